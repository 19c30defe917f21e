"""Bounds over intervals hold, and are sharp where they can be."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import rejected

from wucht.numerics.flow.program import lower
from wucht.numerics.intervals import bounds, enclosure
from wucht.piecewise import PiecewiseCubic, interpolated_pieces
from wucht.system import System

X = sp.Symbol("x", real=True)


def test_what_has_no_enclosure_is_refused() -> None:
    with rejected("no-bounds"):
        enclosure(sp.sin(X), X, np.zeros(1), np.ones(1))


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.sampled_from(["monotone", "linear", "steps", "spline"]), st.sampled_from([0, 1, 2]))
def test_bounds_of_piecewise_cubics_are_their_range(seed: int, kind: str, derivatives: int) -> None:
    """Against values close together; a jump counts with both its values."""
    draw = np.random.default_rng(seed)
    breakpoints = np.cumsum(draw.uniform(0.1, 2.0, 6))
    pieces = interpolated_pieces("f", breakpoints.tolist(), draw.normal(size=6).tolist(), kind)
    for _ in range(derivatives):
        pieces = pieces.derivative
    low = draw.uniform(-1.0, breakpoints[-1] + 1.0, 20)
    high = low + draw.choice([0.0, 0.3, 3.0], 20)
    below, above = enclosure(PiecewiseCubic(X, pieces), X, low, high)
    beside = [x for c in breakpoints for x in (np.nextafter(c, -1.0), c)]
    for k, (a, b) in enumerate(zip(low, high, strict=True)):
        at = np.unique([*np.linspace(a, b, 400), *(x for x in beside if a <= x <= b)])
        values, fine = pieces(at), 1e-3 * (np.abs(np.array(pieces.coefficients)).max() + 1)
        assert below[k] <= values.min() + 1e-12
        assert above[k] >= values.max() - 1e-12
        assert below[k] >= values.min() - fine
        assert above[k] <= values.max() + fine


def bounds_of(expression: sp.Expr, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    program = lower(System((X,), (expression,)), (expression,))
    below, above = bounds(program, np.zeros(len(program.constants)), low[None], high[None])
    return below[0], above[0]


@pytest.mark.parametrize(
    ("text", "least"),
    [
        ("sin(x)", -7.0), ("cos(x)", -7.0), ("tan(x)", -7.0), ("cosh(x)", -3.0), ("sinh(x)", -3.0), ("tanh(x)", -3.0),
        ("exp(x)", -3.0), ("log(x)", 0.1), ("atan(x)", -3.0), ("asin(x/9)", -7.0), ("sqrt(x)", 0.0), ("x**(-3/2)", 0.1),
        ("x**2", -3.0), ("x**3", -3.0), ("x**4", -3.0), ("x**(-2)", -3.0), ("x**(-3)", -3.0), ("1/x", -3.0),
    ],
)  # fmt: skip
def test_bounds_of_one_function_are_its_range(text: str, least: float) -> None:
    """Against values close together, on intervals of many lengths; infinite where there is a pole."""
    rng = np.random.default_rng(1)
    low = rng.uniform(least, 6.0, 300)
    high = np.minimum(low + rng.uniform(0.0, 1.0, 300) * rng.choice([0.1, 1.0, 4.0, 9.0], 300), 8.0)
    low = np.minimum(low, high)
    expression = sp.sympify(text, locals={"x": X})
    below, above = bounds_of(expression, low, high)
    inside = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 2001)
    values = sp.lambdify(X, expression)(inside)
    if text == "tan(x)":
        has_pole = (np.diff(values, axis=1) < 0).any(axis=1)
    else:
        has_pole = (low <= 0) & (high >= 0) & ("x**(-" in text or text == "1/x")
    assert np.isinf(above[has_pole]).all() and (np.isinf(below) == has_pole).sum() >= 300 - has_pole.sum()
    regular = ~has_pole
    size = 1 + np.abs(values[regular]).max(axis=1)
    assert (below[regular] <= values[regular].min(axis=1) + 1e-12 * size).all()
    assert (above[regular] >= values[regular].max(axis=1) - 1e-12 * size).all()
    assert (below[regular] >= values[regular].min(axis=1) - 1e-4 * size).all()
    assert (above[regular] <= values[regular].max(axis=1) + 1e-4 * size).all()


@pytest.mark.parametrize(("low", "high"), [(-1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (-1.0, 1.0)])
def test_a_pole_at_an_end_counts(low: float, high: float) -> None:
    at = np.array([low]), np.array([high])
    for power in (1, 2, 3):
        below, above = enclosure(X**-power, X, *at)
        assert np.isinf(above if high > 0 or power == 2 else below).all()
        assert below[0] <= above[0]
    assert bounds_of(1 / X, *at)[0] <= bounds_of(1 / X, *at)[1]


@pytest.mark.parametrize("text", ["3*x/(x + 4) - x**3", "(x - 1)**2*(x + 2)", "1/x", "x*tanh(3*x)", "sqrt(2)*x + pi"])
def test_enclosures_hold(text: str) -> None:
    expression = sp.sympify(text, locals={"x": X})
    low = np.linspace(-2.9, 2.5, 60)
    high = low + 0.31
    below, above = enclosure(expression, X, low, high)
    inside = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 21)
    with np.errstate(divide="ignore"):
        values = sp.lambdify(X, expression)(inside)
    assert (values >= below[:, None] - 1e-12).all()
    assert (values <= above[:, None] + 1e-12).all()
