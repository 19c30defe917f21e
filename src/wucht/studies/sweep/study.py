"""The study ``sweep``: move a parameter slowly up and down, and find where the machine jumps."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.documents import choice, refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.fields import Parameter
from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE, compile_system
from wucht.quantities import Unit
from wucht.studies.keeper import Keeper
from wucht.studies.keys import allowed_value, engine_of, parameter, quantity, span, start_of, tolerance_of, within
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.release import placed, release_event
from wucht.studies.start import start_state
from wucht.studies.sweep.flow import HaltError, Mover, Place, Reading, moving_system, with_value
from wucht.studies.sweep.jumps import JUMP_TOLERANCE, Jump, Scale, jumps, settle
from wucht.studies.sweep.plan import Plan, rate_unit

if TYPE_CHECKING:
    import xarray as xr

_TOO_FAST = 0.01  # by how much the speed may change after a ramp, relative to the largest of the sweep
DIRECTIONS = ("both", "up", "down")


@dataclass(frozen=True)
class Sweep:
    """Move the parameter ``along`` through ``range``, so slowly that the machine follows.

    rate: in the parameter's unit a unit of time; None: the range takes a thousand times as long as the machine takes to answer.
    direction: ``"both"`` (up, then down again), ``"up"`` or ``"down"``. start: see ``start_state``; the machine starts there
    with the parameter at its first value, and settles. jump_tolerance: relative, of the values at which it jumps. tolerance: of
    the integration. engine: see ``RunUp``.
    """

    along: str
    range: tuple[float, float]
    rate: float | None = None
    direction: str = "both"
    start: Mapping[str, Any] = field(default_factory=dict)
    jump_tolerance: float = JUMP_TOLERANCE
    tolerance: float = DEFAULT_TOLERANCE
    engine: str | None = None

    kind: ClassVar[str] = "sweep"
    keys: ClassVar[tuple[str, ...]] = (
        "kind", "along", "range", "rate", "direction", "start", "jump_tolerance", "tolerance", "engine",
    )  # fmt: skip

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> Sweep:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        along = parameter(table, "along", machine)
        unit = Unit(along.unit, along.what)
        limits = span(table, "range", unit)
        if limits is None:
            raise InputError("study.range", None, f"this key is missing; needed is a pair [low, high] of a {along.what}")
        return cls(
            along=along.path,
            range=limits,
            rate=_rate(table, machine, along),
            direction=choice({"direction": "both"} | dict(table), "direction", "study", DIRECTIONS),
            start=start_of(table),
            jump_tolerance=within(table, "jump_tolerance", JUMP_TOLERANCE, 1e-8, 0.1),
            tolerance=tolerance_of(table),
            engine=engine_of(table),
        )

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the start, the range or the rate does not fit the machine."""
        if machine.schedules:
            raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
        unswept = {"carrier.motion.frequency": "the phase of the motion would run away"}
        for b in machine.bodies:
            for key in ("locked", "release.time", "release.speed"):
                unswept[f"{b.name}.{key}"] = "it says when a body is released"
        if self.along in unswept:
            raise InputError("study.along", self.along, f"not allowed: {unswept[self.along]}")
        for i, value in enumerate(self.range):
            allowed_value(machine, self.along, value, f"study.range[{i}]")
        prepared, _ = _prepared(machine, self)
        if self.rate is not None:
            Plan.of(prepared, self)


def _rate(table: Mapping[str, Any], machine: Machine, along: Parameter) -> float | None:
    """The rate of the parameter, None if it is not given. Raises ``InputError``."""
    time, what = machine.units.time, f"rate of the {along.what}"
    rate = quantity(table, "rate", Unit(f"{along.unit or '1'}/{time}" if time else along.unit, what))
    if rate is not None and rate <= 0:
        unit = f", in {rate_unit(machine, along.path)}" if time else ""
        raise InputError("study.rate", table["rate"], f"allowed is a {what} greater than 0{unit}")
    return rate


def _prepared(machine: Machine, question: Sweep) -> tuple[Machine, np.ndarray]:
    """The machine with the bodies of its tracks in order and the parameter at its first value, and the state (n,)."""
    first = question.range[1] if question.direction == "down" else question.range[0]
    machine = with_value(machine, question.along, first)
    initial = start_state(machine, question.start)
    return placed(machine, initial), initial


@dataclass
class Record:
    """What a sweep has found so far. readings, places: after each leg of each ramp; jumps in the order in which they happen.

    complete: the ramps whose jumps have all been found. energies: the mover's scale and the energy at its start, after the
    last leg or ramp: a search for jumps that is broken off leaves no trace.
    """

    readings: dict[str, list[Reading]] = field(default_factory=dict)
    places: dict[str, list[Place]] = field(default_factory=dict)
    jumps: list[Jump] = field(default_factory=list)
    complete: list[str] = field(default_factory=list)
    energies: tuple[float, float | None] = (0.0, None)
    warnings: list[str] = field(default_factory=list)
    failure: str | None = None
    interrupted: bool = False

    def say(self, warning: str) -> None:
        """Warn, once."""
        if warning not in self.warnings:
            self.warnings.append(warning)

    def scale(self, driven: float) -> Scale:
        """The largest speed and amplitude of the sweep so far. driven: the largest speed that the drives reach."""
        return Scale(driven).with_(r for readings in self.readings.values() for r in readings)


@np.errstate(all="ignore")  # a run that fails says so in a sentence, not by warnings about overflow
def sweep(
    machine: Machine,
    question: Sweep,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """Settle, ramp, settle again, find the jumps; then back. Returns the Dataset described in ``sweep.result``.

    progress: called with the ramps done and to do. checkpoint: called now and then with the result so far. resume: an
    earlier result of the same question, gone on with from its last leg. Raises ``InputError`` for a start or rate that does
    not fit; a failure is recorded in the Dataset.
    """
    from wucht.studies.sweep.kept import restore
    from wucht.studies.sweep.result import result

    begun = clock.perf_counter()
    machine, initial = _prepared(machine, question)
    plan = Plan.of(machine, question)
    record = Record(warnings=list(plan.warnings))
    events = tuple(release_event(machine, b) for b in machine.bodies if b.release is not None)
    flow = compile_system(moving_system(machine, question.along), question.tolerance, events, question.engine)
    ways = ["up", "down"] if question.direction == "both" else [question.direction]

    def report(_time: float) -> None:
        if progress is not None:
            done = sum(len(r) for r in record.readings.values()) / plan.samples
            progress(min(done, len(ways)), float(len(ways)))

    def described() -> xr.Dataset:
        return result(machine, question, plan, mover, record, begun)

    mover = Mover(machine, question.along, flow, plan.fastest, report)
    if resume is not None:
        restore(machine, question, resume, mover, record)
    keeper = Keeper(checkpoint)

    def keep() -> None:
        keeper(described)

    try:
        place = None if any(record.places.values()) else _begun(mover, plan, question.range[ways[0] == "down"], initial, record)
        for way, following in zip(ways, [*ways[1:], None], strict=True):
            if following is not None and record.places.get(following):
                continue
            place = _ramp(mover, plan, place, question, way, record, keep)
            if way not in record.complete:
                record.jumps += jumps(mover, plan, record.places[way], record.readings[way], question.jump_tolerance)
                record.complete.append(way)
                record.energies = mover.scale, mover.stored_at_start
    except HaltError as halt:
        record.failure, record.interrupted = halt.failure, halt.failure is None
    except KeyboardInterrupt:
        record.interrupted = True
    return described()


def _begun(mover: Mover, plan: Plan, value: float, initial: np.ndarray, record: Record) -> Place:
    return _settled(mover, plan, mover.begin(value, initial), record, "before the sweep")[0]


def _ramp(
    mover: Mover, plan: Plan, place: Place | None, question: Sweep, way: str, record: Record, keep: Callable[[], None]
) -> Place:
    """One ramp in equal legs, or what is left of it, and settling at its end. place: where it begins."""
    begin, end = question.range if way == "up" else question.range[::-1]
    readings, places = record.readings.setdefault(way, []), record.places.setdefault(way, [])
    place = places[-1] if places else place
    assert place is not None
    for value in np.linspace(begin, end, plan.samples + 1)[1 + len(places) :]:
        place, reading = mover.leg(place, plan.step, float(value))
        readings.append(reading)
        places.append(place)
        record.energies = mover.scale, mover.stored_at_start
        keep()
    place, settled = _settled(mover, plan, place, record, f"after the way {way}")
    change, last = abs(settled.speed - readings[-1].speed), readings[-1]
    if last.beating < _TOO_FAST and change > _TOO_FAST * max(abs(settled.speed), record.scale(0.0).speed):
        speed, unit = mover.machine.units.speed, rate_unit(mover.machine, mover.path)
        record.say(
            f"the sweep is too fast: after the way {way} the speed still changed from {last.speed:.5g} to "
            f"{f'{settled.speed:.5g} {speed}'.strip()}; give a rate below {plan.rate:.3g} {unit}"
        )
    return place


def _settled(mover: Mover, plan: Plan, place: Place, record: Record, when: str) -> tuple[Place, Reading]:
    place, reading, steady = settle(mover, plan, place, scale=record.scale(plan.driven))
    if not steady:
        speed = f"{reading.speed:.5g} {mover.machine.units.speed}".strip()
        record.say(f"the machine did not settle {when}: its speed was still changing at {speed}")
    return place, reading


__all__ = ["Record", "Sweep", "sweep"]
