"""The answer of a motion law in words."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from wucht.results.conventions import summary_of
from wucht.results.formatting import in_lines

if TYPE_CHECKING:
    import xarray as xr


_NAMES, _PER = ("position", "velocity", "acceleration", "jerk"), ("", "/rad", "/rad²", "/rad³")
_BINDS = 1e-5  # of its bound: so near, a restriction binds


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a motion law."""
    s = summary_of(result)
    angle = s["unit"] == "rad"

    def shown(value: float, suffix: str = "") -> str:
        return f"{math.degrees(value):.4g}°{suffix}" if angle else f"{1e3 * value:.4g} mm{suffix}"

    lines = [("stroke", shown(s["stroke"]))]
    if s["ripple"] is not None:
        lines.append(("dwell", f"within {shown(s['ripple'])} of what is asked"))
    for name, suffix in zip(_NAMES[1:], _PER[1:], strict=True):
        lines.append((name, f"at most {shown(s['peaks'][name], suffix)}"))
    if s["rise"] is not None:
        Cv, Ca, Cj = (s["rise"][name] for name in ("velocity", "acceleration", "jerk"))
        lines.append(("rise", f"of 1 over an arc of 1: Cv = {Cv:.5g}, Ca = {Ca:.5g}, Cj = {Cj:.5g}"))
    return in_lines(result, s["sentence"], [*lines, *_restrictions(result, shown)])


def _restrictions(result: xr.Dataset, shown: Callable[[float, str], str]) -> list[tuple[str, str]]:
    """How each is met, and which of them bind."""
    lines = []
    r = {name: result[name].values for name in ("restricted", "begin", "end", "low", "high", "least", "greatest")}
    for i, name in enumerate(result.restriction.values.tolist()):
        k = int(r["restricted"][i])
        suffix, what = ("", "amplitude") if k < 0 else (_PER[k], _NAMES[k])
        low, high, least, greatest = (float(r[n][i]) for n in ("low", "high", "least", "greatest"))
        size = max(abs(bound) for bound in (low, high) if math.isfinite(bound))
        binds = greatest > high - _BINDS * size or (k >= 0 and least < low + _BINDS * size)
        one = k < 0 or least == greatest
        found = shown(greatest, suffix) if one else f"{shown(least, suffix)} to {shown(greatest, suffix)}"
        line = f"{name.removeprefix('law.')}: {what} {found}" + (" (binds)" if binds and low < high else "")
        lines.append(("" if i else "asked", line))
    return lines
