"""A map of basins in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import in_lines

if TYPE_CHECKING:
    import xarray as xr

_UNIDENTIFIED = "unidentified"


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a map of basins."""
    s = result.wucht.summary
    levels = s["levels"]
    first, last = (" x ".join(map(str, levels[k]["cells"])) for k in (0, -1))
    halved = f", at the borders halved to those of {last}" if len(levels) > 1 else ""
    lines = [("map", f"{first} cells over {' and '.join(s['axes'])}{halved}"), ("runs", _runs(s))]
    if s["fractions"]:
        largest = 100 * max(s["bound"].values())
        lines.append(("shares", f"± holds in 19 of 20 cases; borders that the map resolves are off by {largest:.2g} % at most"))
    if len(levels) > 1:
        for k, name in enumerate(s["fractions"]):
            each = ", ".join(f"{100 * level['fractions'].get(name, 0.0):.4g} %" for level in levels)
            lines.append(("" if k else "by level", f"{name} {each}"))
    lines.append(("integrated", s["integration"]))
    if _UNIDENTIFIED in s["fractions"]:
        low, high = (f"{t:.4g}" for t in s["followed"][_UNIDENTIFIED])
        until = (low if low == high else f"{low} to {high}") + (f" {s['time_unit']}" if s["time_unit"] else "")
        lines.append(("unidentified", f"{100 * s['fractions'][_UNIDENTIFIED]:.3g} % of the map, followed until {until}"))
    if s["failures"]:
        lines.append(("failed", f"{s['failures']} run{'s' if s['failures'] > 1 else ''}: see the warnings"))
    return in_lines(result, s["sentence"] or "nothing is computed yet", lines)


def _runs(s: dict[str, Any]) -> str:
    if s["runs"] == s["runs_of_dense_map"]:
        return str(s["runs"])
    return f"{s['runs']}, where one in each cell of the finest map would be {s['runs_of_dense_map']}"
