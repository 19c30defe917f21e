"""No room left, on the disk or where the output goes: a sentence, no half a file, and an exit code that says it."""

from __future__ import annotations

import io
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from wucht.cli.app import run_app

Study = Callable[..., Path]
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
    assert done.stderr.splitlines()[-1] == "wucht: out/result.nc cannot be written: File too large"
    assert list(Path("out").glob("*.part")) + list(Path("out").glob(".*.part")) == []


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
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "run-up.png", "summary.json"]


def test_a_template_of_which_half_fits(here: Path) -> None:
    done = outside("new", "run-up", "mine.toml", room=100)
    assert done.returncode == 2
    assert "mine.toml" in done.stderr
    assert not Path("mine.toml").exists()
