"""The verdict of a coast-down in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import formats, in_lines

if TYPE_CHECKING:
    import xarray as xr


_STARTS = {
    "steady": "it starts in the steady vibration of its speed",
    "rest": "the carrier starts at rest",
    "given": "the carrier starts as study.start says",
    "fixed": "the carrier moves as prescribed",
}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a coast-down."""
    s = result.wucht.summary
    second = "" if result.attrs["dimensionless"] else " s"
    speed, length = formats(result, result.amplitude.attrs["units"])
    label = "" if s["outcome"] is None else f"{s['outcome'].upper()}: "
    half = "not within this time" if s["half_time"] is None else f"after {s['half_time']:.5g}{second}"
    lines = {
        "speed": f"{speed(s['start_speed'])} at the start, {speed(s['final_speed'])} on average at the end",
        "halved": half,
    }
    if s["reversal_time"] is not None:
        lines["turns back"] = f"at {s['reversal_time']:.6g}{second}"
    lines["turned"] = f"{s['turns']:.5g} times in {s['end_time']:.5g}{second}"
    if s["peak_amplitude"]:
        largest = f"{length(s['peak_amplitude'])} at most, at {speed(s['peak_speed'])}"
        lines["amplitude"] = f"{largest}; {_STARTS[s['carrier_start']]}"
    lines["energy"] = f"balance closed to {s['energy_residual']:.1e}"
    return in_lines(result, f"{label}{s['sentence']}", lines.items())
