"""Bounds over intervals hold, and are sharp where they can be."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import rejected

from wucht.numerics.intervals import enclosure
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated_pieces

X = sp.Symbol("x", real=True)


@pytest.mark.parametrize(
    "text", ["x**2 - x", "1/(x**2 + 1)", "3*x/(x + 4) - x**3", "(x - 1)**2*(x + 2)", "1/x", "x*tanh(3*x)", "sqrt(2)*x + pi"]
)
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


def test_bounds_of_an_inner_function() -> None:
    squared = Pieces("signedsquare", (0.0,), ((0, 0, -1, 0), (0, 0, 1, 0)))
    below, above = enclosure(2 - PiecewiseCubic(2 * X, squared), X, np.array([-1.0, 1.0]), np.array([0.5, np.inf]))
    assert below == pytest.approx([1.0, -np.inf])
    assert above == pytest.approx([6.0, np.inf])
