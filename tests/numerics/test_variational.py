"""The variational equations, against SymPy's own derivative."""

import pytest
import sympy as sp

from wucht.numerics.variational import variational
from wucht.system import System

x, v, a = sp.symbols("x v a", real=True)


def test_the_variational_equations_are_the_derivative():
    """By names of intermediate results, through a function of a function; against SymPy's own derivative of the whole."""
    q, r = sp.symbols("q r", real=True)
    system = System((x, v), (r * v, -sp.sin(r) * x), (a,), ((q, x**2 + a), (r, sp.sqrt(q) + v)))
    both = variational(system)
    states, moves = system.states, both.states[2:]
    whole = [system.explicit(d) for d in system.derivatives]
    for derivative, expression in zip(both.derivatives[2:], whole, strict=True):
        wanted = sum(sp.diff(expression, s) * m for s, m in zip(states, moves, strict=True))
        numbers = {x: 0.7, v: -0.4, a: 1.3, moves[0]: 0.9, moves[1]: -2.1}
        assert float(both.explicit(derivative).xreplace(numbers)) == pytest.approx(float(wanted.xreplace(numbers)), rel=1e-13)
