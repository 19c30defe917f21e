"""The report of a cam's correction."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats, report_lines

if TYPE_CHECKING:
    import xarray as xr

_MOST, _FEW = 6, 4  # orders listed at most, and those listed with details
_RPM = 30 / math.pi
_NOTHING = 1e-4  # of order 1
_ROUNDING = 1e-9  # of the stroke: a distance from the law that is none
_CAM_NAMES = {"cam": "cam", "counter": "counter cam", "outer": "outer flank"}


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a correction."""
    s = result.wucht.summary
    lines = [*_shaft_lines(result, s), *_motion_lines(_without_rounding(result, s)), *_residual_lines(s), *_contour_lines(s)]
    if s["measured"] is not None:
        lines += _measurement_lines(s["measured"], s)
    return report_lines(result, s["sentence"], lines)


def _shaft_lines(result: xr.Dataset, s: dict[str, Any]) -> list[tuple[str, str]]:
    speed, _ = formats(result)
    there = [int(j) for j, a in zip(result.speed_order.values, result.speed_amplitude.values, strict=True) if a > 0]
    fluctuates = f"fluctuates by {100 * s['fluctuation']:.2f} % in orders {_orders_text(there)}" if there else "turns evenly"
    lines = [("shaft", f"{speed(s['mean_speed'])}, a turn in {1e3 * s['period']:.5g} ms; it {fluctuates}")]
    if (r := s["record"]) is not None:
        lines += _record_lines(r, s["mean_speed"])
    return lines


def _record_lines(r: dict[str, Any], mean: float) -> list[tuple[str, str]]:
    """Return lines on the residual of the record of the speed, and its effect on the motion."""
    rest = f"{math.degrees(r['residual_rms']):.3g}° rms" if r["unit"] == "rad" else f"{_RPM * r['residual_rms']:.3g} rpm rms"
    fit_clause = f"orders explain {100 * r['explained']:.2f} %, {rest} left"
    noise = f"the noise leaves {_about(r['left_by_errors'])}"
    if not r["left_out"]:
        return [("record", f"{r['turns']:.3g} turns, {r['samples']} samples, {fit_clause}; {noise}, no order left out matters")]
    left_out_clause = f"the orders left out {_about(r['left_by_left_out'])}"
    sizes = (
        f"order {one['order']} ({_RPM * one['amplitude']:.3g} rpm, {_percent(one['amplitude'] / mean)} of the speed), which "
        f"leaves {_percent(one['share'])}"
        for one in r["left_out"][:_FEW]
    )
    return [
        ("record", f"{r['turns']:.3g} turns, {r['samples']} samples, {fit_clause}; {noise}, {left_out_clause}"),
        ("left out", f"{'; '.join(sizes)}"),
    ]


def _measurement_lines(m: dict[str, Any], s: dict[str, Any]) -> list[tuple[str, str]]:
    """Return lines on the measured acceleration beside the computed one."""
    unit, orders = f"{s['unit']}/s^2", f"{m['orders']} orders" if m["orders"] > 1 else "1 order"
    explained_clause = f"{100 * max(m['explained'], 0.0):.1f} % explained by the computed motion of the {m['cam']} cam"
    of_orders = f"{100 * max(m['explained_orders'], 0.0):.1f} % of its {orders}"
    beside = f"{m['noise_rms']:.4g} of {m['rms']:.4g} {unit} rms lie outside these"
    lines = [("measured", f"{m['turns']:.3g} turns: {explained_clause} ({of_orders}; {beside})")]
    if m["delay"] is not None:
        by = f"{abs(math.degrees(m['delay'])):.3g}° ({abs(1e3 * m['delay'] / s['mean_speed']):.3g} ms)"
        late = f"{by} {'later' if m['delay'] > 0 else 'earlier'} than computed"
        lines.append(
            ("", f"it comes {late}; without it {100 * m['explained_without_delay']:.1f} % of its orders would be explained")
        )
    return lines


def _without_rounding(result: xr.Dataset, s: dict[str, Any]) -> dict[str, Any]:
    """Return the summary with 0 for distances from the law that are rounding errors."""
    stroke = float(result.output[0].max() - result.output[0].min())
    errors = [key for key in s if key.startswith(("position_error", "dwell_error"))]
    zero = [key for key in errors if s[key] is not None and s[key] < _ROUNDING * stroke]
    zero += [key.replace("dwell_error", "dwell_travel") for key in zero]
    return s | {key: 0.0 for key in zero if s[key] is not None}


def _motion_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    unit = f"{s['unit']}/s^2"
    lines = [("acceleration", f"at most {s['peak_after']:.4g} {unit}; of the original cam {s['peak_before']:.4g} {unit}")]
    if s.get("position_error_before") is not None:  # results of earlier versions lack it
        after, before = (_travel_text(s, s[f"position_error_{version}"]) for version in ("after", "before"))
        off_clause = f"off the law over time by at most {after}; with the original cam by {before}"
        lines[0] = ("acceleration", f"{lines[0][1]}; {off_clause}")
    if s.get("dwell_error_before") is not None:  # results of earlier versions lack it
        after, before = _position_error_text(s, "after", " at the end of the arm"), _position_error_text(s, "before")
        lines.append(("dwell", f"position off by at most {after}; with the original cam by {before}"))
    if s["recovered"]:
        exact_shares = ", ".join(f"{name} {share:.2g}" for name, share in s["recovered"].items())
        rounded_shares = ", ".join(f"{share:.2g}" for share in s["rounded"].values())
        decimals = f"rounded to {s['decimals']} decimals of a mm {rounded_shares}"
        lines.append(("from points", f"{exact_shares} of order {s['reference_order']}; {decimals}"))
    return lines


def _travel_text(s: dict[str, Any], travel: float) -> str:
    return f"{math.degrees(travel):.4g}°" if s["unit"] == "rad" else _mm(travel)


def _position_error_text(s: dict[str, Any], version: str, place: str = "") -> str:
    """Return the position error in the dwell, in degrees and in mm at the end of the output's arm, or in mm."""
    error, travel = s[f"dwell_error_{version}"], s[f"dwell_travel_{version}"]
    if s["unit"] != "rad":
        return _mm(error)
    return _travel_text(s, error) + ("" if travel is None else f" ({_mm(travel)}{place})")


def _residual_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    """Return lines on the residuals under deviating conditions; the orders left out in one line."""
    orders = [r for r in s["residuals"] if r["what"].startswith("order ")]
    remaining_residuals = [r for r in s["residuals"] if r not in orders]
    lines = [("left if", f"{_percent(r['share']):>7}  {r['what']}") for r in remaining_residuals]
    if orders:
        largest_orders = sorted(orders, key=lambda r: -r["share"])[:_MOST]
        order_shares = ", ".join(f"{_percent(r['share'])} ({r['what'].split()[1]})" for r in largest_orders)
        lines.append(("left if", f"an order of the speed is left out: {order_shares}"))
    return lines


def _contour_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    lines = []
    for name, c in s["contours"].items():
        old, new = c["original"], c["corrected"]
        at = math.degrees(new["max_pressure_angle_at"])
        angles = f"pressure angle at most {_degrees(new)} at {at:.4g}° (original {_degrees(old)}), "
        radii = f"least radius of curvature {_mm(new['min_curvature_radius'])} ({_mm(old['min_curvature_radius'])})"
        roller = "" if new["largest_roller"] is None else f", largest roller {_mm(new['largest_roller'])}"
        wheel = "" if new["largest_wheel"] is None else f", largest grinding wheel {_mm(new['largest_wheel'])}"
        lines.append((_CAM_NAMES[name], f"{angles if new['max_pressure_angle'] else ''}{radii}"))  # a flat face has none
        lines.append(("", f"moved by {_mm(c['moved'])} at most, not undercut{roller}{wheel}"))
    return lines


def _orders_text(orders: list[int]) -> str:
    return ", ".join(map(str, orders[:_MOST])) + (f" and {len(orders) - _MOST} more" if len(orders) > _MOST else "")


def _percent(share: float | None) -> str:
    return "none" if share is None else f"{float(f'{100 * share:.2g}'):g} %"


def _about(share: float) -> str:
    return f"less than {_percent(_NOTHING)}" if share < _NOTHING else f"about {_percent(share)}"


def _degrees(of: dict[str, Any]) -> str:
    return f"{math.degrees(of['max_pressure_angle']):.3g}°"


def _mm(value: float | None) -> str:
    return "none" if value is None else f"{1e3 * value:.4g} mm"
