"""Positions of an output that turns (rad) or slides (m): which of both is known from the drive, or from the units given."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import BeforeValidator

from wucht.errors import InputError
from wucht.schema import Unit, article, read_quantity

UNITS = {"rad": Unit("rad", "angle of the output"), "m": Unit("m", "displacement of the output")}
_BY_ANGLE = re.compile(r"\s*/\s*rad(?:\s*\^\s*([23]))?\s*$")  # a derivative by the cam angle: mm/rad^2
_OF_SEVERAL = re.compile(r"[^\W\d_]\s*[*/^\s]\s*[^\W_]")  # units: an angle has none, so that deg/rad^3 would be one too


def _is_position(given: Any) -> Any:
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise ValueError("must be a number, or a string with a unit of angle or length")
    return given


Position = Annotated[float | str, BeforeValidator(_is_position)]  # in the unit of the output


def read_output(unit: str, given: float | str, where: str, order: int = 0) -> float:
    """A position of the output in rad or m, or its derivative of an order by the cam angle, which its unit may say or not.

    Raises ``InputError``.
    """
    bare, told = _without_angle(given)
    if told not in (0, order) or (isinstance(bare, str) and _OF_SEVERAL.search(bare)):
        by_angle = ("", ", or that per rad", ", or that per rad^2", ", or that per rad^3")[order]
        example = {"rad": "24 deg", "m": "10 mm"}[unit] + ("", "/rad", "/rad^2", "/rad^3")[order]
        raise InputError(where, given, f"must be {article(UNITS[unit].what)}{by_angle}, such as {example!r}")
    return read_quantity(UNITS[unit], bare, where)


def _without_angle(given: float | str) -> tuple[float | str, int]:
    """A quantity without the cam angle that it is divided by, and by which power of it."""
    found = _BY_ANGLE.search(given) if isinstance(given, str) else None
    if found is None or not isinstance(given, str):
        return given, 0
    return given[: found.start()], int(found[1] or 1)


def unit_of_output(given: Iterable[tuple[str, float | str]], known: str | None) -> str:
    """``rad`` or ``m``. given: quantities and where they stand. known: what the linkage or the follower says.

    Raises ``InputError`` where a quantity has another unit. Bare numbers are in rad where nothing says so.
    """
    unit = known
    for where, one in given:
        bare, _ = _without_angle(one)
        if unit is None and isinstance(bare, str):
            unit = next((u for u, described in UNITS.items() if _reads(described, bare)), None)
            if unit is None:
                raise InputError(where, one, "must be an angle or a length, such as '24 deg' or '10 mm'")
        if unit is not None:
            read_quantity(UNITS[unit], bare, where)
    return unit or "rad"


def _reads(unit: Unit, given: str) -> bool:
    return unit.reads(given) and any(c.isalpha() or c == "°" for c in given)
