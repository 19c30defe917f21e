"""The answer of a sweep in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.conventions import summary_of
from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a sweep."""
    s = summary_of(result)
    speed, length = formats(result)
    along = s["along"]
    low, high = (f"{v:.5g}" for v in s["range"])
    unit = f" {s['along_unit']}" if s["along_unit"] else ""
    count = len(s["jumps"])
    headline = {0: "NO JUMP", 1: "ONE JUMP"}.get(count, f"{count} JUMPS")
    lines = [result.attrs["title"]]
    lines.append(f"verdict: {s['sentence'].upper() if s['sentence'].startswith('the sweep') else headline}")
    chosen = " (chosen: so slow that the machine follows)" if s["rate_chosen"] else ""
    lines.append(f"  sweep        {along} from {low} to {high}{unit} at {s['rate']:.3g} {s['rate_unit']}{chosen}")
    for way, ends in s["ends"].items():
        lines.append(f"  {way:<12} {speed(ends['from_speed'])} to {speed(ends['to_speed'])}")
    for jump in s["jumps"]:
        arrow = "rising" if jump["direction"] == "up" else "falling"
        lines.append(f"  jump         {arrow}, at {along} = {jump[along]:.6g}{unit}:")
        lines.append(f"               speed {speed(jump['from_speed'])} to {speed(jump['to_speed'])}")
        lines.append(f"               amplitude {length(jump['from_amplitude'])} to {length(jump['to_amplitude'])}")
    if s["hysteresis"]:
        below, above = s["hysteresis"]
        lines.append(
            f"  hysteresis   between {below:.6g} and {above:.6g}{unit} the state depends on where the machine comes from"
        )
    if s["jumps"]:
        lines.append(
            f"  accuracy     {s['jump_tolerance']:.0e} of these values, found by holding {along}: not late by the rate"
        )
    if s["energy_residual"] is not None:
        lines.append(f"  energy       balance closed to {s['energy_residual']:.1e}")
    return lines
