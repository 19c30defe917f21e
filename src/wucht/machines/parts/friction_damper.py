"""The friction damper between the carrier and the ground, as under the tub of a washing machine."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.attachment import LineAttachment
from wucht.machines.parts.base import SI, Frame, si
from wucht.mechanics.energies import AppliedForce, Energies, InternalState, StateDescription
from wucht.piecewise import Pieces, PiecewiseCubic

BUILD_UP = 2e-4  # m: yield of a lining of foam and its seat, small against the strokes of such dampers


class FrictionDamper(LineAttachment):
    """Dry friction along a line, by Dahl's law, with free travel if it has one.

    The lining is drawn along by z, until it slips: z' = v - |v| f/F, where f = F z/d is its force on the carrier, d being
    ``build_up``. So the force is F against the motion, it holds the carrier where less than F pulls, and turns over within a
    few d after a reversal, at any frequency: P. R. Dahl, "A solid friction model", Aerospace Corporation, TOR-158 (1968). With
    ``free_travel`` g the lining moves freely within -g < z < g, and has its force beyond. At a stroke +-a one cycle takes
    4 F (a - g - d tanh((a - g)/d)): 4 F a where g = 0 and d is small. Before the start the lining is in the middle.
    """

    kind = "friction-damper"
    internal_states = (StateDescription("lining", "m", "lining travel", "z"),)

    force: SI[float] = si("N", "friction force", "F", ge=0, help="friction force of the lining that slips")
    build_up: SI[float] = si("m", "travel over which the force builds up", "d", default=BUILD_UP, gt=0)
    free_travel: SI[float | None] = si("m", "free travel to either side", "Delta", default=None, ge=0)

    def energies(self, frame: Frame) -> Energies:
        """V = F y^2/(2 d), the loss f (v - z') = f^2 |v|/F, with f = F y/d; y: the part of z beyond the free travel."""
        force, build_up, travel = self.symbols("force", "build_up", "free_travel")
        _, v = self.line_motion(frame)
        (lining_state,) = self.internal_states
        z = lining_state.at(self.path)
        y = z if self.free_travel is None else _positive_part(z - travel) - _positive_part(-z - travel)
        f, size = force * y / build_up, build_up if self.free_travel is None else build_up + travel
        lining = InternalState(z, v - PiecewiseCubic(v, _MAGNITUDE) * y / build_up, lining_state, size)
        return Energies(
            potential=force * y**2 / (2 * build_up),
            applied_forces=(
                AppliedForce(-f, v, self.path, energy_side="lost"),
                AppliedForce(f, lining.change, self.path, energy_side="lost"),
            ),
            internal_states=(lining,),
            nonlinear=f"the dry friction of {self.name!r}",
        )


_MAGNITUDE = Pieces("abs", (0.0,), ((0, -1, 0, 0), (0, 1, 0, 0)))
_POSITIVE = Pieces("beyond", (0.0,), ((0, 0, 0, 0), (0, 1, 0, 0)))


def _positive_part(x: sp.Expr) -> sp.Expr:
    return PiecewiseCubic(x, _POSITIVE)
