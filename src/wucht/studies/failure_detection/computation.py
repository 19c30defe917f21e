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
from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal, signal_integration
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine
from wucht.machines.machine import Machine
from wucht.piecewise import Pieces
from wucht.schema import Parameter
from wucht.studies.failure_detection.parameter_points import ParameterPoint, best_index
from wucht.studies.failure_detection.spec import FailureDetection
from wucht.studies.shared_keys import woehler_line
from wucht.studies.spec import Pair

_FINE = 8  # samples in a reading, and between two updates of the damage, at least
_STIFFNESS = "stiffness"
_RUN_SHARE, _AVERAGED_SHARE = (
    0.3,
    0.35,
)  # shares of the work after the run and the averaged equations, where other values follow
_ROUNDS = 4  # halvings of the steps between the best value and its neighbours
_SETTLE = 3.0  # times the part over which the mean is taken: the settling time
_STEADY_TOLERANCE = 1e-4  # of the speed: a larger spread of readings indicates a motion that beats, or has not settled
_BEATING_OUTCOMES = (Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED, Outcome.UNIDENTIFIED)


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
class ParameterAxis:
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
    scheduled_fall: ScheduledFall | None
    step: float
    count: int
    update_samples: int
    along: ParameterAxis | None
    second: ParameterAxis | None

    @property
    def is_gradual(self) -> bool:
        """True if the stiffness falls with the damage from the beginning."""
        return self.spec.failure is not None and self.spec.failure.law == "linear"

    def failing_machine(self, case: RunUpCase) -> FailingMachine:
        """Return the machine of a case, ready to run."""
        spec, machine, [model] = self.spec, case.machine, case.models
        falling, scheduled_fall = None, self.scheduled_fall
        begin = None if scheduled_fall is None else scheduled_fall.begin
        if spec.failure is not None:
            failure = spec.failure
            whole = machine.values[failure.parameter]
            falling = FallingStiffness(failure.parameter, whole, failure.remaining, not self.is_gradual)
            begin = None if not self.is_gradual else (spec.after or 0.0) + (spec.learning or 0.0)
        return FailingMachine(
            machine, signal_integration(case, self.signal), model.initial, self.step, self.count, self.update_samples,
            None if self.line is None else AccumulatedDamage(self.line), falling,
            None if scheduled_fall is None else scheduled_fall.share, begin,
        )  # fmt: skip

    def case_at(self, values: dict[str, float]) -> RunUpCase:
        """Return the run with other values. Raises ``InputError`` for values that are not allowed."""
        return case_of(self.spec, self.machine.with_values(values))


def prepare(spec: FailureDetection, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the study does not fit the machine."""
    scheduled_fall = _scheduled_fall(spec, machine)
    if scheduled_fall is not None:
        _check_windows(spec, scheduled_fall)
    failure, line = spec.failure, None
    if failure is None:
        signal = machine_signal(machine, "displacement", None)
    else:
        _check_failure(spec, machine)
        signal = machine_signal(machine, failure.signal, failure.direction, "study.failure")
        line = woehler_line(failure.woehler, signal.unit, "study.failure.woehler")
    if machine.rotor.coordinate.prescribed_velocity is not None:
        raise InputError("machine.drive", None, "the drive prescribes the speed: it does not change when the specimen fails")
    interval = spec.sensor.interval
    update_interval = interval if failure is None or failure.interval is None else failure.interval
    step = min(interval, update_interval) / _FINE
    count = int(spec.until / step * (1 + 1e-12))
    if spec.until < 2 * FEWEST * interval:
        requirement = f"must be at most study.until/{2 * FEWEST}, {spec.until / (2 * FEWEST):.4g}"
        raise InputError("study.sensor.interval", interval, requirement)
    along = _parameter_axis(spec, machine, spec.along, spec.range, spec.points, "along", "range")
    second = _parameter_axis(spec, machine, spec.second, spec.second_range, spec.second_points, "second", "second_range")
    case = case_of(spec, machine)
    return Plan(spec, machine, case, signal, line, scheduled_fall, step, count, round(update_interval / step), along, second)


def case_of(spec: FailureDetection, machine: Machine) -> RunUpCase:
    """Return the case of one run of a machine. Raises ``InputError``."""
    return RunUpCase.of(machine, spec.start, RunSettings(spec.until, tolerance=spec.tolerance, engine=spec.engine))


def _scheduled_fall(spec: FailureDetection, machine: Machine) -> ScheduledFall | None:
    """Return the schedule of the carrier's stiffness. Raises ``InputError`` without any cause of its fall, or with two."""
    schedules = [s for s in machine.schedules if s.parameter.startswith("carrier.") and _STIFFNESS in s.parameter]
    if spec.failure is not None:
        if schedules:
            raise InputError(
                "study.failure", None, f"not allowed: {schedules[0].parameter} follows a schedule; give one of them"
            )
        return None
    if not schedules:
        reason = "this table is missing; give it, or a schedule of the carrier's stiffness: [[machine.schedules]]"
        raise InputError("study.failure", None, reason)
    changes = [t for s in schedules for t in _changes(s.pieces)]
    if not changes:
        raise InputError("machine.schedules", schedules[0].parameter, "must change the stiffness: all its values are equal")
    fall = ScheduledFall(schedules[0].pieces, min(changes), max(changes))
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
        requirement = ", ".join(p for p in machine.parameters if _STIFFNESS in p)
        raise InputError("study.failure.parameter", path, f"must be a stiffness: {requirement}")
    values_of(machine, parameter, (parameter.value * spec.failure.remaining,), "failure.remaining")


def _check_windows(spec: FailureDetection, scheduled_fall: ScheduledFall) -> None:
    """Check that the speed is measured before and after the fall of the stiffness."""
    begin = scheduled_fall.begin
    after = begin / 2 if spec.after is None else spec.after
    end = begin if spec.learning is None else after + spec.learning
    if end > begin:
        requirement = f"study.after + study.learning must be at most the time at which the stiffness falls, {begin:g}"
        raise InputError("study.after", spec.after, requirement)
    least = FEWEST * spec.sensor.interval
    for span, period in (
        (end - after, "before"),
        ((spec.until - scheduled_fall.end) / 2, "in the second half of the time after"),
    ):
        if span < least:
            requirement = f"there must be {FEWEST} readings {period} the fall of the stiffness: at most {span / FEWEST:.4g}"
            raise InputError("study.sensor.interval", spec.sensor.interval, requirement)


def _parameter_axis(
    spec: FailureDetection, machine: Machine, path: str | None, limits: Pair | None, points: int, key: str, range_key: str
) -> ParameterAxis | None:
    if path is None or limits is None:
        return None
    parameter = parameter_of(machine, path, key)
    if spec.failure is not None and path == spec.failure.parameter:
        raise InputError(f"study.{key}", path, "not allowed: this parameter falls with the failure")
    low, high = checked_range(machine, parameter, limits, range_key)
    return ParameterAxis(parameter, tuple(np.linspace(low, high, points).tolist()))


@dataclass(frozen=True, eq=False)
class MonitoredRun:
    """Run with its windows and the readings of the sensor."""

    run: FailingRun
    windows: Windows
    readings: Readings


@dataclass(frozen=True, eq=False)
class Findings:
    """Findings so far.

    nominal_run: at the values of the machine. detection: of its failure. averaged_speeds: before and after, by the averaged
    equations. points: at other values. no_detection: reason why there is no chart, if there should be one.
    """

    nominal_run: MonitoredRun
    detection: Detection | None = None
    averaged_speeds: tuple[AveragedSpeed, AveragedSpeed] | None = None
    points: tuple[ParameterPoint, ...] = field(default_factory=tuple)
    no_detection: str = ""


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings, more and more complete."""
    shares = (_RUN_SHARE, _AVERAGED_SHARE) if plan.along is not None else (0.9, 1.0)
    for failing in plan.failing_machine(plan.case).run(work.part("own", 0.0, shares[0])):
        nominal_run = _monitored_run(plan, failing)
        yield Findings(nominal_run)
    detection, no_detection = _detection(plan, nominal_run)
    averaging = work.part("averaged", *shares)
    averaged_speeds = None
    if nominal_run.readings.before is not None and nominal_run.readings.after is not None:
        before, after = (
            averaging.unit(name, partial(_averaged_speed, plan, nominal_run, name == "after")) for name in ("before", "after")
        )
        averaged_speeds = before, after
    averaging.report(1.0, "averaged equations")
    findings = Findings(nominal_run, detection, averaged_speeds, no_detection=no_detection)
    yield findings
    for points in _parameter_points(plan, work.part("variant", shares[1], 1.0)):
        yield replace(findings, points=points)


def _monitored_run(plan: Plan, failing: FailingRun) -> MonitoredRun:
    windows = _windows(plan, failing)
    return MonitoredRun(
        failing, windows, readings_of(failing.course.time, failing.course.angle, plan.spec.sensor.interval, windows)
    )


def _windows(plan: Plan, failing: FailingRun) -> Windows:
    """Return the windows in which the speed is measured, in a run so far."""
    spec, end = plan.spec, float(failing.course.time[-1])
    if plan.scheduled_fall is not None:
        begin, fall_end = plan.scheduled_fall.begin, plan.scheduled_fall.end
        failure_time = chart_begin = begin if end > begin else None
    else:
        broken = failing.state.broken
        is_gradual, learnt = plan.is_gradual, (spec.after or 0.0) + (spec.learning or 0.0)
        # A gradual fall may drive the exciter out of its resonance, which ends the damage: it is detected in any case.
        fall_end = broken if broken is not None else learnt if is_gradual else end
        begin, failure_time, chart_begin = (learnt, broken, learnt) if is_gradual else (fall_end, broken, broken)
    after = begin / 2 if spec.after is None else spec.after
    until = begin if spec.learning is None else after + spec.learning
    until = min(until, begin, end)
    earlier_window = (after, until) if until > after else None
    later_window = ((fall_end + end) / 2, end) if chart_begin is not None and end > fall_end else None
    return Windows(earlier_window, later_window, chart_begin, failure_time)


def _detection(plan: Plan, nominal_run: MonitoredRun) -> tuple[Detection | None, str]:
    """Return the detection of the failure; None, and the reason, where there is no chart."""
    sensor = plan.spec.sensor
    every = sensor.false_alarm_every / sensor.interval
    try:
        return detection_of(
            nominal_run.readings, nominal_run.windows, sensor.noise, every, sensor.change, not plan.is_gradual
        ), ""
    except RunError as error:
        return None, str(error)


def _averaged_speed(plan: Plan, nominal_run: MonitoredRun, is_after: bool) -> AveragedSpeed:
    """Return the speed by the averaged equations, before the failure or after it."""
    machine, model = plan.case.machine, plan.case.models[0]
    standing = nominal_run.run.state
    verdict, mean = (
        (nominal_run.run.verdict, nominal_run.readings.after)
        if is_after
        else (nominal_run.run.verdict_before or nominal_run.run.verdict, nominal_run.readings.before)
    )
    assert mean is not None
    if is_after and plan.spec.failure is not None:
        falling = plan.failing_machine(plan.case).falling
        assert falling is not None
        machine = machine.with_unchecked_values(
            {falling.parameter: falling.value * float(nominal_run.run.course.stiffness[-1])}
        )
    window = nominal_run.windows.abnormal if is_after else nominal_run.windows.normal
    assert window is not None
    steady = machine.at(window[1] if is_after else window[0]).with_fields(schedules=())
    # The averaged equations continue from the full motion, and settle before the mean is taken.
    leg = standing.last if is_after else standing.onset or standing.last
    start, part = leg.trajectory.end_state[: len(model.initial)], window[1] - window[0]
    spread = float(
        np.ptp(nominal_run.readings.speed[nominal_run.readings.abnormal if is_after else nominal_run.readings.normal])
    )
    beats = verdict.outcome in _BEATING_OUTCOMES or spread > _STEADY_TOLERANCE * abs(mean)
    return averaged_speed(steady, mean, beats, start, (_SETTLE * part, part), plan.spec.tolerance, plan.spec.engine)


def _parameter_points(plan: Plan, work: Work) -> Iterator[tuple[ParameterPoint, ...]]:
    """Yield the signal at all values; for one parameter also between the best value and its neighbours."""
    if plan.along is None:
        return
    axes = [v.values for v in (plan.along, plan.second) if v is not None]
    remaining_values, points = list(product(*axes)), dict[tuple[float, ...], ParameterPoint]()
    total = len(remaining_values) + (2 * _ROUNDS if plan.second is None else 0)
    for _ in range(1 + (_ROUNDS if plan.second is None else 0)):
        for values in remaining_values:
            part = work.part("", len(points) / total, (len(points) + 1) / total)
            points[values] = part.unit(f"at {values}", partial(_parameter_point, plan, values, part.without_memory))
            part.report(1.0, f"{len(points)} of {total} other values")
            yield tuple(points[v] for v in sorted(points))
        remaining_values = _midpoints(sorted(points), points)


def _midpoints(
    sorted_values: list[tuple[float, ...]], points: dict[tuple[float, ...], ParameterPoint]
) -> list[tuple[float, ...]]:
    """Return the values halfway between the one with the largest signal and its neighbours."""
    best = best_index([points[v] for v in sorted_values])
    if best is None:
        return []
    neighbours = [sorted_values[i] for i in (best - 1, best + 1) if 0 <= i < len(sorted_values)]
    return [((sorted_values[best][0] + one[0]) / 2,) for one in neighbours]


def _parameter_point(plan: Plan, values: tuple[float, ...], work: Work) -> ParameterPoint:
    paths = [v.parameter.path for v in (plan.along, plan.second) if v is not None]
    case = plan.case_at(dict(zip(paths, values, strict=True)))
    *_, failing = plan.failing_machine(case).run(work)
    monitored_run = _monitored_run(plan, failing)
    signal = None if failing.failure else monitored_run.readings.signal(plan.spec.sensor.noise)
    return ParameterPoint(
        values, monitored_run.readings.before, monitored_run.readings.after, signal, str(failing.verdict.outcome)
    )
