"""Units of work of ``capture-probability``: one that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from interrupting import assert_same, stop_at, stopped_at_once, stopped_often
from known_basins import MACHINE, counted, engine, phases
from wucht.studies.capture_probability import computation as running
from wucht.studies.capture_probability.spec import CaptureProbability
from wucht.studies.runner import draw, report
from wucht.studies.runner import run as ask

TURN = {"uniform": [0.0, 2 * math.pi]}
QUESTION = CaptureProbability(
    along="u", range=[1.0, 5.0], points=3, random={"psi": TURN, "delta": TURN}, model="slow", samples=128, probability=0.6,
    sensitivity=True, at=3.0, sensitivity_samples=64,
)  # fmt: skip


@pytest.fixture
def starts(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The starts that are run in small tiles, with their u, each as often as it is."""

    def read(states: np.ndarray, machine: Any) -> tuple[np.ndarray, np.ndarray]:
        psi, delta = phases(states, machine)
        return psi / (2 * math.pi) + 0.1 * np.sin(delta), np.full(len(psi), machine.values["u"])

    known = engine(lambda share, u: share < (u - 1) / 4, fail=lambda share, u: share > 1.02 + 0 * u, read=read)

    return counted(monkeypatch, running, known, tile=50, parameter="u")


def test_resumed_is_uninterrupted(tmp_path: Path, starts: list[bytes]) -> None:
    reports: list[float] = []
    whole = ask(QUESTION, MACHINE, progress=lambda share, _: reports.append(share))
    assert reports == sorted(reports)
    assert reports[-1] == 1.0
    once = len(starts)
    assert once == whole.wucht.summary["runs"]
    starts.clear()
    assert_same(whole, stopped_often(QUESTION, MACHINE, tmp_path, first=12, further=23))
    assert len(starts) == once


def test_stopped_on_the_way_nothing_is_called_the_smallest(tmp_path: Path, starts: list[bytes]) -> None:
    """After the second of three values."""
    result = ask(QUESTION, MACHINE, folder=tmp_path, progress=stop_at(20))
    assert result.parameter.values.tolist() == [1.0, 3.0]
    s = result.wucht.summary
    assert s["smallest"] is None
    assert s["values"] == [2, 3]
    assert "1 of the 3 values of u are not computed yet" in result.wucht.warnings
    assert "at least" not in report(result)[1]
    draw(result)


def test_stopped_before_the_first_value(tmp_path: Path, starts: list[bytes]) -> None:
    assert_same(ask(QUESTION, MACHINE), stopped_at_once(QUESTION, MACHINE, tmp_path, call=2))


def test_tiles_do_not_matter(monkeypatch: pytest.MonkeyPatch, starts: list[bytes]) -> None:
    whole = ask(QUESTION, MACHINE)
    monkeypatch.setattr(running, "_TILE", 1024)
    assert_same(whole, ask(QUESTION, MACHINE))
