"""Numbers of the README are those of benchmarks, which print them beside what they measure."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from benchmarks import __main__ as benchmarks
from benchmarks.readme import StatedNumber, stated_numbers


@pytest.mark.parametrize("number", stated_numbers(), ids=lambda number: number.label)
def test_a_stated_number_is_measured(number: StatedNumber) -> None:
    """There is a benchmark that has this label."""
    source = Path(benchmarks.ALL[number.benchmark].__file__).read_text(encoding="utf-8")
    assert re.search(rf'f?"{re.escape(number.label)}', source)
