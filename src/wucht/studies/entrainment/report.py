"""The answer of ``entrainment`` in words: bands, phases, mean speed, stability, threshold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from wucht.results.formatting import ReportLines

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for the study ``entrainment``."""
    s, lines = result.wucht.summary, ReportLines(result)
    unit = f" {s['along_unit']}" if s["along_unit"] else ""
    words = partial(band_in_words, unit=s["along_unit"], digits=7)
    lines.add("looked at", "{along} = {value:.6g}")
    if s["existence_band"] is not None:
        kinds = dict.fromkeys(k for k in s["existence_edges"] if k != "range")
        how = f", ends: {', '.join(kinds)}" if kinds else ""
        lines.add("existence", f"{words(s['existence_band'])} (averaged equations{how})")
    if s["existence_band_full"] is not None:
        lines.add("", f"{words(s['existence_band_full'])} (full equations)")
    if s["band_from_rest"] is not None:
        lines.add("from start", f"{words(s['band_from_rest'])}, edges to {{resolution:.1e}}")
    for low, high in s["islands"]:
        lines.add("also", f"{low:.6g} to {high:.6g}{unit}")
    for body, phase in s["phases"].items():
        averaged = s["phases_slow"].get(body)
        beside = "" if averaged is None else f", averaged equations {_angle(result, averaged)}"
        lines.add("phase", f"{body}: {_angle(result, phase)}{beside}")
    lines.add("mean speed", "{mean_speed}")
    lines.add("stability", f"{'stable' if s['stable'] else 'not stable'}: largest multiplier of a period {{multiplier:.4g}}")
    lines.add("threshold", "the vibration must be larger than {threshold_amplitude} (averaged equations)")
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}")


def band_in_words(band: Sequence[float | None], unit: str, what: str = "", digits: int = 6) -> str:
    """A band (low, high), None for an end beyond what was looked at. what: before the first of its values."""
    low, high = (None if edge is None else f"{edge:.{digits}g}" for edge in band)
    end = f" {unit}" if unit else ""
    if low is None:
        return "in all of the range" if high is None else f"below {what}{high}{end}"
    return f"above {what}{low}{end}" if high is None else f"between {what}{low} and {high}{end}"


def _angle(result: xr.Dataset, value: float) -> str:
    return f"{value:.5g}" if result.attrs["dimensionless"] else f"{value:.5g} rad ({math.degrees(value):.4g}°)"
