"""The answer of a cam's correction in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.conventions import summary_of
from wucht.results.formatting import formats, in_lines

if TYPE_CHECKING:
    import xarray as xr

_MOST = 6  # orders named one by one


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a correction."""
    s = summary_of(result)
    lines = [*_shaft(result, s), *_motion(s), *_left(s), *_contours(s)]
    if (m := s["measured"]) is not None:
        record = f"{m['turns']:.3g} turns, {m['orders']} orders"
        explained = f"{max(m['explained'], 0.0):.1%} explained by the motion computed for the {m['cam']} cam"
        lines.append(("measured", f"{record}: {explained}"))
    return in_lines(result, s["sentence"], lines)


def _shaft(result: xr.Dataset, s: dict[str, Any]) -> list[tuple[str, str]]:
    speed, _ = formats(result)
    there = [int(j) for j, a in zip(result.speed_order.values, result.speed_amplitude.values, strict=True) if a > 0]
    fluctuates = f"fluctuates by {s['fluctuation']:.2%} in orders {_listed(there)}" if there else "turns evenly"
    lines = [("shaft", f"{speed(s['mean_speed'])}, a turn in {1e3 * s['period']:.5g} ms; it {fluctuates}")]
    if (r := s["record"]) is not None:
        error = "" if r["left_by_errors"] is None else f"; its noise leaves about {_percent(r['left_by_errors'])}"
        lines.append(("record", f"{r['turns']:.3g} turns, {r['samples']} samples, orders explain {r['explained']:.2%}{error}"))
    return lines


def _motion(s: dict[str, Any]) -> list[tuple[str, str]]:
    unit = f"{s['unit']}/s^2"
    lines = [("acceleration", f"at most {s['peak_after']:.4g} {unit}; of the original cam {s['peak_before']:.4g} {unit}")]
    if s["recovered"]:
        found = ", ".join(f"{name} {share:.2g}" for name, share in s["recovered"].items())
        rounded = ", ".join(f"{share:.2g}" for share in s["rounded"].values())
        decimals = f"rounded to {s['decimals']} decimals of a mm {rounded}"
        lines.append(("from points", f"{found} of order {s['reference_order']}; {decimals}"))
    return lines


def _left(s: dict[str, Any]) -> list[tuple[str, str]]:
    """What is left where something is otherwise; the orders left out in one line."""
    orders = [r for r in s["residuals"] if r["what"].startswith("order ")]
    others = [r for r in s["residuals"] if r not in orders]
    lines = [("left if", f"{_percent(r['share']):>7}  {r['what']}") for r in others]
    if orders:
        ranked = sorted(orders, key=lambda r: -r["share"])[:_MOST]
        named = ", ".join(f"{_percent(r['share'])} ({r['what'].split()[1]})" for r in ranked)
        lines.append(("left if", f"an order of the speed is left out: {named}"))
    return lines


def _contours(s: dict[str, Any]) -> list[tuple[str, str]]:
    lines = []
    for name, c in s["contours"].items():
        old, new = c["original"], c["corrected"]
        angles = f"pressure angle at most {_degrees(new)} (original {_degrees(old)})"
        radii = f"least radius of curvature {_mm(new['min_curvature_radius'])} ({_mm(old['min_curvature_radius'])})"
        roller = "" if new["largest_roller"] is None else f", largest roller {_mm(new['largest_roller'])}"
        lines.append((name, f"{angles}, {radii}{roller}; moved by {_mm(c['moved'])}, not undercut"))
    return lines


def _listed(orders: list[int]) -> str:
    return ", ".join(map(str, orders[:_MOST])) + (f" and {len(orders) - _MOST} more" if len(orders) > _MOST else "")


def _percent(share: float | None) -> str:
    return "none" if share is None else f"{float(f'{100 * share:.2g}'):g} %"


def _degrees(of: dict[str, Any]) -> str:
    return f"{math.degrees(of['max_pressure_angle']):.3g}°"


def _mm(value: float | None) -> str:
    return "none" if value is None else f"{1e3 * value:.4g} mm"
