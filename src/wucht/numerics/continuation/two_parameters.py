"""Special equilibria in two parameters: their normal forms on the centre manifold, and the common part of their curves.

Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer 2004, sections 3.5, 5.4, 8.2 to 8.4 and 10.2, whose symbols
are used: f(x + y) = A y + B(y, y)/2 + C(y, y, y)/6 + ..., q and p right and left eigenvectors. The forms B and C come from
the exact Jacobian by central differences of sixth order.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from wucht.earlier_names import with_earlier_names
from wucht.errors import RunError
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations, Problem
from wucht.numerics.continuation.special_curves import (
    BOGDANOV_TAKENS,
    SpecialPointDetector,
    TracedCurve,
    bounds_of,
    require_parameter_count,
)

# First and second derivative from values at k h, k = -3 ... 3, error O(h^6): B. Fornberg, Math. Comp. 51 (1988) 699-706.
_OFFSETS = np.array([1.0, 2.0, 3.0, -1.0, -2.0, -3.0])
_FIRST = np.array([45.0, -9.0, 1.0, -45.0, 9.0, -1.0]) / 60
_SECOND = np.array([270.0, -27.0, 2.0, 270.0, -27.0, 2.0]) / 180
# In units of scale. It balances rounding, 2e-16 / h^2, against truncation, (h/L)^6 / 560, L being the length over which f
# changes its shape: both stay below 1e-10 for L from 0.1 to 3 scales.
_STEP = 0.005


def expansion(
    equations: EquilibriumEquations, unknowns: np.ndarray, directions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A = df/dx (n, n) and its first and second derivatives (n, n, k) along directions d (n, k) of the states.

    They are B(d, .) and C(d, d, .); 6 k + 1 points are evaluated at once.
    """
    n, k = directions.shape
    length = np.linalg.norm(directions / equations.scale[:n, None], axis=0)
    h = _STEP / np.where(length > 0, length, 1.0)
    around = np.repeat(unknowns[:, None], 6 * k + 1, axis=1)
    around[:n, 1:] += ((directions * h)[:, :, None] * _OFFSETS).reshape(n, 6 * k)
    jacobians = equations.values(around)[1][:, :n]
    centre, shifted_jacobians = jacobians[..., 0], jacobians[..., 1:].reshape(n, n, k, 6)
    if not np.isfinite(jacobians).all():
        raise RunError("the equations cannot be evaluated around this point")
    change = shifted_jacobians - centre[:, :, None, None]  # the weights of the second derivative add up to zero: less rounding
    return centre, shifted_jacobians @ _FIRST / h, change @ _SECOND / h**2


def fold_form(equations: EquilibriumEquations, unknowns: np.ndarray) -> tuple[float, float]:
    """Return a and c of the normal form y' = beta + a y^2 + c y^3 of a fold X = (x, p...) (n+m,), y = <p, x - x0>.

    With <q, q> = <p, q> = 1. a: the quadratic coefficient, its sign for a q whose largest entry is positive. c: the cubic one,
    where a = 0 (a cusp). Both are infinite at a Bogdanov-Takens point, where <p, q> of unit vectors is zero. Raises
    ``RunError`` where equations cannot be evaluated.
    """
    q, p = null_vectors(equations.values(unknowns)[1][:, : equations.n])
    A, first, second = expansion(equations, unknowns, q[:, None])
    n, skew = len(q), float(p @ q)
    square, cube = first[..., 0] @ q, second[..., 0] @ q
    with np.errstate(divide="ignore", invalid="ignore"):
        p = p / np.float64(skew)
        a = float(p @ square) / 2
        # A h = <p, B> q - B, <p, h> = 0: the second-order part of the centre manifold.
        bordered_matrix = np.block([[A, q[:, None]], [p[None, :], np.zeros((1, 1))]])
        if not np.isfinite(bordered_matrix).all():
            return math.inf, math.inf
        h = np.linalg.solve(bordered_matrix, np.append(2 * a * q - square, 0.0))[:n]
        return a, float(p @ (cube + 3 * first[..., 0] @ h)) / 6


def bogdanov_takens_form(equations: EquilibriumEquations, unknowns: np.ndarray) -> tuple[float, float]:
    """Return a and b of the normal form y0' = y1, y1' = beta1 + beta2 y0 + a y0^2 + b y0 y1 at X = (x, p...) (n+m,).

    y0 is along the unit null vector (largest entry > 0); Kuznetsov section 8.4.2, (8.53).
    """
    n = equations.n
    A = equations.values(unknowns)[1][:, :n]
    q0, p1 = null_vectors(A)
    # A q1 = q0, A^T p0 = p1: the singular A is bordered by its null vectors, and the border's unknown vanishes.
    bordered_matrix = np.block([[A, p1[:, None]], [q0[None, :], np.zeros((1, 1))]])
    q1 = np.linalg.solve(bordered_matrix, np.append(q0, 0.0))[:n]
    p0 = np.linalg.solve(bordered_matrix.T, np.append(p1, 0.0))[:n]
    p0, p1 = p0 / (p1 @ q1), p1 / (p1 @ q1)
    q1 = q1 - (p0 @ q1) * q0
    B = expansion(equations, unknowns, q0[:, None])[1][..., 0]
    return float(p1 @ B @ q0) / 2, float(p0 @ B @ q0 + p1 @ B @ q1)


@dataclass(frozen=True, eq=False)
class HopfForm:
    """The normal form of a Hopf point, z' = (i omega + ...) z + omega l1 z |z|^2, with <q, q> = <p, q> = 1.

    Attributes
    ----------
    frequency : float
        omega, rad per unit of time.
    l1 : float
        The first Lyapunov coefficient.
    share : float
        l1 relative to the sizes of its summands, from -1 to 1: at 1e-9 it is nothing but rounding.
    eigenvalues : ndarray of complex, (n,)
        The critical pair first.
    """

    frequency: float
    l1: float
    share: float
    eigenvalues: np.ndarray

    @property
    def supercritical(self) -> bool:
        """True if the periodic orbits that begin there are stable on the centre manifold."""
        return self.l1 < 0


def hopf_form(equations: EquilibriumEquations, unknowns: np.ndarray, frequency: float | None = None) -> HopfForm:
    """Compute the normal form of a Hopf point.

    Parameters
    ----------
    equations : EquilibriumEquations
    unknowns : ndarray, (n+m,)
        State and parameters (x, p...) of the Hopf point.
    frequency : float, optional
        Imaginary part of the critical pair; by default the pair nearest to the imaginary axis.

    Returns
    -------
    HopfForm

    Raises
    ------
    RunError
        Where there is no complex pair, a second eigenvalue is critical, or the equations cannot be evaluated.

    References
    ----------
    Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer 2004, (5.39) and (10.45).

    Examples
    --------
    Van der Pol's equation x'' + x = (mu - x^2) x' at mu = 0, where soft oscillations begin:

    >>> import numpy as np
    >>> import sympy as sp
    >>> from wucht.numerics.continuation import EquilibriumEquations, System, hopf_form
    >>> x, y, mu = sp.symbols("x y mu", real=True)
    >>> equations = EquilibriumEquations.from_system(System((x, y), (y, (mu - x**2) * y - x), (mu,)), ["mu"], {})
    >>> form = hopf_form(equations, np.zeros(3))
    >>> form.supercritical, round(form.frequency, 6)
    (True, 1.0)
    """
    n = equations.n
    values, q, p, rest = _critical(equations.values(unknowns)[1][:, :n], frequency)
    omega = float(values[0].imag)
    a, b = q.real, q.imag
    A, first, second = expansion(equations, unknowns, np.stack([a, b], axis=1))
    Ba, Bb, Caa, Cbb = first[..., 0], first[..., 1], second[..., 0], second[..., 1]
    cubic = (Caa @ a + Cbb @ a) + 1j * (Caa @ b + Cbb @ b)  # C(q, q, q*)
    mean = Ba @ a + Bb @ b  # B(q, q*)
    double = Ba @ a - Bb @ b + 2j * (Ba @ b)  # B(q, q)
    try:
        h11, h20 = np.linalg.solve(A, mean), np.linalg.solve(2j * omega * np.eye(n) - A, double)
    except np.linalg.LinAlgError:
        raise RunError("a second eigenvalue is critical: this Hopf point has no first Lyapunov coefficient") from None
    terms = np.conj(p) @ np.stack([cubic, -2 * (Ba + 1j * Bb) @ h11, (Ba - 1j * Bb) @ h20], axis=1)
    size = float(np.abs(terms).sum())
    total = float(terms.real.sum())
    return HopfForm(omega, total / (2 * omega), total / size if size else 0.0, np.concatenate([values, rest]))


def null_vectors(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the right and left unit vectors (n,) that a singular matrix (n, n) maps to zero, largest entries positive."""
    left_vectors, _, right_vectors = np.linalg.svd(matrix)
    q, p = right_vectors[-1], left_vectors[:, -1]
    return q * np.sign(q[np.abs(q).argmax()]), p * np.sign(p[np.abs(p).argmax()])


def _critical(matrix: np.ndarray, frequency: float | None) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return a critical pair (2,), positive imaginary part first, its q and p (n,), and the other eigenvalues (n-2,)."""
    from scipy.linalg.lapack import dgeev

    real, imaginary, left_vectors, right_vectors, info = dgeev(matrix)
    pairs = np.flatnonzero(imaginary > 0)
    if info or not len(pairs):
        raise RunError("there is no pair of complex eigenvalues here: this is not a Hopf point", code="no-pair")
    off = np.abs(real[pairs]) if frequency is None else np.hypot(real[pairs], imaginary[pairs] - frequency)
    i = int(pairs[off.argmin()])
    q, p = right_vectors[:, i] + 1j * right_vectors[:, i + 1], left_vectors[:, i] + 1j * left_vectors[:, i + 1]
    q = q / np.linalg.norm(q)
    values = real + 1j * imaginary
    return values[i : i + 2], q, p / np.conj(np.vdot(p, q)), np.delete(values, [i, i + 1])


@with_earlier_names
@dataclass(frozen=True, eq=False)
class SpecialEquilibrium(ABC):
    """A point of a curve of special equilibria.

    point: X = (x, p, q) (n+2,), followed by any other unknowns of the curve, with tangent and derivatives. kind: ``""`` of a
    regular point.
    """

    equations: EquilibriumEquations
    point: CurvePoint
    kind: str = ""

    @property
    def unknowns(self) -> np.ndarray:
        """States and both parameters (n+2,)."""
        return self.point.unknowns[: self.equations.n + 2]

    @property
    def x(self) -> np.ndarray:
        """The states (n,)."""
        return self.unknowns[:-2]

    @property
    def parameter_values(self) -> np.ndarray:
        """Both parameters (2,)."""
        return self.unknowns[-2:]

    @cached_property
    def coefficients(self) -> Mapping[str, float]:
        """Coefficients of the normal form, at a Bogdanov-Takens point its a and b."""
        if self.kind == BOGDANOV_TAKENS:
            return dict(zip("ab", bogdanov_takens_form(self.equations, self.unknowns), strict=True))
        return self._coefficients()

    @abstractmethod
    def _coefficients(self) -> Mapping[str, float]: ...


P = TypeVar("P", bound=SpecialEquilibrium)


@with_earlier_names
@dataclass(frozen=True, eq=False, repr=False)
class SpecialCurve(TracedCurve[P]):
    """A curve of special equilibria in two parameters that was followed to its ends.

    Attributes
    ----------
    equations : EquilibriumEquations
    points : tuple of Fold or HopfPoint
        In order, special ones included; of a closed curve the first is the last, too.
    ends : (str, str)
        Sentences with the reasons why it ends, at its first and at its last point.
    """

    @cached_property
    def unknowns(self) -> np.ndarray:
        """States and both parameters of all points (n+2, N)."""
        return np.array([p.unknowns for p in self.points]).T

    @property
    def parameter_values(self) -> np.ndarray:
        """Both parameters of all points (2, N)."""
        return self.unknowns[-2:]


@with_earlier_names
@dataclass(frozen=True, eq=False)
class SpecialCurves(ABC, Generic[P]):
    """Curves of special equilibria of equations with two varied parameters (p, q).

    equations: f(x, (p, q)). bounds: (low, high) of both. steps: see ``Steps``. limits: of some states, by their index, beyond
    which a curve is not followed.
    """

    equations: EquilibriumEquations
    bounds: Sequence[tuple[float, float]]
    steps: Steps = field(default_factory=Steps)
    limits: Mapping[int, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_parameter_count(2, self.equations)
        bounds_of(self.equations, self.limits)

    def curve(self, unknowns: np.ndarray) -> Curve:
        """Return the problem in the form that ``Curve`` follows, formulated near a point of it."""
        bounds = bounds_of(self.equations, self.limits, *self.bounds)
        return Curve(self._problem(unknowns), bounds, self.steps, names=self.equations.names)

    def walk(self, start: CurvePoint) -> Walk[P]:
        """Return the points from a first one on, special ones included, computed one by one."""
        curve, first = self._start_curve(start)
        return self._detector(curve).walk(curve, first)

    def follow_curve(self, start: CurvePoint) -> SpecialCurve[P]:
        """Follow the whole curve through a point both ways."""
        curve, first = self._start_curve(start)
        return SpecialCurve(self.equations, *self._detector(curve).trace(curve, first))

    def _start_curve(self, start: CurvePoint) -> tuple[Curve, CurvePoint]:
        """Recompute the null vectors with this border, so that no sign jumps at the first step."""
        curve = self.curve(start.unknowns)
        return curve, replace(start, jacobian=curve.problem.residual(start.unknowns)[1])

    @abstractmethod
    def _problem(self, unknowns: np.ndarray) -> Problem: ...

    @abstractmethod
    def _detector(self, curve: Curve) -> SpecialPointDetector[P]: ...
