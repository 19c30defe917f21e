"""Exact means and antiderivatives of mean zero, against integrals that SymPy finds and known ones; refusals with a reason."""

import pytest
import sympy as sp
from pytest import raises
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.means import antiderivative, mean
from wucht.mechanics.trigonometric import common_period, harmonics
from wucht.system import TIME

a, b, p, q = sp.symbols("a b p q", real=True)
W = sp.Symbol("Omega", positive=True)
t, TURN = TIME, 2 * sp.pi


def zero(expression):
    return sp.simplify(sp.expand(sp.sympify(expression).rewrite(sp.exp))) == 0


@pytest.mark.parametrize(
    "expression",
    [
        sp.S.Zero,
        a + b * p,
        sp.cos(t) ** 2 * a + sp.sin(t) ** 4 * b,
        (a + b * sp.cos(t)) ** 3 * sp.sin(2 * t + p),
        sp.cos(t + p) * sp.cos(t + q) * sp.sin(2 * t),
        sp.cos(3 * t) * (sp.sin(t) + a * sp.cos(t)) ** 3,
        sp.exp(a) * sp.cos(t) ** 2 / (1 + b**2),
        sp.exp(sp.I * t) * sp.exp(-2 * sp.I * t) * sp.exp(sp.I * (t + p)),
        sp.tan(p) * sp.sin(-t) * sp.sin(t),
    ],
)
def test_means_are_the_integrals_over_a_period(expression):
    # The sum of values at n equidistant angles is exact for harmonics below n: an independent mean without an integral.
    n = 16
    by_sum = sp.Add(*(expression.xreplace({t: TURN * k / n}) for k in range(n))) / n
    assert zero(
        sp.N((mean(expression, t) - by_sum).xreplace({a: 0.3, b: 0.7, p: 0.4, q: 1.1}), 30, chop=True).evalf(chop=1e-12)
    )


def test_an_antiderivative_has_mean_zero_and_its_derivative_is_what_oscillates():
    e = (1 + a * sp.cos(W * t + p)) ** 2 * sp.sin(3 * W * t) + b
    primitive = antiderivative(e, t)
    assert zero(sp.diff(primitive, t) - e + mean(e, t))
    assert mean(primitive, t) == 0


def test_phases_come_out_as_differences():
    """<sin(t + p) cos(t + q)> = sin(p - q)/2, 001 (19)."""
    assert mean(sp.sin(t + p) * sp.cos(t + q), t) == sp.sin(p - q) / 2


def test_frequencies_may_be_parameters_and_need_no_common_period():
    root = sp.sqrt(2)
    assert mean(sp.cos(t) * sp.cos(root * t) + sp.cos(root * t) ** 2, t) == sp.Rational(1, 2)
    assert mean(sp.cos(root * t) * sp.cos(sp.sqrt(3) * t) * sp.cos((root + sp.sqrt(3)) * t), t) == sp.Rational(1, 4)
    assert mean(sp.cos(W * t) ** 2 * a, t) == a / 2
    assert harmonics(sp.cos(W * t) * sp.sin(W * t), t).frequencies == (2 * W,)


def test_what_cancels_is_no_frequency():
    assert harmonics(sp.cos(t) ** 2 + sp.sin(t) ** 2, t).frequencies == ()
    assert mean(1 / (a + sp.cos(t) ** 2 + sp.sin(t) ** 2), t) == 1 / (a + 1)
    # A difference that vanishes by algebra: (sqrt(2) - 1)^2 = 3 - 2 sqrt(2).
    assert mean(sp.cos((sp.sqrt(2) - 1) ** 2 * t) * sp.cos((3 - 2 * sp.sqrt(2)) * t), t) == sp.Rational(1, 2)


@pytest.mark.parametrize(
    "expression, expected",
    [
        (1 / (2 + sp.cos(t)), 1 / sp.sqrt(3)),
        (1 / (5 + 4 * sp.cos(t)) ** 2, sp.Rational(5, 27)),  # a/(a^2 - b^2)^(3/2)
        (a * sp.sin(W * t) ** 2 / (5 + 3 * sp.cos(W * t)), a / 9),  # (5 - 4)/9
        (sp.sin(t) / (3 + sp.sin(t)), 1 - 3 / sp.sqrt(8)),
        (1 / (2 + sp.cos(t) * sp.sin(t)), 2 / sp.sqrt(15)),
        (sp.cos(t) / (1 + sp.sin(2 * t) ** 2), 0),
    ],
)
def test_rational_functions_by_their_poles(expression, expected):
    assert zero(mean(expression, t) - expected)


def test_decimal_frequencies_are_what_they_are_written_as():
    """3 * 0.1 - 0.3 is 5.6e-17 in binary numbers, which would be a very slow oscillation."""
    e = sp.cos(0.1 * t) ** 3 * sp.cos(0.3 * t)
    assert mean(e, t) == sp.Rational(1, 8)
    assert common_period(harmonics(e, t).frequencies) == 10 * sp.pi


def test_common_periods():
    assert common_period([W, 3 * W / 2]) == 4 * sp.pi / W
    assert common_period([sp.Rational(2, 3), sp.Integer(4)]) == 3 * sp.pi
    assert common_period([sp.Integer(5)]) == TURN / 5
    assert common_period([sp.S.One, sp.sqrt(2)]) is None
    assert common_period([]) is None


@pytest.mark.parametrize(
    "expression, sentence",
    [
        (t * sp.cos(t), "secular"),
        (t**2, "secular"),
        (sp.sqrt(t), "secular"),
        (t / (2 + sp.cos(t)), "secular"),
        (sp.exp(-t), "no period that is certain"),
        (sp.cos(t**2), "does not grow evenly"),
        (sp.Abs(sp.cos(t)), "no rational function"),
        (sp.exp(sp.cos(t)), "no rational function"),
        (1 / sp.cos(t), "pole"),
        (sp.tan(t), "pole"),
        (1 / (a + sp.cos(t)), "depend on parameters"),
        (1 / (3 + sp.cos(t) + sp.cos(sp.sqrt(2) * t)), "no period that is certain"),
    ],
)
def test_refusals(expression, sentence):
    with raises(WuchtError, match=sentence):
        mean(expression, t)


def test_an_antiderivative_of_a_rational_function_is_refused():
    with rejected("denominator"):
        antiderivative(1 / (2 + sp.cos(t)), t)
