"""A boundary value problem y' = g(y, P) on [0, 1] with as many conditions as make its solutions a curve, for ``Curve``.

Conditions are at the ends, b(y(0), y(1), P) = 0, and on integrals, int h(y, P) = 0; with n states and q parameters there are
n + q - 1 of them. E. J. Doedel, "Lecture notes on numerical analysis of nonlinear equations", in: Numerical Continuation
Methods for Dynamical Systems, Springer 2007.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.collocation.condensation import CollocationJacobian
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.equations import CurvePoint, Equations, Problem
from wucht.system import System

Field = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""(y, P) (n+q, K) -> g (n, K), dg/d(y, P) (n, n+q, K)."""
EndValues = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
Ends = Callable[[np.ndarray, np.ndarray, np.ndarray], EndValues]
"""y(0) (n,), y(1) (n,), P (q,) -> b (k,), its derivatives by y(0) (k, n), y(1) (k, n), P (k, q)."""


def at_begin(state: sp.Symbol) -> sp.Symbol:
    """The value of a state at 0, for a condition."""
    return sp.Symbol(f"{state.name}(0)", real=True)


def at_end(state: sp.Symbol) -> sp.Symbol:
    """The value of a state at 1, for a condition."""
    return sp.Symbol(f"{state.name}(1)", real=True)


@dataclass(frozen=True, eq=False)
class EndConditions:
    """b(y(0), y(1), P) = 0 with its derivatives: ``Ends`` of a boundary value problem.

    formulas: of n states at 0, those at 1, and q parameters -> b (k,) and its derivatives (k, 2n+q).
    """

    formulas: Callable[[np.ndarray], tuple[list[float], list[list[float]]]]
    n: int

    @classmethod
    def of(
        cls, system: System, parameters: Sequence[str], fixed: Mapping[str, float], conditions: Sequence[sp.Expr]
    ) -> EndConditions:
        """Of formulas that have to be zero: of ``at_begin`` and ``at_end`` of states, and of parameters.

        Raises ``WuchtError`` for a formula in which anything else occurs.
        """
        varied = [p for name in parameters for p in system.parameters if p.name == name]
        held = {p: fixed[p.name] for p in system.parameters if p not in varied}
        known = [*map(at_begin, system.states), *map(at_end, system.states), *varied]
        b = sp.Matrix([sp.sympify(c).subs(held) for c in conditions])
        if other := sorted(s.name for s in b.free_symbols - set(known)):
            raise WuchtError(
                f"{other[0]} is no value of a state at_begin or at_end and no parameter: a condition has only those",
                code="unknown-name",
            )
        formulas = sp.lambdify([known], [list(b), b.jacobian(known).tolist()], "numpy", cse=True)
        return cls(formulas, len(system.states))

    def __call__(
        self, first: np.ndarray, last: np.ndarray, parameters: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """See ``Ends``."""
        b, by = (np.array(each, float) for each in self.formulas(np.concatenate([first, last, parameters])))
        return b, by[:, : self.n], by[:, self.n : 2 * self.n], by[:, 2 * self.n :]


@dataclass(frozen=True, eq=False)
class Reference:
    """The solution at the point before, at the points of collocation. y, slope (n, K): it and its derivative."""

    y: np.ndarray
    slope: np.ndarray


Integrand = Callable[[np.ndarray, np.ndarray, Reference], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""y (n, K), P (q,), the reference -> h (r, K), its derivatives by y (r, n, K) and P (r, q, K)."""

_FEWER, _MORE = 0.8, 1.1  # times the intervals: less is not worth a new mesh
_SPARE = 1.1  # times the intervals of a mesh that is best for the next orbit, not for this one
_INTERVALS = (8, 400)
_FIRST = (40, 6)  # intervals and degree where no mesh is given
_UNEVEN = 1.25  # how many more mesh points than the mean an interval may want before the mesh is changed


@dataclass(frozen=True, eq=False)
class BoundaryValueProblem:
    """See the module. The unknowns u are y at the nodes of the mesh, node by node, then the parameters P.

    field: g. n, q: how many states and parameters. ends, integrand: the conditions; those on integrals may be none.
    mesh: its nodes. reference: of the conditions on integrals. sizes (n+q,): by how much each state and parameter changes when
    it changes much. winding (n,): y(1) - y(0) of a periodic solution, whose first condition on an integral fixes the
    phase; None where it is not periodic.
    accuracy: wanted within intervals, in units of sizes; at mesh points it is about the square of that.
    """

    field: Field
    n: int
    q: int
    ends: Ends
    integrand: Integrand | None
    mesh: Mesh
    reference: Reference
    sizes: np.ndarray
    winding: np.ndarray | None = None
    accuracy: float = 1e-7

    @classmethod
    def of(
        cls,
        system: System,
        parameters: Sequence[str],
        fixed: Mapping[str, float],
        conditions: Sequence[sp.Expr],
        *,
        scale: Mapping[str, float] | None = None,
        accuracy: float = 1e-7,
    ) -> BoundaryValueProblem:
        """Of a System, its time running from 0 to 1, with formulas for what holds at both ends.

        Parameters
        ----------
        system : System
            Whose equations do not depend on time: a time that matters is a state whose derivative is 1, a length L of the
            interval a parameter by which all derivatives are multiplied.
        parameters : sequence of str
            Those that vary; the last one is that over which solutions are followed.
        fixed : mapping
            Values of all others.
        conditions : sequence of sympy.Expr
            What is zero: formulas of ``at_begin`` and ``at_end`` of states, and of parameters; as many as there are states and
            parameters that vary, less one.
        scale : mapping, optional
            By how much states and parameters change when they change much, by name; 1 where it is silent.
        accuracy : float
            Wanted, in units of scale.

        Raises
        ------
        WuchtError
            For another number of conditions, a formula of anything else, and as ``Equations.of``.
        """
        equations = Equations.of(system, parameters, fixed, scale)
        n, q = equations.n, len(parameters)
        if not q or len(conditions) != n + q - 1:
            told = f"{n} states and {q} parameters: given are {len(conditions)} conditions at the ends"
            raise WuchtError(
                f"{told}, where a curve of solutions has one parameter at least, and {n + max(q, 1) - 1} of them", code="count"
            )
        ends, nothing = EndConditions.of(system, parameters, fixed, conditions), Reference(np.zeros((n, 0)), np.zeros((n, 0)))
        return cls(equations.values, n, q, ends, None, Mesh.even(*_FIRST), nothing, equations.scale, None, accuracy)

    def split(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """y at the nodes (N m + 1, n), and P (q,)."""
        return u[: -self.q].reshape(-1, self.n), u[-self.q :]

    @property
    def periodic(self) -> bool:
        """Whether y(1) is y(0), but for a winding."""
        return self.winding is not None

    @cached_property
    def scale(self) -> np.ndarray:
        """See ``Problem``: the size of a function is its mean square over [0, 1], all states together."""
        per_node = 1 / np.sqrt(self.mesh.shares)
        return np.concatenate([(per_node[:, None] * self.sizes[: self.n]).ravel(), self.sizes[self.n :]])

    def residual(self, u: np.ndarray) -> tuple[np.ndarray, CollocationJacobian]:
        """See ``Problem``."""
        y, parameters = self.split(u)
        mesh, n, q = self.mesh, self.n, self.q
        intervals, m, lagrange = mesh.intervals, mesh.degree, mesh.basis.values
        pieces = mesh.pieces(y)
        at, slopes = lagrange @ pieces, (mesh.basis.slopes @ pieces) / mesh.lengths[:, None, None]
        states = at.reshape(-1, n).T
        g, g_u = self.field(np.concatenate([states, np.broadcast_to(parameters[:, None], (q, states.shape[1]))]))
        off = slopes.reshape(-1, n) - g.T
        by_states = g_u[:, :n].transpose(2, 0, 1).reshape(intervals, m, n, 1, n)
        derived = mesh.basis.slopes[:, None, :, None] * np.eye(n)[:, None]
        blocks = derived / mesh.lengths[:, None, None, None, None] - by_states * lagrange[:, None, :, None]
        blocks = blocks.reshape(intervals, m * n, (m + 1) * n)
        by_parameters = -g_u[:, n:].transpose(2, 0, 1).reshape(intervals, m * n, q)
        b, begin, end, ends_by_parameters = self.ends(y[0], y[-1], parameters)
        h, integrals, integrals_by_parameters = self._integrals(states, parameters)
        jacobian = CollocationJacobian(
            blocks[..., :n], blocks[..., n:], by_parameters, begin, end, ends_by_parameters, integrals, integrals_by_parameters
        )
        return np.concatenate([off.ravel(), b, h]), jacobian

    def rates_at_edges(self, u: np.ndarray) -> np.ndarray:
        """g (N+1, n) at the edges of the mesh."""
        y, parameters = self.split(u)
        at = y[:: self.mesh.degree].T
        return self.field(np.concatenate([at, np.broadcast_to(parameters[:, None], (self.q, at.shape[1]))]))[0].T

    def divergences(self, u: np.ndarray) -> np.ndarray:
        """The trace of dg/dy, integrated over each interval (N,): by which ln of volumes grows (Liouville)."""
        y, parameters = self.split(u)
        at = (self.mesh.basis.values @ self.mesh.pieces(y)).reshape(-1, self.n).T
        g_u = self.field(np.concatenate([at, np.broadcast_to(parameters[:, None], (self.q, at.shape[1]))]))[1]
        return np.asarray((np.trace(g_u[:, : self.n]).reshape(self.mesh.weights.shape) * self.mesh.weights).sum(axis=1))

    def _integrals(self, states: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        mesh, n = self.mesh, self.n
        if self.integrand is None:
            return np.zeros(0), np.zeros((0, mesh.intervals, mesh.degree + 1, n)), np.zeros((0, self.q))
        h, by_states, by_parameters = self.integrand(states, parameters, self.reference)
        weights = mesh.weights.ravel()
        weighted = (by_states * weights).reshape(len(h), n, mesh.intervals, mesh.degree)
        return h @ weights, (weighted @ mesh.basis.values).transpose(0, 2, 3, 1), by_parameters @ weights

    def solution(self, jacobian: CollocationJacobian, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """See ``Problem``; the determinant's sign is not known: 0."""
        return jacobian.solve(row, sides), 0

    def renewed(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """See ``Problem``: the reference is the point's solution; the mesh follows it from time to time."""
        better = self.remeshed(point.u)
        u, tangent, bend = point.u, point.tangent, np.zeros_like(point.u) if point.bend is None else point.bend
        if better.mesh is not self.mesh:
            u, tangent, bend = self.moved(np.stack([u, tangent, bend], axis=1), better.mesh).T
        problem = replace(better, reference=better.referred(u))
        if self.periodic and self.integrand is not None:
            tangent, bend = problem._in_phase(u, tangent), problem._in_phase(u, bend)
        jacobian = point.jacobian if better.mesh is self.mesh else None
        return problem, CurvePoint(u, tangent, jacobian, point.length, point.orientation, bend)

    def _in_phase(self, u: np.ndarray, change: np.ndarray) -> np.ndarray:
        """A change of an orbit u, but for the shift of its phase that its first condition on an integral forbids."""
        y, parameters = self.split(u)
        shift = np.append(self.mesh.slopes(y).ravel(), np.zeros(self.q))
        _, row, _ = self._integrals(self.reference.y, parameters)
        along, share = ((row[0] * self.mesh.pieces(self.split(each)[0])).sum() for each in (shift, change))
        return np.asarray(change - share / along * shift)

    def remeshed(self, u: np.ndarray) -> BoundaryValueProblem:
        """The problem on a mesh that suits a solution, if its own does not: as many intervals as the accuracy asks for."""
        values = self.split(u)[0] / self.sizes[: self.n]
        wanted = _SPARE * self.mesh.wanted(values, self.periodic, self.accuracy)
        intervals = int(np.clip(math.ceil(wanted), *_INTERVALS))
        if _FEWER * self.mesh.intervals < intervals < _MORE * self.mesh.intervals:
            intervals = self.mesh.intervals
            if self.mesh.unevenness(values, self.periodic) < _UNEVEN:
                return self
        return replace(self, mesh=self.mesh.adapted(values, self.periodic, intervals))

    def referred(self, u: np.ndarray) -> Reference:
        """A solution as the next one's reference."""
        pieces = self.mesh.pieces(self.split(u)[0])
        slopes = (self.mesh.basis.slopes @ pieces) / self.mesh.lengths[:, None, None]
        return Reference((self.mesh.basis.values @ pieces).reshape(-1, self.n).T, slopes.reshape(-1, self.n).T)

    def error(self, u: np.ndarray) -> np.ndarray:
        """About by how much the solution is wrong within each interval (N,), in units of its sizes; far less at mesh points."""
        return self.mesh.error(self.split(u)[0] / self.sizes[: self.n], self.periodic)

    def moved(self, u: np.ndarray, mesh: Mesh) -> np.ndarray:
        """A solution, or a change of it, on another mesh; or several, as columns."""
        values = u[: -self.q].reshape(len(self.mesh.nodes), -1)
        return np.concatenate([self.mesh.at(values, mesh.nodes).reshape(-1, *u.shape[1:]), u[-self.q :]])

    def outline(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ``Problem``: the parameters, mean and mean square of states that return, which no shift of the phase changes."""
        y, parameters = self.split(u)
        scaled = (y / self.sizes[: self.n])[:, np.ones(self.n, bool) if self.winding is None else self.winding == 0]
        # By Gauss' quadrature: what the orbit is must not depend on its mesh.
        at, weights = (
            (self.mesh.basis.values @ self.mesh.pieces(scaled)).reshape(-1, scaled.shape[1]),
            self.mesh.weights.ravel(),
        )
        mean = weights @ at
        numbers = np.concatenate([mean, weights @ (at - mean) ** 2, parameters / self.sizes[self.n :]])
        return numbers, np.zeros(len(numbers))
