"""The steady phase configurations in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import ReportLines

if TYPE_CHECKING:
    import xarray as xr

_MOST = 24  # states named one by one
_LINE = 0.5  # of the motion across over that along, below which it throws in a direction
_GENTLE = 0.05  # machine number below which the vibration is nothing to speak of


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for synchronous states."""
    s, lines = result.wucht.summary, ReportLines(result)
    lines.add("speed", "{speed}, given")
    for state in (s["states"][k] for k in chosen([entry["verdict"] for entry in s["states"]], _MOST)):
        name = (state["name"] or "no name") + (f" ({state['type']})" if state["type"] else "")
        lines.add(f"{name:18} ", _line(state, "" if s["speed"] is not None else " at {speed}", s["full"]), state, "states")
        if s["full"]:
            lines.add("", "{why}", state)
        if state.get("machine_number", 0.0) >= _GENTLE and not state["verdict"].startswith("unstable"):
            lines.add("", _throw(state))
    if len(s["states"]) > _MOST:
        lines.add(f"and {len(s['states']) - _MOST} more: see the Dataset", "")
    lines.add("complete", f"{'yes' if s['complete'] else 'not shown'}: {s['shown']}")
    if s["map"] is not None:
        shares = "; ".join(f"{name} {100 * share:.0f} %" for name, share in s["map"]["stable_share"].items() if share)
        lines.add("map", f"stable: {shares}")
    return lines.report(s["sentence"])


def chosen(verdicts: Sequence[str], most: int) -> list[int]:
    """Those that are shown, in their order: where there are too many, those are left out first that are not stable."""
    return sorted(sorted(range(len(verdicts)), key=lambda k: verdicts[k].startswith("unstable"))[:most])


def _line(state: dict[str, Any], at: str, full: bool) -> str:
    angles = ", ".join(f"{body} {_degrees(phase)}\u00b0" for body, phase in state["phases"].items())
    left = "" if state["residual_share"] is None else ", {residual_share:%} of the unbalance left"
    family = ", one of a family of dimension {family_dimension:d}" if state["family_dimension"] else ""
    several = ", {multiplicity:d} ways" if state["multiplicity"] > 1 and not family else ""
    overlap = ", but bodies of a track would lie in each other's place" if state["overlapping"] else ""
    return f"{_stability(state, full)}{at}: {angles}{left}{family}{several}{overlap}"


def _throw(state: dict[str, Any]) -> str:
    """What it does to the carrier, and to what lies on it."""
    way = f" at {math.degrees(state['throw_direction']):.1f}\u00b0" if state["throw_ratio"] < _LINE else ""
    return f"stroke {1e3 * state['stroke']:.4g} mm peak to peak{way}, machine number {state['machine_number']:.3g}"


def _degrees(phase: float) -> str:
    """A phase in degrees; what is rounded to a whole turn is 0."""
    return f"{round(math.degrees(phase), 2) % 360:.2f}"


def _stability(state: dict[str, Any], full: bool) -> str:
    slow, exact = state["stable_slow"], state["stable_full"]
    words = {True: "stable", False: "unstable", None: "undecided"}
    if not full:
        return f"{words[slow]} in the averaged equations"
    if slow == exact:
        return words[slow]
    return f"{words[slow]} in the slow, {words[exact]} in the full equations"
