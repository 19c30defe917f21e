"""The study ``synchronous-states``: every constant phase configuration of a machine, its name and its stability.

000 sections 4-6 (tables 1-3), 001 section 2.4 (table 1), 002 section 5.1 (types I, II, III).
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.quantities import Unit
from wucht.studies.keys import quantity, span
from wucht.studies.kinds import Checkpoint, Progress

if TYPE_CHECKING:
    import xarray as xr

MOST_BODIES, MOST_CELLS = 11, 400
_MOST_RATIO = 1e6

Axis = tuple[float, float, int]


@dataclass(frozen=True)
class SynchronousStates:
    """All constant phases of the balancing bodies or of self-synchronising rotors, with names and stability.

    speed: of the main rotor, signed; by default what its drive prescribes, or else all speeds that the drive and the
    vibration leave, searched over ``range`` (default: up to the highest speed without vibration, or three times the highest
    natural frequency where a drive runs away without load: then it is not said that these are all). inertia: of the balancing
    bodies in the slow equations; false for the strongly damped reduction, 002 (4.60)-(4.62). full: whether the multipliers of
    the full equations are computed too. axes: a stability map of given speeds, {speed = [lo, hi, cells], ratio = [lo, hi,
    cells]}, cell-centred; ratio: of the unbalance of all balancing bodies together to that of the rotor, which is changed for
    it.
    """

    speed: float | None = None
    range: tuple[float, float] | None = None
    inertia: bool = True
    full: bool = True
    axes: Mapping[str, Axis] | None = None

    kind: ClassVar[str] = "synchronous-states"
    keys: ClassVar[tuple[str, ...]] = ("kind", "speed", "range", "inertia", "full", "axes")

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> SynchronousStates:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        unit = Unit(machine.units.speed, "speed")
        flags = {key: table.get(key, True) for key in ("inertia", "full")}
        for key, value in flags.items():
            if not isinstance(value, bool):
                raise InputError(f"study.{key}", value, "allowed is true or false")
        return cls(quantity(table, "speed", unit), span(table, "range", unit), axes=_axes(table, unit), **flags)

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the machine has no phases, or is outside the class of the slow equations."""
        from wucht.machines.slow import damped, slow_machine
        from wucht.machines.synchronous.torques import SteadyTorques
        from wucht.studies.synchronous_states.found import prepared
        from wucht.studies.synchronous_states.map import check_map
        from wucht.studies.synchronous_states.speeds import check_speed, searched

        if len(machine.bodies) < 2:
            _refuse_single(machine)
        if len(machine.bodies) > MOST_BODIES:
            raise InputError("machine.bodies", len(machine.bodies), f"allowed are up to {MOST_BODIES}, the main rotor included")
        if self.speed == 0:
            raise InputError("study.speed", 0.0, "allowed is a speed other than 0")
        held = self.speed is not None or machine.rotor.coordinate.prescribed is not None
        if held and self.range is not None:
            raise InputError("study.range", list(self.range), "not allowed where the speed of the main rotor is given")
        steady, unheld = prepared(machine, self.speed), prepared(machine, None)
        if not self.inertia and not damped(steady):
            raise InputError("study.inertia", False, "allowed is true: a balancing body is not damped against its rotor")
        torques = SteadyTorques.from_slow(slow_machine(steady, self.inertia))
        if torques.given is not None and torques.given <= 0:
            raise InputError(
                "machine.drive", None, "the main rotor stands still: there is no vibration that could place bodies"
            )
        if self.speed is not None:
            check_speed(unheld, self.speed)
        if not held:
            searched(steady, self.range)
        elif torques.poles(*[torques.given or 0.0] * 2):
            raise InputError(
                "machine.drive" if self.speed is None else "study.speed", torques.given, "allowed is another speed: this is "
                "the natural frequency of a vibration without damping, which is infinite there",
            )  # fmt: skip
        if self.axes is not None:
            check_map(torques, unheld, self.axes)


def _refuse_single(machine: Machine) -> None:
    """Why a machine with one body that turns has no constant phases. Raises ``InputError``."""
    rotor = machine.rotor
    if machine.shaken is not None:
        raise InputError(
            "machine.carrier.motion", None, "a single body has no phases; whether the carrier's motion takes it along is "
            "study.kind = 'entrainment'",
        )  # fmt: skip
    if machine.sliders:
        raise InputError(
            "machine.bodies", None, f"only {rotor.name!r} turns freely: {machine.sliders[0].name!r} slides in a guide that "
            "turns with it, and has no phase of its own; study.kind = 'run-up' shows its motion",
        )  # fmt: skip
    advice = "at which speeds it can turn is study.kind = 'torque-balance'"
    if not machine.drives or rotor.coordinate.prescribed is not None:
        advice = "how it makes the carrier vibrate is study.kind = 'response'"
    raise InputError("machine.bodies", None, f"a single body has no phases; {advice}")


def _axes(table: Mapping[str, Any], unit: Unit) -> dict[str, Axis] | None:
    given = table.get("axes")
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise InputError("study.axes", given, "allowed is a table: axes = { speed = [lo, hi, cells], ratio = [lo, hi, cells] }")
    refuse_unknown(given, ("speed", "ratio"), "study.axes")
    found = {}
    for name, what in (("speed", unit), ("ratio", Unit("", "ratio"))):
        where, triple = f"study.axes.{name}", given.get(name)
        if not isinstance(triple, list) or len(triple) != 3:
            raise InputError(where, triple, "allowed is [lo, hi, cells]")
        low, high = span({f"axes.{name}": triple[:2]}, f"axes.{name}", what) or (0.0, 0.0)
        cells = triple[2]
        if isinstance(cells, bool) or not isinstance(cells, int) or not 2 <= cells <= MOST_CELLS:
            raise InputError(where, triple, f"allowed is a whole number of cells from 2 to {MOST_CELLS}")
        if low < 0:
            raise InputError(where, triple, f"allowed is a {what.what} from 0 on")
        if name == "ratio" and high > _MOST_RATIO:
            raise InputError(where, triple, f"allowed is a ratio up to {_MOST_RATIO:g}")
        found[name] = (low, high, cells)
    return found


@np.errstate(all="ignore")  # a characteristic may have a pole outside what it is made for
def synchronous_states(
    machine: Machine,
    question: SynchronousStates,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """All constant phases. Returns the Dataset of ``synchronous_states.result``.

    progress: called with the number of states judged, and of all. It takes seconds at most: nothing is kept in between or
    resumed. Raises ``InputError`` for a question that does not fit the machine.
    """
    from wucht.studies.synchronous_states.found import Configurations, prepared
    from wucht.studies.synchronous_states.result import result
    from wucht.studies.synchronous_states.speeds import SpeedRange, searched

    begun = clock.perf_counter()
    question.check(machine)
    steady = prepared(machine, question.speed)
    held = steady.rotor.coordinate.prescribed is not None
    speeds = SpeedRange(0.0, 0.0) if held else searched(steady, question.range)
    report = (lambda done, whole: None) if progress is None else (lambda done, whole: progress(float(done), float(whole)))
    found = Configurations(steady, speeds, question.inertia, question.full, report)
    return result(machine, question, found, begun)
