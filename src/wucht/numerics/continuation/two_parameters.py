"""Special equilibria in two parameters, and their curves: what folds and Hopf points have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.normal_forms import bogdanov_takens_form
from wucht.numerics.continuation.problem import CurvePoint, Problem
from wucht.numerics.continuation.special_curves import BOGDANOV_TAKENS, Followed, Watch, bounds_of, refuse_other_than


@dataclass(frozen=True, eq=False)
class SpecialEquilibrium(ABC):
    """A point of such a curve.

    point: u = (x, p, q) (n+2,), and what other unknowns the curve has, with tangent and derivatives. kind: ``""`` of a regular
    point.
    """

    equations: Equations
    point: CurvePoint
    kind: str = ""

    @property
    def u(self) -> np.ndarray:
        """States and both parameters (n+2,)."""
        return self.point.u[: self.equations.n + 2]

    @property
    def x(self) -> np.ndarray:
        """The states (n,)."""
        return self.u[:-2]

    @property
    def parameters(self) -> np.ndarray:
        """Both (2,)."""
        return self.u[-2:]

    @cached_property
    def coefficients(self) -> Mapping[str, float]:
        """Of the normal form, at a Bogdanov-Takens point its a and b: see ``normal_forms``."""
        if self.kind == BOGDANOV_TAKENS:
            takens = bogdanov_takens_form(self.equations, self.u)
            return {"a": takens.a, "b": takens.b}
        return self._coefficients()

    @abstractmethod
    def _coefficients(self) -> Mapping[str, float]: ...


P = TypeVar("P", bound=SpecialEquilibrium)


@dataclass(frozen=True, eq=False)
class SpecialCurve(Followed[P]):
    """A curve of special equilibria in two parameters."""

    @cached_property
    def u(self) -> np.ndarray:
        """States and both parameters of all points (n+2, N)."""
        return np.array([p.u for p in self.points]).T

    @property
    def parameters(self) -> np.ndarray:
        """Both parameters of all points (2, N)."""
        return self.u[-2:]


@dataclass(frozen=True, eq=False)
class SpecialCurves(ABC, Generic[P]):
    """Curves of special equilibria of equations with two varied parameters (p, q).

    equations: f(x, (p, q)). bounds: (low, high) of both. steps: see ``Steps``. limits: of some states, by their index, beyond
    which a curve is not followed.
    """

    equations: Equations
    bounds: Sequence[tuple[float, float]]
    steps: Steps = field(default_factory=Steps)
    limits: Mapping[int, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse_other_than(2, self.equations)
        bounds_of(self.equations, self.limits)

    def curve(self, u: np.ndarray) -> Curve:
        """The problem as ``Curve`` follows it, written for the neighbourhood of a point u of it."""
        bounds = bounds_of(self.equations, self.limits, *self.bounds)
        return Curve(self._problem(u), bounds, self.steps, names=self.equations.names)

    def walk(self, start: CurvePoint) -> Walk[P]:
        """The points from a first one on, special ones among them, as they are asked for."""
        curve, first = self._written(start)
        return self._watch(curve).walk(curve, first)

    def branch(self, start: CurvePoint) -> SpecialCurve[P]:
        """The whole curve through a point, followed both ways."""
        curve, first = self._written(start)
        return SpecialCurve(self.equations, *self._watch(curve).followed(curve, first))

    def _written(self, start: CurvePoint) -> tuple[Curve, CurvePoint]:
        """The null vectors as this border has them, so that no sign jumps at the first step."""
        curve = self.curve(start.u)
        return curve, replace(start, jacobian=curve.problem.residual(start.u)[1])

    @abstractmethod
    def _problem(self, u: np.ndarray) -> Problem: ...

    @abstractmethod
    def _watch(self, curve: Curve) -> Watch[P]: ...
