"""The verdict of a coast-down in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import ReportLines

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
    s, lines = result.wucht.summary, ReportLines(result)
    lines.add("speed", "{start_speed} at the start, {final_speed} on average at the end")
    lines.add("halved", "not within this time" if s["half_time"] is None else "after {half_time:.5g}")
    lines.add("turns back", "at {reversal_time:.6g}")
    lines.add("turned", "{turns:.5g} times in {end_time:.5g}")
    lines.add("amplitude", f"{{peak_amplitude}} at most, at {{peak_speed}}; {_STARTS[s['carrier_start']]}")
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}" if s["outcome"] else s["sentence"])
