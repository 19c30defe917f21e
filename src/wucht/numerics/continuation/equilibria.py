"""Branches of equilibria in one parameter, with eigenvalues, folds, Hopf and branch points, and zeros of user functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from wucht.earlier_names import provide_earlier_names, with_earlier_names
from wucht.errors import RunError, WuchtError
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations, FunctionProblem, Problem
from wucht.numerics.continuation.special_curves import (
    UNRESOLVED_POINT,
    Condition,
    SpecialPointDetector,
    TracedCurve,
    bounds_of,
    require_parameter_count,
    state_of,
)
from wucht.numerics.continuation.special_points import (
    SUM_ROUNDING,
    BranchPoint,
    branch_point,
    branch_point_near,
    critical_pairs,
    eigenvalues_of,
    may_cross,
)

FOLD, HOPF, BRANCH_POINT = "fold", "hopf", "branch-point"

_FIRST = 0.05  # of the range: a first step at most
_NEAR = 1e-3  # of the first step: nearer to a point where the orientation changes, the branch continues whatever its kind
_AT = 1e-5  # arclength: a fold that near to a branch point is none
_ON_AXIS = 1e-8  # relative: the sign of a smaller real part is rounding
_HALVINGS = 8  # of a step, to locate eigenvalues that crossed and came back
_HERE = 1e-6  # of the parameter, in units of its scale: a start that near to a branch point is on it
_CROSSING = {FOLD: 1, BRANCH_POINT: 1, HOPF: 2}  # eigenvalues that pass the imaginary axis there
_NARROW = 0.25  # of the angle between both branches: the largest deviation of a point from the direction of its branch

UserFunction = Callable[[np.ndarray], float]


@with_earlier_names
@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Equilibrium on a branch.

    Attributes
    ----------
    unknowns : ndarray, (n+1,)
        States and the parameter; angles continued along the branch, not wrapped.
    point : CurvePoint
        The same with tangent and Jacobian.
    eigenvalues : ndarray of complex, (n,)
        Eigenvalues of df/dx, per unit of time.
    kind : str
        ``""`` of a regular point, else ``"fold"``, ``"hopf"``, ``"branch-point"``, or the name of the user function that is
        zero.
    """

    point: CurvePoint
    eigenvalues: np.ndarray
    kind: str = ""

    @property
    def unknowns(self) -> np.ndarray:  # noqa: D102
        return self.point.unknowns

    @property
    def x(self) -> np.ndarray:
        """The states (n,)."""
        return self.point.unknowns[:-1]

    @property
    def parameter(self) -> float:
        """The parameter's value."""
        return float(self.point.unknowns[-1])

    @cached_property
    def unstable(self) -> int:
        """Number of eigenvalues with a positive real part."""
        return int(np.count_nonzero(self.eigenvalues.real > 0))

    @property
    def frequency(self) -> float:
        """Frequency of the complex pair of eigenvalues nearest to the imaginary axis, rad per unit of time."""
        complex_ = self.eigenvalues[self.eigenvalues.imag > 0]
        return float(complex_[np.abs(complex_.real).argmin()].imag) if len(complex_) else 0.0


@with_earlier_names
@dataclass(frozen=True, eq=False, repr=False)
class Branch(TracedCurve[Equilibrium]):
    """A branch of equilibria that was followed to its ends.

    Attributes
    ----------
    equations : EquilibriumEquations
    points : tuple of Equilibrium
        In order, special ones included; of a closed branch the first is the last, too.
    ends : (str, str)
        Sentences with the reasons why it ends, at its first and at its last point.
    """

    @cached_property
    def unknowns(self) -> np.ndarray:
        """States and parameter of all points (n+1, N)."""
        return np.array([p.unknowns for p in self.points]).T

    @cached_property
    def unstable(self) -> np.ndarray:
        """Number of eigenvalues of each point with a positive real part (N,)."""
        return np.array([p.unstable for p in self.points])


@with_earlier_names
@dataclass(frozen=True, eq=False)
class EquilibriumContinuation:
    """Branches of the equilibria of equations with one varied parameter.

    Parameters
    ----------
    equations : EquilibriumEquations
        f(x, p) with one parameter p.
    bounds : (float, float)
        Lower and upper limit of the parameter.
    steps : Steps
    limits : mapping of int to (float, float)
        Limits of some states, by their index, beyond which a branch is not followed.
    functions : mapping of str to callable
        Functions of the unknowns X = (x, p) (n+1,), by name, whose zeros are located.

    Raises
    ------
    WuchtError
        For equations with another number of varied parameters, limits of a state that does not exist, and a function with the
        name of a kind of special point.
    """

    equations: EquilibriumEquations
    bounds: tuple[float, float]
    steps: Steps = field(default_factory=Steps)
    limits: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    functions: Mapping[str, UserFunction] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_parameter_count(1, self.equations)
        bounds_of(self.equations, self.limits)
        if clashes := self.functions.keys() & {FOLD, HOPF, BRANCH_POINT, UNRESOLVED_POINT}:
            raise WuchtError(
                f"a user function must not be called {min(clashes)}: that is a kind of special point", code="name-taken"
            )

    @cached_property
    def curve(self) -> Curve:
        """The problem in the form that ``Curve`` follows."""
        e, (low, high) = self.equations, self.bounds
        # A first step over a large part of the range would miss special points there.
        first = min(self.steps.first, max(self.steps.least, _FIRST * abs(high - low) / float(e.scale[-1])))
        steps = replace(self.steps, first=first)
        bounds = bounds_of(e, self.limits, self.bounds)
        return Curve(FunctionProblem(e.values, e.scale, e.turns), bounds, steps, self._continues, e.names)

    def start(self, x: Sequence[float] | np.ndarray, value: float) -> CurvePoint:
        """Solve for the equilibrium near a state at a value of the parameter.

        Parameters
        ----------
        x : sequence of float, (n,)
            State near the equilibrium.
        value : float
            The parameter's value.

        Returns
        -------
        CurvePoint
            Where two branches cross it is on the one along the parameter; ``switch_branch`` leads to the other.

        Raises
        ------
        WuchtError
            For a state of another length, and numbers that are not finite.
        RunError
            Where Newton's method does not converge to an equilibrium.
        """
        up = np.zeros(self.equations.n + 1)
        up[-1] = self.equations.scale[-1]
        unknowns = state_of(self.equations, x, [value])
        try:
            return self.curve.start(unknowns, up)
        except RunError as error:
            if (crossing := self._crossing_near(unknowns)) is not None:
                return crossing
            at = f"{self.equations.parameter_names[0]} = {value:.9g}"
            raise RunError(
                f"{error}; nor do two branches cross at {at}: start at another value or state", code="not-evaluated"
            ) from error

    def _crossing_near(self, unknowns: np.ndarray) -> CurvePoint | None:
        """Return the branch point near given unknowns (n+1,) at its value of the parameter, None if there is none."""
        try:
            crossing = branch_point_near(self.equations, unknowns)
        except (RunError, ValueError, ArithmeticError):  # the latter of a user's function, outside its region
            return None
        here = abs(float(crossing.unknowns[-1] - unknowns[-1])) < _HERE * float(self.equations.scale[-1])
        return CurvePoint(crossing.unknowns, crossing.tangents[0], crossing.jacobian, 0.0, 0) if here else None

    def walk(self, start: CurvePoint) -> Walk[Equilibrium]:
        """Return the points from a first one on, special ones included, computed one by one."""
        return self._detector.walk(self.curve, start)

    def follow_branch(self, start: CurvePoint) -> Branch:
        """Follow the whole branch through a point both ways."""
        return Branch(self.equations, *self._detector.trace(self.curve, start))

    def evaluate(self, point: CurvePoint) -> Equilibrium:
        """Return a point with its eigenvalues."""
        return Equilibrium(point, eigenvalues_of(point.jacobian[:, :-1]))

    @cached_property
    def _detector(self) -> SpecialPointDetector[Equilibrium]:
        size = float(self.equations.scale[-1])

        def parameter_rate(equilibrium: Equilibrium) -> float:
            return float(equilibrium.point.tangent[-1]) / size

        return SpecialPointDetector(
            self.evaluate,
            [
                Condition(FOLD, parameter_rate, parameter_rate),
                Condition(HOPF, _sums, _sums, SUM_ROUNDING, holds=lambda e: critical_pairs(e.eigenvalues)[1]),
                *(
                    Condition(name, user_test := _user_condition(f), user_test, relative=True)
                    for name, f in self.functions.items()
                ),
            ],
            self._branch_point,
            self._is_explained,
            _without_turns,
        )

    def _is_explained(self, here: Equilibrium, there: Equilibrium, special_points: Sequence[Equilibrium]) -> bool:
        if not _crossings_agree(here, there, special_points):
            return False
        if not special_points:  # as nearly always
            return not self._hides(here, there, _HALVINGS)
        least = _NEAR * self.curve.steps.first
        stops = [here, *sorted((p for p in special_points if p.kind in _CROSSING), key=lambda p: p.point.length), there]
        return not any(b.point.length - a.point.length > least and self._hides(a, b, _HALVINGS) for a, b in pairwise(stops))

    def _hides(self, here: Equilibrium, there: Equilibrium, halvings: int) -> bool:
        """True if between two equally unstable points there is one that is not, so that special points cancel.

        Half way eigenvalues are taken at the cubic through both points, which costs less than a point of the branch; such a
        point is computed only where they may cross. This detects special points of any kind that are farther apart than the
        step over 2^halvings, if real parts are about parabolas over the step, or its middle lies between. It misses narrower
        excursions of real parts that are level elsewhere, and often two of three points where the same eigenvalue crosses.
        """
        if not halvings:
            return False
        a, b = here.point, there.point
        try:
            guess = (a.unknowns + b.unknowns) / 2 + (b.length - a.length) / 8 * (a.tangent - b.tangent)
            middle = self.equations.values(guess)[1][:, :-1]
            if not may_cross(here.eigenvalues, middle, there.eigenvalues, _ON_AXIS):
                return False
            middle_point = self.evaluate(self.curve.point_between(a, b, 0.5))
        except (RunError, ValueError, ArithmeticError):  # the latter of a user's function, outside its region
            return False
        if not (_crossings_agree(here, middle_point, ()) and _crossings_agree(middle_point, there, ())):
            return True
        return self._hides(here, middle_point, halvings - 1) or self._hides(middle_point, there, halvings - 1)

    def _continues(self, _: Problem, a: CurvePoint, b: CurvePoint) -> bool:
        """True if two points are on one curve: not, if the orientation changes and no branch point lies between.

        Very near to a point that is no simple branch point this is undecidable: the branch continues, and it is labelled.
        """
        near = b.length - a.length < _NEAR * self.curve.steps.first
        return a.orientation * b.orientation >= 0 or near or self._branch_point(a, b) is not None

    def _branch_point(self, a: CurvePoint, b: CurvePoint) -> Equilibrium | None:
        try:
            crossing = branch_point(self.equations, a, b)
        except (RunError, ValueError, ArithmeticError):  # the latter of a user's function, outside its region
            return None
        tangent = crossing.tangents[0]
        point = CurvePoint(crossing.unknowns, tangent, crossing.jacobian, a.length + crossing.share * (b.length - a.length), 0)
        return replace(self.evaluate(point), kind=BRANCH_POINT)

    def switch_branch(self, at: Equilibrium, step: float | None = None) -> tuple[CurvePoint, CurvePoint]:
        """Return the first points of the other branch through a branch point, one on either side. Raises ``RunError``.

        step: their largest distance from it.
        """
        tangents = BranchPoint.from_point(self.equations, at.unknowns, at.point.tangent).tangents
        distance = self.curve.steps.first if step is None else step
        first, second = (self._point_on_branch(at, s * tangents[1], tangents[0], distance) for s in (1.0, -1.0))
        return first, second

    def _point_on_branch(
        self, at: Equilibrium, direction: np.ndarray, branch_tangent: np.ndarray, distance: float
    ) -> CurvePoint:
        """Return a point of the branch with a given direction at a branch point: other branches lie in other directions."""
        curve, scale = self.curve, self.equations.scale
        cosine = float((direction / scale) @ (branch_tangent / scale))
        largest_angle = _NARROW * math.sqrt(max(1 - cosine**2, 0.0))
        while distance >= curve.steps.least:
            with suppress(RunError):
                candidate = curve.start(at.unknowns + distance * direction, direction)
                off = curve.size(candidate.unknowns - at.unknowns - distance * direction)
                turn = curve.size(candidate.tangent - direction)
                if max(off / distance, turn / 2) < largest_angle and curve.is_within_bounds(candidate.unknowns):
                    return candidate
            distance /= 2
        raise RunError("near this branch point no point of the other branch was found within the bounds: adjust the scale")


def _crossings_agree(here: Equilibrium, there: Equilibrium, special_points: Sequence[Equilibrium]) -> bool:
    """True if the special points between two points can explain the change of the number of unstable eigenvalues.

    At a branch point one passes the imaginary axis, or touches it; those on the axis may be on either side.
    """
    if not special_points and here.unstable == there.unstable:
        return True
    size = _ON_AXIS * max(float(np.abs(e.eigenvalues).max()) for e in (here, there))
    (a, most_a), (b, most_b) = _unstable_counts(here.eigenvalues, size), _unstable_counts(there.eigenvalues, size)
    least, crossing = max(0, b - most_a, a - most_b), sum(_CROSSING.get(p.kind, 0) for p in special_points)
    sure = (a, b) == (most_a, most_b) and all(p.kind != BRANCH_POINT for p in special_points)
    return least <= crossing and not (sure and (crossing - least) % 2)


def _unstable_counts(eigenvalues: np.ndarray, on_axis: float) -> tuple[int, int]:
    """Return the least and the greatest number with a positive real part, as those on the axis may have either sign."""
    return int((eigenvalues.real > on_axis).sum()), int((eigenvalues.real >= -on_axis).sum())


def _without_turns(special_points: Sequence[Equilibrium]) -> Sequence[Equilibrium]:
    """Remove folds at branch points: there a branch turns where it meets another, which is no fold."""
    lengths = [p.point.length for p in special_points if p.kind == BRANCH_POINT]
    return [p for p in special_points if p.kind != FOLD or all(abs(p.point.length - m) > _AT for m in lengths)]


def _sums(equilibrium: Equilibrium) -> float:
    """Test function that is zero where two eigenvalues add up to zero."""
    return critical_pairs(equilibrium.eigenvalues)[0]


def _user_condition(function: UserFunction) -> Callable[[Equilibrium], float]:
    return lambda equilibrium: float(function(equilibrium.unknowns))


provide_earlier_names(__name__)
