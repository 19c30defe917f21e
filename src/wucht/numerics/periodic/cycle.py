"""A periodic orbit as collocation has it, and what about it is zero where its stability changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import Collocated
from wucht.numerics.continuation.equations import CurvePoint, Problem

FOLD, DOUBLING, TORUS, BRANCH_POINT = "fold", "period-doubling", "torus", "branch-point"
_STILL = 0.02  # by how much of its size a parameter changes, at most, while the period grows e-fold
VANISHED = 1e-4  # times the orbit before: what is smaller is an equilibrium
_LOST = 1e-2  # of the trivial multiplier's logarithm: beyond it the others are not known either


@dataclass(frozen=True, eq=False)
class Orbit(Collocated):
    """A periodic orbit of a branch or a curve. curve: the problem with its mesh. point: of the curve."""

    @property
    def period(self) -> float:
        """T."""
        return float(self.problem.split(self.point.u)[1][0])


class Hidden(NamedTuple):
    """A special point that was not located: its kind, and the parameter's values at the orbits on either side."""

    kind: str
    between: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Cycle(Orbit):
    """A periodic orbit of a branch.

    logarithms (n-1,): ln mu of Floquet's multipliers without the trivial one. Of two states that is the integral of the
    divergence over a period (Liouville's formula); of more they are those of the collocation, right near the unit circle, not
    where mu is tiny (``floquet`` has those). along: ln mu of the trivial one, 0 but for errors. product_error: by how much the
    sum of all is not the integral of the divergence. basis (n-1, n-1): of their invariant subspaces, for a neighbour.
    kind: ``""``, ``"fold"``, ``"period-doubling"``, ``"torus"``, ``"branch-point"``, or ``"unresolved"``: a special point
    that was not located lies between the orbit before and this one. other: at a branch point, the direction, of all unknowns,
    of the branch that crosses. hidden: of an unresolved point, what it may be, and the parameter's values between which it is.
    """

    logarithms: np.ndarray
    along: float
    product_error: float
    basis: np.ndarray
    kind: str = ""
    other: np.ndarray = field(default_factory=lambda: np.empty(0))
    hidden: Hidden | None = None

    @property
    def parameter(self) -> float:
        """The parameter's value."""
        return float(self.point.u[-1])

    def integral(self, values: np.ndarray) -> float:
        """The integral over a period, in time, of values at the nodes (K,)."""
        mesh = self.problem.mesh
        return self.period * float((mesh.weights * (mesh.pieces(values) @ mesh.basis.values.T)).sum())

    @property
    def unstable(self) -> int:
        """How many multipliers lie outside the unit circle; of a special orbit those that lie on it do not count."""
        return int((np.delete(self.logarithms.real, self._on_circle) > 0).sum())

    @property
    def _on_circle(self) -> list[int]:
        """Which of the multipliers lie on the unit circle, by the kind."""
        values = self.logarithms
        if self.kind in (FOLD, BRANCH_POINT):
            return [int(np.abs(values).argmin())]
        if self.kind == DOUBLING:
            return [int((np.abs(values.real) + np.abs(np.abs(values.imag) - math.pi)).argmin())]
        return critical_pair(values) if self.kind == TORUS else []

    @property
    def past_one(self) -> float:
        """Of one sign while no multiplier passes 1: the product of (mu - 1)/(1 + |mu|)."""
        return _product(self.logarithms)

    @property
    def trusted(self) -> bool:
        """Whether the multipliers are known: near a connection of saddles they grow until even the trivial one is lost.

        Of two states the only one is known without that.
        """
        return len(self.logarithms) < 2 or abs(self.along) < _LOST

    @property
    def lengthens(self) -> bool:
        """Whether along the branch the period grows and the parameter hardly changes, as it comes near an equilibrium."""
        longer, further = self.point.tangent[-2:] / (self.period, self.problem.sizes[-1])
        return bool(abs(further) < _STILL * longer)

    @property
    def error(self) -> float:
        """By how much the orbit is about wrong between mesh points, in units of its sizes."""
        return float(self.problem.error(self.point.u).max())

    def on(self, mesh: Mesh) -> CurvePoint:
        """Its point of the curve on another mesh."""
        if self.problem.mesh is mesh:
            return self.point
        u, tangent = self.problem.moved(np.stack([self.point.u, self.point.tangent], axis=1), mesh).T
        return replace(self.point, u=u, tangent=tangent)


def swing(here: Orbit, there: Orbit) -> float:
    """How large another orbit is in terms of this one, both without winding: negative where it goes on half a period later.

    So it is once a branch has passed through a point, as at a Hopf point. Orbits that wind have no such size: 1.
    """
    return _size_in_terms_of(here.problem, here.states, there.at(here.tau))


def is_orbit(problem: Problem, here: CurvePoint, there: CurvePoint) -> bool:
    """Whether a point of a curve after another one is an orbit too: an equilibrium satisfies the same equations."""
    assert isinstance(problem, BoundaryValueProblem)
    a, b = (problem.split(point.u)[0].T for point in (here, there))
    return abs(_size_in_terms_of(problem, a, b)) > VANISHED


def _size_in_terms_of(problem: BoundaryValueProblem, a: np.ndarray, b: np.ndarray) -> float:
    """Of states (n, K) at the nodes of a problem, in terms of others."""
    if np.any(problem.winding):
        return 1.0
    shares = problem.mesh.shares
    a, b = (each - (each @ shares)[:, None] for each in (a, b))
    along, whole = ((a * other) @ shares / problem.sizes[: len(a)] ** 2 for other in (b, a))
    return float(along.sum() / whole.sum())


def _along_parameter(cycle: Cycle) -> float:
    return float(cycle.point.tangent[-1])


def _minus_one(cycle: Cycle) -> float:
    return _product(cycle.logarithms + 1j * math.pi)


def _on_circle(cycle: Cycle) -> float:
    """Zero where the product of two multipliers is 1."""
    return _product(_sums(cycle.logarithms))


def _plus_one(cycle: Cycle) -> float:
    """Passes zero where a second multiplier is 1 and the branch does not turn: where another branch crosses it."""
    return cycle.past_one * _along_parameter(cycle)


def has_pair_on_circle(cycle: Cycle) -> bool:
    """Whether those two multipliers whose product is nearest to 1 are a complex pair."""
    i, _ = critical_pair(cycle.logarithms)
    return bool(abs(cycle.logarithms[i].imag) not in (0.0, math.pi))


def critical_pair(logarithms: np.ndarray) -> list[int]:
    """Which two multipliers, given ln mu, have the product that is nearest to 1."""
    nearest = np.abs(np.expm1(_sums(logarithms))).argmin()
    return [int(each[nearest]) for each in np.triu_indices(len(logarithms), 1)]


def _sums(logarithms: np.ndarray) -> np.ndarray:
    i, j = np.triu_indices(len(logarithms), 1)
    return np.asarray(logarithms[i] + logarithms[j])


def _product(logarithms: np.ndarray) -> float:
    """The product of (mu - 1)/(1 + |mu|), given ln mu."""
    large = logarithms.real > 0
    bounded = np.where(large, -logarithms, logarithms)  # mu - 1 = -mu (1/mu - 1)
    sign = np.where(large, -np.exp(1j * logarithms.imag), 1.0)
    return float(np.prod(sign * (np.expm1(bounded)) / (1 + np.exp(bounded.real))).real)


TESTS: Mapping[str, Callable[[Cycle], float]] = {
    FOLD: _along_parameter,
    DOUBLING: _minus_one,
    TORUS: _on_circle,
    BRANCH_POINT: _plus_one,
}
