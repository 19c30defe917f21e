"""Branches of equilibria in one parameter, with eigenvalues, folds, Hopf and branch points, and zeros of a user's functions."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.branch_points import BranchPoint, branch_point
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.problem import CurvePoint, Functions
from wucht.numerics.continuation.special_points import critical_pairs, located

FOLD, HOPF, BRANCH_POINT = "fold", "hopf", "branch-point"

_ROUNDING = 1e-10  # a test function that is smaller says nothing
_HALVINGS = 8  # of a step at most, to tell apart special points that lie within it
_ON_AXIS = 1e-8  # relative: the sign of a real part that is smaller says nothing
_CROSSING = {FOLD: 1, BRANCH_POINT: 1, HOPF: 2}  # eigenvalues that pass the imaginary axis there

UserFunction = Callable[[np.ndarray], float]


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A point of a branch.

    Attributes
    ----------
    u : ndarray, (n+1,)
        States and the parameter; angles as they have turned along the branch.
    point : CurvePoint
        The same with tangent and Jacobian.
    eigenvalues : ndarray of complex, (n,)
        Of df/dx, per unit of time.
    kind : str
        ``""`` of a regular point, else ``"fold"``, ``"hopf"``, ``"branch-point"``, or the name of the user's function that is
        zero.
    """

    point: CurvePoint
    eigenvalues: np.ndarray
    kind: str = ""

    @property
    def u(self) -> np.ndarray:  # noqa: D102
        return self.point.u

    @property
    def x(self) -> np.ndarray:
        """The states (n,)."""
        return self.point.u[:-1]

    @property
    def parameter(self) -> float:
        """The parameter's value."""
        return float(self.point.u[-1])

    @property
    def unstable(self) -> int:
        """How many eigenvalues have a positive real part."""
        return int((self.eigenvalues.real > 0).sum())

    @property
    def frequency(self) -> float:
        """Of the pair of complex eigenvalues nearest to the imaginary axis, rad per unit of time: at a Hopf point its own."""
        complex_ = self.eigenvalues[self.eigenvalues.imag > 0]
        return float(complex_[np.abs(complex_.real).argmin()].imag) if len(complex_) else 0.0


@dataclass(frozen=True, eq=False)
class Branch:
    """A branch that was followed to its ends. points: in order, special ones among them. ends: why it ends, at first and last.

    A closed branch has its first point once more as its last; then both sentences say so.
    """

    equations: Equations
    points: tuple[Equilibrium, ...]
    ends: tuple[str, str]

    @cached_property
    def u(self) -> np.ndarray:
        """States and parameter of all points (n+1, N)."""
        return np.array([p.u for p in self.points]).T

    @cached_property
    def unstable(self) -> np.ndarray:
        """How many eigenvalues of each point have a positive real part (N,)."""
        return np.array([p.unstable for p in self.points])

    @property
    def special(self) -> tuple[Equilibrium, ...]:
        """Folds, Hopf and branch points, and those of the user's functions."""
        return tuple(p for p in self.points if p.kind)

    @property
    def closed(self) -> bool:
        """Whether it returns to its first point, but for whole turns of angles."""
        return self.ends[0] == self.ends[1] == CLOSED


CLOSED = "it is closed"

_Found = list[Equilibrium]
_Last = Mapping[str, tuple[CurvePoint, float]]


@dataclass(frozen=True, eq=False)
class Equilibria:
    """Branches of the equilibria of equations with one varied parameter.

    equations: f(x, p). bounds: (low, high) of the parameter. steps: see ``Steps``. limits: of some states, by their index,
    beyond which a branch is not followed. functions: of u = (x, p) (n+1,), whose zeros are looked for, by name.
    """

    equations: Equations
    bounds: tuple[float, float]
    steps: Steps = field(default_factory=Steps)
    limits: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    functions: Mapping[str, UserFunction] = field(default_factory=dict)

    @cached_property
    def curve(self) -> Curve:
        """The problem as ``Curve`` follows it."""
        e = self.equations
        return Curve(Functions(e.values, e.scale, e.turns), {**self.limits, -1: self.bounds}, self.steps)

    def start(self, x: Sequence[float] | np.ndarray, value: float) -> CurvePoint:
        """The equilibrium near a state (n,) at a value of the parameter. Raises ``RunError`` where none is found."""
        up = np.zeros(self.equations.n + 1)
        up[-1] = self.equations.scale[-1]
        return self.curve.start(np.append(x, value), up)

    def walk(self, start: CurvePoint) -> Walk[Equilibrium]:
        """The points from a first one on, special ones among them, as they are asked for."""
        return Walk(self._walked(start))

    def branch(self, start: CurvePoint) -> Branch:
        """The whole branch through a point, followed both ways."""
        onward = self.walk(start)
        after = list(onward)
        if onward.end == CLOSED:
            return Branch(self.equations, (self.seen(start), *after), (CLOSED, CLOSED))
        backward = self.walk(self.curve.backwards(start))
        before = [_reversed(p) for p in backward][::-1]
        return Branch(self.equations, (*before, self.seen(start), *after), (backward.end, onward.end))

    def seen(self, point: CurvePoint) -> Equilibrium:
        """A point with its eigenvalues."""
        return Equilibrium(point, _eigenvalues(point.jacobian[:, :-1]))

    def _walked(self, start: CurvePoint) -> Generator[Equilibrium, None, str]:
        here, walk = self.seen(start), self.curve.follow(start)
        # Where a test function is lost in rounding its sign is that of the last point where it was not.
        last: _Last = {kind: (here.point, test(here)) for kind, test in self._tests.items()}
        for curve, point in walk:
            there = self.seen(point)
            found, last = self._between(curve, here, there, last, _HALVINGS)
            yield from found
            yield there
            here = there
        return walk.end

    @cached_property
    def _tests(self) -> Mapping[str, Callable[[Equilibrium], float]]:
        return {FOLD: _along_parameter, HOPF: _sums, **{n: _of_user(f) for n, f in self.functions.items()}}

    def _between(self, curve: Curve, here: Equilibrium, there: Equilibrium, last: _Last, halvings: int) -> tuple[_Found, _Last]:
        """The special points between two neighbours, and the test functions at the second.

        Where they do not account for the eigenvalues that have become unstable, or stable, two of a kind may have hidden each
        other: then both halves of the way are looked at.
        """
        found, now = list[Equilibrium | None](), dict(last)
        for kind, test in self._tests.items():
            value, (before, valued) = test(there), last[kind]
            if abs(value) > _ROUNDING:
                if value * valued < 0 and abs(valued) > _ROUNDING:
                    found.append(self._located(curve, before, there.point, kind, test))
                now[kind] = there.point, value
        if here.point.orientation * there.point.orientation < 0:
            found.append(self._branch_point(here.point, there.point))
        passed = sorted((p for p in found if p is not None), key=lambda p: p.point.length)
        if not halvings or _accounted(here, there, passed):
            return passed, now
        try:
            middle = self.seen(curve.between(here.point, there.point, 0.5))
        except RunError:
            return passed, now
        first, last = self._between(curve, here, middle, last, halvings - 1)
        second, last = self._between(curve, middle, there, last, halvings - 1)
        return [*first, *second], last

    def _located(
        self, curve: Curve, a: CurvePoint, b: CurvePoint, kind: str, test: Callable[[Equilibrium], float]
    ) -> Equilibrium | None:
        found = located(curve, a, b, self.seen, test)
        if found is None or (kind == HOPF and not critical_pairs(found.eigenvalues)[1]):
            return None
        return Equilibrium(found.point, found.eigenvalues, kind)

    def _branch_point(self, a: CurvePoint, b: CurvePoint) -> Equilibrium | None:
        try:
            found = branch_point(self.equations, a, b)
        except RunError:
            return None
        tangent = found.tangents[0]
        point = CurvePoint(found.u, tangent, found.jacobian, a.length + found.share * (b.length - a.length), 0)
        return Equilibrium(point, _eigenvalues(point.jacobian[:, :-1]), BRANCH_POINT)

    def switched(self, at: Equilibrium, step: float | None = None) -> tuple[CurvePoint, CurvePoint]:
        """The first points of the other branch through a branch point, one on either side. Raises ``RunError``."""
        found = BranchPoint.at(self.equations, at.u, at.point.tangent)
        other = found.tangents[1]
        distance = self.steps.first if step is None else step
        first, second = (self.curve.start(at.u + s * distance * other, s * other) for s in (1.0, -1.0))
        return first, second


def _reversed(equilibrium: Equilibrium) -> Equilibrium:
    p = equilibrium.point
    turned = CurvePoint(p.u, -p.tangent, p.jacobian, -p.length, -p.orientation)
    return Equilibrium(turned, equilibrium.eigenvalues, equilibrium.kind)


def _eigenvalues(matrix: np.ndarray) -> np.ndarray:
    from scipy.linalg.lapack import dgeev

    real, imaginary, _, _, _ = dgeev(matrix, compute_vl=0, compute_vr=0)
    return np.asarray(real + 1j * imaginary)


def _accounted(here: Equilibrium, there: Equilibrium, passed: Sequence[Equilibrium]) -> bool:
    """Whether as many eigenvalues may have passed the imaginary axis as do so at the points between two, or some lie on it."""
    change, most = abs(there.unstable - here.unstable), sum(_CROSSING.get(p.kind, 0) for p in passed)
    return (change <= most and (most - change) % 2 == 0) or _on_axis(here.eigenvalues) or _on_axis(there.eigenvalues)


def _on_axis(eigenvalues: np.ndarray) -> bool:
    return bool(np.abs(eigenvalues.real).min() <= _ON_AXIS * np.abs(eigenvalues).max())


def _along_parameter(equilibrium: Equilibrium) -> float:
    return float(equilibrium.point.tangent[-1])


def _sums(equilibrium: Equilibrium) -> float:
    """Zero where two eigenvalues add up to zero."""
    values = equilibrium.eigenvalues
    return float((values[0] + values[1]).real) if len(values) == 2 else critical_pairs(values)[0]


def _of_user(function: UserFunction) -> Callable[[Equilibrium], float]:
    return lambda equilibrium: float(function(equilibrium.u))
