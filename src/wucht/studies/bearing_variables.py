"""Forces on bearings, and their life, in an answer."""

from __future__ import annotations

import math
from collections.abc import Mapping

from wucht.dynamics.run_ups.bearing_loads import BearingLife, BearingLoad
from wucht.results.formatting import number_text
from wucht.studies.answer import Answer

_MOST_ROTORS = 6  # named one by one
_FOREVER = 1e7  # h, beyond which a life is no prediction


def state_loads(a: Answer, loads: Mapping[str, BearingLoad], is_shown: bool, mark: str = "") -> None:
    """State the forces of rotors on their bearings at the end of a run. is_shown: in a line, with a mark at its end."""
    if not loads:
        return
    largest, steady, peak = ({n: getattr(load, key) for n, load in loads.items()} for key in ("largest", "steady", "peak"))
    vectors = {name: list(load.vector) for name, load in loads.items()}
    a.number("bearing_forces", largest, "largest force of each rotor on the carrier at the end", "N")
    a.number("steady_bearing_forces", steady, "mean magnitude of the force of each rotor at the end", "N")
    a.number("mean_bearing_force_vectors", vectors, "mean force of each rotor at the end, in x and y", "N")
    a.number("peak_bearing_forces", peak, "largest force of each rotor in the whole run", "N")
    if is_shown:
        first = sorted(steady, key=lambda name: -largest[name])[:_MOST_ROTORS]
        listing = ", ".join(f"{n} {force_text(f)} ({force_text(largest[n])} at most)" for n, f in steady.items() if n in first)
        more = f"; {len(steady) - _MOST_ROTORS} smaller ones" if len(steady) > _MOST_ROTORS else ""
        in_run = f"{force_text(max(peak.values()))} at most in the whole run"
        a.line("bearings", "{listing}", listing=f"{listing} at the end{more}; {in_run}{mark}")


def state_lives(a: Answer, lives: Mapping[str, BearingLife], mark: str = "") -> None:
    """State the life of bearings that have a rating; in the line the shortest of many, with a mark at its end."""
    if not lives:
        return
    loads, hours = ({n: getattr(life, key) for n, life in lives.items()} for key in ("load", "hours"))
    a.number("equivalent_bearing_loads", loads, "equivalent load of each rotor's bearing, ISO 281", "N")
    a.number("bearing_life", hours, "life of each rotor's bearing, ISO 281", "h")
    shortest = sorted(lives, key=lambda name: math.inf if hours[name] is None else float(hours[name] or 0.0))[:_MOST_ROTORS]
    texts = [f"{name} {_hours(life)}" for name, life in lives.items() if name in shortest]
    more = f"; {len(lives) - _MOST_ROTORS} longer ones" if len(lives) > _MOST_ROTORS else ""
    a.line("bearing life", "{lives}", lives=f"{', '.join(texts)} (ISO 281, nine of ten){more}{mark}")


def force_text(value: float) -> str:
    """Return a force in N, or kN, as text."""
    return str(number_text(value, "N"))


def _hours(life: BearingLife) -> str:
    if life.hours is None or life.load is None:
        return "has no load" if life.load is not None else "does not turn"
    return (
        f"{number_text(life.hours, 'h')} under {force_text(life.load)}"
        if life.hours < _FOREVER
        else f"more than {_FOREVER:,.0f} h"
    )
