"""Means of quotients of sines and cosines, against quadratures and known integrals; refusals within bearable time."""

import math
import time

import numpy as np
import pytest
import sympy as sp
from pytest import approx, raises
from scipy.integrate import quad

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.means import mean
from wucht.mechanics.zero_testing import identically_zero
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.system import TIME, System

t = TIME
x, y, p, epsilon = sp.symbols("x y p epsilon", real=True)
W = sp.Symbol("Omega", positive=True)
AT = {x: 0.7, y: -0.4, p: 0.3, W: 1}
BEARABLE = 20.0
"""Seconds that no expression below may take, on a machine that does other things besides; measured: below 1.5 s."""
c, s = sp.cos, sp.sin


def zero(expression):
    return sp.simplify(expression) == 0


@pytest.mark.parametrize(
    "expression",
    [
        -x / (2 + c(t)) + s(t) * x**2 / (3 + s(t)) ** 2,
        1 / (2 + c(t)) + 1 / (3 + s(t)),
        1 / (2 + s(t) + c(t)),
        x / (2 + c(t)) + y / (3 + s(t)) + s(2 * t) * x * y / (5 + 2 * c(2 * t)),
        y / (2 + s(t)) ** 3,
        c(2 * t) / (3 + c(t)) ** 3,
        1 / ((2 + c(t)) * (3 + s(t))),
        1 / (sp.sqrt(5) + c(t)) ** 2,
        1 / (sp.pi + c(t) + 2 * s(t)),
        s(t) / (1 + 1 / (2 + c(t))),
        sp.tan(t) ** 2 / (2 + sp.tan(t) ** 2),
        c(t + p) / (2 + c(t + x)),  # a phase of the denominator may be a state
        s(t) / (2 * x + x * c(t + y)),  # and a common factor of it
        c(t / 2) / (2 + c(t)),
        x / (1 + c(t) ** 2 + s(t) ** 2) + 1 / (2 + c(t)),  # a denominator that only seems to turn
        (x + y * c(t)) ** 3 / (2 + c(t)) ** 2,
        s(t) ** 8 / (1.5 + c(t)),
        (x / (2 + c(W * t)) + y) * s(W * t + p),
    ],
)
def test_the_mean_is_real_and_that_of_a_quadrature(expression):
    begin = time.perf_counter()
    value = mean(expression, t)
    assert time.perf_counter() - begin < BEARABLE
    assert not value.has(sp.I)
    numbers = sp.lambdify(t, expression.subs(AT), "math")
    by_quadrature = quad(numbers, 0, 4 * math.pi, epsabs=1e-12, epsrel=1e-12, limit=400)[0] / (4 * math.pi)
    assert float(sp.N(value.subs(AT))) == approx(by_quadrature, abs=1e-10)


def test_known_integrals():
    """<1/(A + B cos + C sin)> = 1/sqrt(A^2 - B^2 - C^2)."""
    assert zero(mean(1 / (2 + s(t) + c(t)), t) - 1 / sp.sqrt(2))
    assert identically_zero(mean(1 / (sp.pi + c(t) + 2 * s(t)), t) - 1 / sp.sqrt(sp.pi**2 - 5))
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
        (c(sp.sqrt(W) * t) / (2 + c(t)), "is not certain"),
    ],
)
def test_refusals(expression, sentence):
    begin = time.perf_counter()
    with raises(WuchtError, match=sentence):
        mean(expression, t)
    assert time.perf_counter() - begin < BEARABLE


@pytest.mark.parametrize("engine", ["heyoka", "scipy"])
def test_the_averaged_system_compiles(engine):
    """x' = -a x - b x^2 by hand: x = a/((a/x_0 + b) exp(a t) - b)."""
    if engine == "heyoka":
        pytest.importorskip("heyoka")
    rate = epsilon * (-x / (2 + c(t)) + s(t) * x**2 / (3 + s(t)) ** 2)
    slow = averaged(System((x,), (rate,), (epsilon,)), epsilon).system
    grid = np.linspace(0, 10, 3)
    run = integrate(compile_system(slow, engine=engine), [0.7], {"epsilon": 0.1}, grid)
    a, b = 0.1 / math.sqrt(3), 0.1 * math.sqrt(2) / 32
    assert run.states[0] == approx(a / ((a / 0.7 + b) * np.exp(a * grid) - b), rel=1e-6)  # the default tolerance
