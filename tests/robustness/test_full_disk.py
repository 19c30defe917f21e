"""No room left, on the disk or where the output goes: a sentence, no half a file, and an exit code that says it."""

from __future__ import annotations

import io
import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.robustness import children

from wucht.cli.app import run_app
from wucht.results.output_folder import load_result

Study = Callable[..., Path]
FILES = {"result.nc", "run-up.png", "summary.json"}
SHORT = ('until = "0.5 s"', 'until = "0.02 s"')
NO_ROOM = "wucht: the output cannot be written: No space left on device\n"


def outside(*words: object, stdout: str | None = None, room: int | None = None) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own: what it says goes to a file. room: bytes that a file may have."""

    def limited() -> None:
        if room is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    code = [sys.executable, "-m", "wucht", *map(str, words)]
    with Path(stdout or "said").open("w") as said:
        return subprocess.run(
            code, stdout=said, stderr=subprocess.PIPE, text=True, check=False, timeout=120, preexec_fn=limited
        )


@pytest.mark.slow
def test_a_result_that_does_not_fit(study: Study) -> None:
    """The process ends by itself, not by a signal of the library beneath."""
    done = outside("run", study('until = "0.5 s"', 'until = "0.02 s"'), "-o", "out", room=4096)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "wucht: out/.wucht-new/result.nc cannot be written: File too large"
    assert [path.name for path in Path("out").iterdir()] == ["units"], "what was computed, for --resume"


@pytest.mark.slow
def test_an_earlier_result_stays_whole_where_the_new_one_does_not_fit(study: Study, wucht: Callable[..., Any]) -> None:
    """Not only its file: its figure and its summary too."""
    file = study('until = "0.5 s"', 'until = "0.02 s"')
    assert wucht("run", file, "-o", "out").code == 0
    before = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    assert before.keys() == FILES
    room = len(before["result.nc"]) - 9000
    again = children.entry_point("run", str(file), "-o", "out", "--set", "study.until=0.021")

    def limited() -> int:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
        return again()

    done = children.call(limited, Path())
    assert done.code == 1
    assert done.sentence == "wucht: out/.wucht-new/result.nc cannot be written: File too large"
    assert {path.name: path.read_bytes() for path in Path("out").iterdir() if path.is_file()} == before


@pytest.mark.slow
def test_a_figure_that_does_not_fit_is_a_warning(study: Study, wucht: Callable[..., Any]) -> None:
    """The new result is in its place, with its summary; the figure of the earlier one, which is not its own, is not."""
    file = study('until = "0.5 s"', 'until = "0.02 s"')
    assert wucht("run", file, "-o", "out").code == 0
    before = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    room = len(before["result.nc"]) + 9000
    assert len(before["run-up.png"]) > room
    again = children.entry_point("run", str(file), "-o", "out", "--set", "study.until=0.021")

    def limited() -> int:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
        return again()

    done = children.call(limited, Path())
    assert done.code == 0, done.err
    assert "warning: not written: figure run-up.png (out/.wucht-new/run-up.png cannot be written: File too large)" in done.err
    files = {path.name for path in Path("out").iterdir() if path.suffix}
    assert files == {"result.nc", "summary.json"}
    assert load_result(Path("out")).wucht.question["study"]["until"] == 0.021


def test_an_output_that_is_full(here: Path) -> None:
    done = outside("list", stdout="/dev/full")
    assert done.returncode == 1
    assert done.stderr == NO_ROOM


@pytest.mark.usefixtures("unpainted")
def test_an_output_that_is_full_after_a_run(
    study: Study, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The object is written to a buffer, and there is no room when that is emptied. The files are there."""

    class Full(io.StringIO):
        def flush(self) -> None:
            raise OSError(28, "No space left on device")

    file = study('until = "0.5 s"', 'until = "0.02 s"')
    monkeypatch.setattr(sys, "argv", ["wucht", "run", str(file), "-o", "out", "--json"])
    monkeypatch.setattr(sys, "stdout", Full())
    assert run_app() == 1
    assert capsys.readouterr().err.endswith(NO_ROOM)
    assert {p.name for p in Path("out").iterdir()} == FILES


def test_a_template_of_which_half_fits(here: Path) -> None:
    done = outside("new", "run-up", "mine.toml", room=100)
    assert done.returncode == 2
    assert "mine.toml" in done.stderr
    assert not Path("mine.toml").exists()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 4 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("only root can have a disk of its own; others have the limit of a file's size, above")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


LEFT = (0, 12, 30, 100, 200, 300, 400, 500, 600, 700, 800, 1000, 1200)


@pytest.mark.slow
@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize("left", LEFT)
def test_a_disk_that_becomes_full(study: Study, small_disk: Path, left: int) -> None:
    """left: kilobytes that the second run has. Either its result is there as a whole, at least without its figure, or the first
    one with its figure, and --resume goes on."""
    children.load_everything()
    file, out, ballast = study(*SHORT), small_disk / "out", small_disk / "ballast"
    place = file.absolute().parent
    assert children.call(children.wucht("run", file.name, "-o", str(out)), place).code == 0
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    ballast.write_bytes(bytes(max(0, shutil.disk_usage(small_disk).free - 1024 * left)))
    again = ("run", file.name, "-o", str(out), "--set", "study.until=0.03")
    ended = children.call(children.wucht(*again), place)
    after = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    assert "Traceback" not in ended.err
    assert ended.code in (0, 1)
    if ended.code == 1:
        assert ended.sentence.startswith("wucht: ")
        assert "No space left on device" in ended.sentence
    if after != before:
        assert after["result.nc"] != before["result.nc"]
        assert after["summary.json"] != before["summary.json"]
        assert after.keys() == before.keys() or "not written: figure" in ended.err or ended.code == 1
    assert ended.code == 1 or after != before
    ballast.unlink()
    assert children.call(children.wucht(*again, "--resume"), place).code == 0
    assert sorted(path.name for path in out.iterdir()) == sorted(before)
