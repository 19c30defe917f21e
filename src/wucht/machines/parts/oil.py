"""Oil around the balls of a track, from which their damping follows.

A ball of radius r that rolls between the side walls of its race, with a gap d to each, is dragged by F = 6 pi eta r K v.
One wall gives K_1 = (8/15 + 64/375 d/r) ln(2 r/d) + 0.58461 (M. E. O'Neill, K. Stewartson, On the slow motion of a sphere
parallel to a nearby plane wall, J. Fluid Mech. 27 (1967) 705-724; within 2 % of the exact values of A. J. Goldman, R. G. Cox,
H. Brenner, Chem. Eng. Sci. 22 (1967) 637-651, up to d/r = 0.13, 10 % too small at 0.5). What two walls add is about the sum
of what each adds alone (C. W. Oseen, Hydrodynamik, 1927): K = 2 K_1 - 1. The spin of the ball and the film at the outer race
are left out. With v = (R - r) times the slip the damping is beta = 6 pi eta r K (R - r)^2.

This is the drag of a slow ball. That of a fast one grows with the square of its speed, c_D rho pi r^2 v^2/2 with c_D = 0.44
(Newton's drag of a sphere; H. Schlichting, Boundary-Layer Theory, figure 1.5).
"""

from __future__ import annotations

import math

from wucht.machines.parts.base import SI, si
from wucht.machines.parts.nameplate import Nameplate

WIDEST = 0.5  # of the ball's radius: a gap at which the drag is a tenth too small
_FORM_DRAG = 0.44


class Oil(Nameplate):
    """Oil between balls and the side walls of their race."""

    viscosity: SI[float] = si("Pa s", "dynamic viscosity", "eta", gt=0, help=(
        "dynamic viscosity at the temperature of operation: 1 cSt at 950 kg/m^3 is 0.95 mPa s"
    ))  # fmt: skip
    gap: SI[float] = si("m", "gap", "d", gt=0, help="gap between the ball and each side wall of its race")
    density: SI[float] = si("kg/m^3", "density", "rho", default=950.0, gt=0, help=(
        "density, for the slip up to which the damping holds; silicone oils have 950 kg/m^3"
    ))  # fmt: skip

    def drag(self, radius: float) -> float:
        """Return the drag of a ball over its speed, in N s/m. radius: of the ball, in m."""
        gap = self.gap / radius
        one_wall = (8 / 15 + 64 / 375 * gap) * math.log(2 / gap) + 0.58461
        return 6 * math.pi * self.viscosity * radius * (2 * one_wall - 1)

    def fastest(self, radius: float) -> float:
        """Return the speed of a ball in m/s at which the drag of its shape is as large as that of the viscous oil."""
        return self.drag(radius) / (_FORM_DRAG * self.density * math.pi * radius**2 / 2)
