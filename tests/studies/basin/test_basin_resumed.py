"""Units of work of ``basin``: a study that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from interrupting import assert_same, stop_at, stopped_at_once, stopped_often
from known_basins import MACHINE, TURN, counted, engine, spiral
from wucht.studies.basin import computation as running
from wucht.studies.basin.spec import Basin
from wucht.studies.runner import draw, load, report
from wucht.studies.runner import run as ask

QUESTION = Basin(axes=TURN, model="slow", refine=2)


@pytest.fixture
def starts(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The starts that are run in small tiles, each as often as it is."""
    return counted(monkeypatch, running, engine(spiral, fail=lambda psi, delta: (psi < 0.3) & (delta > 2.9)), tile=100)


def test_resumed_is_uninterrupted(tmp_path: Path, starts: list[bytes]) -> None:
    """Stopped again and again, a few reports further each time; no member that was finished is run twice."""
    reports: list[float] = []
    whole = ask(QUESTION, MACHINE, progress=lambda share, _: reports.append(share))
    assert reports == sorted(reports)
    assert reports[-1] == 1.0
    once = len(starts)
    assert once == whole.wucht.summary["runs"]
    assert len(set(starts)) == once
    starts.clear()
    assert_same(whole, stopped_often(QUESTION, MACHINE, tmp_path, first=8, further=11))
    assert len(starts) == len(set(starts)) == once


def test_cells_that_are_not_computed_are_missing_not_an_outcome(tmp_path: Path, starts: list[bytes]) -> None:
    """After the second of six tiles of the coarsest map."""
    whole = ask(QUESTION, MACHINE)
    result = ask(QUESTION, MACHINE, folder=tmp_path, progress=stop_at(8))
    known = result.outcome.values >= 0
    assert known.sum() == 200
    assert known.ravel()[:200].all()
    assert np.array_equal(result.outcome.values[known], whole.outcome.values[known])
    assert np.isnan(result.settling_time.values[~known]).all()
    s = result.wucht.summary
    assert s["missing"] == pytest.approx(312 / 512)
    assert sum(s["fractions"].values()) == pytest.approx(200 / 512)
    assert "312 of the 512 cells of the map are not computed; the shares are of all cells" in json.loads(
        result.attrs["warnings"]
    )
    assert "60.9 % not computed yet" in report(result)[1]
    legend = draw(result).axes[0].get_legend()
    assert legend is not None
    assert "not computed" in [t.get_text() for t in legend.get_texts()]


def test_stopped_at_the_borders_the_map_has_what_is_known(tmp_path: Path, starts: list[bytes]) -> None:
    """On the level that was under way: what was not halved stands, what was to be run is missing."""
    whole = ask(QUESTION.model_copy(update={"refine": 1}), MACHINE)
    first = len(starts) - 512
    result = ask(QUESTION, MACHINE, folder=tmp_path, progress=stop_at(3 * 6 + 3 * 2 + 1))
    refined = result.refined_outcome.values
    assert (refined < 0).sum() == first - 200
    assert np.array_equal(refined[refined >= 0], whole.refined_outcome.values[refined >= 0])
    assert np.array_equal(result.outcome.values, whole.outcome.values)
    assert "refined_level" in result
    draw(result)
    report(result)


def test_stopped_before_the_first_tile(tmp_path: Path, starts: list[bytes]) -> None:
    assert_same(ask(QUESTION, MACHINE), stopped_at_once(QUESTION, MACHINE, tmp_path, call=1))


def test_tiles_do_not_matter(monkeypatch: pytest.MonkeyPatch, starts: list[bytes]) -> None:
    whole = ask(QUESTION, MACHINE)
    monkeypatch.setattr(running, "_TILE", {"slow": 33})
    assert_same(whole, ask(QUESTION, MACHINE))


KILLED = """
import sys, time
from pathlib import Path
import numpy as np
sys.path.insert(0, sys.argv[1])
from known_basins import MACHINE, TURN, engine, spiral
from wucht.studies import memory, runner
from wucht.studies.basin import computation as running
from wucht.studies.basin.spec import Basin
known = engine(spiral)
def slowly(*given):
    time.sleep(0.05)
    return known(*given[:3])
running.outcomes_of, memory._EVERY_S, runner._SAVE_EVERY_S = lambda *a, report: slowly(*a), 0.0, 0.1
running._TILE = {"slow": 20}
runner.run(Basin(axes=TURN, model="slow", refine=1), MACHINE, folder=Path(sys.argv[2]))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_killed_and_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """kill -9: the map so far is readable, and what was written is not run again."""
    here = str(Path(__file__).parents[2])
    process = subprocess.Popen([sys.executable, "-c", KILLED, here, str(tmp_path)])
    unfinished = tmp_path / "result.partial.nc"
    try:
        until = time.monotonic() + 60
        while not unfinished.is_file():
            assert process.poll() is None
            assert time.monotonic() < until
            time.sleep(0.02)
    finally:
        process.kill()
        process.wait()
    kept = load(unfinished)
    assert kept.attrs["finished"] == 0
    assert (kept.outcome.values >= 0).any()
    question, members = Basin(axes=TURN, model="slow", refine=1), list[int]()
    monkeypatch.setattr(running, "outcomes_of", known := engine(spiral))
    whole = ask(question, MACHINE)

    def counted(question: Any, states: np.ndarray, values: Any, report: Any = None) -> Any:
        members.append(states.shape[1])
        return known(question, states, values, report)

    monkeypatch.setattr(running, "outcomes_of", counted)
    monkeypatch.setattr(running, "_TILE", {"slow": 20})
    assert_same(whole, ask(question, MACHINE, folder=tmp_path, resume=True))
    assert 0 < sum(members) < whole.wucht.summary["runs"]
