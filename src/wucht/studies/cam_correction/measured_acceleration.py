"""A record of the output's acceleration -> its orders about the shaft's speed, by least squares: the record need not be cut."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wucht.cams.correction import Comparison, compared
from wucht.cams.laws.law import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.errors import InputError
from wucht.measurements.order_checks import check_samples
from wucht.measurements.order_regression import START_BLOCKS, Mean, OrderModel, block_means, start
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import Channel
from wucht.measurements.shaft_signal import TURN, ShaftSignal
from wucht.numerics.harmonics import Harmonics
from wucht.schema import Unit
from wucht.studies.cam_correction.spec import Acceleration

_FREE_FROM = 3.0  # turns: in fewer the record does not say at which speed it repeats
_NEAR = 0.01  # of omega: the same speed
_DRIFTS = 1e-3  # of omega: another one than was said
_LITTLE = 0.5  # of the mean square is explained
_UNITS = {"rad": Unit("rad/s^2", "angular acceleration"), "m": Unit("m/s^2", "acceleration")}


@dataclass(frozen=True, eq=False)
class Measured:
    """channel: the record in rad/s^2 or m/s^2. comparison: of its orders with what the cam makes. cam: which one. noise: what
    is left of the record, root mean square, in the same unit. turns: of the record. notes: what to check, in sentences."""

    channel: Channel
    comparison: Comparison
    cam: str
    noise: float
    turns: float
    notes: tuple[str, ...]


def measured(asked: Acceleration, folder: Path, unit: str, most: int, law: Law, shaft: ShaftMotion, zero: float) -> Measured:
    """The record beside what the cam for ``law`` makes.

    unit: of the output. most: orders that are fitted if nothing is said. law: over the cam angle. zero: the time at which the
    cam angle is zero if nothing is said. Raises ``InputError`` for a record that cannot be read, has another dimension, is
    shorter than a turn or has gaps or too few samples.
    """
    channel = _in_unit(
        read_recording(folder / asked.file).channel(asked.column).corrected(asked.unit, asked.scale), asked, unit
    )
    orders = np.arange(1, (asked.orders or most) + 1)
    check_samples(ShaftSignal(channel.where, "speed", channel.time, channel.values), shaft.mean, orders)
    zero = zero if asked.zero is None else asked.zero
    found, noise, speed = _fitted(channel, orders, shaft.mean, zero)
    comparison = compared(found, law, shaft)
    turns = speed * float(np.ptp(channel.time)) / TURN
    return Measured(channel, comparison, asked.cam, noise, turns, _notes(comparison, asked.cam, speed / shaft.mean))


def _in_unit(channel: Channel, asked: Acceleration, unit: str) -> Channel:
    """In the output's unit/s^2. Raises ``InputError``, that of a unit that was given at its key."""
    if asked.radius is not None and unit != "rad":
        raise InputError("study.acceleration.radius", asked.radius, "the output slides: there is no circle about an axis")
    try:
        found = channel.in_si(_UNITS[unit if asked.radius is None else "m"])
    except InputError as error:
        allowed = error.allowed
        if asked.radius is None and unit == "rad" and _is_straight(channel):
            allowed = "the output turns: give study.acceleration.radius, the distance of the sensor from the output's axis"
        own = asked.unit is not None and error.given == asked.unit
        raise InputError("study.acceleration.unit" if own else error.where, error.given, allowed) from None
    return found if asked.radius is None else found.scaled(1 / asked.radius, "rad/s^2")


def _is_straight(channel: Channel) -> bool:
    """Whether its unit is one of an acceleration along a way."""
    try:
        channel.in_si(_UNITS["m"])
    except InputError:
        return False
    return bool(channel.unit)


def _fitted(channel: Channel, orders: np.ndarray, omega: float, zero: float) -> tuple[Harmonics, float, float]:
    """The orders, their phases from the time zero on, what is left of the samples, and the speed at which they repeat."""
    model, centre = OrderModel(orders, Mean.FREE), float(channel.time[0] + channel.time[-1]) / 2
    time, theta = channel.time - centre, np.zeros(model.size)
    theta[0] = omega
    if omega * float(np.ptp(time)) > _FREE_FROM * TURN:
        first = start(model, *block_means(time, channel.values, TURN / omega / orders[-1] / START_BLOCKS), omega)
        fit = model.fit(time, channel.values, first.theta)
        theta[0] = fit.theta[0] if fit.converged and abs(fit.theta[0] / omega - 1) < _NEAR else omega
    fit = model.at(time, channel.values, theta)
    theta[1:], *_ = np.linalg.lstsq(fit.gram[1:, 1:], fit.gradient[1:], rcond=1e-13)
    left = model.at(time, channel.values, theta)
    waves = model.waves(theta)
    about_centre = Harmonics(float(theta[1]), waves.real, -waves.imag)
    return about_centre.shifted(theta[0] * (centre - zero)), left.variance**0.5, float(theta[0])


def _notes(comparison: Comparison, cam: str, ratio: float) -> tuple[str, ...]:
    notes: list[str] = []
    if abs(ratio - 1) > _DRIFTS:
        notes.append(f"The measured acceleration repeats at {ratio:.5g} times the mean speed of the shaft: check the speed.")
    if comparison.share < _LITTLE:
        notes.append(
            f"The motion computed for the {cam} cam explains {max(comparison.share, 0.0):.0%} of the measured acceleration: "
            "check its sign and unit (keys scale and unit), and that both records have one clock, or give "
            "study.acceleration.zero."
        )
    return tuple(notes)
