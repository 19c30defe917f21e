"""Points keep the chord tolerance, and are not many more than that takes."""

import math

import numpy as np
import pytest
from curves_to_mill import CURVES, RADIUS, broken, cusped, ellipse, lobes
from tests.refusals import refused

from wucht.cams.workshop.points import FINE, chord_deviation, chord_points, even_points, rounding_warning


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


@pytest.mark.parametrize(
    ("ask", "refusal"),
    [
        (lambda: chord_points(ellipse(), 0.0), refused("tolerance", given=0.0, code="not-positive")),
        (lambda: chord_points(ellipse(), 1e-3, spacing=-1.0), refused("spacing", given=-1.0, code="not-positive")),
        (lambda: chord_points(ellipse(), 1e-3, least=2), refused("least", given=2, code="whole-number")),
        (lambda: chord_points(broken, 1e-3), refused("curve", code="not-finite")),
        (lambda: chord_points(cusped, 1e-3), refused("curve", code="cusp")),
        (lambda: chord_points(ellipse(), 1e-16), refused("tolerance", "2000000", given=1e-16)),
    ],
)
def test_what_will_not_do(ask, refusal):
    with refusal:
        ask()


def test_a_warning_from_a_hundredth_of_h2_over_r_on():
    points = even_points(ellipse(), 360)
    height = points.spacing[0] ** 2 / RADIUS
    assert rounding_warning(ellipse(), points, 0.999 * FINE * height) is None
    assert rounding_warning(ellipse(), points, 1.001 * FINE * height) is not None


def test_the_densest_place_counts():
    """On an ellipse h^2/r = a b d^2/v with the speed v, smallest where it is flat, as far as r stays below R = length/(2 pi).

    There v^3 = a b R.
    """
    a, b, d = 0.05, 0.04, 2 * math.pi / 360
    points = even_points(ellipse(a, b), 360)
    limit = FINE * a * b * d**2 / (a * b * points.spacing.sum() / (2 * math.pi)) ** (1 / 3)
    assert rounding_warning(ellipse(a, b), points, 0.99 * limit) is None
    assert rounding_warning(ellipse(a, b), points, 1.01 * limit) is not None
