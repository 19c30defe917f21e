"""The end of a run-up from rest in the result of a study of steady states."""

from __future__ import annotations

from dataclasses import asdict

from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.machines.structure import Units
from wucht.results.quantities import Quantity, table

FROM_REST_WORDS = ("whether it is reached from rest, null where that is not known", "")


def from_rest_quantities(from_rest: FromRest | None, units: Units) -> list[Quantity]:
    """Return the ends of run-ups from rest, none where there was no run."""
    parts = {
        "outcome": ("outcome", ""),
        "sentence": ("sentence on the end, or why it is not known", ""),
        "speeds": ("mean speeds of the rotors in magnitude", units.speed),
        "phases": ("phases of the other rotors to the main one", "rad"),
        "share": ("residual unbalance, as a share of the main rotor's", ""),
        "end_time": ("time at the end", units.time),
    }
    rows = [] if from_rest is None else [asdict(end) for end in from_rest.ends]
    return table("from_rest", rows, "ends of run-ups from rest, with the default start of the machine", parts)
