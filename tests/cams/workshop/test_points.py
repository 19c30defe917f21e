"""Points keep the chord tolerance, and are not many more than that takes."""

import math

import numpy as np
import pytest
from curves_to_mill import CURVES, RADIUS, broken, cusped, ellipse, hollow, lobes
from tests.refusals import refused

from wucht.cams.workshop.points import FINE, WORST, chord_deviation, chord_points, even_points, rounding_warning
from wucht.numerics.fourier_series import even_angles


def farthest(curve, points):
    """The largest distance of the polygon's chords from the curve, on a grid of its own."""
    ends = np.append(points.phi, 2 * math.pi)
    share = np.linspace(0, 1, 102)
    c = curve(ends[:-1, None] + np.diff(ends)[:, None] * share)
    chord = c[:, -1:] - c[:, :1]
    return np.abs(((c - c[:, :1]) * chord.conj()).imag / np.abs(chord)).max()


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-7])
def test_the_tolerance_is_kept_and_made_use_of(name, tolerance):
    points = chord_points(CURVES[name], tolerance)
    assert 0.5 * tolerance < farthest(CURVES[name], points) <= tolerance
    assert chord_deviation(CURVES[name], points.phi) == pytest.approx(farthest(CURVES[name], points), rel=0.005)


@pytest.mark.parametrize("tolerance", [5e-3, 1e-5, 1e-8])
def test_as_many_points_as_a_circle_needs(tolerance):
    """N = pi/acos(1 - tolerance/R), and a hundredth of the tolerance to spare."""
    ideal = math.pi / math.acos(1 - tolerance / RADIUS)
    assert ideal <= len(chord_points(ellipse(), tolerance).phi) <= 1.01 * ideal + 1


def test_fewer_points_where_the_curve_is_flat():
    points = chord_points(ellipse(0.08, 0.02), 1e-6)
    assert points.spacing.max() > 5 * points.spacing.min()
    same = next(n for n in range(len(points.phi), 10**4) if chord_deviation(ellipse(0.08, 0.02), even_angles(n)) <= 1e-6)
    assert len(points.phi) < 0.98 * same  # the ellipse's own parameter is a good one already


@pytest.mark.parametrize("name", CURVES)
def test_points_lie_on_the_curve_in_order_each_once(name):
    points = chord_points(CURVES[name], 1e-5)
    assert points.phi[0] == 0
    assert (np.diff(points.phi) > 0).all()
    assert points.phi[-1] < 2 * math.pi
    assert np.array_equal(points.position, CURVES[name](points.phi))
    assert points.spacing.min() > 0.3 * points.spacing[-1] > 0
    assert np.abs(points.normal) == pytest.approx(np.ones(len(points.phi)), rel=1e-14)


def test_the_longest_chord_is_limited():
    free, limited = chord_points(lobes, 1e-4), chord_points(lobes, 1e-4, spacing=1e-3)
    assert free.spacing.max() > 1e-3 >= limited.spacing.max() > 0.9e-3
    assert len(limited.phi) < 1.05 * limited.spacing.sum() / 1e-3


def test_the_longest_chord_is_measured_too():
    """With a length that is a whole number of chords, none is left to make up for what the density is off."""
    spacing = 2 * math.pi * np.abs(lobes(even_angles(10**4), 1)).mean() / 5000 * (1 + 1e-12)
    assert chord_points(lobes, 1e-4, spacing=spacing).spacing.max() <= spacing


def test_there_are_at_least_so_many():
    assert len(chord_points(ellipse(), 1e-3, least=500).phi) == 500
    assert len(chord_points(ellipse(), 1.0).phi) == 3


def test_evenly_spaced_in_the_cam_angle():
    points = even_points(lobes, 360)
    assert points.phi == pytest.approx(np.radians(np.arange(360)), abs=1e-15)
    assert np.array_equal(points.position, lobes(points.phi))


def test_the_deviation_of_a_polygon():
    assert chord_deviation(ellipse(), even_angles(6)) == pytest.approx(RADIUS * (1 - math.cos(math.pi / 6)), rel=1e-9)


@pytest.mark.parametrize(
    ("ask", "refusal"),
    [
        (lambda: chord_points(ellipse(), 0.0), refused("tolerance", given=0.0, code="not-positive")),
        (lambda: chord_points(ellipse(), math.nan), refused("tolerance", given=float("nan"), code="not-positive")),
        (lambda: chord_points(ellipse(), 1e-3, spacing=-1.0), refused("spacing", given=-1.0, code="not-positive")),
        (lambda: chord_points(ellipse(), 1e-3, least=2), refused("least", given=2, code="whole-number")),
        (lambda: even_points(ellipse(), 2), refused("count", given=2, code="whole-number")),
        (lambda: chord_points(broken, 1e-3), refused("curve", code="not-finite")),
        (lambda: even_points(broken, 10), refused("curve", code="not-finite")),
        (lambda: chord_points(cusped, 1e-3), refused("curve", code="cusp")),
        (lambda: chord_points(ellipse(), 1e-16), refused("tolerance", "2000000", given=1e-16)),
    ],
)
def test_what_will_not_do(ask, refusal):
    with refusal:
        ask()


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
