"""The answer of a motion law in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wucht.results.formatting import ReportLines

if TYPE_CHECKING:
    import xarray as xr

_NAMES = ("position", "velocity", "acceleration", "jerk")
_BINDS = 1e-5  # of its bound: so near, a restriction binds


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a motion law."""
    lines = ReportLines(result)
    lines.add("stroke", "{stroke}")
    lines.add("dwell", "within {ripple} of what is asked")
    for name in _NAMES[1:]:
        lines.add(name, f"at most {{peaks.{name}}}")
    lines.add("rise", "of 1 over an arc of 1: Cv = {rise.velocity:.5g}, Ca = {rise.acceleration:.5g}, Cj = {rise.jerk:.5g}")
    for i in range(result.sizes["restriction"]):
        lines.add("" if i else "asked", "{restriction}", restriction=_restriction(result, lines, i))
    return lines.report(result.attrs["sentence"])


def _restriction(result: xr.Dataset, lines: ReportLines, i: int) -> str:
    """How one is met, and whether it binds."""
    order = int(result.restricted.values[i])
    low, high, least, greatest = (float(result[n].values[i]) for n in ("low", "high", "least", "greatest"))
    of = result[_NAMES[max(order, 0)]]
    shown = [lines.written(value, of.units) for value in ((greatest,) if order < 0 or least == greatest else (least, greatest))]
    size = max(abs(bound) for bound in (low, high) if math.isfinite(bound))
    binds = low < high and (greatest > high - _BINDS * size or (order >= 0 and least < low + _BINDS * size))
    name, what = str(result.restriction.values[i]).removeprefix("law."), "amplitude" if order < 0 else of.name
    return f"{name}: {what} {' to '.join(map(str, shown))}" + (" (binds)" if binds else "")
