"""A closed curve in the plane: its sense, its outward normals, its curvature, and how far points lie from it."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from wucht.cams.demands import finite
from wucht.errors import InputError
from wucht.numerics.harmonics import even_angles

GRID = 4096  # samples of a turn, from which a curve is judged as a whole
_STANDING = 1e-9  # of the largest speed: slower, the curve has a cusp there
_NEWTON = 12
_TURN = 2 * math.pi


class ClosedCurve(Protocol):
    """A smooth closed curve over the parameter phi, of period 2 pi, traversed either way, without double points."""

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """x + i y in m, or its derivative by phi of order 1 or 2, complex, at parameters in rad of any shape."""
        ...


def speed(curve: ClosedCurve, phi: np.ndarray) -> np.ndarray:
    """|c'| at parameters of any shape, in m/rad. Raises ``InputError`` where the curve stands still: at a cusp."""
    absolute = np.abs(finite("curve", curve(phi, 1)))
    if not absolute.min() > _STANDING * absolute.max():
        raise InputError(
            "curve", None, "its derivative vanishes: there is a cusp or a corner (undercut), without a normal", code="cusp"
        )
    return np.asarray(absolute)


def clockwise(curve: ClosedCurve) -> bool:
    """Whether the curve runs clockwise: whether the area on its left is negative."""
    phi = even_angles(GRID)
    return bool(np.sum((curve(phi).conj() * curve(phi, 1)).imag) < 0)


def outward_normals(curve: ClosedCurve, phi: np.ndarray) -> np.ndarray:
    """Unit normals, complex, away from the area that the curve encloses, at parameters of any shape."""
    right = -1j * curve(phi, 1) / speed(curve, phi)
    return np.asarray(-right if clockwise(curve) else right)


def curvature(curve: ClosedCurve, phi: np.ndarray) -> np.ndarray:
    """|Im(conj(c') c'')|/|c'|^3 in 1/m at parameters of any shape."""
    return np.asarray(np.abs((curve(phi, 1).conj() * curve(phi, 2)).imag) / speed(curve, phi) ** 3)


def distances(curve: ClosedCurve, position: np.ndarray) -> np.ndarray:
    """The distances (N,) in m of points (N,), complex, from the curve.

    From the nearest of many samples Newton's method leads to the foot of the normal, Re(conj(c') (c - p)) = 0.
    """
    from scipy.spatial import cKDTree

    grid = even_angles(GRID)
    samples = finite("curve", curve(grid))
    nearest, index = cKDTree(np.column_stack([samples.real, samples.imag])).query(
        np.column_stack([position.real, position.imag])
    )
    phi = grid[index]
    for _ in range(_NEWTON):
        off, along = curve(phi) - position, curve(phi, 1)
        slope = np.abs(along) ** 2 + (curve(phi, 2).conj() * off).real
        # Where the foot is no nearest point, the step is cut to the distance of the samples and the sample itself remains.
        step = np.divide((along.conj() * off).real, slope, out=np.zeros(len(phi)), where=slope > 0)
        phi = phi - np.clip(step, -_TURN / GRID, _TURN / GRID)
    return np.asarray(np.minimum(nearest, np.abs(curve(phi) - position)))
