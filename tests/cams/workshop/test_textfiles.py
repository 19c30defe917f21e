"""Files that are never half there."""

import numpy as np
import pytest

from wucht.cams.workshop.textfiles import decimal, read_text, written, written_text
from wucht.errors import InputError, RunError


def test_a_text_comes_back(tmp_path):
    path = written_text(tmp_path / "a.txt", "1 2\n3 4\n")
    assert path.read_bytes() == b"1 2\n3 4\n"
    assert read_text(path) == "1 2\n3 4\n"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_a_failure_leaves_what_was_there(tmp_path):
    path = written_text(tmp_path / "a.txt", "old")

    def fails(beside):
        beside.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(RunError, match=r"a\.txt cannot be written: No space left on device"):
        written(path, fails)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_a_folder_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "a.txt", tmp_path / "missing" / "a.txt"):
        with pytest.raises(RunError, match="cannot be written"):
            written_text(path, "x")
    (tmp_path / "folder").mkdir()
    with pytest.raises(RunError, match="cannot be written"):
        written_text(tmp_path / "folder", "x")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]


def test_what_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        read_text(tmp_path / "a.txt")
    (tmp_path / "b.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="it is no text file"):
        read_text(tmp_path / "b.txt")


def test_plain_letters_only(tmp_path):
    with pytest.raises(InputError, match="plain ASCII"):
        written_text(tmp_path / "a.txt", "Kurve für Öl")
    assert list(tmp_path.iterdir()) == []


def test_decimals_without_a_negative_zero():
    assert decimal(np.array([-0.0004, 1.0005, -2.0]), 3) == ["0.000", "1.000", "-2.000"]
    assert decimal(np.array([2.6]), 0) == ["3"]
