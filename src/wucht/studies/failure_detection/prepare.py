"""Question and machine -> plan: how the stiffness falls, what the sensor reads, which other values are looked at."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wucht.dynamics.exciters.failing_machine import FailingMachine, FallingStiffness
from wucht.dynamics.exciters.speed_readings import FEWEST
from wucht.dynamics.parameters import ends_of, parameter_of, values_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal, watched_signal
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.errors import InputError
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine
from wucht.machines.machine import Machine
from wucht.piecewise import Pieces
from wucht.schema import Parameter
from wucht.studies.failure_detection.spec import FailureDetection
from wucht.studies.load_keys import woehler_line
from wucht.studies.spec import Pair

_FINE = 8  # samples in a reading, and between two looks at the damage, at least
_STIFFNESS = "stiffness"


@dataclass(frozen=True)
class ScheduledFall:
    """A schedule of the carrier's stiffness. begin, end: between which it changes."""

    pieces: Pieces
    begin: float
    end: float

    def share(self, time: np.ndarray) -> np.ndarray:
        """Of the first value (N,)."""
        first, *_ = self.pieces.breakpoints
        return np.asarray(self.pieces(time)) / float(self.pieces(first - 1.0))


@dataclass(frozen=True)
class Varied:
    """A parameter over which the signal is looked for, and the values that are looked at first."""

    parameter: Parameter
    values: tuple[float, ...]


@dataclass(frozen=True)
class Plan:
    """scheduled: how the stiffness falls by a schedule, None where it falls with the damage of the line. along, second: None
    where nothing is varied. step, count: samples of a run. per_look: samples between two looks at the damage. interval: of the
    sensor."""

    spec: FailureDetection
    machine: Machine
    case: RunUpCase
    signal: MachineSignal
    line: WoehlerLine | None
    scheduled: ScheduledFall | None
    step: float
    count: int
    per_look: int
    along: Varied | None
    second: Varied | None

    @property
    def gradual(self) -> bool:
        """Whether the stiffness falls with the damage from the begin on."""
        return self.spec.failure is not None and self.spec.failure.law == "linear"

    def failing(self, case: RunUpCase) -> FailingMachine:
        """The machine of a case, ready to run."""
        spec, machine, [model] = self.spec, case.machine, case.models
        falling, scheduled = None, self.scheduled
        begin = None if scheduled is None else scheduled.begin
        if spec.failure is not None:
            asked = spec.failure
            whole = machine.values[asked.parameter]
            falling = FallingStiffness(asked.parameter, whole, asked.remaining, not self.gradual)
            begin = None if not self.gradual else (spec.after or 0.0) + (spec.learning or 0.0)
        return FailingMachine(
            machine, watched_signal(case, self.signal), model.initial, self.step, self.count, self.per_look,
            None if self.line is None else AccumulatedDamage(self.line), falling,
            None if scheduled is None else scheduled.share, begin,
        )  # fmt: skip

    def case_at(self, values: dict[str, float]) -> RunUpCase:
        """The run with other values. Raises ``InputError`` for some that are not allowed."""
        return case_of(self.spec, self.machine.with_values(values))


def prepare(spec: FailureDetection, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    scheduled = _scheduled(spec, machine)
    if scheduled is not None:
        _check_windows(spec, scheduled)
    failure, line = spec.failure, None
    if failure is None:
        signal = machine_signal(machine, "displacement", None)
    else:
        _check_failure(spec, machine)
        signal = machine_signal(machine, failure.signal, failure.direction, "study.failure")
        line = woehler_line(failure.woehler, signal.unit, "study.failure.woehler")
    if machine.rotor.coordinate.prescribed is not None:
        raise InputError("machine.drive", None, "the drive prescribes the speed: it does not change when the specimen fails")
    interval = spec.sensor.interval
    looks = interval if failure is None or failure.interval is None else failure.interval
    step = min(interval, looks) / _FINE
    count = int(spec.until / step * (1 + 1e-12))
    if spec.until < 2 * FEWEST * interval:
        allowed = f"must be at most study.until/{2 * FEWEST}, {spec.until / (2 * FEWEST):.4g}"
        raise InputError("study.sensor.interval", interval, allowed)
    along = _varied(spec, machine, spec.along, spec.range, spec.points, "along", "range")
    second = _varied(spec, machine, spec.second, spec.second_range, spec.second_points, "second", "second_range")
    case = case_of(spec, machine)
    return Plan(spec, machine, case, signal, line, scheduled, step, count, round(looks / step), along, second)


def case_of(spec: FailureDetection, machine: Machine) -> RunUpCase:
    """One run of a machine. Raises ``InputError``."""
    return RunUpCase.of(machine, spec.start, RunSettings(spec.until, tolerance=spec.tolerance, engine=spec.engine))


def _scheduled(spec: FailureDetection, machine: Machine) -> ScheduledFall | None:
    """The schedule of the carrier's stiffness. Raises ``InputError`` where nothing, or too much, makes it fall."""
    found = [s for s in machine.schedules if s.parameter.startswith("carrier.") and _STIFFNESS in s.parameter]
    if spec.failure is not None:
        if found:
            raise InputError("study.failure", None, f"not allowed: {found[0].parameter} follows a schedule; give one of both")
        return None
    if not found:
        why = "this table is missing; needed is it, or a schedule of the carrier's stiffness: [[machine.schedules]]"
        raise InputError("study.failure", None, why)
    changes = [t for s in found for t in _changes(s.pieces)]
    if not changes:
        raise InputError("machine.schedules", found[0].parameter, "must change the stiffness: all its values are the same")
    fall = ScheduledFall(found[0].pieces, min(changes), max(changes))
    if fall.begin <= 0 or fall.end >= spec.until:
        raise InputError(
            "study.until", spec.until, f"must be later than the stiffness falls, from {fall.begin:g} to {fall.end:g}"
        )
    return fall


def _changes(pieces: Pieces) -> list[float]:
    """The breakpoints of a schedule at which, or on both sides of which, the value changes."""
    jumps = list(pieces.jumps())
    for a, b in pairwise(pieces.breakpoints):
        if pieces(a) != pieces((a + b) / 2):
            jumps += [a, b]
    return jumps


def _check_failure(spec: FailureDetection, machine: Machine) -> None:
    """What falls is a stiffness that the machine has and may lose."""
    assert spec.failure is not None
    path = spec.failure.parameter
    parameter = parameter_of(machine, path, "failure.parameter")
    if _STIFFNESS not in path:
        allowed = ", ".join(p for p in machine.parameters if _STIFFNESS in p)
        raise InputError("study.failure.parameter", path, f"must be a stiffness: {allowed}")
    values_of(machine, parameter, (parameter.value * spec.failure.remaining,), "failure.remaining")


def _check_windows(spec: FailureDetection, scheduled: ScheduledFall) -> None:
    """The speed is taken before the stiffness falls, and after it."""
    begin = scheduled.begin
    after = begin / 2 if spec.after is None else spec.after
    end = begin if spec.learning is None else after + spec.learning
    if end > begin:
        raise InputError("study.after", spec.after, f"with study.learning it must end before the stiffness falls, {begin:g}")
    least = FEWEST * spec.sensor.interval
    for span, what in ((end - after, "before"), ((spec.until - scheduled.end) / 2, "in the second half of the time after")):
        if span < least:
            allowed = f"there must be {FEWEST} readings {what} the fall of the stiffness: at most {span / FEWEST:.4g}"
            raise InputError("study.sensor.interval", spec.sensor.interval, allowed)


def _varied(
    spec: FailureDetection, machine: Machine, path: str | None, given: Pair | None, points: int, key: str, between: str
) -> Varied | None:
    if path is None or given is None:
        return None
    parameter = parameter_of(machine, path, key)
    if spec.failure is not None and path == spec.failure.parameter:
        raise InputError(f"study.{key}", path, "not allowed: this is what fails")
    low, high = ends_of(machine, parameter, given, between)
    return Varied(parameter, tuple(np.linspace(low, high, points).tolist()))
