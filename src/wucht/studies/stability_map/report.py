"""A stability map in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a stability map."""
    s = result.wucht.summary
    along, second = s["along"], s["second"]
    lines = [result.attrs["title"], f"verdict: {s['sentence']}"]
    for name, line in s["boundaries"].items():
        xs, ys = zip(*line, strict=True)
        lines.append(f"  {name}: {along} from {min(xs):.5g} to {max(xs):.5g}, {second} from {min(ys):.5g} to {max(ys):.5g}")
    for p in s["points"]:
        at = zip((along, second, s.get("eliminate")), p["values"], strict=False)
        lines.append(f"  {p['kind'].replace('-', ' ')}: {', '.join(f'{name} = {value:.7g}' for name, value in at)}")
    for region in s["regions"]:
        lines.append(f"  {100 * region['share']:5.1f} %  {region['label']}")
    agree = s["places"] - s["against"]
    runs = f", by {s['runs']} runs from several starts," if s.get("runs") else ""
    lines.append(
        f"  checked      {agree} of {s['places']} places that were looked at one by one{runs} agree with the boundaries"
    )
    return lines
