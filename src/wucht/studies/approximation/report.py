"""Whether the slow equations may be trusted, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.conventions import summary_of
from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr

_VERDICTS = {True: "TRUSTED", False: "NOT TRUSTED", None: "NOT DECIDED"}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an approximation."""
    s = summary_of(result)
    lines = [result.attrs["title"], f"verdict: {_VERDICTS[s['trusted']]}"]
    lines += [f"  because      {reason}" for reason in s["reasons"]]
    if s["own"] is not None:
        lines.append(f"  this machine {_one(s['own'], s, result)}")
    if s["order_of_error"] is not None:
        lines.append(f"  order        the error falls with epsilon to the power {s['order_of_error']:.2f}")
    single = isinstance(s["along"], str)
    if s["deviations"]:
        named = s["along"] if single else f"factor of {' and '.join(s['along'])}"
        lines.append(f"  along {named}, up to {s['until_phi']:.4g} rad of the rotor's angle")
    key, unit = (s["along"], f" {s['along_unit']}".rstrip()) if single else ("factor", "")
    lines += [f"    {f'{d[key]:.6g}{unit}':<14} {_one(d, s, result)}" for d in s["deviations"]]
    for low, high in s["disagreement"]:
        where = f"at {low:.6g}{unit}" if low == high else f"from {low:.6g} to {high:.6g}{unit}"
        lines.append(f"  the models end differently {where}")
    return lines


def _one(d: dict[str, Any], summary: dict[str, Any], result: xr.Dataset) -> str:
    speed, length = formats(result, summary["amplitude_unit"])
    apart = "nothing in common"
    if d["speed"] is not None:
        of = summary["speeds_of"]
        apart = f"speeds of {of} differ by {speed(d['speed'])} at most, amplitudes by {length(d['amplitude'])}"
    ends = f"both {d['outcome']}" if d["same_outcome"] else f"{d['outcome']}, slow equations {d['slow_outcome']}"
    return f"{apart}; {ends}"
