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
from wucht.numerics.collocation.solutions import refined, sampled, solved_near
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint, Equations
from wucht.numerics.continuation.special_curves import UNRESOLVED
from wucht.numerics.continuation.special_points import located
from wucht.numerics.periodic.connection import (
    LONG,
    TESTS,
    Connection,
    distances,
    ended,
    leading,
    lengthened,
    missing_times,
    standing,
    stands,
)
from wucht.system import System

_STEP = 6e-6  # of central differences, in units of scale: the cube root of rounding
_DEGREE = 6
_HELD = sp.Symbol("_held", real=True)
_STEPS = Steps(most=0.5, turn=0.3, corrections=4, tolerance=1e-7, foretold=True)
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
    others: np.ndarray
    by_right: int
    by_left: int

    @classmethod
    def of(cls, jacobian: np.ndarray, scale: np.ndarray, by: tuple[int, int] | None = None) -> Directions:
        """Return the directions of a Jacobian (n, n), scaled by sizes (n,).

        by: the states by which both eigenvectors are normalised, where they are compared with those at another place: with
        the largest component of each they would jump. Raises ``RunError`` where the leaving eigenvalue is complex.
        """
        matrix = jacobian / scale[:, None] * scale
        right, left = _leaving(matrix), _leaving(matrix.T)
        by_right, by_left = by or (int(np.abs(right).argmax()), int(np.abs(left).argmax()))
        others = np.delete(np.eye(len(scale)), by_right, axis=0)
        others[:, by_right] = -np.delete(right, by_right) / right[by_right]
        return cls(left / left[by_left] / scale, others / scale, by_right, by_left)


def _leaving(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvector (n,) of the largest eigenvalue, which is simple, so the vector is well defined."""
    values, vectors = np.linalg.eig(matrix)
    k = int(values.real.argmax())
    if values[k].imag != 0:
        raise RunError("the equilibrium is left in more than one direction")
    return np.asarray(vectors[:, k].real)


@dataclass(frozen=True, eq=False)
class Connections:
    """Connections of equilibria each of which is left in one direction.

    rates: f(x, p), by x and the varied parameters. time: T, at least. winding (n,). bounds: of the parameters. folds: True for
    those of the one or two equilibria that are saddle-nodes. longest: time up to which orbits of saddles are extended where
    their ends do not come near to them.
    """

    rates: Equations
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
        parameters: Sequence[str],
        fixed: Mapping[str, float],
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
        parameters : sequence of str
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

        Raises
        ------
        WuchtError
            For another number of parameters, and as ``Equations.of``.
        """
        count, wanted = len(folds), 2 + sum(folds)
        if count not in (1, 2) or not len(parameters) == len(bounds) or len(parameters) not in (wanted, wanted - 1):
            raise WuchtError(
                "a curve of connections has two parameters with bounds, and one more for each saddle-node", code="count"
            )
        if len(parameters) < wanted:  # with a fixed parameter on which nothing depends the curve becomes a point
            system = replace(system, parameters=(*system.parameters, _HELD))
            parameters, bounds = (*parameters, _HELD.name), (*bounds, (-math.inf, math.inf))
        bare = System(system.states, system.derivatives, system.parameters, system.definitions, angles=system.angles)
        rates = Equations.of(bare, tuple(parameters), fixed, scale)
        turns = np.array([(winding or {}).get(name, 0) for name in system.state_names])
        return cls(rates, time, turns, tuple(bounds), tuple(folds), steps or _STEPS, accuracy, longest)

    def start(self, times: np.ndarray, states: np.ndarray, equilibria: np.ndarray, values: Sequence[float]) -> Connection:
        """Compute the connection near an orbit, the last parameter fixed. Raises ``RunError`` where there is none.

        times (K,), states (n, K): samples that begin and end near the equilibria (e, n). values: of the parameters.
        """
        mesh, y = sampled(times, states, self.rates.scale[: self.rates.n], _DEGREE)
        m = len(self.bounds)
        values = [*values, *[0.0] * (m - len(values))]
        u = np.concatenate([y.ravel(), np.ravel(equilibria), values])
        found = self.seen(*solved_near(self._curve(mesh), u))
        for _ in range(_MOST_LONGER):
            before, found = found, self.longer(found, kept=True)
            if found is before:
                break
        return found

    def longer(self, connection: Connection, *, kept: bool = False) -> Connection:
        """Extend a connection to a longer time where its ends are too far from its saddles; else return it unchanged.

        fix_last: True to fix the last parameter, as in ``start``; else the point moves across its tangent.
        """
        scale, advance = self.rates.scale[: self.rates.n], 2 * math.pi * self.winding
        room = min(self.longest - connection.time, (_LONGER - 1) * connection.time)
        near = max(distances(connection, scale, advance)) <= _FAR
        enough = connection.problem.mesh.intervals > _MANY
        if any(self.folds) or enough or not room > 0 or (near and connection.time >= self.time):
            return connection
        more = missing_times(connection, scale, advance, self.time)
        if not more.sum() > 0:
            return connection
        matrix = self.rates.values(self._places(connection.point.u[-self._q :])[-1])[1][:, : self.rates.n]
        more = more * min(1.0, room / more.sum())
        mesh, y, changes = lengthened(connection, more, matrix, advance)
        later, q, point = replace(self, time=connection.time + float(more.sum())), self._q, connection.point
        u = np.concatenate([y.ravel(), point.u[-q:]])
        towards = np.concatenate([changes.ravel(), point.tangent[-q:]])
        try:
            curve, found = solved_near(later._curve(mesh), u, None if kept else towards)
        except RunError:
            return connection
        return later.seen(curve, replace(found, length=point.length))

    def seen(self, curve: Curve, point: CurvePoint) -> Connection:
        """Return the connection at a point of the curve with the equilibria's eigenvalues."""
        places = self._places(point.u[-self._q :])
        values = [np.linalg.eigvals(self.rates.values(place)[1][:, : self.rates.n]) for place in places]
        ordered = np.array([each[np.argsort(-each.real)] for each in values])
        n = self.rates.n
        return Connection(curve, point, self.time, np.array([p[:n] for p in places]), ordered, places[0][n:])

    def walk(self, start: Connection) -> Walk[Connection]:
        """Return an iterator over the connections of the curve from a first one on, including special ones."""
        return Walk(self._walked(start))

    def backwards(self, connection: Connection) -> Connection:
        """Return the same connection of the curve followed the other way."""
        return replace(connection, point=connection.curve.backwards(connection.point))

    def _walked(self, start: Connection) -> Generator[Connection, None, str]:
        here, steps, made, still, largest = start, self.steps, 0, 0, leading(start)
        while True:
            of, walk = replace(self, time=here.time), replace(here.curve, steps=steps).follow(here.point)
            for curve, point in walk:
                there, made = of.seen(replace(curve, steps=self.steps), point), made + 1
                yield from of._special(here, there)
                largest = max(largest, leading(there))
                if why := ended(self.folds, start, there, largest):
                    return why
                yield there
                if made == self.steps.points:
                    return f"it has reached the largest number of points, {made}"
                step, scale = there.point.length - here.point.length, self.rates.scale[self.rates.n :]
                still = still + 1 if stands(here, there, scale) else 0
                if still == LONG:
                    return standing(self.rates.parameters, there)
                here, longer = there, self.longer(there)
                if longer is not there:  # another problem: continue from there, with the same length of steps
                    here, steps = longer, replace(self.steps, first=max(step, self.steps.least))
                    break
            else:
                return walk.end

    def _special(self, here: Connection, there: Connection) -> list[Connection]:
        """Return the special points between two neighbours, in order; unresolved where one is not located."""
        if len(self.folds) == 2 or self.folds[0] or self.rates.n < 2:
            return []
        found, between = list[Connection](), None
        for kind, test in TESTS.items():
            if not test(here) * test(there) < 0:  # also where one is nan
                continue
            try:
                between = between or refined((here.curve, here.point), (there.curve, there.point), _LOCATING)
            except RunError:
                return [replace(there, kind=UNRESOLVED)]
            curve = between[0]
            at = located(*between, lambda point, curve=curve: self.seen(curve, point), test)  # type: ignore[misc]
            if at is None:
                found.append(replace(there, kind=UNRESOLVED))
            else:
                found.append(replace(at, kind=kind, curve=replace(at.curve, steps=self.steps)))
        return sorted(found, key=lambda c: c.point.length)

    def _curve(self, mesh: Mesh) -> Curve:
        m = len(self.bounds)
        return Curve(self._problem(mesh), {k - m: each for k, each in enumerate(self.bounds)}, self.steps)

    @property
    def _q(self) -> int:
        return len(self.folds) * self.rates.n + len(self.bounds)

    def _places(self, parameters: np.ndarray) -> list[np.ndarray]:
        """Return each equilibrium with the varied parameters (n + m,)."""
        x, p = np.split(parameters, [len(self.folds) * self.rates.n])
        return [np.concatenate([each, p]) for each in x.reshape(len(self.folds), -1)]

    def _problem(self, mesh: Mesh) -> BoundaryValueProblem:
        n, q = self.rates.n, self._q
        advance = 2 * math.pi * self.winding
        weights = 1 / self.rates.scale[:n, None] ** 2
        sizes = np.concatenate([self.rates.scale[:n], np.tile(self.rates.scale[:n], len(self.folds)), self.rates.scale[n:]])

        def field(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            kept = [*range(n), *range(len(u) - len(self.bounds), len(u))]
            f, f_u = self.rates.values(u[kept])
            by_u = np.zeros((n, len(u), u.shape[1]))
            by_u[:, kept] = self.time * f_u
            return self.time * f, by_u

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
            begin[: n - 1], end[n - 1] = at_first.others, at_last.leaving
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
        folds = [np.linalg.det(f_u[:, :n]) for (_, f_u), fold in zip(values, self.folds, strict=True) if fold]
        others, leaving = self._directions(places[0], by).others, self._directions(places[-1], by).leaving
        left, reached = others @ (first - places[0][:n]), leaving @ (last - places[-1][:n])
        return np.concatenate([left, [reached], *(f for f, _ in values), folds])

    def _directions(self, place: np.ndarray, by: tuple[int, int] | None = None) -> Directions:
        n = self.rates.n
        return Directions.of(self.rates.values(place)[1][:, :n], self.rates.scale[:n], by)
