"""Solve ``M a = F`` symbolically as a straight-line program: every intermediate result gets a name and stays small.

Gaussian elimination, of a symmetric matrix the row with the fewest couplings first (minimum degree), of equals one that is
still unchanged: its pivot is short. For a machine this eliminates the bodies before the carrier, so the work and the size of
the result grow linearly with the number of bodies.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from wucht.mechanics.phasors import Lines


def solve_by_elimination(
    matrix: sp.Matrix, right: Sequence[sp.Expr], names: Sequence[str], lines: Lines, prefix: str = "_", symmetric: bool = True
) -> list[sp.Expr]:
    """Solve ``matrix * a = right`` for the n unknowns a, in terms of definitions that are added to the lines.

    names: n labels for the definitions. symmetric: the matrix is, and is positive definite for admissible parameters; else the
    elimination goes in the given order. There is no pivoting.
    """

    def name(e: sp.Expr, label: str) -> sp.Expr:
        return lines.name(e, f"{prefix}{label}")

    n = len(names)
    rows: list[dict[int, sp.Expr]] = [{j: matrix[i, j] for j in range(n) if matrix[i, j] != 0} for i in range(n)]
    rhs = [name(right[i], f"F[{names[i]}]") for i in range(n)]
    remaining, changed_rows, order = set(range(n)), set[int](), list[int]()
    while remaining:
        k = min(remaining, key=lambda i: (symmetric and (sum(j in remaining for j in rows[i]), i in changed_rows), i))
        remaining.discard(k)
        order.append(k)
        coupled_columns = sorted(remaining & rows[k].keys())
        for j in (k, *coupled_columns):
            rows[k][j] = name(rows[k][j], f"M[{names[k]},{names[j]}]")
        for i in (i for i in sorted(remaining) if k in rows[i]):
            factor = name(rows[k if symmetric else i][i if symmetric else k] / rows[k][k], f"L[{names[i]},{names[k]}]")
            for j in (j for j in coupled_columns if j >= i or not symmetric):
                rows[i][j] = name(rows[i].get(j, sp.S.Zero) - factor * rows[k][j], f"M{len(order)}[{names[i]},{names[j]}]")
                if symmetric:
                    rows[j][i] = rows[i][j]
            rhs[i] = name(rhs[i] - factor * rhs[k], f"F{len(order)}[{names[i]}]")
            changed_rows.add(i)
    solution: dict[int, sp.Expr] = {}
    for step, k in enumerate(reversed(order)):
        rest = sp.Add(*(rows[k][j] * solution[j] for j in sorted(rows[k]) if j in solution))
        solution[k] = name((rhs[k] - rest) / rows[k][k], f"a{step}[{names[k]}]")
    return [solution[i] for i in range(n)]
