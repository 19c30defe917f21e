"""What is left of a record when its orders are taken out: other orders, a drift, noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.measurements.order_regression import Fit, Mean, OrderModel, powers

_AT_ONCE = 8192


@dataclass(frozen=True)
class LeftOutOrder:
    """An order not fitted. amplitude: of the speed in rad/s. error: its standard error. share: of the residual's square.

    Each is fitted to the residual alone: in a record of few turns an order also takes what belongs to its neighbours.
    """

    order: int
    amplitude: float
    error: float
    share: float


def left_out_orders(
    model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray, orders: np.ndarray, samples: int
) -> tuple[LeftOutOrder, ...]:
    """The orders (L,), increasing, in the residual. time, values (B,): block means of so many samples."""
    if not len(orders) or fit.variance <= 0:
        return ()
    theta, variance = fit.theta, fit.variance
    omega, squares, products, total = theta[0], np.zeros(len(orders), complex), np.zeros(len(orders), complex), 0
    for i in range(0, len(time), _AT_ONCE):
        t = time[i : i + _AT_ONCE]
        rest = model.rows(t, values[i : i + _AT_ONCE], theta)[-1]
        waves = np.array(powers(omega * t, orders))
        squares += (waves * waves).sum(axis=1)
        products += waves @ rest
        total += len(t)
    # cos^2 and sin^2 are half the number of samples, more or less half the square of the wave.
    wave = 2 * (total * products - squares * products.conj()) / (total**2 - np.abs(squares) ** 2)
    power = (wave * products.conj()).real / total
    per_unit = orders * omega if model.mean is Mean.ANGLE else np.ones(len(orders))
    return tuple(
        LeftOutOrder(int(j), float(k * abs(w)), float(k * (2 * variance / samples) ** 0.5), float(p / variance))
        for j, k, w, p in zip(orders, per_unit, wave, power, strict=True)
    )


def drift(model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """By how much the speed rises over the record, in rad/s, and the share of the residual's square that this is."""
    rest = _rest(model, fit, time, values)
    course = time**2 / 2 if model.mean is Mean.ANGLE else time
    course = course - course.mean()
    slope = float(course @ rest / (course @ course))
    share = slope**2 * float(np.mean(course**2)) / fit.variance if fit.variance > 0 else 0.0
    return slope * float(time[-1] - time[0]), share


def roughness(model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray) -> float:
    """Of the residual: the mean square of successive differences over that of the values; 2 for noise, less for what is smooth.

    time, values (B,): samples, or block means.
    """
    rest = _rest(model, fit, time, values)
    power = float(np.mean((rest - rest.mean()) ** 2))
    return float(np.mean(np.diff(rest) ** 2)) / power if power > 0 else 2.0


def _rest(model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    starts = range(0, len(time), _AT_ONCE)
    return np.concatenate([model.rows(time[i : i + _AT_ONCE], values[i : i + _AT_ONCE], fit.theta)[-1] for i in starts])
