"""One run at a time writes into a folder, and a run that was killed is no obstacle; what is the user's is never removed."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from itertools import count
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from tests import refusals
from tests.refusals import failed, refused

from wucht.results import output_folder, store
from wucht.results.output_folder import (
    CHECKSUMS,
    COMMIT,
    NEW,
    SUMMARY,
    checksum,
    claim_folder,
    commit,
    latest_file,
    note_figure,
)
from wucht.results.store import prepare_folder, replace_file
from wucht.studies.memory import UnitMemory

CLAIM = """
import sys, time
from pathlib import Path
from wucht.results.output_folder import claim_folder
with claim_folder(Path(sys.argv[1])):
    print("claimed", flush=True)
    time.sleep(60)
"""


def test_a_folder_that_stays_empty_is_not_left(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), claim_folder(tmp_path / "a" / "b"):
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []
    with claim_folder(tmp_path):
        pass
    assert tmp_path.is_dir(), "it was there before"


def test_another_process_is_kept_out_until_it_is_killed(tmp_path: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", CLAIM, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "claimed\n"
        with refusals.refused("-o"), claim_folder(tmp_path):
            pytest.fail("two runs write into one folder")
    finally:
        other.kill()
        other.wait()
        if other.stdout is not None:
            other.stdout.close()
    assert list(tmp_path.iterdir()), "what it left behind"
    with claim_folder(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def put(folder: Path, files: dict[str, str], figures: tuple[str, ...] = ()) -> None:
    """Write a result of these files; its summary notes the figures."""
    new = folder / NEW
    new.mkdir()
    for name, text in files.items():
        (new / name).write_text(text)
    if figures:
        (new / SUMMARY).write_text(json.dumps({CHECKSUMS: {name: checksum(new / name) for name in figures}}))


def files_of(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in folder.iterdir() if p.name != SUMMARY}


OLD = {"result.nc": "old", "run-up.png": "old", "run-up.pdf": "the same in both"}
STEPS = 7  # the folder is renamed, five files are moved, what is empty is removed
FRESH = {"result.nc": "new", "run-up.png": "new", "run-up.pdf": "the same in both", "table.csv": "new"}


def test_a_result_takes_the_place_of_the_earlier_one_and_of_its_figures(tmp_path: Path) -> None:
    with claim_folder(tmp_path):
        put(tmp_path, OLD, ("run-up.png", "run-up.pdf"))
        commit(tmp_path)
    assert files_of(tmp_path) == OLD
    with claim_folder(tmp_path):
        put(tmp_path, {"result.nc": "another", "basin.png": "another"}, ("basin.png",))
        commit(tmp_path)
    assert files_of(tmp_path) == {"result.nc": "another", "basin.png": "another"}


def test_what_was_not_committed_is_removed(tmp_path: Path) -> None:
    put(tmp_path, OLD)
    assert latest_file(tmp_path / "result.nc") == tmp_path / "result.nc"
    assert (tmp_path / NEW).is_dir(), "it may be that of a run that goes on"
    with claim_folder(tmp_path):
        assert not (tmp_path / NEW).exists()


@pytest.mark.parametrize("step", range(1, STEPS + 2))
def test_cut_off_anywhere_it_is_the_earlier_result_or_the_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    """As by SIGKILL: at any change of a name, what is left is completed by the next who opens the folder."""
    with claim_folder(tmp_path):
        put(tmp_path, OLD, ("run-up.png", "run-up.pdf"))
        commit(tmp_path)
    steps = count(1)
    with monkeypatch.context() as patched:
        for name in ("replace", "unlink", "rmdir"):
            patched.setattr(Path, name, until(step, steps, getattr(Path, name)))
        put(tmp_path, FRESH, ("run-up.png", "run-up.pdf", "table.csv"))
        with suppress(KeyboardInterrupt):
            commit(tmp_path)
    assert next(steps) == min(step, STEPS) + 1, "each step is tried"
    result = latest_file(tmp_path / "result.nc").read_text()
    with claim_folder(tmp_path):
        pass
    assert files_of(tmp_path) == {"old": OLD, "new": FRESH}[result]
    noted = json.loads((tmp_path / SUMMARY).read_text())[CHECKSUMS]
    assert noted == {name: checksum(tmp_path / name) for name in noted}
    assert result == ("old" if step == 1 else "new")


def until(step: int, steps: Iterator[int], change: Callable[..., Any]) -> Callable[..., Any]:
    """A change of a file's name that ends the process at this step."""

    def killed(*arguments: Any, **options: Any) -> Any:
        if next(steps) >= step:
            raise KeyboardInterrupt
        return change(*arguments, **options)

    return killed


def test_a_folder_that_cannot_be_written_is_read_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a commit left behind is read where it is, if it cannot be moved."""
    put(tmp_path, FRESH)
    (tmp_path / NEW).rename(tmp_path / COMMIT)

    def read_only(*_: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "replace", read_only)
    assert latest_file(tmp_path / "result.nc").read_text() == "new"
    monkeypatch.undo()
    assert latest_file(tmp_path / "result.nc") == tmp_path / "result.nc"
    assert not (tmp_path / COMMIT).exists()


def test_a_file_that_a_viewer_has_open_is_tried_again_and_then_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on Windows. The new result is complete, and the next run puts it into its place."""
    move, opened = Path.replace, [3]

    def held(source: Path, target: Path) -> Path:
        if target.name == "run-up.png" and opened[0]:
            opened[0] -= 1
            raise PermissionError(errno.EACCES, "Permission denied")
        return move(source, target)

    monkeypatch.setattr(Path, "replace", held)
    with claim_folder(tmp_path):
        put(tmp_path, OLD, ("run-up.png",))
        commit(tmp_path)
    assert files_of(tmp_path) == OLD, "closed after a while"
    monkeypatch.setattr(store, "_PATIENCE_S", 0.2)
    opened[0] = 100
    with claim_folder(tmp_path):
        put(tmp_path, FRESH, ("run-up.png",))
        with failed("not-replaced", "up.png"):
            commit(tmp_path)
    opened[0] = 0
    with claim_folder(tmp_path):
        assert files_of(tmp_path)["run-up.png"] == "new"


def test_only_what_is_noted_and_unchanged_is_removed(tmp_path: Path) -> None:
    figure, drawn_over, own = (tmp_path / name for name in ("run-up.png", "run-up.pdf", "basin.png"))
    for file in (figure, drawn_over, own):
        file.write_text(file.name)
    outside = tmp_path.parent / "outside.png"
    outside.write_text("outside")
    noted = {figure.name: checksum(figure), "../outside.png": checksum(outside), "\0": "", "run-up.svg": "", ".": 1}
    (tmp_path / SUMMARY).write_text(json.dumps({CHECKSUMS: noted}))
    note_figure(drawn_over, xr.Dataset())
    drawn_over.write_text("with an arrow")
    replace_result(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["basin.png", "result.nc", "run-up.pdf"]
    assert outside.is_file()


def replace_result(folder: Path) -> None:
    with claim_folder(folder):
        put(folder, {"result.nc": ""})
        commit(folder)


@pytest.mark.parametrize("own", ["{", '{"checksums": 1}', "\0"])
def test_a_summary_of_others_is_left_alone(tmp_path: Path, own: str) -> None:
    (tmp_path / SUMMARY).write_text(own)
    (tmp_path / "run-up.png").write_text("")
    note_figure(tmp_path / "run-up.png", xr.Dataset())
    replace_result(tmp_path)
    assert (tmp_path / SUMMARY).read_text() == own
    assert (tmp_path / "run-up.png").is_file()


def test_a_folder_in_which_nothing_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(output_folder, "FileIO", refuse)
    with (
        refusals.refused("-o", "nothing can be written there", "Read-only file system", given=str(tmp_path)),
        claim_folder(tmp_path),
    ):
        pytest.fail("it cannot be claimed")


@pytest.mark.skipif(sys.platform == "win32", reason="locks of POSIX")
@pytest.mark.parametrize(("removals", "tries"), [(2, 3), (100, 10)])
def test_a_lock_that_was_removed_meanwhile_is_taken_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, removals: int, tries: int
) -> None:
    """By the run that had it and has ended: the file of that name is another one then. Again and again, it is given up."""
    lock, locked = tmp_path / ".wucht.lock", list[int]()

    def taken(descriptor: int, _how: int) -> None:
        locked.append(descriptor)
        if len(locked) <= removals:
            lock.unlink()
        if len(locked) == 2:
            lock.write_text("of another")

    monkeypatch.setattr("fcntl.flock", taken)
    given_up = refusals.refused("-o", "another run is writing a result there")
    with given_up if removals > 10 else nullcontext(), claim_folder(tmp_path):
        assert lock.is_file()
    assert len(locked) == tries and not lock.exists()


@pytest.mark.parametrize(("number", "matters"), [(errno.EINVAL, False), (errno.EIO, True)])
def test_a_file_system_that_knows_no_flushing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, matters: bool
) -> None:
    """A result that cannot be put into its place for another reason stays where it is."""

    def fail(_: int) -> None:
        raise OSError(number, "none")

    put(tmp_path, FRESH)
    monkeypatch.setattr(os, "fsync", fail)
    with failed("", "none") if matters else nullcontext():
        commit(tmp_path)
    assert (tmp_path / NEW).is_dir() is matters and not (tmp_path / COMMIT).exists()


def test_what_is_kept_in_a_folder_in_which_nothing_can_be_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(*_: Any, **_options: Any) -> Any:
        raise PermissionError(13, "Permission denied")

    memory = UnitMemory.start(tmp_path, {"study": "a"})
    memory.unit("a", lambda: 1.0)
    memory.flush()
    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", denied)
        with refused("-o", "nothing can be written there: Permission denied", given=str(tmp_path)):
            UnitMemory.start(tmp_path, {"study": "a"})
    UnitMemory.start(tmp_path, {"study": "a"})


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


def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with refused("-o", "nothing can be written there", given=str(tmp_path / "file" / "in")):
        prepare_folder(tmp_path / "file" / "in")
    with refused("-o", "this cannot be the name of a folder", given="a\0b"):
        prepare_folder(Path("a\0b"))
    (tmp_path / "out" / "result.nc").mkdir(parents=True)
    with refused("-o", "result.nc", given=str(tmp_path / "out"), code="folder"):
        prepare_folder(tmp_path / "out", ["result.nc"])


def test_a_folder_in_the_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "result.nc").mkdir()
    with refused("-o", "result.nc", code="folder"):
        prepare_folder(tmp_path, ["result.nc"])
