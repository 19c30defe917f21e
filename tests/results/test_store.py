"""Files that are replaced as a whole, by several processes too."""

from __future__ import annotations

import os
from pathlib import Path

from tests.refusals import failed, refused

from wucht.results.store import prepare_folder, replace_file


def test_two_at_once_do_not_mix(tmp_path: Path) -> None:
    """The second begins while the first is half way: each is whole in its turn."""
    file, seen = tmp_path / "a", list[str]()

    def slowly(beside: Path) -> None:
        beside.write_text("first, h")
        replace_file(file, lambda other: other.write_text("second"))
        seen.append(file.read_text())
        with beside.open("a") as rest:
            rest.write("alf and half")

    replace_file(file, slowly)
    assert seen == ["second"]
    assert file.read_text() == "first, half and half"
    assert list(tmp_path.iterdir()) == [file]


def test_what_cannot_be_written_leaves_what_was_there(tmp_path: Path) -> None:
    file = tmp_path / "a"
    replace_file(file, lambda beside: beside.write_text("whole"))

    def full(beside: Path) -> None:
        beside.write_text("ha")
        raise OSError(28, "No space left on device")

    with failed("not-written"):
        replace_file(file, full)
    assert file.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [file]


def test_what_a_killed_process_left_is_removed_once_it_is_old(tmp_path: Path) -> None:
    old, fresh, others = (tmp_path / name for name in (".result.nc.0.part", ".result.nc.1.part", ".mine.0.part"))
    for file in (old, fresh, others):
        file.write_text("half")
    os.utime(old, (0, 0))
    os.utime(others, (0, 0))
    prepare_folder(tmp_path, ["result.nc"])
    assert sorted(tmp_path.iterdir()) == sorted([fresh, others])


def test_a_folder_in_the_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "result.nc").mkdir()
    with refused("-o", "result.nc", code="folder"):
        prepare_folder(tmp_path, ["result.nc"])


def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with refused("-o", "nothing can be written there", given=str(tmp_path / "file" / "in")):
        prepare_folder(tmp_path / "file" / "in")
    with refused("-o", "this cannot be the name of a folder", given="a\0b"):
        prepare_folder(Path("a\0b"))
    (tmp_path / "out" / "result.nc").mkdir(parents=True)
    with refused("-o", "result.nc", given=str(tmp_path / "out"), code="folder"):
        prepare_folder(tmp_path / "out", ["result.nc"])
