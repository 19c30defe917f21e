"""Independent integrators of a System: heyoka's Taylor series, and SciPy's DOP853, LSODA and Radau.

They take the equations as they are written, and share with wucht neither the straight-line program nor machine code.
F. Biscani, D. Izzo, "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics", Monthly Notices of the
Royal Astronomical Society 504 (2021) 2614-2628. E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations
I", Springer 1993, section II.10 (DOP853).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from wucht.piecewise import PiecewiseCubic
from wucht.system import TIME, System

Values = Mapping[str, float] | Sequence[float]

needs_heyoka = pytest.mark.skipif(not find_spec("heyoka"), reason="PyPI has heyoka for Linux alone")


def taylor_states(system: System, initial: Sequence[float], values: Values, grid: Any, tolerance: float = 1e-16) -> np.ndarray:
    """Return the states (n, N) at increasing times by heyoka. The equations have no piecewise functions."""
    import heyoka as hy

    equations = taylor_equations(system, values)
    integrator = hy.taylor_adaptive(equations, list(map(float, initial)), tol=tolerance, compact_mode=True)
    times = np.asarray(grid, float)
    integrator.time = times[0]
    outcome, *_, states = integrator.propagate_grid(times)
    assert outcome == hy.taylor_outcome.time_limit, outcome
    return states.T


def taylor_equations(system: System, values: Values) -> list[tuple[Any, Any]]:
    """Return heyoka's variable and rate of each state."""
    import heyoka as hy

    variables = hy.make_vars(*(f"x{i}" for i in range(len(system.states))))
    known = dict(zip(system.states, variables, strict=True)) | {TIME: hy.time}
    known |= {s: hy.expression(v) for s, v in _parameters(system, values).items()}
    translate = _Translator(known)
    for symbol, expression in system.definitions:
        known[symbol] = translate(sp.sympify(expression))
    return [(x, translate(sp.sympify(rate))) for x, rate in zip(variables, system.derivatives, strict=True)]


def runge_kutta_states(
    system: System, initial: Sequence[float], values: Values, grid: Any, method: str = "DOP853", **options: Any
) -> np.ndarray:
    """Return the states (n, N) at increasing times by SciPy: rtol = 1e-12, atol = 1e-14 unless ``options`` say otherwise.

    Steps go over breakpoints of piecewise functions as if there were none: give ``max_step``.
    """
    times = np.asarray(grid, float)
    allowed = {"rtol": 1e-12, "atol": 1e-14} | options
    solution = solve_ivp(rates_of(system, values), (times[0], times[-1]), initial, method, times, **allowed)
    assert solution.success, solution.message
    return solution.y


def rates_of(system: System, values: Values) -> Callable[[float, np.ndarray], list[float]]:
    """Return the derivatives as a function of time and state."""
    numbers = {s: sp.Float(v, 17) for s, v in _parameters(system, values).items()}
    expressions = [sp.sympify(e).xreplace(numbers) for e in (*(e for _, e in system.definitions), *system.derivatives)]
    tables = {p.args[1] for e in expressions for p in e.atoms(PiecewiseCubic)}
    functions = {table: sp.Function(f"table{k}") for k, table in enumerate(sorted(tables, key=str))}
    symbols = [*system.states, TIME, *(s for s, _ in system.definitions)]
    short = {s: sp.Symbol(f"v{k}") for k, s in enumerate(symbols)}
    expressions = [e.replace(PiecewiseCubic, lambda x, table: functions[table](x)).xreplace(short) for e in expressions]
    count = len(system.definitions)
    lines = [(short[s], e) for (s, _), e in zip(system.definitions, expressions[:count], strict=True)]
    function = sp.lambdify(
        [short[TIME], [short[s] for s in system.states]],
        expressions[count:],
        modules=[{str(f): table for table, f in functions.items()}, "math"],
        cse=lambda results: (lines, results),
    )
    return lambda time, state: function(time, state.tolist())


def _parameters(system: System, values: Values) -> dict[sp.Symbol, float]:
    numbers = [values[s.name] for s in system.parameters] if isinstance(values, Mapping) else values
    return dict(zip(system.parameters, map(float, numbers), strict=True))


class _Translator:
    """SymPy's expressions to heyoka's. known: what symbols stand for."""

    def __init__(self, known: dict[sp.Basic, Any]) -> None:
        import heyoka as hy

        self.hy, self.known = hy, known
        names = ("sin", "cos", "tan", "exp", "log", "sinh", "cosh", "tanh", "atan", "asin", "acos", "atan2")
        self.functions = {getattr(sp, name): getattr(hy, name) for name in names}

    def __call__(self, e: sp.Expr) -> Any:
        if e not in self.known:
            self.known[e] = self._translate(e)
        return self.known[e]

    def _translate(self, e: sp.Expr) -> Any:
        if e.is_number:
            return self.hy.expression(float(e))
        if isinstance(e, sp.Add):
            return self.hy.sum([self(a) for a in e.args])
        if isinstance(e, sp.Mul):
            return self.hy.prod([self(a) for a in e.args])
        if isinstance(e, sp.Pow) and e.exp.is_Integer:  # heyoka's x**3 has no Taylor coefficients at x = 0
            product = self.hy.prod([self(e.base)] * int(abs(e.exp)))
            return product if e.exp > 0 else self.hy.expression(1.0) / product
        if isinstance(e, sp.Pow):
            return self.hy.sqrt(self(e.base)) if e.exp == sp.Rational(1, 2) else self(e.base) ** self(e.exp)
        return self.functions[e.func](*map(self, e.args))
