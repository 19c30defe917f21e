"""The end of a run-up from rest in the result of a study of steady states."""

from __future__ import annotations

from dataclasses import asdict

from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.studies.answer import Answer

FROM_REST_WORDS = ("whether it is reached from rest, null where that is not known", "")


def state_ends_from_rest(a: Answer, from_rest: FromRest | None) -> None:
    """State the ends of run-ups from rest, none where there was no run."""
    parts = {
        "outcome": ("outcome", ""),
        "sentence": ("sentence on the end, or why it is not known", ""),
        "speeds": ("mean speeds of the rotors in magnitude", a.unit("speed")),
        "phases": ("phases of the other rotors to the main one", "rad"),
        "share": ("residual unbalance, as a share of the main rotor's", ""),
        "end_time": ("time at the end", a.unit("time")),
    }
    rows = [] if from_rest is None else [asdict(end) for end in from_rest.ends]
    a.number("from_rest", rows, "ends of run-ups from rest, with the default start of the machine", parts=parts)
