"""The drive whose torque falls linearly with speed."""

from __future__ import annotations

from typing import ClassVar

from wucht.machines.parts.base import Drive, Frame, si
from wucht.mechanics.energies import Applied, Energies


class LinearDrive(Drive):
    """torque = slope (no_load_speed - speed): 002 (3.27), (4.5)."""

    kind: ClassVar[str] = "linear"

    slope: float = si("N m s", "slope of the torque over speed", "U", ge=0)
    no_load_speed: float = si(
        "rad/s",
        "no-load speed",
        "omega",
    )

    def energies(self, frame: Frame) -> Energies:
        """The motor's torque on the body's speed."""
        slope, no_load = self.symbols("slope", "no_load_speed")
        speed = frame.speed(self.on)
        return Energies(applied=(Applied(slope * (no_load - speed), speed, name=self.path),))
