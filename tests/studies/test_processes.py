"""Units of work in processes of this computer: the result of one process, and what they fail of."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from tests.interrupting import assert_same
from tests.refusals import failed, refused
from tests.studies.tiled_squares import TiledSquares, marks

import wucht
from wucht.studies.processes import LocalProcesses


def test_two_processes_find_what_one_finds(tmp_path: Path) -> None:
    told: list[tuple[float, str]] = []
    expected = wucht.run(TiledSquares(count=4, lasts=0.0), tmp_path)
    before = len(marks(tmp_path, "done"))
    assert_same(expected, wucht.run(TiledSquares(count=4), tmp_path, processes=2, progress=lambda *one: told.append(one)))
    computing = {process for _, process in marks(tmp_path, "done")[before:]}
    assert len(computing) == 2 and os.getpid() not in computing
    shares = [share for share, _ in told]
    assert shares == sorted(shares) and {what for _, what in told} >= {"squares, 2 processes"}


def test_the_error_of_a_task_is_that_of_the_study(tmp_path: Path) -> None:
    with refused("study.lasts", given=-1.0):
        wucht.run(TiledSquares(count=2, lasts=-1.0), tmp_path, processes=2)


@pytest.mark.slow
def test_an_interrupted_study_is_resumed_by_processes(tmp_path: Path) -> None:
    def stop(share: float, _label: str) -> None:
        if share > 0.3:
            raise KeyboardInterrupt

    question, out = TiledSquares(count=6), tmp_path / "out"
    part = wucht.run(question, tmp_path, folder=out, processes=2, progress=stop)
    assert not part.wucht.finished
    whole = wucht.run(question, tmp_path, folder=out, resume=True, processes=2)
    assert whole.wucht.finished and whole.square.values.tolist() == [0, 1, 4, 9, 16, 25]
    assert len(marks(tmp_path, "done")) < 12  # some are read back


def end_at_once(_report: Callable[[float], None]) -> None:
    os._exit(3)


def test_a_process_that_ends_is_told() -> None:
    with failed("process-ended", "tile", "memory"):
        list(LocalProcesses(2).compute({"tile": end_at_once}, lambda *_: None))
    with failed("not-sent", "tile"):
        list(LocalProcesses(1).compute({"tile": lambda _: None}, lambda *_: None))


@pytest.mark.parametrize(
    ("question", "keys"),
    [
        (wucht.RunUp(until=1.0), {"processes": 2}),
        (TiledSquares(), {"processes": 0}),
        (TiledSquares(), {"processes": 1.5}),
        (TiledSquares(), {"processes": 2, "scheduler": "tcp://127.0.0.1:9"}),
    ],
)
def test_what_is_refused(question: wucht.RunUp | TiledSquares, keys: dict[str, object], tmp_path: Path) -> None:
    ask = partial(wucht.run, question, tmp_path if isinstance(question, TiledSquares) else "drozdetskaya-2020/r1")
    with refused("processes", given=keys["processes"]):
        ask(**keys)
