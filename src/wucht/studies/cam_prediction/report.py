"""The answer of a prediction in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats, in_lines

if TYPE_CHECKING:
    import xarray as xr

_BEST = 3  # motions of the elastic output that are named


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a prediction."""
    s, (speed, _) = result.wucht.summary, formats(result)
    above, power = s["above"], s["power"]
    most = f"; without a drive there is a corrected cam up to {s['inertia_ratio_limit']:.3g}"
    ratio = f"of the output at most {s['inertia_ratio']:.3g} of the shaft's"
    lines = [("inertia", ratio + ("" if s["driven"] == "enforced" else most))]
    for name, one in (("original", s), ("corrected", s["corrected"])):
        left = f"orders above {above['orders']}: {_share(above[name])} of order 1"
        lines.append((name, f"{speed(one['mean_speed'])}, fluctuating by {_share(one['fluctuation'])}; {left}"))
    constant, drive = power["constant_speed"], power["corrected"]
    taken = f"{_watts(constant['peak'])} at most, {_watts(constant['mean_positive'])} in the mean without what flows back"
    lines.append(("even speed", f"would take {taken}"))
    if s["driven"] == "eigenmotion":
        lines.append(("drive", "none: the eigenmotion saves all of that"))
    elif s["driven"] == "drive":
        saved = s["power_saved"]
        less = f"saved {_watts(saved['peak'])} and {_watts(saved['mean_positive'])}"
        lines.append(("drive", f"{_watts(drive['peak'])} at most, {_watts(drive['mean_positive'])} in the mean; {less}"))
    if s["cut_residuals"]:
        shown = ", ".join(_share(left) for left in s["cut_residuals"])
        lines.append(("instead", f"cutting, measuring and cutting again leaves {shown}"))
    if (simulated := s["simulation"]) is not None:
        one = simulated["corrected"]
        off = "it fails" if one["failure"] else f"{one['deviation']:.1e} off in speed"
        left = "" if one["above"] is None else f", {one['above']:.1e} of order 1 above {above['orders']}"
        lines.append(("simulated", f"{simulated['turns']} turns with the corrected cam: {off}{left}"))
    return in_lines(result, s["sentence"], [*lines, *_springs(s)])


def _springs(s: dict[str, Any]) -> list[tuple[str, str]]:
    lines = []
    if (output := s["output"]) is not None:
        turns = output["natural_frequency"] / (2 * math.pi)
        lines.append(
            ("elastic", f"output at {turns:.4g} Hz, damping ratio {output['damping_ratio']:.3g}; in the dwell it stays within")
        )
        lines += [("", f"{_size(e['deviation'], s['unit'])}: {e['name']}") for e in _named(output["excited"])]
    for one in s["shaft"] or ():
        twist = f"twists by {math.degrees(one['twist']):.3g}°, {one['torque']:.4g} N m"
        lines.append(
            ("shaft", f"{twist}, orders above {s['above']['orders']} {_share(one['above'])} of order 1: {one['name']}")
        )
    if output is not None and s["shaft"]:
        lines.append(("springs", "of output and shaft: each is computed with the other one rigid"))
    return lines


def _named(excited: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The quietest motions, and each cam."""
    return [e for i, e in enumerate(excited) if i < _BEST or e["name"].endswith("cam")]


def _share(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-6 or not share else f"{share:.0e}"


def _watts(power: float) -> str:
    return f"{power / 1e3:.4g} kW" if abs(power) >= 1e3 else f"{power:.4g} W"


def _size(value: float, unit: str) -> str:
    return f"{math.degrees(value):.3g}°" if unit == "rad" else f"{1e3 * value:.3g} mm"
