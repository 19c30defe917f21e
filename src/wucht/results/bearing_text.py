"""Forces on bearings, and their life, as text in reports."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

_MOST_BEARINGS = 6  # listed one by one
_FOREVER = 1e7  # h, beyond which a life is no prediction


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
