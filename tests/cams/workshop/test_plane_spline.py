"""The closed spline keeps its tolerance, with few pieces, and is smooth where it closes."""

import math

import numpy as np
import pytest
from curves_to_mill import CURVES, broken, ellipse, lobes
from tests.refusals import refused

from wucht.cams.workshop.closed_curve import distances
from wucht.cams.workshop.plane_spline import fitted_spline, spline_deviation, spline_through


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


def test_of_fourth_order():
    coarse, fine = (spline_deviation(lobes, spline_through(lobes, n)) for n in (100, 200))
    assert coarse / fine == pytest.approx(16, rel=0.05)


def test_it_passes_through_the_points():
    phi = np.arange(24) * math.pi / 12
    assert spline_through(lobes, 24)(phi) == pytest.approx(lobes(phi), abs=1e-16)


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


def test_the_deviation_is_never_less_than_the_distance():
    spline = spline_through(ellipse(0.08, 0.02), 10)
    from_the_curve = distances(ellipse(0.08, 0.02), spline(np.linspace(0, 2 * math.pi, 5000)))
    assert 0 < from_the_curve.max() <= spline_deviation(ellipse(0.08, 0.02), spline)


def test_what_will_not_do():
    with refused("tolerance", given=0, code="not-positive"):
        fitted_spline(lobes, 0)
    with refused("tolerance", "65536", given=1e-20):
        fitted_spline(lobes, 1e-20)
    with refused("curve", code="not-finite"):
        fitted_spline(broken, 1e-3)
