"""What is stated of the records of a correction: of the speed of the shaft, and of the acceleration of the output."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np

from wucht.cams.correction import residual_of_all, residual_of_errors
from wucht.cams.drive import CamDrive
from wucht.cams.measured_acceleration import MeasuredAcceleration
from wucht.cams.shaft_motion import ShaftMotion
from wucht.measurements.order_checks import OmittedOrder
from wucht.measurements.order_fit import OrderFit
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import pad_orders

_MATTERS, _ERRORS = 1e-3, 3.0  # of the mean speed, and standard errors: an order left out that is warned of
_WARNED_ORDERS = (1, 2)  # orders that the fit itself warns of
_DRIFTS = 1e-3  # of omega: differs from the stated speed
_LITTLE = 0.5  # of the mean square: a smaller explained share is warned of
_FEW = 4  # orders listed with details
_NOTHING = 1e-4  # of order 1
_SAMPLES = 3000  # of a record, shown in the figure
_RPM = 30 / math.pi


def state_record(a: Answer, drive: CamDrive, left_out: Mapping[OmittedOrder, float], residuals: Mapping[str, float]) -> None:
    """State the fit to the record of the speed, what its errors and the orders that are left out leave, and what to check.

    residuals: under deviating conditions.
    """
    what, fit, speed = "orders fitted to the record", drive.speed_fit, drive.speed
    if fit is None or speed is None:
        a.number("record", None, what)
        return
    from_errors = residual_of_errors(fit, residuals)
    with a.group("record", what):
        a.number("orders", list(fit.orders), "orders fitted")
        a.number("turns", fit.turns, "number of turns")
        a.number("samples", fit.samples, "number of samples")
        a.number("explained", fit.explained_share, "explained share of the variance")
        a.number("residual_rms", fit.residual_rms, "root mean square of the residual", fit.unit)
        a.number("unit", fit.unit, "unit of the record")
        a.number("mean_error", float(fit.standard_errors[0]), "standard error of the mean speed", "rad/s")
        a.number("zero", fit.origin, "time at which the first turn begins", "s")
        a.number("left_by_errors", from_errors, "residual due to the standard errors, as a share")
        share = residual_of_all(left_out)
        a.number("left_by_left_out", share, "residual due to the orders left out, as a share")
        parts = {"amplitude": ("amplitude of the speed", "rad/s"), "error": ("standard error of the amplitude", "rad/s")}
        rows = [asdict(one) | {"share": residual} for one, residual in left_out.items()]
        a.number("left_out", rows, "orders left out", parts=parts)
    rest = f"{math.degrees(fit.residual_rms):.3g}°" if fit.unit == "rad" else f"{_RPM * fit.residual_rms:.3g} rpm"
    omitted_clause = f"the orders left out {_about(share)}" if left_out else "no order left out matters"
    a.line(
        "record",
        f"{fit.turns:.3g} turns, {fit.samples} samples, orders explain {100 * fit.explained_share:.2f} %, {rest} rms left; "
        f"the noise leaves {_about(from_errors)}, {omitted_clause}",
    )
    mean = drive.shaft_motion.mean
    sizes = (
        f"order {one.order} ({_RPM * one.amplitude:.3g} rpm, {percent_text(one.amplitude / mean)} of the speed), which leaves "
        f"{percent_text(residual)}"
        for one, residual in [*left_out.items()][:_FEW]
    )
    if left_out:
        a.line("left out", "; ".join(sizes))
    a.warn(*fit.warnings)
    has_zero = fit.unit == "rad" and speed.pulses_per_turn is None  # an angle defines its zero
    if speed.index is None and not has_zero:
        a.warn(
            f"The record has no index pulse: cam angle zero is taken to be at {fit.origin:.6g} s. The phase of the speed "
            "against the cam matters; the first line 'deviation' states the effect of one degree."
        )
    for one in fit.notable():
        if one.order not in _WARNED_ORDERS and one.amplitude > max(_ERRORS * one.error, _MATTERS * fit.speed.mean):
            percentage = 100 * (one.amplitude / fit.speed.mean)
            a.warn(f"Order {one.order} is left out, but the record holds {percentage:.2f} % of the speed in it.")


def state_speed_orders(a: Answer, shaft: ShaftMotion, fit: OrderFit | None) -> None:
    """State the orders of the speed with their errors, and those of the record that are left out."""
    speed, left_out, over, left_over = shaft.speed, () if fit is None else fit.omitted_orders, "speed_order", "left_out_order"
    errors = np.full((3, speed.count), np.nan)
    if fit is not None:
        errors[:, np.array(fit.orders) - 1] = [*np.split(fit.standard_errors[1:], 2), fit.amplitude_errors]
    a.curve("speed_order", np.arange(1, speed.count + 1), "order of the speed")
    a.curve("left_out_order", [one.order for one in left_out], "order of the speed left out")
    a.curve("speed_cosine", speed.cosine, "cosine coefficient of the speed", "rad/s", over)
    a.curve("speed_sine", speed.sine, "sine coefficient of the speed", "rad/s", over)
    a.curve("speed_amplitude", speed.amplitudes, "speed, amplitude", "rad/s", over)
    a.curve("speed_cosine_error", errors[0], "standard error of the cosine coefficient", "rad/s", over)
    a.curve("speed_sine_error", errors[1], "standard error of the sine coefficient", "rad/s", over)
    a.curve("speed_error", errors[2], "standard error of the amplitude", "rad/s", over)
    a.curve("left_out_amplitude", [one.amplitude for one in left_out], "speed left out, amplitude", "rad/s", left_over)
    a.curve("left_out_error", [one.error for one in left_out], "standard error of the amplitude left out", "rad/s", left_over)


def warn_of_measurement(a: Answer, measurement: MeasuredAcceleration | None, cam: str, shaft: ShaftMotion) -> None:
    """Warn of what to check of the record of the acceleration, with the cam of this version, if there is one."""
    if measurement is None:
        return
    if abs(measurement.ratio - 1) > _DRIFTS:
        a.warn(
            f"The measured acceleration repeats at {measurement.ratio:.5g} times the mean speed of the shaft: check the speed."
        )
    if (share := measurement.share) < _LITTLE:
        a.warn(
            f"The motion computed for the {cam} cam explains {100 * max(share, 0.0):.0f} % of the measured acceleration: "
            "check its sign and unit (keys scale and unit), and that both records have one clock, or give "
            "study.acceleration.zero."
        )
    if measurement.enough_orders is not None:
        a.warn(
            f"Only {measurement.measured_orders.count} orders are fitted to the measured acceleration; the computed "
            f"motion has {100 * measurement.share_above:.0f} % of its root mean square above them. The residual is not noise, "
            f"and the speed of repetition is uncertain: take study.acceleration.orders = {measurement.enough_orders}."
        )
    if measurement.delay is not None:
        by, explained_share = measurement.delay
        a.warn(
            f"The measured acceleration comes {_delay_text(by, shaft)} than that computed for the {cam} cam; without it "
            f"{100 * explained_share:.1f} % of its orders would be explained. Check the delay of the sensor's filter, the "
            "cam's angle on its shaft, and the clocks of the records; study.acceleration.zero = "
            f'"{measurement.zero + by / shaft.mean:.6g} s" removes it.'
        )


def _delay_text(by: float, shaft: ShaftMotion) -> str:
    return f"{abs(math.degrees(by)):.3g}° ({abs(1e3 * by / shaft.mean):.3g} ms) {'later' if by > 0 else 'earlier'}"


def state_measurement(
    a: Answer,
    measurement: MeasuredAcceleration | None,
    cam: str,
    shaft: ShaftMotion,
    tau: np.ndarray,
    unit: str,
    shown_count: int,
) -> None:
    """State the measured acceleration beside the computed one, with the cam of this version; not numbers without a record."""
    per, what = f"{unit}/s^2", "measured acceleration, and the explained share"
    record_orders = computed_orders = FourierSeries.of(math.nan)
    if measurement is not None:
        record_orders, computed_orders = measurement.measured_orders, measurement.computed_orders
    over_time = record_orders(tau) - record_orders.mean if record_orders.count else tau + math.nan
    sample_tau, samples = (np.zeros(0), np.zeros(0)) if measurement is None else measurement.folded_samples(_SAMPLES)
    a.curve("measured_acceleration", over_time, "measured acceleration, orders fitted", per, "tau")
    a.curve("sample_tau", sample_tau, "time of a sample within a turn, as an angle", "rad", "sample")
    a.curve("sample_acceleration", samples, "measured acceleration, samples", per, "sample")
    for kind, orders in (("measured", record_orders), ("computed", computed_orders)):
        amplitudes = pad_orders(orders.amplitudes, shown_count)
        a.curve(f"{kind}_amplitude", amplitudes, f"{kind} acceleration, amplitude", per, "order")
    if measurement is None:
        a.number("measured", None, what)
        return
    share, noise, count = measurement.share, measurement.noise, record_orders.count
    explained_share = measurement.share_of_record(share)
    rms = math.sqrt(float((record_orders.amplitudes**2).sum()) / 2 + noise**2)
    delay, without = measurement.delay or (None, None)
    with a.group("measured", what):
        a.number("cam", cam, "cam of the measurement")
        a.number("explained", explained_share, "explained share of the variance of the whole record")
        a.number("explained_orders", share, "explained share of the variance of the fitted orders")
        a.number("noise_rms", noise, "root mean square outside the fitted orders", per)
        a.number("rms", rms, "root mean square of the record about its mean", per)
        a.number("turns", measurement.turns, "number of turns")
        a.number("orders", count, "number of orders fitted")
        a.number("zero", measurement.zero, "time at which the cam angle is zero", "s")
        a.number("delay", delay, "delay against the computed motion, as an angle", "rad")
        a.number("explained_without_delay", without, "share of its orders explained without the delay")
    fitted_text = f"{count} orders" if count > 1 else "1 order"
    explained_clause = f"{100 * max(explained_share, 0.0):.1f} % explained by the computed motion of the {cam} cam"
    rest = f"{noise:.4g} of {rms:.4g} {per} rms lie outside these"
    of_orders = f"{100 * max(share, 0.0):.1f} % of its {fitted_text}; {rest}"
    a.line("measured", f"{measurement.turns:.3g} turns: {explained_clause} ({of_orders})")
    if delay is not None and without is not None:
        late = f"it comes {_delay_text(delay, shaft)} than computed"
        a.line("", f"{late}; without it {100 * without:.1f} % of its orders would be explained")


def percent_text(share: float) -> str:
    """Return a share in percent, with two digits."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def _about(share: float) -> str:
    return f"less than {percent_text(_NOTHING)}" if share < _NOTHING else f"about {percent_text(share)}"
