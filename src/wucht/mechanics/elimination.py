"""Solve ``M a = F`` symbolically as a straight-line program: every intermediate result gets a name and stays small.

Gaussian elimination of a symmetric matrix, the row with the fewest couplings first (minimum degree). For a machine this
takes the bodies before the carrier, so the work and the size of the result grow linearly with the number of bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import sympy as sp


@dataclass
class _Program:
    """Collects ``(symbol, expression)`` pairs."""

    prefix: str
    lines: list[tuple[sp.Symbol, sp.Expr]] = field(default_factory=list)

    def name(self, expression: sp.Expr, label: str) -> sp.Expr:
        """A symbol for the expression, unless it is as short as a symbol already."""
        if expression.is_Atom:
            return expression
        symbol = sp.Symbol(f"{self.prefix}{label}", real=True)
        self.lines.append((symbol, expression))
        return symbol


def solve_by_elimination(
    mass: sp.ImmutableMatrix, forces: sp.ImmutableMatrix, names: Sequence[str], prefix: str = "_"
) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[sp.Expr, ...]]:
    """Solve ``mass * a = forces`` for a.

    mass: n x n, symmetric, positive definite for admissible parameters. forces: n x 1. names: n labels for the definitions.
    Returns the definitions in order of evaluation, and the n accelerations in terms of them.
    """
    n = mass.rows
    program = _Program(prefix)
    rows: list[dict[int, sp.Expr]] = [{j: mass[i, j] for j in range(n) if mass[i, j] != 0} for i in range(n)]
    right = [program.name(forces[i], f"F[{names[i]}]") for i in range(n)]
    remaining, order = set(range(n)), []
    pivots: dict[int, sp.Expr] = {}
    while remaining:
        k = min(remaining, key=lambda i: (sum(j in remaining for j in rows[i]), i))
        remaining.discard(k)
        order.append(k)
        coupled = sorted(j for j in rows[k] if j in remaining)
        pivots[k] = program.name(rows[k][k], f"M[{names[k]}]")
        for i in coupled:
            rows[k][i] = rows[i][k] = program.name(rows[k][i], f"M[{names[k]},{names[i]}]")
        for i in coupled:
            factor = program.name(rows[i][k] / pivots[k], f"L[{names[i]},{names[k]}]")
            for j in coupled:
                if j >= i:
                    updated = rows[i].get(j, sp.S.Zero) - factor * rows[k][j]
                    rows[i][j] = rows[j][i] = program.name(updated, f"M{len(order)}[{names[i]},{names[j]}]")
            right[i] = program.name(right[i] - factor * right[k], f"F{len(order)}[{names[i]}]")
    accelerations: dict[int, sp.Expr] = {}
    for step, k in enumerate(reversed(order)):
        known = (rows[k][j] * accelerations[j] for j in sorted(rows[k]) if j in accelerations)
        accelerations[k] = program.name((right[k] - sp.Add(*known)) / pivots[k], f"a{step}[{names[k]}]")
    return tuple(program.lines), tuple(accelerations[i] for i in range(n))


def solve_general(
    matrix: Sequence[Sequence[sp.Expr]],
    right: Sequence[sp.Expr],
    names: Sequence[str],
    name: Callable[[sp.Expr, str], sp.Expr],
    label: str,
) -> list[sp.Expr]:
    """Solve ``matrix * x = right`` (n x n, not symmetric) by elimination in the given order, without pivoting.

    name: gives an intermediate result a symbol, by expression and label, and returns it.
    """
    n = len(right)
    rows = [[name(e, f"{label}M[{names[i]},{names[j]}]") for j, e in enumerate(row)] for i, row in enumerate(matrix)]
    known = [name(e, f"{label}F[{names[i]}]") for i, e in enumerate(right)]
    for k in range(n):
        for i in (i for i in range(k + 1, n) if rows[i][k] != 0):
            factor = name(rows[i][k] / rows[k][k], f"{label}L[{names[i]},{names[k]}]")
            for j in (j for j in range(k + 1, n) if rows[k][j] != 0):
                rows[i][j] = name(rows[i][j] - factor * rows[k][j], f"{label}M{k + 1}[{names[i]},{names[j]}]")
            known[i] = name(known[i] - factor * known[k], f"{label}F{k + 1}[{names[i]}]")
    solution = [sp.S.Zero] * n
    for k in reversed(range(n)):
        rest = sp.Add(*(rows[k][j] * solution[j] for j in range(k + 1, n)))
        solution[k] = name((known[k] - rest) / rows[k][k], f"{label}[{names[k]}]")
    return solution
