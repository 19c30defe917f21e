"""The search: a known front, the same search for the same seed, and pymoo missing."""

from __future__ import annotations

import importlib
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from known_fronts import END, MACHINE, RANGE, Parabolas, x_of
from tests.refusals import refused

from wucht.dynamics.balancers import candidates
from wucht.dynamics.sampling import searches
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.studies.optimise_balancer import computation
from wucht.studies.optimise_balancer.spec import OptimiseBalancer
from wucht.studies.runner import draw, report
from wucht.studies.runner import run as ask

TWO = OptimiseBalancer(
    vary={"damping": RANGE}, objectives=["peak", "settling-time"], samples=2, population=20, evaluations=400, points=12,
    damping_curve=False,
)  # fmt: skip


@pytest.fixture(autouse=True)
def _no_steady_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """None are sought: what they leave is compared in test_damping_optimum.py."""
    monkeypatch.setattr(computation, "compensated_state", lambda _machine, full: None)


def test_the_front_is_the_known_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two parabolas of x in [-1, 3]: x in [0, 2] is on the front, where sqrt(f1) + sqrt(f2) = 2."""
    monkeypatch.setattr(candidates, "outcomes_of", Parabolas())
    result = ask(TWO, MACHINE)
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
    monkeypatch.setattr(candidates, "outcomes_of", Parabolas())
    few = TWO.model_copy(update={"evaluations": 60, "points": 1})
    first = ask(few, MACHINE)
    np.random.seed(1)
    assert np.array_equal(first.tried_value, ask(few, MACHINE).tried_value)
    assert not np.array_equal(first.tried_value, ask(few.model_copy(update={"seed": 2}), MACHINE).tried_value)


def test_capture_bounds_where_it_is_no_objective(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs are captured for x < 1 but for the machine as it is (x = 0.7): no other candidate may be."""
    few = TWO.model_copy(update={"evaluations": 100, "points": 1})
    monkeypatch.setattr(candidates, "outcomes_of", Parabolas(lambda x, _: (x < 1) & (np.abs(x - x_of(np.array(5e-5))) > 1e-9)))
    assert x_of(ask(few, MACHINE).front_value.values[:, 0]).min() > x_of(np.array(5e-5)) - 1e-9
    monkeypatch.setattr(candidates, "outcomes_of", Parabolas(lambda x, _: np.ones(len(x), bool)))
    none = ask(few, MACHINE)
    assert none.wucht.summary["front"] == []
    assert "no candidate has all objectives" in report(none)[1]
    draw(none)


def test_runs_without_a_verdict_are_neither_captured_nor_through(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every second run: what is known are bounds, and nothing else counts them."""
    half = Parabolas(open_=lambda _, number: number % 2 == 1)
    monkeypatch.setattr(candidates, "outcomes_of", half)
    asked = TWO.model_copy(update={"objectives": ("settling-time", "capture-probability"), "evaluations": 20, "points": 2})
    result = ask(asked, MACHINE)
    x = x_of(result.tried_value.values[:, 0])
    assert np.allclose(result.tried_objective.values[:, 0], (x**2 + END) / 2)
    assert np.array_equal(result.tried_objective.values[:, 3], np.full(20, 0.5))
    assert np.array_equal(result.tried_undecided.values, np.full(20, 0.5))
    assert any("0 % to 50 % (the rest without a verdict) captured" in line for line in report(result))
    assert "21 candidates have runs without a verdict, up to 50 %" in result.attrs["warnings"]
    draw(result)


def test_a_machine_with_open_runs_bounds_others_by_both_of_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is (x = 0.7) one of two runs is open: another with one that is captured is worse for certain, beyond x = 0.7."""
    own = x_of(np.array(5e-5))
    engine = Parabolas(
        captured=lambda x, number: (x > own + 1e-9) & (number % 2 == 1),
        open_=lambda x, number: (np.abs(x - own) < 1e-9) & (number % 2 == 1),
    )
    monkeypatch.setattr(candidates, "outcomes_of", engine)
    asked = TWO.model_copy(update={"objectives": ("residual", "peak"), "evaluations": 100, "points": 2})
    result = ask(asked, MACHINE)
    assert result.wucht.summary["as_it_is"]["objectives"]["capture-probability"] == 0.5
    assert x_of(result.front_value.values[:, 0]).max() <= own + 1e-9


def test_a_run_that_fails_leaves_no_settling_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        candidates, "outcomes_of", Parabolas(open_=lambda x, number: (x > 0) & (number == 0), without=Outcome.FAILED)
    )
    result = ask(TWO.model_copy(update={"evaluations": 20, "points": 2}), MACHINE)
    failed = result.tried_undecided.values > 0
    assert failed.any()
    assert np.isnan(result.tried_objective.values[failed][:, [0, 2]]).all()
    assert np.isfinite(result.tried_objective.values[~failed]).all()


def test_the_full_equations_are_asked_and_differences_told(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = Parabolas(offset=10.0)
    monkeypatch.setattr(candidates, "outcomes_of", engine)
    result = ask(TWO.model_copy(update={"evaluations": 40, "points": 3, "model": "slow"}), MACHINE)
    searched, check, *later = engine.starts
    assert check.shape[1] == 4 * searched.shape[1] == 8
    assert sum(np.array_equal(starts, check) for starts in later) >= 3, "of each point"
    assert not np.isclose(check[:, 0], searched[:, 0]).all(), "what suits the phases of the search may not suit others"
    assert np.allclose(result.front_checked.values[:, 0], result.front_objective.values[:, 0] + 10)
    assert "the full equations, from other phases, give another settling-time at 3 of 3 points" in result.attrs["warnings"]
    assert "another peak" not in result.attrs["warnings"]


def test_the_curve_comes_with_the_rates_of_its_dampings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Settling times x^2 over the range of the damping, on which x = 0 has the sixth of 25 values and a quarter of it."""
    engine, of_rates = Parabolas(), list[np.ndarray]()

    def rates(_trials: Any, dampings: np.ndarray, _report: Any = None) -> Any:
        of_rates.append(dampings)
        return SimpleNamespace(values=2 * dampings, greatest_at=3e-3)

    monkeypatch.setattr(candidates, "outcomes_of", engine)
    monkeypatch.setattr(computation, "decay_rates", rates)
    result = ask(TWO.model_copy(update={"evaluations": 20, "points": 1, "damping_curve": True}), MACHINE)
    dampings = result.damping.values
    assert dampings == pytest.approx(np.geomspace(*RANGE, 25)) and of_rates[0] is not None
    assert result.settling_time.values == pytest.approx(x_of(dampings) ** 2, abs=1e-12)
    assert result.decay_rate.values == pytest.approx(2 * dampings)
    assert result.wucht.summary["damping"]["optimum"] == pytest.approx(1e-5)
    assert result.wucht.summary["damping"]["of_rates"] == 3e-3
    assert result.wucht.summary["runs"] == 2 * (1 + 25 + 20 + 4 * 2) < engine.members < 2 * (1 + 25 + 20 + 4 * 2) + 200


def test_without_pymoo_a_sentence_says_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    def without(name: str) -> Any:
        if name.startswith("pymoo"):
            raise ImportError(name)
        return importlib.import_module(name)

    monkeypatch.setattr(searches, "import_module", without)
    with refused("study.kind", "wucht[optimise]", given="optimise-balancer"):
        ask(TWO, MACHINE)


@pytest.mark.parametrize(
    ("shares", "is_first"),
    [((0.3, 0.6), True), ((0.0, 1.0), True), ((-0.1, 0.5), False), ((0.5, 1.1), False), ((1.1, 1.1), False)],
)
def test_the_machine_as_it_is_comes_first_if_all_that_is_varied_lies_in_its_range(
    shares: tuple[float, ...], is_first: bool
) -> None:
    variables = [SimpleNamespace(share=lambda x: x) for _ in shares]
    plan: Any = SimpleNamespace(spec=SimpleNamespace(population=5, seed=1), numbers=shares)
    generation = computation._first_generation(plan, 2, SimpleNamespace(variables=variables))  # type: ignore[arg-type]
    assert generation.shape == (5, 2)
    assert (generation[0].tolist() == list(shares)) is is_first
    assert ((generation >= 0) & (generation <= 1)).all()


def test_a_front_of_nothing_has_no_points() -> None:
    assert computation.front_of(SimpleNamespace(), SimpleNamespace(evaluated_generations=())) == ((), 0)  # type: ignore[arg-type]


def test_a_search_recommends_what_balances(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two parabolas all runs end compensated: the fastest one, x near 0; if half of them pass without, none is."""
    monkeypatch.setattr(candidates, "outcomes_of", Parabolas())
    few = TWO.model_copy(update={"evaluations": 60})
    result = ask(few, MACHINE)
    s = result.wucht.summary
    assert s["recommended"]["settling_time"] == min(p["checked"]["settling-time"] for p in s["front"] if p["holds"])
    assert s["front"][s["recommended"]["point"]]["parameters"] == pytest.approx(s["recommended"]["parameters"], rel=1e-3)
    assert s["recommended"]["fails"] == 0 and all(p["balances"] for p in s["front"])
    assert (
        s["sentence"].startswith("2 bodies: median settling time ")
        and ", 0 % fail; with " in s["sentence"]
        and "; a front of " in s["sentence"]
    )
    half = Parabolas(open_=lambda _x, run: run % 2 == 0, without=Outcome.PASSED)
    monkeypatch.setattr(candidates, "outcomes_of", half)
    passing = ask(few, MACHINE).wucht.summary
    assert passing["recommended"] is None and not any(p["balances"] for p in passing["front"])
    assert passing["sentence"].startswith("nothing that was compared balances in more than half of its runs; ")
