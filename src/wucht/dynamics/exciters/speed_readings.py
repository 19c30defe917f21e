"""Speeds before and after a failure: readings of a slow sensor and its alarms, and by the averaged equations."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import driven_speeds, machine_at_speed
from wucht.measurements.cusum import AlarmDistribution, Cusum, design_chart
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.observers.records import smooth_weights

STEADY, UNSTABLE, BEATING = "steady state", "unstable steady state", "beating motion"
_SAMPLES = 2000


@dataclass(frozen=True)
class AveragedSpeed:
    """Speed by the averaged equations. speed: of the main rotor, signed. kind: the nearest steady state, stable or not, or the
    mean of a beating motion. reason: why there is none. next_stable: the speed of the nearest stable state, if another one."""

    speed: float | None
    kind: str = ""
    reason: str = ""
    next_stable: float | None = None


def averaged_speed(
    machine: Machine,
    near: float,
    beats: bool,
    start: np.ndarray,
    span: tuple[float, float],
    tolerance: float,
    engine: str | None,
) -> AveragedSpeed:
    """Return the speed by the averaged equations that corresponds to a mean speed of the full ones.

    machine: as it is then. near: the mean speed of the full equations. beats: True if that is one of a beating motion; then the
    averaged equations run from ``start``, a state (n,) of the machine on that motion, for a time, and the mean is taken over
    the end of it. span: these two times.
    """
    steady = machine_at_speed(machine, None)
    try:
        return _beating_speed(steady, start, span, tolerance, engine) if beats else _nearest_speed(steady, near)
    except InputError as error:
        return AveragedSpeed(None, reason=str(error))


def _nearest_speed(machine: Machine, near: float) -> AveragedSpeed:
    averaged_equations = averaged_equations_of(machine, True)
    torques = SteadyTorques.from_averaged_equations(averaged_equations)
    if torques.fixed_speed is not None:
        return AveragedSpeed(None, reason="the drive prescribes the speed")
    stability, sense = AveragedStability(torques, averaged_equations), averaged_equations.senses[machine.rotor.name]
    states = all_states(torques, *driven_speeds(machine)[0]).states
    if not states:
        return AveragedSpeed(None, reason="the averaged equations have no steady state")
    ordered_states = sorted(states, key=lambda state: abs(sense * state.speed - near))
    stable = [s for s in ordered_states if stability.stability(s).stable is not False]
    if stable[:1] == ordered_states[:1]:
        return AveragedSpeed(sense * ordered_states[0].speed, STEADY)
    return AveragedSpeed(sense * ordered_states[0].speed, UNSTABLE, next_stable=sense * stable[0].speed if stable else None)


def _beating_speed(
    machine: Machine, start: np.ndarray, span: tuple[float, float], tolerance: float, engine: str | None
) -> AveragedSpeed:
    model = slow_model(machine, start, None, 1)
    compiled_system = compile_system(model.system, tolerance, (), engine)
    whole, part = span
    grid = np.append(0.0, np.linspace(whole - part, whole, _SAMPLES)) if whole > part else np.linspace(0.0, whole, _SAMPLES)
    motion = integrate(compiled_system, model.initial, model.parameter_values, grid).reraise_interrupt()
    if motion.failure:
        return AveragedSpeed(None, reason=motion.failure)
    name = machine.rotor.name
    output = model.averaged_equations.system.output(f"speed[{name}]").expression
    speeds = Evaluator.of(model.system, [output], [name])(motion.time, motion.states, motion.final_parameter_values)[name][
        -_SAMPLES:
    ]
    mean = float(np.average(speeds, weights=smooth_weights(len(speeds))))
    return AveragedSpeed(model.averaged_equations.senses[name] * mean, BEATING)


FEWEST = 10  # readings that determine a speed
_MOST_NORMAL = 256  # readings before the failure that are repeated periodically
_EVEN = 1e-3  # of the noise: readings that differ by less are equal
_CERTAIN = 0.9999  # sufficient probability of an alarm
_POINTS = 1000  # of the probability curve, beyond the readings that are followed one by one


@dataclass(frozen=True, eq=False)
class Windows:
    """Time windows. normal, abnormal: of the speed before and after the failure, None if there is none. monitoring_start: from
    which alarms count as true. failure_time: None where the specimen did not fail."""

    normal: tuple[float, float] | None
    abnormal: tuple[float, float] | None
    monitoring_start: float | None
    failure_time: float | None


@dataclass(frozen=True, eq=False)
class Readings:
    """Mean speeds (n,) over the sensor's intervals, without noise. time (n,): at the end of each. normal, abnormal (n,): masks
    of those that are used for the speed before the failure, and for that after it. before, after: these speeds, means over
    beats; None where the readings are too few. beating: the standard deviation of the readings before the failure, wherever in
    a beat they begin. windows: of both speeds."""

    time: np.ndarray
    speed: np.ndarray
    normal: np.ndarray
    abnormal: np.ndarray
    before: float | None
    after: float | None
    beating: float
    windows: Windows

    def deviation(self, noise: float) -> float:
        """Return the standard deviation of the readings before the failure: of the noise, and of the beating."""
        return float(np.hypot(noise, self.beating))

    def signal(self, noise: float) -> float | None:
        """Return the change of speed over the standard deviation of the readings; None without a speed before or after."""
        if self.before is None or self.after is None:
            return None
        return abs(self.after - self.before) / self.deviation(noise)


def readings_of(time: np.ndarray, angle: np.ndarray, interval: float, windows: Windows) -> Readings:
    """Return the readings from the angle (N,) of the rotor at samples whose spacing is a whole part of the interval."""
    every = round(interval / (time[1] - time[0])) if len(time) > 1 else 1
    at, angles = time[::every], angle[::every]
    normal, abnormal = (_inside(at[:-1], at[1:], between) for between in (windows.normal, windows.abnormal))
    # A reading may begin anywhere in a beat: means and deviations are those of all possible readings.
    begin, end, speeds = time[:-every], time[every:], (angle[every:] - angle[:-every]) / interval
    before, beating = _mean_and_deviation(speeds[_inside(begin, end, windows.normal)], int(normal.sum()))
    after, _ = _mean_and_deviation(speeds[_inside(begin, end, windows.abnormal)], int(abnormal.sum()))
    return Readings(at[1:], np.diff(angles) / np.diff(at), normal, abnormal, before, after, beating, windows)


def _mean_and_deviation(values: np.ndarray, readings: int) -> tuple[float | None, float]:
    """Return mean and standard deviation of beating values (n,), cut at both ends. readings: their number."""
    if readings < FEWEST:
        return None, 0.0
    weights = smooth_weights(len(values))
    mean = float(np.average(values, weights=weights))
    return mean, math.sqrt(float(np.average((values - mean) ** 2, weights=weights)))


@dataclass(frozen=True, eq=False)
class Detection:
    """Detection by a chart. chart: that monitors the readings. learnt: their mean before the failure. alarms: by readings, the
    first of them at a time ``begins`` after the failure (where there is none, after the chart began) and then one every
    ``interval``; beyond the run those of its end are repeated."""

    chart: Cusum
    learnt: float
    alarms: AlarmDistribution
    begins: float
    interval: float

    @property
    def readings(self) -> int:
        """Number of readings after which an alarm is practically certain, or no more is known."""
        return int(self.alarms.curve(_CERTAIN, 1)[0][-1]) + 1

    @property
    def horizon(self) -> float:
        """Time of the last of these readings after the failure."""
        return self.begins + self.interval * (self.readings - 1)

    @property
    def mean(self) -> float | None:
        """Expected time from the failure to the alarm; None where an alarm is not certain enough."""
        is_known = self.alarms.is_certain or self.alarms.first[-1] >= _CERTAIN
        return self.begins + self.interval * self.alarms.mean() if is_known else None

    def quantile(self, probability: float) -> float | None:
        """Return the time after the failure by which an alarm has a probability; None if not reached within the horizon."""
        count = self.alarms.quantile(probability)
        return None if count is None else self.begins + self.interval * count

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times (N,) after the failure, and the probability (N,) of an alarm by each."""
        count, probability = self.alarms.curve(_CERTAIN, _POINTS)
        return self.begins + self.interval * count, probability


def detection_of(readings: Readings, noise: float, every: float, change: float | None, steady: bool) -> Detection | None:
    """Compute how soon a change is detected; None where there is no speed before, or no reading is monitored after.

    noise: of a reading. every: mean number of readings between two false alarms. change: for which the chart is optimal.
    steady: the chart has been running for long when the change comes, and has not alarmed; else it begins then. Raises
    ``RunError`` where there is no chart.
    """
    learnt, start = readings.speed[readings.normal][-_MOST_NORMAL:], readings.windows.monitoring_start
    if readings.before is None or start is None:
        return None
    later = readings.time > start * (1 + 1e-12)
    if not later.any():
        return None
    # The mean of the readings themselves, which need not be that over whole beats: so the repeated deviations average zero.
    mean = float(learnt.mean())
    normal = np.zeros(1) if np.ptp(learnt) < _EVEN * noise else learnt - mean
    reference = (change or readings.deviation(noise)) / 2
    cusum_chart = design_chart(reference, noise, every, normal)
    abnormal, again = (readings.speed[mask] - mean for mask in (later, readings.abnormal))
    alarms = cusum_chart.alarms(normal if steady else None, abnormal, again, _CERTAIN)
    failure_time = readings.windows.failure_time
    begins = readings.time[later][0] - (start if failure_time is None else failure_time)
    step = readings.time[-1] - readings.time[-2]
    return Detection(cusum_chart, mean, alarms, float(begins), float(step))


def _inside(begin: np.ndarray, end: np.ndarray, between: tuple[float, float] | None) -> np.ndarray:
    """Return a mask of the intervals (n,) that lie within two times."""
    if between is None or not len(end):
        return np.zeros(len(end), bool)
    rounding = 1e-9 * (end[-1] - begin[0])
    return np.asarray((begin >= between[0] - rounding) & (end <= between[1] + rounding))
