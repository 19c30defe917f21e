"""Spec and machine -> plan -> findings: fall of the stiffness and readings of the sensor, in the run and at other values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise, product

import numpy as np

from wucht.dynamics.exciters.failing_machine import FailingMachine, FailingRun, FallingStiffness
from wucht.dynamics.exciters.speed_readings import (
    FEWEST,
    AveragedSpeed,
    Detection,
    Readings,
    Windows,
    averaged_speed,
    detection_of,
    readings_of,
)
from wucht.dynamics.parameters import ends_of, parameter_of, values_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal, watched_signal
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine
from wucht.machines.machine import Machine
from wucht.piecewise import Pieces
from wucht.schema import Parameter
from wucht.studies.failure_detection.spec import FailureDetection
from wucht.studies.shared_keys import woehler_line
from wucht.studies.spec import Pair

_FINE = 8  # samples in a reading, and between two updates of the damage, at least
_STIFFNESS = "stiffness"
_OWN, _CHECKED = 0.3, 0.35  # shares of the work after the run and the averaged equations, where other values follow
_ROUNDS = 4  # halvings of the steps between the best value and its neighbours
_SETTLE = 3.0  # times the part over which the mean is taken: the settling time
_EVEN = 1e-4  # of the speed: a larger spread of readings indicates a motion that beats, or has not settled
_BEATS = (Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED, Outcome.UNIDENTIFIED)


@dataclass(frozen=True)
class ScheduledFall:
    """Schedule of the carrier's stiffness. begin, end: between which it changes."""

    pieces: Pieces
    begin: float
    end: float

    def share(self, time: np.ndarray) -> np.ndarray:
        """Return the share (N,) of the first value."""
        first, *_ = self.pieces.breakpoints
        return np.asarray(self.pieces(time)) / float(self.pieces(first - 1.0))


@dataclass(frozen=True)
class Varied:
    """Parameter over which the signal is computed, and its first values."""

    parameter: Parameter
    values: tuple[float, ...]


@dataclass(frozen=True)
class Plan:
    """Plan of a failure.

    scheduled_fall: fall of the stiffness by a schedule, None where it falls with the damage of the line. along, second: None
    where no parameter is varied. step, count: samples of a run. update_samples: between two updates of the damage.
    """

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
        """True if the stiffness falls with the damage from the beginning."""
        return self.spec.failure is not None and self.spec.failure.law == "linear"

    def failing(self, case: RunUpCase) -> FailingMachine:
        """Return the machine of a case, ready to run."""
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
        """Return the run with other values. Raises ``InputError`` for values that are not allowed."""
        return case_of(self.spec, self.machine.with_values(values))


def prepare(spec: FailureDetection, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the study does not fit the machine."""
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
    """Return the case of one run of a machine. Raises ``InputError``."""
    return RunUpCase.of(machine, spec.start, RunSettings(spec.until, tolerance=spec.tolerance, engine=spec.engine))


def _scheduled(spec: FailureDetection, machine: Machine) -> ScheduledFall | None:
    """Return the schedule of the carrier's stiffness. Raises ``InputError`` without any cause of its fall, or with two."""
    found = [s for s in machine.schedules if s.parameter.startswith("carrier.") and _STIFFNESS in s.parameter]
    if spec.failure is not None:
        if found:
            raise InputError("study.failure", None, f"not allowed: {found[0].parameter} follows a schedule; give one of them")
        return None
    if not found:
        why = "this table is missing; needed is this table or a schedule of the carrier's stiffness: [[machine.schedules]]"
        raise InputError("study.failure", None, why)
    changes = [t for s in found for t in _changes(s.pieces)]
    if not changes:
        raise InputError("machine.schedules", found[0].parameter, "must change the stiffness: all its values are equal")
    fall = ScheduledFall(found[0].pieces, min(changes), max(changes))
    if fall.begin <= 0 or fall.end >= spec.until:
        raise InputError(
            "study.until", spec.until, f"must be later than the fall of the stiffness, from {fall.begin:g} to {fall.end:g}"
        )
    return fall


def _changes(pieces: Pieces) -> list[float]:
    """Return the breakpoints of a schedule at or beside which the value changes."""
    jumps = list(pieces.jumps())
    for a, b in pairwise(pieces.breakpoints):
        if pieces(a) != pieces((a + b) / 2):
            jumps += [a, b]
    return jumps


def _check_failure(spec: FailureDetection, machine: Machine) -> None:
    """Check that the falling parameter is a stiffness that the machine has and may lose."""
    assert spec.failure is not None
    path = spec.failure.parameter
    parameter = parameter_of(machine, path, "failure.parameter")
    if _STIFFNESS not in path:
        allowed = ", ".join(p for p in machine.parameters if _STIFFNESS in p)
        raise InputError("study.failure.parameter", path, f"must be a stiffness: {allowed}")
    values_of(machine, parameter, (parameter.value * spec.failure.remaining,), "failure.remaining")


def _check_windows(spec: FailureDetection, scheduled: ScheduledFall) -> None:
    """Check that the speed is measured before and after the fall of the stiffness."""
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
        raise InputError(f"study.{key}", path, "not allowed: this parameter falls with the failure")
    low, high = ends_of(machine, parameter, given, between)
    return Varied(parameter, tuple(np.linspace(low, high, points).tolist()))


@dataclass(frozen=True, eq=False)
class Seen:
    """Run with its windows and the readings of the sensor."""

    run: FailingRun
    windows: Windows
    readings: Readings


@dataclass(frozen=True)
class Place:
    """Result at other values. before, after: speeds, signal: None where the specimen did not fail, or too late."""

    values: tuple[float, ...]
    before: float | None
    after: float | None
    signal: float | None
    outcome: str


@dataclass(frozen=True, eq=False)
class Findings:
    """Findings so far.

    nominal_run: at the values of the machine. detection: of its failure. averaged_speeds: before and after, by the averaged
    equations. points: at other values. no_detection: reason why there is no chart, if there should be one.
    """

    own: Seen
    detection: Detection | None = None
    averaged: tuple[AveragedSpeed, AveragedSpeed] | None = None
    places: tuple[Place, ...] = field(default_factory=tuple)
    undetected: str = ""


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings, more and more complete."""
    shares = (_OWN, _CHECKED) if plan.along is not None else (0.9, 1.0)
    for failing in plan.failing(plan.case).run(work.part("own", 0.0, shares[0])):
        own = _seen(plan, failing)
        yield Findings(own)
    detection, undetected = _detection(plan, own)
    checked = work.part("averaged", *shares)
    averaged = None
    if own.readings.before is not None and own.readings.after is not None:
        before, after = (checked.unit(name, partial(_averaged, plan, own, name == "after")) for name in ("before", "after"))
        averaged = before, after
    checked.report(1.0, "averaged equations")
    found = Findings(own, detection, averaged, undetected=undetected)
    yield found
    for places in _places(plan, work.part("variant", shares[1], 1.0)):
        yield replace(found, places=places)


def _seen(plan: Plan, failing: FailingRun) -> Seen:
    windows = _windows(plan, failing)
    return Seen(failing, windows, readings_of(failing.course.time, failing.course.angle, plan.spec.sensor.interval, windows))


def _windows(plan: Plan, failing: FailingRun) -> Windows:
    """Return the windows in which the speed is measured, in a run so far."""
    spec, end = plan.spec, float(failing.course.time[-1])
    if plan.scheduled is not None:
        begin, over = plan.scheduled.begin, plan.scheduled.end
        failed = watched = begin if end > begin else None
    else:
        broken = failing.standing.broken
        gradual, learnt = plan.gradual, (spec.after or 0.0) + (spec.learning or 0.0)
        # A gradual fall may drive the exciter out of its resonance, which ends the damage: it is detected in any case.
        over = broken if broken is not None else learnt if gradual else end
        begin, failed, watched = (learnt, broken, learnt) if gradual else (over, broken, broken)
    after = begin / 2 if spec.after is None else spec.after
    until = begin if spec.learning is None else after + spec.learning
    until = min(until, begin, end)
    normal = (after, until) if until > after else None
    changed = ((over + end) / 2, end) if watched is not None and end > over else None
    return Windows(normal, changed, watched, failed)


def _detection(plan: Plan, own: Seen) -> tuple[Detection | None, str]:
    """Return the detection of the failure; None, and the reason, where there is no chart."""
    sensor = plan.spec.sensor
    every = sensor.false_alarm_every / sensor.interval
    try:
        return detection_of(own.readings, own.windows, sensor.noise, every, sensor.change, not plan.gradual), ""
    except RunError as error:
        return None, str(error)


def _averaged(plan: Plan, own: Seen, failed: bool) -> AveragedSpeed:
    """Return the speed by the averaged equations, before the failure or after it."""
    machine, model = plan.case.machine, plan.case.models[0]
    standing = own.run.standing
    verdict, mean = (
        (own.run.verdict, own.readings.after) if failed else (own.run.before or own.run.verdict, own.readings.before)
    )
    assert mean is not None
    if failed and plan.spec.failure is not None:
        falling = plan.failing(plan.case).falling
        assert falling is not None
        machine = machine.with_unchecked({falling.parameter: falling.value * float(own.run.course.stiffness[-1])})
    window = own.windows.changed if failed else own.windows.normal
    assert window is not None
    steady = machine.at(window[1] if failed else window[0]).changed(schedules=())
    # The averaged equations continue from the full motion, and settle before the mean is taken.
    leg = standing.last if failed else standing.begun or standing.last
    start, part = leg.stored.end_state[: len(model.initial)], window[1] - window[0]
    spread = float(np.ptp(own.readings.speed[own.readings.changed if failed else own.readings.normal]))
    beats = verdict.outcome in _BEATS or spread > _EVEN * abs(mean)
    return averaged_speed(steady, mean, beats, start, (_SETTLE * part, part), plan.spec.tolerance, plan.spec.engine)


def _places(plan: Plan, work: Work) -> Iterator[tuple[Place, ...]]:
    """Yield the signal at all values; for one parameter also between the best value and its neighbours."""
    if plan.along is None:
        return
    axes = [v.values for v in (plan.along, plan.second) if v is not None]
    wanted, found = list(product(*axes)), dict[tuple[float, ...], Place]()
    total = len(wanted) + (2 * _ROUNDS if plan.second is None else 0)
    for _ in range(1 + (_ROUNDS if plan.second is None else 0)):
        for values in wanted:
            part = work.part("", len(found) / total, (len(found) + 1) / total)
            found[values] = part.unit(f"at {values}", partial(_place, plan, values, part.unkept))
            part.report(1.0, f"{len(found)} of {total} other values")
            yield tuple(found[v] for v in sorted(found))
        wanted = _between(sorted(found), found)


def _between(ordered: list[tuple[float, ...]], found: dict[tuple[float, ...], Place]) -> list[tuple[float, ...]]:
    """Return the values halfway between the one with the largest signal and its neighbours."""
    best = max(range(len(ordered)), key=lambda i: found[ordered[i]].signal or 0.0)
    neighbours = [ordered[i] for i in (best - 1, best + 1) if 0 <= i < len(ordered)]
    return [((ordered[best][0] + one[0]) / 2,) for one in neighbours] if found[ordered[best]].signal else []


def _place(plan: Plan, values: tuple[float, ...], work: Work) -> Place:
    paths = [v.parameter.path for v in (plan.along, plan.second) if v is not None]
    case = plan.case_at(dict(zip(paths, values, strict=True)))
    *_, failing = plan.failing(case).run(work)
    seen = _seen(plan, failing)
    signal = None if failing.failure else seen.readings.signal(plan.spec.sensor.noise)
    return Place(values, seen.readings.before, seen.readings.after, signal, str(failing.verdict.outcome))
