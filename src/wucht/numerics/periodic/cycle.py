"""Periodic orbits by collocation, and test functions that are zero where their stability changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from wucht.earlier_names import with_earlier_names
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import CollocationSolution
from wucht.numerics.continuation.equations import CurvePoint, Problem

FOLD, DOUBLING, TORUS, BRANCH_POINT = "fold", "period-doubling", "torus", "branch-point"
_STILL = 0.02  # largest relative change of a parameter while the period grows e-fold
VANISHING_SIZE = 1e-4  # times the previous orbit: a smaller one is an equilibrium
_TRUST_LIMIT = 1e-2  # of the trivial multiplier's logarithm: beyond it the others are not accurate either


@dataclass(frozen=True, eq=False)
class Orbit(CollocationSolution):
    """Periodic orbit of a branch or a curve. curve: the problem with its mesh. point: of the curve."""

    @property
    def period(self) -> float:
        """T."""
        return float(self.problem.split(self.point.unknowns)[1][0])


class HiddenPoint(NamedTuple):
    """Special point that was not located: its kind, and the parameter's values at the orbits on either side."""

    kind: str
    interval: tuple[float, float]


@with_earlier_names
@dataclass(frozen=True, eq=False)
class Cycle(Orbit):
    """Periodic orbit on a branch in one parameter.

    Attributes
    ----------
    curve : Curve
        The branch, with the collocation problem on the orbit's mesh.
    point : CurvePoint
        The orbit's unknowns: states at the nodes, period and parameter.
    logarithms : ndarray of complex, (n-1,)
        ln mu of Floquet's multipliers without the trivial one. For two states that is the integral of the divergence over a
        period (Liouville's formula); for more they are those of the collocation, accurate near the unit circle, not where mu
        is tiny (see ``floquet``).
    along : float
        ln mu of the trivial multiplier, 0 except for errors.
    product_error : float
        Difference of the sum of all ln mu and the integral of the divergence.
    basis : ndarray, (n-1, n-1)
        Basis of the invariant subspaces, for a neighbour.
    kind : str
        ``""``, ``"fold"``, ``"period-doubling"``, ``"torus"``, ``"branch-point"``, or ``"unresolved"``: a special point that
        was not located lies between the orbit before and this one.
    crossing_direction : ndarray
        At a branch point the direction, of all unknowns, of the branch that crosses.
    hidden_point : HiddenPoint or None
        Possible kind and interval of an unresolved point.
    """

    logarithms: np.ndarray
    along: float
    product_error: float
    basis: np.ndarray
    kind: str = ""
    crossing_direction: np.ndarray = field(default_factory=lambda: np.empty(0))
    hidden_point: HiddenPoint | None = None

    @property
    def parameter(self) -> float:
        """Value of the parameter."""
        return float(self.point.unknowns[-1])

    def integral(self, values: np.ndarray) -> float:
        """Return the integral over a period, in time, of values at the nodes (K,)."""
        mesh = self.problem.mesh
        return self.period * float((mesh.weights * (mesh.pieces(values) @ mesh.basis.values.T)).sum())

    @property
    def unstable(self) -> int:
        """Number of multipliers outside the unit circle; those of a special orbit that lie on it do not count."""
        return int((np.delete(self.logarithms.real, self._indices_on_circle) > 0).sum())

    @property
    def _indices_on_circle(self) -> list[int]:
        """Indices of the multipliers on the unit circle, by the kind."""
        values = self.logarithms
        if self.kind in (FOLD, BRANCH_POINT):
            return [int(np.abs(values).argmin())]
        if self.kind == DOUBLING:
            return [int((np.abs(values.real) + np.abs(np.abs(values.imag) - math.pi)).argmin())]
        return critical_pair(values) if self.kind == TORUS else []

    @property
    def past_one(self) -> float:
        """Product of (mu - 1)/(1 + |mu|): of constant sign while no multiplier passes 1."""
        return _product(self.logarithms)

    @property
    def is_trusted(self) -> bool:
        """True if the multipliers are accurate: near a connection of saddles they grow until even the trivial one is lost.

        For two states the only one is always accurate.
        """
        return len(self.logarithms) < 2 or abs(self.along) < _TRUST_LIMIT

    @property
    def lengthens(self) -> bool:
        """True if along the branch the period grows while the parameter hardly changes, as near an equilibrium."""
        longer, further = self.point.tangent[-2:] / (self.period, self.problem.sizes[-1])
        return bool(abs(further) < _STILL * longer)

    @property
    def error(self) -> float:
        """Estimated error of the orbit between mesh points, in units of its sizes."""
        return float(self.problem.error(self.point.unknowns).max())

    @property
    def is_accurate(self) -> bool:
        """True if that error is as small as required; it may be larger on the way, on the mesh of the orbit before."""
        return self.problem.is_accurate(self.point.unknowns)

    def point_on(self, mesh: Mesh) -> CurvePoint:
        """Return its point of the curve on another mesh."""
        if self.problem.mesh is mesh:
            return self.point
        unknowns, tangent = self.problem.to_mesh(np.stack([self.point.unknowns, self.point.tangent], axis=1), mesh).T
        return replace(self.point, unknowns=unknowns, tangent=tangent)


def swing(here: Orbit, there: Orbit) -> float:
    """Return the size of another orbit in terms of this one, both without winding: negative if shifted by half a period.

    That happens once a branch has passed through a point, as at a Hopf point. Orbits that wind have no such size: 1.
    """
    return _relative_size(here.problem, here.states, there.states_at(here.tau))


def is_orbit(problem: Problem, here: CurvePoint, there: CurvePoint) -> bool:
    """True if a point of a curve after another one is an orbit too: an equilibrium satisfies the same equations."""
    assert isinstance(problem, BoundaryValueProblem)
    a, b = (problem.split(point.unknowns)[0].T for point in (here, there))
    return abs(_relative_size(problem, a, b)) > VANISHING_SIZE


def _relative_size(problem: BoundaryValueProblem, a: np.ndarray, b: np.ndarray) -> float:
    """Return the size of states b (n, K) at the nodes of a problem in terms of states a."""
    if np.any(problem.winding):
        return 1.0
    shares = problem.mesh.shares
    a, b = (values - (values @ shares)[:, None] for values in (a, b))
    along, whole = ((a * factor) @ shares / problem.sizes[: len(a)] ** 2 for factor in (b, a))
    return float(along.sum() / whole.sum())


def _parameter_slope(cycle: Cycle) -> float:
    return float(cycle.point.tangent[-1])


def _product_at_minus_one(cycle: Cycle) -> float:
    return _product(cycle.logarithms + 1j * math.pi)


def _pair_product(cycle: Cycle) -> float:
    """Return a function that is zero where the product of two multipliers is 1."""
    return _product(_sums(cycle.logarithms))


def _product_at_plus_one(cycle: Cycle) -> float:
    """Return a function that passes zero where a second multiplier is 1 without a fold: where another branch crosses."""
    return cycle.past_one * _parameter_slope(cycle)


def has_pair_on_circle(cycle: Cycle) -> bool:
    """True if the two multipliers whose product is nearest to 1 are a complex pair."""
    i, _ = critical_pair(cycle.logarithms)
    return bool(abs(cycle.logarithms[i].imag) not in (0.0, math.pi))


def critical_pair(logarithms: np.ndarray) -> list[int]:
    """Return the indices of the two multipliers, given ln mu, whose product is nearest to 1."""
    nearest = np.abs(np.expm1(_sums(logarithms))).argmin()
    return [int(indices[nearest]) for indices in np.triu_indices(len(logarithms), 1)]


def _sums(logarithms: np.ndarray) -> np.ndarray:
    i, j = np.triu_indices(len(logarithms), 1)
    return np.asarray(logarithms[i] + logarithms[j])


def _product(logarithms: np.ndarray) -> float:
    """Return the product of (mu - 1)/(1 + |mu|), given ln mu."""
    large = logarithms.real > 0
    bounded_logarithms = np.where(large, -logarithms, logarithms)  # mu - 1 = -mu (1/mu - 1)
    sign = np.where(large, -np.exp(1j * logarithms.imag), 1.0)
    return float(np.prod(sign * (np.expm1(bounded_logarithms)) / (1 + np.exp(bounded_logarithms.real))).real)


TESTS: Mapping[str, Callable[[Cycle], float]] = {
    FOLD: _parameter_slope,
    DOUBLING: _product_at_minus_one,
    TORUS: _pair_product,
    BRANCH_POINT: _product_at_plus_one,
}
