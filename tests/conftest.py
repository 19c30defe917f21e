"""Helpers of all tests: the command line called in this process, and a small study file to spoil."""

from __future__ import annotations

import contextlib
import gc
import io
import json
import os
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest

# Two workers whose linear algebra has threads of its own wait for each other: before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell starts what runs in the background with Ctrl-C ignored; Python then leaves it so.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

_OBJECTS = 50_000  # more between two collections: formulas and figures are many, and most of them stay

STUDY = """\
title = "A drum with two pendulums"

[machine.carrier]
mass = "1 kg"
stiffness = "1e5 N/m"
damping = "200 N s/m"

[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "9 kg"
eccentricity = "1 mm"
inertia = "0.03 kg m^2"

[[machine.bodies]]
kind = "pendulum"
name = "p1"
about = "drum"
mass = "125 g"
length = "104 mm"
damping = "0.17 N m s"

[[machine.bodies]]
kind = "pendulum"
name = "p2"
about = "drum"
mass = "125 g"
length = "104 mm"
damping = "0.17 N m s"

[machine.drive]
on = "drum"
kind = "linear"
slope = "0.04 N m s"
no_load_speed = "200 rad/s"

[study]
kind = "run-up"
until = "0.5 s"
start = { p1 = "0.3 rad", p2 = "-0.5 rad" }
"""


def pytest_configure(config: pytest.Config) -> None:
    """Tests derive everything anew: they share a cache folder and a key of their own, which all workers and commands have."""
    if not hasattr(config, "workerinput"):
        folder = tempfile.TemporaryDirectory(prefix="wucht-tests-")
        os.environ |= {"WUCHT_CACHE_DIR": f"{folder.name}/cache", "XDG_STATE_HOME": f"{folder.name}/state"}
        config.add_cleanup(folder.cleanup)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Ten thousand tests, and the modules that they import, live to the end: whether they are garbage is not asked again and
    again, neither while they come to be nor, with each look at what a test leaves, for all that stands since then."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(_OBJECTS)
        gc.enable()


@dataclass(frozen=True)
class Completed:
    """What a command said: its exit code, stdout and stderr."""

    code: int
    out: str
    err: str

    @property
    def document(self) -> dict[str, Any]:
        """The one JSON object on stdout."""
        actual = json.loads(self.out)
        assert isinstance(actual, dict)
        return actual


Command = Callable[..., Completed]
Spoil = Callable[..., Path]


@cache
def _commands() -> Any:
    """The commands as Typer makes them of the app, anew at each call: they are the same for all tests of a process."""
    import typer

    from wucht.cli.app import app, register

    register()
    return typer.main.get_command(app)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _command(patch: pytest.MonkeyPatch, printed: Callable[[], tuple[str, str]]) -> Command:
    """The command line in this process. printed: returns and forgets what was printed on stdout and stderr."""
    from wucht.cli.app import run_app

    patch.setattr("wucht.cli.progress._SILENCE_S", 1e6)
    patch.setattr("wucht.cli.app.app", _commands())
    patch.setattr("wucht.cli.app.register", lambda: None)

    def call(*words: object) -> Completed:
        patch.setattr(sys, "argv", ["wucht", *map(str, words)])
        printed()
        completed = Completed(run_app(), *printed())
        assert "warning: not written: " not in completed.err, completed.err  # of a figure that fails, a warning is left
        return completed

    return call


@pytest.fixture
def wucht(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """``wucht("run", "study.toml")``: the command in this process. A traceback is the exception itself: the test fails.

    What it says does not depend on how busy the machine is: the sign of life comes from work alone, not from time.
    """
    return _command(monkeypatch, capsys.readouterr)


@pytest.fixture(scope="module")
def wucht_of_module() -> Iterator[Command]:
    """The same for commands whose results all tests of a module read. It runs in the working directory."""
    streams = [io.StringIO(), io.StringIO()]

    def printed() -> tuple[str, str]:
        texts = [stream.getvalue() for stream in streams]
        for stream in streams:
            stream.seek(0)
            stream.truncate()
        return texts[0], texts[1]

    with pytest.MonkeyPatch.context() as patch:
        call = _command(patch, printed)

        def redirected(*words: object) -> Completed:
            with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
                return call(*words)

        yield redirected


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made and written, but the page stays blank: painting is a quarter of a short run."""
    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "draw", lambda _figure, _renderer: None)


@pytest.fixture
def no_figures(unpainted: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """A blank page is written instead of a figure, which is half of a short run: for commands of which the numbers, files or
    words are tested. The figures of all studies are tested with the studies."""
    from matplotlib.figure import Figure

    monkeypatch.setattr("wucht.studies.runner.draw", lambda _result, _page=None: Figure((1, 1)))


@pytest.fixture(scope="module")
def coarse_angles() -> Iterator[None]:
    """Cams are looked at at 512 angles of a turn instead of 4096: for studies of cams that are not narrow anywhere, since what
    is cut away is most of their work. The angles themselves are tested with the cams."""
    import numpy as np

    from wucht.cams import contact, contact_history, shape, undercut
    from wucht.cams.followers import flat_faced
    from wucht.numerics import angles

    with pytest.MonkeyPatch.context() as patch:
        for module in (contact, contact_history, shape, undercut, flat_faced, angles):
            patch.setattr(module, "GRID", angles.TURN * np.arange(512) / 512)
            if hasattr(module, "STEP"):
                patch.setattr(module, "STEP", angles.TURN / 512)
        yield


@pytest.fixture
def study(here: Path) -> Spoil:
    """``study(old, new, ...)``: the study file with ``old`` replaced by ``new`` (first place each), as study.toml."""

    def write(*changes: str, name: str = "study.toml") -> Path:
        text = STUDY
        for old, new in zip(changes[::2], changes[1::2], strict=True):
            assert old in text, f"{old!r} is not in the study file"
            text = text.replace(old, new, 1)
        Path(name).write_text(text, encoding="utf-8")
        return Path(name)

    return write


@pytest.fixture
def from_template(wucht: Command) -> Callable[..., dict[str, Any]]:
    """``from_template("basin", ...)``: the summary of a study's own template; its figure is drawn again from the result."""

    def run(kind: str, *settings: str) -> dict[str, Any]:
        assert wucht("new", kind).code == 0
        done = wucht("run", f"{kind}.toml", "-o", "out", "--json", *settings)
        assert done.code == 0, done.err
        (figure,) = Path("out").glob("*.png")
        figure.unlink()
        assert wucht("plot", "out/result.nc").code == 0
        assert figure.is_file()
        summary: dict[str, Any] = json.loads(done.out)["summary"]
        return summary

    return run


@pytest.fixture
def refused(wucht: Command) -> Callable[..., str]:
    """``refused("run", ..., says=(...))``: exit code 2, one sentence on stderr containing all of these, and nothing
    on stdout; with ``--json`` an object with the same sentence."""

    def check(*words: object, says: tuple[str, ...] = ()) -> str:
        completed = wucht(*words)
        assert completed.code == 2, completed.err
        if "--json" in words:
            assert completed.document["exit_code"] == 2
            assert completed.err == f"wucht: {completed.document['error']}\n"
        else:
            assert not completed.out
        assert completed.err.startswith("wucht: ")
        assert completed.err.endswith("\n")
        assert completed.err.count("\n") == 1, completed.err
        for part in says:
            assert part in completed.err
        return completed.err

    return check
