"""The cam that makes a clean motion on a shaft that does not turn evenly, and the motion that any cam makes on it: 004.

A law is the motion that the output is to make over tau, the time of a turn as an angle. On a shaft that turns evenly tau is the
cam angle; on any other the cam for it has the same motion over the angle that the shaft has reached by then.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.cams.laws import Law
from wucht.cams.linkages.closure import composed_derivative
from wucht.cams.shaft_motion import ShaftMotion
from wucht.errors import InputError
from wucht.measurements.order_checks import OmittedOrder
from wucht.measurements.order_fit import OrderFit
from wucht.numerics.fourier_series import FourierSeries, even_angles

_SAMPLES = 2048  # of a turn: orders up to a quarter of that are free of aliasing for any motion worth making
_PHASES = (1.0, 5.0)  # degrees by which the speed may be out of phase with the shaft
_SHARES = (0.9, 1.1)  # times the fluctuation
_SPEEDS = (1.1, 0.9)  # times the mean speed, with the same fluctuation in rad/s
_SIDES = 4  # phases of an order, over half a turn, of which the worst counts: the other half is the same to first order
_NEGLIGIBLE = 1e-9  # of the largest order of the law's acceleration: less is negligible
_ERRORS = 3.0  # standard errors: a larger order that is left out is significant
_MOST_LEFT_OUT, _NOTHING = 6, 1e-4  # largest of them that are examined; of order 1: a residual that does not matter
_MOST_ORDERS = _SAMPLES // 8  # of a law: one with more of them is taken to have no end


@dataclass(frozen=True, eq=False)
class CorrectedLaw:
    """The motion over the cam angle, itself a law, that on a shaft is the law over time.

    Parameters
    ----------
    law : Law
        Over tau, the time of a turn as an angle.
    shaft : ShaftMotion
    mounting_error : float, optional
        Angle in rad by which the cam sits turned on its shaft.
    """

    law: Law
    shaft: ShaftMotion
    mounting_error: float = 0.0

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles in rad of any shape."""
        time = self.shaft.time_derivatives(np.asarray(phi) - self.mounting_error)
        return composed_derivative(np.stack([self.law(time[0], n) for n in range(order + 1)]), time[: order + 1])


@dataclass(frozen=True, eq=False)
class MotionOverTime:
    """The motion over tau, itself a law, that a motion over the cam angle becomes on a shaft: 004 (1)-(3).

    Parameters
    ----------
    law : Law
        Over the cam angle.
    shaft : ShaftMotion
    """

    law: Law
    shaft: ShaftMotion

    def __call__(self, tau: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by tau of an order from 0 to 3, at tau of any shape."""
        angle = [self.shaft.angle(tau, n) for n in range(order + 1)]
        return composed_derivative(np.stack([self.law(angle[0], n) for n in range(order + 1)]), angle)


def orders(law: Law, order: int = 2, samples: int = _SAMPLES) -> FourierSeries:
    """Return the orders, below half of the samples, of a derivative by tau; by default of the acceleration over omega^2."""
    return FourierSeries.from_samples(law(even_angles(samples), order))


def last_order_above(amplitudes: np.ndarray, share: float = _NEGLIGIBLE) -> int:
    """Return the number of the last order, the first being 1, that is larger than a share of the largest one; 0 without."""
    return int(np.flatnonzero(amplitudes > share * amplitudes.max(initial=0.0)).max(initial=-1)) + 1


def share_above_order(acceleration: FourierSeries, count: int, reference: int = 1) -> float:
    """Return the largest order of the acceleration above a number, as a share of its first order, or of a reference order."""
    return float(acceleration.amplitudes[count:].max(initial=0.0) / acceleration.amplitudes[reference - 1])


@dataclass(frozen=True)
class Deviation:
    """How far an output is from its law over time. orders: of its acceleration, see ``Purity.share``. position, rms: the
    largest distance and its root mean square over time, in the unit of the output."""

    orders: float
    position: float
    rms: float


@dataclass(frozen=True, eq=False)
class Purity:
    """The measure of all studies of cams: how far an output is from its law over time, by orders and by its position.

    law: over tau. target: the orders of its acceleration over omega^2. count: N, the number of its harmonics; None where it is
    infinite. reference: the order to which shares refer: the first one, or the lowest one present.
    """

    law: Law
    target: FourierSeries
    count: int | None
    reference: int

    @classmethod
    def from_law(cls, law: Law, count: int | None = None) -> Purity:
        """Return the measure for a law. count: N, by default determined. Raises ``InputError`` (law): the output rests."""
        target = orders(law)
        present = np.flatnonzero(target.amplitudes > _NEGLIGIBLE * target.amplitudes.max()) + 1
        if not len(present):
            raise InputError("law", None, "the output does not move: there is nothing to correct")
        if count is None and present[-1] <= _MOST_ORDERS:
            count = int(present[-1])
        return cls(law, target, count, int(present[0]))

    @cached_property
    def stroke(self) -> float:
        """Stroke of the output, in its unit."""
        return float(np.ptp(self.law(even_angles(_SAMPLES))))

    @property
    def name(self) -> str:
        """What a share is, in words."""
        of = "largest order above N" if self.count is not None else "largest deviation of an order from the law's"
        return f"{of} over order {self.reference}"

    def share(self, acceleration: FourierSeries) -> float:
        """Return the largest order above N, as a share of the reference; without an N the largest deviation of an order."""
        if self.count is not None:
            return share_above_order(acceleration, self.count, self.reference)
        n = min(acceleration.count, self.target.count)
        off = np.hypot(acceleration.cosine[:n] - self.target.cosine[:n], acceleration.sine[:n] - self.target.sine[:n])
        return float(off.max() / acceleration.amplitudes[self.reference - 1])

    def deviation(self, motion: Law) -> Deviation:
        """Return how far a motion of the output over tau is from the law."""
        tau = even_angles(_SAMPLES)
        distances = np.abs(motion(tau) - self.law(tau))
        return Deviation(self.share(orders(motion)), float(distances.max()), math.sqrt(float((distances**2).mean())))

    def is_clean(self, deviation: Deviation, limit: float) -> bool:
        """True if neither an order is off by more than a share of the reference nor the position by that of the stroke."""
        return deviation.orders <= limit and deviation.position <= limit * self.stroke


_Cases = list[tuple[CorrectedLaw, ShaftMotion]]  # cams, and the shafts that turn them


def residuals(law: Law, count: int | None, shaft: ShaftMotion) -> dict[str, float]:
    """Return how clean the motion of the corrected cam stays where its shaft turns differently from the assumed motion.

    That is the residual above order N, as a share of order 1, by the condition for which the cam was not made, a phrase.
    count: N, the orders of the law, or None: see ``Purity``. Of deviations to either side the worse one counts. A speed that
    changes as a whole, all fluctuations with it, changes nothing. Conditions under which the shaft would turn back are omitted.
    """
    purity = Purity.from_law(law, count)
    return {condition: _worst(purity, cases) for condition, cases in _conditions(law, shaft) if cases}


def _worst(purity: Purity, cases: _Cases) -> float:
    return max(purity.share(orders(MotionOverTime(cam, actual))) for cam, actual in cases)


def _conditions(law: Law, shaft: ShaftMotion) -> Iterator[tuple[str, _Cases]]:
    """Yield each condition for which the cam was not made, as a phrase, with its cases."""
    cam = CorrectedLaw(law, shaft)
    yield "as measured", [(cam, shaft)]
    for degrees in _PHASES:
        misaligned_cams = [CorrectedLaw(law, shaft, math.radians(by)) for by in (degrees, -degrees)]
        yield f"the phase of the speed, or the cam on its shaft, off by {degrees:g}°", [(one, shaft) for one in misaligned_cams]
    for share in _SHARES:
        yield f"{100 * share:.0f} % of the fluctuation", [(cam, scaled_shaft) for scaled_shaft in _scaled_shafts(shaft, share)]
    speeds = [(cam, scaled_shaft) for by in _SPEEDS for scaled_shaft in _scaled_shafts(shaft, 1 / by)]
    off = "off by" if len(speeds) == len(_SPEEDS) else "higher by"  # at the lower one a strong fluctuation would turn back
    yield f"a mean speed {off} {100 * (_SPEEDS[0] - 1):.0f} %, the fluctuation the same in rad/s", speeds
    for j in (np.flatnonzero(shaft.speed.amplitudes) + 1).tolist():
        with suppress(InputError):
            yield f"order {j} left out of the correction", [(CorrectedLaw(law, shaft.without_order(j)), shaft)]
    yield "a shaft that turns evenly", [(cam, shaft.with_scaled_fluctuation(0.0))]


def _scaled_shafts(shaft: ShaftMotion, by: float) -> list[ShaftMotion]:
    """Return the shaft with its fluctuation scaled by a factor; empty where it would turn back."""
    with suppress(InputError):
        return [shaft.with_scaled_fluctuation(by)]
    return []


def residual_of_extra_order(law: Law, count: int | None, shaft: ShaftMotion, order: int, amplitude: float) -> float:
    """Return the residual of the cam if the shaft's speed has an extra order: as a share of order 1, as in ``residuals``.

    amplitude: of that order in rad/s. Its phase is not known: the worst counts. Raises ``InputError`` (speed) where the shaft
    would turn back.
    """
    cam, cases = CorrectedLaw(law, shaft), _Cases()
    for phase in np.pi * np.arange(_SIDES) / _SIDES:
        wave = np.zeros(max(order, shaft.speed.count), complex)
        wave[: shaft.speed.count] = shaft.speed.cosine + 1j * shaft.speed.sine
        wave[order - 1] += amplitude * np.exp(1j * phase)
        cases.append((cam, ShaftMotion(FourierSeries(shaft.mean, wave.real, wave.imag))))
    return _worst(Purity.from_law(law, count), cases)


def left_out_orders(fit: OrderFit | None, law: Law, count: int | None, shaft: ShaftMotion) -> dict[OmittedOrder, float]:
    """Return the residual due to each significant order of a record that is not corrected and matters, the largest order first.

    None without a record. count: N, see ``residuals``.
    """
    significant = [] if fit is None else [one for one in fit.omitted_orders if one.amplitude > _ERRORS * one.error]
    left_out = dict[OmittedOrder, float]()
    for one in sorted(significant, key=lambda one: -one.amplitude)[:_MOST_LEFT_OUT]:
        with suppress(InputError):  # the shaft would turn back with it
            left_out[one] = residual_of_extra_order(law, count, shaft, one.order, one.amplitude)
    return {one: share for one, share in left_out.items() if share > _NOTHING}


def residual_of_all(left_out: Mapping[OmittedOrder, float]) -> float:
    """Return the residual of all orders of the record that are not corrected: about the root of the sum of squares."""
    return math.hypot(*left_out.values())


def residual_of_errors(fit: OrderFit, residuals: Mapping[str, float]) -> float:
    """Return the residual due to the standard errors of a record's orders.

    The residual of an order is proportional to it, and errors of different orders are independent: the root of the squares.
    """
    shares = {int(condition.split()[1]): share for condition, share in residuals.items() if condition.startswith("order ")}
    errors, amplitudes = zip(fit.orders, fit.amplitude_errors, strict=True), fit.speed.amplitudes
    return float(np.linalg.norm([shares[j] * error / amplitudes[j - 1] for j, error in errors if j in shares]))


def orders_beside(acceleration: FourierSeries, law: Law, shaft: ShaftMotion) -> FourierSeries:
    """004, figures 2 and 4: orders of what the cam should make, as many as of a measured acceleration, in its unit.

    Raises ``InputError`` (acceleration) where it has no orders.
    """
    if not acceleration.count:
        raise InputError("acceleration", None, "the measured acceleration must have orders", code="no-orders")
    total = float((acceleration.amplitudes**2).sum())
    if total <= (_NEGLIGIBLE * acceleration.mean) ** 2:
        requirement = f"this record holds no orders, it is constant at {acceleration.mean:.4g}: is it the right column?"
        raise InputError("acceleration", None, requirement, code="constant")
    motion_orders, scale = orders(MotionOverTime(law, shaft)), shaft.mean**2
    count = acceleration.count
    return FourierSeries(0.0, scale * motion_orders.cosine[:count], scale * motion_orders.sine[:count])


def explained_share(record_orders: FourierSeries, motion_orders: FourierSeries) -> float:
    """Return the share of the mean square of measured orders, which are not all zero, that computed ones explain.

    Both in one unit; the means do not count.
    """
    count = min(record_orders.count, motion_orders.count)
    cosine, sine = (getattr(record_orders, part)[:count] - getattr(motion_orders, part)[:count] for part in ("cosine", "sine"))
    rest = float((np.hypot(cosine, sine) ** 2).sum() + (record_orders.amplitudes[count:] ** 2).sum())
    return 1 - rest / float((record_orders.amplitudes**2).sum())


def best_delay(record_orders: FourierSeries, motion_orders: FourierSeries) -> tuple[float, float]:
    """Return the delay in rad of tau, within half a turn, of measured orders after computed ones where they agree best.

    Also the share explained with it, see ``explained_share``.
    """
    count = min(record_orders.count, motion_orders.count)
    motion_orders = FourierSeries(0.0, motion_orders.cosine[:count], motion_orders.sine[:count])
    m, c = (series.cosine[:count] - 1j * series.sine[:count] for series in (record_orders, motion_orders))
    product = m.conj() * c
    agreement = FourierSeries(0.0, product.real, product.imag)  # over the delay
    at = agreement.stationary()
    best = float(at[np.argmax(agreement(at))])
    measured_power, computed_power = (float((series.amplitudes**2).sum()) for series in (record_orders, motion_orders))
    share = (2 * float(agreement(best)) - computed_power) / measured_power
    return math.remainder(best, 2 * math.pi), share
