"""Boxes in which the rates of a System may jump: there no bound on their Jacobian says how far they change."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.numerics.flow.program import Numbers, lower
from wucht.numerics.phase_plane.box_bounds import bounds
from wucht.piecewise import PiecewiseCubic
from wucht.system import System


def may_jump(system: System, values: Numbers, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether each of the n rates may jump in each of N boxes (n, N). values: of the parameters. low, high: (n, N).

    Raises ``WuchtError`` for a function of which no bounds are known.
    """
    found = np.zeros(low.shape, bool)
    pieces = _jumping(system)
    if not pieces:
        return found
    program = lower(system, [piece.args[0] for _, piece in pieces])
    below, above = bounds(program, program.constant_values(values), low, high)
    for (row, piece), a, b in zip(pieces, below, above, strict=True):
        at = np.array(piece.args[1].jumps())[:, None]
        found[row] |= ~((at < a) | (at > b)).all(axis=0)  # where nothing is known of the argument too
    return found


@lru_cache(maxsize=64)
def _jumping(system: System) -> tuple[tuple[int, PiecewiseCubic], ...]:
    """The piecewise functions that jump, by the row of the rate that depends on them, definitions put in."""
    meanings = system.definitions
    if not any(p.args[1].jumps() for e in (*system.derivatives, *(e for _, e in meanings)) for p in _pieces(e)):
        return ()
    whole = list(map(sp.sympify, system.derivatives))
    for symbol, expression in reversed(meanings):
        whole = [e.xreplace({symbol: sp.sympify(expression)}) for e in whole]
    return tuple((i, p) for i, e in enumerate(whole) for p in sorted(_pieces(e), key=str) if p.args[1].jumps())


def _pieces(e: sp.Expr) -> set[PiecewiseCubic]:
    return set(sp.sympify(e).atoms(PiecewiseCubic))
