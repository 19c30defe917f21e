"""Numbers in the units that an engineer reads."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

_FEW = 10  # rpm: below, with decimals

Format = Callable[[float | None], str]


def formats(result: xr.Dataset, amplitude_unit: str = "m") -> tuple[Format, Format]:
    """How speeds and amplitudes of a result are written: with units, or as plain numbers for a dimensionless machine."""
    if result.attrs["dimensionless"]:
        return plain, plain
    return _si_speed, _si_angle if amplitude_unit == "rad" else _si_length


def _si_angle(value: float | None) -> str:
    return "none" if value is None else f"{math.degrees(value):.4g}°"


def plain(value: float | None) -> str:
    """A number without a unit."""
    return "none" if value is None else f"{value:.5g}"


def _si_speed(value: float | None) -> str:
    if value is None:
        return "none"
    turns = value * 30 / math.pi
    return f"{value:.5g} rad/s ({f'{turns:.3g}' if abs(turns) < _FEW else f'{turns:.0f}'} rpm)"


def _si_length(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value * 1e3:.4g} mm" if abs(value) >= 1e-5 else f"{value * 1e6:.3g} um"
