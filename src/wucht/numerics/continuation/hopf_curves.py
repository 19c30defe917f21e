"""Curves of Hopf points in two parameters.

With A = df/dx and kappa = omega^2 a Hopf point is a regular solution of f = 0 and of two entries of G = 0, where

    [A^2 + kappa I, b; c^T, 0] [V; G] = [0; I],   [.]^T [W; G^T] = [0; I],   dG/dX = -W^T (A^2 + kappa I)_X V,

with borders b, c of two columns. This stays regular at a Bogdanov-Takens point, where kappa passes zero; beyond it the
eigenvalues are real, +-sqrt(-kappa): neutral saddles, which are no Hopf points.
Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer 2004, section 10.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.equations import CurvePoint, Equations, Problem, bordered_solution
from wucht.numerics.continuation.fold_curves import direction, finite_jacobian
from wucht.numerics.continuation.special_curves import (
    BOGDANOV_TAKENS,
    DOUBLE_HOPF,
    GENERALISED_HOPF,
    ZERO_HOPF,
    Condition,
    SpecialPointDetector,
    state_of,
)
from wucht.numerics.continuation.special_points import SUM_ROUNDING, critical_pairs, least_real
from wucht.numerics.continuation.two_parameters import HopfForm, SpecialCurves, SpecialEquilibrium, hopf_form

_STEP = 6e-6  # of a central difference, in units of scale: the cube root of rounding
_ROUNDING = 1e-10  # of kappa, in units of its scale
_SHARE = 1e-8  # l1 relative to the sizes of its summands: less is rounding
_ENDS = "it ends at a Bogdanov-Takens point: beyond it, two real eigenvalues of opposite signs add up to zero"


class DoublyBorderedJacobian(NamedTuple):
    """Derivatives at a point. matrix (n+2, n+3): of f and two entries of G. V, W (n, 2): null vectors of A^2 + kappa I."""

    matrix: np.ndarray
    V: np.ndarray
    W: np.ndarray


@dataclass(frozen=True, eq=False)
class HopfProblem:
    """f = 0 and two entries of G = 0 with the unknowns X = (x, p, q, kappa) (n+3,).

    border (n+2, n+2): b, c in its last two columns and rows. entries: row and column of both entries of G. scale (n+3,).
    """

    equations: Equations
    border: np.ndarray
    entries: tuple[tuple[int, int], tuple[int, int]]
    scale: np.ndarray

    @classmethod
    def from_point(cls, equations: Equations, unknowns: np.ndarray) -> HopfProblem:
        """Formulate the problem with the border best suited at unknowns (n+3,)."""
        n, sizes = equations.n, equations.scale[: equations.n]
        A = finite_jacobian(equations, unknowns[:-1])[:, :n] * (sizes / sizes[:, None])
        left_vectors, _, right_vectors = np.linalg.svd(A @ A + unknowns[-1] * np.eye(n))
        size = float(np.linalg.norm(A, 2)) ** 2
        scale = np.append(equations.scale, size if size > 0 else 1.0)
        return cls(equations, *_border_and_entries(A, right_vectors[-2:].T, left_vectors[:, -2:]), scale)

    @cached_property
    def _weights(self) -> np.ndarray:
        sizes = self.equations.scale[: self.equations.n]
        return np.asarray(sizes / sizes[:, None])

    def residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, DoublyBorderedJacobian]:
        """Evaluate f and two entries of G (n+2,), and their derivatives.

        Those of G only guide Newton's method: they are central differences along V and A V.
        """
        from scipy.linalg.lapack import dgesv  # dgetrs of two right-hand sides wakes other threads, however small they are

        n, sizes, at = self.equations.n, self.equations.scale, unknowns[:-1]
        f, derivatives = self.equations.values(at)
        A = derivatives[:, :n] * self._weights
        bordered_matrix = self.border.copy()
        bordered_matrix[:n, :n] = A @ A
        bordered_matrix[range(n), range(n)] += unknowns[-1]
        units = np.eye(n + 2)[:, n:]
        _, _, solution, info = dgesv(bordered_matrix, units)
        if info:
            raise RunError("the bordered matrix of this Hopf point is singular")
        transposed_solution = dgesv(bordered_matrix.T, units)[2]
        V, W = solution[:n], transposed_solution[:n]
        G, AV, WA = solution[n:], A @ V, A.T @ W
        along = np.concatenate([V, AV], axis=1)
        h = _STEP / np.maximum(np.linalg.norm(along, axis=0), np.finfo(float).tiny)
        move = along * h * sizes[:n, None]
        around = np.repeat(at[:, None], 8, axis=1)
        around[:n, :4] += move
        around[:n, 4:] -= move
        jacobians = self.equations.values(around)[1]
        change = (jacobians[..., :4] - jacobians[..., 4:]) / (2 * h * sizes[:n, None, None])  # (n, n+2, 4): f_xX V, f_xX A V
        matrix = np.zeros((n + 2, n + 3))
        matrix[:n, :-1] = derivatives
        for row, (i, j) in enumerate(self.entries, n):
            matrix[row, :-1] = -(W[:, i] @ change[..., 2 + j] + WA[:, i] @ change[..., j])
            matrix[row, -1] = -W[:, i] @ V[:, j]
        return np.append(f, [G[i, j] for i, j in self.entries]), DoublyBorderedJacobian(matrix, V, W)

    def solution(self, jacobian: DoublyBorderedJacobian, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """Solve the bordered linear equations: see ``Problem``."""
        return bordered_solution(jacobian.matrix, row, sides)

    def reformulate(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """Align b and c with the null vectors, and take the most independent entries of G: see ``Problem``."""
        n, jacobian = self.equations.n, point.jacobian
        A = jacobian.matrix[:n, :n] * self._weights
        return HopfProblem(self.equations, *_border_and_entries(A, jacobian.V, jacobian.W), self.scale), point

    def outline(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the unknowns as outline: see ``Problem``."""
        return unknowns / self.scale, np.append(self.equations.turns, 0.0) / self.scale


def _border_and_entries(
    A: np.ndarray, V: np.ndarray, W: np.ndarray
) -> tuple[np.ndarray, tuple[tuple[int, int], tuple[int, int]]]:
    """Return the border and the two entries of G that suit null vectors (n, 2).

    On the critical plane A^2 + kappa I = tr A + (kappa - det) I: G is a combination of W^T A V and W^T V, and the two entries
    must be independent.
    """
    n = len(A)
    V, W = np.linalg.qr(V)[0], np.linalg.qr(W)[0]
    border = np.zeros((n + 2, n + 2), order="F")
    border[:n, n:], border[n:, :n] = W, V.T
    matrix_entries, unit_entries = (W.T @ A @ V).ravel(), (W.T @ V).ravel()
    products = np.outer(matrix_entries, unit_entries)
    first, second = divmod(int(np.abs(products - products.T).argmax()), 4)
    return border, (divmod(first, 2), divmod(second, 2))


@dataclass(frozen=True, eq=False)
class HopfPoint(SpecialEquilibrium):
    """Hopf point on a curve in two parameters.

    Attributes
    ----------
    equations : Equations
    point : CurvePoint
        X = (x, p, q, kappa) (n+3,), kappa the square of the frequency, with tangent and derivatives.
    kind : str
        ``""`` of a regular point, else ``"bogdanov-takens"``, ``"zero-hopf"``,
        ``"generalised-hopf"`` or ``"double-hopf"``.
    """

    @property
    def frequency(self) -> float:
        """Frequency in rad per unit of time; 0 at a Bogdanov-Takens point."""
        return float(max(self.point.unknowns[-1], 0.0) ** 0.5)

    @cached_property
    def noncritical_eigenvalues(self) -> np.ndarray:
        """The eigenvalues of df/dx (n-2,), per unit of time, without the critical pair."""
        n, pair = self.equations.n, 1j * np.sqrt(complex(self.point.unknowns[-1]))
        values = np.linalg.eigvals(self.point.jacobian.matrix[:n, :n])
        for critical in (pair, -pair):
            values = np.delete(values, np.abs(values - critical).argmin())
        return values

    @cached_property
    def form(self) -> HopfForm | None:
        """The normal form; None where there is none, as at a Bogdanov-Takens point."""
        if not self.frequency > 0:
            return None
        try:
            return hopf_form(self.equations, self.unknowns, self.frequency)
        except RunError:
            return None

    def _coefficients(self) -> Mapping[str, float]:
        return {"l1": self.form.l1} if self.form else {}


@dataclass(frozen=True, eq=False)
class HopfPoints(SpecialCurves[HopfPoint]):
    """Curves of Hopf points of equations with two varied parameters.

    Parameters
    ----------
    equations : Equations
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

    def _problem(self, unknowns: np.ndarray) -> HopfProblem:
        return HopfProblem.from_point(self.equations, unknowns)

    def start(self, x: Sequence[float] | np.ndarray, parameters: Sequence[float], frequency: float | None = None) -> CurvePoint:
        """Solve for the Hopf point near a state and both parameters.

        Parameters
        ----------
        x : sequence of float, (n,)
            State, as of an ``Equilibrium`` of kind hopf.
        parameters : sequence of float, (2,)
            Values of p and q there.
        frequency : float, optional
            In rad per unit of time, by default that of the complex pair nearest to the imaginary axis; 0 at a Bogdanov-Takens
            point.

        Returns
        -------
        CurvePoint
            The curve is followed from it towards greater frequency.

        Raises
        ------
        WuchtError
            For another number of states or parameters, and numbers that are not finite.
        RunError
            Where Newton's method does not converge, or to a neutral saddle.
        """
        at = state_of(self.equations, x, parameters)
        if frequency is None:
            values = np.linalg.eigvals(finite_jacobian(self.equations, at)[:, : self.equations.n])
            values = values[values.imag > 0]
            if not len(values):
                raise RunError("no pair of complex eigenvalues near this state: there is no Hopf point nearby", code="no-pair")
            frequency = float(values[np.abs(values.real).argmin()].imag)
        unknowns = np.append(at, frequency**2)
        curve = self.curve(unknowns)
        hopf_point = curve.start(unknowns, direction(curve.problem.residual(unknowns)[1].matrix, curve.problem.scale))
        if hopf_point.unknowns[-1] < -_ROUNDING * curve.problem.scale[-1]:
            raise RunError(
                "near this state there is no Hopf point, but a saddle whose eigenvalues add up to zero", code="neutral-saddle"
            )
        return hopf_point

    def _detector(self, curve: Curve) -> SpecialPointDetector[HopfPoint]:
        n, kappa = self.equations.n, float(curve.problem.scale[-1])

        def square(point: HopfPoint) -> float:
            return float(point.point.unknowns[-1]) / kappa

        conditions = [
            Condition(BOGDANOV_TAKENS, square, square, _ROUNDING, end=_ENDS),
            Condition(GENERALISED_HOPF, _sure_lyapunov, _lyapunov, relative=True),
        ]
        if n > 2:
            conditions.append(Condition(ZERO_HOPF, _least, _least, SUM_ROUNDING))
        if n > 3:
            conditions.append(
                Condition(
                    DOUBLE_HOPF, _pairs, _pairs, SUM_ROUNDING, holds=lambda p: critical_pairs(p.noncritical_eigenvalues)[1]
                )
            )
        return SpecialPointDetector(partial(HopfPoint, self.equations), conditions)


def _lyapunov(point: HopfPoint) -> float:
    return point.form.frequency * point.form.l1 if point.form else math.nan


def _sure_lyapunov(point: HopfPoint) -> float:
    return _lyapunov(point) if point.form and abs(point.form.share) > _SHARE else 0.0


def _least(point: HopfPoint) -> float:
    eigenvalues = point.noncritical_eigenvalues
    return least_real(eigenvalues, max(float(np.abs(eigenvalues).max()), point.frequency))


def _pairs(point: HopfPoint) -> float:
    return critical_pairs(point.noncritical_eigenvalues)[0]
