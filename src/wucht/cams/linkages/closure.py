"""The common base of linkages between the follower's lever and the output: closure by a rod, and a law transmitted by it.

In the complex plane, with the lever's pivot at 0, the rod's ends are the lever's joint Q = arm e^(i alpha) and the output's
joint P(y): |P - Q| = rod. On one branch each of alpha and y follows from the other in closed form, by a quadratic equation, and
the derivatives from the closure by implicit differentiation. R. L. Norton, "Design of Machinery", McGraw-Hill, chapter 4.

Derivatives up to the third: those of a function, orders 0 to 3, are one array (4, ...).
"""

from __future__ import annotations

import cmath
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.cams.demands import format_degrees
from wucht.cams.laws import Law
from wucht.errors import InputError
from wucht.numerics.zeros_and_peaks import crossings

Limits = tuple[float, float]
_DEAD = 1e-6  # rad: nearer to a dead point no linkage is taken for a working one
_ROUNDING = 1e-9
_UNIT_DERIVATIVES = np.array([1, 1j, -1, -1j])  # the derivatives of e^(i alpha) by alpha, over e^(i alpha)
_GRID = 2048  # angles a turn, between which no law has two extremes


def composed_derivative(outer: np.ndarray, inner: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """The highest derivative of y(x(t)), of an order from 0 to 3: Faa di Bruno's formula.

    outer: of y by x (4, ...). inner: of x by t, up to the required order.
    """
    y, (_, *x) = outer, inner
    if not x:
        return np.asarray(y[0])
    if len(x) == 1:
        return np.asarray(y[1] * x[0])
    if len(x) == 2:
        return np.asarray(y[2] * x[0] ** 2 + y[1] * x[1])
    return np.asarray(y[3] * x[0] ** 3 + 3 * y[2] * x[0] * x[1] + y[1] * x[2])


def _constrained_derivatives(leader: np.ndarray, follower: np.ndarray) -> np.ndarray:
    """The derivatives y', y'', y''' (3, ...) by x for which |P(x) - Q(y(x))| stays the same.

    leader: of the point P by x, complex (4, ...). follower: of the point Q by y, complex (4, ...), not square to the rod.

    With D = P - Q it is D . D' = 0, D' . D' + D . D'' = 0 and 3 D' . D'' + D . D''' = 0; each is linear in the highest
    derivative of y.
    """
    P, Q = leader, follower
    D, grip = P[0] - Q[0], _dot(P[0] - Q[0], Q[1])
    y1 = _dot(D, P[1]) / grip
    D1 = P[1] - Q[1] * y1
    y2 = (_dot(D1, D1) + _dot(D, P[2] - Q[2] * y1**2)) / grip
    D2 = P[2] - Q[2] * y1**2 - Q[1] * y2
    y3 = (3 * _dot(D1, D2) + _dot(D, P[3] - Q[3] * y1**3 - 3 * Q[2] * y1 * y2)) / grip
    return np.stack([y1, y2, y3])


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The scalar product of vectors in the complex plane."""
    return np.asarray((np.conj(a) * b).real)


class Linkage(ABC):
    """A linkage between the lever's angle rho and the output psi, both zero in the reference position.

    There the lever is at ``angle`` (rad), and the output where the closure on the ``branch`` (+1 or -1) puts it. All
    angles are counter-clockwise. Dead points are of two kinds: where the rod cannot move the output, being in line with it or
    square to its slide, and where the rod is in line with the lever, and the output turns back. The lever can pass those of the
    second kind; a motion of the output cannot require it.
    """

    angle: float
    branch: int

    def lever_at(self, psi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative of rho by psi of an order from 0 to 3, at psi of any shape. Raises as ``lever_derivatives``."""
        return np.asarray(self.lever_derivatives(psi)[order])

    def output_at(self, rho: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative of psi by rho of an order from 0 to 3, at rho of any shape. Raises as ``output_derivatives``."""
        return np.asarray(self.output_derivatives(rho)[order])

    def lever_derivatives(self, psi: np.ndarray | float) -> np.ndarray:
        """rho and its first three derivatives by psi (4, ...). Raises ``InputError`` (linkage): out of reach."""
        _check_limits("output", psi, self.output_limits, self._format_output)
        y = self._reference_output + np.asarray(psi, float)
        alpha = self._lever_angle(y)
        slopes = _constrained_derivatives(self._output_joint(y), self._lever_joint(alpha))
        return np.concatenate([[alpha - self._reference_lever], slopes])

    def output_derivatives(self, rho: np.ndarray | float) -> np.ndarray:
        """psi and its first three derivatives by rho (4, ...). Raises ``InputError`` (linkage): out of reach."""
        alpha, y = self._position(rho)
        slopes = _constrained_derivatives(self._lever_joint(alpha), self._output_joint(y))
        return np.concatenate([[y - self._reference_output], slopes])

    def transmission_angle(self, rho: np.ndarray | float) -> np.ndarray:
        """Transmission angle from 0 (the rod cannot move the output) to pi/2 (all its force does), at rho of any shape.

        Of a four-bar between coupler and output, of a slider-crank between the rod and the normal of the slide. Raises
        ``InputError`` (linkage): out of reach.
        """
        alpha, y = self._position(rho)
        P = self._output_joint(y)
        along = np.conj(P[0] - self._lever_joint(alpha)[0]) * P[1]
        return np.asarray(np.arctan2(np.abs(along.real), np.abs(along.imag)))

    @cached_property
    def output_limits(self) -> Limits:
        """psi stays between the dead points, of either kind, next to 0; infinite where the output can turn round and round."""
        dead_outputs = [y for alpha, y in self._dead_positions() if self._lean(alpha, y) * self._side > -_ROUNDING]
        return _limits_around(self._reference_output, [*dead_outputs, *self._reversal_outputs()], self._period)

    @cached_property
    def lever_limits(self) -> Limits:
        """rho stays between the dead points next to 0 where the rod cannot move the output; infinite where the lever turns."""
        return _limits_around(self.angle, [alpha for alpha, _ in self._dead_positions()], 2 * math.pi)

    @cached_property
    def _reference_output(self) -> float:
        return float(self._output_position(np.asarray(self.angle)))

    @cached_property
    def _reference_lever(self) -> float:
        """The input angle, in the turn in which the output's position puts it."""
        near = float(self._lever_angle(np.asarray(self._reference_output)))
        return self.angle + 2 * math.pi * round((near - self.angle) / (2 * math.pi))

    @cached_property
    def _side(self) -> float:
        """Side of the line from its pivot to the output's joint on which the lever is: between dead points it stays there."""
        return math.copysign(1.0, self._lean(self.angle, self._reference_output))

    def _position(self, rho: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """alpha and y at rho."""
        _check_limits("lever", rho, self.lever_limits, format_degrees)
        alpha = self.angle + np.asarray(rho, float)
        return alpha, self._output_position(alpha)

    def _lever_joint(self, alpha: np.ndarray) -> np.ndarray:
        """Q and its derivatives by alpha (4, ...)."""
        return np.asarray(np.multiply.outer(_UNIT_DERIVATIVES, self._arm * np.exp(1j * alpha)))

    def _lever_angle(self, y: np.ndarray) -> np.ndarray:
        """alpha; it does not jump where y does not."""
        reach = np.abs(self._output_joint(y)[0])
        return np.asarray(self._direction(y) + self._side * corner(reach, self._arm, self._rod))

    def _lean(self, alpha: float, y: float) -> float:
        """The sine of the lever's angle against the line to the output's joint."""
        w = complex(self._output_joint(np.asarray(y))[0])
        return float((w.conjugate() * cmath.exp(1j * alpha)).imag / (abs(w) or 1.0))

    def _check_reference(self) -> None:
        """Raise ``InputError`` (linkage.angle) where the reference position is a dead point."""
        y = np.asarray(self._reference_output)
        P, Q = self._output_joint(y), self._lever_joint(np.asarray(self.angle))
        grips = [abs((np.conj(P[0] - Q[0]) * tangent).real) / (self._rod * abs(tangent)) for tangent in (P[1], Q[1])]
        if min(grips) < _DEAD:
            line = "the rod cannot move the output" if grips[0] < grips[1] else "the rod is in line with the lever"
            raise InputError("linkage.angle", format_degrees(self.angle), f"must not be a dead point: {line}")

    @property
    @abstractmethod
    def _arm(self) -> float:
        """Arm of the lever in m."""

    @property
    @abstractmethod
    def _rod(self) -> float:
        """Length of the rod in m."""

    @property
    @abstractmethod
    def _period(self) -> float:
        """Period of the output: 2 pi or infinite."""

    @abstractmethod
    def _output_joint(self, y: np.ndarray) -> np.ndarray:
        """P and its derivatives by y (4, ...)."""

    @abstractmethod
    def _direction(self, y: np.ndarray) -> np.ndarray:
        """The angle of P; it does not jump where y does not."""

    @abstractmethod
    def _output_position(self, alpha: np.ndarray) -> np.ndarray:
        """y on the branch; it does not jump where alpha does not."""

    @abstractmethod
    def _dead_positions(self) -> Iterable[tuple[float, float]]:
        """alpha and y of all positions in which the rod cannot move the output."""

    @abstractmethod
    def _reversal_outputs(self) -> Iterable[float]:
        """y of all positions in which the rod is in line with the lever."""

    @staticmethod
    @abstractmethod
    def _format_output(psi: float) -> str:
        """Return an output value with its unit."""


def corner(a: np.ndarray, b: float, opposite: float) -> np.ndarray:
    """The angle between the sides a and b of a triangle, 0 or pi where it does not close.

    W. Kahan, "Miscalculating Area and Angles of a Needle-like Triangle" (2014): a cosine would lose half of the digits near 0.
    """
    near, far = (opposite - a + b) * (opposite + a - b), (a + b - opposite) * (a + b + opposite)
    return np.asarray(2 * np.arctan2(np.sqrt(np.maximum(near, 0)), np.sqrt(np.maximum(far, 0))))


def check_parameters(lengths: dict[str, float], angle: float, branch: int) -> None:
    """Raise ``InputError`` (linkage.KEY) for invalid lengths in m or angles, or a branch that is not +1 or -1."""
    for key, length in lengths.items():
        if not (math.isfinite(length) and length > 0):
            raise InputError(f"linkage.{key}", length, "must be a length greater than 0 m")
    if not math.isfinite(angle):
        raise InputError("linkage.angle", angle, "must be a finite angle")
    if branch not in (-1, +1):
        raise InputError("linkage.branch", branch, "must be +1 (open) or -1 (crossed)")


def _limits_around(value: float, dead: Iterable[float], period: float) -> Limits:
    """Return the distances from a value to the next dead points below and above it; infinite where there are none."""
    gaps = np.array(list(dead)) - value
    # With an infinite period one above is infinitely far below, and the other way round.
    below, above = -np.mod(-gaps, period), np.mod(gaps, period)
    return float(below.max(initial=-math.inf)), float(above.min(initial=math.inf))


def _check_limits(member: str, positions: np.ndarray | float, limits: Limits, format_value: Callable[[float], str]) -> None:
    low, high = limits
    values = np.ravel(positions)
    beyond = values[~((values > low) & (values < high))]
    if len(beyond):
        worst = float(beyond[np.argmax(np.maximum(low - beyond, beyond - high))])
        requirement = (
            f"the {member} must stay between {format_value(low)} and {format_value(high)}, where the linkage has dead points"
        )
        raise InputError("linkage", format_value(worst), requirement)


@dataclass(frozen=True, eq=False)
class LeverMotion:
    """The lever's motion rho(phi), a law, that makes the output move by a law psi(phi).

    Raises ``InputError`` (linkage) where the output would reach a dead point: that psi, and the range it must stay in.
    """

    law: Law
    linkage: Linkage

    def __post_init__(self) -> None:
        self.linkage.lever_derivatives(_extremes(self.law))

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles in rad of any shape."""
        return _chained_derivative(self.linkage.lever_derivatives, self.law, phi, order)

    def transmission_angle(self, phi: np.ndarray | float) -> np.ndarray:
        """Return the transmission angle of the linkage (``Linkage.transmission_angle``), at cam angles of any shape."""
        return self.linkage.transmission_angle(self(phi))


def _chained_derivative(
    derivatives: Callable[[np.ndarray], np.ndarray], law: Law, phi: np.ndarray | float, order: int
) -> np.ndarray:
    inner = [law(phi, n) for n in range(order + 1)]
    return composed_derivative(derivatives(inner[0]), inner)


def _extremes(law: Law) -> np.ndarray:
    """The values of a law on a grid and where its velocity changes its sign in between."""
    grid = np.linspace(0, 2 * math.pi, _GRID + 1)
    return law(np.concatenate([grid, crossings(lambda phi: law(phi, 1), grid)]))
