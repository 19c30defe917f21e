"""What the kinds of a map are called, of its regions, curves and points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wucht.numerics.periodic.branch_ends import RANGE, SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.studies.stability_map.ending_curves import DOUBLE
from wucht.studies.stability_map.orbit_endings import NONE

MODULATED = "modulated motion"
UNKNOWN = "not identified"
UNNAMED = "a steady state that was not found"
UNSETTLED = "a motion that neither rests nor repeats itself"
ENDINGS: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "ends at a saddle-node on the orbit",
    SADDLE_CONNECTION: "ends at a saddle connection",
    RANGE: "lasts to the end of the range",
    NONE: "no modulated motion begins",
}
SHORT: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "saddle-node on the orbit",
    SADDLE_CONNECTION: "saddle connection",
    RANGE: "end of the range",
    NONE: "no modulated motion",
}
POINTS: Mapping[str, str] = {DOUBLE: "connection of two saddle-nodes"}
ORBIT_CURVES: Mapping[str, str] = {
    "branch-point": "loses stability sideways",
    "fold": "fold",
    "period-doubling": "period doubling",
    "torus": "torus",
    SADDLE_CONNECTION: "saddle connection",
    SADDLE_NODE_ON_ORBIT: "saddle-node on it",
}
LEVELS = ("", f"{MODULATED} unstable", f"{MODULATED} stable")
TONES: Mapping[str, int] = {SADDLE_NODE_ON_ORBIT: 2, SADDLE_CONNECTION: 1, RANGE: 3, NONE: 0}


def state_label(names: Sequence[str], level: int, sought: bool) -> str:
    """``together, modulated motion stable``: what is stable besides what is everywhere. sought: modulated motions were."""
    parts = [*names, LEVELS[level]] if level else [*names]
    return ", ".join(parts) or ("nothing else" if sought else "no other steady state")


def numbered(names: Sequence[str]) -> list[str]:
    """The same, names that occur again with a number: ``fold: together``, ``fold: together (2)``."""
    seen, made = dict[str, int](), []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        made.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return made
