"""Numbers of the README are those of benchmarks, which print them beside what they measure."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from benchmarks import __main__ as benchmarks
from benchmarks.readme import README, StatedNumber, stated_numbers


def _cost() -> str:
    """The section of the README on costs, without its marks."""
    section = README.read_text(encoding="utf-8").partition("\n## Cost\n")[2].partition("\n## ")[0]
    return re.sub(r"<!-- bench: .+? -->.+?<!-- end -->", "", section)


def test_numbers_of_costs_are_marked() -> None:
    """But for those that say what was measured."""
    conditions = {"two", "320", "1e-9", "Thirty", "twelve", "64"}
    words = {"two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "twelve", "thirty"}
    said = {
        word
        for word in re.findall(r"\b\d+(?:\.\d+)?(?:e-?\d+)?|[A-Za-z]+\d*", _cost())
        if word[0].isdigit() or word.lower() in words
    }
    assert said <= conditions
    assert len(stated_numbers()) >= 8


@pytest.mark.parametrize("number", stated_numbers(), ids=lambda number: number.label)
def test_a_stated_number_is_measured(number: StatedNumber) -> None:
    """There is a benchmark that has this label."""
    source = Path(benchmarks.ALL[number.benchmark].__file__).read_text(encoding="utf-8")
    assert re.search(rf'f?"{re.escape(number.label)}', source)
