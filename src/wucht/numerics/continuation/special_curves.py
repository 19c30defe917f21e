"""Curves of special equilibria in two parameters, and the points on them where a second condition holds."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.continuation.curve import Curve, Walk
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.equilibria import CLOSED
from wucht.numerics.continuation.problem import CurvePoint
from wucht.numerics.continuation.special_points import located

CUSP, BOGDANOV_TAKENS, ZERO_HOPF = "cusp", "bogdanov-takens", "zero-hopf"
GENERALISED_HOPF, DOUBLE_HOPF = "generalised-hopf", "double-hopf"

_ZERO = 1e-5  # what a test function, of order one where nothing happens, is at most where it is said to be zero


class Seen(Protocol):
    """A point of such a curve with what is known of it: a frozen dataclass."""

    @property
    def point(self) -> CurvePoint: ...  # noqa: D102

    @property
    def kind(self) -> str: ...  # noqa: D102


P = TypeVar("P", bound=Seen)


@dataclass(frozen=True, eq=False)
class SpecialCurve(Generic[P]):
    """A curve that was followed to its ends. points: in order, special ones among them. ends: why it ends, at first and last.

    A closed curve has its first point once more as its last; then both sentences say so.
    """

    equations: Equations
    points: tuple[P, ...]
    ends: tuple[str, str]

    @cached_property
    def u(self) -> np.ndarray:
        """States and both parameters of all points (n+2, N)."""
        return np.array([p.point.u[: self.equations.n + 2] for p in self.points]).T

    @property
    def parameters(self) -> np.ndarray:
        """Both parameters of all points (2, N)."""
        return self.u[-2:]

    @property
    def special(self) -> tuple[P, ...]:
        """The points where a second condition holds."""
        return tuple(p for p in self.points if p.kind)

    @property
    def closed(self) -> bool:
        """Whether it returns to its first point, but for whole turns of angles."""
        return self.ends[0] == self.ends[1] == CLOSED


@dataclass(frozen=True)
class Condition(Generic[P]):
    """A condition that singles out points of a curve.

    kind: their label. test: passes zero there; looked at along the way, it may be rough. exact: the same, right to rounding.
    rounding: what is smaller says nothing of the test. holds: whether a zero is what it is taken for. end: where the curve only
    lasts while the test is positive, a sentence why it ends.
    """

    kind: str
    test: Callable[[P], float]
    exact: Callable[[P], float]
    rounding: float = 1e-10
    holds: Callable[[P], bool] = lambda _: True
    end: str = ""


def refuse_other_than_two(equations: Equations) -> None:
    """Raises ``WuchtError`` where not exactly two parameters are varied."""
    if len(equations.parameters) != 2:
        given = ", ".join(equations.parameters) or "none"
        raise WuchtError(f"a curve of special equilibria needs two parameters that are varied; given: {given}")


def walked(
    curve: Curve, start: CurvePoint, seen: Callable[[CurvePoint], P], conditions: Iterable[Condition[P]]
) -> Generator[P, None, str]:
    """The points after a first one, special ones among them, and why they end. seen: a point as the conditions see it."""
    here, walk = seen(start), curve.follow(start)
    # Where a test function is lost in rounding its sign is that of the last point where it was not.
    last = [(c, start, c.test(here)) for c in conditions]
    for written, point in walk:
        there, found, end, until = seen(point), list[P](), "", point.length
        for i, (condition, before, valued) in enumerate(last):
            value = condition.test(there)
            if not abs(value) > condition.rounding:
                continue
            if value * valued < 0 and abs(valued) > condition.rounding:
                special = _located(written, before, point, seen, condition)
                if special is not None:
                    found.append(special)
                    until = special.point.length if condition.end else until
            if condition.end and value < 0:
                end = condition.end
            last[i] = condition, point, value
        yield from sorted((p for p in found if p.point.length <= until), key=lambda p: p.point.length)
        if end:
            return end
        yield there
    return walk.end


def _located(curve: Curve, a: CurvePoint, b: CurvePoint, seen: Callable[[CurvePoint], P], condition: Condition[P]) -> P | None:
    def exact(point: CurvePoint) -> P:
        """With the Jacobian at the point itself, not one correction before."""
        return seen(replace(point, jacobian=curve.problem.residual(point.u)[1]))

    found = located(curve, a, b, exact, condition.exact)
    if found is None or not abs(condition.exact(found)) < _ZERO or not condition.holds(found):
        return None
    return replace(found, kind=condition.kind)  # type: ignore[type-var]


def whole_curve(
    equations: Equations, start: P, walk: Callable[[CurvePoint], Walk[P]], backwards: Callable[[CurvePoint], CurvePoint]
) -> SpecialCurve[P]:
    """The curve through a point, followed both ways."""
    onward = walk(start.point)
    after = list(onward)
    if onward.end == CLOSED:
        return SpecialCurve(equations, (start, *after), (CLOSED, CLOSED))
    backward = walk(backwards(start.point))
    before = [_reversed(p) for p in backward][::-1]
    return SpecialCurve(equations, (*before, start, *after), (backward.end, onward.end))


def _reversed(seen: P) -> P:
    p = seen.point
    turned = replace(p, tangent=-p.tangent, length=-p.length, orientation=-p.orientation)
    return replace(seen, point=turned)  # type: ignore[type-var]
