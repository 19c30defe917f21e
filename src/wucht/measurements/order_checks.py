"""Checks of fitted orders: the capacity of a record, its content beside the orders, and sensor faults that imitate them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.errors import InputError
from wucht.measurements.order_regression import Fit, Mean, OrderModel, powers
from wucht.measurements.shaft_signal import TURN, ShaftSignal
from wucht.numerics.fourier_series import FourierSeries

_GAP = 10.0  # times the median step
_NYQUIST = 2.02  # samples a period, and a little, for the speed is not yet known well
_STANDS = 0.05  # turns: so few are none
_FAR = 5.0  # times as far from the median as all samples but few: one that sticks out
_FEW = 0.01  # of the samples may stick out
_LARGE = 0.2  # of the median: a smaller distance does no harm
_AT_ONCE = 8192
_ERRORS = 3.0  # standard errors: a larger order is significant
_ROUNDING = 1e-9  # of omega: an order below is none
_MATTERS = 1e-3  # of omega: an order that is left out
_SHARE = 0.05  # of the residual's square, by a drift
_HALF = 0.5  # of a fluctuation, or of what is left of it
_ROUGH = 1.0  # of block means: smoother ones are no noise
_ROUGH_SAMPLES = 0.5  # of samples, likewise; these may be few in a period


def check_samples(shaft: ShaftSignal, omega: float, orders: np.ndarray) -> None:
    """Raise ``InputError`` for a record that cannot hold the orders (K,) at about omega in rad/s."""
    location, count, span = shaft.location, len(shaft.time), float(np.ptp(shaft.time))
    turns = omega * span / TURN
    if -_STANDS < turns <= 0:
        explanation = (
            f"the shaft stands still: {omega:.4g} rad/s on average, {turns:.2g} turns in {span:.4g} s; "
            "are column and unit right?"
        )
        raise InputError(location, None, explanation, code="stands-still")
    if turns < 0:
        explanation = (
            f"the shaft turns backwards ({omega:.4g} rad/s on average): reverse the sign with the key scale, as in scale = -1"
        )
        raise InputError(location, None, explanation, code="turns-back")
    if turns < 1:
        summary = f"the record is shorter than a turn ({turns:.2g} turns at {omega:.4g} rad/s)"
        explanation = f"{summary}: record several turns, or check the unit of the speed"
        raise InputError(location, None, explanation, code="too-short")
    steps = np.diff(shaft.time)
    longest = int(steps.argmax())
    if steps[longest] > _GAP * float(np.median(steps)) and steps[longest] * omega > TURN:
        explanation = (
            f"there is a gap of {steps[longest]:.4g} s, {steps[longest] * omega / TURN:.3g} turns, after "
            f"{shaft.time[longest]:.6g} s: cut the record to one side of it"
        )
        raise InputError(location, None, explanation, code="gap")
    highest, parameters = int(orders[-1]), 3 + 2 * len(orders)
    a_turn = (count - 1) / turns
    if a_turn < _NYQUIST * highest or count < parameters:
        requirement = (
            f"order {highest} needs more than {2 * highest}"
            if count >= parameters
            else f"these orders need {parameters} samples in all"
        )
        units = "; are the units of time and speed right?" if a_turn < _NYQUIST else ""
        raise InputError(
            f"{location}: orders", orders.tolist(), f"there are {a_turn:.3g} samples a turn, and {requirement}{units}"
        )


def check_outliers(shaft: ShaftSignal) -> None:
    """Raise ``InputError`` for outliers of a speed, and name the farthest: one of them falsifies the mean."""
    if shaft.quantity != "speed":
        return
    median = float(np.median(shaft.values))
    deviation = np.abs(shaft.values - median)
    usual = float(np.quantile(deviation, 1 - _FEW))
    out = np.flatnonzero(deviation > max(_FAR * usual, _LARGE * abs(median)))
    if len(out):
        i = int(deviation.argmax())
        more_outliers = f" further outliers: {len(out) - 1};" if len(out) > 1 else ""
        explanation = (
            f"sample {i + 1}, at {shaft.time[i]:.6g} s, is an outlier: it is "
            f"{shaft.format_speed(float(shaft.values[i]))}, and the "
            f"median of all is {shaft.format_speed(median)};{more_outliers} take such samples out"
        )
        raise InputError(shaft.location, None, explanation)


@dataclass(frozen=True)
class OmittedOrder:
    """An order not fitted. amplitude: of the speed in rad/s. error: its standard error. share: of the residual's square.

    Each is fitted to the residual alone: in a record of few turns an order also takes what belongs to its neighbours.
    """

    order: int
    amplitude: float
    error: float
    share: float


def fit_omitted_orders(
    model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray, orders: np.ndarray, samples: int
) -> tuple[OmittedOrder, ...]:
    """Fit the orders (L,), increasing, to the residual. time, values (B,): block means of so many samples."""
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
        OmittedOrder(int(j), float(k * abs(w)), float(k * (2 * variance / samples) ** 0.5), float(p / variance))
        for j, k, w, p in zip(orders, per_unit, wave, power, strict=True)
    )


def drift(model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Return the rise of the speed over the record, in rad/s, and its share of the residual's square."""
    rest = _rest(model, fit, time, values)
    course = time**2 / 2 if model.mean is Mean.ANGLE else time
    course = course - course.mean()
    slope = float(course @ rest / (course @ course))
    share = slope**2 * float(np.mean(course**2)) / fit.variance if fit.variance > 0 else 0.0
    return slope * float(time[-1] - time[0]), share


def roughness(model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray) -> float:
    """Return the mean square of successive differences of the residual over that of its values: 2 for noise, less if smooth.

    time, values (B,): samples, or block means.
    """
    rest = _rest(model, fit, time, values)
    power = float(np.mean((rest - rest.mean()) ** 2))
    return float(np.mean(np.diff(rest) ** 2)) / power if power > 0 else 2.0


def _rest(model: OrderModel, fit: Fit, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    starts = range(0, len(time), _AT_ONCE)
    return np.concatenate([model.rows(time[i : i + _AT_ONCE], values[i : i + _AT_ONCE], fit.theta)[-1] for i in starts])


def warnings_of(
    speed: FourierSeries,
    orders: tuple[int, ...],
    errors: np.ndarray,
    omitted_orders: tuple[OmittedOrder, ...],
    speed_drift: tuple[float, float],
) -> tuple[str, ...]:
    """Return sentences on what to check: orders 1 and 2 that a sensor may imitate, or that are omitted, and a drifting speed.

    errors (K,): of the amplitudes of the orders. speed_drift: in rad/s, and its share of the residual's square.
    """
    texts, omega = [], speed.mean
    for order in (1, 2):
        if order in orders:
            amplitude = float(speed.amplitudes[order - 1])
            if amplitude > max(_ERRORS * errors[orders.index(order)], _ROUNDING * omega):
                texts.append(_kept_order_warning(order, amplitude / omega))
        else:
            omitted_order = next((o for o in omitted_orders if o.order == order), None)
            if omitted_order and omitted_order.amplitude > max(_ERRORS * omitted_order.error, _MATTERS * omega):
                texts.append(_omitted_order_warning(order, omitted_order.amplitude / omega))
    if has_drift(omega, speed_drift):
        texts.append(
            f"The speed drifts by {speed_drift[0]:+.3g} rad/s over the record, which orders of one constant "
            "speed cannot follow: "
            "cut the record to a part of constant mean speed."
        )
    return tuple(texts)


def has_drift(omega: float, speed_drift: tuple[float, float]) -> bool:
    """True if a speed drifts. speed_drift: in rad/s, and its share of the residual's square."""
    return speed_drift[1] > _SHARE and abs(speed_drift[0]) > _MATTERS * omega


def unexplained_warning(
    explained_share: float, rough: tuple[float, float], omitted_orders: tuple[OmittedOrder, ...], drift_share: float
) -> tuple[str, ...]:
    """Return a sentence if the orders kept explain less than half of a fluctuation that is no noise, drift or other order.

    rough: of the residual, of block means and of samples, see ``roughness``. drift_share: of its square, by a drift.
    """
    omitted_share = sum(o.share for o in omitted_orders if o.amplitude > _ERRORS * o.error)
    noise = rough[0] > _ROUGH and rough[1] > _ROUGH_SAMPLES
    if explained_share > _HALF or noise or omitted_share > _HALF or drift_share > _HALF:
        return ()
    return (
        f"The orders kept explain {_percent(explained_share)} of the fluctuation, and the rest is neither "
        "noise from sample to sample, nor "
        "drift, nor in another whole order: it does not repeat with the speed that the numbers give. Check unit and scale, for "
        "pulses pulses_per_turn, and whether this is the shaft of the cam.",
    )


def _kept_order_warning(order: int, share: float) -> str:
    return (
        f"Order {order} is {_percent(share)} of the speed and is kept. {_sensor_hint(order, share)} before it is corrected for."
    )


def _omitted_order_warning(order: int, share: float) -> str:
    text = f"Order {order} is left out, but the record holds {_percent(share)} of the speed in it."
    if order == 1:
        text += (
            f" If the shaft really turns like this, a correction without it leaves about {_percent(9 * share)} "
            "of the motion as it was."
        )
    return f"{text} {_sensor_hint(order, share)} before it is left out."


def _sensor_hint(order: int, share: float) -> str:
    if order == 1:
        return (
            f"An encoder off centre by {_percent(share)} of its radius shows the same: check its run-out, or read it with two "
            "heads opposite each other,"
        )
    angle = math.degrees(math.sqrt(2 * share))
    return (
        f"A cardan (universal) joint bent by {angle:.2g} deg between shaft and encoder shows the same: check how the encoder "
        "is coupled,"
    )


def _percent(share: float) -> str:
    return f"{float(f'{100 * share:.2g}'):g} %"
