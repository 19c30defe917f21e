"""Python functions f(t, x, p) as formulas: the same System as of formulas that are written, or a sentence with the line."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.special
import sympy as sp
from scipy.integrate import solve_ivp
from tests.refusals import refused, rejected

import wucht
from wucht import System, UserSystem


def van_der_pol(t: Any, x: Any, p: Any) -> Any:
    q, v = x
    (mu,) = p
    return v, mu * (1 - q**2) * v - q


def every_function(t: Any, x: Any, p: Any) -> Any:
    q, v = x
    rate = np.zeros_like(x)
    rate[0] = np.abs(v) + np.sign(q) + np.maximum(q, v) + np.arctan2(q, v) + np.exp(-q) / 3 + 0.25 * np.sqrt(q**2 + v**2)
    rate[1] = np.array([0.5, 2.0]) @ np.sin(x) - p[0] * np.cos(t) + np.tanh(p[1] * v) ** 3
    return rate


def test_a_traced_function_is_the_system_of_its_formulas() -> None:
    by_formulas = UserSystem.from_formulas({"q": "v", "v": "mu*(1 - q^2)*v - q"}, {"mu": 1.5})
    assert UserSystem.from_function(van_der_pol, ["q", "v"], {"mu": 1.5}) == by_formulas
    rates = {
        "q": "abs(v) + sign(q) + max(q, v) + atan2(q, v) + exp(-q)/3 + 0.25*sqrt(q^2 + v^2)",
        "v": "0.5*sin(q) + 2*sin(v) - a*cos(t) + tanh(b*v)^3",
    }
    written = UserSystem.from_formulas(rates, {"a": 1, "b": 2}).system
    traced = System.from_function(every_function, ["q", "v"], ["a", "b"])
    assert [sp.expand(a - b) for a, b in zip(traced.derivatives, written.derivatives, strict=True)] == [0, 0]


def dry_friction(t: Any, x: Any, p: Any) -> Any:
    return [x[1], -x[0] - np.where(x[1] > 0, p[0], -p[0])]


def two_masses(t: Any, x: Any, p: Any) -> Any:
    mass = np.array([[2.0, np.cos(x[0])], [np.cos(x[0]), 1.0]])
    return [*x[2:], *sp.Matrix(mass).LUsolve(sp.Matrix([-x[0], sp.Rational(1, 3) * np.sin(x[1])]))]


def test_a_mass_matrix_is_solved_by_sympy() -> None:
    system = System.from_function(two_masses, ["a", "b", "u", "v"])
    a, b = 0.7, -0.4
    symbols = dict(zip(system.states, (a, b, 1.5, 2.5), strict=True))
    rates = [float(rate.subs(symbols)) for rate in system.derivatives]
    solved = np.linalg.solve([[2.0, np.cos(a)], [np.cos(a), 1.0]], [-a, np.sin(b) / 3])
    assert rates == pytest.approx([1.5, 2.5, *solved], rel=1e-14)


def test_kinks_of_a_traced_function_are_located() -> None:
    """Of dry friction: x'' = -x - f sgn(x') from x = 1.05 with f = 0.1 is at -0.85, 0.65, -0.45 after each half period pi."""
    friction = UserSystem.from_function(dry_friction, ["x", "v"], {"f": 0.1})
    result = wucht.run(wucht.RunUp(start={"x": 1.05, "v": -1e-12}, until=3 * math.pi), friction)
    assert result.states.sel(state="x").isel(time=-1).item() == pytest.approx(-0.45, abs=1e-9)


def test_a_run_of_a_traced_function_is_that_of_scipy() -> None:
    result = wucht.run(
        wucht.RunUp(start={"q": 0.5}, until=10.0), UserSystem.from_function(van_der_pol, ["q", "v"], {"mu": 1.0})
    )
    calculated = solve_ivp(van_der_pol, (0.0, 10.0), [0.5, 0.0], rtol=1e-11, atol=1e-11, args=([1.0],))
    assert result.states.sel(state=["q", "v"]).isel(time=-1).values == pytest.approx(calculated.y[:, -1], rel=1e-7)


def branching(t: Any, x: Any, p: Any) -> Any:
    if x[0] > 0:
        return [1.0]
    return [-1.0]


def filling(t: Any, x: Any, p: Any) -> Any:
    rate = np.zeros(1)
    rate[0] = x[0]
    return rate


@pytest.mark.parametrize(
    ("function", "named"),
    [
        (branching, ("branching", "if x[0] > 0:", "np.where")),
        (filling, ("rate[0] = x[0]", "np.zeros_like(x)")),
        (lambda t, x, p: [1.0 if x[0] == 0 else 2.0], ("equal",)),
        (lambda t, x, p: [math.sin(x[0])], ("number", "np.sin")),
        (lambda t, x, p: [max(x[0], 0.0)], ("branches", "np.maximum")),
        (lambda t, x, p: [scipy.special.jv(0, x[0])], ("jv",)),
        (lambda t, x, p: [np.interp(x[0], [0, 1], [1, 2])], ("number",)),
    ],
)
def test_what_has_no_formula_is_told_with_its_line_and_called(function: Callable[..., Any], named: tuple[str, ...]) -> None:
    with pytest.warns(RuntimeWarning) as caught:
        system = System.from_function(function, ["x"])
    (warning,) = caught
    assert all(word in str(warning.message) for word in (*named, "called", "without a Jacobian", "slower"))
    assert warning.filename == __file__ and not system.has_formulas


@pytest.mark.parametrize(
    ("function", "named"),
    [
        (lambda t, x, p: [x[0] * 1j], ("1j", "a real number")),
        (lambda t, x, p: [x[3]], ("IndexError",)),
        (lambda x: x, ("TypeError",)),
        (lambda t, x, p: [1.0, 2.0] if x[0] > 0 else [3.0, 4.0], ("branches", "each of 1 states")),
    ],
)
def test_what_cannot_be_called_either_is_refused(function: Callable[..., Any], named: tuple[str, ...]) -> None:
    with rejected("not-traced") as caught:
        System.from_function(function, ["x"])
    assert all(word in str(caught.value) for word in named)


def test_what_is_refused() -> None:
    with rejected("count", "2", "1"):
        System.from_function(lambda t, x, p: [x[0]], ["x", "v"])
    with rejected("count", "nothing"):
        System.from_function(lambda t, x, p: None, ["x"])
    with rejected("no-list"):
        System.from_function(van_der_pol, "qv")
    with rejected("time-taken", "t"):
        System.from_function(lambda t, x, p: x, ["t"])
    with refused("system.angles", given="x"):
        UserSystem.from_function(lambda t, x, p: x, ["x"], angles=["x"])
    with refused("parameters.mu", given="fast", code="no-quantity"):
        UserSystem.from_function(van_der_pol, ["q", "v"], {"mu": "fast"})


def test_a_line_whose_text_is_not_known_is_told_by_its_number() -> None:
    typed: dict[str, Any] = {}
    exec(compile("def rate(t, x, p):\n    return [x[3]]", "<stdin>", "exec"), typed)
    with rejected("not-traced") as caught:
        System.from_function(typed["rate"], ["x"])
    assert "at line 2 of <stdin>" in str(caught.value) and "()" not in str(caught.value)
