"""The answer of ``entrainment`` in words: bands, phases, mean speed, stability, threshold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for the study ``entrainment``."""
    s = result.wucht.summary
    speed, length = formats(result)
    unit = f" {s['along_unit']}" if s["along_unit"] else ""
    lines = [result.attrs["title"], f"verdict: {s['outcome'].upper()}: {s['sentence']}"]
    lines.append(f"  looked at    {s['along']} = {s['value']:.6g}{unit}")
    words = partial(band_in_words, unit=s["along_unit"], digits=7)
    if s["existence_band"] is not None:
        kinds = dict.fromkeys(k for k in s["existence_edges"] if k != "range")
        how = f", ends: {', '.join(kinds)}" if kinds else ""
        lines.append(f"  existence    {words(s['existence_band'])} (averaged equations{how})")
    if s["existence_band_full"] is not None:
        lines.append(f"               {words(s['existence_band_full'])} (full equations)")
    if s["band_from_rest"] is not None:
        lines.append(f"  from start   {words(s['band_from_rest'])}, edges to {s['resolution']:.1e}{unit}")
    lines += [f"  also         {low:.6g} to {high:.6g}{unit}" for low, high in s["islands"]]
    for body, phase in s["phases"].items():
        averaged = s["phases_slow"].get(body)
        beside = "" if averaged is None else f", averaged equations {_angle(result, averaged)}"
        lines.append(f"  phase        {body}: {_angle(result, phase)}{beside}")
    if s["mean_speed"] is not None:
        lines.append(f"  mean speed   {speed(s['mean_speed'])}")
    if s["multiplier"] is not None:
        kind = "stable" if s["stable"] else "not stable"
        lines.append(f"  stability    {kind}: largest multiplier of a period {s['multiplier']:.4g}")
    if s["threshold_amplitude"] is not None:
        least = length(s["threshold_amplitude"])
        lines.append(f"  threshold    the vibration must be larger than {least} (averaged equations)")
    return lines


def band_in_words(band: Sequence[float | None], unit: str, what: str = "", digits: int = 6) -> str:
    """A band (low, high), None for an end beyond what was looked at. what: before the first of its values."""
    low, high = (None if edge is None else f"{edge:.{digits}g}" for edge in band)
    end = f" {unit}" if unit else ""
    if low is None:
        return "in all of the range" if high is None else f"below {what}{high}{end}"
    return f"above {what}{low}{end}" if high is None else f"between {what}{low} and {high}{end}"


def _angle(result: xr.Dataset, value: float) -> str:
    return f"{value:.5g}" if result.attrs["dimensionless"] else f"{value:.5g} rad ({math.degrees(value):.4g}°)"
