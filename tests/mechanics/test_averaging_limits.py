"""Where averaging ends: slow time, resonances, periods and parameters that are none; what stays where u is not known."""

import math

import pytest
import sympy as sp
from pytest import approx, raises
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.zero_testing import is_identically_zero
from wucht.system import TIME, Output, System

x, v, epsilon = sp.symbols("x v epsilon", real=True)


def zero(expression):
    return sp.simplify(expression) == 0


@pytest.mark.parametrize("which", [1, 2])
@pytest.mark.parametrize(
    "rate",
    [
        epsilon * x / (1 + epsilon * TIME),
        epsilon * x * (1 + epsilon * TIME),
        epsilon * x * sp.cos(epsilon * TIME**2),
        epsilon * sp.tanh(epsilon * TIME),
        epsilon * sp.sqrt(1 + epsilon * TIME),
        epsilon * sp.cos(TIME + epsilon * TIME**2),
        epsilon * sp.sin(x + sp.sin(epsilon * TIME) + TIME),
        epsilon * x * sp.exp(-epsilon * TIME),
        epsilon * sp.tan((1 + epsilon) * TIME) ** 2,
        epsilon * x + epsilon**2 * sp.exp(TIME),
    ],
)
def test_slow_time_is_refused(rate, which):
    """epsilon t grows to 1 in the time 1/epsilon over which the averaged equations are to hold."""
    with raises(WuchtError, match=r"slow time|frequency in .* depends on epsilon"):
        averaged(System((x,), (rate,), (epsilon,)), epsilon, which)


@pytest.mark.parametrize(
    "rate, mean",
    [
        (epsilon * sp.sin(x + epsilon * v * sp.cos(TIME)), sp.sin(x)),
        (epsilon * x / (1 + epsilon * sp.cos(TIME)), x),
        (epsilon * x * sp.exp(epsilon * sp.sin(TIME)), x),
        (epsilon * sp.Abs(x + epsilon * v), sp.Abs(x)),
    ],
)
def test_epsilon_beside_bounded_functions_of_time_is_no_slow_time(rate, mean):
    averaging = averaged(System((x, v), (rate, sp.S.Zero), (epsilon,)), epsilon)
    assert averaging.first == (mean, 0)


A, B = sp.symbols("a b", real=True)


@pytest.mark.parametrize(
    "wave, other",
    [
        ((A**2 - B**2) / (A - B), A + B),
        (1 / (1 / A + 1 / B), A * B / (A + B)),
        (sp.sqrt(A**2 + 2 * A * B + B**2), sp.Abs(A + B)),
        (2 * math.pi * 50, 100 * sp.pi),
        (1.4142135623730951, sp.sqrt(2)),
        (2 * math.pi * 50 * A, 100 * sp.pi * A),
    ],
)
def test_equal_frequencies_that_are_written_differently(wave, other):
    """<cos^2> is 1/2, and nothing is divided by a difference that is zero."""
    rate = epsilon * x * sp.cos(wave * TIME) * sp.cos(other * TIME)
    for which in (1, 2):
        averaging = averaged(System((x,), (rate,), (epsilon, A, B)), epsilon, which)
        assert averaging.first == (x / 2,)
        assert not any(is_identically_zero(w) for w in averaging.divisors)


def test_resonances_of_the_second_order_are_reported():
    """<(dX/dx) u> of cos(a t) and sin(b t) is zero unless a = b or a = -b."""
    averaging = averaged(
        System((x, v), (epsilon * v * sp.cos(A * TIME), epsilon * x * sp.sin(B * TIME)), (epsilon, A, B)), epsilon, 2
    )
    assert averaging.second == (0, 0)
    assert set(averaging.divisors) == {A, B, A - B, A + B}
    heat = Output("heat", sp.cos(A * TIME) * sp.cos(B * TIME))
    slow = averaged(System((x,), (epsilon,), (epsilon, A, B), quadratures=(heat,)), epsilon)
    assert set(slow.divisors) == {A - B, A + B}
    assert averaged(System((x,), (epsilon / (2 + sp.cos(A * TIME)),), (epsilon, A)), epsilon).divisors == (A,)


def test_the_period_is_of_all_that_is_averaged():
    halved = epsilon * x * sp.cos(TIME) + epsilon**2 * x * sp.cos(TIME / 4) ** 2
    assert averaged(System((x,), (halved,), (epsilon,)), epsilon, 2).period == 4 * sp.pi
    assert averaged(System((x,), (halved,), (epsilon,)), epsilon).period == 2 * sp.pi
    irrational = System((x,), (halved + epsilon**2 * x * sp.cos(sp.sqrt(2) * TIME),), (epsilon,))
    assert averaged(irrational, epsilon, 2).period is None
    with rejected("other-period", "2"):
        averaged(irrational, epsilon, 2, period=2 * sp.pi)


def test_outputs_stay_where_the_fast_part_is_not_known():
    """Of the slow states, with the error O(epsilon) that first order has anyway; nothing is called ``full.x`` that is not."""
    moving = sp.Symbol("moving", real=True)
    given = System(
        (x,), (epsilon * x / (2 + sp.cos(TIME)),), (epsilon,), ((moving, x * sp.cos(TIME)),),
        (Output("power", x**2 + moving, "W"),),
    )  # fmt: skip
    averaging = averaged(given, epsilon)
    assert [o.name for o in averaging.system.outputs] == ["power"]
    assert averaging.system.output("power").unit == "W"
    assert zero(averaging.system.explicit(averaging.system.output("power").expression) - x**2 - x * sp.cos(TIME))
    assert averaging.start == (x,)


@pytest.mark.parametrize(
    "small, refusal",
    [
        (x, rejected("no-parameter", "x")),
        (TIME, rejected("no-parameter", "t")),
        (sp.Symbol("mu", real=True), rejected("no-parameter")),
        (sp.Symbol("epsilon"), rejected("other-assumptions")),
        ("epsilon", rejected("no-symbol", "epsilon")),
        (2 * epsilon, rejected("no-symbol")),
    ],
)
def test_what_is_no_small_parameter_is_refused(small, refusal):
    with refusal:
        averaged(System((x,), (epsilon * x,), (epsilon,)), small)


@pytest.mark.parametrize("which", [0, 3, 1.0, 2.0, True, "2", None])
def test_orders_that_are_none_are_refused(which):
    with rejected("order", "1", "2"):
        averaged(System((x,), (epsilon * sp.cos(TIME),), (epsilon,)), epsilon, order=which)


def test_the_period_of_a_quotient_is_that_of_its_squares():
    system = System((x,), (epsilon / (2 + sp.cos(TIME) ** 2),), (epsilon,))
    assert averaged(system, epsilon).period == sp.pi
    assert averaged(system, epsilon, period=sp.pi).period == sp.pi


def test_periods_that_are_none_are_refused():
    system = System((x,), (epsilon * sp.cos(TIME),), (epsilon, A))
    assert averaged(system, epsilon, period=4 * sp.pi).period == 4 * sp.pi
    assert averaged(system, epsilon, period=2 * math.pi).period == approx(2 * math.pi)
    for wrong in (sp.pi, 3.0, 5.0, 12.0, A):
        with rejected("other-period"):
            averaged(system, epsilon, period=wrong)
    for wrong in (0, -2 * sp.pi, sp.oo, sp.I):
        with rejected("not-positive"):
            averaged(system, epsilon, period=wrong)
    with rejected("text"):
        averaged(system, epsilon, period="2*pi")
