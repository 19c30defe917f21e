"""The answer of an activation in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import ReportLines, formats

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an activation."""
    s, (speed, _), lines = result.wucht.summary, formats(result), ReportLines(result)
    alike: dict[str, list[str]] = {}
    for p in s["pendulums"]:
        for opening, closing, snaps in zip(p["opening"], p["closing"], p["snaps"], strict=True):
            how = f"opens at {speed(opening)}, closes at {speed(closing)}{'' if snaps else ': gradually in between'}"
            alike.setdefault(how, []).append(p["name"])
    for how, names in alike.items():
        lines.add(", ".join(names), how)
    lines.add("none", "{none.peak_amplitude} at {none.peak_speed}")
    for name in ("rigid", "balanced", "switchable"):
        for group in s[name]:
            after = "" if name == "rigid" else ", none opens"
            if group.get("peak_after") is not None:
                after = ", {peak_after} from the opening on"
            at = "at {activation_speed:.5g}, " if name != "rigid" and len(result.activation_speed) > 1 else ""
            outcomes = ", ".join(f"{n} {outcome}" for outcome, n in group["outcomes"].items())
            lines.add(name, f"{at}{{orientation}} apart: {{peak_amplitude}} at most{after}; {outcomes}", group, name)
    lines.add("energy", "balance closed to {energy_residual:.1e} in all runs")
    return lines.report(s["sentence"])
