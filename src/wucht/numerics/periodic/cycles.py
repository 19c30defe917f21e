"""Branches of periodic orbits in one parameter, with winding numbers for angles, and their special orbits.

The orbit is y(tau), tau = t/T from 0 to 1: y' = T f(y, p), y(1) = y(0) + 2 pi winding, and the phase is fixed by
int (y - y_ref) . y_ref' = 0. E. J. Doedel, "Lecture notes on numerical analysis of nonlinear equations", in: Numerical
Continuation Methods for Dynamical Systems, Springer 2007, section 1.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.errors import RunError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem as BoundaryValueProblem  # noqa: PLC0414 - re-exported
from wucht.numerics.collocation.boundary_values import EndValues, Reference
from wucht.numerics.collocation.boundary_values import end_value as end_value  # noqa: PLC0414 - re-exported
from wucht.numerics.collocation.boundary_values import start_value as start_value  # noqa: PLC0414 - re-exported
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import Solutions as Solutions  # noqa: PLC0414 - re-exported
from wucht.numerics.collocation.solutions import refine_on_common_mesh
from wucht.numerics.continuation.curve import CURVE_IS_CLOSED, Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations
from wucht.numerics.continuation.special_curves import UNRESOLVED_POINT
from wucht.numerics.continuation.special_points import locate_zero
from wucht.numerics.periodic.cycle import (
    BRANCH_POINT,
    FOLD,
    TESTS,
    TORUS,
    Cycle,
    HiddenPoint,
    has_pair_on_circle,
    is_orbit,
    swing,
)
from wucht.numerics.periodic.floquet import collocated_multipliers
from wucht.numerics.periodic.hopf_ends import SHRINKS, VANISHES, hopf_point
from wucht.numerics.periodic.orbit_branch_points import orbit_branch_point
from wucht.numerics.periodic.orbit_prediction import predicted_orbit
from wucht.numerics.periodic.periods import PERIOD, refuse_empty, turns_of, with_period_unit
from wucht.system import System as System  # noqa: PLC0414 - re-exported

_STEERING = 1e-10  # relative accuracy of the multipliers used to detect special points
_LOCATING = 1e-9  # accuracy of the mesh when they are located
_ROUNDING = 1e-9  # a smaller test function is not significant
_STILL = 1e-11  # of the parameter's share in the tangent, on a fine mesh: a smaller one is rounding
_STANDS = 1e-7  # of the parameter's share in the tangent, on any mesh: below it its sign alone is not significant
_FAR = 10.0  # of ln mu: a multiplier farther off at both neighbours does not cross the unit circle between them
_BESIDE = 0.05  # of a test function at one neighbour: largest value at the other that may be the special orbit itself
_NEARLY = 0.95  # of the way to a Hopf point, where the equations are singular
_ASIDE = (0.05, 0.1, 0.2, 0.4)  # of the way between two neighbours: distances from the estimated branch point
_LONGER = 4  # times the least period: from there on a branch may change in its period only
STEPS = Steps(most=0.5, turn=0.35, corrections=4, tolerance=1e-7, predicts_correction=True)


@dataclass(frozen=True, eq=False)
class Cycles:
    """Branches of periodic orbits of a System in one of its parameters. ``Cycles.of`` sets them up.

    Attributes
    ----------
    equations : EquilibriumEquations
        y' = T f(y, p); varied are the period T and the parameter.
    bounds : (float, float)
        Lower and upper limit of the parameter.
    periods : (float, float)
        Limits of T.
    winding : ndarray, (n,)
        Turns of each angle in a period, 0 of other states.
    steps : Steps
    accuracy : float
        Required between mesh points, in units of scale: see ``BoundaryValueProblem``.
    degree : int
        Degree of the polynomials of an interval.
    predicts_shifts : bool
        True to predict how the fast parts of an orbit move within its period, by ``predicted_orbit``: fewer corrections.
    """

    equations: EquilibriumEquations
    bounds: tuple[float, float]
    periods: tuple[float, float]
    winding: np.ndarray
    steps: Steps
    accuracy: float = 1e-7
    degree: int = 6
    predicts_shifts: bool = False

    @classmethod
    def of(
        cls,
        system: System,
        parameter: str,
        fixed_values: Mapping[str, float],
        bounds: tuple[float, float],
        *,
        winding: Mapping[str, int] | None = None,
        scale: Mapping[str, float] | None = None,
        periods: tuple[float, float] = (0.0, math.inf),
        steps: Steps | None = None,
        accuracy: float = 1e-7,
        degree: int = 6,
    ) -> Cycles:
        """Set up the orbits of an autonomous System.

        Parameters
        ----------
        system : System
        parameter : str
            Name of the varied one.
        fixed_values : mapping
            Values of all others.
        bounds : (float, float)
            Of the parameter.
        winding : mapping, optional
            Turns of angles in a period, by the states' names.
        scale : mapping, optional
            Typical changes of states and the parameter, by name; 1 where not given.
        periods : (float, float)
            Range of periods within which the branch is followed.
        steps : Steps, optional
        accuracy : float
            Required between mesh points, in units of scale.
        degree : int
            Degree of the polynomials of an interval.

        Returns
        -------
        Cycles

        Raises
        ------
        WuchtError
            As ``EquilibriumEquations.from_system``, for a winding of a state that is no angle, for bounds without a range
            between them, and for equations that depend on time: see ``with_forcing_phase``.
        """
        refuse_empty(parameter, bounds)
        refuse_empty("the period", periods)
        equations = EquilibriumEquations.from_system(with_period_unit(system), (PERIOD.name, parameter), fixed_values, scale)
        return cls(equations, bounds, periods, turns_of(system, winding), steps or STEPS, accuracy, degree)

    def problem(self, mesh: Mesh, period: float) -> BoundaryValueProblem:
        """Return the boundary value problem on a mesh, with a guess of the period as its scale."""
        e, n = self.equations, self.equations.n
        sizes = e.scale.copy()
        sizes[n] = period
        advance = 2 * math.pi * self.winding
        ends, phase = partial(_periodicity, advance), partial(_phase_condition, 1 / sizes[:n, None] ** 2, 2)
        nothing = Reference(np.zeros((n, 0)), np.zeros((n, 0)))
        return BoundaryValueProblem(e.values, n, 2, ends, phase, mesh, nothing, sizes, advance, self.accuracy)

    def curve(self, problem: BoundaryValueProblem) -> Curve:
        """Return the continuation problem, within the bounds of parameter and period."""
        predict = predicted_orbit if self.predicts_shifts else None
        return Curve(problem, {-1: self.bounds, -2: self.periods}, self.steps, is_orbit, predict=predict)

    def cycle_from_point(self, curve: Curve, point: CurvePoint, near: np.ndarray | None = None) -> Cycle:
        """Return the orbit at a point of the curve with its multipliers. near: the basis of a neighbour."""
        problem = curve.problem
        assert isinstance(problem, BoundaryValueProblem)
        if curve.steps.predicts_correction:  # the Jacobian is that at a point before
            point = replace(point, jacobian=problem.residual(point.unknowns)[1])
        return Cycle(curve, point, *collocated_multipliers(problem, point.unknowns, point.jacobian, near, _STEERING))

    def walk(self, start: Cycle) -> Walk[Cycle]:
        """Return an iterator over the orbits from a first one on, including special ones."""
        return Walk(self._iterate(start))

    def backwards(self, cycle: Cycle) -> Cycle:
        """Return the same orbit of the branch followed the other way."""
        return replace(cycle, point=cycle.curve.backwards(cycle.point))

    def _iterate(self, start: Cycle) -> Generator[Cycle, None, str]:
        here, least, walk = start, start.period, start.curve.follow(start.point)
        # Where a test function is lost in rounding, its sign is that of the last orbit where it was significant.
        last = {kind: (start, test(start)) for kind, test in TESTS.items()}
        for curve, point in walk:
            there = self.cycle_from_point(curve, point, here.basis)
            if (size := swing(here, there)) < 0:
                shrinking = [here]
                with suppress(RunError):
                    share = _NEARLY / (1 - size)
                    small = self.cycle_from_point(
                        curve, curve.point_between(here.point_on(there.problem.mesh), there.point, share), here.basis
                    )
                    shrinking.append(small)
                    yield small
                return SHRINKS if hopf_point(self.equations, shrinking) is not None else VANISHES
            sign_changes = dict[str, Cycle]()
            for kind, test in TESTS.items() if there.is_trusted else ():
                value, (before, value_before) = test(there), last[kind]
                if abs(value) > _ROUNDING:
                    if value * value_before < 0 and abs(value_before) > _ROUNDING and before.is_trusted:
                        sign_changes[kind] = before
                    last[kind] = there, value
            fold_before = sign_changes.get(FOLD)
            if fold_before and self._stands_still(fold_before, there) and fold_before.past_one * there.past_one > 0:
                sign_changes = {kind: before for kind, before in sign_changes.items() if kind not in (FOLD, BRANCH_POINT)}
            special = [c for kind, before in sign_changes.items() for c in self._special_between(curve, before, there, kind)]
            values = [c.parameter for c in (here, there, *special)]  # a fold may lie beyond both
            for c in sorted(special, key=lambda c: c.point.length):
                yield (
                    c
                    if c.hidden_point is None
                    else replace(c, hidden_point=HiddenPoint(c.hidden_point.kind, (min(values), max(values))))
                )
            yield there
            here, least = there, min(least, there.period)
        if walk.end != CURVE_IS_CLOSED and here.period > _LONGER * least and here.lengthens:
            grown = f"the period has grown from {least:.6g} to {here.period:.6g}"
            return f"{walk.end}; {grown}, while {self.equations.parameter_names[-1]} stays near {here.parameter:.6g}"
        return walk.end

    def _stands_still(self, *neighbours: Cycle) -> bool:
        """True if the parameter changes by errors only, whose sign would make a fold where no multiplier passes 1."""
        return all(abs(c.point.tangent[-1]) < _STANDS * self.equations.scale[-1] for c in neighbours)

    def _special_between(self, curve: Curve, here: Cycle, there: Cycle, kind: str) -> list[Cycle]:
        """Return the special orbit between two at which a test function changes its sign; none where it is not special."""
        before = here.point_on(there.problem.mesh)
        try:
            fine, first, last = refine_on_common_mesh((curve, before), (curve, there.point), _LOCATING)
        except RunError:  # near a connection of saddles, where the parameter stands still except for errors
            if kind == FOLD:
                return []
            fine, first, last = curve, before, there.point
        slopes = [p.tangent[-1] / self.equations.scale[-1] for p in (first, last)]
        make_cycle, test = partial(self.cycle_from_point, fine, near=here.basis), TESTS[kind]
        if kind in (FOLD, BRANCH_POINT) and np.abs(slopes).min() < _STILL:
            return []
        begin, end = (test(make_cycle(p)) for p in (first, last))
        if begin * end > 0 and min(abs(begin), abs(end)) > _BESIDE * max(abs(begin), abs(end)):
            return []  # no change of sign on the finer mesh
        if kind == BRANCH_POINT:
            special = self._branch_point(fine, first, last, abs(begin) / (abs(begin) + abs(end)), make_cycle)
        else:
            special = locate_zero(fine, first, last, make_cycle, test) if begin * end < 0 else None
        if special is None:
            if min(np.abs(c.logarithms.real).min() for c in (here, there)) > _FAR:
                return []  # no multiplier is near the unit circle: one that is huge has lost its sign
            return [replace(there, kind=UNRESOLVED_POINT, hidden_point=HiddenPoint(kind, (here.parameter, there.parameter)))]
        return [] if kind == TORUS and not has_pair_on_circle(special) else [replace(special, kind=kind)]

    def _branch_point(
        self, curve: Curve, a: CurvePoint, b: CurvePoint, root: float, make_cycle: Callable[[CurvePoint], Cycle]
    ) -> Cycle | None:
        """Locate the branch point between two neighbours, at about a share of the way; None where that fails."""
        for share in (root, *(root + s * d for d in _ASIDE for s in (1, -1))):
            if not 0 <= share <= 1:
                continue
            with suppress(RunError):
                near = curve.point_between(a, b, share)
                near = replace(near, jacobian=curve.problem.residual(near.unknowns)[1])
                unknowns, (along, across), part = orbit_branch_point(curve, near, a, b)
                length = a.length + part * (b.length - a.length)
                point = CurvePoint(unknowns, along, curve.problem.residual(unknowns)[1], length, 0)
                return replace(make_cycle(point), crossing_direction=across)
        return None


def _periodicity(advance: np.ndarray, first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> EndValues:
    plus = np.eye(len(advance))
    return last - first - advance, -plus, plus, np.zeros((len(advance), len(parameters)))


def _phase_condition(
    weights: np.ndarray, count: int, y: np.ndarray, _: np.ndarray, reference: Reference
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    direction = reference.slope * weights
    return ((y - reference.y) * direction).sum(axis=0)[None], direction[None], np.zeros((1, count, y.shape[1]))
