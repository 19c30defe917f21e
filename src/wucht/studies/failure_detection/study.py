"""Failure of a specimen: the fall of its stiffness and the readings of a slow sensor, in the run and at other values."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from wucht.dynamics.exciters.failing_machine import FailingMachine, FailingRun, FallingStiffness
from wucht.dynamics.exciters.monitored_failure import (
    ScheduledFall,
    averaged_speed_of,
    changes_of,
    measuring_windows,
)
from wucht.dynamics.exciters.signal_points import SignalPoint, values_beside_best
from wucht.dynamics.exciters.speed_readings import FEWEST, Readings, detection_of, readings_of
from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal
from wucht.dynamics.run_ups.observed_loads import load_integration
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.work import Work, result_or_reason
from wucht.errors import InputError
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine
from wucht.machines.machine import Machine
from wucht.schema import SI, Composite, Parameter, composite, si
from wucht.studies.answer import Answer
from wucht.studies.failure_detection.answer import state_failure
from wucht.studies.failure_detection.failure_tables import FAILURE, SENSOR, Failure, Sensor
from wucht.studies.failure_detection.figure import figure
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Pair, Path, Start, Tolerance, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import woehler_line
from wucht.studies.study import FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MOST_POINTS, _MOST_READINGS = 200, 20_000
_FEWEST_BETWEEN_ALARMS = 10.0  # readings
_FINE = 8  # samples in a reading, and between two updates of the damage, at least
_STIFFNESS = "stiffness"
_RUN_SHARE, _AVERAGED_SHARE = 0.3, 0.35  # of the work after the run and the averaged equations, where other values follow
_ROUNDS = 4  # halvings of the steps between the best value and its neighbours

Axis = tuple[Parameter, tuple[float, ...]]  # a parameter over which the signal is computed, and its first values
# The run, the load of the specimen with its line and the schedule of its stiffness, and the parameters that are varied.
Prepared = tuple[RunUpCase, MachineSignal, WoehlerLine | None, ScheduledFall | None, tuple[Axis, ...]]


class FailureDetection(Study):
    """Failure of a specimen, and its detection by the speed of the exciter.

    The stiffness falls by a schedule of the machine, or with the damage that its load does (``failure``).
    """

    kind = "failure-detection"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    curves = (("reading_time", "speed"), ("alarm_time", "seen"))
    solves = FULL_EQUATIONS
    from_start = True

    until: SI[float] = si("s", "time", gt=0, help="time at which the run ends")
    start: Composite[Start] = composite(default_factory=dict)
    failure: Composite[Annotated[Failure | None, FAILURE]] = composite(
        default=None,
        description="failure by the damage of a load, a table `[study.failure]`; without it by a schedule of the machine",
    )
    sensor: Composite[Annotated[Sensor, SENSOR]] = composite(
        title="sensor of the speed", description="sensor of the speed: `[study.sensor]`"
    )
    after: SI[float | None] = si("s", "time from which on the speed is measured", default=None, ge=0, help=(
        "time from which on the speed before the failure is measured; by default the second half of the time before it"
    ))  # fmt: skip
    learning: SI[float | None] = si("s", "time over which the speed before the failure is measured", default=None, gt=0, help=(
        "time over which the speed before the failure is measured; by default until the stiffness begins to fall"
    ))  # fmt: skip
    along: Path | None = Field(default=None, description=(
        "path of a parameter over which the signal at the failure (change of speed over the standard deviation of the "
        "readings) and its largest value are computed"
    ))  # fmt: skip
    range: Composite[Pair | None] = composite(default=None, description="pair [low, high] of the parameter `along`")
    points: Whole = Field(default=21, ge=2, le=_MOST_POINTS, description="number of values of the parameter `along`")
    second: Path | None = Field(default=None, description="path of another parameter, beside `along`")
    second_range: Composite[Pair | None] = composite(default=None, description="pair [low, high] of the second parameter")
    second_points: Whole = Field(default=5, ge=2, le=_MOST_POINTS, description="number of values of the second parameter")
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that keys which belong together are given, and that times fit each other."""
        sensor, failure = self.sensor, self.failure
        if sensor.false_alarm_every < _FEWEST_BETWEEN_ALARMS * sensor.interval:
            least = _FEWEST_BETWEEN_ALARMS * sensor.interval
            raise InputError(
                "study.sensor.false_alarm_every", sensor.false_alarm_every, f"must be at least ten readings, {least:g}"
            )
        if self.until / sensor.interval > _MOST_READINGS:
            raise InputError("study.sensor.interval", sensor.interval, f"must be at least study.until/{_MOST_READINGS}")
        if failure is not None:
            failure.woehler.check("study.failure.woehler")
            ratio = sensor.interval / (failure.interval or sensor.interval)
            if abs(max(ratio, 1 / ratio) - round(max(ratio, 1 / ratio))) > 1e-9 * max(ratio, 1 / ratio):
                requirement = f"must be a multiple of study.sensor.interval ({sensor.interval:g}), or an integer fraction of it"
                raise InputError("study.failure.interval", failure.interval, requirement)
            if failure.law == "linear" and (self.learning is None or self.after is None):
                missing = "learning" if self.after is not None else "after"
                reason = "the stiffness falls from the beginning: study.after and study.learning say when to measure the speed"
                raise InputError(f"study.{missing}", None, f"this key is missing: {reason}", code="missing")
        end = (self.after or 0.0) + (self.learning or 0.0)
        if end >= self.until:
            learning = "" if self.learning is None else f"with study.learning ({self.learning:g}) "
            raise InputError("study.after", self.after, f"must {learning}be before study.until, {self.until:g}")
        for path, range_key in (("along", "range"), ("second", "second_range")):
            if (getattr(self, path) is None) != (getattr(self, range_key) is None):
                missing = path if getattr(self, path) is None else range_key
                raise InputError(
                    f"study.{missing}", None, f"this key is missing; {path} and {range_key} belong together", code="missing"
                )
        if self.second is not None and self.along is None:
            raise InputError("study.along", None, "this key is missing; second is given", code="missing")
        if self.second is not None and self.second == self.along:
            raise InputError("study.second", self.second, "must be another parameter than along")

    def prepare(self, machine: Machine) -> Prepared:
        """Return the run, its load, the fall of the stiffness and the axes. Raises ``InputError``."""
        fall, failure, line = self._scheduled_fall(machine), self.failure, None
        if fall is not None:
            self._check_windows(fall)
        if failure is None:
            signal = machine_signal(machine, "displacement", None)
        else:
            _check_failure(failure, machine)
            signal = machine_signal(machine, failure.signal, failure.direction, "study.failure")
            line = woehler_line(failure.woehler, signal.unit, "study.failure.woehler")
        if machine.rotor.coordinate.prescribed_velocity is not None:
            raise InputError(
                "machine.drive", None, "the drive prescribes the speed: it does not change when the specimen fails"
            )
        interval = self.sensor.interval
        if self.until < 2 * FEWEST * interval:
            requirement = f"must be at most study.until/{2 * FEWEST}, {self.until / (2 * FEWEST):.4g}"
            raise InputError("study.sensor.interval", interval, requirement)
        along = self._axis(machine, self.along, self.range, self.points, "along", "range")
        second = self._axis(machine, self.second, self.second_range, self.second_points, "second", "second_range")
        axes = tuple(axis for axis in (along, second) if axis is not None)
        return self._case(machine), signal, line, fall, axes

    def _case(self, machine: Machine) -> RunUpCase:
        """Return the run of a machine. Raises ``InputError``."""
        return RunUpCase.of(machine, self.start, RunSettings(self.until, tolerance=self.tolerance, engine=self.engine))

    def _scheduled_fall(self, machine: Machine) -> ScheduledFall | None:
        """Return the schedule of the carrier's stiffness. Raises ``InputError`` without any cause of its fall, or with two."""
        schedules = [s for s in machine.schedules if s.parameter.startswith("carrier.") and _STIFFNESS in s.parameter]
        if self.failure is not None:
            if schedules:
                reason = f"not allowed: {schedules[0].parameter} follows a schedule; give one of them"
                raise InputError("study.failure", None, reason)
            return None
        if not schedules:
            reason = "this table is missing; give it, or a schedule of the carrier's stiffness: [[machine.schedules]]"
            raise InputError("study.failure", None, reason)
        changes = [t for s in schedules for t in changes_of(s.pieces)]
        if not changes:
            raise InputError("machine.schedules", schedules[0].parameter, "must change the stiffness: all its values are equal")
        fall = ScheduledFall(schedules[0].pieces, min(changes), max(changes))
        if fall.begin <= 0 or fall.end >= self.until:
            requirement = f"must be later than the fall of the stiffness, from {fall.begin:g} to {fall.end:g}"
            raise InputError("study.until", self.until, requirement)
        return fall

    def _check_windows(self, fall: ScheduledFall) -> None:
        """Check that the speed is measured before and after the fall of the stiffness."""
        after = fall.begin / 2 if self.after is None else self.after
        end = fall.begin if self.learning is None else after + self.learning
        if end > fall.begin:
            requirement = f"study.after + study.learning must be at most the time at which the stiffness falls, {fall.begin:g}"
            raise InputError("study.after", self.after, requirement)
        spans = {"before": end - after, "in the second half of the time after": (self.until - fall.end) / 2}
        for period, span in spans.items():
            if span < FEWEST * self.sensor.interval:
                requirement = f"there must be {FEWEST} readings {period} the fall of the stiffness: at most {span / FEWEST:.4g}"
                raise InputError("study.sensor.interval", self.sensor.interval, requirement)

    def _axis(
        self, machine: Machine, path: str | None, limits: Pair | None, points: int, key: str, range_key: str
    ) -> Axis | None:
        if path is None or limits is None:
            return None
        parameter = parameter_of(machine, path, key)
        if self.failure is not None and path == self.failure.parameter:
            raise InputError(f"study.{key}", path, "not allowed: this parameter falls with the failure")
        low, high = checked_range(machine, parameter, limits, range_key)
        return parameter, tuple(np.linspace(low, high, points).tolist())

    @property
    def _is_gradual(self) -> bool:
        """True if the stiffness falls with the damage from the beginning."""
        return self.failure is not None and self.failure.law == "linear"

    def _failing_machine(self, case: RunUpCase, prepared: Prepared) -> FailingMachine:
        """Return the machine of a case, ready to run."""
        _, signal, line, fall, _ = prepared
        interval, failure, [model] = self.sensor.interval, self.failure, case.models
        update_interval = interval if failure is None or failure.interval is None else failure.interval
        step = min(interval, update_interval) / _FINE
        count = int(self.until / step * (1 + 1e-12))
        falling, begin = None, None if fall is None else fall.begin
        if failure is not None:
            whole = case.machine.values[failure.parameter]
            falling = FallingStiffness(failure.parameter, whole, failure.remaining, not self._is_gradual)
            begin = (self.after or 0.0) + (self.learning or 0.0) if self._is_gradual else None
        return FailingMachine(
            case.machine, load_integration(case, signal), model.initial, step, count, round(update_interval / step),
            None if line is None else AccumulatedDamage(line), falling, None if fall is None else fall.share, begin,
        )  # fmt: skip

    def _readings(self, run: FailingRun, fall: ScheduledFall | None) -> Readings:
        course, broken = run.course, run.state.broken
        windows = measuring_windows(float(course.time[-1]), broken, fall, self._is_gradual, self.after, self.learning)
        return readings_of(course.time, course.angle, self.sensor.interval, windows)

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Run the machine until after its failure, and at other values."""
        case, signal, _, fall, axes = prepared
        failing, sensor = self._failing_machine(case, prepared), self.sensor
        state = partial(state_failure, case=case, signal=signal, axes=axes, sensor=sensor)
        shares = (_RUN_SHARE, _AVERAGED_SHARE) if axes else (0.9, 1.0)
        for run in failing.run(work.part("own", 0.0, shares[0])):
            readings = self._readings(run, fall)
            yield Answer(machine.units, partial(state, run=run, readings=readings))
        every = sensor.false_alarm_every / sensor.interval
        detection = result_or_reason(detection_of, readings, sensor.noise, every, sensor.change, not self._is_gradual)
        averaging, averaged_speeds = work.part("averaged", *shares), {}
        for name in ("before", "after") if readings.before is not None and readings.after is not None else ():
            speed_then = partial(averaged_speed_of, failing, run, readings, name == "after", self.tolerance, self.engine)
            averaged_speeds[name] = averaging.unit(name, speed_then)
        averaging.report(1.0, "averaged equations")
        state = partial(state, run=run, readings=readings, detection=detection, averaged_speeds=averaged_speeds)
        yield Answer(machine.units, state)
        for points in self._points(machine, prepared, work.part("variant", shares[1], 1.0)):
            yield Answer(machine.units, partial(state, points=points))

    def _points(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[tuple[SignalPoint, ...]]:
        """Yield the signal at all values; for one parameter also between the best value and its neighbours."""
        *_, axes = prepared
        if not axes:
            return
        rounds = _ROUNDS if len(axes) == 1 else 0
        remaining_values, points = list(product(*(values for _, values in axes))), dict[tuple[float, ...], SignalPoint]()
        total = len(remaining_values) + 2 * rounds
        for _ in range(1 + rounds):
            for values in remaining_values:
                part = work.part("", len(points) / total, (len(points) + 1) / total)
                points[values] = part.unit(f"at {values}", partial(self._point, machine, prepared, values, part.without_memory))
                part.report(1.0, f"{len(points)} of {total} other values")
                yield tuple(points[v] for v in sorted(points))
            remaining_values = values_beside_best([points[v] for v in sorted(points)])

    def _point(self, machine: Machine, prepared: Prepared, values: tuple[float, ...], work: Work) -> SignalPoint:
        _, _, _, fall, axes = prepared
        paths = [parameter.path for parameter, _ in axes]
        case = self._case(machine.with_values(dict(zip(paths, values, strict=True))))
        *_, run = self._failing_machine(case, prepared).run(work)
        readings = self._readings(run, fall)
        signal = None if run.failure else readings.signal(self.sensor.noise)
        return SignalPoint(values, readings.before, readings.after, signal, str(run.verdict.outcome))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw speed, load and stiffness over time, the detection, and the signal at other values."""
        return figure(result)


def _check_failure(failure: Failure, machine: Machine) -> None:
    """Check that the falling parameter is a stiffness that the machine has and may lose."""
    path = failure.parameter
    parameter = parameter_of(machine, path, "failure.parameter")
    if _STIFFNESS not in path:
        requirement = ", ".join(p for p in machine.parameters if _STIFFNESS in p)
        raise InputError("study.failure.parameter", path, f"must be a stiffness: {requirement}")
    values_of(machine, parameter, (parameter.value * failure.remaining,), "failure.remaining")
