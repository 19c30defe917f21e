"""What a slow sensor sees of a run: readings of the speed before and after the failure, and how soon its chart alarms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.measurements.cusum import AlarmDistribution, Cusum, chart
from wucht.numerics.observers.records import smooth_weights

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
