"""Titles speak of the values that were set, not of those that the file had."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from wucht.files.catalogue import load_equations, load_machine
from wucht.files.changed_title import changed_title


@pytest.mark.parametrize(
    ("name", "settings", "title"),
    [
        ("drozdetskaya-2020/figure-5.14", {}, "Figure 5.14: u = 2.5"),
        ("drozdetskaya-2020/figure-5.14", {"u": 5.0}, "Figure 5.14: u = 5 (changed from 2.5)"),
        ("drozdetskaya-2020/figure-5.14", {"u": 2.5}, "Figure 5.14: u = 2.5"),
        ("drozdetskaya-2020/figure-5.14", {"mu": 0.2}, "Figure 5.14: u = 2.5 (changed: mu = 0.2)"),
        ("drozdetskaya-2020/r1-u80", {"drive": {"slope": "0.02 N m s"}}, "R1, u = 80 (changed: drive.slope = 0.02 N m s)"),
    ],
)
def test_a_catalogue_machine_with_other_values(name: str, settings: dict[str, Any], title: str) -> None:
    assert load_machine(name, settings).title == title


def test_own_equations() -> None:
    assert (
        load_equations("drozdetskaya-2020/figure-2.13", {"mu": 1.2}).title == "Infinite-period bifurcation (changed: mu = 1.2)"
    )


def test_what_a_file_sets_is_known_to_its_own_title_and_to_no_other(here: Path) -> None:
    del here
    used = '[machine]\nuse = "drozdetskaya-2020/figure-5.14"\nset = { u = 5 }\n'
    Path("untitled.toml").write_text(used, encoding="utf-8")
    Path("titled.toml").write_text(f'title = "With u = 5"\n{used}', encoding="utf-8")
    assert load_machine("untitled.toml").title == "Figure 5.14: u = 5 (changed from 2.5)"
    assert load_machine("titled.toml").title == "With u = 5"
    assert load_machine("titled.toml", {"u": 6.0}).title == "With u = 6 (changed from 5)"
    assert load_machine("untitled.toml", {"u": 6.0}).title == "Figure 5.14: u = 6 (changed from 2.5)"


def test_a_name_within_another_is_left_alone() -> None:
    assert changed_title("At mu = 0.1, u = 2e-3", {"u": 1.0}) == "At mu = 0.1, u = 1 (changed from 2e-3)"
    assert changed_title("At drive.u = 3 and u1 = 4", {"u": 1.0}) == "At drive.u = 3 and u1 = 4 (changed: u = 1)"


def test_many_values_and_long_ones() -> None:
    changed = {"a": 1, "b": [1, 2], "c": "3 m", "d": 4.0, "e": 5}
    assert changed_title("T", changed) == "T (changed: a = 1, b = ..., c = 3 m and 2 more)"
