"""Names of files that others have a say in."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wucht import run_file
from wucht.file_names import DEFAULT_NAME, printable, safe_name
from wucht.files.catalogue import short_name
from wucht.results.spreadsheets import save_csv


@given(st.text())
def test_a_safe_name_is_one_file_of_its_folder(text: str) -> None:
    name = safe_name(text)
    assert name == Path(name).name
    assert name not in ("", ".", "..")
    assert name.isprintable()
    assert len(name.encode()) <= 201  # with the "-" after what Windows keeps for itself


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("my machine 2.1", "my machine 2.1"),
        ("Prüfstand", "Prüfstand"),
        ("../../x", "x"),
        ("/etc/passwd", "etc-passwd"),
        ("a\nb\x1b[31mc", "a-b-31mc"),
        ("CON", "CON-"),
        ("x" * 300, "x" * 100),
        (90 * "洗", 66 * "洗"),
    ],
)
def test_safe_names(text: str, name: str) -> None:
    assert safe_name(text) == name


def test_what_is_said_of_a_name_is_one_line_of_utf_8() -> None:
    assert printable("a\nb\x1b[1m\udcff.toml") == "a?b?[1m?.toml"
    assert printable("洗濯\u3000機 2.1") == "洗濯\u3000機 2.1"


def test_a_study_file_called_by_dots_alone_is_kept_in_no_folder_above() -> None:
    assert short_name(Path("somewhere/...toml")) == Path(DEFAULT_NAME)
    assert short_name(Path("somewhere/a.toml")) == Path("a")


def test_tables_stay_in_their_folder_and_begin_no_formula(tmp_path: Path) -> None:
    result = run_file("drozdetskaya-2020/r1", {"study.until": 0.2})
    result.attrs["study"] = "../../x"
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    result["said"] = ((), "=HYPERLINK(1)")
    result["less"] = ((), "-1.5e3")
    written = save_csv(result, folder)
    assert {path.parent for path in written} == {folder}
    assert sorted(folder.iterdir()) == sorted(written)
    assert [p for p in tmp_path.rglob("*") if p.is_file()] and {p.parent for p in tmp_path.rglob("*.csv")} == {folder}
    cells = {row[0]: row[1] for row in csv.reader((folder / "x-numbers.csv").open(encoding="utf-8"))}
    assert cells["said"] == "'=HYPERLINK(1)"
    assert cells["less"] == "-1.5e3"
