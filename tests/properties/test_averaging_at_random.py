"""Averaging of expressions drawn at random: means against quadrature, fast parts against 002 (3.6), refusals by a sentence."""

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from pytest import approx
from scipy.integrate import quad

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.means import mean
from wucht.mechanics.trigonometric import trigonometric_polynomial
from wucht.system import TIME, System

few = settings(
    max_examples=25, deadline=None, suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.generate),
)  # fmt: skip
x, y, a, b, epsilon = sp.symbols("x y a b epsilon", real=True)
TURN = 2 * math.pi
AT = {x: sp.Rational(7, 10), y: sp.Rational(-4, 10)}


@st.composite
def factors(draw):
    """cos or sin of a multiple of t, with a phase that may be a state; or a state."""
    angle = draw(st.integers(1, 3)) * TIME + draw(st.sampled_from([0, sp.Rational(1, 3), x, x - 2 * y]))
    return draw(st.sampled_from([sp.cos(angle), sp.sin(angle), x, 1 + y]))


@st.composite
def terms(draw):
    term = sp.Rational(draw(st.integers(-9, 9)), 4)
    for factor in draw(st.lists(factors(), min_size=1, max_size=3)):
        term *= factor ** draw(st.integers(1, 2))
    return term


polynomials = st.lists(terms(), min_size=1, max_size=3).map(lambda summands: sp.Add(*summands))


def numbers(expression):
    return sp.lambdify(TIME, expression.xreplace(AT), "math")


def by_quadrature(expression):
    return quad(numbers(expression), 0, TURN, epsabs=1e-12, epsrel=1e-12, limit=200)[0] / TURN


@few
@given(polynomials)
def test_the_mean_is_the_integral_over_a_period(expression):
    # quad's tolerance, on values up to about 50
    assert float(mean(expression, TIME).xreplace(AT)) == approx(by_quadrature(expression), abs=1e-10)


@few
@given(polynomials)
def test_mean_and_harmonics_are_the_expression(expression):
    """Nothing is lost: at random times the sum of mean and oscillation is the expression, to rounding of values up to 50."""
    waves = trigonometric_polynomial(expression, TIME)
    whole, parts = numbers(expression), numbers(waves.mean + waves.oscillation)
    for time in np.random.default_rng(1).uniform(0, TURN, 5):
        assert whole(time) == approx(parts(time), abs=1e-11)


@few
@given(polynomials, polynomials)
def test_the_transformation_has_mean_zero_and_solves_its_equation(f, g):
    """du/dt = X - <X>, <u> = 0 (3.6); the second order is <(dX/dx) u>, by quadrature; u is bounded."""
    result = averaged(System((x, y), (epsilon * f, epsilon * g), (epsilon,)), epsilon, order=2)
    for u, X, first in zip(result.fast, (f, g), result.first, strict=True):
        assert by_quadrature(u) == approx(0, abs=1e-10)
        residual = numbers(sp.diff(u, TIME) - X + first)
        assert max(abs(residual(t)) for t in (0.1, 1.7, 4.4)) < 1e-10
    for second, X in zip(result.second, (f, g), strict=True):
        bent = sp.diff(X, x) * result.fast[0] + sp.diff(X, y) * result.fast[1]
        assert float(second.xreplace(AT)) == approx(by_quadrature(bent), rel=1e-9, abs=1e-9)


@st.composite
def wild(draw, depth=2):
    """Anything that may stand in a rate: what averages, what grows, what has a kink or a pole, in any nesting."""
    if depth == 0:
        angle = draw(st.sampled_from([1, 2, sp.Rational(1, 2), sp.sqrt(2), a, 0.1, 2 * math.pi, a / b, x])) * TIME
        angle += draw(st.sampled_from([0, sp.Rational(1, 3), x, a, epsilon * y]))
        waves = [sp.cos(angle), sp.sin(angle), sp.tan(angle), sp.exp(sp.I * angle)]
        others = [x, y, a, epsilon, TIME, epsilon * TIME, sp.Float(1.5), sp.exp(-x), sp.Abs(x), sp.exp(-TIME), sp.Mod(TIME, 1)]
        return draw(st.sampled_from(waves * 4 + others))
    left, right = draw(wild(depth - 1)), draw(wild(depth - 1))
    below = draw(st.sampled_from([2, 3, x, sp.sqrt(7)])) + draw(st.sampled_from([sp.cos(TIME), sp.sin(2 * TIME), right]))
    forms = [left + right, left * right, left**2, left / below, left / below**2, sp.sqrt(left), sp.Abs(left), sp.cos(left)]
    return draw(st.sampled_from([f for f in forms if not f.has(sp.zoo, sp.nan, sp.oo)]))


@few
@given(wild(), wild(), st.sampled_from([1, 2]))
def test_what_cannot_be_averaged_is_refused_by_a_sentence(f, g, order):
    """No error of SymPy's own comes out of whatever is written; a real right-hand side has a real mean."""
    try:
        result = averaged(System((x, y), (epsilon * f, epsilon * g), (epsilon, a, b)), epsilon, order)
    except WuchtError:
        return
    assert f.has(sp.I) or g.has(sp.I) or not any(sp.sympify(e).has(sp.I) for e in (*result.first, *result.second))


@pytest.mark.slow
@few
@given(st.tuples(*[st.fractions(-2, 2, max_denominator=7)] * 2), st.integers(1, 3), polynomials)
def test_the_mean_of_a_quotient_is_the_integral_over_a_period(waves, power, numerator):
    """Over A + B cos + C sin with A^2 = B^2 + C^2 + 1, to a power."""
    cosine, sine = (sp.Rational(w.numerator, w.denominator) for w in waves)
    below = sp.sqrt(cosine**2 + sine**2 + 1) + cosine * sp.cos(TIME) + sine * sp.sin(TIME)
    value = mean(numerator / below**power, TIME)
    assert not value.has(sp.I)
    expected = by_quadrature(numerator / below**power)
    assert float(sp.N(value.xreplace(AT))) == approx(expected, rel=1e-9, abs=1e-9)
