"""Least squares of a signal that repeats at an unknown speed, sampled at any times; and their start.

y(t) = omega r(t) + C + sum over orders j of u_j cos(j omega t) + v_j sin(j omega t), where r = 1 for a speed (C = 0), r = t for
an angle, and r = 0 where the mean of a speed is left free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

_AT_ONCE = 1024  # samples: their rows stay in the cache, and are too few for BLAS to wake threads, which takes longer
_MOST = 40
_SHORTENINGS = 12
_SMALL = 1e-3  # of a standard error: a step that changes no result
_EPSILON = float(np.finfo(float).eps)
START_BLOCKS = 12  # a period of the highest order
_COARSE = 20_000  # blocks: enough for a mean
_FIRST_TURNS = 4.0  # in which no speed is so wrong that the highest order is out of phase
_LONGER = 2.0
_SMALL_OF_START, _MOST_OF_START = 0.03, 12  # of a standard error, and steps: a start need not be sharp
_IN_PHASE = 0.3  # rad, of the highest order at an end of the record: two starts that near lead to one end


class Mean(Enum):
    """Relation between the mean of the signal and omega."""

    SPEED = "omega"
    ANGLE = "omega t + C"
    FREE = "C"


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters theta (p,): omega, C if there is one, u, v. gram (p, p): of the derivatives. squares: of the residual."""

    theta: np.ndarray
    gram: np.ndarray
    gradient: np.ndarray
    squares: float
    samples: int
    has_converged: bool = True

    @property
    def variance(self) -> float:
        """The residual variance of a sample."""
        return self.squares / max(1, self.samples - len(self.theta))


@dataclass(frozen=True, eq=False)
class OrderModel:
    """Model of a signal by orders (K,), increasing whole numbers from 1."""

    orders: np.ndarray
    mean: Mean

    @property
    def fixed_count(self) -> int:
        """The number of parameters before those of the orders."""
        return 1 if self.mean is Mean.SPEED else 2

    @property
    def size(self) -> int:
        """The number of parameters, p."""
        return self.fixed_count + 2 * len(self.orders)

    def waves(self, theta: np.ndarray) -> np.ndarray:
        """Return u - i v (K,): the orders are the real parts of it times exp(i j omega t)."""
        u, v = theta[self.fixed_count :].reshape(2, -1)
        return np.asarray(u - 1j * v)

    def rows(self, time: np.ndarray, values: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Return derivatives by the parameters and, last, the residual of the values: (p + 1, n)."""
        rows, first, count = np.empty((self.size + 1, len(time))), self.fixed_count, len(self.orders)
        cosines, sines = rows[first : first + count], rows[first + count : -1]
        for i, wave in enumerate(powers(theta[0] * time, self.orders)):
            cosines[i], sines[i] = wave.real, wave.imag
        u, v = theta[first:].reshape(2, -1)
        rows[0] = time * ((self.orders * v) @ cosines - (self.orders * u) @ sines)
        rows[-1] = values - theta[first:] @ rows[first:-1]
        if self.mean is not Mean.SPEED:
            rows[1] = 1.0
            rows[-1] -= theta[1]
        if self.mean is not Mean.FREE:
            ramp = time if self.mean is Mean.ANGLE else 1.0
            rows[0] += ramp
            rows[-1] -= theta[0] * ramp
        return rows

    def normal_equations(self, time: np.ndarray, values: np.ndarray, theta: np.ndarray) -> Fit:
        """Return the normal equations at given parameters."""
        total = np.zeros((self.size + 1, self.size + 1))
        for i in range(0, len(time), _AT_ONCE):
            rows = self.rows(time[i : i + _AT_ONCE], values[i : i + _AT_ONCE], theta)
            total += rows @ rows.T
        return Fit(theta, total[:-1, :-1], total[:-1, -1], float(total[-1, -1]), len(time))

    def fit(self, time: np.ndarray, values: np.ndarray, theta: np.ndarray, small: float = _SMALL, most: int = _MOST) -> Fit:
        """Fit by Gauss-Newton steps from given parameters; a step that raises the squares is shortened.

        time (n,): best counted from the middle of the record, where omega and the phases do not depend on each other. small: of
        a standard error; a step no larger is the last one. most: steps.
        """
        current, largest, longest = (
            self.normal_equations(time, values, theta),
            float(np.abs(values).max()),
            float(np.abs(time).max()),
        )
        for _ in range(most):
            phase = self.orders[-1] * abs(current.theta[0]) * longest
            rounding = _EPSILON * (largest + phase * float(np.abs(self.waves(current.theta)).sum()))
            step = least_squares_step(current.gram, current.gradient)
            sizes = np.abs(step) * np.sqrt(current.gram.diagonal())
            if (sizes <= max(small * current.variance**0.5, rounding * len(time) ** 0.5)).all():
                squares = max(current.squares - float(current.gradient @ step), 0.0)
                return replace(current, theta=current.theta + step, squares=squares)
            for _ in range(_SHORTENINGS):
                trial = self.normal_equations(time, values, current.theta + step)
                if trial.squares <= current.squares:
                    break
                step = step / 4
            else:
                nothing_left = (
                    current.squares <= len(time) * (16 * rounding) ** 2 or current.gradient @ step <= 1e-9 * current.squares
                )
                return replace(current, has_converged=bool(nothing_left))
            current = trial
        return replace(current, has_converged=False)


def powers(phase: np.ndarray, orders: np.ndarray) -> list[np.ndarray]:
    """Return exp(i j phase) (n,) for increasing orders j, each from the one before it: sines cost more than products."""
    first = np.empty(len(phase), complex)
    first.real, first.imag = np.cos(phase), np.sin(phase)
    waves: list[np.ndarray] = []
    before, wave = 0, np.ones(len(phase), complex)
    for order in orders:
        wave = wave * (first if order == before + 1 else first ** int(order - before))
        before = order
        waves.append(wave)
    return waves


def scaled_gram(gram: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the correlations of the columns and their lengths; a column of zeros has length 1."""
    lengths = np.sqrt(gram.diagonal())
    lengths = np.where(lengths > 0, lengths, 1.0)
    return gram / np.outer(lengths, lengths), lengths


def least_squares_step(gram: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """Return the least-squares step, with columns scaled to length 1 first."""
    correlations, lengths = scaled_gram(gram)
    step, *_ = np.linalg.lstsq(correlations, gradient / lengths, rcond=1e-13)
    return np.asarray(step / lengths)


def block_means(time: np.ndarray, values: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return means of times and values (B,) over blocks of as many successive samples as fit into a time, B the whole blocks.

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
    """Return omega from the values under a Hann window, which orders hardly affect, however many turns the record has."""
    t, y = block_means(time, values, (time[-1] - time[0]) / _COARSE)
    share = (t - time[0]) / (time[-1] - time[0])
    weights = np.sin(math.pi * share) ** 2 * np.gradient(t)
    weights /= weights.sum()
    level = float(weights @ y)
    if mean is not Mean.ANGLE:
        return level
    deviation = t - weights @ t
    return float((weights * deviation) @ (y - level) / ((weights * deviation) @ deviation))


def middle(time: np.ndarray, values: np.ndarray, span: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples within a span about time zero."""
    inside = np.abs(time) <= span / 2
    return time[inside], values[inside]


def initial_fit(model: OrderModel, time: np.ndarray, values: np.ndarray, omega: float) -> Fit:
    """Return a fit near that of all samples, from blocks of them: the better one of two.

    One begins with omega for the whole record. The other begins with a few turns in its middle and continues with parts twice
    as long, until the speed is so well known that the highest order stays in phase to the ends of the record.
    """
    span = float(time[-1] - time[0])
    grown, part, phase_factor = (
        _initial_parameters(model, omega),
        _FIRST_TURNS * 2 * math.pi / omega,
        float(model.orders[-1]) * span / 2,
    )
    while part < span:
        t, y = middle(time, values, part)
        if len(t) > 2 * model.size:
            fit = model.fit(t, y, grown, _SMALL_OF_START, _MOST_OF_START)
            is_known = fit.has_converged and omega / 2 < fit.theta[0] < 2 * omega
            if is_known and max(_error(fit), abs(fit.theta[0] - omega) / 10) * phase_factor < _IN_PHASE / 10:
                return fit
            grown = fit.theta if is_known else _initial_parameters(model, omega)
        part *= _LONGER
    best = model.fit(time, values, grown, _SMALL_OF_START, _MOST_OF_START)
    if best.has_converged and abs(best.theta[0] - omega) * phase_factor < _IN_PHASE:
        return best
    alternative = model.fit(time, values, _initial_parameters(model, omega), _SMALL_OF_START, _MOST_OF_START)
    return min(best, alternative, key=lambda f: (not f.has_converged, f.squares))


def _error(fit: Fit) -> float:
    """The least possible standard error of omega: as if it depended on no other parameter."""
    return float((fit.variance / fit.gram[0, 0]) ** 0.5) if fit.gram[0, 0] > 0 else math.inf


def _initial_parameters(model: OrderModel, omega: float) -> np.ndarray:
    theta = np.zeros(model.size)
    theta[0] = omega
    if model.mean is Mean.FREE:
        theta[1] = omega
    return theta
