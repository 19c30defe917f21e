"""What the figure of a map looks like."""

from __future__ import annotations

from itertools import combinations

from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.studies.basin.figure import _LOOKS


def test_all_outcomes_can_be_told_apart_without_colour() -> None:
    """Any two differ in their hatch, or clearly in brightness (ITU-R BT.709)."""
    assert set(_LOOKS) == {str(o) for o in Outcome}

    def brightness(colour: str) -> float:
        red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    for (one, hatch), (other, other_hatch) in combinations(_LOOKS.values(), 2):
        assert hatch != other_hatch or abs(brightness(one) - brightness(other)) > 0.2
