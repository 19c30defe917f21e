"""Solutions of a boundary value problem: from samples or from far away to a first one, then over a parameter.

Newton's method from far away is damped by the remaining correction as the last linearisation measures it. That measure does
not depend on the units of the equations, and accepts the whole step where the linearisation holds.
P. Deuflhard, "Newton Methods for Nonlinear Problems", Springer 2011, section 3.3 (natural monotonicity test); U. M. Ascher,
R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential Equations", SIAM
1995, section 8.1.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.earlier_names import with_earlier_names
from wucht.errors import RunError, WuchtError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint
from wucht.numerics.continuation.special_curves import UNRESOLVED_POINT
from wucht.numerics.continuation.special_points import locate_zero

_INTERVALS = 40
_ENOUGH_REFINEMENTS, _MOST_REFINEMENTS = 6, 12  # then an accurate solution is enough, on whichever mesh; then any
_FINE = 20_001
_EXACT = 1e-10  # Newton's tolerance, where points are located
_LEAST = 2.0**-8  # share of a step
_CORRECTION_ROUNDING = 1e-7  # corrections that small and no longer smaller are rounding
FOLD, VALUE = "fold", "value"
_LOCATING = 1e-9  # accuracy of the mesh on which special solutions are located
STEPS = Steps(most=0.5, turn=0.3, corrections=4, tolerance=1e-7, predicts_correction=True)


@with_earlier_names
@dataclass(frozen=True, eq=False)
class CollocationSolution:
    """A solution by collocation. curve: that on which it lies, with the problem on the solution's mesh. point: on the curve."""

    curve: Curve
    point: CurvePoint

    @property
    def problem(self) -> BoundaryValueProblem:
        """The boundary value problem on the solution's mesh."""
        assert isinstance(self.curve.problem, BoundaryValueProblem)
        return self.curve.problem

    @property
    def tau(self) -> np.ndarray:
        """Places of the states (K,), from 0 to 1: fractions of the period, or of the time."""
        return self.problem.mesh.nodes

    @property
    def states(self) -> np.ndarray:
        """States at these places (n, K)."""
        return self.problem.split(self.point.unknowns)[0].T

    def states_at(self, tau: np.ndarray) -> np.ndarray:
        """Interpolate the states (n, K) at places (K,) of [0, 1]."""
        return self.problem.mesh.interpolate(self.states.T, np.asarray(tau, float)).T


def mesh_from_samples(
    times: np.ndarray, states: np.ndarray, sizes: np.ndarray, degree: int, intervals: int = _INTERVALS
) -> tuple[Mesh, np.ndarray]:
    """Return a mesh that is finer where the states change faster, and their values at its nodes (K', n), by a cubic spline.

    times (K,), increasing, states (n, K), sizes (n,): a typical large change of each.
    """
    from scipy.interpolate import CubicSpline

    samples = CubicSpline((times - times[0]) / (times[-1] - times[0]), states.T)
    fine = np.linspace(0.0, 1.0, _FINE)
    speed = np.linalg.norm(np.diff(samples(fine), axis=0) / sizes, axis=1)
    # States that do not change at all need an even mesh.
    cumulative_density = np.insert(np.cumsum(speed + (0.5 * speed.mean() or 1.0)), 0, 0.0)
    mesh = Mesh(np.interp(np.linspace(0.0, cumulative_density[-1], intervals + 1), cumulative_density, fine), degree)
    return mesh, samples(mesh.nodes)


def solve_near(curve: Curve, unknowns: np.ndarray, towards: np.ndarray | None = None) -> tuple[Curve, CurvePoint]:
    """Solve for the solution near given unknowns; return also the curve on a mesh that suits it.

    curve: of a boundary value problem, on their mesh. towards: a direction of all unknowns; the solution lies in the plane
    across it, and the curve continues that way. By default it is the last parameter, which then keeps its value. Raises
    ``RunError`` where Newton's method does not converge.
    """
    if towards is None:
        towards = np.zeros(len(unknowns))
        towards[-1] = 1.0
    for refinement in range(_MOST_REFINEMENTS + 1):
        problem = curve.problem
        assert isinstance(problem, BoundaryValueProblem)
        curve = replace(curve, problem=replace(problem, reference=problem.reference_from(unknowns)))
        point = curve.start(unknowns, towards)
        better = problem.adapt_mesh(point.unknowns)
        is_enough = refinement >= _ENOUGH_REFINEMENTS and problem.is_accurate(point.unknowns)
        if better.mesh is problem.mesh or is_enough or refinement == _MOST_REFINEMENTS:
            break
        unknowns, towards = problem.to_mesh(np.stack([point.unknowns, towards], axis=1), better.mesh).T
        curve = replace(curve, problem=better)
    return curve, point


def tangent_near(problem: BoundaryValueProblem, unknowns: np.ndarray) -> np.ndarray:
    """Return the direction of the curve of solutions near given unknowns, with either sign. Raises ``RunError``."""
    sides = np.zeros((len(unknowns), 1))
    sides[-1] = 1.0
    row = (
        np.random.default_rng(0).normal(size=len(unknowns)) / problem.scale
    )  # not across the curve, as that of a fold would be
    return problem.solution(problem.residual(unknowns)[1], row, sides)[0][:, 0]


def with_exact_tolerance(curve: Curve) -> Curve:
    """Return the curve with Newton's method converging to rounding: for requested points, not those on the way."""
    return replace(curve, steps=replace(curve.steps, tolerance=min(_EXACT, curve.steps.tolerance), predicts_correction=False))


def refine_on_common_mesh(
    a: tuple[Curve, CurvePoint], b: tuple[Curve, CurvePoint], accuracy: float
) -> tuple[Curve, CurvePoint, CurvePoint]:
    """Recompute two neighbours of a curve on one mesh, so that points between them can be located.

    a, b: with the curves on whose meshes they are. accuracy: see ``BoundaryValueProblem``; Newton's method converges to
    rounding. Raises ``RunError`` where it fails.
    """
    curve, there = b
    problem = curve.problem
    assert isinstance(problem, BoundaryValueProblem)
    better = replace(problem, accuracy=min(accuracy, problem.accuracy)).adapt_mesh(there.unknowns)
    better = replace(better, reference=better.reference_from(problem.to_mesh(there.unknowns, better.mesh)))
    fine, points = with_exact_tolerance(replace(curve, problem=better)), list[CurvePoint]()
    for at, point in (a, b):
        coarse_problem = at.problem
        assert isinstance(coarse_problem, BoundaryValueProblem)
        unknowns, tangent = coarse_problem.to_mesh(np.stack([point.unknowns, point.tangent], axis=1), better.mesh).T
        points.append(fine.correct(unknowns, tangent, point.length)[0])
    return fine, points[0], points[1]


def solve_across_row(
    problem: BoundaryValueProblem, unknowns: np.ndarray, row: np.ndarray, positive: int, most_steps: int, tolerance: float
) -> tuple[np.ndarray, int]:
    """Solve for the solution near given unknowns in the plane through them across a row; return also the number of steps.

    Parameters
    ----------
    problem : BoundaryValueProblem
    unknowns, row : ndarray
        All unknowns; their changes are zero along the row.
    positive : int
        Index of an unknown that stays positive: a period.
    most_steps : int
    tolerance : float
        Of the remaining correction, by the problem's scale.

    Raises
    ------
    RunError
        Where Newton's method does not converge.
    """
    scale = problem.scale

    def correction(jacobian: object, off: np.ndarray) -> tuple[np.ndarray, float]:
        sides = np.append(off, 0.0)[:, None]
        change = problem.solution(jacobian, row, sides)[0][:, 0]  # type: ignore[arg-type]
        return change, float(np.linalg.norm(change / scale))

    off, jacobian = problem.residual(unknowns)
    change, size = correction(jacobian, off)
    share = 1.0
    for step in range(1, most_steps + 1):
        while True:
            at = unknowns - share * change
            if at[positive] > 0:
                off, after = problem.residual(at)
                next_change, next_size = correction(jacobian, off)
                if next_size <= max((1 - share / 2) * size, tolerance) or (
                    share == 1.0 and next_size < _CORRECTION_ROUNDING and next_size < 2 * size
                ):
                    break
            share /= 2
            if not share >= _LEAST:
                raise RunError("Newton's method does not converge", code="no-convergence")
        unknowns = at
        if share == 1.0 and (next_size <= tolerance or size / 2 < next_size < _CORRECTION_ROUNDING):
            return unknowns - next_change, step
        jacobian, (change, size) = after, correction(after, off)
        share = min(1.0, 2 * share)
    raise RunError(f"after {most_steps} steps of Newton's method a correction of {size:.2g} remains", code="too-many-steps")


@with_earlier_names
@dataclass(frozen=True, eq=False)
class Solution(CollocationSolution):
    """A solution on a curve of solutions.

    curve, point: see ``CollocationSolution``. kind: ``""``, ``"fold"``, ``"value"``: the last parameter has a requested one, or
    ``"unresolved"``: one of these was not located between the previous solution and this one.
    """

    kind: str = ""

    @property
    def parameter_values(self) -> np.ndarray:
        """Values of the parameters (q,)."""
        return self.problem.split(self.point.unknowns)[1]

    @property
    def error(self) -> float:
        """Estimated error between mesh points, in units of its sizes."""
        return float(self.problem.error(self.point.unknowns).max())


@dataclass(frozen=True, eq=False)
class Solutions:
    """Solutions of a boundary value problem, followed over its parameters.

    Parameters
    ----------
    problem : BoundaryValueProblem
        On any mesh.
    bounds : sequence of (float, float)
        Lower and upper limit of each parameter.
    values : sequence of float
        Values of the last parameter at which solutions are wanted.
    steps : Steps
    """

    problem: BoundaryValueProblem
    bounds: Sequence[tuple[float, float]]
    values: Sequence[float] = ()
    steps: Steps = STEPS

    def start(
        self, tau: Sequence[float] | np.ndarray, states: Sequence[Sequence[float]] | np.ndarray, parameters: Sequence[float]
    ) -> Solution:
        """Solve for the solution near samples of one, the last parameter keeping its value.

        Parameters
        ----------
        tau : sequence of float, (K,)
            Places, increasing, the first being 0, the last 1.
        states : array, (n, K)
            At these places.
        parameters : sequence of float, (q,)
            Near those of the solution; the last one keeps its value.

        Returns
        -------
        Solution

        Raises
        ------
        WuchtError
            For samples of another form, another number of parameters or bounds.
        RunError
            Where Newton's method finds no solution near them.
        """
        problem, q = self.problem, self.problem.q
        at, state_samples = np.asarray(tau, float), np.asarray(states, float)
        if state_samples.shape != (problem.n, len(at)) or len(at) < 2 or len(parameters) != q or len(self.bounds) != q:
            form = f"{problem.n} states at two places or more, and {q} parameters with bounds"
            raise WuchtError(
                f"a start needs samples of {form}; given: {state_samples.shape} at {len(at)}, {len(parameters)}",
                code="shape",
            )
        if not (
            np.isfinite(at).all()
            and np.isfinite(state_samples).all()
            and np.isfinite(parameters).all()
            and (np.diff(at) > 0).all()
        ):
            raise WuchtError("samples of a solution and its parameters must be finite, and their places must increase")
        mesh, y = mesh_from_samples(at, state_samples, problem.sizes[: problem.n], problem.mesh.degree)
        curve = Curve(replace(problem, mesh=mesh), {k - q: limits for k, limits in enumerate(self.bounds)}, self.steps)
        return Solution(*solve_near(curve, np.concatenate([y.ravel(), parameters])))

    def walk(self, start: Solution) -> Walk[Solution]:
        """Return the solutions after a first one, special ones included, computed one by one."""
        return Walk(self._generate_solutions(start))

    def backwards(self, solution: Solution) -> Solution:
        """Return the same solution with the curve followed the other way."""
        return replace(solution, point=solution.curve.backwards(solution.point))

    def _generate_solutions(self, start: Solution) -> Generator[Solution, None, str]:
        here, walk = start, replace(start.curve, steps=self.steps).follow(start.point)
        for curve, point in walk:
            there = Solution(curve, point)
            yield from self._special(here, there)
            yield there
            here = there
        return walk.end

    def _special(self, here: Solution, there: Solution) -> list[Solution]:
        """Locate the special solutions between two neighbours, in order."""
        tests: Mapping[tuple[str, float], Callable[[Solution], float]] = {
            (FOLD, 0.0): lambda s: float(s.point.tangent[-1]),
            **{(VALUE, value): lambda s, value=value: float(s.point.unknowns[-1]) - value for value in self.values},  # type: ignore[misc]
        }
        active_tests = [(kind, test) for (kind, _), test in tests.items() if test(here) * test(there) < 0]
        if not active_tests:
            return []
        try:
            fine, first, last = refine_on_common_mesh((here.curve, here.point), (there.curve, there.point), _LOCATING)
        except RunError:
            return [replace(there, kind=UNRESOLVED_POINT)]
        special_solutions = list[Solution]()
        for kind, test in active_tests:
            at = locate_zero(fine, first, last, lambda point: Solution(fine, point), test)
            special_solutions.append(replace(there, kind=UNRESOLVED_POINT) if at is None else replace(at, kind=kind))
        return sorted(special_solutions, key=lambda s: s.point.length)
