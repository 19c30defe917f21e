"""A closed curve in the plane: sense, outward normals, curvature, distances of points; a cubic spline through points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wucht.cams.demands import require_finite, require_positive
from wucht.errors import InputError
from wucht.numerics.fourier_series import even_angles

GRID = 4096  # samples of a turn, from which a curve is judged as a whole
_CUSP = 1e-9  # of the largest speed: slower, the curve has a cusp there
_NEWTON = 12
_AT_THE_FOOT = 1e-12  # rad: the distance changes by the square of it
_TURN = 2 * math.pi
_FEWEST, _MOST = 8, 65536
_COARSE = 1024  # pieces of a spline, before those that need it are halved
_BETWEEN = 16
_SAMPLES = 2048
_SHARE = 0.99  # of the tolerance is used: the error is only evaluated between 16 parts of each piece


class CamCurve(Protocol):
    """A smooth closed curve over the parameter phi, of period 2 pi, traversed either way, without double points."""

    def __call__(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """x + i y in m, or its derivative by phi of order 1 or 2, complex, at parameters in rad of any shape."""
        ...


def speed(curve: CamCurve, phi: np.ndarray) -> np.ndarray:
    """Return |c'| at parameters of any shape, in m/rad. Raises ``InputError`` where it vanishes: at a cusp."""
    absolute = np.abs(require_finite("curve", curve(phi, 1)))
    if not absolute.min() > _CUSP * absolute.max():
        raise InputError(
            "curve", None, "its derivative vanishes: there is a cusp or a corner (undercut), without a normal", code="cusp"
        )
    return np.asarray(absolute)


def is_clockwise(curve: CamCurve) -> bool:
    """Return True if the curve runs clockwise: if the area on its left is negative."""
    phi = even_angles(GRID)
    return bool(np.sum((curve(phi).conj() * curve(phi, 1)).imag) < 0)


def outward_normals(curve: CamCurve, phi: np.ndarray) -> np.ndarray:
    """Return unit normals, complex, away from the area that the curve encloses, at parameters of any shape."""
    right = -1j * curve(phi, 1) / speed(curve, phi)
    return np.asarray(-right if is_clockwise(curve) else right)


def curvature(curve: CamCurve, phi: np.ndarray) -> np.ndarray:
    """Return |Im(conj(c') c'')|/|c'|^3 in 1/m at parameters of any shape."""
    return np.asarray(np.abs((curve(phi, 1).conj() * curve(phi, 2)).imag) / speed(curve, phi) ** 3)


def curve_distances(curve: CamCurve, position: np.ndarray) -> np.ndarray:
    """Return the distances (N,) in m of points (N,), complex, from the curve.

    From the nearest of many samples Newton's method leads to the foot of the normal, Re(conj(c') (c - p)) = 0.
    """
    from scipy.spatial import cKDTree

    grid = even_angles(GRID)
    samples = require_finite("curve", curve(grid))
    nearest, index = cKDTree(np.column_stack([samples.real, samples.imag])).query(
        np.column_stack([position.real, position.imag])
    )
    phi, moving = grid[index], np.arange(len(position))
    for _ in range(_NEWTON):
        at = phi[moving]
        off, along = curve(at) - position[moving], curve(at, 1)
        slope = np.abs(along) ** 2 + (curve(at, 2).conj() * off).real
        # Where the foot is not a nearest point, the step is cut to the distance of the samples and the sample itself remains.
        step = np.divide((along.conj() * off).real, slope, out=np.zeros(len(at)), where=slope > 0)
        phi[moving] = at - np.clip(step, -_TURN / GRID, _TURN / GRID)
        moving = moving[np.abs(step) > _AT_THE_FOOT]
        if not len(moving):
            break
    return np.asarray(np.minimum(nearest, np.abs(curve(phi) - position)))


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
        """Number of cubics of which it consists."""
        return len(self.control) - self.degree


def spline_through(curve: CamCurve, count: int) -> PlaneSpline:
    """Return the periodic cubic spline through so many even points of the curve in phi: its curvature is continuous."""
    return _spline_at(curve, np.append(even_angles(count), _TURN))


def _spline_at(curve: CamCurve, phi: np.ndarray) -> PlaneSpline:
    """Return the periodic cubic spline through the curve at parameters (N,) from 0 to 2 pi."""
    from scipy.interpolate import CubicSpline, make_interp_spline

    at = require_finite("curve", curve(phi))
    at[-1] = at[0]
    values = np.column_stack([at.real, at.imag])
    slope = CubicSpline(phi, values, bc_type="periodic")(0.0, 1)
    parts = make_interp_spline(phi, values, k=3, bc_type=([(1, slope)], [(1, slope)]))
    control = parts.c[:, 0] + 1j * parts.c[:, 1]
    control[-1] = control[0]
    return PlaneSpline(3, np.asarray(parts.t), control)


def spline_deviation(curve: CamCurve, spline: PlaneSpline) -> float:
    """Return the largest distance in m of the two at equal phi: never less than the distance of the spline from the curve."""
    count = max(_SAMPLES, _BETWEEN * spline.pieces)
    phi = even_angles(count)
    return float(np.abs(spline(phi) - curve(phi)).max())


def fitted_spline(curve: CamCurve, tolerance: float) -> PlaneSpline:
    """Return the spline through about as few points as keep it within the tolerance, in m. Raises ``InputError``."""
    require_positive("tolerance", tolerance)
    count = _FEWEST
    while count <= _MOST:
        spline = spline_through(curve, count)
        excess = spline_deviation(curve, spline) / (_SHARE * tolerance)
        if excess <= 1:
            return spline
        # The error falls with the fourth power of the spacing, once the spacing is fine.
        count = max(count + 1, math.ceil(count * min(excess**0.25, 1.5)))
    return _graded_spline(curve, tolerance)


def _graded_spline(curve: CamCurve, tolerance: float) -> PlaneSpline:
    """Return the spline whose pieces are halved until they keep the tolerance, as where a flat face's contour bends anew: there
    c' jumps, and the error falls with the spacing alone. Raises ``InputError``."""
    phi, shares = np.append(even_angles(_COARSE), _TURN), np.arange(1, _BETWEEN) / _BETWEEN
    while len(phi) <= _MOST:
        spline, middles = _spline_at(curve, phi), (phi[:-1] + phi[1:]) / 2
        between = phi[:-1, None] + np.diff(phi)[:, None] * shares
        off = np.abs(spline(between) - curve(between)).max(axis=1)
        if off.max() <= _SHARE * tolerance:
            return spline
        phi = np.sort(np.append(phi, middles[off > _SHARE * tolerance]))
    raise InputError("tolerance", tolerance, f"a spline of {_MOST} pieces does not keep it (in m): choose a wider one")
