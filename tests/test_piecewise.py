"""Piecewise cubics: their values against NumPy's and SciPy's interpolation, their derivatives, their life inside SymPy."""

import copy
import pickle

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import CubicSpline, PchipInterpolator
from tests.refusals import rejected

from wucht.piecewise import Pieces, PiecewiseCubic, interpolated_pieces, step

x, t = sp.symbols("x t", real=True)
TIMES, VALUES = [-2.0, -0.5, 1.0, 1.25, 4.0], [1.0, -3.0, 2.0, 2.0, 0.5]
INSIDE = np.linspace(-2.0, 4.0, 997)
OUTSIDE = np.array([-50.0, -2.000001, 4.000001, 1e6])
KINDS = ("steps", "linear", "smooth", "monotone", "spline")


def held(points):
    """VALUES at TIMES, constant outside."""
    return np.where(points < TIMES[0], VALUES[0], VALUES[-1])


@pytest.mark.parametrize(
    ("kind", "reference"),
    [
        ("linear", lambda p: np.interp(p, TIMES, VALUES)),
        ("monotone", PchipInterpolator(TIMES, VALUES)),
        ("spline", CubicSpline(TIMES, VALUES, bc_type="clamped")),
        ("steps", lambda p: np.array(VALUES)[np.searchsorted(TIMES, p, side="right") - 1]),
    ],
)
def test_between_points_as_numpy_and_scipy(kind, reference):
    function = interpolated_pieces("f", TIMES, VALUES, kind)
    assert function(INSIDE) == pytest.approx(reference(INSIDE), abs=1e-13)
    assert function(OUTSIDE) == pytest.approx(held(OUTSIDE), abs=0)


def test_smooth_goes_from_value_to_value_without_slope_or_overshoot():
    """Between two points 3 s^2 - 2 s^3 of the way: half the way in the middle, 0.15625 of it after a quarter."""
    function = interpolated_pieces("f", TIMES, VALUES, "smooth")
    assert function(np.array(TIMES)) == pytest.approx(VALUES, abs=1e-14)
    assert function.derivative(np.array(TIMES)) == pytest.approx(0, abs=1e-13)
    assert function.derivative(np.array(TIMES) - 1e-9) == pytest.approx(0, abs=1e-7)
    assert function(-2 + 1.5 / 4) == pytest.approx(1 - 4 * 0.15625, abs=1e-14)
    assert function(-1.25) == pytest.approx(-1.0, abs=1e-14)
    assert (np.diff(function(INSIDE[INSIDE <= -0.5])) <= 0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_the_derivative_is_the_slope(kind):
    """Against central differences of 1e-6, away from breakpoints; those are right to 1e-9 for cubics of order one."""
    function, h = interpolated_pieces("f", TIMES, VALUES, kind), 1e-6
    smooth = np.array([p for p in INSIDE if np.abs(p - np.array(TIMES)).min() > 2 * h])
    slope = (function(smooth + h) - function(smooth - h)) / (2 * h)
    assert function.derivative(smooth) == pytest.approx(slope, abs=2e-8)


def test_at_a_breakpoint_the_value_from_the_right_holds():
    heaviside = step("H", 2.0, -1.0, 5.0)
    assert heaviside(2.0) == 5.0
    assert heaviside(np.nextafter(2.0, -1)) == -1.0
    assert interpolated_pieces("f", [0, 1, 2], [4, 5, 6], "steps")(1.0) == 5.0


def test_jumps_are_where_the_value_jumps():
    assert step("H", 2.0, -1.0, 5.0).jumps() == (2.0,)
    assert step("H", 2.0, 3.0, 3.0).jumps() == ()
    assert interpolated_pieces("f", [0, 1, 2, 3], [4, 5, 5, 7], "steps").jumps() == (
        1.0,
        3.0,
    )  # 4 holds before the first point too
    for kind in KINDS[1:]:
        assert interpolated_pieces("f", TIMES, VALUES, kind).jumps() == ()
    assert Pieces("f", (0.0, 1.0), ((0, 0, 0, 0), (0, 1, 0, 0), (2, 0, 0, 0))).jumps() == (1.0,)


@pytest.mark.parametrize(
    ("breakpoints", "coefficients", "refusal"),
    [
        ((2.0, 1.0), np.zeros((3, 4)), rejected("not-increasing")),
        ((1.0, np.nan), np.zeros((3, 4)), rejected("not-increasing")),
        ((1.0,), [[np.nan, 0, 0, 0], [0, 0, 0, 0]], rejected("not-increasing")),
        ((1.0, 2.0), np.zeros((2, 4)), rejected("count", "2", "3", "4")),
        ((1.0,), np.zeros((2, 3)), rejected("count", "1", "2", "4")),
    ],
)
def test_what_is_no_function_is_refused(breakpoints, coefficients, refusal):
    with refusal:
        Pieces("f", breakpoints, coefficients)


def test_equal_pieces_are_one_symbolic_function():
    one, other = (PiecewiseCubic(x, interpolated_pieces("f", TIMES, VALUES, "linear")) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)
    assert one - other == 0
    different = PiecewiseCubic(x, interpolated_pieces("f", TIMES, [1.0, -3.0, 2.0, 2.0, 0.6], "linear"))
    assert one != different
    assert one != PiecewiseCubic(x, interpolated_pieces("g", TIMES, VALUES, "linear"))
    assert copy.deepcopy(one) == one
    assert pickle.loads(pickle.dumps(one.args[1])) == one.args[1]


def test_the_chain_rule():
    pieces = interpolated_pieces("f", TIMES, VALUES, "monotone")
    derivative = sp.diff(PiecewiseCubic(x**2 - 1, pieces), x)
    assert derivative == 2 * x * PiecewiseCubic(x**2 - 1, pieces.derivative)
    assert sp.diff(PiecewiseCubic(x, pieces), t) == 0
    assert sp.diff(PiecewiseCubic(x * t, pieces) ** 2, t) == 2 * x * PiecewiseCubic(x * t, pieces) * PiecewiseCubic(
        x * t, pieces.derivative
    )


def test_a_number_gives_a_number():
    pieces = interpolated_pieces("f", TIMES, VALUES, "linear")
    assert PiecewiseCubic(sp.Rational(1, 4), pieces) == pytest.approx(-0.5)
    assert PiecewiseCubic(x, pieces).subs(x, sp.Rational(1, 4)) == pytest.approx(-0.5)
    assert PiecewiseCubic(x, pieces).is_real


@pytest.mark.parametrize(
    ("first", "second", "jumps"),
    [
        ((0, 1, 0, 0), (1e-13, 0, 0, 0), (0.0,)),  # small as it is, it is as large as the values are
        ((0, 1, 0, 0), (0, 2, 0, 0), ()),
        ((1e6, 0, 0, 0), (1e6 + 1e-9, 0, 0, 0), ()),  # rounding
        ((0, 0, 0, 0), (0, 1, 0, 0), ()),
    ],
)
def test_what_is_a_jump_is_said_by_the_size_of_the_values(first, second, jumps):
    assert Pieces("f", (0.0,), (first, second)).jumps() == jumps
