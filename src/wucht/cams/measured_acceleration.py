"""A record of the output's acceleration beside the computed motion: its orders by least squares, so that it need not be cut."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.cams.correction import MotionOverTime, best_delay, explained_share, orders, orders_beside
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.measurements.order_checks import check_samples
from wucht.measurements.order_regression import START_BLOCKS, Mean, OrderModel, block_means, initial_fit
from wucht.measurements.recording import Channel
from wucht.measurements.shaft_signal import TURN, ShaftSignal
from wucht.numerics.fourier_series import FourierSeries

_FREE_FROM = 3.0  # turns: a shorter record does not determine the speed at which it repeats
_NEAR = 0.01  # of omega: the same speed
_AGREES, _BETTER = 0.5, 0.005  # of the mean square: what a delay must explain at least, and how much more than none
_ABOVE = 0.1  # of the root mean square: a larger share of the computed motion above the fitted orders is not noise


@dataclass(frozen=True, eq=False)
class MeasuredAcceleration:
    """Measured acceleration beside the computed one.

    channel: the record in rad/s^2 or m/s^2. measured_orders: of the record. computed_orders: of the computed motion. noise:
    root mean square of the residual, in the same unit. turns: of the record. ratio: of the speed at which it repeats to the
    mean speed of the shaft. zero: time in s of its clock at which the cam angle is zero. above (n,): of the root mean square of
    the computed motion the share of the orders above 0, 1, ...
    """

    channel: Channel
    measured_orders: FourierSeries
    computed_orders: FourierSeries
    noise: float
    turns: float
    ratio: float
    zero: float
    above: np.ndarray

    @classmethod
    def of(cls, channel: Channel, count: int, law: Law, shaft: ShaftMotion, zero: float) -> MeasuredAcceleration:
        """Fit orders 1 to ``count`` to a record, and compare them with the motion that the cam for a law makes.

        Raises ``InputError`` for a record that is shorter than a turn, has gaps, too few samples or no orders (acceleration).
        """
        fitted_orders = np.arange(1, count + 1)
        check_samples(ShaftSignal(channel.location, "speed", channel.time, channel.values), shaft.mean, fitted_orders)
        series, noise, speed = _fit_orders(channel, fitted_orders, shaft.mean, zero)
        computed_orders = orders_beside(series, law, shaft)
        powers = orders(MotionOverTime(law, shaft)).amplitudes ** 2
        above = np.sqrt(np.append(np.cumsum(powers[::-1])[::-1], 0.0) / powers.sum())
        turns = speed * float(np.ptp(channel.time)) / TURN
        return cls(channel, series, computed_orders, noise, turns, speed / shaft.mean, zero, above)

    @cached_property
    def share(self) -> float:
        """Of the mean square of the measured orders the share that the computed ones explain."""
        return explained_share(self.measured_orders, self.computed_orders)

    def share_of_record(self, share: float) -> float:
        """Return the explained share of the whole record about its mean, from that of the mean square of its orders."""
        order_power = float((self.measured_orders.amplitudes**2).sum()) / 2
        return share * order_power / (order_power + self.noise**2)

    @property
    def share_above(self) -> float:
        """Of the root mean square of the computed motion the share above the fitted orders."""
        return float(self.above[self.measured_orders.count])

    @property
    def enough_orders(self) -> int | None:
        """The number of orders to be fitted where the computed motion has orders above the fitted ones."""
        return int(np.argmax(self.above <= _ABOVE**2)) if self.share_above > _ABOVE else None

    @cached_property
    def delay(self) -> tuple[float, float] | None:
        """Delay of the record in rad of tau, and the share explained without it: where that is noticeably more, and most of it.

        None with too few orders: at a wrong speed the record is out of phase in any case.
        """
        if self.enough_orders is not None:
            return None
        delay, share = best_delay(self.measured_orders, self.computed_orders)
        better = share > self.share + _BETTER and self.share_of_record(share) > _AGREES
        return (delay, share) if better else None

    def folded_samples(self, most: int) -> tuple[np.ndarray, np.ndarray]:
        """Return samples (S,) about their mean: tau within a turn, and the acceleration."""
        # At random: every n-th sample would always lie at the same phase of a turn if the shaft gave the clock.
        indices = np.random.default_rng(0).permutation(len(self.channel.time))[:most]
        speed = TURN * self.turns / float(np.ptp(self.channel.time))
        tau = np.mod(speed * (self.channel.time[indices] - self.zero), TURN)
        return tau, self.channel.values[indices] - self.measured_orders.mean


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
