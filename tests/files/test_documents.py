"""Files that are no files, or too large to be read."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from wucht.errors import InputError
from wucht.files.documents import LARGEST, contents_of, read_text

Refused = Callable[..., str]
Study = Callable[..., Path]


def test_a_device_is_not_read(refused: Refused, study: Study) -> None:
    """It would be read until the memory is full."""
    linear = 'kind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"'
    file = study(linear, 'kind = "table"\nfile = "/dev/zero"')
    refused("run", file, says=("study.toml: machine.drive.file: given '/dev/zero'; this is no file",))
    assert contents_of(Path("/dev/zero")) == ""


def test_nor_is_what_waits_for_a_writer(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="this is no file"):
        read_text(tmp_path / "pipe")
    assert contents_of(tmp_path / "pipe") == ""


def test_a_file_larger_than_what_is_read(tmp_path: Path) -> None:
    large = tmp_path / "large"
    with large.open("wb") as file:
        file.truncate(LARGEST + 1)  # a hole: it takes no room
    with pytest.raises(InputError, match=r"the file has 1 GB; at most 1 GB are read"):
        read_text(large)
    with large.open("wb") as file:
        file.write(b"1,2\n")
    assert read_text(large) == "1,2\n"
    assert len(contents_of(large)) == 64
