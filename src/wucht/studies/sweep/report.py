"""The answer of a sweep in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import formats, in_lines

if TYPE_CHECKING:
    import xarray as xr

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a sweep."""
    s = result.wucht.summary
    speed, length = formats(result)
    along, jumps = s["along"], s["jumps"]
    low, high = s["range"]
    unit = f" {s['along_unit']}" if s["along_unit"] else ""
    headline = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(jumps), f"{len(jumps)} JUMPS")
    chosen = " (chosen: so slow that the machine follows)" if s["rate_chosen"] else ""
    verdict = s["sentence"].upper() if s["sentence"].startswith("the sweep") else headline
    lines = [("sweep", f"{along} from {low:.5g} to {high:.5g}{unit} at {s['rate']:.3g} {s['rate_unit']}{chosen}")]
    lines += [(way, f"{speed(ends['from_speed'])} to {speed(ends['to_speed'])}") for way, ends in s["ends"].items()]
    for jump in jumps:
        lines += [
            ("jump", f"{SENSE[jump['direction']]}, at {along} = {jump[along]:.6g}{unit}:"),
            ("", f"speed {speed(jump['from_speed'])} to {speed(jump['to_speed'])}"),
            ("", f"amplitude {length(jump['from_amplitude'])} to {length(jump['to_amplitude'])}"),
        ]
    if s["hysteresis"]:
        between = "{:.6g} and {:.6g}".format(*s["hysteresis"])
        lines.append(("hysteresis", f"between {between}{unit} the state depends on where the machine comes from"))
    if jumps:
        accuracy = f"{s['jump_tolerance']:.0e} of these values, found by holding {along}: not late by the rate"
        lines.append(("accuracy", accuracy))
    if s["energy_residual"] is not None:
        lines.append(("energy", f"balance closed to {s['energy_residual']:.1e}"))
    return in_lines(result, verdict, lines)
