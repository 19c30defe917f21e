"""The points of a curve where conditions hold: special equilibria along a branch, and special points on curves of these."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from wucht.errors import RunError, WuchtError
from wucht.numerics.continuation.curve import CURVE_IS_CLOSED, Curve, Walk
from wucht.numerics.continuation.equations import CurvePoint, Equations
from wucht.numerics.continuation.special_points import locate_zero

CUSP, BOGDANOV_TAKENS, ZERO_HOPF = "cusp", "bogdanov-takens", "zero-hopf"
GENERALISED_HOPF, DOUBLE_HOPF = "generalised-hopf", "double-hopf"
UNRESOLVED_POINT = "unresolved"

_ZERO = 1e-5  # a test function, of order one elsewhere, counts as zero below this
_NEEDS = {
    1: "a branch of equilibria needs one varied parameter",
    2: "a curve of special equilibria needs two varied parameters",
}
_HALVINGS = 8  # of a step at most, to distinguish special points that lie within it


class EvaluatedPoint(Protocol):
    """A point of a curve with the quantities evaluated at it: a frozen dataclass."""

    @property
    def point(self) -> CurvePoint: ...  # noqa: D102

    @property
    def kind(self) -> str: ...  # noqa: D102


P = TypeVar("P", bound=EvaluatedPoint)


@dataclass(frozen=True, eq=False, repr=False)
class TracedCurve(Generic[P]):
    """A curve that was followed to its ends. points: in order, special ones included. ends: why it ends, at first and last.

    A closed curve has its first point once more as its last; both sentences then state that it is closed.
    """

    equations: Equations
    points: tuple[P, ...]
    ends: tuple[str, str]

    def __repr__(self) -> str:
        """Summarise the curve in one line: its points are hundreds of arrays."""
        n, names = self.equations.n, self.equations.parameter_names
        values = np.array([p.point.unknowns[n : n + len(names)] for p in self.points]).T
        ranges = (f"{name} from {v.min():.6g} to {v.max():.6g}" for name, v in zip(names, values, strict=True))
        kinds = Counter(p.kind for p in self.special)
        special = ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "none"
        ends = " and ".join(dict.fromkeys(self.ends))
        return f"<{type(self).__name__}: {len(self.points)} points, {', '.join(ranges)}; special: {special}; ends: {ends}>"

    @property
    def special(self) -> tuple[P, ...]:
        """Points at which a condition holds."""
        return tuple(p for p in self.points if p.kind)

    @property
    def is_closed(self) -> bool:
        """True if the curve returns to its first point, but for whole turns of angles."""
        return self.ends[0] == self.ends[1] == CURVE_IS_CLOSED


@dataclass(frozen=True)
class Condition(Generic[P]):
    """A condition that distinguishes points of a curve.

    kind: their label. test: passes zero there; it is evaluated along the way and may be rough. exact: the same to rounding.
    rounding: smaller values of the test are insignificant. relative: the test is not of order one, but measured by its largest
    value so far. holds: true if a zero is of this kind indeed. end: where the curve exists only while the test is
    positive, a sentence why it ends.
    """

    kind: str
    test: Callable[[P], float]
    exact: Callable[[P], float]
    rounding: float = 1e-10
    relative: bool = False
    holds: Callable[[P], bool] = lambda _: True
    end: str = ""


class _Value(NamedTuple):
    """A test function at the last point where it exceeded rounding, and its largest value so far, if relative, else 1."""

    point: CurvePoint
    number: float
    largest: float


_Values = Mapping[str, _Value]


@dataclass(frozen=True)
class SpecialPointDetector(Generic[P]):
    """Detection of special points along a curve.

    evaluate: adds to a point the quantities that the conditions need. branch_crossing: the point between two neighbours of
    opposite orientation where another branch crosses. explains: true if the changes from one point to a second follow from
    the special points between them; else both halves of the way are examined, and the remainder is labelled
    ``"unresolved"``. select: which of the special points between two neighbours are reported.
    """

    evaluate: Callable[[CurvePoint], P]
    conditions: Sequence[Condition[P]]
    branch_crossing: Callable[[CurvePoint, CurvePoint], P | None] | None = None
    explains: Callable[[P, P, Sequence[P]], bool] = lambda *_: True
    select: Callable[[Sequence[P]], Sequence[P]] = lambda points: points

    def walk(self, curve: Curve, start: CurvePoint) -> Walk[P]:
        """Return the points after a first one, special ones included, computed one by one."""
        return Walk(self._generate_points(start, curve.follow(start)))

    def trace(self, curve: Curve, start: CurvePoint) -> tuple[tuple[P, ...], tuple[str, str]]:
        """Follow the whole curve through a point both ways: return its points, and why it ends at first and at last."""
        onward, backward = self.walk(curve, start), self.walk(curve, curve.backwards(start))
        after = list(onward)
        is_closed = onward.end == CURVE_IS_CLOSED
        before = [_reverse(p) for p in (islice(backward, 1) if is_closed else backward)][::-1]
        ends = (backward.end, onward.end)
        here = self._start_points(curve, before, self.evaluate(start), after, ends)
        if is_closed:
            return (*here, *after), (CURVE_IS_CLOSED, CURVE_IS_CLOSED)
        return (*before, *here, *after), ends

    def _generate_points(self, start: CurvePoint, walk: Walk[tuple[Curve, CurvePoint]]) -> Generator[P, None, str]:
        here = self.evaluate(start)
        # Where a test function is below rounding its sign is that of the last point where it was not.
        last: _Values = {c.kind: _value(c, start, c.test(here), 0.0) for c in self.conditions}
        ending = [c for c in self.conditions if c.end]
        for curve, point in walk:
            there = self.evaluate(point)
            special_points, last = self._special_points_between(curve, here, there, last, _HALVINGS)
            end_condition = next((c for c in ending if last[c.kind].number < 0), None)
            until = point.length
            for p in sorted(self.select(special_points), key=lambda p: p.point.length) if special_points else ():
                if not curve.is_within_bounds(p.point.unknowns) and (exit_point := _exit_point(curve, here.point, p.point)):
                    yield self.evaluate(exit_point[0])
                    return exit_point[1]
                if p.point.length <= until and not curve.is_on_bound(p.point.unknowns):
                    yield p
                until = p.point.length if end_condition and p.kind == end_condition.kind else until
            if end_condition:
                return end_condition.end
            yield there
            here = there
        return walk.end

    def _special_points_between(self, curve: Curve, here: P, there: P, last: _Values, halvings: int) -> tuple[list[P], _Values]:
        """Return the special points between two neighbours, and the test functions at the second."""
        candidates, now = list[P | None](), dict(last)
        for condition in self.conditions:
            before = last[condition.kind]
            value = _value(condition, there.point, condition.test(there), before.largest)
            if _is_significant(condition, value):
                now[condition.kind] = value
                if value.number * before.number < 0 and _is_significant(condition, before):
                    candidates.append(_locate_condition(curve, before.point, value, self.evaluate, condition))
        special_points = [p for p in candidates if p is not None]
        is_explained = True
        if self.branch_crossing and here.point.orientation * there.point.orientation < 0:
            crossing = self.branch_crossing(here.point, there.point)
            special_points, is_explained = (
                special_points if crossing is None else [*special_points, crossing],
                crossing is not None,
            )
        if is_explained and self.explains(here, there, special_points):
            return special_points, now
        try:
            middle = self.evaluate(curve.point_between(here.point, there.point, 0.5)) if halvings else None
        except RunError:
            middle = None
        if middle is None:
            return [*special_points, _label(there, UNRESOLVED_POINT)], now
        first, last = self._special_points_between(curve, here, middle, last, halvings - 1)
        second, last = self._special_points_between(curve, middle, there, last, halvings - 1)
        return [*first, *second], last

    def _start_points(self, curve: Curve, before: Sequence[P], start: P, after: Sequence[P], ends: tuple[str, str]) -> list[P]:
        """Return the first point, or in its place the special points that lie on it, as its neighbours show."""
        for condition in self.conditions:
            here = _value(condition, start.point, condition.test(start), 0.0)
            if condition.end and condition.end in ends and not _is_significant(condition, here):
                return [_label(start, condition.kind)]
        a, b = (next((p for p in side if not p.kind), None) for side in (before[::-1], after))
        if a is None or b is None:
            return [start]
        candidates = list[P | None]()
        for condition in self.conditions:
            first_value = _value(condition, a.point, condition.test(a), 0.0)
            second_value = _value(condition, b.point, condition.test(b), first_value.largest)
            here = _value(condition, start.point, condition.test(start), second_value.largest)
            if (
                first_value.number * second_value.number < 0
                and _is_significant(condition, first_value)
                and not _is_significant(condition, here)
            ):
                candidates.append(_locate_condition(curve, a.point, second_value, self.evaluate, condition))
        if self.branch_crossing and not start.point.orientation and a.point.orientation * b.point.orientation < 0:
            candidates.append(self.branch_crossing(a.point, b.point))
        return list(self.select([p for p in candidates if p is not None])) or [start]


def _value(condition: Condition[P], point: CurvePoint, number: float, largest: float) -> _Value:
    return _Value(point, number, max(largest, abs(number)) if condition.relative else 1.0)


def _is_significant(condition: Condition[P], value: _Value) -> bool:
    return abs(value.number) > condition.rounding * value.largest


def _locate_condition(
    curve: Curve, a: CurvePoint, b: _Value, evaluate: Callable[[CurvePoint], P], condition: Condition[P]
) -> P | None:
    def exact(point: CurvePoint) -> P:
        """Evaluate with the Jacobian at this point, not one correction before."""
        return evaluate(replace(point, jacobian=curve.problem.residual(point.unknowns)[1]))

    candidate = locate_zero(curve, a, b.point, exact, condition.exact)
    if candidate is None or not abs(condition.exact(candidate)) < _ZERO * b.largest or not condition.holds(candidate):
        return None
    return _label(candidate, condition.kind)


def _exit_point(curve: Curve, a: CurvePoint, b: CurvePoint) -> tuple[CurvePoint, str] | None:
    """Return the point where the curve leaves the range, to which it returns within a step, and the sentence for it."""
    if (crossing := curve.crossed_bound(a.unknowns, b.unknowns)) is None:
        return None
    index, limit = crossing
    solution = locate_zero(curve, a, b, lambda point: point, lambda point: float(point.unknowns[index]) - limit)
    if solution is None:
        return None
    unknowns = solution.unknowns.copy()
    unknowns[index] = limit
    return replace(solution, unknowns=unknowns), curve.exit_sentence(index, limit)


def _label(evaluation: P, kind: str) -> P:
    return replace(evaluation, kind=kind)  # type: ignore[type-var]


def _reverse(evaluation: P) -> P:
    p = evaluation.point
    reversed_point = replace(p, tangent=-p.tangent, length=-p.length, orientation=-p.orientation)
    return replace(evaluation, point=reversed_point)  # type: ignore[type-var]


def require_parameter_count(count: int, equations: Equations) -> None:
    """Raise ``WuchtError`` unless as many parameters are varied as the curve needs, one or two."""
    if len(equations.parameter_names) != count:
        names = ", ".join(equations.parameter_names) or "none"
        raise WuchtError(f"{_NEEDS[count]}; given: {names}", code="one-parameter")


def bounds_of(
    equations: Equations, limits: Mapping[int, tuple[float, float]], *bounds: tuple[float, float]
) -> dict[int, tuple[float, float]]:
    """Return the bounds of a ``Curve``, by index: of some states, and of the parameters.

    Raises ``WuchtError`` for an index that is no state.
    """
    n = equations.n
    if wrong := [i for i in limits if not 0 <= i < n]:
        raise WuchtError(
            f"limits are given for state {wrong[0]}, which does not exist: states are numbered 0 to {n - 1}", code="no-state"
        )
    return {**limits, **{n + k: pair for k, pair in enumerate(bounds)}}


def state_of(equations: Equations, x: Sequence[float] | np.ndarray, parameters: Sequence[float]) -> np.ndarray:
    """Return X = (x, p) (n+m,) of a state and parameters. Raises ``WuchtError`` if one has a wrong length or is not finite."""
    for values, names, kind in (
        (x, equations.state_names, "state"),
        (parameters, equations.parameter_names, "value of the parameters"),
    ):
        if np.shape(values) != (len(names),):
            raise WuchtError(f"a {kind} is {len(names)} numbers, {', '.join(names)}; given: {values}", code="shape")
    unknowns = np.concatenate([np.asarray(x, float), np.asarray(parameters, float)])
    if not np.isfinite(unknowns).all():
        raise WuchtError(
            f"a state and its parameters must be finite numbers; given: {', '.join(f'{v:g}' for v in unknowns)}",
            code="not-finite",
        )
    return unknowns
