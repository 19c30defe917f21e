"""Periodic orbit at given parameter values near an almost periodic motion, by collocation, isolated or of a family.

An orbit near x(0), T is closed by (M - 1) dx + (dx(T)/dT) dT = -gap. Where this matrix has not full rank, x(T) = x(0) + advance
becomes x(T) = x(0) + advance + sum_i s_i l_i, l_i spanning what its columns do not reach, and the change has no part along the
w_j that it maps to zero: those lead along the family. Such a bordered matrix is regular. The s_i are solved for with the
orbit: zero on a true family, and the gap of a member of one that a small term has broken.
W. Govaerts, "Numerical Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, chapter 3.

The monodromy matrix M is not multiplied out: with places on the way, the changes at all of them are the unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import sympy as sp

from wucht.errors import RunError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem, EndValues, Reference
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import mesh_from_samples, solve_across_row
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.periodic.periods import PERIOD, with_period_unit
from wucht.system import TIME, System

_SINGULAR = 1e-9  # share of the largest singular value below which a direction leads along a family
_LARGE = 10.0  # bound of that largest value: larger growth in a period is no measure
_CONDITION = 1e3  # of products of maps: a new place begins where it would become larger
_DEGREE = 6
_ACCURACY = 1e-7  # within intervals; that at mesh points is about its square
_MESH_ERROR = 1e-8  # largest error of propagated changes at mesh points
_TOLERANCE = 1e-9  # of Newton's last correction
_MOST_MESHES = 6


@dataclass(frozen=True, eq=False)
class Borders:
    """Borders that make the equations of an orbit regular, in units of the states' sizes and of the period.

    open (n, k): l_i, orthonormal. rows (k + 1, n + 1): conditions on the changes of x(0) and T, the first the one that is
    satisfied exactly (the held period, or a held state).
    """

    open: np.ndarray
    rows: np.ndarray


@dataclass(frozen=True, eq=False)
class Places:
    """Linearisation of an orbit, in units of the states' sizes and of the period.

    maps (G, n, n): from changes at a place to those at the next one. by_period (G, n): effect of a change of the period there.
    """

    maps: np.ndarray
    by_period: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        """Matrix from the changes at the places and of the period (G n + 1) to the gaps at the next places (G n)."""
        count, n, _ = self.maps.shape
        matrix = np.zeros((count, n, count * n + 1))
        for j, (step_map, late) in enumerate(zip(self.maps, self.by_period, strict=True)):
            matrix[j, :, j * n : (j + 1) * n] += step_map
            after = (j + 1) % count * n
            matrix[j, :, after : after + n] -= np.eye(n)
            matrix[j, :, -1] = late
        return matrix.reshape(count * n, -1)

    def borders(self, held_states: tuple[int, ...], free_period: bool, left_open: int, error: float = 0.0) -> Borders:
        """Return the borders of the equations.

        held_states: that keep their first value. free_period: True if T is unknown. left_open: least number of directions of a
        family. error: of the maps; smaller singular values count as zero. Raises ``RunError`` where more directions are
        singular than there are states.
        """
        count, n, _ = self.maps.shape
        free_columns = [i for i in range(count * n + free_period) if i not in held_states]
        try:
            left_vectors, values, right_vectors = np.linalg.svd(self.matrix[:, free_columns])
        except np.linalg.LinAlgError:  # they are not finite
            raise RunError("the equations are singular here") from None
        smallest = max(_SINGULAR * min(max(values[0], 1.0), _LARGE), error)
        rank = min(int((values > smallest).sum()), len(values) - left_open)
        if count * n - rank > n:
            raise RunError("the equations are singular here", code="singular")
        along = np.zeros((len(right_vectors) - rank, count * n + 1))
        along[:, free_columns] = right_vectors[rank:]
        family = np.linalg.qr(along[:, [*range(n), count * n]].T)[0].T
        fixed_rows = np.eye(n + 1)[[*(() if free_period else (n,)), *held_states]]
        return Borders(np.linalg.qr(left_vectors[-n:, rank:])[0], np.concatenate([fixed_rows, family]))

    def correction(self, gaps: np.ndarray, borders: Borders) -> tuple[np.ndarray, float, np.ndarray]:
        """Return the correction that closes an orbit: changes (G, n) at the places, of the period, and the s_i (k,).

        gaps (G, n): between the end of each place's motion and the next place. Raises ``RunError`` where that is singular.
        """
        count, n, _ = self.maps.shape
        k = borders.open.shape[1]
        matrix = np.zeros((count * n + k + 1, count * n + 1 + k))
        matrix[: count * n, : count * n + 1] = self.matrix
        matrix[(count - 1) * n : count * n, count * n + 1 :] = -borders.open
        matrix[count * n :, :n], matrix[count * n :, count * n] = borders.rows[:, :n], borders.rows[:, n]
        try:
            x = np.linalg.solve(matrix, -np.append(gaps.ravel(), np.zeros(k + 1)))
        except np.linalg.LinAlgError:
            raise RunError("the equations are singular here") from None
        return x[: count * n].reshape(count, n), float(x[count * n]), x[count * n + 1 :]


def places(maps: np.ndarray, by_period: np.ndarray) -> tuple[Places, np.ndarray]:
    """Return the fewest places between which changes grow and decay moderately, of all where the linearisation is known.

    maps (N, n, n), by_period (N, n): of neighbouring ones. Returns also the index of the first of each (G,).
    """
    firsts = [0]
    merged_maps, late = [maps[0]], [by_period[0]]
    for k in range(1, len(maps)):
        product = maps[k] @ merged_maps[-1]
        if np.linalg.cond(product) < _CONDITION:
            merged_maps[-1], late[-1] = product, maps[k] @ late[-1] + by_period[k]
        else:
            firsts.append(k)
            merged_maps.append(maps[k])
            late.append(by_period[k])
    return Places(np.array(merged_maps), np.array(late)), np.array(firsts)


@dataclass(frozen=True, eq=False)
class Closing:
    """Conditions on an orbit, the same in all steps.

    advance (n,): of each state in a period. sizes (n,). reference (n,), period: guesses of the state and the period.
    held_states: that keep their first value. free_period: True if T is unknown. left_open: see ``Places.borders``.
    """

    advance: np.ndarray
    sizes: np.ndarray
    reference: np.ndarray
    period: float
    held_states: tuple[int, ...]
    free_period: bool
    left_open: int

    def with_time(self, time: float) -> Closing:
        """Return the same conditions with the time as a last state, from a given time on."""
        n = len(self.advance)
        return replace(
            self,
            advance=np.append(self.advance, self.period),
            sizes=np.append(self.sizes, self.period),
            reference=np.append(self.reference, time),
            held_states=(n, *self.held_states),
        )

    def gap_size(self, gap: np.ndarray) -> float:
        """Return the largest component of a gap (n,), or several (n, K), by the size of each state."""
        return float(np.abs(gap.T / self.sizes).max(initial=0.0))

    def borders(self, at: Places, error: float = 0.0) -> Borders:
        """Return the borders at places. error: of the linearisation."""
        return at.borders(self.held_states, self.free_period, self.left_open, error)


def with_clock(system: System) -> System:
    """Return a System that depends on time as an autonomous one: time is its last state. Outputs are left out."""
    clock = sp.Symbol("_clock", real=True)
    definitions = tuple((s, sp.sympify(e).xreplace({TIME: clock})) for s, e in system.definitions)
    rates = tuple(sp.sympify(d).xreplace({TIME: clock}) for d in system.derivatives)
    bare = replace(system, outputs=(), quadratures=(), second_order=None)
    return replace(bare, states=(*system.states, clock), derivatives=(*rates, sp.S.One), definitions=definitions)


@dataclass(frozen=True, eq=False)
class ClosedOrbit:
    """Closed orbit as states at places.

    period: T. times (G + 1,): in periods, of places between which changes grow and decay moderately, from 0 to 1. states
    (n, G + 1): there.
    """

    period: float
    times: np.ndarray
    states: np.ndarray


def close_orbit(
    system: System, parameter_values: np.ndarray, time: float, motion: np.ndarray, closing: Closing, most_steps: int
) -> ClosedOrbit:
    """Close a motion of one period to an orbit, as piecewise polynomials.

    Parameters
    ----------
    system : System
        n states.
    parameter_values : ndarray
        In its order.
    time : float
        At which the period begins.
    motion : ndarray, (n, K)
        States at evenly spaced times.
    closing : Closing
    most_steps : int
        Of Newton's method.

    Raises
    ------
    RunError
        Where there is none near the motion.
    """
    shares, n = np.linspace(0.0, 1.0, motion.shape[1]), len(system.states)
    if system.depends_on_time:
        motion = np.concatenate([motion, time + closing.period * shares[None]])
        system, closing = with_clock(system), closing.with_time(time)
    fixed_values = dict(zip(system.parameter_names, map(float, parameter_values), strict=True))
    equations = Equations.of(with_period_unit(system), (PERIOD.name,), fixed_values)
    mesh, y = mesh_from_samples(shares, motion, closing.sizes, _DEGREE)
    period, steps_left, counts, gap = closing.period, most_steps, -1, y[-1] - y[0] - closing.advance
    for _ in range(_MOST_MESHES):
        whole, _ = _places(_problem(equations, closing, mesh, None), y, np.array([period]), closing)
        borders = closing.borders(whole, _MESH_ERROR)
        problem = _problem(equations, closing, mesh, borders)
        # Most of the gap goes where the equations cannot be closed.
        s = borders.open.T @ (gap / closing.sizes)
        unknowns = np.concatenate([y.ravel(), [period], s])
        unknowns, steps = solve_across_row(problem, unknowns, _row(problem, borders), -1 - len(s), steps_left, _TOLERANCE)
        steps_left -= steps
        y, free_parameters = problem.split(unknowns)
        period, gap = float(free_parameters[0]), closing.sizes * (borders.open @ free_parameters[1:])
        better = problem.adapt_mesh(unknowns)
        if better.mesh is mesh and counts == len(s):
            break
        if better.mesh is not mesh:
            y, mesh = mesh.interpolate(y, better.mesh.nodes), better.mesh
        counts = len(s)
        if not steps_left:
            break
    whole, firsts = _places(_problem(equations, closing, mesh, None), y, np.array([period]), closing)
    edges = np.append(firsts, mesh.intervals)
    return ClosedOrbit(period, mesh.edges[edges], y[edges * mesh.degree, :n].T)


def _problem(equations: Equations, closing: Closing, mesh: Mesh, borders: Borders | None) -> BoundaryValueProblem:
    """Return the problem y' = T f(y), closed except for open gaps; without borders the only parameter is T."""
    n, k = equations.n, 0 if borders is None else borders.open.shape[1]

    def field(unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        f, derivatives = equations.values(unknowns[: n + 1])
        return f, np.concatenate([derivatives, np.zeros((n, k, unknowns.shape[1]))], axis=1)

    sizes = np.concatenate([closing.sizes, [closing.period], np.ones(k)])
    ends = partial(_ends, closing, borders)
    nothing = Reference(np.zeros((n, 0)), np.zeros((n, 0)))
    return BoundaryValueProblem(field, n, 1 + k, ends, None, mesh, nothing, sizes, closing.advance, _ACCURACY)


def _ends(
    closing: Closing, borders: Borders | None, first: np.ndarray, last: np.ndarray, parameter_values: np.ndarray
) -> EndValues:
    """See ``Ends``: the gap, and all conditions except the first."""
    n, k = len(first), len(parameter_values) - 1
    gap = last - first - closing.advance
    if borders is None:
        return gap, -np.eye(n), np.eye(n), np.zeros((n, 1))
    rows, open_ = borders.rows[1:], closing.sizes[:, None] * borders.open
    change = np.append((first - closing.reference) / closing.sizes, parameter_values[0] / closing.period - 1)
    begin = np.concatenate([-np.eye(n), rows[:, :n] / closing.sizes])
    by_parameters = np.zeros((n + k, 1 + k))
    by_parameters[:n, 1:], by_parameters[n:, 0] = -open_, rows[:, n] / closing.period
    value = np.concatenate([gap - open_ @ parameter_values[1:], rows @ change])
    return value, begin, np.concatenate([np.eye(n), np.zeros((k, n))]), by_parameters


def _row(problem: BoundaryValueProblem, borders: Borders) -> np.ndarray:
    """Return the first condition as a row of all unknowns."""
    row = np.zeros(len(problem.scale))
    row[: problem.n] = borders.rows[0, : problem.n] / problem.sizes[: problem.n]
    row[-problem.q] = borders.rows[0, -1] / problem.sizes[problem.n]
    return row


def _places(
    problem: BoundaryValueProblem, y: np.ndarray, parameter_values: np.ndarray, closing: Closing
) -> tuple[Places, np.ndarray]:
    """Return the linearisation between places, and the intervals that begin there."""
    jacobian = problem.residual(np.concatenate([y.ravel(), parameter_values]))[1]
    n, sizes = problem.n, closing.sizes
    try:
        late, maps = -np.linalg.solve(jacobian.inner, jacobian.by_parameters)[:, -n:, 0], jacobian.maps()[:, -1]
    except np.linalg.LinAlgError:
        raise RunError("the equations are singular here") from None
    return places(maps * sizes / sizes[:, None], late * closing.period / sizes)
