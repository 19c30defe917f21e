"""The load with a measured characteristic."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Load, Parameter, si
from wucht.machines.parts.characteristic import Points, curve
from wucht.machines.parts.coulomb_load import TRANSITION
from wucht.piecewise import PiecewiseCubic
from wucht.schema import Composite


class TableLoad(Load):
    """torque = a monotone cubic through measured points (speed, torque); beyond them the torque of the first or last one.

    Points of negative speed are taken as they are, their torque being negative where it resists. Where there is none, the load
    is odd: torque(-speed) = -torque(speed). A curve that then begins at speed 0 with a torque T_0 would jump there: T_0 becomes
    a dry friction, T_0 tanh(speed/transition_speed), as in the kind "coulomb", and the curve goes on from it. A curve that
    begins at a positive speed is led through zero at standstill.

    In a study file the points are given by ``file``, or inline as ``points``; they are no parameters.
    """

    kind = "table"

    points: Composite[Points]
    transition_speed: SI[float] = si("rad/s", "speed of the transition at standstill", "w_c", default=TRANSITION, gt=0)

    def friction(self) -> float:
        """Return the torque T_0 in N m with which the curve begins at speed 0."""
        speed, torque = self.points[0]
        return torque if speed == 0 else 0.0

    def odd_points(self) -> tuple[tuple[float, float], ...]:
        """Return the points without the dry friction, mirrored if none has a negative speed."""
        if self.points[0][0] < 0:
            return self.points
        above = tuple((w, t - self.friction()) for w, t in self.points)
        return (*((-w, -t) for w, t in reversed(above) if w > 0), *above)

    def parameters(self) -> tuple[Parameter, ...]:
        """The speed of the transition, where there is one."""
        return super().parameters() if self.friction() else ()

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """The curve, and the dry friction with which it begins."""
        rest = PiecewiseCubic(speed, curve(f"{self.path}.torque", self.odd_points()))
        return rest + self.friction() * sp.tanh(speed / self.symbol("transition_speed")) if self.friction() else rest
