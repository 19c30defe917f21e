"""Speeds before and after a failure: readings of a slow sensor and its alarms, and by the averaged equations."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import driven_speeds, turning
from wucht.measurements.cusum import AlarmDistribution, Cusum, chart
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.observers.records import smooth_weights

STEADY, UNSTABLE, BEATING = "steady state", "unstable steady state", "beating motion"
_SAMPLES = 2000


@dataclass(frozen=True)
class AveragedSpeed:
    """speed: of the main rotor, signed. kind: the steady state that is nearest, stable or not, or the mean of a beating motion.
    reason: why there is none. next_stable: the speed of the nearest stable steady state, where it is another one."""

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
    """What the averaged equations give instead of a mean speed.

    machine: as it is then. near: the mean speed of the full equations. beats: whether that is one of a beating motion; then the
    averaged equations run from ``start``, a state (n,) of the machine on that motion, for a time, and the mean is taken over
    the end of it. span: these two times.
    """
    steady = turning(machine, None)
    try:
        return _beating(steady, start, span, tolerance, engine) if beats else _nearest(steady, near)
    except InputError as error:
        return AveragedSpeed(None, reason=str(error))


def _nearest(machine: Machine, near: float) -> AveragedSpeed:
    slow = averaged_machine(machine, True)
    torques = SteadyTorques.from_slow(slow)
    if torques.given is not None:
        return AveragedSpeed(None, reason="the drive prescribes the speed")
    stability, sense = AveragedStability(torques, slow), slow.senses[machine.rotor.name]
    found = all_states(torques, *driven_speeds(machine)[0]).states
    if not found:
        return AveragedSpeed(None, reason="the averaged equations have no steady state")
    each = sorted(found, key=lambda state: abs(sense * state.speed - near))
    stable = [s for s in each if stability.stability(s).stable is not False]
    if stable[:1] == each[:1]:
        return AveragedSpeed(sense * each[0].speed, STEADY)
    return AveragedSpeed(sense * each[0].speed, UNSTABLE, next_stable=sense * stable[0].speed if stable else None)


def _beating(
    machine: Machine, start: np.ndarray, span: tuple[float, float], tolerance: float, engine: str | None
) -> AveragedSpeed:
    model = slow_model(machine, start, None, 1)
    compiled = compile_system(model.system, tolerance, (), engine)
    whole, part = span
    grid = np.append(0.0, np.linspace(whole - part, whole, _SAMPLES)) if whole > part else np.linspace(0.0, whole, _SAMPLES)
    motion = integrate(compiled, model.initial, model.values, grid)
    if motion.failure:
        return AveragedSpeed(None, reason=motion.failure)
    name = machine.rotor.name
    output = model.slow.system.output(f"speed[{name}]").expression
    speeds = Evaluator.of(model.system, [output], [name])(motion.time, motion.states, motion.parameters)[name][-_SAMPLES:]
    mean = float(np.average(speeds, weights=smooth_weights(len(speeds))))
    return AveragedSpeed(model.slow.senses[name] * mean, BEATING)


FEWEST = 10  # readings, of which a speed is told
_MOST_NORMAL = 256  # readings before the failure that are taken as what comes again and again
_EVEN = 1e-3  # of the noise: readings that differ less are one
_CERTAIN = 0.9999  # the probability at which it is enough
_POINTS = 1000  # of the probability, beyond the readings that are followed one by one


@dataclass(frozen=True, eq=False)
class Readings:
    """The mean speeds (n,) over the sensor's intervals, without noise. time (n,): at the end of each. normal, changed (n,):
    which of them are taken for the speed before the failure, and for that after it. before, after: these speeds, means over
    beats; None where the readings are too few. beating: the standard deviation of the readings before the failure, wherever in
    a beat they begin."""

    time: np.ndarray
    speed: np.ndarray
    normal: np.ndarray
    changed: np.ndarray
    before: float | None
    after: float | None
    beating: float

    def deviation(self, noise: float) -> float:
        """The standard deviation of the readings before the failure: of the noise, and of the beating."""
        return float(np.hypot(noise, self.beating))

    def signal(self, noise: float) -> float | None:
        """The change of speed over the standard deviation of the readings; None where there is no speed before or after."""
        if self.before is None or self.after is None:
            return None
        return abs(self.after - self.before) / self.deviation(noise)


@dataclass(frozen=True, eq=False)
class Windows:
    """Of time: from when to when the speed before and after the failure is taken, None where there is none; when the chart
    begins to count what is no false alarm; and when the specimen failed, None where it did not."""

    normal: tuple[float, float] | None
    changed: tuple[float, float] | None
    watched: float | None
    failed: float | None


def readings_of(time: np.ndarray, angle: np.ndarray, interval: float, windows: Windows) -> Readings:
    """From the angle (N,) of the rotor at samples whose spacing is a whole part of the interval."""
    every = round(interval / (time[1] - time[0])) if len(time) > 1 else 1
    at, turned = time[::every], angle[::every]
    normal, changed = (_inside(at[:-1], at[1:], between) for between in (windows.normal, windows.changed))
    # A reading may begin anywhere in a beat: means and deviations are those of all that could be taken.
    begin, end, any_ = time[:-every], time[every:], (angle[every:] - angle[:-every]) / interval
    before, beating = _mean_and_deviation(any_[_inside(begin, end, windows.normal)], int(normal.sum()))
    after, _ = _mean_and_deviation(any_[_inside(begin, end, windows.changed)], int(changed.sum()))
    return Readings(at[1:], np.diff(turned) / np.diff(at), normal, changed, before, after, beating)


def _mean_and_deviation(values: np.ndarray, readings: int) -> tuple[float | None, float]:
    """Of values (n,) that beat, and are cut at both ends; readings: so many are among them."""
    if readings < FEWEST:
        return None, 0.0
    weights = smooth_weights(len(values))
    mean = float(np.average(values, weights=weights))
    return mean, math.sqrt(float(np.average((values - mean) ** 2, weights=weights)))


@dataclass(frozen=True, eq=False)
class Detection:
    """chart: that watches the readings. learnt: their mean before the failure. alarms: by readings, the first of them at a time
    ``begins`` after the failure (where there is none, after the chart began) and then one every ``interval``, those beyond the
    run being those of its end, again and again."""

    chart: Cusum
    learnt: float
    alarms: AlarmDistribution
    begins: float
    interval: float

    @property
    def readings(self) -> int:
        """The horizon: after so many readings it is as good as certain that it has been seen, or no more is known."""
        return int(self.alarms.curve(_CERTAIN, 1)[0][-1]) + 1

    @property
    def horizon(self) -> float:
        """The time of the last of them after the failure."""
        return self.begins + self.interval * (self.readings - 1)

    @property
    def mean(self) -> float | None:
        """The expected time from the failure to the alarm; None where that is not certain enough."""
        known = self.alarms.certain or self.alarms.first[-1] >= _CERTAIN
        return self.begins + self.interval * self.alarms.mean() if known else None

    def quantile(self, probability: float) -> float | None:
        """By when after the failure it is seen with a probability; None where that is not reached within the horizon."""
        count = self.alarms.quantile(probability)
        return None if count is None else self.begins + self.interval * count

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (N,) after the failure, and the probability (N,) that it has been seen by each."""
        count, probability = self.alarms.curve(_CERTAIN, _POINTS)
        return self.begins + self.interval * count, probability


def detection_of(
    readings: Readings, windows: Windows, noise: float, every: float, change: float | None, steady: bool
) -> Detection | None:
    """How soon a change is seen; None where there is no speed before, or nothing is watched after.

    noise: of a reading. every: readings between two false alarms. change: that is to be seen soonest. steady: the chart has
    been running for long when the change comes, and has not alarmed; else it begins then. Raises ``RunError`` where there is
    no chart.
    """
    learnt = readings.speed[readings.normal][-_MOST_NORMAL:]
    if readings.before is None or windows.watched is None:
        return None
    later = readings.time > windows.watched * (1 + 1e-12)
    if not later.any():
        return None
    # The mean of the readings as they came, which need not be that over whole beats: so they come again and again about zero.
    mean = float(learnt.mean())
    normal = np.zeros(1) if np.ptp(learnt) < _EVEN * noise else learnt - mean
    reference = (change or readings.deviation(noise)) / 2
    made = chart(reference, noise, every, normal)
    changed, again = (readings.speed[which] - mean for which in (later, readings.changed))
    alarms = made.alarms(normal if steady else None, changed, again, _CERTAIN)
    counted_from = windows.watched if windows.failed is None else windows.failed
    begins, step = readings.time[later][0] - counted_from, readings.time[-1] - readings.time[-2]
    return Detection(made, mean, alarms, float(begins), float(step))


def _inside(begin: np.ndarray, end: np.ndarray, between: tuple[float, float] | None) -> np.ndarray:
    """Which of the intervals (n,) lie within two times."""
    if between is None or not len(end):
        return np.zeros(len(end), bool)
    rounding = 1e-9 * (end[-1] - begin[0])
    return np.asarray((begin >= between[0] - rounding) & (end <= between[1] + rounding))
