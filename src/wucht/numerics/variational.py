"""The variational equations: what small changes of a motion become, symbolically, beside the motion itself.

A. H. Nayfeh, B. Balachandran, "Applied Nonlinear Dynamics", Wiley 1995, sections 3.2, 5.2.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from wucht.numerics.jacobian import Tangent
from wucht.system import System


@lru_cache(maxsize=16)
def variational(system: System, columns: int = 1) -> System:
    """The System together with its linearisation: states (x, dx_1, dx_2, ...), d(dx_j)/dt = (df/dx) dx_j.

    columns: how many changes dx_j are carried along. No outputs, no quadratures.
    """
    moves = [[sp.Symbol(f"d[{s.name}][{j}]", real=True) for s in system.states] for j in range(columns)]
    rates = tuple(sp.sympify(d) for d in system.derivatives)
    definitions = [(symbol, sp.sympify(expression)) for symbol, expression in system.definitions]
    tangent = Tangent({s: {j: moves[j][i] for j in range(columns)} for i, s in enumerate(system.states)}, definitions)
    changes = [tangent.of(rate, f"f{i}") for i, rate in enumerate(rates)]
    further = tuple(change.get(j, sp.S.Zero) for j in range(columns) for change in changes)
    states = (*system.states, *(move for column in moves for move in column))
    return System(states, (*rates, *further), system.parameters, tuple(tangent.lines), angles=system.angles)
