"""Curves of folds in two parameters.

A fold is a regular solution of f = 0, g = 0, where g comes from the matrix of df/dx with a border:

    [f_x b; c^T 0] [v; g] = [0; 1],    [f_x^T c; b^T 0] [w; g] = [0; 1],    dg/du = -w^T f_xu v.

W. Govaerts, "Numerical Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, chapter 4; Y. A. Kuznetsov, "Elements of
Applied Bifurcation Theory", Springer 2004, section 10.2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.normal_forms import expansion, fold_form
from wucht.numerics.continuation.problem import CurvePoint, Problem, bordered_solution
from wucht.numerics.continuation.special_curves import BOGDANOV_TAKENS, CUSP, ZERO_HOPF, Condition, Watch, state_of
from wucht.numerics.continuation.special_points import LOST, critical_pairs
from wucht.numerics.continuation.two_parameters import SpecialCurves, SpecialEquilibrium

_TURNED = 1 / math.cos(0.3) ** 2
_STEP = 1e-7  # of a difference to one side, in units of scale: rounding and truncation are then about as large


class Bordered(NamedTuple):
    """Derivatives at a point. matrix (n+1, n+2): of f and g. v, w (n,): null vectors of f_x, measured by the scale."""

    matrix: np.ndarray
    v: np.ndarray
    w: np.ndarray


@dataclass(frozen=True, eq=False)
class FoldProblem:
    """f = 0, g = 0 with unknowns u = (x, p, q) (n+2,). border (n+1, n+1): b, c in its last column and row.

    weights (n, n): by which f_x is multiplied to be measured by the scale.
    """

    equations: Equations
    border: np.ndarray
    weights: np.ndarray

    @classmethod
    def at(cls, equations: Equations, u: np.ndarray) -> FoldProblem:
        """As it is best written at u (n+2,)."""
        n, scale = equations.n, equations.scale
        weights = scale[:n] / scale[:n, None]
        left, _, right = np.linalg.svd(evaluated(equations, u)[:, :n] * weights)
        return cls(equations, _border(right[-1], left[:, -1]), weights)

    @property
    def scale(self) -> np.ndarray:
        """See ``Problem``."""
        return self.equations.scale

    def residual(self, u: np.ndarray) -> tuple[np.ndarray, Bordered]:
        """f and g (n+1,), and their derivatives. dg/du only steers: it is a difference along v."""
        dgetrf, dgetrs = _routines()
        n, values, sizes = len(u) - 2, self.equations.values, self.equations.scale[: len(u) - 2]
        f, f_u = values(u)
        bordered = self.border.copy(order="K")
        np.multiply(f_u[:, :n], self.weights, out=bordered[:n, :n])
        factors, pivots, failed = dgetrf(bordered, overwrite_a=1)
        if failed:
            raise RunError("the bordered matrix of this fold is singular")
        unit = np.zeros(n + 1)
        unit[n] = 1.0
        solved, transposed = dgetrs(factors, pivots, unit)[0], dgetrs(factors, pivots, unit, trans=1)[0]
        v, w = solved[:n], transposed[:n]
        h = _STEP / math.sqrt(v @ v)
        aside = u.copy()
        aside[:n] -= h * sizes * v
        matrix = np.empty((n + 1, n + 2))
        matrix[:n] = f_u
        matrix[n] = (w / (h * sizes)) @ (values(aside)[1] - f_u)
        off = np.empty(n + 1)
        off[:n], off[n] = f, solved[n]
        return off, Bordered(matrix, v, w)

    def solution(self, jacobian: Bordered, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """See ``Problem``."""
        return bordered_solution(jacobian.matrix, row, sides)

    def renewed(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """See ``Problem``: with b and c along the null vectors, once these have turned by 0.3 rad (c^T v = b^T w = 1)."""
        v, w = point.jacobian.v, point.jacobian.w
        if max(v @ v, w @ w) < _TURNED:
            return self, point
        return FoldProblem(self.equations, _border(v, w), self.weights), point

    def outline(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ``Problem``: the unknowns."""
        return u / self.equations.scale, self._turns

    @cached_property
    def _turns(self) -> np.ndarray:
        return np.asarray(self.equations.turns / self.equations.scale)


@cache
def _routines() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """LAPACK's factorisation and solution: loading SciPy takes long, and looking it up at each call adds up."""
    from scipy.linalg.lapack import dgetrf, dgetrs

    return dgetrf, dgetrs


def evaluated(equations: Equations, u: np.ndarray) -> np.ndarray:
    """df/du (n, n+m) at a first u. Raises ``RunError`` where it is not finite."""
    matrix = equations.values(u)[1]
    if not np.isfinite(matrix).all():
        at = ", ".join(f"{name} = {v:g}" for name, v in zip(equations.names, u, strict=False))
        raise RunError(f"the equations cannot be evaluated at {at}", code="not-evaluated")
    return matrix


def _border(v: np.ndarray, w: np.ndarray) -> np.ndarray:
    n = len(v)
    border = np.zeros((n + 1, n + 1), order="F")
    border[:n, n], border[n, :n] = w / math.sqrt(w @ w), v / math.sqrt(v @ v)
    return border


@dataclass(frozen=True, eq=False)
class Fold(SpecialEquilibrium):
    """A point of a fold curve.

    point: u = (x, p, q) (n+2,) with tangent and derivatives. kind: ``""`` of a regular point, else ``"cusp"``,
    ``"bogdanov-takens"`` or ``"zero-hopf"``.
    """

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Of df/dx (n,), per unit of time, the critical one first."""
        n = self.equations.n
        values = np.linalg.eigvals(self.point.jacobian.matrix[:n, :n])
        return values[np.argsort(np.abs(values))]

    def _coefficients(self) -> Mapping[str, float]:
        """a, at a cusp c as well."""
        form = fold_form(self.equations, self.u)
        return {"a": form.a, "c": form.c} if self.kind == CUSP else {"a": form.a}


@dataclass(frozen=True, eq=False)
class Folds(SpecialCurves[Fold]):
    """Curves of folds: see ``SpecialCurves``."""

    def _problem(self, u: np.ndarray) -> FoldProblem:
        return FoldProblem.at(self.equations, u)

    def start(self, x: Sequence[float] | np.ndarray, parameters: Sequence[float]) -> CurvePoint:
        """The fold near a state (n,) and both parameters, as an ``Equilibrium`` of the kind fold has them, towards greater q.

        Raises ``RunError`` where none is found.
        """
        u = state_of(self.equations, x, parameters)
        curve = self.curve(u)
        return curve.start(u, direction(curve.problem.residual(u)[1].matrix, self.equations.scale))

    def _watch(self, _: Curve) -> Watch[Fold]:
        conditions = [
            Condition(CUSP, _curvature, _exact_curvature, 1e-5),
            Condition(BOGDANOV_TAKENS, _skew, _skew),
        ]
        if self.equations.n > 2:
            conditions.append(Condition(ZERO_HOPF, _pairs, _pairs, LOST, holds=lambda f: critical_pairs(f.eigenvalues[1:])[1]))
        return Watch(partial(Fold, self.equations), conditions)


def direction(matrix: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The direction (n+1,) that a Jacobian (n, n+1) maps to zero, in units of scale, the last parameter that moves growing."""
    along = np.linalg.svd(matrix * scale)[2][-1]
    moving = np.flatnonzero(np.abs(along) > 1e-3)[-1]
    return np.asarray(along * scale * math.copysign(1.0, along[moving]))


# The lengths of v and w lie between 1 and 1 / cos(0.3), as the border has it: they need no division here.


def _curvature(fold: Fold) -> float:
    """w^T B(v, v) in terms of w^T B(v, .): zero at a cusp."""
    jacobian: Bordered = fold.point.jacobian
    n = len(jacobian.v)
    row = jacobian.matrix[n] * fold.equations.scale
    return float(row[:n] @ jacobian.v) / math.sqrt(row @ row)


def _exact_curvature(fold: Fold) -> float:
    jacobian: Bordered = fold.point.jacobian
    scale = fold.equations.scale
    n = len(jacobian.v)
    v, w, row = jacobian.v * scale[:n], jacobian.w / scale[:n], jacobian.matrix[n] * scale
    form = expansion(fold.equations, fold.u, v[:, None]).first[..., 0]
    return float(w @ form @ v) / math.sqrt(row @ row)


def _skew(fold: Fold) -> float:
    """The cosine between v and w: zero at a Bogdanov-Takens point."""
    return float(fold.point.jacobian.v @ fold.point.jacobian.w)


def _pairs(fold: Fold) -> float:
    return critical_pairs(fold.eigenvalues[1:])[0]
