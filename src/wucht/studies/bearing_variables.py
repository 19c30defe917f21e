"""The life of bearings in a summary, and its line in a report."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from wucht.dynamics.run_ups.bearing_loads import BearingLife, BearingLoad
from wucht.results.quantities import Quantity

_MOST_BEARINGS = 6  # listed one by one
_FOREVER = 1e7  # h, beyond which a life is no prediction


def load_quantities(loads: Mapping[str, BearingLoad]) -> list[Quantity]:
    """Return the quantities of the forces of rotors on their bearings at the end of a run."""
    if not loads:
        return []
    of = {name: [getattr(load, name) for load in loads.values()] for name in ("largest", "steady", "vector", "peak")}
    by_rotor = {name: dict(zip(loads, values, strict=True)) for name, values in of.items()}
    vectors = {name: list(vector) for name, vector in by_rotor["vector"].items()}
    return [
        Quantity("bearing_forces", by_rotor["largest"], "largest force of each rotor on the carrier at the end", "N"),
        Quantity("steady_bearing_forces", by_rotor["steady"], "mean magnitude of the force of each rotor at the end", "N"),
        Quantity("mean_bearing_force_vectors", vectors, "mean force of each rotor at the end, in x and y", "N"),
        Quantity("peak_bearing_forces", by_rotor["peak"], "largest force of each rotor in the whole run", "N"),
    ]


def life_quantities(lives: Mapping[str, BearingLife]) -> list[Quantity]:
    """Return the quantities of the life of bearings that have a rating."""
    if not lives:
        return []
    loads, hours = ({n: getattr(life, key) for n, life in lives.items()} for key in ("load", "hours"))
    return [
        Quantity("equivalent_bearing_loads", loads, "equivalent load of each rotor's bearing, ISO 281", "N"),
        Quantity("bearing_life", hours, "life of each rotor's bearing, ISO 281", "h"),
    ]


def life_text(summary: Mapping[str, Any]) -> str:
    """Return the lives of bearings as text, the shortest of many; empty where none has a rating."""
    lives: dict[str, float | None] = summary.get("bearing_life") or {}
    if not lives:
        return ""
    shortest = sorted(lives, key=lambda name: math.inf if lives[name] is None else float(lives[name] or 0.0))[:_MOST_BEARINGS]
    loads = summary["equivalent_bearing_loads"]
    texts = [f"{name} {_hours(hours, loads[name])}" for name, hours in lives.items() if name in shortest]
    more = f"; {len(lives) - _MOST_BEARINGS} longer ones" if len(lives) > _MOST_BEARINGS else ""
    return f"{', '.join(texts)} (ISO 281, nine of ten){more}"


def force_text(value: float) -> str:
    """Return a force in N, or kN, as text."""
    return f"{value / 1e3:.4g} kN" if value >= 1e3 else f"{value:.4g} N"


def _hours(life: float | None, load: float | None) -> str:
    if life is None or load is None:
        return "has no load" if load is not None else "does not turn"
    return f"{life:.4g} h under {force_text(load)}" if life < _FOREVER else f"more than {_FOREVER:.0e} h"
