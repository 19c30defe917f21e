"""A search that is stopped and resumed, or computed by workers, ends as one that was not, to the last bit."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from known_fronts import MACHINE, RANGE, KnownRuns, parabolas

from interrupting import assert_same, stop_at, stopped_often
from wucht import OptimiseBalancer, draw, report
from wucht import run as ask
from wucht.dynamics.balancers import balancer_candidate, balancer_search, candidates
from wucht.studies import runner

QUESTION = OptimiseBalancer(
    vary={"damping": RANGE},
    objectives=["peak", "settling-time"],
    samples=2,
    population=4,
    evaluations=16,
    points=3,
    bodies=[2, 3],
)


@pytest.fixture(autouse=True)
def _small_units(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two candidates each; steady states, which take longer, are not sought."""
    monkeypatch.setattr(candidates, "_UNIT", 4)
    monkeypatch.setattr(balancer_candidate, "compensated_state", lambda _machine, full: None)


def test_resumed_is_uninterrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    engine = KnownRuns(parabolas)
    monkeypatch.setattr(candidates, "outcomes_of", engine)
    asked, reports = QUESTION.model_copy(update={"damping_curve": False}), list[float]()
    whole = ask(asked, MACHINE, progress=lambda share, _: reports.append(share))
    assert reports == sorted(reports)
    assert reports[-1] == 1.0
    once, engine.members = engine.members, 0
    assert_same(whole, stopped_often(asked, MACHINE, tmp_path, 9, 8))
    assert engine.members < 2 * once, "what was finished is not run again"


@pytest.mark.slow
def test_what_is_known_before_the_end_is_drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(candidates, "outcomes_of", KnownRuns(parabolas))
    result = ask(QUESTION, MACHINE, folder=tmp_path, progress=stop_at(60))
    assert not result.attrs["finished"]
    draw(result)
    assert report(result)


class Workers:
    """In place of a scheduler's: tasks go to them as bytes, and come back in another order."""

    def __init__(self) -> None:
        self.tasks = 0

    def compute(self, tasks: Mapping[str, Callable[..., Any]], tell: Any) -> Iterator[tuple[str, Any]]:
        for name, task in reversed(tasks.items()):
            self.tasks += 1
            tell(0.5, "")
            yield name, pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(task))(lambda _share: None)))


@pytest.mark.slow
def test_workers_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(candidates, "outcomes_of", KnownRuns(parabolas))
    workers = Workers()
    alone = ask(QUESTION, MACHINE)
    monkeypatch.setattr(runner, "cluster_at", lambda _address: nullcontext(workers))
    assert_same(alone, ask(QUESTION, MACHINE, scheduler="tcp://workers:1"))
    before = 1 + 1 + 13 + 4 * 2 + 3
    assert workers.tasks > before, "the machine as it is twice, dampings and candidates by twos, points, and their comparison"


def test_that_it_takes_long_is_said_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where all are run up one by one, as balls of a track are, how many run-ups there will be is the first that is told."""
    monkeypatch.setattr(candidates, "outcomes_of", KnownRuns(parabolas))
    monkeypatch.setattr(balancer_search, "batching_obstacle", lambda _question: "bodies are released on the way")
    told: list[str] = []

    def stop(_share: float, what: str) -> None:
        told.append(what)
        raise KeyboardInterrupt

    asked = QUESTION.model_copy(update={"bodies": None, "points": 2, "objectives": None})
    with pytest.raises(KeyboardInterrupt):
        ask(asked, MACHINE, progress=stop)
    runs = 2 * (1 + 25 + 16 + 4 * 3)
    assert told == [f"{runs} run-ups at most before the recommendation, integrated one by one, which takes long"]
