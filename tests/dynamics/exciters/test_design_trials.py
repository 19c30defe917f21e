"""Candidates of a design: the search near one, and the run that checks it, with distances made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.exciters import design_trials
from wucht.dynamics.exciters.design_trials import DesignTrials, check_candidate, spectrum_distances
from wucht.dynamics.exciters.slow_beats import Beat
from wucht.dynamics.sampling.searches import Variable
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.fatigue.counted_cycles import LoadCycles

RUNS: Any = "displacement", "y", {"p": 0.1}, True, 1e-8
NARROW, WIDE = (Variable(n, None, (n,), low, high, "", "") for n, low, high in (("a", 2.0, 4.0), ("b", 1.0, 100.0)))
TARGET = LoadCycles(np.ones(1), np.zeros(1), np.ones(1))


class Bowl(DesignTrials):
    """A beat only where a < 3.95; its distance is that from a = 2.5, b = 10, as shares of the ranges."""

    def beat(self, numbers: np.ndarray) -> Beat:
        tried.append(numbers.tolist())
        shares = self.shares(numbers) - np.array([0.25, 0.5])
        return Beat("modulated" if numbers[0] < 3.95 else "steady", amplitude=np.array([np.hypot(*shares)]), rate=np.ones(1))


tried = list[list[float]]()


def trials(metric: int = 1) -> DesignTrials:
    return Bowl(None, (NARROW, WIDE), *RUNS, metric, 4.0)  # type: ignore[arg-type]


def test_shares_of_the_ranges() -> None:
    """Of two decades by the logarithm."""
    assert trials().values(np.array([[0.25, 0.5], [1.0, 0.0]])) == pytest.approx(np.array([[2.5, 10.0], [4.0, 1.0]]))
    assert trials().shares(np.array([2.5, 10.0])) == pytest.approx([0.25, 0.5])


@pytest.mark.parametrize("metric", [0, 1, 2])
def test_the_best_near_a_candidate(monkeypatch: pytest.MonkeyPatch, metric: int) -> None:
    """By the metric of the study; the first steps are a twentieth of the ranges, inwards at their upper ends."""

    def distances(cycles: LoadCycles, target: LoadCycles, slope: float) -> tuple[float, ...]:
        assert (target, slope) == (TARGET, 4.0)
        off = [7.0, 7.0, 7.0]
        off[metric] = float(cycles.ranges[0]) / 2
        return tuple(off)

    monkeypatch.setattr(design_trials, "spectrum_distances", distances)
    shares = list[float]()
    numbers, distance = trials(metric).optimise(np.array([3.0, 3.0]), TARGET, 200, shares.append)
    assert numbers == pytest.approx([2.5, 10.0], rel=1e-5) and distance == pytest.approx(0.0, abs=1e-6)
    assert shares[:3] == [0.0, 1 / 200, 2 / 200] and max(shares) <= 1.0
    tried.clear()
    trials(metric).optimise(np.array([4.0, 1.0]), TARGET, 3, shares.append)
    first = np.array(tried[:3])
    assert first[:, 0] == pytest.approx([4.0, 3.9, 4.0]) and first[:, 1] == pytest.approx([1.0, 1.0, 100**0.05])
    numbers, distance = trials(metric).optimise(np.array([9.0, 1.0]), TARGET, 1, shares.append)
    assert distance == 1e3 and numbers[0] == pytest.approx(4.0), "nothing beats there; a start outside is moved in"


@pytest.mark.parametrize(
    ("outcome", "beats"), [(Outcome.CAPTURED_MODULATED, True), (Outcome.BALANCER_CAPTURED, True), (Outcome.PASSED, False)]
)
def test_a_candidate_is_run_over_its_beats(monkeypatch: pytest.MonkeyPatch, outcome: Outcome, beats: bool) -> None:
    """Only turning points after the beat has begun count: at 7 s; a quarter as many cycles as in the target."""
    case, signals = SimpleNamespace(machine="machine"), list[Any]()

    def of(machine: Any, start: Any, settings: Any) -> Any:
        signals.append((machine, start, settings.until, settings.tolerance))
        return case

    points = np.array([0.0, 9.0, -9.0, 2.0, -1.0, 2.0, -1.0, 2.0])
    last = SimpleNamespace(
        values=points, time=np.array([0.0, 1.0, 6.9, 7.0, 8.0, 9.0, 10.0, 11.0]), end_time=12.5,
        verdict=SimpleNamespace(outcome=outcome), failure="it burst" if beats else None,
    )  # fmt: skip
    monkeypatch.setattr(design_trials, "RunUpCase", SimpleNamespace(of=of))
    monkeypatch.setattr(design_trials, "machine_signal", lambda *given: (signals.append(given), "signal")[1])
    monkeypatch.setattr(design_trials, "load_histories", lambda *_: iter([None, last]))
    monkeypatch.setattr(DesignTrials, "candidate_machine", lambda _, numbers: numbers.tolist())
    monkeypatch.setattr(Bowl, "beat", lambda _, __: Beat("modulated", 7.0, 0.5))
    target = LoadCycles(np.array([4.0]), np.zeros(1), np.array([2.0]))
    made = check_candidate(trials(), np.array([3.0, 5.0]), target, 40, Work())
    assert signals == [([3.0, 5.0], {"p": 0.1}, 27.0, 1e-8), ("machine", "displacement", "y")]
    assert (made.cycles.ranges.tolist(), made.cycles.counts.sum(), made.duration) == ([3.0], pytest.approx(2.0), 5.5)
    assert made.distances == pytest.approx(spectrum_distances(made.cycles, target, 4.0))
    assert (made.outcome, made.beats, made.reason) == (str(outcome), beats, "it burst" if beats else "")
    assert made.slow.begin == 7.0 and made.cycles.largest == 3.0
