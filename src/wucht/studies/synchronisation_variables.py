"""The margin of synchronism of exciters in an answer."""

from __future__ import annotations

from collections.abc import Sequence

from wucht.analysis.synchronising_torque import SynchronisationMargin
from wucht.studies.answer import Column

COLUMN = "synchronisation_"  # before the names of columns


def synchronisation_columns(margins: Sequence[SynchronisationMargin | None]) -> dict[str, Column]:
    """Return the margins of several states, as columns of a table."""
    return {
        "synchronisation_available": (
            [m and m.largest for m in margins], "largest vibration torque that can pass between the rotors", "torque"
        ),
        "synchronisation_used": (
            [m and m.passing for m in margins], "vibration torque that has to pass between the rotors", "torque"
        ),
        "synchronisation_ratio": ([m and m.margin for m in margins], "torque that can pass over that which has to"),
        "synchronisation_ratio_within_tolerances": (
            [m and m.within_tolerances for m in margins], "least such margin within the tolerances of the motors' slip"
        ),
    }  # fmt: skip


def margin_in_words(margin: SynchronisationMargin, before: str = COLUMN) -> str:
    """Return the text of a line on a margin. before: in the names of its numbers."""
    needed = "none has to" if margin.margin is None else f"{{{before}used}} has to: margin {{{before}ratio:.3g}}"
    tolerance = f"; {{{before}ratio_within_tolerances:.3g}} within the tolerances of the motors' slip (IEC 60034-1)"
    within = "" if margin.within_tolerances is None else tolerance
    return f"{{{before}available}} can pass between the rotors, {needed}{within}"
