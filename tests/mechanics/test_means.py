"""Exact means and antiderivatives of mean zero, against integrals that SymPy finds and known ones; refusals with a reason."""

import math
import time

import numpy as np
import pytest
import sympy as sp
from pytest import approx, raises
from scipy.integrate import quad
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.means import antiderivative, mean
from wucht.mechanics.trigonometric import common_period, trigonometric_polynomial
from wucht.mechanics.zero_testing import is_identically_zero
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import TIME, System

t = TIME
x, y, p, epsilon = sp.symbols("x y p epsilon", real=True)
W = sp.Symbol("Omega", positive=True)
AT = {x: 0.7, y: -0.4, p: 0.3, W: 1}
BEARABLE = 20.0
"""Seconds of processor time that no expression below may take; measured: below 1.5 s."""
c, s = sp.cos, sp.sin


def zero(expression):
    return sp.simplify(expression) == 0


@pytest.mark.parametrize(
    "expression",
    [
        -x / (2 + c(t)) + s(t) * x**2 / (3 + s(t)) ** 2,
        x / (2 + c(t)) + y / (3 + s(t)) + s(2 * t) * x * y / (5 + 2 * c(2 * t)),
        y / (2 + s(t)) ** 3,
        c(2 * t) / (3 + c(t)) ** 3,
        1 / ((2 + c(t)) * (3 + s(t))),
        1 / (sp.pi + c(t) + 2 * s(t)),
        s(t) / (1 + 1 / (2 + c(t))),
        sp.tan(t) ** 2 / (2 + sp.tan(t) ** 2),
        c(t + p) / (2 + c(t + x)),
        (y * c(t + p) + s(2 * t + p)) / (2 + s(t + x)),
        s(t) / (2 * x + x * c(t + y)),
        c(t / 2) / (2 + c(t)),
        x / (1 + c(t) ** 2 + s(t) ** 2) + 1 / (2 + c(t)),
        s(t) ** 8 / (1.5 + c(t)),
    ],
)
def test_the_mean_is_real_and_that_of_a_quadrature(expression):
    begin = time.process_time()
    value = mean(expression, t)
    assert time.process_time() - begin < BEARABLE
    assert not value.has(sp.I)
    numbers = sp.lambdify(t, expression.subs(AT), "math")
    by_quadrature = quad(numbers, 0, 4 * math.pi, epsabs=1e-12, epsrel=1e-12, limit=400)[0] / (4 * math.pi)
    assert float(sp.N(value.subs(AT))) == approx(by_quadrature, abs=1e-10)


def test_known_integrals():
    """<1/(A + B cos + C sin)> = 1/sqrt(A^2 - B^2 - C^2)."""
    assert zero(mean(1 / (2 + s(t) + c(t)), t) - 1 / sp.sqrt(2))
    assert is_identically_zero(mean(1 / (sp.pi + c(t) + 2 * s(t)), t) - 1 / sp.sqrt(sp.pi**2 - 5))
    assert zero(mean(x / (2 + c(t)) + y / (2 + c(sp.sqrt(2) * t)), t) - (x + y) / sp.sqrt(3))  # a period of its own each
    near = sp.Rational(10**12 + 1, 10**12)  # poles at 1.4e-6 from the circle
    assert zero(mean(1 / (near + c(t)), t) - 1 / sp.sqrt(near**2 - 1))


@pytest.mark.parametrize(
    "expression, sentence",
    [
        ((x * y**2 + s(t)) / (3 + c(t) + s(2 * t) / 2), "no short closed form"),
        (1 / (2 + c(t) + s(3 * t) / 2), "no short closed form"),
        (1 / ((3 + s(t)) ** 2 * (2 + c(t)) * (4 + c(2 * t))), "no short closed form"),
        (1 / (2 + c(t)) ** 9, "degree in sines and cosines is 9, more than 8"),
        (1 / (1 + c(t)), "pole"),
        (x / (c(t) ** 2 + s(t) ** 2 - 1) + 1 / (2 + c(t)), "is zero at all times"),
        (1 / (2 + sp.exp(sp.I * t) + c(t)), "not real"),
        (1 / (2 + c(t) + c(2 * t + x)), "depend on parameters or states"),
        (1 / (2 + p * c(t)), "depend on parameters or states"),
        (sp.exp(-t) * c(t), "neither a sine nor a cosine"),
        (c(sp.sqrt(W) * t) / (2 + c(t)), "is not known to be rational"),
    ],
)
def test_refusals(expression, sentence):
    begin = time.process_time()
    with raises(WuchtError, match=sentence):
        mean(expression, t)
    assert time.process_time() - begin < BEARABLE


def test_the_averaged_system_compiles():
    """x' = -a x - b x^2 by hand: x = a/((a/x_0 + b) exp(a t) - b)."""
    rate = epsilon * (-x / (2 + c(t)) + s(t) * x**2 / (3 + s(t)) ** 2)
    slow = averaged(System((x,), (rate,), (epsilon,)), epsilon).system
    grid = np.linspace(0, 10, 3)
    run = integrate(compile_system(slow), [0.7], {"epsilon": 0.1}, grid)
    a, b = 0.1 / math.sqrt(3), 0.1 * math.sqrt(2) / 32
    assert run.states[0] == approx(a / ((a / 0.7 + b) * np.exp(a * grid) - b), rel=1e-6)  # the default tolerance


a, b, q = sp.symbols("a b q", real=True)
TURN = 2 * sp.pi


def vanishes(expression):
    return sp.simplify(sp.expand(sp.sympify(expression).rewrite(sp.exp))) == 0


def test_an_antiderivative_has_mean_zero_and_its_derivative_is_what_oscillates():
    e = (1 + a * sp.cos(W * t + p)) ** 2 * sp.sin(3 * W * t) + b
    primitive = antiderivative(e, t)
    assert vanishes(sp.diff(primitive, t) - e + mean(e, t))
    assert mean(primitive, t) == 0


def test_phases_come_out_as_differences():
    """<sin(t + p) cos(t + q)> = sin(p - q)/2, 001 (19)."""
    assert mean(sp.sin(t + p) * sp.cos(t + q), t) == sp.sin(p - q) / 2


def test_frequencies_may_be_parameters_and_need_no_common_period():
    root = sp.sqrt(2)
    assert mean(sp.cos(t) * sp.cos(root * t) + sp.cos(root * t) ** 2, t) == sp.Rational(1, 2)
    assert mean(sp.cos(root * t) * sp.cos(sp.sqrt(3) * t) * sp.cos((root + sp.sqrt(3)) * t), t) == sp.Rational(1, 4)
    assert mean(sp.cos(W * t) ** 2 * a, t) == a / 2
    assert trigonometric_polynomial(sp.cos(W * t) * sp.sin(W * t), t).frequencies == (2 * W,)


def test_what_cancels_is_no_frequency():
    assert trigonometric_polynomial(sp.cos(t) ** 2 + sp.sin(t) ** 2, t).frequencies == ()
    assert mean(1 / (a + sp.cos(t) ** 2 + sp.sin(t) ** 2), t) == 1 / (a + 1)
    # A difference that vanishes by algebra: (sqrt(2) - 1)^2 = 3 - 2 sqrt(2).
    assert mean(sp.cos((sp.sqrt(2) - 1) ** 2 * t) * sp.cos((3 - 2 * sp.sqrt(2)) * t), t) == sp.Rational(1, 2)


def test_decimal_frequencies_are_what_they_are_written_as():
    """3 * 0.1 - 0.3 is 5.6e-17 in binary numbers, which would be a very slow oscillation."""
    e = sp.cos(0.1 * t) ** 3 * sp.cos(0.3 * t)
    assert mean(e, t) == sp.Rational(1, 8)
    assert common_period(trigonometric_polynomial(e, t).frequencies) == 10 * sp.pi


def test_common_periods():
    assert common_period([W, 3 * W / 2]) == 4 * sp.pi / W
    assert common_period([sp.Rational(2, 3), sp.Integer(4)]) == 3 * sp.pi
    assert common_period([sp.S.One, sp.Rational(1, 2), sp.Rational(1, 3)]) == 12 * sp.pi
    assert common_period([sp.Integer(5)]) == TURN / 5
    assert common_period([sp.S.One, sp.sqrt(2)]) is None
    assert common_period([]) is None


@pytest.mark.parametrize(
    "expression, sentence",
    [
        (sp.sqrt(t), "secular"),
        (t / (2 + sp.cos(t)), "secular"),
        (sp.cos(t**2), "is not linear in"),
        (sp.Abs(sp.cos(t)), "not a rational function"),
        (sp.exp(sp.cos(t)), "not a rational function"),
        (1 / sp.cos(t), "pole"),
        (1 / (3 + sp.cos(t) + sp.cos(sp.sqrt(2) * t)), "no certain period"),
    ],
)
def test_what_has_no_mean(expression, sentence):
    with raises(WuchtError, match=sentence):
        mean(expression, t)


def test_an_antiderivative_of_a_rational_function_is_refused():
    with rejected("denominator"):
        antiderivative(1 / (2 + sp.cos(t)), t)
