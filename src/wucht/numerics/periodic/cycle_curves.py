"""Curves in two parameters on which a periodic orbit has a fold, doubles its period, begets a torus, or breaks its symmetry.

The orbit and a change v of it that satisfies the linearised equations are one boundary value problem, with g = T f(y):
fold: v' = g_y v + c f, v(1) = v(0), int v.y_ref' = 0, int v.v + (c/T)^2 = 1; period doubling: v' = g_y v, v(1) = -v(0),
int v.v = 1; torus: the same for v = a + i b with v(1) = exp(i theta) v(0); symmetry breaking: as the fold, and y' = g + d v,
int (y - y_ref).v_ref = 0, where d stays 0.
E. J. Doedel, W. Govaerts, Yu. A. Kuznetsov, SIAM J. Numer. Anal. 41 (2003) 401-435.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.earlier_names import with_earlier_names
from wucht.errors import WuchtError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem, EndFunction, EndValues, Integrand, Reference
from wucht.numerics.collocation.solutions import with_exact_tolerance
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.flow.jacobian import variational_system
from wucht.numerics.periodic.cycle import BRANCH_POINT, DOUBLING, FOLD, TORUS, VANISHING_SIZE, Cycle, Orbit, swing
from wucht.numerics.periodic.cycle_starts import cycle_at, propagated_change
from wucht.numerics.periodic.cycles import STEPS, Cycles
from wucht.numerics.periodic.periods import PERIOD, refuse_empty, turns_of, with_period_unit
from wucht.system import System

_EXTRA, _BREAKING = sp.Symbol("_extra", real=True), sp.Symbol("_breaking", real=True)
_COLUMNS = {FOLD: 1, DOUBLING: 1, TORUS: 2, BRANCH_POINT: 1}  # changes v in the extended system
_EXTRAS = {FOLD: 1, DOUBLING: 0, TORUS: 1, BRANCH_POINT: 2}  # further parameters
_SHRINKS = {
    FOLD: "it shrinks to an equilibrium: a generalised Hopf point",
    DOUBLING: "it shrinks to an equilibrium",
    TORUS: "it shrinks to an equilibrium: a double Hopf or a zero-Hopf point",
    BRANCH_POINT: "it shrinks to an equilibrium",
}
_SYMMETRIC = 1e-3  # largest d of an orbit with the symmetry: d v is added to its rates, v of the size of states


@with_earlier_names
@dataclass(frozen=True, eq=False)
class CurveCycle(Orbit):
    """Special periodic orbit on a curve in two parameters.

    Attributes
    ----------
    curve : Curve
        With the collocation problem of the orbit and its changes, on the orbit's mesh.
    point : CurvePoint
        All unknowns.
    n : int
        Number of the problem's states that are the orbit's, the others being its changes.
    """

    n: int

    @property
    def parameter_values(self) -> tuple[float, float]:
        """Values of both parameters."""
        first, second = self.point.unknowns[-2:].tolist()
        return first, second

    @property
    def states(self) -> np.ndarray:
        """States of the orbit at the nodes (n, K)."""
        return super().states[: self.n]

    @property
    def extra(self) -> list[float]:
        """Extra unknowns: theta of a torus, c of a fold, c and d of a symmetry breaking."""
        return [float(e) for e in self.problem.split(self.point.unknowns)[1][1:-2]]


@dataclass(frozen=True, eq=False)
class CycleCurve:
    """Curves of special periodic orbits in two parameters. ``CycleCurve.of`` sets them up.

    Attributes
    ----------
    kind : str
        ``"fold"``, ``"period-doubling"``, ``"torus"`` or ``"branch-point"``: that of all its orbits.
    equations : EquilibriumEquations
        Of the orbit y and its change v; varied are T, c or theta where there is one, and both parameters.
    n : int
        Number of states of y.
    winding : ndarray, (n,)
        Turns of each angle in a period, 0 of other states.
    bounds : tuple of two (float, float)
        Lower and upper limit of both parameters.
    periods : (float, float)
        Limits of T.
    steps : Steps
    accuracy : float
        Required between mesh points, in units of scale.
    system : System
        Of y alone.
    fixed_values : mapping
        Values of its parameters that do not vary.
    """

    kind: str
    equations: EquilibriumEquations
    n: int
    winding: np.ndarray
    bounds: tuple[tuple[float, float], tuple[float, float]]
    periods: tuple[float, float]
    steps: Steps
    accuracy: float
    system: System
    fixed_values: Mapping[str, float]

    @classmethod
    def of(
        cls,
        kind: str,
        system: System,
        parameter_names: tuple[str, str],
        fixed_values: Mapping[str, float],
        bounds: tuple[tuple[float, float], tuple[float, float]],
        *,
        winding: Mapping[str, int] | None = None,
        scale: Mapping[str, float] | None = None,
        periods: tuple[float, float] = (0.0, math.inf),
        steps: Steps | None = None,
        accuracy: float = 1e-7,
    ) -> CycleCurve:
        """Set up the curves of one kind of an autonomous System.

        Parameters
        ----------
        kind : {"fold", "period-doubling", "torus", "branch-point"}
            As of a ``Cycle``.
        system : System
        parameter_names : (str, str)
            Names of both varied ones.
        fixed_values : mapping
            Values of all others.
        bounds : tuple of two (float, float)
            Of both parameters.
        winding, scale, periods, steps, accuracy
            As of ``Cycles.of``.

        Returns
        -------
        CycleCurve

        Raises
        ------
        WuchtError
            For another kind, one parameter given twice, and as ``Cycles.of``.
        """
        if kind not in _COLUMNS:
            raise WuchtError(f"{kind}: curves of orbits are of the kinds {', '.join(_COLUMNS)}", code="unknown-kind")
        if parameter_names[0] == parameter_names[1]:
            raise WuchtError(f"a curve of orbits needs two parameters, not {parameter_names[0]} twice", code="given-twice")
        for name, both_bounds in zip((*parameter_names, "the period"), (*bounds, periods), strict=True):
            refuse_empty(name, both_bounds)
        with_variation, n = variational_system(with_period_unit(system), _COLUMNS[kind]), len(system.states)
        rates, changes = with_variation.derivatives[:n], with_variation.derivatives[n:]
        if kind in (FOLD, BRANCH_POINT):
            changes = tuple(change + _EXTRA * rate / PERIOD for change, rate in zip(changes, rates, strict=True))
        if kind == BRANCH_POINT:
            rates = tuple(rate + _BREAKING * v for rate, v in zip(rates, with_variation.states[n:], strict=True))
        extra = (_EXTRA, _BREAKING)[: _EXTRAS[kind]]
        whole = replace(with_variation, derivatives=(*rates, *changes), parameters=(*extra, *with_variation.parameters))
        varied_names = (PERIOD.name, *(s.name for s in extra), *parameter_names)
        sizes = dict(scale or {})
        sizes |= {name: 1.0 for name in (PERIOD.name, *varied_names) if name not in sizes}
        equations = EquilibriumEquations.from_system(whole, varied_names, fixed_values, sizes)
        turns = turns_of(system, winding)
        return cls(kind, equations, n, turns, bounds, periods, steps or STEPS, accuracy, system, dict(fixed_values))

    def start(self, at: Cycle, second: float) -> CurveCycle:
        """Compute the point of the curve at an orbit of this kind, located on a branch in the first parameter.

        second: value of the other parameter there. Raises ``RunError`` where Newton's method does not converge.
        """
        y, (period, first) = at.problem.split(at.point.unknowns)
        changes, extra = _changes(at, self.kind)
        sizes = self.equations.scale.copy()
        whole, q = len(self.equations.state_names), len(self.equations.parameter_names)
        sizes[self.n : whole] = np.tile(sizes[: self.n], whole // self.n - 1)
        sizes[whole] = period
        sizes[whole + 1 : q + whole - 2] = period if self.kind in (FOLD, BRANCH_POINT) else 1.0  # c, d are rates per period
        squares = at.problem.mesh.shares @ ((changes / sizes[self.n : whole]) ** 2).sum(axis=1)
        if self.kind in (FOLD, BRANCH_POINT):
            squares += (extra[0] / period) ** 2
            extra[0] /= math.sqrt(squares)
        changes = changes / math.sqrt(squares)
        unknowns = np.concatenate([np.concatenate([y, changes], axis=1).ravel(), [period, *extra, first, second]])
        ends, integrand = _conditions(self.kind, self.n, 2 * math.pi * self.winding, sizes)
        nothing = Reference(np.zeros((whole, 0)), np.zeros((whole, 0)))
        winding = np.concatenate([2 * math.pi * self.winding, np.zeros(whole - self.n)])
        problem = BoundaryValueProblem(
            self.equations.values, whole, q, ends, integrand, at.problem.mesh, nothing, sizes, winding, self.accuracy
        )
        problem = replace(problem, reference=problem.reference_from(unknowns))
        curve = Curve(problem, {-2: self.bounds[0], -1: self.bounds[1], -q: self.periods}, self.steps)
        towards = np.zeros(len(unknowns))
        towards[-1] = sizes[-1]
        return CurveCycle(curve, with_exact_tolerance(curve).start(unknowns, towards), self.n)

    def walk(self, start: CurveCycle) -> Walk[CurveCycle]:
        """Return an iterator over the orbits of the curve from a first one on."""
        return Walk(self._iterate(start))

    def backwards(self, cycle: CurveCycle) -> CurveCycle:
        """Return the same orbit of the curve followed the other way."""
        return replace(cycle, point=cycle.curve.backwards(cycle.point))

    def branch_through(self, at: CurveCycle, parameter: str | None = None) -> tuple[Cycles, Cycle]:
        """Compute the branch in one of both parameters that passes through an orbit of the curve, and that orbit on it.

        Parameters
        ----------
        at : CurveCycle
            Of this curve. At a branch point the branch is one of the two that cross there.
        parameter : str, optional
            The one that varies along the branch, by default the first; the other one keeps its value at the orbit.

        Returns
        -------
        cycles : Cycles
            Within this curve's bounds, with its steps and its accuracy.
        first : Cycle
            For ``cycles.walk``, and the other way ``cycles.backwards``.

        Raises
        ------
        WuchtError
            For a name that is none of both parameters.
        RunError
            Where Newton's method does not converge.
        """
        names = self.equations.parameter_names[-2:]
        if parameter not in (None, *names):
            raise WuchtError(f"{parameter} is none of the parameters of this curve: {', '.join(names)}", code="no-parameter")
        k = 0 if parameter is None else names.index(parameter)
        fixed_values = {**self.fixed_values, names[1 - k]: at.parameter_values[1 - k]}
        sizes = dict(zip(self.equations.state_names[: self.n], self.equations.scale.tolist(), strict=False))
        cycles = Cycles.of(
            self.system, names[k], fixed_values, self.bounds[k],
            winding={name: int(turns) for name, turns in zip(sizes, self.winding, strict=True) if turns},
            scale={**sizes, names[k]: float(self.equations.scale[k - 2])}, periods=self.periods, steps=self.steps,
            accuracy=self.accuracy, degree=at.problem.mesh.degree,
        )  # fmt: skip
        return cycles, cycle_at(cycles, at, at.parameter_values[k])

    def _iterate(self, start: CurveCycle) -> Generator[CurveCycle, None, str]:
        here, walk = start, start.curve.follow(start.point)
        for curve, point in walk:
            there = CurveCycle(curve, point, self.n)
            if swing(here, there) < VANISHING_SIZE:
                return _SHRINKS[self.kind]
            if self.kind == BRANCH_POINT and abs(there.extra[1]) > _SYMMETRIC:
                return "the orbit loses the symmetry that was broken"
            yield there
            here = there
        return walk.end


def _changes(at: Cycle, kind: str) -> tuple[np.ndarray, list[float]]:
    """Return v at the nodes (K, n or 2 n) of an orbit of a kind, and the extra unknowns."""
    if kind == FOLD:
        change, (longer, _) = at.problem.split(at.point.tangent)
        return change, [float(longer)]
    if kind == DOUBLING:
        return propagated_change(at, -1.0).real, []
    if kind == BRANCH_POINT:
        change, (longer, _) = at.problem.split(at.crossing_direction)
        return change, [float(longer), 0.0]
    values = at.logarithms[at.logarithms.imag > 0]
    angle = float(values[np.abs(values.real).argmin()].imag)
    wave = propagated_change(at, np.exp(1j * angle))
    return np.concatenate([wave.real, wave.imag], axis=1), [angle]


def _conditions(kind: str, n: int, advance: np.ndarray, sizes: np.ndarray) -> tuple[EndFunction, Integrand]:
    """Return the conditions at the ends and on integrals of a kind. sizes: of y, v and the parameters."""
    columns = _COLUMNS[kind]
    whole, q = n * (1 + columns), 3 + _EXTRAS[kind]
    one = np.eye(whole)
    signs = np.ones(whole)
    signs[n:] = -1.0 if kind == DOUBLING else 1.0
    gains = np.concatenate([advance, np.zeros(whole - n)])
    weights = 1 / sizes[:whole, None] ** 2

    def ends(first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> EndValues:
        begin, by_parameters = -np.diag(signs), np.zeros((whole, q))
        if kind == TORUS:
            cosine, sine = math.cos(parameters[1]), math.sin(parameters[1])
            turn = np.kron(np.array([[cosine, -sine], [sine, cosine]]), np.eye(n))
            begin[n:, n:] = -turn
            by_parameters[n:, 1] = np.kron(np.array([[sine, cosine], [-cosine, sine]]), np.eye(n)) @ first[n:]
        return last + begin @ first - gains, begin, one, by_parameters

    def integrand(y: np.ndarray, parameters: np.ndarray, reference: Reference) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        along, zeros = np.zeros_like(y), np.zeros((n, y.shape[1]))
        along[:n] = (reference.slope * weights)[:n]
        v = y * weights
        v[:n] = 0.0
        square = (y * v).sum(axis=0) - 1
        by_parameters = np.zeros((q - 1, q, y.shape[1]))
        rows = [((y - reference.y) * along).sum(axis=0), square]
        by_states = [along, 2 * v]
        if kind in (FOLD, BRANCH_POINT):
            rows[1] = square + (parameters[1] / sizes[whole + 1]) ** 2
            by_parameters[1, 1] = 2 * parameters[1] / sizes[whole + 1] ** 2
            across = np.concatenate([zeros, along[:n]])
            rows.append((y * across).sum(axis=0))
            by_states.append(across)
        if kind == TORUS:
            a, b = (reference.y * weights)[n : 2 * n], (reference.y * weights)[2 * n :]
            across = np.concatenate([zeros, b, -a])
            rows.append((y * across).sum(axis=0))
            by_states.append(across)
        if kind == BRANCH_POINT:
            across = np.concatenate([(reference.y * weights)[n:], zeros])
            rows.append(((y - reference.y) * across).sum(axis=0))
            by_states.append(across)
        return np.array(rows), np.array(by_states), by_parameters

    return ends, integrand
