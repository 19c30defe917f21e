"""Orders of a shaft's speed, by least squares over any span of a record and any times: never by bins of a cut record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import InputError
from wucht.measurements.order_checks import (
    OmittedOrder,
    check_outliers,
    check_samples,
    drift,
    fit_omitted_orders,
    roughness,
    unexplained_warning,
    warnings_of,
)
from wucht.measurements.order_regression import (
    START_BLOCKS,
    Fit,
    Mean,
    OrderModel,
    block_means,
    initial_fit,
    mean_speed,
    middle,
    scaled_gram,
)
from wucht.measurements.repetition import check_repetition, scale_warning
from wucht.measurements.shaft_signal import TURN, ShaftSignal, mean_direction
from wucht.numerics.fourier_series import FourierSeries

_RESIDUAL_BLOCKS = 24  # a period of the highest order that is searched for
_RESIDUAL_TURNS = 200.0  # in the middle of the record: enough
_SINGULAR = 1e-9  # least eigenvalue of the correlations: below, orders cannot be distinguished
_MOST_LEFT_OUT = 20  # orders are searched for in the residual up to this, or twice the highest one fitted
_INDEX_EVERY = (0.9, 1.1)  # turns
_SCATTER = 0.01  # rad, of the index pulses
_MOST_STEPS = 50


@dataclass(frozen=True, eq=False)
class OrderFit:
    """The speed of a shaft: omega + sum over orders of a_j cos(j x) + b_j sin(j x), x = omega (t - origin).

    Attributes
    ----------
    location : str
        File and column.
    orders : tuple of int, K
        Those fitted, increasing.
    speed : FourierSeries
        In rad/s over x; its mean is omega, other orders are zero.
    covariance : numpy.ndarray, (1 + 2K, 1 + 2K)
        Of omega, a, b, if the residual is noise, independent from sample to sample.
    origin : float
        Time in s at which x is zero.
    offset : float
        C in rad of the angle omega (t - origin) + C + sum (a_j sin(j x) - b_j cos(j x))/(j omega).
    turns, samples : float and int
        Of the record.
    unit : str
        Of the signal.
    kept_rms, residual_rms : float
        Of the orders and of the residual, in ``unit``.
    omitted_orders : tuple of OmittedOrder
        Those not fitted, in the residual.
    warnings : tuple of str
        Sentences on what to check.
    """

    location: str
    orders: tuple[int, ...]
    speed: FourierSeries
    covariance: np.ndarray
    origin: float
    offset: float
    turns: float
    samples: int
    unit: str
    kept_rms: float
    residual_rms: float
    omitted_orders: tuple[OmittedOrder, ...]
    warnings: tuple[str, ...]

    @property
    def cosine(self) -> np.ndarray:
        """a_j (K,) of the orders fitted, in rad/s."""
        return np.asarray(self.speed.cosine[np.array(self.orders) - 1])

    @property
    def sine(self) -> np.ndarray:
        """b_j (K,) of the orders fitted, in rad/s."""
        return np.asarray(self.speed.sine[np.array(self.orders) - 1])

    @property
    def standard_errors(self) -> np.ndarray:
        """Standard errors of omega, a, b (1 + 2K,), in rad/s."""
        return np.asarray(np.sqrt(self.covariance.diagonal()))

    @property
    def amplitude_errors(self) -> np.ndarray:
        """The standard error of an order's amplitude (K,), in rad/s: the greatest in any phase."""
        k, n = np.arange(1, len(self.orders) + 1), len(self.orders)
        blocks = np.array([self.covariance[np.ix_([i, i + n], [i, i + n])] for i in k])
        return np.asarray(np.sqrt(np.linalg.eigvalsh(blocks)[:, -1]))

    @property
    def explained_share(self) -> float:
        """The share of the fluctuation's variance that the orders explain."""
        total = self.kept_rms**2 + self.residual_rms**2
        return self.kept_rms**2 / total if total > 0 else 1.0

    def notable(self, share: float = 0.05) -> tuple[OmittedOrder, ...]:
        """Return the omitted orders that hold more than a share of the residual's square."""
        return tuple(o for o in self.omitted_orders if o.share > share)

    def angle(self, time: np.ndarray) -> np.ndarray:
        """Return the angle in rad at times in s."""
        x, j = self.speed.mean * (np.asarray(time, float) - self.origin), np.arange(1, self.speed.count + 1)
        return np.asarray(
            x + self.offset + FourierSeries(0.0, -self.speed.sine / j, self.speed.cosine / j)(x) / self.speed.mean
        )

    def with_origin(self, origin: float) -> OrderFit:
        """Return the same motion with phases counted from another time in s."""
        time_shift, n, j = origin - self.origin, len(self.orders), np.array(self.orders)
        shifted_speed = self.speed.shift(-self.speed.mean * time_shift)
        shifted_fit = replace(self, speed=shifted_speed, origin=origin, offset=self.offset + self.speed.mean * time_shift)
        c, s = np.diag(np.cos(j * self.speed.mean * time_shift)), np.diag(np.sin(j * self.speed.mean * time_shift))
        change = np.eye(1 + 2 * n)
        change[1:, 1:] = np.block([[c, s], [-s, c]])
        change[1:, 0] = time_shift * np.concatenate([j * shifted_fit.sine, -j * shifted_fit.cosine])
        return replace(shifted_fit, covariance=change @ self.covariance @ change.T)

    def time_of_angle(self, angle: float = 0.0, after: float | None = None) -> float:
        """Return the first time in s, from ``after`` (by default the origin), at which the angle is this, up to whole turns."""
        from_time = self.origin if after is None else after
        start_angle = float(self.angle(np.array(from_time)))
        target_angle = start_angle + (angle - start_angle) % TURN
        time = from_time + (target_angle - start_angle) / self.speed.mean
        for _ in range(_MOST_STEPS):
            x = self.speed.mean * (time - self.origin)
            step = (target_angle - float(self.angle(np.array(time)))) / max(float(self.speed(x)), 0.1 * self.speed.mean)
            time += step
            if abs(step) * self.speed.mean < 1e-14 * max(1.0, abs(target_angle)):
                break
        return time


def fit_orders(
    shaft: ShaftSignal, orders: Sequence[int], origin: float | None = None, look_up_to: int | None = None
) -> OrderFit:
    """Fit chosen orders of a speed or an angle by least squares, with omega = 2 pi/T unknown.

    Parameters
    ----------
    shaft : ShaftSignal
    orders : sequence of int
        Different whole numbers from 1.
    origin : float, optional
        The time in s at which phases are zero; by default that of the first index pulse, at which then the angle is zero too,
        and without one 0 s of the record's clock.
    look_up_to : int, optional
        The highest order that is searched for in the residual.

    Returns
    -------
    OrderFit

    Raises
    ------
    InputError
        For orders that are no whole numbers from 1, a record shorter than a turn, in which whole turns are missing, with too
        few samples a turn or outliers, a shaft that stands or turns backwards, numbers that repeat as if they were in another
        unit, and orders that cannot be distinguished.
    """
    chosen = checked_orders(orders)
    check_outliers(shaft)
    model = OrderModel(chosen, Mean.SPEED if shaft.quantity == "speed" else Mean.ANGLE)
    centre = float(shaft.time[0] + shaft.time[-1]) / 2
    time = shaft.time - centre
    omega = mean_speed(time, shaft.values, model.mean)
    suspicions = check_repetition(shaft, omega, chosen)
    check_samples(shaft, omega, chosen)
    blocks = block_means(time, shaft.values, TURN / omega / chosen[-1] / START_BLOCKS)
    first = initial_fit(model, *blocks, omega)
    fit = model.fit(time, shaft.values, first.theta)
    _check_fit(shaft, model, fit, omega)
    result = _with_index_origin(_result(shaft, model, fit, centre), shaft.index, origin)
    most = max(_MOST_LEFT_OUT, 2 * result.orders[-1]) if look_up_to is None else look_up_to
    omitted_orders = _omitted_orders(shaft, model, fit, time, most)
    speed_drift = drift(model, fit, *blocks)
    notes = suspicions or scale_warning(shaft, chosen, result.speed.mean)
    if not notes:
        samples = middle(time, shaft.values, _RESIDUAL_TURNS * TURN / result.speed.mean)
        rough = roughness(model, fit, *blocks), roughness(model, fit, *samples)
        notes = unexplained_warning(result.explained_share, rough, omitted_orders, speed_drift[1])
    texts = warnings_of(result.speed, result.orders, result.amplitude_errors, omitted_orders, speed_drift)
    return replace(result, omitted_orders=omitted_orders, warnings=shaft.warnings + result.warnings + notes + texts)


def checked_orders(orders: Sequence[int]) -> np.ndarray:
    """Return the orders chosen (K,), increasing. Raises ``InputError`` for none, a repeated one, or no whole number from 1."""
    explanation = "the orders must be different whole numbers, 1 or more, such as [2, 3, 4]"
    whole = all(not isinstance(j, bool) and isinstance(j, int | np.integer) and j >= 1 for j in orders)
    if not len(orders) or not whole or len(set(orders)) < len(orders):
        raise InputError("orders", list(orders), explanation)
    return np.array(sorted(int(j) for j in orders))


def _check_fit(shaft: ShaftSignal, model: OrderModel, fit: Fit, omega: float) -> None:
    if not fit.has_converged or not omega / 2 < fit.theta[0] < 2 * omega:
        explanation = (
            "no speed could be determined at which these orders repeat; cut the record to a part of constant mean speed"
        )
        raise InputError(shaft.location, None, explanation)
    correlations, _ = scaled_gram(fit.gram)
    values, vectors = np.linalg.eigh(correlations)
    if values[0] < _SINGULAR:
        share = np.abs(vectors[model.fixed_count :, 0]).reshape(2, -1).max(axis=0)
        similar_orders = [int(j) for j, s in zip(model.orders, share, strict=True) if s > 0.2 * share.max()]
        turns = fit.theta[0] * float(np.ptp(shaft.time)) / TURN
        explanation = (
            f"these orders cannot be distinguished in a record of {turns:.3g} turns: choose fewer, or record more turns"
        )
        raise InputError(f"{shaft.location}: orders", similar_orders, explanation)


def _result(shaft: ShaftSignal, model: OrderModel, fit: Fit, centre: float) -> OrderFit:
    """Return the result with phases from the middle of the record, where omega was fitted."""
    omega, j, n = float(fit.theta[0]), model.orders, len(model.orders)
    waves = model.waves(fit.theta)
    u, v = waves.real, -waves.imag
    change = np.zeros((1 + 2 * n, model.size))
    change[0, 0] = 1.0
    if model.mean is Mean.SPEED:
        a, b, change[1:, 1:] = u, v, np.eye(2 * n)
    else:
        a, b = j * omega * v, -j * omega * u
        scale, zeros = np.diag(j * omega), np.zeros((n, n))
        change[1:, 2:] = np.block([[zeros, scale], [-scale, zeros]])
        change[1:, 0] = np.concatenate([j * v, -j * u])
    correlations, lengths = scaled_gram(fit.gram)
    inverse = fit.variance * np.linalg.inv(correlations) / np.outer(lengths, lengths)
    cosine, sine = np.zeros((2, j[-1]))
    cosine[j - 1], sine[j - 1] = a, b
    return OrderFit(
        location=shaft.location, orders=tuple(int(k) for k in j), speed=FourierSeries(omega, cosine, sine),
        covariance=change @ inverse @ change.T, origin=centre, offset=float(fit.theta[1]) if model.mean is Mean.ANGLE else 0.0,
        turns=omega * float(np.ptp(shaft.time)) / TURN, samples=fit.samples,
        unit="rad/s" if model.mean is Mean.SPEED else "rad", kept_rms=float(np.linalg.norm(waves)) / 2**0.5,
        residual_rms=fit.variance**0.5, omitted_orders=(), warnings=(),
    )  # fmt: skip


def _with_index_origin(fit: OrderFit, index: np.ndarray, origin: float | None) -> OrderFit:
    """Count phases, and with an index also the angle, from their origin."""
    if not len(index):
        return fit.with_origin(0.0 if origin is None else origin)
    every = np.diff(index) * fit.speed.mean / TURN
    low, high = _INDEX_EVERY
    if ((every < low) | (every > high)).any():
        explanation = f"the index pulse must come once a turn; it comes after {every.min():.3g} to {every.max():.3g} turns"
        raise InputError(f"{fit.location}: index", None, explanation)
    angles = fit.angle(index)
    zero = mean_direction(angles)
    first = fit.time_of_angle(zero, after=float(index[0]) - TURN / fit.speed.mean / 2)
    scatter = float(np.std(np.angle(np.exp(1j * (angles - zero)))))
    text = f"The index pulses scatter by {math.degrees(scatter):.2g} deg: no phase is better known than that."
    warnings = (text,) if scatter > _SCATTER else ()
    result = replace(fit, offset=fit.offset - float(fit.angle(np.array(first))), warnings=warnings)
    return result.with_origin(first if origin is None else origin)


def _omitted_orders(shaft: ShaftSignal, model: OrderModel, fit: Fit, time: np.ndarray, most: int) -> tuple[OmittedOrder, ...]:
    """Return the orders that were not fitted, as far as they are searched for and the samples can hold them."""
    turn = TURN / float(fit.theta[0])
    most = min(most, math.ceil(len(time) * turn / float(np.ptp(time)) / 2) - 1)
    orders = np.array([j for j in range(1, most + 1) if j not in model.orders], int)
    t, y = middle(time, shaft.values, _RESIDUAL_TURNS * turn)
    blocks = block_means(t, y, turn / max(1, most) / _RESIDUAL_BLOCKS)
    return fit_omitted_orders(model, fit, *blocks, orders, len(t))
