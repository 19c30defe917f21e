"""Sense, normals, curvature and distances of curves for which they are known."""

import math

import numpy as np
import pytest
from curves_to_mill import CURVES, RADIUS, broken, cusped, ellipse, lobes
from tests.refusals import refused

from wucht.cams.workshop.closed_curve import clockwise, curvature, distances, outward_normals, speed
from wucht.numerics.harmonics import even_angles

PHI = even_angles(37) + 0.1


@pytest.mark.parametrize("b", [RADIUS, -RADIUS])
def test_normals_point_outward_whichever_way_the_curve_runs(b):
    circle = ellipse(b=b, centre=0.2)
    assert clockwise(circle) == (b < 0)
    assert outward_normals(circle, PHI) == pytest.approx((circle(PHI) - 0.2) / RADIUS, abs=1e-14)


def test_normals_of_an_ellipse():
    """Along the gradient of x^2/a^2 + y^2/b^2."""
    a, b = 0.08, 0.02
    gradient = np.cos(PHI) / a + 1j * np.sin(PHI) / b
    assert outward_normals(ellipse(a, b), PHI) == pytest.approx(gradient / abs(gradient), abs=1e-13)


def test_curvature():
    a, b = 0.08, 0.02
    assert curvature(ellipse(), PHI) == pytest.approx(np.full(37, 1 / RADIUS), rel=1e-12)
    ends = curvature(ellipse(a, -b), np.array([0.0, math.pi / 2]))
    assert ends == pytest.approx([a / b**2, b / a**2], rel=1e-12)


@pytest.mark.parametrize("name", CURVES)
def test_distances(name):
    """Of points at a known distance along the normals, on both sides, smaller than every radius of curvature."""
    curve = CURVES[name]
    off = 1e-3 * np.sin(7 * PHI)
    assert distances(curve, curve(PHI) + off * outward_normals(curve, PHI)) == pytest.approx(np.abs(off), abs=1e-12)


def test_distances_from_afar():
    """Farther off than the radius of curvature."""
    curve = ellipse(0.08, 0.02)
    there = distances(curve, curve(PHI) + 0.3 * outward_normals(curve, PHI))
    assert there == pytest.approx(np.full(37, 0.3), rel=1e-14)


def test_the_distance_of_the_centre():
    """There every point is the nearest, and Newton's method stands still."""
    assert distances(ellipse(), np.zeros(1, complex)) == pytest.approx([RADIUS], rel=1e-12)
    assert distances(lobes, np.zeros(1, complex)) == pytest.approx([0.045], rel=1e-6)


def test_a_curve_that_stands_still_has_no_normal():
    with refused("curve", code="cusp"):
        speed(cusped, even_angles(4096))
    with refused("curve", code="not-finite"):
        speed(broken, even_angles(4096))
