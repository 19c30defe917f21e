"""Orbits from one equilibrium to another, or back to it, over two or more parameters: connections of saddles and saddle-nodes.

y' = T f(y, p) over a long time T, y(0) - x in the directions in which the equilibrium x is left, y(1) - z - 2 pi winding in
those in which z is reached; f(x, p) = f(z, p) = 0. Of a saddle-node the leaving direction is that of the eigenvalue zero: an
orbit that returns to it along the others is where a saddle-node on an orbit becomes a saddle connection.
W.-J. Beyn, IMA J. Numer. Anal. 10 (1990) 379-405; A. R. Champneys, Yu. A. Kuznetsov, B. Sandstede, Int. J. Bifurcation Chaos 6
(1996) 867-887.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.errors import RunError, WuchtError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem, EndValues, Reference
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import mesh_from_samples, refine_on_common_mesh, solve_near
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations
from wucht.numerics.continuation.special_curves import UNRESOLVED_POINT
from wucht.numerics.continuation.special_points import locate_zero
from wucht.numerics.periodic.connection import (
    LONG,
    TESTS,
    Connection,
    end_distances,
    end_reason,
    is_standstill,
    leading_rate,
    lengthen_orbit,
    missing_times,
    standstill_sentence,
)
from wucht.system import System

_STEP = 6e-6  # of central differences, in units of scale: the cube root of rounding
_DEGREE = 6
_FIXED_PARAMETER = sp.Symbol("_held", real=True)
_STEPS = Steps(most=0.5, turn=0.3, corrections=4, tolerance=1e-7, predicts_correction=True)
_FAR = 1e-5  # of the orbit's size: where its ends are farther from the saddle, it is extended
_MOST_LONGER, _LONGER = 8, 4.0  # number of extensions at a first point, and largest factor of each
_MANY = 120  # intervals of a mesh, from which on orbits are not extended: next to a Hopf point they never come near its end
_LOCATING = 1e-9  # accuracy of the mesh on which special points are located


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of an equilibrium that is left in one direction.

    leaving (n,): its left eigenvector, normal to the stable subspace. complement (n-1, n): a basis of the span of the
    other left eigenvectors, normal to the leaving direction. by_right, by_left: the states by which the right and the left
    eigenvector of the leaving direction are normalised, the largest where they were chosen.
    """

    leaving: np.ndarray
    complement: np.ndarray
    by_right: int
    by_left: int

    @classmethod
    def from_jacobian(cls, jacobian: np.ndarray, scale: np.ndarray, by: tuple[int, int] | None = None) -> Directions:
        """Return the directions of a Jacobian (n, n), scaled by sizes (n,).

        by: the states by which both eigenvectors are normalised, where they are compared with those at another place: with
        the largest component of each they would jump. Raises ``RunError`` where the leaving eigenvalue is complex.
        """
        matrix = jacobian / scale[:, None] * scale
        right_vector, left_vector = _leaving(matrix), _leaving(matrix.T)
        by_right, by_left = by or (int(np.abs(right_vector).argmax()), int(np.abs(left_vector).argmax()))
        complement = np.delete(np.eye(len(scale)), by_right, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):  # not finite where such a state takes no part in an eigenvector
            complement[:, by_right] = -np.delete(right_vector, by_right) / right_vector[by_right]
            leaving = left_vector / left_vector[by_left]
        return cls(leaving / scale, complement / scale, by_right, by_left)


def _leaving(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvector (n,) of the largest eigenvalue, which is simple, so the vector is well defined."""
    values, vectors = np.linalg.eig(matrix)
    k = int(values.real.argmax())
    if values[k].imag != 0:
        raise RunError("the equilibrium has more than one unstable direction")
    return np.asarray(vectors[:, k].real)


@dataclass(frozen=True, eq=False)
class Connections:
    """Curves of connections of equilibria each of which is left in one direction. ``Connections.of`` sets them up.

    Attributes
    ----------
    rates : EquilibriumEquations
        f(x, p), p being the varied parameters.
    time : float
        Duration T of the orbit, at least.
    winding : ndarray, (n,)
        Turns of each angle along the orbit, 0 of other states.
    bounds : tuple of (float, float)
        Lower and upper limits of the parameters.
    folds : tuple of bool
        True for those of the one or two equilibria that are saddle-nodes.
    steps : Steps
    accuracy : float
        Required between mesh points, in units of scale.
    longest : float
        Time up to which orbits of saddles are extended where their ends do not come near to them.
    """

    rates: EquilibriumEquations
    time: float
    winding: np.ndarray
    bounds: tuple[tuple[float, float], ...]
    folds: tuple[bool, ...]
    steps: Steps
    accuracy: float
    longest: float = math.inf

    @classmethod
    def of(
        cls,
        system: System,
        parameter_names: Sequence[str],
        fixed_values: Mapping[str, float],
        bounds: Sequence[tuple[float, float]],
        time: float,
        *,
        folds: Sequence[bool] = (False,),
        winding: Mapping[str, int] | None = None,
        scale: Mapping[str, float] | None = None,
        steps: Steps | None = None,
        accuracy: float = 1e-7,
        longest: float = math.inf,
    ) -> Connections:
        """Set up connections of an autonomous System.

        Parameters
        ----------
        system : System
        parameter_names : sequence of str
            Two, and one more for each saddle-node; one less where a single connection is computed, not a curve of them.
        fixed_values : mapping
            Values of all others.
        bounds : sequence of (float, float)
            Of the parameters.
        time : float
            Least duration of the orbit.
        folds : sequence of bool
            True if the equilibrium is a saddle-node; two where the orbit leads to another one, else it returns up to
            ``winding`` turns of angles.
        winding, scale, steps, accuracy
            As of ``Cycles.of``.
        longest : float
            An orbit of saddles is extended beyond ``time``, up to this, where its ends are not yet near them: the error of
            the parameters is about the square of that distance. An orbit of a saddle-node is not: it comes near only as 1/time.

        Returns
        -------
        Connections

        Raises
        ------
        WuchtError
            For another number of parameters, and as ``EquilibriumEquations.from_system``.
        """
        count, parameter_count = len(folds), 2 + sum(folds)
        if (
            count not in (1, 2)
            or not len(parameter_names) == len(bounds)
            or len(parameter_names) not in (parameter_count, parameter_count - 1)
        ):
            raise WuchtError(
                "a curve of connections has two parameters with bounds, and one more for each saddle-node", code="count"
            )
        if len(parameter_names) < parameter_count:  # with a fixed parameter on which nothing depends the curve becomes a point
            system = replace(system, parameters=(*system.parameters, _FIXED_PARAMETER))
            parameter_names, bounds = (*parameter_names, _FIXED_PARAMETER.name), (*bounds, (-math.inf, math.inf))
        bare = System(system.states, system.derivatives, system.parameters, system.definitions, angles=system.angles)
        rates = EquilibriumEquations.from_system(bare, tuple(parameter_names), fixed_values, scale)
        turns = np.array([(winding or {}).get(name, 0) for name in system.state_names])
        return cls(rates, time, turns, tuple(bounds), tuple(folds), steps or _STEPS, accuracy, longest)

    def start(self, times: np.ndarray, states: np.ndarray, equilibria: np.ndarray, values: Sequence[float]) -> Connection:
        """Compute the connection near an orbit, the last parameter fixed. Raises ``RunError`` where there is none.

        times (K,), states (n, K): samples that begin and end near the equilibria (e, n). values: of the parameters.
        """
        mesh, y = mesh_from_samples(times, states, self.rates.scale[: self.rates.n], _DEGREE)
        m = len(self.bounds)
        values = [*values, *[0.0] * (m - len(values))]
        unknowns = np.concatenate([y.ravel(), np.ravel(equilibria), values])
        connection = self.connection_from_point(*solve_near(self._curve(mesh), unknowns))
        for _ in range(_MOST_LONGER):
            before, connection = connection, self.prolong(connection, fix_last=True)
            if connection is before:
                break
        return connection

    def prolong(self, connection: Connection, *, fix_last: bool = False) -> Connection:
        """Extend a connection to a longer time where its ends are too far from its saddles; else return it unchanged.

        fix_last: True to fix the last parameter, as in ``start``; else the point moves across its tangent.
        """
        scale, advance = self.rates.scale[: self.rates.n], 2 * math.pi * self.winding
        room = min(self.longest - connection.time, (_LONGER - 1) * connection.time)
        near = max(end_distances(connection, scale, advance)) <= _FAR
        enough = connection.problem.mesh.intervals > _MANY
        if any(self.folds) or enough or not room > 0 or (near and connection.time >= self.time):
            return connection
        more = missing_times(connection, scale, advance, self.time)
        if not more.sum() > 0:
            return connection
        matrix = self.rates.values(self._places(connection.point.unknowns[-self._q :])[-1])[1][:, : self.rates.n]
        more = more * min(1.0, room / more.sum())
        mesh, y, changes = lengthen_orbit(connection, more, matrix, advance)
        later, q, point = replace(self, time=connection.time + float(more.sum())), self._q, connection.point
        unknowns = np.concatenate([y.ravel(), point.unknowns[-q:]])
        towards = np.concatenate([changes.ravel(), point.tangent[-q:]])
        try:
            curve, new_point = solve_near(later._curve(mesh), unknowns, None if fix_last else towards)
        except RunError:
            return connection
        return later.connection_from_point(curve, replace(new_point, length=point.length))

    def connection_from_point(self, curve: Curve, point: CurvePoint) -> Connection:
        """Return the connection at a point of the curve with the equilibria's eigenvalues."""
        places = self._places(point.unknowns[-self._q :])
        values = [np.linalg.eigvals(self.rates.values(place)[1][:, : self.rates.n]) for place in places]
        ordered_values = np.array([spectrum[np.argsort(-spectrum.real)] for spectrum in values])
        n = self.rates.n
        return Connection(curve, point, self.time, np.array([p[:n] for p in places]), ordered_values, places[0][n:])

    def walk(self, start: Connection) -> Walk[Connection]:
        """Return an iterator over the connections of the curve from a first one on, including special ones."""
        return Walk(self._iterate(start))

    def backwards(self, connection: Connection) -> Connection:
        """Return the same connection of the curve followed the other way."""
        return replace(connection, point=connection.curve.backwards(connection.point))

    def _iterate(self, start: Connection) -> Generator[Connection, None, str]:
        here, steps, point_count, still, largest = start, self.steps, 0, 0, leading_rate(start)
        while True:
            connections, walk = replace(self, time=here.time), replace(here.curve, steps=steps).follow(here.point)
            for curve, point in walk:
                there, point_count = connections.connection_from_point(replace(curve, steps=self.steps), point), point_count + 1
                yield from connections._special(here, there)
                largest = max(largest, leading_rate(there))
                if reason := end_reason(self.folds, start, there, largest):
                    return reason
                yield there
                if point_count == self.steps.points:
                    return f"it has reached the largest number of points, {point_count}"
                step, scale = there.point.length - here.point.length, self.rates.scale[self.rates.n :]
                still = still + 1 if is_standstill(here, there, scale) else 0
                if still == LONG:
                    return standstill_sentence(self.rates.parameter_names, there)
                here, longer = there, self.prolong(there)
                if longer is not there:  # another problem: continue from there, with the same length of steps
                    here, steps = longer, replace(self.steps, first=max(step, self.steps.least))
                    break
            else:
                return walk.end

    def _special(self, here: Connection, there: Connection) -> list[Connection]:
        """Return the special points between two neighbours, in order; unresolved where one is not located."""
        if len(self.folds) == 2 or self.folds[0] or self.rates.n < 2:
            return []
        special_points, between = list[Connection](), None
        for kind, test in TESTS.items():
            if not test(here) * test(there) < 0:  # also where one is nan
                continue
            try:
                between = between or refine_on_common_mesh((here.curve, here.point), (there.curve, there.point), _LOCATING)
            except RunError:
                return [replace(there, kind=UNRESOLVED_POINT)]
            curve = between[0]
            at = locate_zero(*between, lambda point, curve=curve: self.connection_from_point(curve, point), test)  # type: ignore[misc]
            if at is None:
                special_points.append(replace(there, kind=UNRESOLVED_POINT))
            else:
                special_points.append(replace(at, kind=kind, curve=replace(at.curve, steps=self.steps)))
        return sorted(special_points, key=lambda c: c.point.length)

    def _curve(self, mesh: Mesh) -> Curve:
        m = len(self.bounds)
        return Curve(self._problem(mesh), {k - m: pair for k, pair in enumerate(self.bounds)}, self.steps)

    @property
    def _q(self) -> int:
        return len(self.folds) * self.rates.n + len(self.bounds)

    def _places(self, parameters: np.ndarray) -> list[np.ndarray]:
        """Return each equilibrium with the varied parameters (n + m,)."""
        x, p = np.split(parameters, [len(self.folds) * self.rates.n])
        return [np.concatenate([equilibrium, p]) for equilibrium in x.reshape(len(self.folds), -1)]

    def _problem(self, mesh: Mesh) -> BoundaryValueProblem:
        n, q = self.rates.n, self._q
        advance = 2 * math.pi * self.winding
        weights = 1 / self.rates.scale[:n, None] ** 2
        sizes = np.concatenate([self.rates.scale[:n], np.tile(self.rates.scale[:n], len(self.folds)), self.rates.scale[n:]])

        def field(unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            rows = [*range(n), *range(len(unknowns) - len(self.bounds), len(unknowns))]
            f, derivatives = self.rates.values(unknowns[rows])
            by_unknowns = np.zeros((n, len(unknowns), unknowns.shape[1]))
            by_unknowns[:, rows] = self.time * derivatives
            return self.time * f, by_unknowns

        def ends(first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> EndValues:
            at_first, at_last = (self._directions(self._places(parameters)[k]) for k in (0, -1))
            by = at_first.by_right, at_last.by_left
            conditions = self._conditions(first, last - advance, parameters, by)
            by_parameters = np.empty((len(conditions), q))
            for k, size in enumerate(sizes[n:]):
                h = np.zeros(q)
                h[k] = _STEP * size
                up, down = (self._conditions(first, last - advance, parameters + s * h, by) for s in (1.0, -1.0))
                by_parameters[:, k] = (up - down) / (2 * h[k])
            begin, end = np.zeros((len(conditions), n)), np.zeros((len(conditions), n))
            begin[: n - 1], end[n - 1] = at_first.complement, at_last.leaving
            return conditions, begin, end, by_parameters

        def phase(y: np.ndarray, _: np.ndarray, reference: Reference) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            direction = reference.slope * weights
            return ((y - reference.y) * direction).sum(axis=0)[None], direction[None], np.zeros((1, q, y.shape[1]))

        nothing = Reference(np.zeros((n, 0)), np.zeros((n, 0)))
        return BoundaryValueProblem(field, n, q, ends, phase, mesh, nothing, sizes, None, self.accuracy)

    def _conditions(self, first: np.ndarray, last: np.ndarray, parameters: np.ndarray, by: tuple[int, int]) -> np.ndarray:
        """Return the conditions on the first and the last state, on the equilibria, and on saddle-nodes."""
        n, places = self.rates.n, self._places(parameters)
        values = [self.rates.values(place) for place in places]
        folds = [np.linalg.det(derivatives[:, :n]) for (_, derivatives), fold in zip(values, self.folds, strict=True) if fold]
        complement, leaving = self._directions(places[0], by).complement, self._directions(places[-1], by).leaving
        start_gaps, end_gap = complement @ (first - places[0][:n]), leaving @ (last - places[-1][:n])
        return np.concatenate([start_gaps, [end_gap], *(f for f, _ in values), folds])

    def _directions(self, place: np.ndarray, by: tuple[int, int] | None = None) -> Directions:
        n = self.rates.n
        return Directions.from_jacobian(self.rates.values(place)[1][:, :n], self.rates.scale[:n], by)
