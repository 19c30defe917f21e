"""Whether the slow equations may be trusted, in words."""

from __future__ import annotations

from typing import Any

from wucht.cli.verdicts.units import speaking

_VERDICTS = {True: "TRUSTED", False: "NOT TRUSTED", None: "NOT DECIDED"}


def lines(document: dict[str, Any]) -> list[str]:
    """The lines that ``wucht run`` prints for an approximation."""
    s = document["summary"]
    said = [document["machine"], f"verdict: {_VERDICTS[s['trusted']]}"]
    said += [f"  because      {reason}" for reason in s["reasons"]]
    if s["own"] is not None:
        said.append(f"  this machine {_one(s['own'], document)}")
    if s["order_of_error"] is not None:
        said.append(f"  order        the error falls with epsilon to the power {s['order_of_error']:.2f}")
    single = isinstance(s["along"], str)
    if s["deviations"]:
        named = s["along"] if single else f"factor of {' and '.join(s['along'])}"
        said.append(f"  along {named}, up to {s['until_phi']:.4g} rad of the rotor's angle")
    key, unit = (s["along"], f" {s['along_unit']}".rstrip()) if single else ("factor", "")
    said += [f"    {f'{d[key]:.6g}{unit}':<14} {_one(d, document)}" for d in s["deviations"]]
    for low, high in s["disagreement"]:
        where = f"at {low:.6g}{unit}" if low == high else f"from {low:.6g} to {high:.6g}{unit}"
        said.append(f"  the models end differently {where}")
    return said


def _one(d: dict[str, Any], document: dict[str, Any]) -> str:
    s = document["summary"]
    speed, length = speaking(document, s["amplitude_unit"])
    apart = "nothing in common"
    if d["speed"] is not None:
        apart = f"speeds of {s['speeds_of']} differ by {speed(d['speed'])} at most, amplitudes by {length(d['amplitude'])}"
    ends = f"both {d['outcome']}" if d["same_outcome"] else f"{d['outcome']}, slow equations {d['slow_outcome']}"
    return f"{apart}; {ends}"
