"""The table [shaft] of a cam file: what turns, what drives it, and how stiff it is."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from wucht.fields import Described, si


class ShaftTable(Described):
    """inertia: of what turns with the cam; output_inertia: of what moves with the output. mean_speed: instead of a drive, the
    eigenmotion; with one where it is expected."""

    inertia: float = si("kg m^2", "moment of inertia", gt=0)
    output_inertia: float | None = si("kg m^2", "moment of inertia of the output", default=None, ge=0)
    output_mass: float | None = si("kg", "mass of the output", default=None, ge=0)
    mean_speed: float | None = si("rad/s", "mean speed", default=None, gt=0)

    @classmethod
    def where(cls) -> str:
        """In a file."""
        return "shaft"

    @model_validator(mode="after")
    def _one_output(self) -> Self:
        if (self.output_inertia is None) == (self.output_mass is None):
            raise ValueError("output_inertia", "needed is the output_inertia of an output that turns, or the output_mass")
        return self
