"""The drive with a measured characteristic."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import Drive
from wucht.machines.parts.characteristic import Points, curve
from wucht.piecewise import PiecewiseCubic


class TableDrive(Drive):
    """torque = a monotone cubic through measured points (speed, torque); beyond them the torque of the first or last one.

    In a study file the points are given by ``file``, or inline as ``points``; they are no parameters.
    """

    kind = "table"

    points: Points

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """The curve."""
        return PiecewiseCubic(speed, curve(f"{self.path}.torque", self.points))
