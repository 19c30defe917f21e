"""A search that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

from pathlib import Path

import pytest
from known_fronts import MACHINE, RANGE, Parabolas

from interrupting import assert_same, stop_at
from wucht.studies.optimise_balancer import candidates
from wucht.studies.optimise_balancer.spec import OptimiseBalancer
from wucht.studies.runner import draw, report
from wucht.studies.runner import run as ask

QUESTION = OptimiseBalancer(
    vary={"damping": RANGE},
    objectives=["peak", "settling-time"],
    samples=2,
    population=6,
    evaluations=36,
    points=4,
    bodies=[2, 3],
)


def test_resumed_is_uninterrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    engine = Parabolas()
    monkeypatch.setattr(candidates, "outcomes_of", engine)
    reports: list[float] = []
    whole = ask(QUESTION, MACHINE_OF_EQUALS, progress=lambda share, _: reports.append(share))
    assert reports == sorted(reports)
    assert reports[-1] == 1.0
    once, engine.members = engine.members, 0
    result = ask(QUESTION, MACHINE_OF_EQUALS, folder=tmp_path, progress=stop_at(6))
    times = 1
    while not result.attrs["finished"]:
        draw(result)
        report(result)
        result = ask(QUESTION, MACHINE_OF_EQUALS, folder=tmp_path, resume=True, progress=stop_at(4 + 5 * times))
        times += 1
        assert times < 40
    assert times > 3
    assert_same(whole, result)
    assert not (tmp_path / "units").exists()
    assert engine.members < once + 40 * times, "what was finished is not run again"


MACHINE_OF_EQUALS = MACHINE.with_values({"r2.track_radius": MACHINE.values["r1.track_radius"]})
