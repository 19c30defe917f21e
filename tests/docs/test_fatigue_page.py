"""The page on counting and damage: its blocks run and print what it says, and that is right by other means."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from page_blocks import PAGES, blocks, run_python
from scipy.optimize import minimize_scalar


@pytest.fixture(scope="module")
def names() -> Mapping[str, Any]:
    """What the page's blocks define, run in order."""
    known: dict[str, Any] = {}
    for block in blocks(PAGES["docs/fatigue.md"]):
        if block.language == "python":
            assert run_python(block, known) == block.said, block.text
    return known


def test_the_turning_points_sample_by_sample(names: Mapping[str, Any]) -> None:
    s = names["stress"].tolist()
    inside = [b for a, b, c in zip(s, s[1:], s[2:], strict=False) if (b - a) * (c - b) < 0]
    assert names["points"].tolist() == [s[0], *inside, s[-1]]


def test_the_largest_value_by_minimisation(names: Mapping[str, Any]) -> None:
    def load(t: float) -> float:
        return 60 * math.sin(2.1 * t) + 35 * math.sin(0.37 * t) + 0.5 * t

    near = float(names["time"][names["stress"].argmax()])
    top = minimize_scalar(lambda t: -load(t), bounds=(near - 0.1, near + 0.1), method="bounded", options={"xatol": 1e-10})
    assert names["refined"].max() == pytest.approx(-top.fun, abs=2e-3)


def test_the_cycles_are_those_of_pylife(names: Mapping[str, Any]) -> None:
    stress = pytest.importorskip("pylife.stress.rainflow")
    recorder = stress.FullRecorder()
    counter = stress.FourPointDetector(recorder=recorder).process(names["stress"])
    closed = np.abs(np.array(recorder.values_from) - np.array(recorder.values_to))
    assert np.sort(closed) == pytest.approx(np.sort(names["rainflow"](names["stress"], "drop").ranges), rel=1e-12)
    halves = np.abs(np.diff(counter.residuals))
    whole = names["rainflow"](names["stress"])
    assert np.sort(whole.ranges[whole.counts == 0.5]) == pytest.approx(np.sort(halves), rel=1e-12)


def test_the_damage_cycle_by_cycle(names: Mapping[str, Any]) -> None:
    cycles, line = names["rainflow"](names["stress"]), names["lines"]["haibach"]
    slopes = [(5 if size >= 140 else 9, size, n) for size, n in zip(cycles.ranges, cycles.counts, strict=True)]
    by_hand = sum(n / (2e6 * (size / 2 / 70.0) ** -k) for k, size, n in slopes)
    assert line.damages(cycles).sum() == pytest.approx(by_hand, rel=1e-12)
    assert names["damage"].total == pytest.approx(by_hand, rel=1e-12)


def test_half_of_the_required_cycles(names: Mapping[str, Any]) -> None:
    """The normal shape: S = S_max sqrt(1 - ln H/ln H_0); the table: S falls linearly with ln H."""
    at = names["amplitudes_at"]
    assert at(names["normal"], np.array([0.5]))[0] == pytest.approx(150 * math.sqrt(math.log(2) / math.log(1e6)), rel=1e-3)
    assert at(names["table"], np.array([0.5]))[0] == pytest.approx(20 + 60 * math.log(2) / math.log(100), rel=1e-3)
