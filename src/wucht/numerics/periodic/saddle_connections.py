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
from wucht.numerics.collocation.starting import sampled, solved_near
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.problem import CurvePoint
from wucht.numerics.periodic.periods import PERIOD, in_periods
from wucht.system import System

SADDLE_NODE = "the saddle becomes a saddle-node"

_STEP = 6e-6  # of central differences, in units of scale: the cube root of rounding
_DEGREE = 6
_HELD = sp.Symbol("_held", real=True)
_STEPS = Steps(most=0.5, turn=0.3, corrections=4, tolerance=1e-7, foretold=True)


@dataclass(frozen=True, eq=False)
class Connection:
    """An orbit between equilibria.

    curve, point: as they are followed. time: that it is followed. equilibria (e, n): where it begins and ends, one where that
    is the same. eigenvalues (e, n): there, the largest real part first. parameters: their values, in the order in which they
    are varied.
    """

    curve: Curve
    point: CurvePoint
    time: float
    equilibria: np.ndarray
    eigenvalues: np.ndarray
    parameters: np.ndarray

    @property
    def _problem(self) -> BoundaryValueProblem:
        assert isinstance(self.curve.problem, BoundaryValueProblem)
        return self.curve.problem

    @property
    def tau(self) -> np.ndarray:
        """Of the nodes, in shares of the time (K,)."""
        return self._problem.mesh.nodes

    @property
    def states(self) -> np.ndarray:
        """At the nodes (n, K)."""
        return self._problem.split(self.point.u)[0].T

    def at(self, tau: np.ndarray) -> np.ndarray:
        """The states (n, K) at shares (K,) of the time."""
        return self._problem.mesh.at(self.states.T, np.asarray(tau, float)).T

    @property
    def saddle_quantity(self) -> float:
        """The sum of the leaving and of the slowest reaching eigenvalue: nearby orbits are stable where it is < 0."""
        return float((self.eigenvalues[0, 0] + self.eigenvalues[-1, 1]).real)


@dataclass(frozen=True, eq=False)
class Connections:
    """Connections of equilibria each of which is left in one direction.

    rates: f(x, p), by x and the varied parameters. field: T f, by y, the equilibria and the parameters. time: T. winding (n,).
    bounds: of the parameters. folds: which of the equilibria, one or two, are saddle-nodes.
    """

    rates: Equations
    field: Equations
    time: float
    winding: np.ndarray
    bounds: tuple[tuple[float, float], ...]
    folds: tuple[bool, ...]
    steps: Steps
    accuracy: float

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
    ) -> Connections:
        """Of a System whose equations do not depend on time.

        Parameters
        ----------
        system : System
        parameters : sequence of str
            Two, and one more for each saddle-node; one less where a single connection is looked for, not a curve of them.
        fixed : mapping
            Values of all others.
        bounds : sequence of (float, float)
            Of the parameters.
        time : float
            That the orbit is followed, so long that at its ends it is near the equilibria.
        folds : sequence of bool
            Whether the equilibrium is a saddle-node; two where the orbit leads to another one, else it returns but for
            ``winding`` turns of angles.
        winding, scale, steps, accuracy
            As of ``Cycles.of``.

        Raises
        ------
        WuchtError
            For another number of parameters, and as ``Equations.of``.
        """
        count, wanted = len(folds), 2 + sum(folds)
        if count not in (1, 2) or not len(parameters) == len(bounds) or len(parameters) not in (wanted, wanted - 1):
            raise WuchtError("a curve of connections has two parameters with bounds, and one more for each saddle-node")
        if len(parameters) < wanted:  # one on which nothing depends is kept: what is left is a point
            system = replace(system, parameters=(*system.parameters, _HELD))
            parameters, bounds = (*parameters, _HELD.name), (*bounds, (-math.inf, math.inf))
        bare = System(system.states, system.derivatives, system.parameters, system.definitions, angles=system.angles)
        rates, timed = Equations.of(bare, tuple(parameters), fixed, scale), in_periods(bare)
        places = [sp.Symbol(f"_equilibrium{k}[{s.name}]", real=True) for k in range(count) for s in system.states]
        sizes = dict(scale or {}) | {p.name: s for p, s in zip(places, np.tile(rates.scale[: rates.n], count), strict=True)}
        whole = replace(timed, parameters=(*timed.parameters, *places))
        names = (*(p.name for p in places), *parameters)
        equations = Equations.of(whole, names, {**fixed, PERIOD.name: time}, sizes)
        turns = np.array([(winding or {}).get(name, 0) for name in system.state_names])
        return cls(rates, equations, time, turns, tuple(bounds), tuple(folds), steps or _STEPS, accuracy)

    def start(self, times: np.ndarray, states: np.ndarray, equilibria: np.ndarray, values: Sequence[float]) -> Connection:
        """The connection near an orbit, the last parameter kept. Raises ``RunError`` where none is found.

        times (K,), states (n, K): samples that begin and end near the equilibria (e, n). values: of the parameters.
        """
        mesh, y = sampled(times, states, self.rates.scale[: self.rates.n], _DEGREE)
        m = len(self.bounds)
        values = [*values, *[0.0] * (m - len(values))]
        bounds = {k - m: each for k, each in enumerate(self.bounds)}
        u = np.concatenate([y.ravel(), np.ravel(equilibria), values])
        return self.seen(*solved_near(Curve(self._problem(mesh), bounds, self.steps), u))

    def seen(self, curve: Curve, point: CurvePoint) -> Connection:
        """A point of the curve with the equilibria's eigenvalues."""
        places = self._places(point.u[-self._q :])
        values = [np.linalg.eigvals(self.rates.values(place)[1][:, : self.rates.n]) for place in places]
        ordered = np.array([each[np.argsort(-each.real)] for each in values])
        n = self.rates.n
        return Connection(curve, point, self.time, np.array([p[:n] for p in places]), ordered, places[0][n:])

    def walk(self, start: Connection) -> Walk[Connection]:
        """The connections of the curve from a first one on, as they are asked for."""
        return Walk(self._walked(start))

    def backwards(self, connection: Connection) -> Connection:
        """The same connection of the curve followed the other way."""
        return replace(connection, point=connection.curve.backwards(connection.point))

    def _walked(self, start: Connection) -> Generator[Connection, None, str]:
        walk = start.curve.follow(start.point)
        for curve, point in walk:
            there = self.seen(curve, point)
            if any(not e[0].real > 0 for e, fold in zip(there.eigenvalues, self.folds, strict=True) if not fold):
                return SADDLE_NODE
            yield there
        return walk.end

    @property
    def _q(self) -> int:
        return len(self.field.parameters)

    def _places(self, parameters: np.ndarray) -> list[np.ndarray]:
        """Each equilibrium with the varied parameters (n + m,)."""
        x, p = np.split(parameters, [len(self.folds) * self.rates.n])
        return [np.concatenate([each, p]) for each in x.reshape(len(self.folds), -1)]

    def _problem(self, mesh: Mesh) -> BoundaryValueProblem:
        n, q = self.rates.n, self._q
        advance = 2 * math.pi * self.winding
        weights = 1 / self.rates.scale[:n, None] ** 2
        sizes = np.concatenate([self.rates.scale[:n], self.field.scale[n:]])

        def ends(first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> EndValues:
            conditions = self._conditions(first, last - advance, parameters)
            by_parameters = np.empty((len(conditions), q))
            for k, size in enumerate(sizes[n:]):
                h = np.zeros(q)
                h[k] = _STEP * size
                up, down = (self._conditions(first, last - advance, parameters + s * h) for s in (1.0, -1.0))
                by_parameters[:, k] = (up - down) / (2 * h[k])
            places = self._places(parameters)
            begin, end = np.zeros((len(conditions), n)), np.zeros((len(conditions), n))
            begin[: n - 1], end[n - 1] = self._directions(places[0])[1], self._directions(places[-1])[0]
            return conditions, begin, end, by_parameters

        def phase(y: np.ndarray, _: np.ndarray, reference: Reference) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            direction = reference.slope * weights
            return ((y - reference.y) * direction).sum(axis=0)[None], direction[None], np.zeros((1, q, y.shape[1]))

        nothing = Reference(np.zeros((n, 0)), np.zeros((n, 0)))
        return BoundaryValueProblem(self.field.values, n, q, ends, phase, mesh, nothing, sizes, None, self.accuracy)

    def _conditions(self, first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """On the first and the last state, on the equilibria, and that they are saddle-nodes."""
        n, places = self.rates.n, self._places(parameters)
        values = [self.rates.values(place) for place in places]
        folds = [np.linalg.det(f_u[:, :n]) for (_, f_u), fold in zip(values, self.folds, strict=True) if fold]
        others, leaving = self._directions(places[0])[1], self._directions(places[-1])[0]
        left, reached = others @ (first - places[0][:n]), leaving @ (last - places[-1][:n])
        return np.concatenate([left, [reached], *(f for f, _ in values), folds])

    def _directions(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of an equilibrium: the left eigenvector of the leaving direction (n,), and a basis of the others' span (n-1, n)."""
        n, scale = self.rates.n, self.rates.scale[: self.rates.n]
        values, right = np.linalg.eig(self.rates.values(place)[1][:, :n] / scale[:, None] * scale)
        k = int(values.real.argmax())
        if values[k].imag != 0:
            raise RunError("the equilibrium is left in more than one direction")
        left = np.linalg.inv(right)[k].real
        left = left / left[np.abs(left).argmax()]
        # The other left eigenvectors span what is normal to the right one.
        leaving = right[:, k].real
        fixed = int(np.abs(leaving).argmax())
        others = np.delete(np.eye(n), fixed, axis=0)
        others[:, fixed] = -np.delete(leaving, fixed) / leaving[fixed]
        return left / scale, others / scale
