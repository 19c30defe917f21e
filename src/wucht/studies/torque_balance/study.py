"""The study ``torque-balance``: where the drive's torque equals that of load and vibration. 002 (3.51), figure 3.2b."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine, Turning
from wucht.machines.models import Model
from wucht.machines.vibration import free_speed, group
from wucht.quantities import Unit
from wucht.studies.keys import span, start_of
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.steady import angles_of, forced, read_points

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_POINTS = 1200


@dataclass(frozen=True)
class TorqueBalance:
    """The drive's characteristic, the load line and the vibration torque over the speed, and the working points.

    range: of the speed, signed; by default from 0 to 1.2 times the speed that the drive reaches without vibration. on: the
    rotor whose shaft is looked at, by default the main one; other rotors turn with it at the same speed. start: the phases at
    which bodies stay, as in ``start_state``. points: evenly spaced over the range, to which those are added that resolve
    resonances and breakdown.
    """

    range: tuple[float, float] | None = None
    on: str | None = None
    points: int = DEFAULT_POINTS
    start: Mapping[str, Any] = field(default_factory=dict)

    kind: ClassVar[str] = "torque-balance"
    keys: ClassVar[tuple[str, ...]] = ("kind", "range", "on", "points", "start")

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> TorqueBalance:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        found = span(table, "range", Unit(machine.units.speed, "speed"))
        return cls(found, table.get("on"), read_points(table, DEFAULT_POINTS), start_of(table))

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the start does not fit the machine, or the shaft has no drive with a torque."""
        rotor = self.rotor(machine)
        forced(machine, self.start)
        if rotor.coordinate.prescribed is not None:
            raise InputError(
                "machine.drive", None, f"the drive gives {rotor.name!r} its speed, whatever torque that takes: nothing is to "
                "be balanced; study.kind = 'response' shows the torque that it takes",
            )  # fmt: skip
        turning = {b.name for b in group(machine, rotor)}
        if not isinstance(machine.parts[0], Model) and not any(d.on in turning for d in machine.drives):
            raise InputError("machine.drive", None, f"nothing drives {rotor.name!r}: there is no torque to balance")

    def rotor(self, machine: Machine) -> Turning:
        """The rotor whose shaft is looked at. Raises ``InputError``."""
        if self.on is None:
            return machine.rotor
        found = next((r for r in machine.rotors if r.name == self.on), None)
        if found is None:
            raise InputError("study.on", self.on, f"allowed is a rotor: {', '.join(r.name for r in machine.rotors)}")
        return found


def speed_range(machine: Machine, rotor: Turning) -> tuple[float, float]:
    """The default of ``range``; three times the highest natural frequency where the drive reaches no speed of its own."""
    free = free_speed(machine, rotor)
    end = 1.2 * free if free else 3 * max([f for f in natural_frequencies(machine).values() if f > 0], default=100.0)
    return min(0.0, end), max(0.0, end)


@np.errstate(all="ignore")  # a characteristic may have a pole outside what it is made for: the series motor turned backwards
def torque_balance(
    machine: Machine,
    question: TorqueBalance,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """Characteristic, load line, vibration torque and working points. Returns the Dataset of ``torque_balance.result``.

    It takes milliseconds: nothing is reported, kept in between or resumed. Raises ``InputError`` for a question that does not
    fit the machine.
    """
    from wucht.studies.torque_balance.result import result

    begun, machine = clock.perf_counter(), machine.at(machine.corners[-1])  # steady: with its schedules done
    question.check(machine)
    rotor = question.rotor(machine)
    angles = angles_of(machine, question.start)
    return result(machine, question, rotor, angles, question.range or speed_range(machine, rotor), begun)
