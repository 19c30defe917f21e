"""The answer of a torque balance in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.conventions import summary_of
from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a torque balance."""
    s = summary_of(result)
    speed, _ = formats(result)
    torque, slope = ("", "") if result.attrs["dimensionless"] else (" N m", " N m s")
    lines = [result.attrs["title"], f"verdict: {s['sentence']}"]
    possible = [p for p in s["working_points"] if not p.get("overlapping")]  # the verdict says how many are not
    for p in possible or s["working_points"]:
        kind = "stable" if p["stable"] else "touching" if p["tangential"] else "unstable"
        slip = "" if p["slip"] is None else f", slip {100 * p['slip']:.3g} %"
        if p["slope"] is None:
            line = "held by the drive's controller"
        elif p["no_load_speed"] is None:
            line = "drive of constant torque there"
        else:
            line = f"drive there like {p['slope']:.4g}{slope} from {speed(p['no_load_speed'])}"
        lines.append(f"  {kind:12} {speed(p['speed'])}{_bodies(p)}: {p['torque']:.4g}{torque}{slip}; {line}")
    if s["free_speed"] is not None:
        lines.append(f"  free         {speed(s['free_speed'])} without vibration")
    if s["breakdown"] is not None:
        b = s["breakdown"]
        lines.append(f"  breakdown    {b['torque']:.4g}{torque} at {speed(b['speed'])}, slip {100 * b['slip']:.3g} %")
    lines.append(f"  resonance    {', '.join(f'{d}: {speed(f)}' for d, f in s['natural_frequencies'].items()) or 'none'}")
    return lines


def _bodies(point: dict[str, Any]) -> str:
    """The configuration of bodies in steady phases."""
    if "configuration" not in point:
        return ""
    place = ", but bodies of a track in each other's place" if point["overlapping"] else ""
    return f", {point['configuration']}{place}"
