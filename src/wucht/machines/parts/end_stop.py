"""The end stop: a buffer that the carrier meets after a gap."""

from __future__ import annotations

from typing import Literal

import sympy as sp
from pydantic import Field

from wucht.machines.parts.attachment import LineAttachment
from wucht.machines.parts.base import SI, Frame, si
from wucht.machines.parts.stop import buffer, contact_indicator
from wucht.mechanics.energies import AppliedForce, Energies
from wucht.piecewise import CLAMP_TO_ONE, PiecewiseCubic

TRANSITION = 1e-3  # m/s: below any speed of impact of interest


class EndStop(LineAttachment):
    """A spring that the carrier meets after a gap in the direction of its line, or against it, too.

    Its loss is viscous (``damping``), or of the kind of friction, in proportion to the spring's
    force (``restitution`` e): c d (1 + e^2)/2 at the depth d, and c d (1 - e^2)/2 against the motion. So whatever mass meets
    it at whatever speed, far above ``transition_speed``, leaves with e times that speed: the area of that loop is (1 - e^2)
    c d^2/2. The force always pushes, other than that of a viscous damper at the end of a contact.
    """

    kind = "end-stop"

    gap: SI[float] = si("m", "gap", "s", ge=0, help="gap between the carrier and the spring, counted from `rest`")
    stiffness: SI[float] = si("N/m", "stiffness", "c", gt=0, help="stiffness of the spring behind the gap")
    damping: SI[float | None] = si(
        "N s/m", "damping", "b", default=None, ge=0, help="viscous damping of the stop; or `restitution`"
    )
    restitution: SI[float | None] = si("", "coefficient of restitution", "e_c", default=None, ge=0.01, le=1, help=(
        "coefficient of restitution: the speed after a contact over that before it"
    ))  # fmt: skip
    sides: Literal["one", "both"] = Field(default="one", description='sides of the stop; `"both"`: against its line, too')
    rest: SI[float] = si("m", "displacement along the line at which the gap is measured", "s_0", default=0.0, help=(
        "displacement along the line at which the gap is measured: 0 where the carrier's springs are free of force"
    ))  # fmt: skip
    transition_speed: SI[float] = si(
        "m/s", "speed of the transition where the motion reverses", "v_c", default=TRANSITION, gt=0
    )

    def check(self) -> None:
        """Check that one of damping and restitution is given."""
        if (self.damping is None) == (self.restitution is None):
            raise ValueError("restitution", "give either damping or restitution (1: nothing is lost)")

    def doubts_at(self, rest: float) -> tuple[str, ...]:
        """Return a warning for a stop that is closed at rest."""
        displacement = rest - self.rest
        depth = (displacement if self.sides == "one" else abs(displacement)) - self.gap
        if depth <= 0:
            return ()
        at = f"the carrier rests at {rest:.4g} m along this line, and the gap counts from rest = {self.rest:.4g} m"
        return (f"the end stop {self.name!r} is closed by {depth:.4g} m from the start: {at}",)

    def energies(self, frame: Frame) -> Energies:
        """While the gap is closed: V = c d^2/2 and R = b d'^2/2, or the law of the class."""
        gap, rest = self.symbols("gap", "rest")
        s, v = self.line_motion(frame)
        sides = [(gap - (s - rest), -v), (gap + (s - rest), v)][: 1 if self.sides == "one" else 2]
        label = Energies(nonlinear=f"the end stop {self.name!r}")
        return sum((self._side(*side) for side in sides), label)

    def _side(self, gap: sp.Expr, rate: sp.Expr) -> Energies:
        c, b, e, transition = self.symbols("stiffness", "damping", "restitution", "transition_speed")
        if self.restitution is None:
            return buffer(gap, rate, c, b)
        loss = contact_indicator(gap) * (1 - e**2) / 2 * c * gap * PiecewiseCubic(rate / transition, CLAMP_TO_ONE)
        elastic = buffer(gap, rate, (1 + e**2) / 2 * c, sp.S.Zero)
        return elastic + Energies(applied_forces=(AppliedForce(loss, rate, self.path, energy_side="lost"),))
