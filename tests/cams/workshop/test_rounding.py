"""Coordinates must be rounded much more finely than h^2/r: measured, and said."""

import math

import numpy as np
import pytest
from curves_to_mill import RADIUS, ellipse, hollow, lobes
from tests.refusals import refused

from wucht.cams.workshop.points import even_points
from wucht.cams.workshop.rounding import FINE, WORST, rounding_warning


def rounded(position, step):
    return step * (np.round(position.real / step) + 1j * np.round(position.imag / step))


def second_difference(position):
    return np.roll(position, 1) - 2 * position + np.roll(position, -1)


@pytest.mark.parametrize("count", [360, 3600])
def test_second_differences_of_rounded_points(count):
    """Their largest error nears 2 sqrt(2) roundings, and does not pass it: the curvature's is that over h^2."""
    step = 1e-6
    points = even_points(ellipse(), count)
    off = np.abs(second_difference(rounded(points.position, step)) - second_difference(points.position))
    assert 0.6 * WORST * step < off.max() <= WORST * step


def test_a_warning_from_a_hundredth_of_h2_over_r_on():
    points = even_points(ellipse(), 360)
    height = points.spacing[0] ** 2 / RADIUS
    assert rounding_warning(ellipse(), points, 0.999 * FINE * height) is None
    assert rounding_warning(ellipse(), points, 1.001 * FINE * height) is not None


def test_at_the_limit_the_curvature_is_off_by_a_few_percent():
    points = even_points(ellipse(), 720)
    h = points.spacing[0]
    measured = np.abs(second_difference(rounded(points.position, FINE * h**2 / RADIUS))) / h**2
    assert 0.005 < np.abs(measured * RADIUS - 1).max() <= 0.0284


def test_the_sentence_gives_the_numbers_that_help():
    """Points every degree on R = 50 mm: h = 0.8727 mm, h^2/r = 15.23 um; of 1 um 2 sqrt(2)/15.23 = 18.6 %."""
    points = even_points(ellipse(), 360)
    sentence = rounding_warning(ellipse(), points, 1e-6)
    assert sentence == (
        "coordinates rounded to 1 um are too coarse for points 0.8727 mm apart on a radius of 50 mm: h^2/r is 15.23 um there "
        "(the sagitta 1.904 um), and second differences miss the curvature by up to 19 %; round to 0.1 um or finer, "
        "or take points 2.236 mm apart or more"
    )
    assert rounding_warning(ellipse(), points, 1e-7) is None
    fewer = even_points(ellipse(), math.floor(math.pi / math.asin(2.237e-3 / 2 / RADIUS)))
    assert rounding_warning(ellipse(), fewer, 1e-6) is None


def test_the_densest_place_counts():
    """On an ellipse h^2/r = a b d^2/v with the speed v, smallest where it is flat, as far as r stays below R = length/(2 pi).

    There v^3 = a b R.
    """
    a, b, d = 0.05, 0.04, 2 * math.pi / 360
    points = even_points(ellipse(a, b), 360)
    limit = FINE * a * b * d**2 / (a * b * points.spacing.sum() / (2 * math.pi)) ** (1 / 3)
    assert rounding_warning(ellipse(a, b), points, 0.99 * limit) is None
    assert rounding_warning(ellipse(a, b), points, 1.01 * limit) is not None


@pytest.mark.parametrize("curve", [lobes, hollow])
def test_where_the_curve_is_flat_a_circle_of_its_length_stands_for_it(curve):
    """Else every hollow cam would be warned of, at its points of inflection."""
    points = even_points(curve, 360)
    limit = FINE * points.spacing.min() ** 2 * 2 * math.pi / points.spacing.sum()
    assert rounding_warning(curve, points, 0.999 * limit) is None
    assert rounding_warning(curve, points, 5 * limit) is not None


@pytest.mark.parametrize("rounding", [0.0, -1e-6, math.nan])
def test_a_rounding_that_is_none(rounding):
    with refused("rounding", code="not-positive"):
        rounding_warning(ellipse(), even_points(ellipse(), 10), rounding)
