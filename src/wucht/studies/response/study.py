"""The study ``response``: the steady forced vibration over the speed, the unbalance fixed. 002 (2.74)-(2.79)."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine
from wucht.machines.vibration import free_speed
from wucht.quantities import Unit
from wucht.studies.keys import span, start_of
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.steady import angles_of, forced, read_points

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_POINTS = 600


@dataclass(frozen=True)
class Response:
    """Amplitude, phase, self-centring and torque demand over the speed, at a steady speed with the unbalance fixed.

    range: lowest and highest speed, not negative; by default from 0.02 to 3 times the highest natural frequency, or to 1.5
    times the speed that the drive reaches without vibration where that is more. points: evenly spaced over it, to which those
    that resolve the resonances are added. start: the phases at which bodies stay, as in ``start_state``; its speeds and the
    carrier's start do not matter. Every body turns in the sense of the drive of its rotor.
    """

    range: tuple[float, float] | None = None
    points: int = DEFAULT_POINTS
    start: Mapping[str, Any] = field(default_factory=dict)

    kind: ClassVar[str] = "response"
    keys: ClassVar[tuple[str, ...]] = ("kind", "range", "points", "start")

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> Response:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        found = span(table, "range", Unit(machine.units.speed, "speed"))
        if found is not None and found[0] < 0:
            allowed = "allowed is a pair [low, high] of speeds of at least 0; bodies turn in the sense of their drives"
            raise InputError("study.range", table["range"], allowed)
        return cls(found, read_points(table, DEFAULT_POINTS), start_of(table))

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the start does not fit the machine, or nothing is free to vibrate."""
        if not machine.free_carrier:
            raise InputError(
                "machine.carrier", None, "nothing here is free to vibrate: a response needs a carrier on springs, and this one "
                f"is {'fixed' if machine.shaken is None else 'moved as prescribed'}",
            )  # fmt: skip
        forced(machine, self.start)


def speed_range(machine: Machine) -> tuple[float, float]:
    """The default of ``range``."""
    natural = [f for f in natural_frequencies(machine).values() if f > 0]
    free = abs(free_speed(machine, machine.rotor) or 0.0)
    top = max([*natural, 0.0]) or free or 1.0
    return min(0.02 * top, 0.3 * min([*natural, top])), max(3 * top, 1.5 * free)


def response(
    machine: Machine,
    question: Response,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """The steady vibration over the speed, in closed form. Returns the Dataset described in ``response.result``.

    It takes milliseconds: nothing is reported, kept in between or resumed. Raises ``InputError`` for a question that does not
    fit the machine.
    """
    from wucht.studies.response.result import result

    begun, machine = clock.perf_counter(), machine.at(machine.corners[-1])  # steady: with its schedules done
    question.check(machine)
    return result(machine, question, angles_of(machine, question.start), question.range or speed_range(machine), begun)
