"""Equations in closed form, as the tests beside give them to the continuation: nothing is compiled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy as sp

from wucht.numerics.continuation.equations import Equations

X, P, Q = sp.symbols("x p q", real=True)
Pair = tuple[np.ndarray, np.ndarray]


def by_hand(rates: Sequence[sp.Expr], states: Sequence[sp.Symbol], parameters: Sequence[sp.Symbol] = (P,)) -> Equations:
    """Of expressions, without compiling them."""
    given = [*states, *parameters]
    f = sp.lambdify(given, list(rates), "numpy")
    derivatives = sp.lambdify(given, sp.Matrix(rates).jacobian(given).tolist(), "numpy")

    def values(unknowns: np.ndarray) -> Pair:
        with np.errstate(all="ignore"):
            return np.array(f(*unknowns), float), np.array(derivatives(*unknowns), float)

    return Equations.from_function(values, [s.name for s in states], [p.name for p in parameters])
