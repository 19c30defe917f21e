"""Spec and cam drive -> plan: law, shaft, cams before and after; records, among them measured accelerations by orders.

A record of the output's acceleration -> its orders about the shaft's speed, by least squares: the record need not be cut.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.correction import (
    AccelerationComparison,
    CorrectedLaw,
    MotionOverTime,
    Purity,
    compare_with_measurement,
    last_order_above,
)
from wucht.cams.correction import orders as orders_of
from wucht.cams.drive import CamDrive
from wucht.cams.dwells import dwells_of
from wucht.cams.elastic_output import Dwell
from wucht.cams.laws import Law
from wucht.cams.linkages.closure import Linkage
from wucht.cams.shaft_motion import ShaftMotion
from wucht.errors import InputError
from wucht.measurements.order_checks import check_samples
from wucht.measurements.order_fit import OrderFit
from wucht.measurements.order_regression import START_BLOCKS, Mean, OrderModel, block_means, initial_fit
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import Channel
from wucht.measurements.shaft_signal import TURN, ShaftSignal
from wucht.numerics.fourier_series import FourierSeries
from wucht.schema import Unit
from wucht.studies.cam_correction.spec import MOST_ORDERS, Acceleration, CamCorrection

_FREE_FROM = 3.0  # turns: a shorter record does not determine the speed at which it repeats
_NEAR = 0.01  # of omega: the same speed
_DRIFTS = 1e-3  # of omega: differs from the stated speed
_LITTLE = 0.5  # of the mean square: a smaller explained share is warned of
_UNITS = {"rad": Unit("rad/s^2", "angular acceleration"), "m": Unit("m/s^2", "acceleration")}
_DEFAULT_ORDERS = 60  # orders shown of a law with infinitely many
_MATTERS, _ERRORS = 1e-3, 3.0  # of the mean speed, and standard errors: an order left out that is warned of
_WARNED_ORDERS = (1, 2)  # orders that the fit itself warns of
_AGREES, _BETTER = 0.5, 0.005  # of the mean square: what a delay must explain at least, and how much more than none
_ABOVE = 0.1  # of the root mean square: a larger share of the computed motion above the fitted orders is warned of
Cams = Mapping[str, Cam]


@dataclass(frozen=True, eq=False)
class MeasuredAcceleration:
    """Measured acceleration beside the computed one.

    channel: the record in rad/s^2 or m/s^2. comparison: of its orders with the computed motion. cam: original or corrected.
    noise: root mean square of the residual, in the same unit. turns: of the record. notes: what to check, in sentences.
    """

    channel: Channel
    comparison: AccelerationComparison
    cam: str
    noise: float
    turns: float
    notes: tuple[str, ...]


def measured_acceleration(
    acceleration: Acceleration, folder: Path, unit: str, most: int, law: Law, shaft: ShaftMotion, zero: float
) -> MeasuredAcceleration:
    """Compare the record with the motion that the cam for ``law`` makes.

    unit: of the output. most: default number of fitted orders. law: over the cam angle. zero: default time at which the cam
    angle is zero. Raises ``InputError`` for a record that cannot be read, has another dimension, is
    shorter than a turn or has gaps or too few samples.
    """
    channel = _acceleration_channel(
        read_recording(folder / acceleration.file).channel(acceleration.column).correct(acceleration.unit, acceleration.scale),
        acceleration,
        unit,
    )
    orders = np.arange(1, (acceleration.orders or most) + 1)
    check_samples(ShaftSignal(channel.location, "speed", channel.time, channel.values), shaft.mean, orders)
    zero = zero if acceleration.zero is None else acceleration.zero
    series, noise, speed = _fit_orders(channel, orders, shaft.mean, zero)
    comparison = compare_with_measurement(series, law, shaft)
    turns = speed * float(np.ptp(channel.time)) / TURN
    return MeasuredAcceleration(
        channel, comparison, acceleration.cam, noise, turns, _notes(comparison, acceleration.cam, speed / shaft.mean)
    )


def _acceleration_channel(channel: Channel, acceleration: Acceleration, unit: str) -> Channel:
    """Convert the record to the output's unit/s^2. Raises ``InputError``, at the key of the unit if that is given."""
    if acceleration.radius is not None and unit != "rad":
        raise InputError(
            "study.acceleration.radius", acceleration.radius, "the output slides: there is no circle about an axis"
        )
    try:
        channel_si = channel.to_si(_UNITS[unit if acceleration.radius is None else "m"])
    except InputError as error:
        requirement = error.explanation
        if acceleration.radius is None and unit == "rad" and _is_straight(channel):
            requirement = "the output turns: give study.acceleration.radius, the distance of the sensor from the output's axis"
        is_given_unit = acceleration.unit is not None and error.value == acceleration.unit
        raise InputError("study.acceleration.unit" if is_given_unit else error.location, error.value, requirement) from None
    return channel_si if acceleration.radius is None else channel_si.with_scale(1 / acceleration.radius, "rad/s^2")


def _is_straight(channel: Channel) -> bool:
    """True if its unit is that of an acceleration along a path."""
    try:
        channel.to_si(_UNITS["m"])
    except InputError:
        return False
    return bool(channel.unit)


def _fit_orders(channel: Channel, orders: np.ndarray, omega: float, zero: float) -> tuple[FourierSeries, float, float]:
    """Return the orders with phases from the time zero on, the rms of the residual, and the speed at which they repeat."""
    model, centre = OrderModel(orders, Mean.FREE), float(channel.time[0] + channel.time[-1]) / 2
    time, theta = channel.time - centre, np.zeros(model.size)
    theta[0] = omega
    if omega * float(np.ptp(time)) > _FREE_FROM * TURN:
        first = initial_fit(model, *block_means(time, channel.values, TURN / omega / orders[-1] / START_BLOCKS), omega)
        fit = model.fit(time, channel.values, first.theta)
        theta[0] = fit.theta[0] if fit.has_converged and abs(fit.theta[0] / omega - 1) < _NEAR else omega
    fit = model.normal_equations(time, channel.values, theta)
    theta[1:], *_ = np.linalg.lstsq(fit.gram[1:, 1:], fit.gradient[1:], rcond=1e-13)
    residual_fit = model.normal_equations(time, channel.values, theta)
    waves = model.waves(theta)
    about_centre = FourierSeries(float(theta[1]), waves.real, -waves.imag)
    return about_centre.shift(theta[0] * (centre - zero)), residual_fit.variance**0.5, float(theta[0])


def _notes(comparison: AccelerationComparison, cam: str, ratio: float) -> tuple[str, ...]:
    notes: list[str] = []
    if abs(ratio - 1) > _DRIFTS:
        notes.append(f"The measured acceleration repeats at {ratio:.5g} times the mean speed of the shaft: check the speed.")
    if comparison.share < _LITTLE:
        notes.append(
            f"The motion computed for the {cam} cam explains {100 * max(comparison.share, 0.0):.0f} % of the measured "
            "acceleration: "
            "check its sign and unit (keys scale and unit), and that both records have one clock, or give "
            "study.acceleration.zero."
        )
    return tuple(notes)


@dataclass(frozen=True, eq=False)
class Plan:
    """Laws, shaft, cams and records of a correction.

    law, corrected_law: of the output over the cam angle, in ``unit``; levers: motion of the follower for both. purity: of the
    acceleration. orders: number of those examined; last_order: the last one that is not negligible with the original cam.
    dwells: of the law over time. closure: the linkage. before, after: the cams of both by name, none without a follower. fit:
    of the record of the speed. measurement: record of the acceleration, zero: the time in s of its clock at which the cam angle
    is zero. delay: of the record against the computed motion in rad of tau, and the share explained without it; None if not
    larger.
    """

    spec: CamCorrection
    drive: CamDrive
    law: Law
    corrected_law: CorrectedLaw
    levers: tuple[Law, Law]
    unit: str
    lever_unit: str
    purity: Purity
    orders: int
    last_order: int
    dwells: tuple[Dwell, ...]
    shaft: ShaftMotion
    closure: Linkage | None
    before: Cams
    after: Cams
    fit: OrderFit | None
    measurement: MeasuredAcceleration | None
    zero: float
    delay: tuple[float, float] | None
    notes: tuple[str, ...]

    @property
    def shown_orders(self) -> int:
        """Number of orders in the Dataset and its figure: those examined, and all that are measured or not negligible."""
        fitted_orders = 0 if self.measurement is None else self.measurement.comparison.measured_orders.count
        is_chosen = self.spec.orders is not None or self.purity.count is None  # infinitely many do not fit a figure
        return max(self.orders, fitted_orders, 0 if is_chosen else self.last_order)


def prepare(spec: CamCorrection, drive: CamDrive) -> Plan:
    """Return the plan.

    Raises ``InputError``: there is no such law, the output stands still, the motion of the shaft is not given, it turns back,
    a record cannot be used, or the linkage or the follower cannot make the motion.
    """
    motion_law, shaft, fit = drive.motion_law, drive.shaft_motion, drive.speed_fit
    purity = Purity.from_law(motion_law.function, motion_law.count)
    orders = spec.orders or 3 * (purity.count or _DEFAULT_ORDERS // 3)
    corrected_law = CorrectedLaw(motion_law.function, shaft)
    before, after = (
        ({}, {}) if drive.follower is None else (drive.make_cams(motion_law.function), drive.make_cams(corrected_law))
    )
    zero, record, delay, notes = 0.0 if fit is None else fit.origin, None, None, list(_record_notes(drive, fit))
    if spec.acceleration is not None:
        law = motion_law.function if spec.acceleration.cam == "original" else corrected_law
        record = _read_measurement(spec.acceleration, drive, orders, law, zero)
        zero, few = zero if spec.acceleration.zero is None else spec.acceleration.zero, _order_count_notes(record, law, shaft)
        delay = None if few else _delay(record)  # at a wrong speed the record is out of phase in any case
        notes += [*record.notes, *few, *_delay_notes(record, delay, shaft.mean, zero)]
    return Plan(
        spec=spec,
        drive=drive,
        law=motion_law.function,
        corrected_law=corrected_law,
        levers=(drive.follower_law(motion_law.function), drive.follower_law(corrected_law)),
        unit=motion_law.unit,
        lever_unit=motion_law.unit if drive.closure is None else "rad",
        purity=purity,
        orders=orders,
        last_order=min(last_order_above(orders_of(MotionOverTime(motion_law.function, shaft)).amplitudes), MOST_ORDERS),
        dwells=dwells_of(motion_law),
        shaft=shaft,
        closure=drive.closure,
        before=before,
        after=after,
        fit=fit,
        measurement=record,
        zero=zero,
        delay=delay,
        notes=tuple(notes),
    )


def _read_measurement(acceleration: Acceleration, drive: CamDrive, orders: int, law: Law, zero: float) -> MeasuredAcceleration:
    """Return the measured acceleration. Raises ``InputError``, at its key for a column without orders."""
    try:
        return measured_acceleration(acceleration, drive.folder, drive.motion_law.unit, orders, law, drive.shaft_motion, zero)
    except InputError as error:
        if error.location != "acceleration":
            raise
        raise InputError("study.acceleration.column", acceleration.column, error.explanation) from None


def _delay(record: MeasuredAcceleration) -> tuple[float, float] | None:
    """Return the delay of ``Plan``: only where it explains noticeably more, and most of the record."""
    delay, share = record.comparison.best_delay
    better = share > record.comparison.share + _BETTER and explained_share(record, share) > _AGREES
    return (delay, share) if better else None


def explained_share(record: MeasuredAcceleration, share: float) -> float:
    """Return the explained share of the whole record about its mean, from that of the mean square of its orders."""
    order_power = float((record.comparison.measured_orders.amplitudes**2).sum()) / 2
    return share * order_power / (order_power + record.noise**2)


def _delay_notes(record: MeasuredAcceleration, delay: tuple[float, float] | None, omega: float, zero: float) -> list[str]:
    """Return a note on a delay of the record. zero: time at which the cam angle is zero, in s."""
    if delay is None:
        return []
    by, share = delay
    delay_text = f"{abs(math.degrees(by)):.3g}° ({abs(1e3 * by / omega):.3g} ms) {'later' if by > 0 else 'earlier'}"
    return [
        f"The measured acceleration comes {delay_text} than that computed for the {record.cam} cam; without "
        f"it {100 * share:.1f} % of its "
        "orders would be explained. Check the delay of the sensor's filter, the cam's angle on its shaft, and the clocks of "
        f'the records; study.acceleration.zero = "{zero + by / omega:.6g} s" removes it.'
    ]


def _order_count_notes(record: MeasuredAcceleration, law: Law, shaft: ShaftMotion) -> list[str]:
    """Return a note where the computed motion has orders above the fitted ones."""
    count, powers = record.comparison.measured_orders.count, orders_of(MotionOverTime(law, shaft)).amplitudes ** 2
    above = np.sqrt(np.append(np.cumsum(powers[::-1])[::-1], 0.0) / powers.sum())  # above[n]: of orders from n + 1 on
    if above[count] <= _ABOVE:
        return []
    enough = int(np.argmax(above <= _ABOVE**2))
    return [
        f"Only {count} orders are fitted to the measured acceleration; the computed motion has {100 * above[count]:.0f} % of "
        f"its root mean square above them. The residual is not noise, and the speed of repetition is uncertain: "
        f"take study.acceleration.orders = {enough}."
    ]


def _record_notes(drive: CamDrive, fit: OrderFit | None) -> tuple[str, ...]:
    """Return what to check of the record of the speed, in sentences."""
    if fit is None or drive.speed is None:
        return ()
    notes = list(fit.warnings)
    has_zero = fit.unit == "rad" and drive.speed.pulses_per_turn is None  # an angle defines its zero
    if drive.speed.index is None and not has_zero:
        notes.append(
            f"The record has no index pulse: cam angle zero is taken to be at {fit.origin:.6g} s. The phase of the speed "
            "against the cam matters; the line 'left if' states the effect of one degree."
        )
    for left_out_order in fit.notable():
        if left_out_order.order not in _WARNED_ORDERS and left_out_order.amplitude > max(
            _ERRORS * left_out_order.error, _MATTERS * fit.speed.mean
        ):
            share = left_out_order.amplitude / fit.speed.mean
            notes.append(
                f"Order {left_out_order.order} is left out, but the record holds {100 * share:.2f} % of the speed in it."
            )
    return tuple(notes)
