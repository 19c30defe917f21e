"""Numbers as they are printed."""

from __future__ import annotations

import pytest

from wucht.results.formatting import percent, value_in_words


@pytest.mark.parametrize(
    ("share", "off", "words"),
    [
        (0.24881, 0.0075, "24.88 % ± 0.75 %"),
        (0.0389, 0.000112, "3.890 % ± 0.011 %"),
        (0.83, 0.14, "83 % ± 14 %"),
        (0.5, 0.0, "50 %"),
        (1.0, float("nan"), "100 %"),
        (0.5, 1e-12, "50.000000 % ± 0.000000 %"),
    ],
)
def test_as_many_decimals_as_the_uncertainty_is_worth(share: float, off: float, words: str) -> None:
    assert percent(share, off) == words


def test_several_numbers_are_printed_by_the_same_factor() -> None:
    assert value_in_words([0.001, 0.0025], 1e3, "mm") == "[1, 2.5] mm"
    assert value_in_words(0.001, 1e3, "mm") == "1 mm" and value_in_words(True, 1e3, "mm") == "True"
