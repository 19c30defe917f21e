"""Whether the averaged equations may be trusted, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr

_VERDICTS = {True: "TRUSTED", False: "NOT TRUSTED", None: "NOT DECIDED"}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an approximation."""
    s = result.wucht.summary
    speed, length = formats(result, s["amplitude_unit"])

    def compared(d: dict[str, Any]) -> str:
        apart = "nothing in common"
        if d["speed"] is not None:
            speeds = f"speeds of {s['speeds_of']} differ by {speed(d['speed'])} at most"
            apart = f"{speeds}, amplitudes by {length(d['amplitude'])}"
        ends = f"both {d['outcome']}" if d["same_outcome"] else f"{d['outcome']}, averaged equations {d['slow_outcome']}"
        return f"{apart}; {ends}"

    lines = [result.attrs["title"], f"verdict: {_VERDICTS[s['trusted']]}"]
    lines += [f"  because      {reason}" for reason in s["reasons"]]
    if s["own"] is not None:
        lines.append(f"  this machine {compared(s['own'])}")
    if s["order_of_error"] is not None:
        lines.append(f"  order        the error falls with epsilon to the power {s['order_of_error']:.2f}")
    key, unit, name = "factor", "", f"factor of {' and '.join(s['along'])}"
    if isinstance(s["along"], str):
        key, unit, name = s["along"], f" {s['along_unit']}".rstrip(), s["along"]
    if s["deviations"]:
        lines.append(f"  along {name}, up to {s['until_phi']:.4g} rad of the rotor's angle")
    lines += [f"    {f'{d[key]:.6g}{unit}':<14} {compared(d)}" for d in s["deviations"]]
    for low, high in s["disagreement"]:
        where = f"at {low:.6g}{unit}" if low == high else f"from {low:.6g} to {high:.6g}{unit}"
        lines.append(f"  the models end differently {where}")
    return lines
