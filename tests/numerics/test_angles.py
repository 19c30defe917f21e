"""Minima of functions of an angle, and the arcs on which they are negative."""

import math

import numpy as np
import pytest

from wucht.numerics.angles import STEP, arcs_below_zero, valleys, wrap_angle, wrap_to_pi

TURN, PI = 2 * math.pi, math.pi


def test_arcs_below_zero():
    assert arcs_below_zero(np.cos) == (pytest.approx((PI / 2, 3 * PI / 2), abs=1e-15),)
    assert arcs_below_zero(lambda x: -np.cos(x)) == (pytest.approx((3 * PI / 2, 5 * PI / 2), abs=1e-14),)
    assert arcs_below_zero(lambda x: np.cos(x) - 2) == ((0.0, TURN),)
    assert arcs_below_zero(lambda x: np.cos(x) + 2) == ()
    centre = 1.0 + 0.4 * STEP
    ((begin, end),) = arcs_below_zero(lambda x: 1 - np.cos(x - centre) - 1e-8)
    assert (begin, end) == pytest.approx((centre - math.sqrt(2e-8), centre + math.sqrt(2e-8)), abs=1e-9)


def test_valleys_of_functions_with_kinks_and_jumps():
    at, least = valleys(lambda x: np.abs(np.sin(x - 1.0001)) + 0.3)
    assert np.sort(at) == pytest.approx([1.0001, 1.0001 + PI], abs=1e-9)
    assert least == pytest.approx([0.3, 0.3], abs=1e-9)
    _, least = valleys(lambda x: np.where(np.mod(x, TURN) < 2.00003, -np.mod(x, TURN), 5.0))
    assert least.min() == pytest.approx(-2.00003, abs=1e-9)


@pytest.mark.parametrize("shift", [0.5 * STEP, -0.5 * STEP])
def test_arcs_that_begin_or_end_just_beside_a_whole_turn(shift):
    """Between the last sample of a turn and the first, and between the first and the second."""
    begin, end = PI + shift, TURN + shift
    assert arcs_below_zero(lambda x: np.sin(x - shift)) == (pytest.approx((begin, end), abs=1e-14),)
    assert arcs_below_zero(lambda x: -np.sin(x - shift)) == (
        pytest.approx((shift % TURN, PI + shift + (TURN if shift < 0 else 0.0)), abs=1e-14),
    )


def test_angles_in_one_turn():
    """From zero on, where a rounding below a whole turn is zero; or from -pi on."""
    angles = np.array([[-0.5, 7.0], [-3 * TURN, TURN - 0.9e-9]])
    assert wrap_angle(angles) == pytest.approx(np.array([[TURN - 0.5, 7.0 - TURN], [0.0, 0.0]]))
    assert wrap_angle(angles).shape == (2, 2)
    assert wrap_angle(TURN - 1.1e-9) == pytest.approx(TURN) and wrap_angle(-1e-12) == 0.0 and wrap_angle(1e-12) == 1e-12
    assert wrap_to_pi(np.array([3.0, 4.0, -4.0, 9.5])) == pytest.approx([3.0, 4.0 - TURN, TURN - 4.0, 9.5 - 2 * TURN])
    assert wrap_to_pi(PI) == wrap_to_pi(-PI) == -PI and wrap_to_pi(0.0) == 0.0
