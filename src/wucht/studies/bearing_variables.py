"""Forces on bearings, and their life, in a summary."""

from __future__ import annotations

from collections.abc import Mapping

from wucht.dynamics.run_ups.bearing_loads import BearingLife, BearingLoad
from wucht.results.bearing_text import life_text
from wucht.results.quantities import Quantity
from wucht.studies.answer import Answer


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


def state_lives(a: Answer, lives: Mapping[str, BearingLife]) -> None:
    """State the life of bearings that have a rating."""
    a.add(life_quantities(lives))
    loads, hours = ({n: getattr(life, key) for n, life in lives.items()} for key in ("load", "hours"))
    if lives:
        a.line("bearing life", "{lives}", lives=life_text({"bearing_life": hours, "equivalent_bearing_loads": loads}))
