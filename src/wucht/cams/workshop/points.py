"""Points of a closed curve to mill: by a chord tolerance, or evenly spaced; and a check of their rounding."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.demands import require_at_least, require_finite, require_positive
from wucht.cams.workshop.closed_curve import GRID, CamCurve, curvature, outward_normals, speed
from wucht.errors import InputError
from wucht.numerics.fourier_series import even_angles

FEWEST = 3
SPACING = 1e-3  # m: longest chord by default
_BETWEEN = 16  # parts of each chord between which the curve is sampled; the middle is one
_SAMPLES = 2048  # of the turn, at least, however few the chords are
_SHARE = 0.99  # of the tolerance is used: between the samples lie at most 0.4 % more of a parabola's height
_FLATTEST = 0.02  # of the mean density of points: so many even where the curve is straight
_MOST = 2_000_000
_TURN = 2 * math.pi
FINE = 0.01  # of h^2/r: a rounding up to there will do
WORST = 2 * math.sqrt(2)  # roundings: how far a second difference of points is off, all four halves the worst way in x and in y


@dataclass(frozen=True, eq=False)
class PointList:
    """Points of a closed curve in order, the first not repeated at the end.

    phi (N,): parameters in rad, rising from 0. position (N,): x + i y in m. normal (N,): outward unit normals, complex.
    """

    phi: np.ndarray
    position: np.ndarray
    normal: np.ndarray

    @property
    def spacing(self) -> np.ndarray:
        """The lengths (N,) in m of the chords from each point to the next, the last back to the first."""
        return np.asarray(np.abs(np.roll(self.position, -1) - self.position))


def points_at(curve: CamCurve, phi: np.ndarray) -> PointList:
    """Return the points of the curve at parameters (N,)."""
    return PointList(phi, require_finite("curve", curve(phi)), outward_normals(curve, phi))


def even_points(curve: CamCurve, count: int) -> PointList:
    """Return points evenly spaced in the parameter, 3 or more. Raises ``InputError``."""
    return points_at(curve, even_angles(require_at_least("count", count, FEWEST)))


def chord_points(curve: CamCurve, tolerance: float, spacing: float = math.inf, least: int = FEWEST) -> PointList:
    """Return points so dense that no chord between neighbours deviates from the curve by more than the tolerance.

    tolerance: in m. spacing: the longest permitted chord, in m. least: the least number of points.
    The density comes from the sagitta h^2 kappa/8 of a chord h; the chords themselves are then checked, between the points
    too, and all are made denser where one deviates too far. Raises ``InputError``.
    """
    require_positive("tolerance", tolerance)
    require_at_least("least", least, FEWEST)
    if spacing != math.inf:
        require_positive("spacing", spacing)
    grid = np.append(even_angles(GRID), _TURN)
    density = _density(curve, grid, _SHARE * tolerance, spacing)
    steps = (density[1:] + density[:-1]) / 2 * (_TURN / GRID)
    cumulative_count = np.append(0.0, np.cumsum(steps))
    count = max(least, math.ceil(cumulative_count[-1]))
    while count <= _MOST:
        phi = np.interp(cumulative_count[-1] * np.arange(count) / count, cumulative_count, grid)
        longest = float(np.abs(np.diff(curve(np.append(phi, _TURN)))).max())
        excess = max(math.sqrt(chord_deviation(curve, phi) / (_SHARE * tolerance)), longest / spacing)
        if excess <= 1:
            return points_at(curve, phi)
        count = max(count + 1, math.ceil(count * min(excess, 2.0)))
    raise InputError(
        "tolerance", tolerance, f"it needs more than {_MOST} points: choose a wider tolerance or spacing (both in m)"
    )


def _density(curve: CamCurve, phi: np.ndarray, tolerance: float, spacing: float) -> np.ndarray:
    """Return points a radian at parameters (M,): of chords h = sqrt(8 tolerance/kappa), none longer than ``spacing``."""
    require_finite("curve", curve(phi, 2))
    density = speed(curve, phi) * np.maximum(np.sqrt(curvature(curve, phi) / (8 * tolerance)), 1 / spacing)
    return np.asarray(np.maximum(density, _FLATTEST * density.mean()))


def chord_deviation(curve: CamCurve, phi: np.ndarray) -> float:
    """Return the largest distance in m between the curve and the closed polygon of its points at rising parameters (N,)."""
    parts = max(_BETWEEN, math.ceil(_SAMPLES / len(phi)))
    ends = np.append(phi, phi[0] + _TURN)
    shares = np.arange(1, parts) / parts
    between = require_finite("curve", curve(ends[:-1, None] + np.diff(ends)[:, None] * shares))
    start = curve(ends[:-1])[:, None]
    return float(_chord_distances(between, start, np.roll(start, -1, axis=0) - start).max())


def _chord_distances(position: np.ndarray, start: np.ndarray, chord: np.ndarray) -> np.ndarray:
    """Return the distances of points (N, M) from their chords (N, 1)."""
    length = np.maximum(np.abs(chord) ** 2, np.finfo(float).tiny)
    share = np.clip(((position - start) * chord.conj()).real / length, 0.0, 1.0)
    return np.asarray(np.abs(position - start - share * chord))


def rounding_warning(curve: CamCurve, points: PointList, rounding: float) -> str | None:
    """Return a warning where rounding spoils the direction of the contour, else None.

    rounding: the step in m to which coordinates are rounded. A machine that follows the points, or a program that draws a
    spline through them, takes the curvature from second differences h^2/r of the coordinates, h the distance of neighbours and
    r the radius of curvature: it is off by up to 2 sqrt(2) rounding/h^2, by at most 2.8 % for a rounding of a hundredth of
    h^2/r, from where on this warns (cam-mathematics, "coordinate rounding must be much finer than h^2/r"). The sagitta, by
    which the chords leave the contour, is an eighth of h^2/r. Where the curve is flatter than a circle of its length, that
    circle's radius stands for r: of a straight piece there is no curvature to compare with. Raises ``InputError``.
    """
    require_positive("rounding", rounding)
    h = np.minimum(points.spacing, np.roll(points.spacing, 1))
    kappa = np.maximum(curvature(curve, points.phi), 2 * math.pi / points.spacing.sum())
    k = int(np.argmin(h**2 * kappa))
    height = float(h[k] ** 2 * kappa[k])
    if rounding <= FINE * height:
        return None
    fine, wide = 10.0 ** math.floor(math.log10(FINE * height) + 1e-9), math.sqrt(rounding / (FINE * kappa[k]))
    share = math.ceil(100 * WORST * rounding / height)
    return (
        f"coordinates rounded to {_length(rounding)} are too coarse for points {_length(h[k])} apart on a radius of "
        f"{_length(1 / kappa[k])}: h^2/r is {_length(height)} there (the sagitta {_length(height / 8)}), and second "
        f"differences miss the curvature by up to {share} %; round to {_length(fine)} or finer, or take points "
        f"{_length(wide)} apart or more"
    )


def _length(length: float) -> str:
    size, name = next((s for s in ((1e-3, "mm"), (1e-6, "um")) if length >= 0.1 * s[0]), (1e-9, "nm"))
    return f"{length / size:.4g} {name}"
