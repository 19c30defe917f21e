"""Units of work of ``entrainment``: a study that is stopped and resumed ends as one that was not, and no run is made again."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from tests.refusals import refused

from interrupting import assert_same, stop_at
from wucht import Entrainment, Machine, draw, load, load_machine, report, run

QUESTION: dict[str, Any] = {"points": 6, "resolution": 0.5}
RUN = "drive.no_load_speed"


@cache
def machine() -> Machine:
    return load_machine("sperling-vibration/figure-2a")


def listening(words: list[str], stop: Callable[[float, str], None] = lambda *_: None) -> Callable[[float, str], None]:
    """A progress report that keeps what is worked at: a run is named by its value."""

    def note(share: float, what: str) -> None:
        words.append(what)
        stop(share, what)

    return note


@cache
def whole() -> tuple[xr.Dataset, list[str]]:
    """The result that is not interrupted, and what was worked at."""
    words: list[str] = []
    return run(Entrainment.from_table(QUESTION), machine(), progress=listening(words)), words


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "during"),
    [
        (100, RUN),
        (3, "averaged equations"),
        (8, "locked motions"),
    ],
)
def test_resumed_it_is_the_uninterrupted_one(call: int, during: str, tmp_path: Path) -> None:
    """What was done is not done again: of the runs, only the one in which it was stopped."""
    question, before, after = Entrainment.from_table(QUESTION), list[str](), list[str]()
    broken = run(question, machine(), folder=tmp_path, progress=listening(before, stop_at(call, during)))
    assert broken.attrs["finished"] == load(tmp_path / "result.partial.nc").attrs["finished"] == 0
    again = run(question, machine(), folder=tmp_path, resume=True, progress=listening(after))
    assert again.attrs["finished"] == 1
    result, words = whole()
    assert_same(again, result)
    runs = [{what for what in told if what.startswith(RUN)} for told in (before, after, words)]
    assert runs[0] | runs[1] == runs[2] and runs[0] & runs[1] == {before[-1]} & runs[2]
    finished: list[str] = []
    assert_same(run(question, machine(), folder=tmp_path, resume=True, progress=listening(finished)), result)
    assert not any(what.startswith(RUN) for what in finished), "of a finished study nothing is left to do"


def test_a_study_that_is_interrupted_keeps_what_it_has() -> None:
    """The machine's own value is not yet reached by the scan."""
    words: list[str] = []
    result = run(Entrainment.from_table({"points": 9}), machine(), progress=listening(words, stop_at(34, RUN)))
    finished = len({what for what in words if what.startswith(RUN)}) - 1
    s = result.wucht.summary
    assert (result.attrs["finished"], result.sizes["run"], s["band_from_rest"]) == (0, finished - 1, None)
    assert s["existence_band"] is not None and "interrupted" in s["sentence"]
    assert "only a run with a folder can be resumed" in result.attrs["warnings"]


def test_only_the_same_question_is_resumed(tmp_path: Path) -> None:
    run(Entrainment.from_table(QUESTION), machine(), folder=tmp_path, progress=stop_at(30))
    others: list[tuple[Machine, dict[str, object], tuple[str, ...]]] = [
        (machine(), {"resolution": 0.4}, ("study.resolution", "0.5", "0.4")),
        (machine().with_values({"rotor.inertia": 1.0}), {}, ("rotor.inertia", "1e-05", "1.0")),
    ]
    for other, keys, named in others:
        with refused("--resume", *named, code="other-question"):
            run(Entrainment.from_table(QUESTION | keys), other, folder=tmp_path, resume=True)


def test_it_can_be_stopped_within_a_run() -> None:
    """The first step is done after the machine's own run, of many legs."""
    result = run(Entrainment.from_table({"until": 3000.0}), machine(), progress=stop_at(3))
    assert result.attrs["finished"] == 0
    assert result.wucht.summary["outcome"] == "unidentified" and result.sizes["run"] == 0
    assert report(result) and draw(result).axes
