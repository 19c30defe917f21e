"""Numbers in sentences and tables of pages are those of the results: filled in, not typed."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from docs.site import page_figures
from docs.site.numbers import PAGES, as_written, numbers_of, pages_with_numbers, with_numbers, without_numbers
from page_blocks import PAGES as ALL
from page_blocks import blocks, without_blocks

from wucht.files.catalogue import FOLDER, names

MARKED = {path.relative_to(PAGES).as_posix(): path for path in pages_with_numbers()}
# Pages whose numbers with units are no results of runs on them, or have a test of their own.
OTHERS = {
    "README.md": "times, of make bench",
    "docs/averaging.md": "formulas",
    "docs/cam-files.md": "limits of criteria",
    "docs/design.md": "times, of measurements that are kept as they were",
    "docs/errata.md": "written by tests/validation/errata",
    "docs/live-machine.md": "limits of the program",
    "docs/machine-files.md": "criteria and defaults",
    "docs/outcomes.md": "criteria",
    "docs/several-machines.md": "times",
    "docs/slow-equations.md": "criteria",
    "docs/switchable-pendulums.md": "test_switchable_pendulums_page",
    "docs/symbols.md": "notation",
}
CHECKED = {name: path for name, path in ALL.items() if name not in OTHERS}
UNITS = {  # as pages write them: what they measure, and one of them in SI
    "m": ("m", 1), "mm": ("m", 1e-3), "µm": ("m", 1e-6), "micrometres": ("m", 1e-6), "kg": ("kg", 1), "g": ("kg", 1e-3),
    "s": ("s", 1), "ms": ("s", 1e-3), "h": ("s", 3600), "hours": ("s", 3600), "Hz": ("Hz", 1), "%": ("%", 1), "V": ("V", 1),
    "rad/s": ("rad/s", 1), "rpm": ("rad/s", math.pi / 30), "rad/s2": ("rad/s2", 1), "m/s2": ("m/s2", 1),
    "degrees": ("rad", math.pi / 180), "deg": ("rad", math.pi / 180), "°": ("rad", math.pi / 180),
    "N": ("N", 1), "kN": ("N", 1e3), "N m": ("N m", 1), "N m s": ("N m s", 1), "W": ("W", 1), "kW": ("W", 1e3), "J": ("J", 1),
    "MPa": ("Pa", 1e6), "N/m": ("N/m", 1), "kN/m": ("N/m", 1e3), "N s/m": ("N s/m", 1), "kN s/m": ("N s/m", 1e3),
    "kg m": ("kg m", 1), "g m": ("kg m", 1e-3), "kg mm": ("kg m", 1e-3), "g mm": ("kg m", 1e-6), "kg m2": ("kg m2", 1),
}  # fmt: skip
_LONGEST_FIRST = "|".join(sorted(map(re.escape, UNITS), key=len, reverse=True))
_WITH_UNIT = re.compile(rf"(?<![\w.,])(\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?) ?({_LONGEST_FIRST})(?![\w/^°])")
_BY_HAND = re.compile(r"<!-- by hand: (.*?) -->")


class Quantity(NamedTuple):
    """A number with a unit as a page has it."""

    text: str
    number: str
    unit: str

    @property
    def value(self) -> float:
        return float(self.number) * UNITS[self.unit][1]

    def is_rounded(self, other: Quantity) -> bool:
        """Whether it is another one, with as many decimals as it has itself."""
        kind, one = UNITS[self.unit]
        return UNITS[other.unit][0] == kind and as_written(self.number, other.value / one) == as_written(
            self.number, float(self.number)
        )


def quantities(text: str) -> list[Quantity]:
    text = text.replace("·", " ").replace("²", "2").replace("^2", "2")
    return [Quantity(match[0], match[1].replace(",", ""), match[2]) for match in _WITH_UNIT.finditer(text)]


def typed(text: str, sources: str) -> list[str]:
    """Numbers with units in sentences and tables that are typed: neither marked nor in code, nor do sources have them."""
    sentences = without_numbers(without_blocks(text))
    known = quantities(" ".join((sources, *re.findall("`[^`]+`", re.sub("<!--.*?-->", "", sentences)))))
    by_hand = [one for listed in _BY_HAND.findall(sentences) for one in listed.split("; ")]
    of_page = quantities(re.sub("<!--.*?-->|`[^`]+`", "|", sentences))
    assert [one for one in by_hand if one not in [q.text for q in of_page]] == [], "not on the page any more"
    return [q.text for q in of_page if q.text not in by_hand and not any(map(q.is_rounded, known))]


def sources(page: Path) -> str:
    """What the page itself shows as code or as printed, which is run, and what the files of the catalogue that it names say."""
    text = page.read_text(encoding="utf-8")
    named = [tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8")) for name in names() if name in text]
    given = [value for document in named for key in document if key != "notes" for value in texts_in(document[key])]
    return " ; ".join([*(f"{block.text} {block.said}" for block in blocks(page)), *given])


def texts_in(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from texts_in(item)


@pytest.mark.parametrize("name", CHECKED)
def test_a_number_with_a_unit_is_of_a_result_or_declared_to_be_by_hand(name: str) -> None:
    """Marked, printed by a command of the page, in its code or files; or listed there: ``<!-- by hand: 3.8 N m; 2 s -->``."""
    assert typed(CHECKED[name].read_text(encoding="utf-8"), sources(CHECKED[name])) == []


def test_a_typed_number_is_noticed() -> None:
    text = "It takes 3.46 s of 12 kW, <!-- = practice/fan | final_speed rpm -->300<!-- = --> rpm."
    assert typed(text, "") == ["3.46 s", "12 kW"]
    assert typed(text, "settled at 3.457 s; 12,000 W") == []
    assert typed(text, "3.454 s, 12.6 kW") == ["3.46 s", "12 kW"]
    assert typed(f"{text} <!-- by hand: 12 kW -->", "") == ["3.46 s"]
    with pytest.raises(AssertionError, match="not on the page any more"):
        typed(f"{text} <!-- by hand: 13 kW -->", "")


@pytest.mark.slow
@pytest.mark.parametrize("name", MARKED)
def test_marks_are_complete_and_their_files_can_be_read(name: str, tmp_path: Path) -> None:
    page = MARKED[name].read_text(encoding="utf-8")
    numbers = numbers_of(page)
    opened, closed = len(re.findall("<!-- = (?!-->)", page)), page.count("<!-- = -->")
    assert len(numbers) == opened == closed, "a mark that is none"
    page_figures.write_files(page, tmp_path)
    for number in {(one.file, one.options): one for one in numbers}.values():
        assert number.study(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", MARKED)
def test_the_numbers_of_a_page_are_those_of_the_results(name: str) -> None:
    page = MARKED[name].read_text(encoding="utf-8")
    assert [n.text for n in numbers_of(page)] == [n.text for n in numbers_of(with_numbers(page))], "make numbers fills them in"
