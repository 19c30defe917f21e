"""What the figure of a map looks like."""

from __future__ import annotations

import math
from itertools import combinations

import pytest

from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.studies.basin.figure import _LOOKS, multiples_of_pi


def test_all_outcomes_can_be_told_apart_without_colour() -> None:
    """Any two differ in their hatch, or clearly in brightness (ITU-R BT.709)."""
    assert set(_LOOKS) == {str(o) for o in Outcome}

    def brightness(colour: str) -> float:
        red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    for (one, hatch), (other, other_hatch) in combinations(_LOOKS.values(), 2):
        assert hatch != other_hatch or abs(brightness(one) - brightness(other)) > 0.2


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (0.0, 2 * math.pi, ["0", "π/2", "π", "3π/2", "2π"]),
        (-math.pi, math.pi, ["-π", "-π/2", "0", "π/2", "π"]),
        (0.0, math.pi / 2, ["0", "π/8", "π/4", "3π/8", "π/2"]),
        (0.0, 4 * math.pi, ["0", "π", "2π", "3π", "4π"]),
        (0.1, 0.2, []),
        (0.0, 40 * math.pi, []),
    ],
)
def test_ticks_of_angles(low: float, high: float, words: list[str]) -> None:
    ticks = multiples_of_pi(low, high)
    assert [word for _, word in ticks] == words
    # 3π/4 is 3 * pi / 4
    for at, word in ticks:
        number, _, parts = word.partition("/")
        times = {"0": "0", "π": "1", "-π": "-1"}.get(number, number.removesuffix("π"))
        assert at == pytest.approx(int(times) * math.pi / int(parts or 1))
