"""The motion of a camshaft that does not turn evenly: its angle over the time of a turn, and the inverse.

tau = 2 pi t/T counts the time of a turn T as an angle; omega = 2 pi/T is the mean speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries, even_angles

_MOST_STEPS = 60  # of Newton's method, or of halving where it would leave the interval
_ROUNDING = 4e-16
_OVERSAMPLING, _FEWEST = 8, 64  # samples for each order, and of orders
_ALIKE = 1e-9  # of the mean speed


@dataclass(frozen=True, eq=False)
class ShaftMotion:
    """The motion of a camshaft that does not turn evenly, over tau, the time of a turn as an angle; phi is zero where tau is.

    Of speed = omega + sum a_j cos j tau + b_j sin j tau it is phi = tau + sum (a_j sin j tau - b_j (cos j tau - 1))/(j omega):
    004 (4), whose coefficients are these divided by omega; a constant would only turn the blank.

    Parameters
    ----------
    speed : FourierSeries
        phi' in rad/s over tau; its mean is omega.

    Raises
    ------
    InputError
        (speed) Where the shaft stands still or turns back.
    """

    speed: FourierSeries

    def __post_init__(self) -> None:
        least = self.speed.bounds[0]
        if not least > 0:
            requirement = f"the shaft must not stand still or turn back: its speed falls to {least:.4g} rad/s; check the unit"
            raise InputError("speed", None, f"{requirement} of the coefficients, and that order 0 is the mean speed 2 pi/T")

    @property
    def mean(self) -> float:
        """omega, in rad/s."""
        return self.speed.mean

    @property
    def fluctuation(self) -> float:
        """(largest - least)/mean of the speed."""
        low, high = self.speed.bounds
        return (high - low) / self.mean

    @cached_property
    def _lead(self) -> FourierSeries:
        """phi - tau."""
        j, s = np.arange(1, self.speed.count + 1), self.speed
        cosine, sine = -s.sine / (j * self.mean), s.cosine / (j * self.mean)
        return FourierSeries(float(-cosine.sum()), cosine, sine)

    @cached_property
    def _lead_bounds(self) -> tuple[float, float]:
        return self._lead.bounds

    def angle(self, tau: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative of phi by tau of any order, at tau of any shape."""
        more = tau if order == 0 else 1.0 if order == 1 else 0.0
        return np.asarray(self._lead(tau, order) + more)

    def time(self, phi: np.ndarray | float) -> np.ndarray:
        """tau at cam angles of any shape: by Newton's method, kept between bounds that close in."""
        phi = np.asarray(phi, float)
        least, most = self._lead_bounds
        low, high = phi - most, phi - least
        tau = np.clip(phi - self._lead(phi), low, high)
        for _ in range(_MOST_STEPS):
            off = self.angle(tau) - phi
            low, high = np.where(off <= 0, tau, low), np.where(off >= 0, tau, high)
            newton = tau - off / self.angle(tau, 1)
            step = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2) - tau
            tau = tau + step
            if (np.abs(step) <= _ROUNDING * (1 + np.abs(tau))).all():
                break
        return np.asarray(tau)

    def time_derivatives(self, phi: np.ndarray | float) -> np.ndarray:
        """tau and its first three derivatives by phi (4, ...), not to be written to."""
        # A contour needs the derivatives of its law one by one, at the same angles: the last ones are kept.
        last_phi, last_values = self.__dict__.get("_last", (None, None))
        if last_values is not None and np.array_equal(last_phi, phi):
            return np.asarray(last_values)
        tau = self.time(phi)
        first, second, third = (self.angle(tau, order) for order in (1, 2, 3))
        derivatives = np.stack([tau, 1 / first, -second / first**3, (3 * second**2 - first * third) / first**5])
        derivatives.flags.writeable = False
        self.__dict__["_last"] = (np.array(phi), derivatives)
        return derivatives

    def speed_over_angle(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """Return the speed in rad/s (order 0) or its derivative by the angle (order 1) at cam angles of any shape."""
        tau = self.time(phi)
        first = self.angle(tau, 1)
        return np.asarray(self.mean * (self.angle(tau, 2) / first if order else first))

    def with_scaled_fluctuation(self, by: float) -> ShaftMotion:
        """Return the motion with its fluctuation scaled by a factor about the same mean."""
        return ShaftMotion(FourierSeries(self.mean, by * self.speed.cosine, by * self.speed.sine))

    def without_order(self, order: int) -> ShaftMotion:
        """Return the motion without an order of its fluctuation."""
        keep = np.arange(1, self.speed.count + 1) != order
        return ShaftMotion(FourierSeries(self.mean, keep * self.speed.cosine, keep * self.speed.sine))


def with_period(speed: FourierSeries, period: float) -> ShaftMotion:
    """Return the motion of a shaft whose turn takes a period in s. Raises ``InputError`` where order 0 is not 2 pi/T."""
    mean_speed = 2 * math.pi / period
    if abs(speed.mean - mean_speed) > _ALIKE * mean_speed:
        requirement = f"order 0 must be 2 pi/T = {mean_speed:.6g} rad/s, T = {period:.6g} s being the time of a turn"
        raise InputError("speed.mean", speed.mean, requirement)
    return ShaftMotion(speed)


def shaft_motion_over_time(speed_over_angle: FourierSeries, orders: int) -> ShaftMotion:
    """Return the motion of a shaft whose speed in rad/s is known over its angle, as from order tracking.

    orders: number of orders of the speed over time; these differ from those over angle in second order of the fluctuation.
    dt = dphi/phi', so that tau(phi) = omega integral of dphi/phi' and 1/omega is the mean of 1/phi'. Raises as ``ShaftMotion``.
    """
    over_angle = ShaftMotion(speed_over_angle).speed
    count = _OVERSAMPLING * max(orders, over_angle.count, _FEWEST)
    phi = even_angles(count)
    slowness = FourierSeries.from_samples(1 / over_angle(phi)).without_rounding()
    omega, k = 1 / slowness.mean, np.arange(1, slowness.count + 1)
    lead = FourierSeries.of(0.0, -omega * slowness.sine / k, omega * slowness.cosine / k)
    at = phi  # phi at even tau: tau = phi + ahead(phi) - ahead(0)
    for _ in range(_MOST_STEPS):
        step = (at + lead(at) - lead(0.0) - phi) / (omega * slowness(at))
        at = at - step
        if np.abs(step).max() <= _ROUNDING * 2 * math.pi:
            break
    resampled_speed = FourierSeries.from_samples(over_angle(at))
    return ShaftMotion(FourierSeries(omega, resampled_speed.cosine[:orders], resampled_speed.sine[:orders]))
