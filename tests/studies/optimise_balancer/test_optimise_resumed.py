"""A search that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from searches import DAMPINGS, HELD

from interrupting import assert_same, stop_at, stopped_often
from wucht import OptimiseBalancer, draw, report, run

KEYS: dict[str, Any] = {"samples": 2, "population": 4, "evaluations": 8, "points": 2, "damping_curve": False}
QUESTION = OptimiseBalancer(vary={"damping": DAMPINGS}, objectives=["settling-time"], **KEYS)
MACHINE = HELD.machine(DAMPINGS[0])


@pytest.mark.slow
def test_resumed_is_uninterrupted(tmp_path: Path) -> None:
    reports = list[float]()
    whole = run(QUESTION, MACHINE, progress=lambda share, _: reports.append(share))
    assert reports == sorted(reports) and reports[-1] == 1.0
    share = len(reports) // 6
    assert_same(whole, stopped_often(QUESTION, MACHINE, tmp_path, share, share))


def test_what_is_not_checked_yet_is_neither_confirmed_nor_refuted(tmp_path: Path) -> None:
    """Stopped before the first generation is there, and while the front is checked."""
    begun = run(QUESTION, MACHINE, folder=tmp_path, progress=stop_at(1, "2 bodies, generation 1"))
    assert begun.wucht.sentence == "there is no front yet" and begun.wucht.summary["front"] == []
    result = run(QUESTION, MACHINE, folder=tmp_path, progress=stop_at(1, "check with the full equations"))
    s = result.wucht.summary
    assert [p["holds"] for p in s["front"]] == [None] * len(s["front"]) != [] and np.isnan(result.front_checked.values).all()
    assert (s["recommended"], s["compared"], s["duel"]) == (None, [], None), "not before the comparison"
    draw(result)
    assert report(result)
