"""A curve F(X) = 0, F: R^(n+1) -> R^n, followed point by point by pseudo-arclength continuation.

From a point the next one is predicted along the tangent and its change, and corrected by Newton's method in the plane across
the tangent; the step grows and shrinks with Newton's effort and with how far the tangent turns.
H. B. Keller, in P. Rabinowitz (ed.), "Applications of Bifurcation Theory", Academic Press 1977; W. Govaerts, "Numerical
Methods for Bifurcations of Dynamical Equilibria", SIAM 2000.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.equations import CurvePoint, Problem

P = TypeVar("P")

CURVE_IS_CLOSED = "it is closed"

_MOST_CORRECTIONS = 8
_CORRECTION_ROUNDING = 1e-7  # corrections that small and no longer smaller are rounding
_GROWS, _SHRINKS = 1.6, 0.5  # at most
_NEAR_A_BOUND = 0.1  # of the first step: how near a bound is approached on which the equations are singular
_ON_A_BOUND = 1e-6  # in units of scale: a point beyond a bound by less is on it, as far as a first point is known
_FAR = 100.0  # in units of scale: an unknown that has changed by more has run away
_BOUND_TOLERANCE = 1e-12  # in units of scale: nearer to a bound a point is on it
_SAME = 1e-3  # of the way between two points: how near it the curve passes its first one where it is closed
_ASTRAY = 0.1  # of a step: a prediction that is so much shorter or longer along the tangent is not used
_NEARER = 5  # tries to come so near
_BESIDE = 0.3  # of that way: how far from a straight line between them the first point lies at most
_SAME_WAY = 0.7  # cosine between both directions there at least: steps turn by less


@dataclass(frozen=True)
class Steps:
    """Step control of a continuation. Lengths are arclengths in units of the problem's scale.

    Parameters
    ----------
    first, least, most : float
        Length of the first step, and the shortest and longest one.
    turn : float
        Turn of the tangent from point to point at which the step length is kept, rad.
    corrections : int
        Number of Newton's corrections at which the step length is kept.
    points : int
        Number of points after which a curve is left, at most.
    tolerance : float
        Largest length of Newton's last correction.
    predicts_correction : bool
        True where the tolerance is that of the next correction, which is not made but extrapolated from the previous ones.
    """

    first: float = 0.01
    least: float = 1e-7
    most: float = 0.2
    turn: float = 0.15
    corrections: int = 3
    points: int = 2000
    tolerance: float = 1e-10
    predicts_correction: bool = False


class Walk(Iterator[P], Generic[P]):
    """Iterator over the points of a curve, computed one by one.

    Parameters
    ----------
    points : generator
        Yields the points, and returns a sentence with the reason why there is no further one.

    Attributes
    ----------
    end : str
        That sentence, after the last point; empty before.
    """

    def __init__(self, points: Generator[P, None, str]) -> None:
        self._points, self.end = points, ""

    def __next__(self) -> P:
        try:
            return next(self._points)
        except StopIteration as stop:
            self.end = self.end or str(stop.value)
            raise StopIteration from None
        except BaseException as error:
            self.end = f"it was interrupted: {str(error) or type(error).__name__}"
            raise


@dataclass(frozen=True, eq=False)
class Curve:
    """Curve of the solutions of a problem with one unknown more than equations.

    Parameters
    ----------
    problem : Problem
        The equations F(X) = 0, such as a ``FunctionProblem``.
    bounds : mapping of int to (float, float)
        Lower and upper limit of some unknowns, by their index (-1: the last one).
    steps : Steps
    continues : callable, optional
        Function of the problem and two points: true if the second is on the curve of the first one, as far as a caller can
        decide; else a shorter step is made.
    names : sequence of str
        Names of the unknowns, for sentences.
    predict : callable, optional
        Function of the problem, a point and a step: a guess of the unknowns that far from the point; by default along its
        tangent and bend.

    Examples
    --------
    The unit circle, from its point on the right all around:

    >>> import numpy as np
    >>> from wucht.numerics.continuation import Curve, FunctionProblem
    >>> circle = FunctionProblem(lambda x: (np.array([x @ x - 1]), 2 * x[None]), scale=np.ones(2))
    >>> curve = Curve(circle)
    >>> walk = curve.follow(curve.start(np.array([1.0, 0.0]), towards=np.array([0.0, 1.0])))
    >>> points = np.array([point.unknowns for _, point in walk])
    >>> walk.end, float(points[:, 0].min().round(2))
    ('it is closed', -1.0)
    """

    problem: Problem
    bounds: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    steps: Steps = Steps()
    continues: Callable[[Problem, CurvePoint, CurvePoint], bool] | None = None
    names: Sequence[str] = ()
    predict: Callable[[Problem, CurvePoint, float], np.ndarray] | None = None

    def start(self, unknowns: np.ndarray, towards: np.ndarray) -> CurvePoint:
        """Solve for the point near given unknowns in the plane across a direction (n+1,), which its tangent follows.

        Raises ``RunError``.
        """
        point, _ = self.correct(unknowns, towards / self.size(towards), 0.0)
        return point

    def follow(self, start: CurvePoint) -> Walk[tuple[Curve, CurvePoint]]:
        """Follow the curve from a first point; each point comes with the curve in the formulation used there.

        Raises ``RunError`` for a first point out of bounds.
        """
        self._check_start(start.unknowns)
        return Walk(self._generate_points(start))

    def _generate_points(self, start: CurvePoint) -> Generator[tuple[Curve, CurvePoint], None, str]:
        curve, here, step = self, start, self.steps.first
        first, turns = self.problem.outline(start.unknowns)
        before, count, first_direction, is_reformulated = first, 0, first, False
        while count < self.steps.points:
            try:
                guess = curve._guess(here, step)
                there, corrections = curve.correct(guess, here.tangent, here.length + step, self.steps.predicts_correction)
                # Where Newton's method went farther than the step, that is another curve's point.
                turn_angle = (
                    curve._angle(here.tangent, there.tangent) if curve.size(there.unknowns - guess) <= step else math.pi
                )
            except RunError:
                there, turn_angle, corrections = here, math.pi, _MOST_CORRECTIONS
            if turn_angle > 3 * self.steps.turn or (self.continues and not self.continues(curve.problem, here, there)):
                step, here = step * _SHRINKS, replace(here, bend=None)
                if is_reformulated:  # in the new formulation the last point may be only approximately a solution
                    here, is_reformulated = curve._try_correct(here), False
                if step < self.steps.least:
                    return f"no further point could be computed: steps would be shorter than {self.steps.least:g}"
                continue
            if (crossing := curve.crossed_bound(here.unknowns, there.unknowns)) is not None:
                index, limit = crossing
                gap = abs(limit - here.unknowns[index]) / curve.problem.scale[index]
                if gap < _BOUND_TOLERANCE or not curve.bounds[index][0] <= here.unknowns[index] <= curve.bounds[index][1]:
                    return curve.exit_sentence(index, limit)
                try:
                    last = curve._point_on_bound(here, there, index, limit)
                except RunError:  # on the bound the equations are singular: it is approached
                    step, here = step * _SHRINKS, replace(here, bend=None)
                    if step < _NEAR_A_BOUND * self.steps.first:
                        return f"{curve.exit_sentence(index, limit)}, where the equations are singular"
                    continue
                yield curve, last
                return curve.exit_sentence(index, limit)
            after, _ = curve.problem.outline(there.unknowns)
            close = count > 1 and _passes_start(before, after, first, turns)
            if close and (closing_point := curve._closing_point(here, there, start, first, first_direction)) is not None:
                yield curve, closing_point
                return CURVE_IS_CLOSED
            yield curve, there
            before, count, first_direction = after, count + 1, first_direction if count else after - first
            bend = (there.tangent - here.tangent) / step
            step = self._next_step(step, turn_angle, corrections)
            problem, here = curve.problem.reformulate(replace(there, bend=bend))
            is_reformulated = problem is not curve.problem
            if is_reformulated:
                curve = replace(curve, problem=problem)
        runaway_note = self._runaway_note(start.unknowns, here.unknowns)
        return f"it has reached the maximum number of points, {self.steps.points}{runaway_note}"

    def _guess(self, here: CurvePoint, step: float) -> np.ndarray:
        """Return unknowns a step farther: as predicted where that leads along the tangent, else along tangent and bend."""
        guess = here.unknowns + step * here.tangent
        if here.bend is None:  # at a first point, or after a step that was too long
            return guess
        if self.predict is not None:
            prediction = self.predict(self.problem, here, step)
            missing = step - float((prediction - here.unknowns) @ (here.tangent / self.problem.scale**2))
            if abs(missing) < _ASTRAY * step:
                return np.asarray(prediction + missing * here.tangent)
        return np.asarray(guess + step**2 / 2 * here.bend)

    def correct(
        self, unknowns: np.ndarray, tangent: np.ndarray, length: float, predicts_correction: bool = False
    ) -> tuple[CurvePoint, int]:
        """Apply Newton's method from given unknowns in the plane across a tangent; return also the number of corrections.

        predicts_correction: see ``Steps``; only for points on the way. Raises ``RunError``.
        """
        scale = self.problem.scale
        across = tangent / scale**2
        sides, before = np.zeros((len(unknowns), 2)), math.inf
        sides[-1, 1] = 1.0
        for correction in range(1, _MOST_CORRECTIONS + 1):
            try:
                off, jacobian = self.problem.residual(unknowns)
            except (ValueError, ArithmeticError) as error:  # a user's function, outside the region where it is defined
                raise RunError(f"the equations cannot be evaluated here: {error}") from error
            sides[:-1, 0] = off
            solution, orientation = self.problem.solution(jacobian, across, sides)
            change = self.size(solution[:, 0])
            unknowns = unknowns - solution[:, 0]
            # Where the equations are nearly singular, rounding stops Newton's method before the tolerance is reached.
            remaining = change * (change / before) ** 2 if predicts_correction and change < before < math.inf else change
            if remaining <= self.steps.tolerance or before / 2 < change < _CORRECTION_ROUNDING:
                direction = solution[:, 1]
                return CurvePoint(unknowns, direction / self.size(direction), jacobian, length, orientation), correction
            if not change < 2 * before:
                break
            before = change
        raise RunError("Newton's method does not converge to a point of the curve", code="no-convergence")

    def _try_correct(self, point: CurvePoint) -> CurvePoint:
        """Correct an approximate point by Newton's method; return it unchanged where that fails."""
        try:
            solution, _ = self.correct(point.unknowns, point.tangent, point.length)
        except RunError:
            return point
        return solution

    def point_between(self, a: CurvePoint, b: CurvePoint, share: float) -> CurvePoint:
        """Solve for the point of the curve at a fraction of the way from one point to a near one. Raises ``RunError``."""
        way, span = b.unknowns - a.unknowns, b.length - a.length
        across, s, r = way / self.size(way), share, 1 - share
        guess = (
            (1 + 2 * s) * r**2 * a.unknowns
            + s * r**2 * span * a.tangent
            + s**2 * (3 - 2 * s) * b.unknowns
            - s**2 * r * span * b.tangent
        )
        guess = guess + across * float((a.unknowns + share * way - guess) @ (across / self.problem.scale**2))
        return self.correct(guess, across, a.length + share * span)[0]

    def backwards(self, point: CurvePoint) -> CurvePoint:
        """Return the same point of the curve followed the other way."""
        return replace(point, tangent=-point.tangent, orientation=-point.orientation)

    def size(self, direction: np.ndarray) -> float:
        """Return the length of a change of the unknowns (n+1,), in units of their scale."""
        scaled_direction = direction / self.problem.scale
        return math.sqrt(scaled_direction @ scaled_direction)

    def is_within_bounds(self, unknowns: np.ndarray) -> bool:
        """True if unknowns (n+1,) are within their bounds, or on one but for rounding."""
        near = _ON_A_BOUND * self.problem.scale
        return all(low - near[i] <= unknowns[i] <= high + near[i] for i, (low, high) in self.bounds.items())

    def is_on_bound(self, unknowns: np.ndarray) -> bool:
        """True if unknowns (n+1,) are on one of their bounds, but for rounding: it is then undecided whether a special point
        lies within them."""
        near = _ON_A_BOUND * self.problem.scale
        return any(abs(unknowns[i] - limit) <= near[i] for i, bounds in self.bounds.items() for limit in bounds)

    def _check_start(self, unknowns: np.ndarray) -> None:
        for i, (low, high) in self.bounds.items():
            if not low < high:
                raise RunError(
                    f"there is no range from {low:.9g} to {high:.9g}: the second number must be the greater one",
                    code="empty-range",
                )
            if not replace(self, bounds={i: (low, high)}).is_within_bounds(unknowns):
                description = self._describe_value(i, unknowns[i])
                raise RunError(
                    f"the first point is out of its range: {description} is not between {low:.9g} and {high:.9g}",
                    code="out-of-range",
                )

    def exit_sentence(self, index: int, limit: float) -> str:
        """Return the sentence with which the curve ends where an unknown, by its index in ``bounds``, is on its bound."""
        return f"it leaves the range at {self._describe_value(index, limit)}"

    def _describe_value(self, index: int, value: float) -> str:
        """Describe a value of an unknown, with its name where it is known."""
        i = index % len(self.problem.scale)
        return f"{self.names[i]} = {value:.9g}" if i < len(self.names) else f"{value:.9g}"

    def _runaway_note(self, first: np.ndarray, last: np.ndarray) -> str:
        """Describe the unknown that has changed by far more than its scale, if there is one."""
        if not self.names:
            return ""
        away = (np.abs(last - first) / self.problem.scale)[: len(self.names)]
        i = int(away.argmax())
        note = f"; {self.names[i]} changed from {first[i]:.3g} to {last[i]:.3g}: it may need a greater scale, or limits"
        return note if away[i] > _FAR else ""

    def _angle(self, a: np.ndarray, b: np.ndarray) -> float:
        return math.acos(min(1.0, max(-1.0, float(a @ (b / self.problem.scale**2)))))

    def _next_step(self, step: float, turn_angle: float, corrections: int) -> float:
        """Return the next step length, for the wanted turn of the tangent and number of Newton's corrections."""
        factor = min(_GROWS, self.steps.turn / max(turn_angle, 1e-12), 2.0 ** (self.steps.corrections - corrections + 1))
        return min(max(factor, _SHRINKS) * step, self.steps.most)

    def crossed_bound(self, before: np.ndarray, unknowns: np.ndarray) -> tuple[int, float] | None:
        """Return the index of the unknown that leaves its bounds first on the way, and that bound; None if none does."""
        crossings = [
            (i, low if unknowns[i] < low else high) for i, (low, high) in self.bounds.items() if not low <= unknowns[i] <= high
        ]
        return min(
            crossings,
            key=lambda crossing: (crossing[1] - before[crossing[0]]) / (unknowns[crossing[0]] - before[crossing[0]]),
            default=None,
        )

    def _point_on_bound(self, here: CurvePoint, there: CurvePoint, index: int, limit: float) -> CurvePoint:
        """Solve for the point between two where an unknown is on its bound, by Newton's method in that plane."""
        plane = np.zeros(len(here.unknowns))
        plane[index] = self.problem.scale[index]
        share = (limit - here.unknowns[index]) / (there.unknowns[index] - here.unknowns[index])
        guess = here.unknowns + share * (there.unknowns - here.unknowns)
        solution, _ = self.correct(guess, plane, here.length + share * (there.length - here.length))
        unknowns = solution.unknowns.copy()
        unknowns[index] = limit
        solution = replace(solution, unknowns=unknowns)
        return solution if solution.tangent @ (here.tangent / self.problem.scale**2) > 0 else self.backwards(solution)

    def _closing_point(
        self, here: CurvePoint, there: CurvePoint, start: CurvePoint, first: np.ndarray, first_direction: np.ndarray
    ) -> CurvePoint | None:
        """Return the first point once more if the curve passes it between two points in the direction in which it began."""
        (before, turns), (after, _) = (self.problem.outline(p.unknowns) for p in (here, there))
        way, away = after - before, first - before
        away = away - _whole_turns(away, turns)
        if way @ first_direction < _SAME_WAY * math.sqrt((way @ way) * (first_direction @ first_direction)):
            return None
        share, long = float(away @ way) / float(way @ way), math.sqrt(way @ way)
        for _ in range(_NEARER):  # the curve is no straight line between them
            try:
                near = self.point_between(here, there, share)
            except RunError:  # too near to another branch: the direction alone decides that it returns
                return self._repeat_start(there, start)
            off = self.problem.outline(near.unknowns)[0] - before - away
            if float(off @ off) < (_SAME * long) ** 2:
                return self._repeat_start(near, start)
            share = min(max(share - float(off @ way) / long**2, 0.0), 1.0)
        return None

    def _repeat_start(self, there: CurvePoint, start: CurvePoint) -> CurvePoint:
        """Return the first point, after whole turns of its angles, where an outline determines it; else the near point."""
        _, turns = self.problem.outline(there.unknowns)
        if len(turns) != len(there.unknowns):
            return there
        away = (there.unknowns - start.unknowns) / self.problem.scale
        return replace(start, unknowns=start.unknowns + _whole_turns(away, turns) * self.problem.scale, length=there.length)


def _passes_start(before: np.ndarray, after: np.ndarray, first: np.ndarray, turns: np.ndarray) -> bool:
    """True if the first point's outline lies on the way from one to the next, but for whole turns."""
    away, way = after - first, after - before
    if turns.any():
        away = away - _whole_turns(away, turns)
    long, along = float(way @ way), float(away @ way)
    return 0 <= along <= long and float(away @ away) * long - along**2 < (_BESIDE * long) ** 2


def _whole_turns(away: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return the whole turns nearest to differences, 0 for unknowns that are no angles."""
    return np.asarray(turns * np.rint(away / np.where(turns > 0, turns, np.inf)))
