"""The margin of synchronism of exciters in an answer."""

from __future__ import annotations

from collections.abc import Sequence

from wucht.analysis.synchronising_torque import SynchronisationMargin
from wucht.studies.answer import Column


def synchronisation_columns(margins: Sequence[SynchronisationMargin | None]) -> dict[str, Column]:
    """Return the margins of several states, as columns of a table."""
    return {
        "largest_moment": (
            [m and m.largest for m in margins], "largest vibration torque that can pass between the rotors", "torque"
        ),
        "passing_moment": (
            [m and m.passing for m in margins], "vibration torque that has to pass between the rotors", "torque"
        ),
        "synchronisation_margin": ([m and m.margin for m in margins], "torque that can pass over that which has to"),
        "margin_within_tolerances": (
            [m and m.within_tolerances for m in margins], "least such margin within the tolerances of the motors' slip"
        ),
    }  # fmt: skip


def margin_in_words(margin: SynchronisationMargin) -> str:
    """Return the text of a line on a margin."""
    needed = "none has to" if margin.margin is None else "{passing_moment} has to: margin {synchronisation_margin:.3g}"
    tolerance = "; {margin_within_tolerances:.3g} within the tolerances of the motors' slip (IEC 60034-1)"
    return f"{{largest_moment}} can pass between the rotors, {needed}{'' if margin.within_tolerances is None else tolerance}"
