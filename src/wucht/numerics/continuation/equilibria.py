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
from wucht.numerics.continuation.special_points import located

FOLD, HOPF, BRANCH_POINT = "fold", "hopf", "branch-point"

_ROUNDING = 1e-10  # a test function that is smaller says nothing

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
        tests = {FOLD: _along_parameter, HOPF: _sums, **{n: _of_user(f) for n, f in self.functions.items()}}
        # Where a test function is lost in rounding its sign is that of the last point where it was not.
        last = {kind: (here.point, test(here)) for kind, test in tests.items()}
        for curve, point in walk:
            there, found = self.seen(point), list[Equilibrium | None]()
            for kind, test in tests.items():
                value, (before, valued) = test(there), last[kind]
                if abs(value) > _ROUNDING:
                    if value * valued < 0 and abs(valued) > _ROUNDING:
                        found.append(self._located(curve, before, point, kind, test))
                    last[kind] = point, value
            if here.point.orientation * point.orientation < 0:
                found.append(self._branch_point(here.point, point))
            yield from sorted((p for p in found if p is not None), key=lambda p: p.point.length)
            yield there
            here = there
        return walk.end

    def _located(
        self, curve: Curve, a: CurvePoint, b: CurvePoint, kind: str, test: Callable[[Equilibrium], float]
    ) -> Equilibrium | None:
        found = located(curve, a, b, self.seen, test)
        if found is None or (kind == HOPF and not _has_crossing_pair(found.eigenvalues)):
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


def _along_parameter(equilibrium: Equilibrium) -> float:
    return float(equilibrium.point.tangent[-1])


def _sums(equilibrium: Equilibrium) -> float:
    """The product of the sums of all two eigenvalues, each in terms of their sizes: zero where a pair is imaginary."""
    values = equilibrium.eigenvalues
    n = len(values)
    if n == 2:
        return float((values[0] + values[1]).real)
    if n < 2:
        return 1.0
    i, j = np.triu_indices(n, 1)
    sizes = np.abs(values)
    sums, size = values[i] + values[j], sizes[i] + sizes[j]
    return float(np.prod(sums / np.where(size > 0, size, 1.0)).real)


def _has_crossing_pair(values: np.ndarray) -> bool:
    """Whether those two eigenvalues whose sum is nearest to zero are a complex pair, not two real ones of opposite signs."""
    i, j = np.triu_indices(len(values), 1)
    k = np.abs(values[i] + values[j]).argmin()
    return bool(values[i[k]].imag != 0)


def _of_user(function: UserFunction) -> Callable[[Equilibrium], float]:
    return lambda equilibrium: float(function(equilibrium.u))
