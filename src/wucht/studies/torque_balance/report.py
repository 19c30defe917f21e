"""The answer of a torque balance in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import ReportLines

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a torque balance."""
    summary, lines = result.wucht.summary, ReportLines(result)
    points = summary["working_points"]
    for point in [p for p in points if not p.get("overlapping")] or points:  # the verdict says how many are not possible
        kind = "stable" if point["stable"] else "touching" if point["tangential"] else "unstable"
        slip = "" if point["slip"] is None else ", slip {slip:%}"
        lines.add(
            kind, f"{{speed}}{{bodies}}: {{torque}}{slip}; {_drive(point)}", point, "working_points", bodies=_bodies(point)
        )
    lines.add("free", "{free_speed} without vibration")
    lines.add("breakdown", "{breakdown.torque} at {breakdown.speed}, slip {breakdown.slip:%}")
    lines.add("resonance", "{natural_frequencies}")
    return lines.report(summary["sentence"])


def _drive(point: dict[str, Any]) -> str:
    """The straight line that replaces the drive's characteristic there."""
    if point["slope"] is None:
        return "held by the drive's controller"
    return (
        "drive of constant torque there" if point["no_load_speed"] is None else "drive there like {slope} from {no_load_speed}"
    )


def _bodies(point: dict[str, Any]) -> str:
    """The configuration of bodies in steady phases."""
    if "configuration" not in point:
        return ""
    place = ", but bodies of a track in each other's place" if point["overlapping"] else ""
    return f", {point['configuration']}{place}"
