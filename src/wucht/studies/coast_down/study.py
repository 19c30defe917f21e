"""The study ``coast-down``: switch the drives off and see how the machine comes to rest."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.machines.vibration import energy_scale, free_speed, group
from wucht.mechanics.energies import Energies
from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE, CompiledSystem, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.quantities import Unit
from wucht.studies.coast_down.record import Record
from wucht.studies.keeper import Keeper
from wucht.studies.keys import engine_of, positive, start_of, tolerance_of
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.release import placed, release_event
from wucht.studies.start import start_state

if TYPE_CHECKING:
    import xarray as xr

REVERSAL = "reversal"
SAMPLES_PER_TURN, SAMPLES_A_LEG, ROWS = 24, 20_480, 4000
SLOW = 0.01  # of the speed at the start: without `until` the run ends there
_MOST_TURNS = 50_000
_ENOUGH_SWINGS = 20


@dataclass(frozen=True)
class CoastDown:
    """Let the machine run without its drives; loads, bearings and dampers stay.

    until: a time; None: until it has stopped, swings, or turns at a hundredth of its speed. start: see ``start_state``; rotors
    for which it gives no speed start with the speed that their drive reaches, and the bodies about them turn along. tolerance:
    of the integration. engine: see ``RunUp``.
    """

    until: float | None = None
    start: Mapping[str, Any] = field(default_factory=dict)
    tolerance: float = DEFAULT_TOLERANCE
    engine: str | None = None

    kind: ClassVar[str] = "coast-down"
    keys: ClassVar[tuple[str, ...]] = ("kind", "until", "start", "tolerance", "engine")

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> CoastDown:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        until = positive(table, "until", Unit(machine.units.time, "time"))
        return cls(until, start_of(table), tolerance_of(table), engine_of(table))

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the start does not fit the machine, or where nothing would turn."""
        prepared(machine, self)


def without_drives(machine: Machine) -> Machine:
    """The machine with its drives switched off: no torque, no prescribed speed. What dampers and loads take stays."""
    drives = [p for p in machine.parts if isinstance(p, Drive)]
    bodies = tuple(replace(b, coordinate=replace(b.coordinate, prescribed=None)) for b in machine.bodies)
    return replace(
        machine,
        bodies=bodies,
        energies=tuple(_undriven(e) for e in machine.energies),
        parts=tuple(p for p in machine.parts if p not in drives),
        start_angles={},
        schedules=tuple(s for s in machine.schedules if not any(s.parameter.startswith(f"{d.path}.") for d in drives)),
    )


def _undriven(e: Energies) -> Energies:
    return replace(e, applied=tuple(a for a in e.applied if a.booked != "supplied"))


def prepared(machine: Machine, question: CoastDown) -> tuple[Machine, np.ndarray]:
    """The machine without drives, the bodies of its tracks in order, and the state (n,) to start from.

    Raises ``InputError``.
    """
    coasting = without_drives(machine)
    state = start_state(coasting, question.start)
    names = coasting.state_names
    for rotor in machine.rotors:
        here = names.index(rotor.coordinate.velocity.name)
        if rotor.name in machine.start_angles and not _gives(question.start, rotor.name, "angle"):
            state[names.index(rotor.coordinate.position.name)] += machine.start_angles[rotor.name]
        if not _gives(question.start, rotor.name, "speed") and rotor.release is None:
            state[here] = _driven_speed(machine, rotor.name)
        for body in group(machine, rotor)[1:]:
            if body.release is not None or not _gives(question.start, body.name, "speed"):
                state[names.index(body.coordinate.velocity.name)] = state[here]
    if not state[names.index(machine.rotor.coordinate.velocity.name)]:
        raise InputError(
            "study.start", dict(question.start) or None,
            f"nothing turns: the machine has no drive to give {machine.rotor.name} a speed; "
            f'needed is start = {{ {machine.rotor.name} = {{ speed = "100 rad/s" }} }}',
        )  # fmt: skip
    return placed(coasting, state), state


def _gives(start: Mapping[str, Any], body: str, key: str) -> bool:
    given = start.get(body)
    return key in given if isinstance(given, Mapping) else given is not None and key == "angle"


def _driven_speed(machine: Machine, name: str) -> float:
    """The speed that a rotor's drive reaches, 0 if it has none."""
    rotor = next(r for r in machine.rotors if r.name == name)
    driven = any(a.booked == "supplied" for e in machine.energies for a in e.applied) or rotor.coordinate.prescribed is not None
    speed = free_speed(machine.at(0.0), rotor) if driven else None
    return speed or 0.0


@np.errstate(all="ignore")  # a run that fails says so in a sentence, not by warnings about overflow
def coast_down(
    machine: Machine,
    question: CoastDown,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """Let the machine coast down. Returns the Dataset described in ``coast_down.result``.

    progress: called with the time reached and the time to reach. checkpoint: called now and then with the result so far.
    resume: an earlier result of the same question, gone on with. Raises ``InputError`` for a start that does not fit; a
    failure is recorded.
    """
    from wucht.studies.coast_down.kept import restore
    from wucht.studies.coast_down.result import result

    begun = clock.perf_counter()
    machine, initial = prepared(machine, question)
    velocity = machine.rotor.coordinate.velocity
    start_speed = float(initial[machine.system.state_names.index(velocity.name)])
    events = (
        Event(REVERSAL, velocity, -1 if start_speed > 0 else 1),
        *(release_event(machine, b) for b in machine.bodies if b.release is not None),
    )
    flow = compile_system(machine.system, question.tolerance, events, question.engine)
    record = Record(machine, flow, start_speed)
    natural = [f for f in natural_frequencies(machine).values() if f > 0]
    turn = 2 * math.pi / max([abs(start_speed), *natural])
    limit = question.until or _MOST_TURNS * turn
    step = _step(turn, limit)
    record.stride = limit / ROWS if question.until is not None else turn

    def described(t: Trajectory) -> xr.Dataset:
        return result(machine, question, flow, record, t, begun)

    trajectory = None if resume is None else restore(machine, question, resume, record)
    keep = Keeper(checkpoint)
    while trajectory is None or not (trajectory.ended or _done(record, question, trajectory.end_time, limit)):
        leg = _leg(flow, machine, initial, trajectory, step, limit, progress)
        if leg.interrupted and trajectory is not None:
            trajectory = replace(trajectory, interrupted=True)  # at the end of a whole leg, from which it can be gone on with
            break
        trajectory = replace(leg, hits=tuple(h for h in leg.hits if h.name == REVERSAL))
        record.add(trajectory)
        keep(partial(described, trajectory))
    return described(trajectory)


def _step(turn: float, limit: float) -> float:
    """Between samples: a whole number of them until the end."""
    return limit / max(64, math.ceil(limit * SAMPLES_PER_TURN / turn))


def _leg(
    flow: CompiledSystem, machine: Machine, initial: np.ndarray, before: Trajectory | None, step: float, limit: float,
    progress: Progress | None,
) -> Trajectory:  # fmt: skip
    report: Callable[[float], None] | None = None if progress is None else lambda t: progress(t, limit)
    begin = 0.0 if before is None else before.end_time
    count = max(1, min(SAMPLES_A_LEG, round((limit - begin) / step)))
    grid = begin + step * np.arange(count + 1)
    state = initial if before is None else before.end_state
    given = machine.values if before is None else before.parameters.tolist()
    return integrate(flow, state, given, grid, report, None, energy_scale(machine))


def _done(record: Record, question: CoastDown, time: float, limit: float) -> bool:
    if time >= limit * (1 - 1e-9):
        return True
    if question.until is not None:
        return False
    if record.reversal_time is not None:
        return record.swings >= _ENOUGH_SWINGS or abs(record.rows["max_speed"][-1]) < 1e-4 * abs(record.start_speed)
    return bool(record.turn_speed) and abs(record.rows["speed"][-1]) < SLOW * abs(record.start_speed)


__all__ = ["CoastDown", "coast_down"]
