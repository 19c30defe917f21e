"""Whether the averaged equations may be trusted, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import ReportLines

if TYPE_CHECKING:
    import xarray as xr

_VERDICTS = {True: "TRUSTED", False: "NOT TRUSTED", None: "NOT DECIDED"}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an approximation."""
    s, lines = result.wucht.summary, ReportLines(result)
    for reason in s["reasons"]:
        lines.add("because", reason)
    if s["own"] is not None:
        lines.add("this machine", _compared(s["own"], s["speeds_of"]), s["own"], "own")
    lines.add("order", "the error falls with epsilon to the power {order_of_error:.2f}")
    key, unit, name = "factor", "", f"factor of {' and '.join(s['along'])}"
    if isinstance(s["along"], str):
        key, unit, name = s["along"], f" {s['along_unit']}".rstrip(), s["along"]
    if s["deviations"]:
        lines.add(f"along {name}, up to {s['until_phi']:.4g} rad of the rotor's angle", "")
    for d in s["deviations"]:
        lines.add(f"  {f'{d[key]:.6g}{unit}':<14} ", _compared(d, s["speeds_of"]), d, "deviations")
    for low, high in s["disagreement"]:
        where = f"at {low:.6g}{unit}" if low == high else f"from {low:.6g} to {high:.6g}{unit}"
        lines.add(f"the models end differently {where}", "")
    return lines.report(_VERDICTS[s["trusted"]])


def _compared(d: dict[str, Any], whose: str) -> str:
    apart = f"speeds of {whose} differ by {{speed}} at most, amplitudes by {{amplitude}}"
    ends = "both {outcome}" if d["same_outcome"] else "{outcome}, averaged equations {slow_outcome}"
    return f"{'nothing in common' if d['speed'] is None else apart}; {ends}"
