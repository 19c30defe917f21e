"""From where orders are fitted: the speed from a mean that orders hardly touch, sharpened over ever longer parts."""

from __future__ import annotations

import math

import numpy as np

from wucht.measurements.order_regression import Fit, Mean, OrderModel

START_BLOCKS = 12  # a period of the highest order
_COARSE = 20_000  # blocks: enough for a mean
_FIRST_TURNS = 4.0  # in which no speed is so wrong that the highest order is out of phase
_LONGER = 2.0
_SMALL, _MOST = 0.03, 12  # of a standard error, and steps: a start need not be sharp
_IN_PHASE = 0.3  # rad, of the highest order at an end of the record: two starts that near lead to one end


def block_means(time: np.ndarray, values: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Means of times and values (B,) over blocks of as many successive samples as fit into a time, B the whole blocks.

    Blocks in which the record has a gap are left out. An order loses less than 2 % of its amplitude where a block is a tenth of
    its period.
    """
    size = int(longest * (len(time) - 1) / (time[-1] - time[0]))
    if size < 2:
        return time, values
    count = len(time) // size
    times, means = (a[: count * size].reshape(count, size) for a in (time, values))
    whole = times[:, -1] - times[:, 0] <= 2 * longest
    return times[whole].mean(axis=1), means[whole].mean(axis=1)


def mean_speed(time: np.ndarray, values: np.ndarray, mean: Mean) -> float:
    """omega from the values under a Hann window, which orders hardly touch, however many turns the record has."""
    t, y = block_means(time, values, (time[-1] - time[0]) / _COARSE)
    share = (t - time[0]) / (time[-1] - time[0])
    weights = np.sin(math.pi * share) ** 2 * np.gradient(t)
    weights /= weights.sum()
    level = float(weights @ y)
    if mean is not Mean.ANGLE:
        return level
    off = t - weights @ t
    return float((weights * off) @ (y - level) / ((weights * off) @ off))


def middle(time: np.ndarray, values: np.ndarray, span: float) -> tuple[np.ndarray, np.ndarray]:
    """The samples within a span about time zero."""
    inside = np.abs(time) <= span / 2
    return time[inside], values[inside]


def start(model: OrderModel, time: np.ndarray, values: np.ndarray, omega: float) -> Fit:
    """A fit near that of all samples, from blocks of them: the better one of two.

    One begins with omega for the whole record. The other begins with a few turns in its middle and goes on to parts twice as
    long, until the speed is so well known that the highest order stays in phase to the ends of the record.
    """
    span = float(time[-1] - time[0])
    grown, part, to_phase = _from(model, omega), _FIRST_TURNS * 2 * math.pi / omega, float(model.orders[-1]) * span / 2
    while part < span:
        t, y = middle(time, values, part)
        if len(t) > 2 * model.size:
            fit = model.fit(t, y, grown, _SMALL, _MOST)
            known = fit.converged and omega / 2 < fit.theta[0] < 2 * omega
            if known and max(_error(fit), abs(fit.theta[0] - omega) / 10) * to_phase < _IN_PHASE / 10:
                return fit
            grown = fit.theta if known else _from(model, omega)
        part *= _LONGER
    best = model.fit(time, values, grown, _SMALL, _MOST)
    if best.converged and abs(best.theta[0] - omega) * to_phase < _IN_PHASE:
        return best
    other = model.fit(time, values, _from(model, omega), _SMALL, _MOST)
    return min(best, other, key=lambda f: (not f.converged, f.squares))


def _error(fit: Fit) -> float:
    """Of omega, if it depended on nothing else: the least that it can be."""
    return float((fit.variance / fit.gram[0, 0]) ** 0.5) if fit.gram[0, 0] > 0 else math.inf


def _from(model: OrderModel, omega: float) -> np.ndarray:
    theta = np.zeros(model.size)
    theta[0] = omega
    if model.mean is Mean.FREE:
        theta[1] = omega
    return theta
