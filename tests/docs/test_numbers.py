"""Numbers in sentences and tables of pages are those of the results: filled in, not typed."""

from __future__ import annotations

import re

import pytest
from docs.site.numbers import PAGES, as_written, numbers_of, pages_with_numbers, with_numbers

MARKED = {path.relative_to(PAGES).as_posix(): path for path in pages_with_numbers()}
CAM = "practice/carton-pusher --set study.simulate=0 --set study.cuts=1"


@pytest.mark.parametrize("name", MARKED)
def test_marks_are_complete_and_their_files_can_be_read(name: str) -> None:
    page = MARKED[name].read_text(encoding="utf-8")
    numbers = numbers_of(page)
    opened, closed = len(re.findall("<!-- = (?!-->)", page)), page.count("<!-- = -->")
    assert len(numbers) == opened == closed, "a mark that is none"
    for number in dict.fromkeys((one.file, one.options) for one in numbers):
        assert next(one for one in numbers if (one.file, one.options) == number).study()


def test_all_pages_of_machines_have_their_numbers_from_results() -> None:
    of_machines = {path.relative_to(PAGES).as_posix() for path in (PAGES / "practice").glob("*.md")}
    assert of_machines <= set(MARKED)


@pytest.mark.slow
@pytest.mark.parametrize("name", MARKED)
def test_the_numbers_of_a_page_are_those_of_the_results(name: str) -> None:
    page = MARKED[name].read_text(encoding="utf-8")
    assert [n.text for n in numbers_of(page)] == [n.text for n in numbers_of(with_numbers(page))], "make numbers fills them in"


def test_a_number_is_filled_in_with_its_unit_and_its_decimals() -> None:
    """In SI the summary has 0.1158 and 0.0034 m."""
    marks = (("fluctuation %", "0.0"), ("position_error.original mm", "9"), ("cut_residuals.0", "0.1e-1"), ("driven", "`none`"))
    page = "It swings by " + ", ".join(f"<!-- = {CAM} | {name} -->{text}<!-- = -->" for name, text in marks)
    filled = with_numbers(page)
    assert [n.text for n in numbers_of(filled)] == ["11.6", "3", "7.4e-2", "`drive`"]
    assert with_numbers(filled) == filled and filled.startswith("It swings by <!-- = practice/carton-pusher")


@pytest.mark.parametrize(("text", "value", "written"), [
    ("0.44", 0.4586, "0.46"), ("7e-6", 8.4e-6, "8e-6"), ("1.5e3", 2345.0, "2.3e3"), ("12", 11.58, "12"), ("0.0", -1.26, "-1.3"),
])  # fmt: skip
def test_as_many_decimals_as_stand_there(text: str, value: float, written: str) -> None:
    assert as_written(text, value) == written


def test_a_mark_that_cannot_be_read_is_refused() -> None:
    with pytest.raises(ValueError, match="must be a path in the summary and a unit"):
        numbers_of("<!-- = practice/screen | last week final_speed rad/s -->1<!-- = -->")
    assert not numbers_of("As code `<!-- = FILE | NAME -->1<!-- = -->`.")
