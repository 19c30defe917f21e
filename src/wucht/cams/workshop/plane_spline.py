"""A closed cubic spline in the plane through points of a curve: what a CAD program draws as one smooth line."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.demands import finite, positive
from wucht.cams.workshop.closed_curve import ClosedCurve
from wucht.errors import InputError
from wucht.numerics.harmonics import even_angles

_FEWEST, _MOST = 8, 65536
_BETWEEN = 16
_SAMPLES = 2048
_SHARE = 0.99  # of the tolerance is used: the error is only looked at between 16 parts of each piece
_TURN = 2 * math.pi


@dataclass(frozen=True, eq=False)
class PlaneSpline:
    """A closed B-spline over the parameter phi, 0 to 2 pi. knots (K,): in rad. control (C,): points, complex, in m; K = C + 4.

    The first and the last knot stand four times, as most programs expect, and the first and the last control point are one; the
    direction and the curvature go through there all the same.
    """

    degree: int
    knots: np.ndarray
    control: np.ndarray

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """x + i y in m, or a derivative by phi, at parameters in rad of any shape."""
        from scipy.interpolate import BSpline

        parts = BSpline(self.knots, np.column_stack([self.control.real, self.control.imag]), self.degree)
        values = parts(np.mod(phi, _TURN), nu=order)
        return np.asarray(values[..., 0] + 1j * values[..., 1])

    @property
    def pieces(self) -> int:
        """Of how many cubics it consists."""
        return len(self.control) - self.degree


def spline_through(curve: ClosedCurve, count: int) -> PlaneSpline:
    """The periodic cubic spline through so many points of the curve, evenly spaced in phi: curvature and all are continuous."""
    from scipy.interpolate import CubicSpline, make_interp_spline

    phi = np.append(even_angles(count), _TURN)
    at = finite("curve", curve(phi))
    at[-1] = at[0]
    values = np.column_stack([at.real, at.imag])
    slope = CubicSpline(phi, values, bc_type="periodic")(0.0, 1)
    parts = make_interp_spline(phi, values, k=3, bc_type=([(1, slope)], [(1, slope)]))
    control = parts.c[:, 0] + 1j * parts.c[:, 1]
    control[-1] = control[0]
    return PlaneSpline(3, np.asarray(parts.t), control)


def spline_deviation(curve: ClosedCurve, spline: PlaneSpline) -> float:
    """The largest distance in m of the two at equal phi: never less than how far the spline lies from the curve."""
    count = max(_SAMPLES, _BETWEEN * spline.pieces)
    phi = even_angles(count)
    return float(np.abs(spline(phi) - curve(phi)).max())


def fitted_spline(curve: ClosedCurve, tolerance: float) -> PlaneSpline:
    """The spline through about as few points as keep it within the tolerance, in m, of the curve. Raises ``InputError``."""
    positive("tolerance", tolerance)
    count = _FEWEST
    while count <= _MOST:
        spline = spline_through(curve, count)
        excess = spline_deviation(curve, spline) / (_SHARE * tolerance)
        if excess <= 1:
            return spline
        # The error falls with the fourth power of the spacing, once the spacing is fine.
        count = max(count + 1, math.ceil(count * min(excess**0.25, 1.5)))
    raise InputError("tolerance", tolerance, f"a spline of {_MOST} pieces does not keep it (in m): choose a wider one")
