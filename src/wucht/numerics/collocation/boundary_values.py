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

from wucht.earlier_names import provide_earlier_names
from wucht.errors import WuchtError
from wucht.numerics.collocation.condensation import CollocationJacobian
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations, Problem
from wucht.system import System

Field = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""(y, P) (n+q, K) -> g (n, K), dg/d(y, P) (n, n+q, K)."""
EndValues = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
EndFunction = Callable[[np.ndarray, np.ndarray, np.ndarray], EndValues]
"""y(0) (n,), y(1) (n,), P (q,) -> b (k,), its derivatives by y(0) (k, n), y(1) (k, n), P (k, q)."""


def start_value(state: sp.Symbol) -> sp.Symbol:
    """Return the symbol of a state's value at 0, for a condition.

    Parameters
    ----------
    state : sympy.Symbol
        A state of the System.

    Returns
    -------
    sympy.Symbol
    """
    return sp.Symbol(f"{state.name}(0)", real=True)


def end_value(state: sp.Symbol) -> sp.Symbol:
    """Return the symbol of a state's value at 1, for a condition.

    Parameters
    ----------
    state : sympy.Symbol
        A state of the System.

    Returns
    -------
    sympy.Symbol
    """
    return sp.Symbol(f"{state.name}(1)", real=True)


def end_conditions(
    system: System, parameter_names: Sequence[str], fixed_values: Mapping[str, float], conditions: Sequence[sp.Expr]
) -> EndFunction:
    """Return b(y(0), y(1), P) = 0 with its derivatives, of formulas that must vanish.

    They are in ``start_value`` and ``end_value`` of states and in parameters. Raises ``WuchtError`` for a formula in which
    anything else occurs.
    """
    parameter_symbols = [p for name in parameter_names for p in system.parameters if p.name == name]
    substitutions = {p: fixed_values[p.name] for p in system.parameters if p not in parameter_symbols}
    variables = [*map(start_value, system.states), *map(end_value, system.states), *parameter_symbols]
    b = sp.Matrix([sp.sympify(c).subs(substitutions) for c in conditions])
    if unknown_names := sorted(s.name for s in b.free_symbols - set(variables)):
        raise WuchtError(
            f"{unknown_names[0]} is neither a start_value or end_value of a state nor a parameter: a condition has only these",
            code="unknown-name",
        )
    formulas = sp.lambdify([variables], [list(b), b.jacobian(variables).tolist()], "numpy", cse=True)
    n = len(system.states)

    def values(first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> EndValues:
        b, by = (np.array(part, float) for part in formulas(np.concatenate([first, last, parameters])))
        return b, by[:, :n], by[:, n : 2 * n], by[:, 2 * n :]

    return values


@dataclass(frozen=True, eq=False)
class Reference:
    """The previous solution at the collocation points. y, slope (n, K): its values and derivatives."""

    y: np.ndarray
    slope: np.ndarray


Integrand = Callable[[np.ndarray, np.ndarray, Reference], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""y (n, K), P (q,), the reference -> h (r, K), its derivatives by y (r, n, K) and P (r, q, K)."""

_FEWER, _MORE = 0.8, 1.1  # times the intervals: less is not worth a new mesh
_SPARE = 1.1  # times the intervals of a mesh that is best for the next orbit, not for this one
_INTERVALS = (8, 400)
_FIRST = (40, 6)  # intervals and degree where no mesh is given
_UNEVEN = 1.25  # an interval may need so many times the mean number of mesh points before the mesh is changed


@dataclass(frozen=True, eq=False)
class BoundaryValueProblem:
    """Boundary value problem y' = g(y, P) on [0, 1], discretised. ``BoundaryValueProblem.of`` builds it from formulas.

    The unknowns are y at the nodes of the mesh, node by node, then the parameters P.

    Attributes
    ----------
    field : callable
        g: (y, P) (n+q, K) -> g (n, K) and its derivatives (n, n+q, K).
    n, q : int
        Number of states and of parameters.
    ends : callable
        Conditions at the ends: y(0) (n,), y(1) (n,), P (q,) -> b (k,), and its derivatives by y(0) (k, n), y(1) (k, n) and
        P (k, q).
    integrand : callable or None
        Conditions on integrals: y (n, K), P (q,), reference -> h (r, K), and its derivatives by y (r, n, K) and P (r, q, K).
    mesh : Mesh
    reference : Reference
        The previous solution, for the conditions on integrals.
    sizes : ndarray, (n+q,)
        A typical large change of each state and parameter.
    winding : ndarray, (n,), or None
        y(1) - y(0) of a periodic solution, whose first condition on an integral fixes the phase; None where it is not
        periodic.
    accuracy : float
        Required within intervals, in units of sizes; at mesh points the error is about its square.
    """

    field: Field
    n: int
    q: int
    ends: EndFunction
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
        parameter_names: Sequence[str],
        fixed_values: Mapping[str, float],
        conditions: Sequence[sp.Expr],
        *,
        scale: Mapping[str, float] | None = None,
        accuracy: float = 1e-7,
    ) -> BoundaryValueProblem:
        """Build the problem of a System whose time runs from 0 to 1, with formulas for the conditions at both ends.

        Parameters
        ----------
        system : System
            Whose equations do not depend on time: a time that matters is a state whose derivative is 1, a length L of the
            interval a parameter by which all derivatives are multiplied.
        parameter_names : sequence of str
            Of those that vary; solutions are followed over the last one.
        fixed_values : mapping
            Values of all other parameters.
        conditions : sequence of sympy.Expr
            Formulas that must vanish, in ``start_value`` and ``end_value`` of states and in parameters; as many as there are
            states and parameters that vary, less one.
        scale : mapping, optional
            A typical large change of states and parameters, by name; 1 where none is given.
        accuracy : float
            Required, in units of scale.

        Returns
        -------
        BoundaryValueProblem

        Raises
        ------
        WuchtError
            For another number of conditions, a formula with other symbols, and as ``EquilibriumEquations.from_system``.
        """
        equations = EquilibriumEquations.from_system(system, parameter_names, fixed_values, scale)
        n, q = equations.n, len(parameter_names)
        if not q or len(conditions) != n + q - 1:
            counts = f"{n} states and {q} parameters with {len(conditions)} conditions at the ends"
            raise WuchtError(
                f"{counts}: a curve of solutions needs at least one parameter, and {n + max(q, 1) - 1} conditions", code="count"
            )
        ends, no_reference = (
            end_conditions(system, parameter_names, fixed_values, conditions),
            Reference(np.zeros((n, 0)), np.zeros((n, 0))),
        )
        return cls(equations.values, n, q, ends, None, Mesh.even(*_FIRST), no_reference, equations.scale, None, accuracy)

    def split(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return y at the nodes (N m + 1, n), and P (q,)."""
        return unknowns[: -self.q].reshape(-1, self.n), unknowns[-self.q :]

    @property
    def periodic(self) -> bool:
        """True if y(1) equals y(0), but for a winding."""
        return self.winding is not None

    @cached_property
    def scale(self) -> np.ndarray:
        """Unit of arclength, see ``Problem``: the size of a function is its mean square over [0, 1], all states together."""
        per_node = 1 / np.sqrt(self.mesh.shares)
        return np.concatenate([(per_node[:, None] * self.sizes[: self.n]).ravel(), self.sizes[self.n :]])

    def residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, CollocationJacobian]:
        """Evaluate the equations and their Jacobian: see ``Problem``."""
        y, parameters = self.split(unknowns)
        mesh, n, q = self.mesh, self.n, self.q
        intervals, m, lagrange = mesh.intervals, mesh.degree, mesh.basis.values
        pieces = mesh.pieces(y)
        at, slopes = lagrange @ pieces, (mesh.basis.slopes @ pieces) / mesh.lengths[:, None, None]
        states = at.reshape(-1, n).T
        g, derivatives = self.field(np.concatenate([states, np.broadcast_to(parameters[:, None], (q, states.shape[1]))]))
        off = slopes.reshape(-1, n) - g.T
        by_states = derivatives[:, :n].transpose(2, 0, 1).reshape(intervals, m, n, 1, n)
        differentiation = mesh.basis.slopes[:, None, :, None] * np.eye(n)[:, None]
        blocks = differentiation / mesh.lengths[:, None, None, None, None] - by_states * lagrange[:, None, :, None]
        blocks = blocks.reshape(intervals, m * n, (m + 1) * n)
        by_parameters = -derivatives[:, n:].transpose(2, 0, 1).reshape(intervals, m * n, q)
        b, begin, end, ends_by_parameters = self.ends(y[0], y[-1], parameters)
        h, integrals, integrals_by_parameters = self._integrals(states, parameters)
        jacobian = CollocationJacobian(
            blocks[..., :n], blocks[..., n:], by_parameters, begin, end, ends_by_parameters, integrals, integrals_by_parameters
        )
        return np.concatenate([off.ravel(), b, h]), jacobian

    def rates_at_edges(self, unknowns: np.ndarray) -> np.ndarray:
        """Return g (N+1, n) at the edges of the mesh."""
        y, parameters = self.split(unknowns)
        at = y[:: self.mesh.degree].T
        return self.field(np.concatenate([at, np.broadcast_to(parameters[:, None], (self.q, at.shape[1]))]))[0].T

    def divergences(self, unknowns: np.ndarray) -> np.ndarray:
        """Integrate the trace of dg/dy over each interval (N,): the growth of ln of volumes (Liouville)."""
        y, parameters = self.split(unknowns)
        at = (self.mesh.basis.values @ self.mesh.pieces(y)).reshape(-1, self.n).T
        derivatives = self.field(np.concatenate([at, np.broadcast_to(parameters[:, None], (self.q, at.shape[1]))]))[1]
        return np.asarray((np.trace(derivatives[:, : self.n]).reshape(self.mesh.weights.shape) * self.mesh.weights).sum(axis=1))

    def _integrals(self, states: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        mesh, n = self.mesh, self.n
        if self.integrand is None:
            return np.zeros(0), np.zeros((0, mesh.intervals, mesh.degree + 1, n)), np.zeros((0, self.q))
        h, by_states, by_parameters = self.integrand(states, parameters, self.reference)
        weights = mesh.weights.ravel()
        weighted_derivatives = (by_states * weights).reshape(len(h), n, mesh.intervals, mesh.degree)
        return h @ weights, (weighted_derivatives @ mesh.basis.values).transpose(0, 2, 3, 1), by_parameters @ weights

    def solution(self, jacobian: CollocationJacobian, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """Solve the bordered linear equations: see ``Problem``; the determinant's sign is not computed: 0."""
        return jacobian.solve(row, sides), 0

    def reformulate(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """Take the point's solution as reference, and adapt the mesh from time to time: see ``Problem``."""
        better = self.adapt_mesh(point.unknowns)
        unknowns, tangent, bend = (
            point.unknowns,
            point.tangent,
            np.zeros_like(point.unknowns) if point.bend is None else point.bend,
        )
        if better.mesh is not self.mesh:
            unknowns, tangent, bend = self.to_mesh(np.stack([unknowns, tangent, bend], axis=1), better.mesh).T
        problem = replace(better, reference=better.reference_from(unknowns))
        if self.periodic and self.integrand is not None:
            tangent, bend = problem._without_phase_shift(unknowns, tangent), problem._without_phase_shift(unknowns, bend)
        jacobian = point.jacobian if better.mesh is self.mesh else None
        return problem, CurvePoint(unknowns, tangent, jacobian, point.length, point.orientation, bend)

    def _without_phase_shift(self, unknowns: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Remove from a change of an orbit the phase shift that its first condition on an integral forbids."""
        y, parameters = self.split(unknowns)
        shift = np.append(self.mesh.slopes(y).ravel(), np.zeros(self.q))
        _, row, _ = self._integrals(self.reference.y, parameters)
        along, share = ((row[0] * self.mesh.pieces(self.split(direction)[0])).sum() for direction in (shift, change))
        return np.asarray(change - share / along * shift)

    def adapt_mesh(self, unknowns: np.ndarray) -> BoundaryValueProblem:
        """Return the problem on a mesh that suits a solution, with as many intervals as the accuracy requires."""
        values = self.split(unknowns)[0] / self.sizes[: self.n]
        target = _SPARE * self.mesh.required_intervals(values, self.periodic, self.accuracy)
        intervals = int(np.clip(math.ceil(target), *_INTERVALS))
        if _FEWER * self.mesh.intervals < intervals < _MORE * self.mesh.intervals:
            intervals = self.mesh.intervals
            if self.mesh.unevenness(values, self.periodic) < _UNEVEN:
                return self
        return replace(self, mesh=self.mesh.adapt(values, self.periodic, intervals))

    def reference_from(self, unknowns: np.ndarray) -> Reference:
        """Return a solution as the reference of the next one."""
        pieces = self.mesh.pieces(self.split(unknowns)[0])
        slopes = (self.mesh.basis.slopes @ pieces) / self.mesh.lengths[:, None, None]
        return Reference((self.mesh.basis.values @ pieces).reshape(-1, self.n).T, slopes.reshape(-1, self.n).T)

    def error(self, unknowns: np.ndarray) -> np.ndarray:
        """Estimate the error of the solution within each interval (N,), in units of its sizes; far less at mesh points."""
        return self.mesh.error(self.split(unknowns)[0] / self.sizes[: self.n], self.periodic)

    def is_accurate(self, unknowns: np.ndarray) -> bool:
        """True if a solution is as accurate as required, but for the unevenness with which a mesh is kept."""
        return bool(self.error(unknowns).max() <= _UNEVEN ** (self.mesh.degree + 1) * self.accuracy)

    def to_mesh(self, unknowns: np.ndarray, mesh: Mesh) -> np.ndarray:
        """Interpolate a solution, or a change of it, or several as columns, to another mesh."""
        values = unknowns[: -self.q].reshape(len(self.mesh.nodes), -1)
        return np.concatenate([self.mesh.interpolate(values, mesh.nodes).reshape(-1, *unknowns.shape[1:]), unknowns[-self.q :]])

    def outline(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the parameters, and mean and mean square of states that return: a phase shift does not change these."""
        y, parameters = self.split(unknowns)
        scaled_states = (y / self.sizes[: self.n])[:, np.ones(self.n, bool) if self.winding is None else self.winding == 0]
        # By Gauss' quadrature: the identity of the orbit must not depend on its mesh.
        at, weights = (
            (self.mesh.basis.values @ self.mesh.pieces(scaled_states)).reshape(-1, scaled_states.shape[1]),
            self.mesh.weights.ravel(),
        )
        mean = weights @ at
        numbers = np.concatenate([mean, weights @ (at - mean) ** 2, parameters / self.sizes[self.n :]])
        return numbers, np.zeros(len(numbers))


provide_earlier_names(__name__)
