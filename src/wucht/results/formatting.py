"""Numbers in the units that an engineer reads."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

_FEW = 10  # rpm: below, with decimals

Format = Callable[[float | None], str]


def formats(result: xr.Dataset, amplitude_unit: str = "m") -> tuple[Format, Format]:
    """How speeds and amplitudes of a result are written: with units, or as plain numbers for a dimensionless machine."""
    if result.attrs["dimensionless"]:
        return (_or_none("{:.5g}".format),) * 2
    return _or_none(_speed), _or_none(_angle if amplitude_unit == "rad" else _length)


def in_lines(result: xr.Dataset, verdict: str, named: Iterable[tuple[str, str]]) -> list[str]:
    """The lines of a report: the title, the verdict, and what has a name each in a column beside it."""
    return [result.attrs["title"], f"verdict: {verdict}", *(f"  {name:13}{line}" for name, line in named)]


def percent(share: float, off: float = 0.0) -> str:
    """A share, and by how much it may be off: ``24.88 % ± 0.40 %``, with as many decimals as that is worth."""
    if not off > 0:
        return f"{100 * share:.4g} %"
    decimals = min(max(1 - math.floor(math.log10(100 * off)), 0), 6)
    return f"{100 * share:.{decimals}f} % ± {100 * off:.{decimals}f} %"


def bodies_in_words(count: int) -> str:
    """``4 bodies``."""
    return "1 body" if count == 1 else f"{count} bodies"


def _or_none(written: Callable[[float], str]) -> Format:
    return lambda value: "none" if value is None else written(value)


def _angle(value: float) -> str:
    return f"{math.degrees(value):.4g}°"


def _speed(value: float) -> str:
    turns = value * 30 / math.pi
    return f"{value:.5g} rad/s ({f'{turns:.3g}' if abs(turns) < _FEW else f'{turns:.0f}'} rpm)"


def _length(value: float) -> str:
    return f"{value * 1e3:.4g} mm" if abs(value) >= 1e-5 else f"{value * 1e6:.3g} um"
