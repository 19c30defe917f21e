"""The carrier that only turns: 001, Bild 1b."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Literal, Self

import sympy as sp
from pydantic import Field

from wucht.errors import FieldError
from wucht.machines.parts.base import SI, Body, Frame, si
from wucht.machines.parts.support import NO_TUNING, Inertia, Support, refuse_rotation_both_ways, tuned_rotation, tuning_text
from wucht.mechanics.energies import Energies


class RockingCarrier(Support):
    """A body on a torsion spring and damper.

    With rotors that have a couple unbalance it turns about an axis across theirs, 001 (10)-(11); their share of its inertia
    is taken as constant and belongs into ``inertia``. Otherwise it turns about the normal of the rotors' plane, and they act
    through their positions.
    """

    kind = "carrier-r"

    directions: Literal["r"] = Field(default="r", description="directions in which the carrier moves: it turns")
    mass: SI[float] = si("kg", "mass (it rests: the carrier only turns)", "m", default=0.0, ge=0)
    inertia: SI[float] = si("kg m^2", "moment of inertia about the axis of turning", "Theta", gt=0, help=(
        "moment of inertia about the axis of turning, with the share of rotors that have a couple unbalance"
    ))  # fmt: skip
    rotation_stiffness: SI[float | None] = si(
        "N m", "rotation stiffness", "c_r", default=None, ge=0, help="torsion spring's stiffness"
    )
    rotation_damping: SI[float] = si(
        "N m s", "rotation damping", "b_r", default=0.0, ge=0, help="viscous damping of the rotation"
    )
    rotation_frequency: SI[float | None] = si(
        "rad/s", "natural frequency of the rotation with all bodies on it", default=None, ge=0
    )
    rotation_damping_ratio: SI[float | None] = si("", "damping ratio of the rotation with all bodies on it", default=None, ge=0)
    tilting: bool = Field(default=False, exclude=True)

    def check(self) -> None:
        """Check that a free carrier has a spring."""
        self.check_motion()
        if self.rotation_stiffness is None and self.rotation_frequency is None and self.motion is None:
            raise FieldError("rotation_stiffness", "this key is missing; give the rotation stiffness in N m", code="missing")
        refuse_rotation_both_ways(self)

    def tune_springs(self, inertia: Inertia) -> tuple[Self, str]:
        """See ``Support``."""
        tuning, total_inertia = tuned_rotation(self, inertia), inertia("r")
        note = f"carrier: {tuning_text(tuning, f'{total_inertia:.6g} kg m^2')}" if tuning else ""
        return self.model_copy(update=tuning | NO_TUNING), note

    def check_body(self, body: Body) -> None:
        """Accept bodies anywhere on it, with a couple unbalance too."""

    def with_bodies(self, bodies: Iterable[Body]) -> Self:
        """Return the carrier; it tilts with a couple unbalance on it."""
        return self.model_copy(update={"tilting": any(b.couple() is not None for b in bodies)})

    def reference_frame(self) -> Frame:
        """Return the frame at the axis of turning, about which it turns or tilts."""
        frame = super().reference_frame()
        return replace(frame, rotation=sp.S.Zero, tilt=frame.rotation) if self.tilting else frame

    def energies(self, frame: Frame) -> Energies:
        """T = Theta chi'^2/2, V = c chi^2/2, R = b chi'^2/2: 001 (11)."""
        (r,) = self.coordinates()
        inertia, b = self.symbols("inertia", "rotation_damping")
        c = self.symbol("rotation_stiffness") if self.rotation_stiffness is not None else sp.S.Zero
        return Energies(inertia * r.velocity**2 / 2, c * r.position**2 / 2, b * r.velocity**2 / 2)
