"""Rows as spreadsheets and loggers write them."""

import pytest

from wucht.files.text_rows import cells_of, plain_number, separator_of, without_comment


@pytest.mark.parametrize(
    ("line", "separator", "least", "cells"),
    [
        ('"time [s]";"speed [1/min]";;', ";", 1, ["time [s]", "speed [1/min]"]),
        ("5;", ";", 2, ["5", ""]),
        ("5;", ";", 1, ["5"]),
        ("time [m s]  speed (1 / min)", None, 1, ["time [m s]", "speed (1 / min)"]),
        ("1, 2 ,3", ",", 1, ["1", "2", "3"]),
        ('"a, b", "say ""c"""', ",", 1, ["a, b", 'say "c"']),
        ('"a b"   c', None, 1, ["a b", "c"]),
        ('"a, 2', ",", 1, ["a", "2"]),
        ('"a", ' + 200_000 * "b", ",", 1, ["a", 200_000 * "b"]),
    ],
)
def test_cells(line: str, separator: str | None, least: int, cells: list[str]) -> None:
    assert cells_of(line, separator, least) == cells


@pytest.mark.parametrize(
    ("line", "separator", "text"),
    [
        ('"a;b",c # d', ",", '"a;b",c'),
        ('"a #1";b', ";", '"a #1";b'),
        ('"a #1', None, '"a'),
        ("# only", None, ""),
    ],
)
def test_quoted_cells_neither_separate_nor_begin_a_comment(line: str, separator: str | None, text: str) -> None:
    assert without_comment(line) == text
    assert separator_of(without_comment(line)) == separator


@pytest.mark.parametrize("text", ["٣", "３", "1_0", "1,5", "x"])
def test_numbers_have_the_digits_0_to_9(text: str) -> None:
    assert plain_number("-1.5e2") == -150
    with pytest.raises(ValueError, match=text):
        plain_number(text)
