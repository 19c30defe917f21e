"""Curves of folds in two parameters, and pairs of folds at one value of a parameter over two further ones.

A fold is a regular solution of f = 0, g = 0, where g comes from the matrix of df/dx with a border:

    [f_x b; c^T 0] [v; g] = [0; 1],    [f_x^T c; b^T 0] [w; g] = [0; 1],    dg/dX = -w^T f_xX v.

W. Govaerts, "Numerical Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, chapter 4; Y. A. Kuznetsov, "Elements of
Applied Bifurcation Theory", Springer 2004, section 10.2.

Two folds coincide where f(x, p) = f(z, p) = 0, det f_x(x, p) = det f_x(z, p) = 0: with n states and three parameters p
2 n + 2 equations, a curve.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from wucht.errors import RunError, WuchtError
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations, FunctionProblem, Problem, bordered_solution
from wucht.numerics.continuation.special_curves import (
    BOGDANOV_TAKENS,
    CUSP,
    ZERO_HOPF,
    Condition,
    SpecialPointDetector,
    state_of,
)
from wucht.numerics.continuation.special_points import SUM_ROUNDING, critical_pairs
from wucht.numerics.continuation.two_parameters import SpecialCurves, SpecialEquilibrium, expansion, fold_form

_REALIGN_ABOVE = 1 / math.cos(0.3) ** 2
_ONE_SIDED_STEP = 1e-7  # of a difference to one side, in units of scale: rounding and truncation are then about as large
_CENTRAL_STEP = 6e-6  # of central differences, in units of scale: the cube root of rounding
_CORRECTIONS, _ACCURATE = 40, 1e-10
_CONDITION_TOLERANCE = 1e-7  # of the change of the conditions over one scale: smaller conditions count as met
_STEPS = Steps(first=0.01, most=0.1, turn=0.1)


class BorderedJacobian(NamedTuple):
    """Derivatives at a point. matrix (n+1, n+2): of f and g. v, w (n,): null vectors of f_x, in units of scale."""

    matrix: np.ndarray
    v: np.ndarray
    w: np.ndarray


@dataclass(frozen=True, eq=False)
class FoldProblem:
    """f = 0, g = 0 with the unknowns X = (x, p, q) (n+2,). border (n+1, n+1): b, c in its last column and row.

    weights (n, n): factors of f_x that put it into units of scale.
    """

    equations: EquilibriumEquations
    border: np.ndarray
    weights: np.ndarray

    @classmethod
    def from_point(cls, equations: EquilibriumEquations, unknowns: np.ndarray) -> FoldProblem:
        """Formulate the problem with the border best suited at unknowns (n+2,)."""
        n, scale = equations.n, equations.scale
        weights = scale[:n] / scale[:n, None]
        left_vectors, _, right_vectors = np.linalg.svd(finite_jacobian(equations, unknowns)[:, :n] * weights)
        return cls(equations, _border(right_vectors[-1], left_vectors[:, -1]), weights)

    @property
    def scale(self) -> np.ndarray:
        """Unit of arclength of each unknown: see ``Problem``."""
        return self.equations.scale

    def residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, BorderedJacobian]:
        """Evaluate f and g (n+1,), and their derivatives. dg/dX only guides Newton's method: it is a difference along v."""
        dgetrf, dgetrs = _routines()
        n, values, sizes = len(unknowns) - 2, self.equations.values, self.equations.scale[: len(unknowns) - 2]
        f, derivatives = values(unknowns)
        bordered_matrix = self.border.copy(order="K")
        np.multiply(derivatives[:, :n], self.weights, out=bordered_matrix[:n, :n])
        factors, pivots, info = dgetrf(bordered_matrix, overwrite_a=1)
        if info:
            raise RunError("the bordered matrix of this fold is singular")
        unit = np.zeros(n + 1)
        unit[n] = 1.0
        solution, transposed_solution = dgetrs(factors, pivots, unit)[0], dgetrs(factors, pivots, unit, trans=1)[0]
        v, w = solution[:n], transposed_solution[:n]
        h = _ONE_SIDED_STEP / math.sqrt(v @ v)
        neighbour = unknowns.copy()
        neighbour[:n] -= h * sizes * v
        matrix = np.empty((n + 1, n + 2))
        matrix[:n] = derivatives
        matrix[n] = (w / (h * sizes)) @ (values(neighbour)[1] - derivatives)
        off = np.empty(n + 1)
        off[:n], off[n] = f, solution[n]
        return off, BorderedJacobian(matrix, v, w)

    def solution(self, jacobian: BorderedJacobian, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """Solve the bordered linear equations: see ``Problem``."""
        return bordered_solution(jacobian.matrix, row, sides)

    def reformulate(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """Align b and c with the null vectors, once these have turned by 0.3 rad (c^T v = b^T w = 1): see ``Problem``."""
        v, w = point.jacobian.v, point.jacobian.w
        if max(v @ v, w @ w) < _REALIGN_ABOVE:
            return self, point
        return FoldProblem(self.equations, _border(v, w), self.weights), point

    def outline(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the unknowns as outline: see ``Problem``."""
        return unknowns / self.equations.scale, self._turns

    @cached_property
    def _turns(self) -> np.ndarray:
        return np.asarray(self.equations.turns / self.equations.scale)


@cache
def _routines() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return LAPACK's factorisation and solution: loading SciPy takes long, and a look-up at each call adds up."""
    from scipy.linalg.lapack import dgetrf, dgetrs

    return dgetrf, dgetrs


def finite_jacobian(equations: EquilibriumEquations, unknowns: np.ndarray) -> np.ndarray:
    """Evaluate df/dX (n, n+m) at the first unknowns. Raises ``RunError`` where it is not finite."""
    matrix = equations.values(unknowns)[1]
    if not np.isfinite(matrix).all():
        at = ", ".join(f"{name} = {v:g}" for name, v in zip(equations.names, unknowns, strict=False))
        raise RunError(f"the equations cannot be evaluated at {at}", code="not-evaluated")
    return matrix


def _border(v: np.ndarray, w: np.ndarray) -> np.ndarray:
    n = len(v)
    border = np.zeros((n + 1, n + 1), order="F")
    border[:n, n], border[n, :n] = w / math.sqrt(w @ w), v / math.sqrt(v @ v)
    return border


@dataclass(frozen=True, eq=False)
class Fold(SpecialEquilibrium):
    """Fold of equilibria on a curve in two parameters.

    Attributes
    ----------
    equations : EquilibriumEquations
    point : CurvePoint
        X = (x, p, q) (n+2,) with tangent and derivatives.
    kind : str
        ``""`` of a regular point, else ``"cusp"``, ``"bogdanov-takens"`` or ``"zero-hopf"``.
    """

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Eigenvalues of df/dx (n,), per unit of time, the critical one first."""
        n = self.equations.n
        values = np.linalg.eigvals(self.point.jacobian.matrix[:n, :n])
        return values[np.argsort(np.abs(values))]

    def _coefficients(self) -> Mapping[str, float]:
        """Return a, at a cusp c as well."""
        a, c = fold_form(self.equations, self.unknowns)
        return {"a": a, "c": c} if self.kind == CUSP else {"a": a}


@dataclass(frozen=True, eq=False)
class Folds(SpecialCurves[Fold]):
    """Curves of folds of equilibria of equations with two varied parameters.

    Parameters
    ----------
    equations : EquilibriumEquations
        f(x, (p, q)) with two parameters.
    bounds : sequence of (float, float)
        Lower and upper limit of both.
    steps : Steps
    limits : mapping of int to (float, float)
        Limits of some states, by their index, beyond which a curve is not followed.

    Raises
    ------
    WuchtError
        For equations with another number of varied parameters, and limits of a state that does not exist.
    """

    def _problem(self, unknowns: np.ndarray) -> FoldProblem:
        return FoldProblem.from_point(self.equations, unknowns)

    def start(self, x: Sequence[float] | np.ndarray, parameters: Sequence[float]) -> CurvePoint:
        """Solve for the fold near a state and both parameters.

        Parameters
        ----------
        x : sequence of float, (n,)
            State, as of an ``Equilibrium`` of kind fold.
        parameters : sequence of float, (2,)
            Values of p and q there.

        Returns
        -------
        CurvePoint
            The curve is followed from it towards greater q.

        Raises
        ------
        WuchtError
            For another number of states or parameters, and numbers that are not finite.
        RunError
            Where Newton's method does not converge to a fold.
        """
        unknowns = state_of(self.equations, x, parameters)
        curve = self.curve(unknowns)
        return curve.start(unknowns, direction(curve.problem.residual(unknowns)[1].matrix, self.equations.scale))

    def _detector(self, _: Curve) -> SpecialPointDetector[Fold]:
        conditions = [
            Condition(CUSP, _curvature, _exact_curvature, 1e-5),
            Condition(BOGDANOV_TAKENS, _skew, _skew),
        ]
        if self.equations.n > 2:
            conditions.append(
                Condition(ZERO_HOPF, _pairs, _pairs, SUM_ROUNDING, holds=lambda f: critical_pairs(f.eigenvalues[1:])[1])
            )
        return SpecialPointDetector(partial(Fold, self.equations), conditions)


def direction(matrix: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return the direction (n+1,) that a Jacobian (n, n+1) maps to zero, the last parameter that changes growing."""
    along = np.linalg.svd(matrix * scale)[2][-1]
    moving = np.flatnonzero(np.abs(along) > 1e-3)[-1]
    return np.asarray(along * scale * math.copysign(1.0, along[moving]))


# The border keeps the lengths of v and w between 1 and 1 / cos(0.3): they need no division here.


def _curvature(fold: Fold) -> float:
    """Return w^T B(v, v) in terms of w^T B(v, .): zero at a cusp."""
    jacobian: BorderedJacobian = fold.point.jacobian
    n = len(jacobian.v)
    row = jacobian.matrix[n] * fold.equations.scale
    return float(row[:n] @ jacobian.v) / math.sqrt(row @ row)


def _exact_curvature(fold: Fold) -> float:
    jacobian: BorderedJacobian = fold.point.jacobian
    scale = fold.equations.scale
    n = len(jacobian.v)
    v, w, row = jacobian.v * scale[:n], jacobian.w / scale[:n], jacobian.matrix[n] * scale
    form = expansion(fold.equations, fold.unknowns, v[:, None])[1][..., 0]
    return float(w @ form @ v) / math.sqrt(row @ row)


def _skew(fold: Fold) -> float:
    """Return the cosine between v and w: zero at a Bogdanov-Takens point."""
    return float(fold.point.jacobian.v @ fold.point.jacobian.w)


def _pairs(fold: Fold) -> float:
    return critical_pairs(fold.eigenvalues[1:])[0]


@dataclass(frozen=True, eq=False)
class FoldPairs:
    """Pairs of folds at one value of each varied parameter: three parameters, or two for ``nearest_pair`` alone.

    bounds: (low, high) of each.
    """

    equations: EquilibriumEquations
    bounds: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if len(self.equations.parameter_names) not in (2, 3):
            raise WuchtError("two folds coincide at points of two parameters, or on curves in three of them", code="count")

    def nearest_pair(self, first: np.ndarray, second: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """Solve for x, z and p (2 n + m,) nearest to states and parameters, by the Gauss-Newton method. Raises ``RunError``."""
        unknowns = np.concatenate([first, second, parameters])
        for _ in range(_CORRECTIONS):
            off, jacobian = self._residual(unknowns)
            slopes = jacobian * self._scale
            change = np.linalg.pinv(slopes) @ off
            unknowns = unknowns - change * self._scale
            # Where no parameter separates the values at both folds, the best compromise does not change either.
            if np.linalg.norm(change) < _ACCURATE and np.linalg.norm(off) < _CONDITION_TOLERANCE * np.linalg.norm(slopes):
                return self._require_distinct(unknowns)
        raise RunError("Newton's method does not converge to a point at which both folds coincide")

    def walk(self, unknowns: np.ndarray, way: int = 1) -> Walk[tuple[Curve, CurvePoint]]:
        """Return the points after one, for growing values of the third parameter (way 1) or the other way."""
        n, curve = self.equations.n, self._curve
        along = np.linalg.svd(self._residual(unknowns)[1] * self._scale)[2][-1]
        grows = along[2 * n + 1 :][np.abs(along[2 * n + 1 :]).argmax()]
        return curve.follow(curve.start(unknowns, along * self._scale * way * np.sign(grows)))

    @property
    def _curve(self) -> Curve:
        n = self.equations.n
        return Curve(FunctionProblem(self._residual, self._scale), {2 * n + k: b for k, b in enumerate(self.bounds)}, _STEPS)

    @property
    def _scale(self) -> np.ndarray:
        n, scale = self.equations.n, self.equations.scale
        return np.concatenate([scale[:n], scale])

    def _residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        step = _CENTRAL_STEP * self._scale
        columns = [
            (self._conditions(unknowns + h) - self._conditions(unknowns - h)) / (2 * _CENTRAL_STEP) for h in np.diag(step)
        ]
        return self._conditions(unknowns), np.array(columns).T / self._scale

    def _conditions(self, unknowns: np.ndarray) -> np.ndarray:
        m = len(self.equations.parameter_names)
        return np.concatenate([self._fold(x, unknowns[-m:]) for x in unknowns[:-m].reshape(2, -1)])

    def _fold(self, x: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        n, scale = self.equations.n, self.equations.scale
        f, derivatives = self.equations.values(np.concatenate([x, parameters]))
        matrix = derivatives[:, :n] * (scale[:n] / scale[:n, None])
        size = np.linalg.norm(matrix)
        # A homogeneous function of degree one of the matrix: as large as f is.
        return np.append(f / scale[:n], np.linalg.det(matrix / size) * size if size else 0.0)

    def _require_distinct(self, unknowns: np.ndarray) -> np.ndarray:
        n, scale = self.equations.n, self.equations.scale[: self.equations.n]
        if np.linalg.norm((unknowns[:n] - unknowns[n : 2 * n]) / scale) < 1e-6:
            raise RunError("both folds are the same point")
        return unknowns
