"""The answer of a motion law in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wucht.results.conventions import summary_of
from wucht.results.formatting import in_lines

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a motion law."""
    s = summary_of(result)
    angle = s["unit"] == "rad"

    def shown(value: float, suffix: str = "") -> str:
        return f"{math.degrees(value):.4g}°{suffix}" if angle else f"{1e3 * value:.4g} mm{suffix}"

    lines = [("stroke", shown(s["stroke"]))]
    if s["ripple"] is not None:
        lines.append(("dwell", f"within {shown(s['ripple'])} of what is asked"))
    for name, suffix in (("velocity", "/rad"), ("acceleration", "/rad²"), ("jerk", "/rad³")):
        lines.append((name, f"at most {shown(s['peaks'][name], suffix)}"))
    return in_lines(result, s["sentence"], lines)
