"""Cubic Hermite interpolation, and where it reaches a value."""

import numpy as np
import pytest

from wucht.numerics.interpolation import between, where_reached

CUBIC = np.polynomial.Polynomial([0.3, -1.2, 0.7, 2.5])
UNIT = np.array([0.0, 1.0])


def hermite(at, x, y, slope):
    """At points, by the samples around each, or by the outermost ones."""
    i = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    return between((at - x[i]) / (x[i + 1] - x[i]), x, y, slope, i)


def test_cubics_are_exact_and_go_on_beyond_the_ends():
    x = np.array([-1.0, -0.4, 0.1, 0.15, 2.0])
    at = np.array([-1.3, -1.0, -0.7, -0.4, 0.0, 0.12, 1.0, 2.0, 2.2])
    both = np.array([CUBIC(x), -2 * CUBIC(x)]), np.array([CUBIC.deriv()(x), -2 * CUBIC.deriv()(x)])
    assert hermite(at, x, CUBIC(x), CUBIC.deriv()(x)) == pytest.approx(CUBIC(at), rel=1e-13, abs=1e-13)
    assert hermite(at, x, *both)[1] == pytest.approx(-2 * CUBIC(at), rel=1e-13, abs=1e-13)


def test_samples_are_met_exactly():
    x = np.array([0.1, 0.4, 1.1, 1.3])
    y, slope = np.sin(7 * x), 7 * np.cos(7 * x)
    i = np.arange(3)
    assert np.array_equal(between(np.zeros(3), x, y, slope, i), y[:-1])
    assert between(np.ones(3), x, y, slope, i) == pytest.approx(y[1:], rel=1e-15)


def test_the_error_is_of_fourth_order():
    """The cubic is off by h^4/384 of the fourth derivative in the middle between samples, where that is alike."""
    errors = []
    for n in (11, 21, 41, 81):
        x = np.linspace(0, 3, n)
        errors.append(np.abs(hermite((x[1:] + x[:-1]) / 2, x, np.sin(x), np.cos(x)) - np.sin((x[1:] + x[:-1]) / 2)).max())
    assert errors == pytest.approx([(3 / n) ** 4 / 384 for n in (10, 20, 40, 80)], rel=0.02)


# Of rise 1, and monotone between as long as both are at most 3 (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 1980).
SLOPES = [(a, b) for a in (0.0, 1e-9, 0.5, 1.0, 3.0) for b in (0.0, 1e-9, 0.5, 1.0, 3.0)]


@pytest.mark.parametrize(("first", "last"), SLOPES)
@pytest.mark.parametrize("rise", [1.0, -3e-4, 5e6])
def test_the_place_where_a_monotone_cubic_has_a_value(first, last, rise):
    wanted = np.array([0.0, 1e-12, 1e-7, 1e-3, 0.1, 1 / 3, 0.5, 0.9, 1 - 1e-3, 1 - 1e-7, 1 - 1e-12, 1.0])
    x, y, slope = np.array([2.0, 2.5]), rise * UNIT, 2 * rise * np.array([first, last])
    i = np.zeros(len(wanted), int)
    share = where_reached(rise * wanted, x, y, slope, i)
    assert ((share >= 0) & (share <= 1)).all()
    assert between(share, x, y, slope, i) / rise == pytest.approx(wanted, rel=0, abs=2e-14)


def test_a_body_that_starts_from_rest():
    """y = s^2: the slope at the beginning is zero."""
    y = np.array([1e-8, 1e-4, 0.01, 0.25, 0.81])
    share = where_reached(y, UNIT, UNIT, np.array([0.0, 2.0]), np.zeros(5, int))
    assert share == pytest.approx(np.sqrt(y), rel=1e-9)


def test_a_cubic_that_overshoots_is_met_once_between_its_ends():
    y, slope, i = np.array([0.0, 1.0]), np.array([-2.0, 9.0]), np.zeros(5, int)
    wanted = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    share = where_reached(wanted, UNIT, y, slope, i)
    assert ((share >= 0) & (share <= 1)).all()
    assert between(share, UNIT, y, slope, i) == pytest.approx(wanted, abs=1e-13)


def test_one_place_does_not_depend_on_the_others_that_are_sought():
    draw = np.random.default_rng(1)
    x, y = np.arange(401.0), np.cumsum(draw.uniform(0.5, 1.5, 401))
    slope = draw.uniform(0.0, 1.5, 401) * (draw.random(401) < 0.7)
    i = np.arange(400)
    wanted = y[i] + draw.random(400) ** 4 * np.diff(y)
    alone = [where_reached(wanted[[k]], x, y, slope, i[[k]])[0] for k in i]
    assert np.array_equal(where_reached(wanted, x, y, slope, i), alone)
