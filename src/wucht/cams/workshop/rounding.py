"""Whether coordinates are rounded finely enough for the spacing of their points."""

from __future__ import annotations

import math

import numpy as np

from wucht.cams.demands import positive
from wucht.cams.workshop.closed_curve import ClosedCurve, curvature
from wucht.cams.workshop.points import PointList

FINE = 0.01  # of h^2/r: a rounding up to there will do
WORST = 2 * math.sqrt(2)  # roundings: how far a second difference of points is off, all four halves the worst way in x and in y


def rounding_warning(curve: ClosedCurve, points: PointList, rounding: float) -> str | None:
    """A sentence where rounding spoils the direction of the contour, or None.

    rounding: the step in m to which coordinates are rounded. A machine that follows the points, or a program that draws a
    spline through them, takes the curvature from second differences h^2/r of the coordinates, h the distance of neighbours and
    r the radius of curvature: it is off by up to 2 sqrt(2) rounding/h^2, by at most 2.8 % for a rounding of a hundredth of
    h^2/r, from where on this warns (cam-mathematics, "coordinate rounding must be much finer than h^2/r"). The sagitta, by
    which the chords leave the contour, is an eighth of h^2/r. Where the curve is flatter than a circle of its length, that
    circle's radius stands for r: of a straight piece there is no curvature to compare with. Raises ``InputError``.
    """
    positive("rounding", rounding)
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
