"""The answer of a sweep in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import ReportLines

if TYPE_CHECKING:
    import xarray as xr

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a sweep."""
    s, lines = result.wucht.summary, ReportLines(result)
    jumps, (low, high), unit = s["jumps"], s["range"], f" {s['along_unit']}" if s["along_unit"] else ""
    chosen = " (chosen: so slow that the machine follows)" if s["rate_chosen"] else ""
    lines.add("sweep", f"{{along}} from {low:.5g} to {high:.5g}{unit} at {{rate:.3g}}{chosen}")
    for way, ends in s["ends"].items():
        lines.add(way, "{from_speed} to {to_speed}", ends, "ends")
    for jump in jumps:
        lines.add("jump", f"{SENSE[jump['direction']]}, at {s['along']} = {jump[s['along']]:.6g}{unit}:")
        lines.add("", "speed {from_speed} to {to_speed}", jump, "jumps")
        lines.add("", "amplitude {from_amplitude} to {to_amplitude}", jump, "jumps")
    if s["hysteresis"]:
        between = "{:.6g} and {:.6g}".format(*s["hysteresis"])
        lines.add("hysteresis", f"between {between}{unit} the state depends on where the machine comes from")
    if jumps:
        lines.add("accuracy", "{jump_tolerance:.0e} of these values, found by holding {along}: not late by the rate")
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    count = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(jumps), f"{len(jumps)} JUMPS")
    return lines.report(s["sentence"].upper() if s["sentence"].startswith("the sweep") else count)
