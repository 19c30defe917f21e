"""Conditions at both ends of [0, 1], written as formulas of the states there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.system import System


def at_begin(state: sp.Symbol) -> sp.Symbol:
    """The value of a state at 0, for a condition."""
    return sp.Symbol(f"{state.name}(0)", real=True)


def at_end(state: sp.Symbol) -> sp.Symbol:
    """The value of a state at 1, for a condition."""
    return sp.Symbol(f"{state.name}(1)", real=True)


@dataclass(frozen=True, eq=False)
class EndConditions:
    """b(y(0), y(1), P) = 0 with its derivatives: ``Ends`` of a boundary value problem.

    formulas: of n states at 0, those at 1, and q parameters -> b (k,) and its derivatives (k, 2n+q).
    """

    formulas: Callable[[np.ndarray], tuple[list[float], list[list[float]]]]
    n: int

    @classmethod
    def of(
        cls, system: System, parameters: Sequence[str], fixed: Mapping[str, float], conditions: Sequence[sp.Expr]
    ) -> EndConditions:
        """Of formulas that have to be zero: of ``at_begin`` and ``at_end`` of states, and of parameters.

        Raises ``WuchtError`` for a formula in which anything else occurs.
        """
        varied = [p for name in parameters for p in system.parameters if p.name == name]
        held = {p: fixed[p.name] for p in system.parameters if p not in varied}
        known = [*map(at_begin, system.states), *map(at_end, system.states), *varied]
        b = sp.Matrix([sp.sympify(c).subs(held) for c in conditions])
        if other := sorted(s.name for s in b.free_symbols - set(known)):
            raise WuchtError(
                f"{other[0]} is no value of a state at_begin or at_end and no parameter: a condition has only those",
                code="unknown-name",
            )
        formulas = sp.lambdify([known], [list(b), b.jacobian(known).tolist()], "numpy", cse=True)
        return cls(formulas, len(system.states))

    def __call__(
        self, first: np.ndarray, last: np.ndarray, parameters: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """See ``Ends``."""
        b, by = (np.array(each, float) for each in self.formulas(np.concatenate([first, last, parameters])))
        return b, by[:, : self.n], by[:, self.n : 2 * self.n], by[:, 2 * self.n :]
