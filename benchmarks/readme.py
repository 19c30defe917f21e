"""The numbers that the README states of benchmarks, each in a mark with the benchmark and the beginning of its label."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"
_MARK = re.compile(r"<!-- bench: (\w+) \| (.+?) -->(.+?)<!-- end -->")


@dataclass(frozen=True)
class StatedNumber:
    """A number of the README: what it says, the benchmark, and how the label begins."""

    text: str
    benchmark: str
    label: str


def stated_numbers() -> list[StatedNumber]:
    """All of them, in their order."""
    found = _MARK.findall(README.read_text(encoding="utf-8"))
    return [StatedNumber(text, benchmark, label) for benchmark, label, text in found]
