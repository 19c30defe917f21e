"""Sense, normals, curvature and distances of curves for which they are known."""

import math

import numpy as np
import pytest
from curves_to_mill import CURVES, RADIUS, broken, cusped, ellipse, lobes
from tests.refusals import refused

from wucht.cams.workshop.closed_curve import (
    curve_distances,
    fitted_spline,
    is_clockwise,
    outward_normals,
    speed,
    spline_deviation,
    spline_through,
)
from wucht.numerics.fourier_series import even_angles

PHI = even_angles(37) + 0.1


@pytest.mark.parametrize("b", [RADIUS, -RADIUS])
def test_normals_point_outward_whichever_way_the_curve_runs(b):
    circle = ellipse(b=b, centre=0.2)
    assert is_clockwise(circle) == (b < 0)
    assert outward_normals(circle, PHI) == pytest.approx((circle(PHI) - 0.2) / RADIUS, abs=1e-14)


@pytest.mark.parametrize("name", CURVES)
def test_distances(name):
    """Of points at a known distance along the normals, on both sides, smaller than every radius of curvature."""
    curve = CURVES[name]
    off = 1e-3 * np.sin(7 * PHI)
    assert curve_distances(curve, curve(PHI) + off * outward_normals(curve, PHI)) == pytest.approx(np.abs(off), abs=1e-12)


def test_a_curve_that_stands_still_has_no_normal():
    with refused("curve", code="cusp"):
        speed(cusped, even_angles(4096))
    with refused("curve", code="not-finite"):
        speed(broken, even_angles(4096))


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_the_tolerance_is_kept_and_made_use_of(name, tolerance):
    spline = fitted_spline(CURVES[name], tolerance)
    phi = np.linspace(0, 2 * math.pi, 33331)
    assert np.abs(spline(phi) - CURVES[name](phi)).max() <= tolerance
    assert (
        spline.pieces == 8
        or spline_deviation(CURVES[name], spline_through(CURVES[name], round(0.9 * spline.pieces))) > tolerance
    )


def test_it_closes_smoothly():
    """Up to the curvature; the third derivative jumps there, as at every knot."""
    spline = spline_through(lobes, 24)
    assert spline.control[0] == spline.control[-1]
    assert spline.knots[[0, 3, -4, -1]] == pytest.approx([0, 0, 2 * math.pi, 2 * math.pi], abs=1e-15)
    before, after = 2 * math.pi - 1e-12, 1e-12
    for order in range(3):
        assert spline(before, order) == pytest.approx(complex(spline(after, order)), abs=1e-10)
    assert abs(spline(before, 3) - spline(after, 3)) > 1e-3
    assert spline(2 * math.pi + 1.0) == pytest.approx(complex(spline(1.0)), rel=1e-12)


def test_what_will_not_do():
    with refused("tolerance", given=0, code="not-positive"):
        fitted_spline(lobes, 0)
    with refused("tolerance", "65536", given=1e-20):
        fitted_spline(lobes, 1e-20)
    with refused("curve", code="not-finite"):
        fitted_spline(broken, 1e-3)
