"""The search: a known front, the same search for the same seed, what capture allows, and pymoo missing."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest
from known_fronts import CAUGHT, END, OPEN, OWN, Candidate, End, KnownRuns, ask_known, parabolas, told, x_of
from tests.refusals import refused

from wucht import draw
from wucht.dynamics.sampling import searches
from wucht.dynamics.verdicts.outcomes import Outcome

TWO: dict[str, Any] = {"objectives": ["peak", "settling-time"], "samples": 2, "population": 20, "points": 12}


def test_the_front_is_the_known_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two parabolas of x in [-1, 3]: x in [0, 2] is on the front, where sqrt(f1) + sqrt(f2) = 2."""
    result = ask_known(monkeypatch, parabolas, **TWO, evaluations=400)
    s = result.wucht.summary
    f = result.front_objective.values[:, [0, 2]]
    x = x_of(result.front_value.values[:, 0])
    assert len(x) == 12
    assert np.allclose(np.sqrt(f).sum(axis=1), 2, atol=0.02), "no further off than tried points are apart"
    assert x.min() < 0.05
    assert x.max() > 1.95
    assert np.diff(np.sort(x)).max() < 0.4
    tried = x_of(result.tried_value.values[:, 0])
    assert np.mean((tried[-20:] > -0.01) & (tried[-20:] < 2.01)) > np.mean((tried[:20] > 0) & (tried[:20] < 2)), "it learns"
    assert s["found"] > 50
    assert all(p["holds"] for p in s["front"])
    assert s["candidates"] == 400


@pytest.mark.slow
def test_another_seed_is_another_search_the_same_seed_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    few = TWO | {"evaluations": 60, "points": 1}
    first = ask_known(monkeypatch, parabolas, **few).tried_value
    np.random.seed(1)
    assert np.array_equal(first, ask_known(monkeypatch, parabolas, **few).tried_value)
    assert not np.array_equal(first, ask_known(monkeypatch, parabolas, **few, seed=2).tried_value)


def test_capture_bounds_where_it_is_no_objective(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs are captured for x < 1 but for the machine as it is (x = 0.7): no other candidate may be."""

    def ends(candidate: Candidate) -> End:
        return CAUGHT if candidate.x < 1 and abs(candidate.x - OWN) > 1e-9 else parabolas(candidate)

    few = TWO | {"evaluations": 100, "points": 1}
    assert x_of(ask_known(monkeypatch, ends, **few).front_value.values[:, 0]).min() > OWN - 1e-9


def test_runs_without_a_verdict_are_neither_captured_nor_through(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the runs: what is known are bounds, and nothing else counts them."""
    asked = TWO | {"objectives": ["settling-time", "capture-probability"], "evaluations": 20, "points": 2}
    result = ask_known(monkeypatch, lambda of: [(0.5, OPEN), (0.5, parabolas(of))], **asked)
    x = x_of(result.tried_value.values[:, 0])
    assert np.allclose(result.tried_objective.values[:, 0], (x**2 + END) / 2)
    assert np.array_equal(result.tried_objective.values[:, 3], np.full(20, 0.5))
    assert np.array_equal(result.tried_undecided.values, np.full(20, 0.5))
    assert told(result)["as it is"].endswith("0 % to 50 % (the rest without a verdict) captured, does not balance")
    assert "21 candidates have runs without a verdict, up to 50 %" in result.attrs["warnings"]
    draw(result)


def test_a_machine_with_open_runs_bounds_others_by_both_of_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is (x = 0.7) one of two runs is open: another with one that is captured is worse for certain, beyond x = 0.7."""

    def ends(candidate: Candidate) -> Any:
        if abs(candidate.x - OWN) < 1e-9:
            return [(0.5, parabolas(candidate)), (0.5, OPEN)]
        return [(0.5, parabolas(candidate)), (0.5, CAUGHT)] if candidate.x > OWN else parabolas(candidate)

    asked = TWO | {"objectives": ["residual", "peak"], "evaluations": 100, "points": 2}
    result = ask_known(monkeypatch, ends, **asked)
    assert result.wucht.summary["as_it_is"]["objectives"]["capture-probability"] == 0.5
    assert x_of(result.front_value.values[:, 0]).max() <= OWN + 1e-9
    open_beyond = ask_known(
        monkeypatch, lambda of: [(0.5, parabolas(of)), (0.5, OPEN if of.x > OWN + 1e-9 else parabolas(of))], **asked
    )
    assert x_of(open_beyond.front_value.values[:, 0]).max() <= OWN + 1e-9, "more of these may be captured"


def test_a_run_that_fails_leaves_no_settling_time(monkeypatch: pytest.MonkeyPatch) -> None:
    def ends(candidate: Candidate) -> Any:
        of_failure = [(0.5, End(outcome=Outcome.FAILED)), (0.5, parabolas(candidate))]
        return of_failure if candidate.x > 0 else parabolas(candidate)

    result = ask_known(monkeypatch, ends, **TWO | {"evaluations": 20, "points": 2})
    failed = result.tried_undecided.values > 0
    assert failed.any()
    assert np.isnan(result.tried_objective.values[failed][:, [0, 2]]).all()
    assert np.isfinite(result.tried_objective.values[~failed]).all()


def test_the_full_equations_are_asked_and_differences_told(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = KnownRuns(lambda of: End(of.x**2 + (10.0 if of.is_full else 0.0), (of.x - 2) ** 2))
    result = ask_known(monkeypatch, engine, **TWO | {"evaluations": 40, "points": 3}, model="slow")
    searched, check, *later = engine.starts
    assert check.shape[1] == 4 * searched.shape[1] == 8
    assert sum(np.array_equal(starts, check) for starts in later) >= 3, "of each point"
    assert not np.isclose(check[:, 0], searched[:, 0]).all(), "what suits the phases of the search may not suit others"
    assert np.allclose(result.front_checked.values[:, 0], result.front_objective.values[:, 0] + 10)
    assert "the full equations, from other phases, give another settling-time at 3 of 3 points" in result.attrs["warnings"]
    assert "another peak" not in result.attrs["warnings"]


def test_without_pymoo_a_sentence_says_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    def without(name: str) -> Any:
        if name.startswith("pymoo"):
            raise ImportError(name)
        return importlib.import_module(name)

    monkeypatch.setattr(searches, "import_module", without)
    with refused("study.kind", "wucht[optimise]", given="optimise-balancer"):
        ask_known(monkeypatch, parabolas)


def test_a_search_recommends_what_balances(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two parabolas all runs end compensated: the fastest one, x near 0; if half of them pass without, none is."""
    few = TWO | {"evaluations": 60}
    s = ask_known(monkeypatch, parabolas, **few).wucht.summary
    assert s["recommended"]["settling_time"] == min(p["checked"]["settling-time"] for p in s["front"] if p["holds"])
    assert s["front"][s["recommended"]["point"]]["parameters"] == pytest.approx(s["recommended"]["parameters"], rel=1e-3)
    assert s["recommended"]["fails"] == 0 and all(p["balances"] for p in s["front"])
    assert s["sentence"].startswith("2 bodies: median settling time ") and "; a front of " in s["sentence"]
    assert ", 0 % fail; with " in s["sentence"]
    passes = ask_known(
        monkeypatch, lambda of: [(0.5, parabolas(of)._replace(outcome=Outcome.PASSED)), (0.5, parabolas(of))], **few
    )
    passing = passes.wucht.summary
    assert passing["recommended"] is None and not any(p["balances"] for p in passing["front"])
    assert passing["sentence"].startswith("nothing that was compared balances in more than half of its runs; ")
