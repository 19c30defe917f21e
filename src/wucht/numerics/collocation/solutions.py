"""Solutions of a boundary value problem over a parameter: from samples of one on, through folds, and at wanted values."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import RunError, WuchtError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.collocated import Collocated
from wucht.numerics.collocation.starting import refined, sampled, solved_near
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.special_curves import UNRESOLVED
from wucht.numerics.continuation.special_points import located

FOLD, VALUE = "fold", "value"

_LOCATING = 1e-9  # accuracy of the mesh on which special solutions are located
STEPS = Steps(most=0.5, turn=0.3, corrections=4, tolerance=1e-7, foretold=True)


@dataclass(frozen=True, eq=False)
class Solution(Collocated):
    """A solution.

    curve, point: as it is followed. kind: ``""``, ``"fold"``, ``"value"``: the last parameter has a wanted one, or
    ``"unresolved"``: one of these was not located between the solution before and this one.
    """

    kind: str = ""

    @property
    def parameters(self) -> np.ndarray:
        """Their values (q,)."""
        return self.problem.split(self.point.u)[1]

    @property
    def error(self) -> float:
        """By how much it is about wrong between mesh points, in units of its sizes."""
        return float(self.problem.error(self.point.u).max())


@dataclass(frozen=True, eq=False)
class Solutions:
    """Solutions of a boundary value problem, followed over its parameters.

    problem: on any mesh. bounds: (low, high) of each parameter. values: of the last parameter, at which solutions are wanted.
    """

    problem: BoundaryValueProblem
    bounds: Sequence[tuple[float, float]]
    values: Sequence[float] = ()
    steps: Steps = STEPS

    def start(
        self, tau: Sequence[float] | np.ndarray, states: Sequence[Sequence[float]] | np.ndarray, parameters: Sequence[float]
    ) -> Solution:
        """The solution near samples of one, the last parameter kept.

        Parameters
        ----------
        tau : sequence of float, (K,)
            Places, increasing, the first being 0, the last 1.
        states : array, (n, K)
            There.
        parameters : sequence of float, (q,)
            Near those of the solution; the last one is kept.

        Raises
        ------
        WuchtError
            For samples of another form, another number of parameters or bounds.
        RunError
            Where Newton's method finds no solution near them.
        """
        problem, q = self.problem, self.problem.q
        at, given = np.asarray(tau, float), np.asarray(states, float)
        if given.shape != (problem.n, len(at)) or len(at) < 2 or len(parameters) != q or len(self.bounds) != q:
            form = f"{problem.n} states at two places or more, and {q} parameters with bounds"
            raise WuchtError(
                f"a solution is found near samples of {form}; given: {given.shape} at {len(at)}, {len(parameters)}",
                code="shape",
            )
        if not (
            np.isfinite(at).all() and np.isfinite(given).all() and np.isfinite(parameters).all() and (np.diff(at) > 0).all()
        ):
            raise WuchtError("samples of a solution and its parameters are finite numbers, and their places increase")
        mesh, y = sampled(at, given, problem.sizes[: problem.n], problem.mesh.degree)
        curve = Curve(replace(problem, mesh=mesh), {k - q: each for k, each in enumerate(self.bounds)}, self.steps)
        return Solution(*solved_near(curve, np.concatenate([y.ravel(), parameters])))

    def walk(self, start: Solution) -> Walk[Solution]:
        """The solutions after a first one, special ones among them, as they are asked for."""
        return Walk(self._walked(start))

    def backwards(self, solution: Solution) -> Solution:
        """The same solution, the curve being followed the other way."""
        return replace(solution, point=solution.curve.backwards(solution.point))

    def _walked(self, start: Solution) -> Generator[Solution, None, str]:
        here, walk = start, replace(start.curve, steps=self.steps).follow(start.point)
        for curve, point in walk:
            there = Solution(curve, point)
            yield from self._special(here, there)
            yield there
            here = there
        return walk.end

    def _special(self, here: Solution, there: Solution) -> list[Solution]:
        """The special solutions between two neighbours, in order."""
        tests: Mapping[tuple[str, float], Callable[[Solution], float]] = {
            (FOLD, 0.0): lambda s: float(s.point.tangent[-1]),
            **{(VALUE, value): lambda s, value=value: float(s.point.u[-1]) - value for value in self.values},  # type: ignore[misc]
        }
        passed = [(kind, test) for (kind, _), test in tests.items() if test(here) * test(there) < 0]
        if not passed:
            return []
        try:
            fine, first, last = refined((here.curve, here.point), (there.curve, there.point), _LOCATING)
        except RunError:
            return [replace(there, kind=UNRESOLVED)]
        found = list[Solution]()
        for kind, test in passed:
            at = located(fine, first, last, lambda point: Solution(fine, point), test)
            found.append(replace(there, kind=UNRESOLVED) if at is None else replace(at, kind=kind))
        return sorted(found, key=lambda s: s.point.length)
