"""The rating of the rolling bearing that carries a rotor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import model_validator

from wucht.schema import SI, TableModel, si

_OF_ROLLERS = "10/3"


class Bearing(TableModel):
    """Rating of a rolling bearing by ISO 281: its life in 10^6 revolutions is (C/P)^p.

    The bearing takes ``share`` of the force of its rotor, with the bodies about it, on the carrier.
    """

    C: SI[float] = si("N", "basic dynamic load rating", "C", gt=0, help="basic dynamic radial load rating, from the catalogue")
    p: SI[float] = si("", "exponent of the life", "p", default=3.0, ge=1, le=10, help=(
        "exponent of the life: 3 of ball bearings, \"10/3\" of roller bearings"
    ))  # fmt: skip
    share: SI[float] = si("", "share of the rotor's force", "s", default=1.0, gt=0, le=1, help=(
        "share of the rotor's force that the bearing takes: 0.5 of each of two in the same distance from its centre of mass"
    ))  # fmt: skip

    @model_validator(mode="before")
    @classmethod
    def _read_fraction(cls, raw: Any) -> Any:
        """Accept the exponent of roller bearings as it is printed."""
        if isinstance(raw, Mapping) and isinstance(p := raw.get("p"), str) and p.replace(" ", "") == _OF_ROLLERS:
            return {**raw, "p": 10 / 3}
        return raw
