"""A command in a child process of its own, forked from one that has loaded everything, under limits of time and memory."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from types import FrameType

CTRL_C_AFTER_S = 2.0  # of processor time: a study that works may take longer, and must then end when it is asked to
_KILLED_AFTER_S = 20  # of processor time, and twice as much of any
_LONGEST_S = 600  # where there is no Ctrl-C
_MEMORY = 6 * 2**30  # bytes of address space: the parent has two, with all libraries
_NOT_FINITE = re.compile(r"(?<![\w.])[-+]?(nan|inf|NaN|Infinity)(?![\w.])")


class Class(Enum):
    """What became of a case."""

    CLEAR = "refused with a sentence"
    WORKS = "works, or was ended by Ctrl-C at its limit"
    FAILED = "failed with a sentence"
    TRACEBACK = "a traceback"
    SILENT = "failed without a sentence, or with several"
    NOT_FINITE = "exit code 0, and a number that is not finite"
    HANGS = "does not end"
    CRASHED = "killed by a signal"


GOOD = (Class.CLEAR, Class.WORKS, Class.FAILED)


@dataclass(frozen=True)
class Ended:
    """A child that has ended. code: its exit code, negative for a signal."""

    code: int
    out: str
    err: str
    seconds: float

    @property
    def sentence(self) -> str:
        """What it says last."""
        return (self.err.strip().splitlines() or [""])[-1]


def load_everything() -> None:
    """Load what commands load, so that children need not. Nothing is run: threads do not survive a fork."""
    import h5netcdf  # noqa: F401
    import matplotlib.backends.backend_agg  # noqa: F401
    import scipy.integrate
    import scipy.interpolate
    import scipy.optimize
    import scipy.signal  # noqa: F401
    import xarray as xr

    import wucht.cli.app
    import wucht.studies.runner
    from wucht.machines.parts import part_kinds  # noqa: F401
    from wucht.studies.registry import studies

    wucht.cli.app.register()
    studies()
    xr.Dataset()


def start(function: Callable[[], int], folder: Path, ctrl_c_after: float = math.inf) -> int:
    """A child whose working directory is the folder, and whose exit code is what the function returns: its number."""
    child = os.fork()
    if not child:
        _child(function, folder, ctrl_c_after)
    return child


def call(function: Callable[[], int], folder: Path, ctrl_c_after: float = math.inf) -> Ended:
    """What a function's exit code and words are, in a child."""
    begun = time.perf_counter()
    code = _wait(
        start(function, folder, ctrl_c_after), begun + (2 * _KILLED_AFTER_S if math.isfinite(ctrl_c_after) else _LONGEST_S)
    )
    out, err = ((folder / name).read_text(encoding="utf-8", errors="replace") for name in ("stdout", "stderr"))
    return Ended(code, out, err, time.perf_counter() - begun)


def wucht(*words: str) -> Callable[[], int]:
    """A command, to be called in a child."""

    def run() -> int:
        from wucht.cli.app import run_app

        sys.argv = ["wucht", *words]
        return run_app()

    return run


def entry_point(*words: str) -> Callable[[], int]:
    """The whole program, to be called in a child: also what it does before and after a command."""

    def run() -> int:
        from wucht.cli import main

        sys.argv = ["wucht", *words]
        try:
            main()
        except SystemExit as ended:
            return int(ended.code or 0)

    return run


def _child(function: Callable[[], int], folder: Path, ctrl_c_after: float) -> None:
    """Never returns."""
    import resource
    import traceback

    code = 99
    try:
        os.chdir(folder)
        for number, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout, sys.stderr = (os.fdopen(n, "w", encoding="utf-8", closefd=False) for n in (1, 2))
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if math.isfinite(ctrl_c_after):
            resource.setrlimit(resource.RLIMIT_CPU, (_KILLED_AFTER_S, _KILLED_AFTER_S))
            signal.signal(signal.SIGVTALRM, _press_ctrl_c)
            signal.setitimer(signal.ITIMER_VIRTUAL, ctrl_c_after)
        code = function()
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _press_ctrl_c(_signal: int, _frame: FrameType | None) -> None:
    os.kill(os.getpid(), signal.SIGINT)


def _wait(child: int, until: float) -> int:
    pause = 0.002
    while time.perf_counter() < until:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(pause)
        pause = min(1.3 * pause, 0.05)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return -signal.SIGKILL


def classify(ended: Ended, folder: Path) -> Class:
    """The class of a case that was run with ``-o out``."""
    if ended.code in (-signal.SIGKILL, -signal.SIGXCPU):
        return Class.HANGS
    if ended.code < 0:
        return Class.CRASHED
    if "Traceback" in ended.err or ended.code == 99:
        return Class.TRACEBACK
    if ended.code == 0:
        return Class.NOT_FINITE if _is_not_finite(ended.out, folder) else Class.WORKS
    sentences = [line for line in ended.err.splitlines() if line.startswith("wucht: ")]
    if len(sentences) != 1 or ended.sentence != sentences[0] or len(ended.sentence) < 20:
        return Class.WORKS if ended.code == 130 else Class.SILENT
    return {1: Class.FAILED, 2: Class.CLEAR, 130: Class.WORKS}.get(ended.code, Class.SILENT)


def _is_not_finite(out: str, folder: Path) -> bool:
    """Whether the report has a number that is not finite, or a summary that is no JSON, which has no such numbers."""

    def refuse(_: str) -> None:
        raise ValueError

    for file in (folder / "out").glob("summary.json"):
        try:
            json.loads(file.read_text(encoding="utf-8"), parse_constant=refuse)
        except ValueError:
            return True
    printed = out
    for text in re.findall(r'"([^"\n]+)"', (folder / "study.toml").read_bytes().decode(errors="replace")):
        printed = printed.replace(text, "")  # a title is printed as it is written
    return bool(_NOT_FINITE.search(printed))
