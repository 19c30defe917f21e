"""The cam that makes a clean motion on a shaft that does not turn evenly, and what any cam makes of it: 004.

A law is the motion that the output is to make over tau, the time of a turn as an angle. On a shaft that turns evenly tau is the
cam angle; on any other the cam for it has the same motion over the angle that the shaft has reached by then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.derivatives import composed
from wucht.cams.laws.law import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.errors import InputError
from wucht.numerics.harmonics import Harmonics, even_angles

_SAMPLES = 2048  # of a turn: orders up to a quarter of that are free of aliasing for any motion worth making
_PHASES = (1.0, 5.0)  # degrees by which the speed may be out of phase with the shaft
_SHARES = (0.9, 1.1)  # times the fluctuation


@dataclass(frozen=True, eq=False)
class CorrectedLaw:
    """The motion over the cam angle, itself a law, that on this shaft is the law over time.

    turned: the cam sits on its shaft turned by so many rad against where it belongs.
    """

    law: Law
    shaft: ShaftMotion
    turned: float = 0.0

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles in rad of any shape."""
        time = self.shaft.time_derivatives(np.asarray(phi) - self.turned)
        return composed(np.stack([self.law(time[0], n) for n in range(order + 1)]), time[: order + 1])


@dataclass(frozen=True, eq=False)
class MotionOverTime:
    """The motion over tau, itself a law, that a motion over the cam angle becomes on this shaft: 004 (1)-(3)."""

    law: Law
    shaft: ShaftMotion

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by tau of an order from 0 to 3, at tau of any shape."""
        angle = [self.shaft.angle(phi, n) for n in range(order + 1)]
        return composed(np.stack([self.law(angle[0], n) for n in range(order + 1)]), angle)


def orders(law: Law, order: int = 2, samples: int = _SAMPLES) -> Harmonics:
    """The orders, below half of the samples, of a derivative by tau: of the acceleration over omega^2 if nothing is said."""
    return Harmonics.sampled(law(even_angles(samples), order))


def above(acceleration: Harmonics, count: int) -> float:
    """The largest order of the acceleration above that of a number, as a share of its first order."""
    return float(acceleration.amplitudes[count:].max(initial=0.0) / acceleration.amplitudes[0])


@dataclass(frozen=True)
class Residual:
    """What is left above order N, as a share of order 1, where something is not as the cam was made for. what: in words."""

    what: str
    share: float


def residuals(law: Law, count: int, shaft: ShaftMotion) -> tuple[Residual, ...]:
    """How clean the motion of the corrected cam stays where its shaft turns otherwise than it was made for.

    count: N, the orders of the law. A speed that changes as a whole, all fluctuations with it, changes nothing.
    """
    cam = CorrectedLaw(law, shaft)

    def left(what: str, cam: CorrectedLaw, actual: ShaftMotion = shaft) -> Residual:
        return Residual(what, above(orders(MotionOverTime(cam, actual)), count))

    found = [left("as measured", cam)]
    for degrees in _PHASES:
        turned = CorrectedLaw(law, shaft, math.radians(degrees))
        found.append(left(f"the phase of the speed, or the cam on its shaft, off by {degrees:g}°", turned))
    found += [left(f"{share:.0%} of the fluctuation", cam, shaft.scaled(share)) for share in _SHARES]
    for j in (np.flatnonzero(shaft.speed.amplitudes) + 1).tolist():
        found.append(left(f"order {j} left out of the correction", CorrectedLaw(law, shaft.without(j))))
    found.append(left("a shaft that turns evenly", cam, shaft.scaled(0.0)))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A measured acceleration of the output beside the computed one. measured, computed: orders, of one unit. share: of the
    measured mean square that the computed one explains."""

    measured: Harmonics
    computed: Harmonics
    share: float


def compared(acceleration: Harmonics, law: Law, shaft: ShaftMotion) -> Comparison:
    """004, figures 2 and 4: orders of a measured acceleration (in rad/s^2 or m/s^2) and of what the cam should make."""
    if not acceleration.count:
        raise InputError("acceleration", None, "the measured acceleration must have orders")
    found, scale = orders(MotionOverTime(law, shaft)), shaft.mean**2
    count = min(acceleration.count, found.count)
    computed = Harmonics(0.0, scale * found.cosine[:count], scale * found.sine[:count])
    off = np.hypot(acceleration.cosine[:count] - computed.cosine, acceleration.sine[:count] - computed.sine)
    total = float((acceleration.amplitudes**2).sum())
    rest = float((off**2).sum() + (acceleration.amplitudes[count:] ** 2).sum())
    return Comparison(acceleration, computed, 1 - rest / total if total else math.nan)
