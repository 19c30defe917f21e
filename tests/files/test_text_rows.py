"""Rows as spreadsheets and loggers write them."""

import pytest

from wucht.files.text_rows import cells_of


@pytest.mark.parametrize(
    ("line", "separator", "least", "cells"),
    [
        ('"time [s]";"speed [1/min]";;', ";", 1, ["time [s]", "speed [1/min]"]),
        ("5;", ";", 2, ["5", ""]),
        ("5;", ";", 1, ["5"]),
        ("time [m s]  speed (1 / min)", None, 1, ["time [m s]", "speed (1 / min)"]),
        ("1, 2 ,3", ",", 1, ["1", "2", "3"]),
    ],
)
def test_cells(line: str, separator: str | None, least: int, cells: list[str]) -> None:
    assert cells_of(line, separator, least) == cells
