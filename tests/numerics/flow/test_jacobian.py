"""The Jacobian of a System: against SymPy's own, against finite differences, and that it stays small."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.jacobian import Jacobian, variational_system
from wucht.system import System

x, y, v, a, b, g, h = sp.symbols("x y v a b g h", real=True)


def chain() -> System:
    """Definitions in definitions, one of the parameters alone, one that is not used."""
    definitions = ((g, sp.sin(x) * a + y**2), (h, sp.exp(-g) / (1 + a**2)), (sp.Symbol("k", real=True), a * b))
    return System((x, y), (h * y + b * x, sp.cos(g * h) - sp.Symbol("k", real=True) * y), (a, b), definitions)


def test_against_sympy() -> None:
    system, at = chain(), {x: 0.3, y: -1.2, a: 0.7, b: 2.0}
    f, fx, fp = Jacobian.of(system, ("b", "a")).values_at([0.3, -1.2], [0.7, 2.0])
    explicit = sp.Matrix([system.explicit(d) for d in system.derivatives])
    exact = [np.array(m.xreplace(at).evalf(), float) for m in (explicit, explicit.jacobian([x, y]), explicit.jacobian([b, a]))]
    assert f == pytest.approx(exact[0][:, 0], rel=1e-14)
    assert fx == pytest.approx(exact[1], rel=1e-13)
    assert fp == pytest.approx(exact[2], rel=1e-13)


def test_an_unknown_parameter_is_refused() -> None:
    with rejected("no-parameter", "c", "b"):
        Jacobian.of(chain(), ("c",))


def test_a_division_by_zero_is_no_number() -> None:
    f, fx, _ = Jacobian.of(System((x,), (1 / x,))).values_at([0.0], [])
    assert math.isnan(f[0])
    assert math.isnan(fx[0, 0])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "inertia"), [("drozdetskaya-2020/r1-u80", False), ("practice/screen", True)])
def test_averaged_machines_against_differences(name: str, inertia: bool) -> None:
    averaged_equations = averaged_equations_of(load_machine(name), inertia=inertia)
    system, values = averaged_equations.system, list(averaged_equations.values())
    lin, draw = Jacobian.of(system, (system.parameter_names[0],)), np.random.default_rng(3)
    state = np.array([draw.uniform(0, 6) if s in system.angles else draw.uniform(90, 110) for s in system.states])
    f, fx, fp = lin.values_at(state, values)
    step = 1e-5
    for j in range(len(state)):
        move = step * max(1.0, abs(state[j])) * np.eye(len(state))[j]
        slope = (lin.values_at(state + move, values)[0] - lin.values_at(state - move, values)[0]) / (2 * move[j])
        assert fx[:, j] == pytest.approx(slope, rel=1e-6, abs=1e-7 * np.abs(fx).max())
    more, less = list(values), list(values)
    move = 1e-5 * values[0] or 1e-5
    more[0], less[0] = values[0] + move, values[0] - move
    slope = (lin.values_at(state, more)[0] - lin.values_at(state, less)[0]) / (2 * move)
    assert fp[:, 0] == pytest.approx(slope, rel=1e-5, abs=1e-7 * (np.abs(fp).max() + np.abs(f).max()))


def test_the_variational_equations_are_the_derivative():
    """By names of intermediate results, through a function of a function; against SymPy's own derivative of the whole."""
    q, r = sp.symbols("q r", real=True)
    system = System(
        (x, v),
        (r * v, -sp.sin(r) * x),
        (a,),
        ((q, x**2 + a), (r, sp.sqrt(q) + v)),
    )
    both = variational_system(system)
    states, moves = system.states, both.states[2:]
    whole = [system.explicit(d) for d in system.derivatives]
    for derivative, expression in zip(both.derivatives[2:], whole, strict=True):
        wanted = sum(sp.diff(expression, s) * m for s, m in zip(states, moves, strict=True))
        numbers = {x: 0.7, v: -0.4, a: 1.3, moves[0]: 0.9, moves[1]: -2.1}
        assert float(both.explicit(derivative).xreplace(numbers)) == pytest.approx(float(wanted.xreplace(numbers)), rel=1e-13)
