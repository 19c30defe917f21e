"""Positions of an output that turns (rad) or slides (m): which of both is known from the drive, or from the units given."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import BeforeValidator

from wucht.checking import read_quantity
from wucht.errors import InputError
from wucht.quantities import Unit

UNITS = {"rad": Unit("rad", "angle of the output"), "m": Unit("m", "displacement of the output")}
_BY_ANGLE = re.compile(r"\s*/\s*rad(?:\s*\^\s*[23])?\s*$")  # a derivative by the cam angle: mm/rad^2


def _is_position(given: Any) -> Any:
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise ValueError("must be a number, or a string with a unit of angle or length")
    return given


Position = Annotated[float | str, BeforeValidator(_is_position)]  # in the unit of the output


def without_angle(given: float | str) -> float | str:
    """A quantity without the cam angle that it is divided by."""
    return _BY_ANGLE.sub("", given) if isinstance(given, str) else given


def unit_of_output(given: Iterable[tuple[str, float | str]], known: str | None) -> str:
    """``rad`` or ``m``. given: quantities and where they stand. known: what the linkage or the follower says.

    Raises ``InputError`` where a quantity has another unit. Bare numbers are in rad where nothing says so.
    """
    unit = known
    for where, one in given:
        bare = without_angle(one)
        if unit is None and isinstance(bare, str):
            unit = next((u for u, described in UNITS.items() if _reads(described, bare)), None)
            if unit is None:
                raise InputError(where, one, "must be an angle or a length, such as '24 deg' or '10 mm'")
        if unit is not None:
            read_quantity(UNITS[unit], bare, where)
    return unit or "rad"


def _reads(unit: Unit, given: str) -> bool:
    try:
        unit.parse(given)
    except ValueError:
        return False
    return any(c.isalpha() or c == "°" for c in given)
