"""Texts for other programs."""

import numpy as np
from tests.refusals import failed, refused

from wucht.cams.workshop.lists import format_decimals, write_ascii


def test_a_text_comes_back(tmp_path):
    path = write_ascii(tmp_path / "a.txt", "1 2\n3 4\n")
    assert path.read_bytes() == b"1 2\n3 4\n"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_a_folder_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "a.txt", tmp_path / "missing" / "a.txt"):
        with failed("not-written"):
            write_ascii(path, "x")
    (tmp_path / "folder").mkdir()
    with failed("not-written"):
        write_ascii(tmp_path / "folder", "x")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]


def test_plain_letters_only(tmp_path):
    with refused("a.txt", "ASCII", given=None):
        write_ascii(tmp_path / "a.txt", "Kurve für Öl")
    assert list(tmp_path.iterdir()) == []


def test_decimals_without_a_negative_zero():
    assert format_decimals(np.array([-0.0004, 1.0005, -2.0]), 3) == ["0.000", "1.000", "-2.000"]
    assert format_decimals(np.array([2.6]), 0) == ["3"]
