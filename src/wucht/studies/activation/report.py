"""The answer of an activation in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats, in_lines

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an activation."""
    s, (speed, length) = result.wucht.summary, formats(result, result.peak.attrs["units"])
    alike: dict[str, list[str]] = {}
    for p in s["pendulums"]:
        for k, opening in enumerate(p["opening"]):
            how = f"opens at {speed(opening)}, closes at {speed(p['closing'][k])}"
            alike.setdefault(how if p["snaps"][k] else f"{how}: gradually in between", []).append(p["name"])
    lines = [(", ".join(names), how) for how, names in alike.items()]
    if s["none"]:
        lines.append(("none", f"{length(s['none']['peak_amplitude'])} at {speed(s['none']['peak_speed'])}"))
    lines += [("rigid", f"{_angle(g)}: {length(g['peak_amplitude'])} at most; {_outcomes(g)}") for g in s["rigid"]]
    for name in ("balanced", "switchable"):
        for g in s[name]:
            after = f", {length(g['peak_after'])} from the opening on" if g["peak_after"] is not None else ", none opens"
            at = f"at {g['activation_speed']:.5g} rad/s, " if len(result.activation_speed) > 1 else ""
            lines.append((name, f"{at}{_angle(g)}: {length(g['peak_amplitude'])} at most{after}; {_outcomes(g)}"))
    if s["energy_residual"] is not None:
        lines.append(("energy", f"balance closed to {s['energy_residual']:.1e} in all runs"))
    return in_lines(result, s["sentence"], lines)


def _angle(group: dict[str, Any]) -> str:
    return f"{math.degrees(group['orientation']):.4g}° apart"


def _outcomes(group: dict[str, Any]) -> str:
    return ", ".join(f"{n} {name}" for name, n in group["outcomes"].items())
