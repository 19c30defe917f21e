"""The end of a run-up from rest in the result of a study of steady states."""

from __future__ import annotations

from dataclasses import asdict

from wucht.dynamics.run_ups.settled_from_rest import SettledFromRest
from wucht.machines.structure import Units
from wucht.results.quantities import Quantity

REACHED = ("whether it is reached from rest, null where that is not known", "")


def from_rest_quantity(end: SettledFromRest | None, units: Units) -> Quantity:
    """Return the end of the run-up from rest, None where there was none."""
    parts = {
        "outcome": ("outcome", ""),
        "sentence": ("sentence on the end, or why it is not known", ""),
        "speeds": ("mean speeds of the rotors in magnitude", units.speed),
        "phases": ("phases of the other rotors to the main one", "rad"),
        "share": ("residual unbalance, as a share of the main rotor's", ""),
        "end_time": ("time at the end", units.time),
    }
    value = None if end is None else asdict(end)
    return Quantity("from_rest", value, "end of a run-up from rest, with the start of the machine", parts=parts)
