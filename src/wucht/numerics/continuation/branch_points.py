"""Simple branch points, where two branches of F(u) = 0 cross, and the directions of both.

W. Govaerts, "Numerical Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, sections 6.1 (defining equations) and
4.1 (the algebraic branching equation).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.problem import CurvePoint

_MOST_STEPS = 15
_TOLERANCE = 1e-12
_ROUNDED = 1e-8  # corrections that small and no longer smaller are rounding
_TOUCHING = 1e-8  # in units of scale: branches that pass one another more closely cross
_FLAT = 1e-9  # of the largest: rates of an equation that are smaller are zero
_STEP = 6e-6  # of a central difference, in units of scale: the cube root of rounding


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """Where two branches cross.

    u (n+1,). jacobian (n, n+1). tangents (2, n+1): of the branch that was followed, and of the other. share: of the way to it.
    """

    u: np.ndarray
    jacobian: np.ndarray
    tangents: np.ndarray
    share: float = 0.0

    @classmethod
    def at(cls, equations: Equations, u: np.ndarray, along: np.ndarray | None = None) -> BranchPoint:
        """The branches through a branch point u; the first is nearest to a direction (n+1,), by default the parameter's.

        Raises ``RunError`` where two branches do not cross there.
        """
        scale = equations.scale
        jacobian = equations.values(u)[1]
        rates = np.abs(jacobian * scale).max(axis=1)
        weights = 1 / np.where(rates > _FLAT * rates.max(), rates, rates.max() or 1.0)
        left, _, right = np.linalg.svd(jacobian * scale * weights[:, None])
        w, both = left[:, -1] * weights, right[-2:] * scale
        second = np.array([w @ derivative_along(equations, u, v) @ both.T for v in both])
        a, b, c = second[0, 0], (second[0, 1] + second[1, 0]) / 2, second[1, 1]
        inside = b * b - a * c
        if not inside > 1e-8 * (b * b + abs(a * c)):
            raise RunError("no two branches cross here: it is no simple branch point")
        # a x^2 + 2 b x y + c y^2 = 0, each root by the formula that does not cancel.
        q = -(b + math.copysign(math.sqrt(inside), b))
        roots = np.array([(q, a), (c, q)])
        tangents = roots @ both
        tangents /= np.linalg.norm(tangents / scale, axis=1)[:, None]
        wanted = np.eye(len(u))[-1] * scale if along is None else along
        near = np.abs(tangents / scale @ (wanted / scale))
        tangents = tangents[np.argsort(-near)]
        tangents *= np.where(tangents / scale @ (wanted / scale) < 0, -1.0, 1.0)[:, None]
        return cls(u, jacobian, tangents)


def derivative_along(equations: Equations, u: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """d/ds of dF/du (n, n+m) along a direction (n+m,), by a central difference: right to about ten digits."""
    length = float(np.linalg.norm(direction / equations.scale))
    h = _STEP / length if length else 1.0
    _, both = equations.values(np.stack([u + h * direction, u - h * direction], axis=-1))
    return np.asarray((both[..., 0] - both[..., 1]) / (2 * h))


def branch_point(equations: Equations, a: CurvePoint, b: CurvePoint) -> BranchPoint:
    """The branch point between two neighbouring points of a branch.

    Raises ``RunError`` where none lies there.
    """
    way = (b.u - a.u) / equations.scale
    u = _solved(equations, (a.u + b.u) / 2)
    share = float((u - a.u) / equations.scale @ way / (way @ way))
    if not -0.5 <= share <= 1.5:
        raise RunError("no branch point was found between two points")
    return replace(BranchPoint.at(equations, u, b.u - a.u), share=share)


def branch_point_near(equations: Equations, u: np.ndarray) -> BranchPoint:
    """The branch point near u (n+1,), its branches in the order in which ``BranchPoint.at`` has them.

    Raises ``RunError`` where Newton's method finds none.
    """
    return BranchPoint.at(equations, _solved(equations, u))


def _solved(equations: Equations, u: np.ndarray) -> np.ndarray:
    """Where F_u (n, n+1) has less than full rank: a solution, and a regular one, of F + b w = 0, F_u^T w = 0, w^T w = 1.

    The unknowns are u, b, w. Raises ``RunError`` where Newton's method finds none from u (n+1,).
    """
    n, scale, slack = equations.n, equations.scale, 0.0
    # Equations of very different rates are measured by their own: at a branch point first derivatives alone may vanish.
    rates = np.abs(np.concatenate([equations.values(u)[1] * scale, *np.moveaxis(_second(equations, u), 1, 0)], axis=1)).max(
        axis=1
    )
    weights = 1 / np.where(rates > 0, rates, 1.0)[:, None]
    if not np.isfinite(weights).all():
        raise RunError("no branch point was found: the equations cannot be evaluated there")
    w = np.linalg.svd(equations.values(u)[1] * scale * weights)[0][:, -1]
    before = math.inf
    for _ in range(_MOST_STEPS):
        off, jacobian = equations.values(u)
        off, scaled = off * weights[:, 0], jacobian * scale * weights
        hessian = np.einsum("i,ijk->jk", w * weights[:, 0], _second(equations, u))
        matrix = np.zeros((2 * n + 2, 2 * n + 2))
        matrix[:n, : n + 1], matrix[:n, n + 1], matrix[:n, n + 2 :] = scaled, w, slack * np.eye(n)
        matrix[n : 2 * n + 1, : n + 1], matrix[n : 2 * n + 1, n + 2 :] = hessian, scaled.T
        matrix[-1, n + 2 :] = 2 * w
        missed = np.concatenate([off + slack * w, scaled.T @ w, [w @ w - 1]])
        try:
            step = np.linalg.solve(matrix, -missed)
        except np.linalg.LinAlgError:
            break
        u, slack, w = u + step[: n + 1] * scale, slack + step[n + 1], w + step[n + 2 :]
        change = float(np.abs(step[: n + 2]).max())
        if not math.isfinite(change):
            break
        if change <= _TOLERANCE * max(1.0, float(np.abs(u / scale).max())) or before / 2 < change < _ROUNDED:
            if abs(slack) < _TOUCHING:
                return u
            break
        before = change
    raise RunError("no branch point was found")


def _second(equations: Equations, u: np.ndarray) -> np.ndarray:
    """d^2 F / du^2 (n, n+1, n+1) in units of scale, by central differences."""
    n, basis = equations.n, _STEP * np.diag(equations.scale)
    both = equations.values(u[:, None] + np.concatenate([basis, -basis], axis=1))[1]
    return np.asarray((both[..., : n + 1] - both[..., n + 1 :]) * equations.scale[:, None] / (2 * _STEP))
