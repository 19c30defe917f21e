"""Candidates of a balancer in one ensemble: whose values its runs have, the error of a median, and compensated states."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.balancers import candidates, damping_optimum
from wucht.dynamics.balancers.candidates import (
    CAPTURE,
    PEAK,
    RESIDUAL,
    SETTLING,
    BalancerTrials,
    CandidateResults,
    evaluate_batch,
    evaluate_candidates,
    power_of_two,
)
from wucht.dynamics.balancers.damping_optimum import compensated_state, damping_curve, decay_rate
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.sampling.searches import Variable
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, OUTCOMES, RESONANCE_PASSED, Outcome
from wucht.dynamics.work import Work
from wucht.files.building import machine_from

SAMPLES = 4


def machine() -> Any:
    ball = {"kind": "pendulum", "about": "d", "mass": 0.05, "length": 0.1, "damping": 0.01}
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 5.0},
        "bodies": [
            {"kind": "rotor", "name": "d", "mass": 1.0, "unbalance": 4e-3, "inertia": 0.01}, ball | {"name": "p"},
            ball | {"name": "q"},
        ],
        "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": 300.0},
    })  # fmt: skip


def trials(fresh: bool = False, ends: tuple[float, float] = (0.0, 24e-3)) -> BalancerTrials:
    runs: Any = SAMPLES, 3, {"d": {"angle": 0.5}}, None, 1, 1e-6
    variable = Variable("mass", "mass", ("p.mass", "q.mass"), 0.01, 0.2, "kg", "mass")
    return BalancerTrials(machine(), (variable,), "d.unbalance", ends, True, *runs, fresh)


PASSED, CAPTURED, OPEN = (OUTCOMES.index(o) for o in (Outcome.COMPENSATED, Outcome.CAPTURED, Outcome.UNIDENTIFIED))


def test_each_run_has_the_values_of_its_candidate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four runs of each of three candidates, of which the second is not allowed; the unbalance goes from 0 to 24 g m in each.
    Of 24 g m bodies of 100 g leave 4, of 40 g 16."""
    given: dict[str, Any] = {}

    def outcomes_of(question: Any, starts: np.ndarray, values: dict[str, np.ndarray], report: Any) -> MemberOutcomes:
        given.update(values=values, starts=starts, question=question)
        outcome = np.array([PASSED] * 5 + [CAPTURED] + [PASSED] * 2)
        settling = np.array([1.0, 2.0, 3.0, 4.0, 8.0, np.nan, 6.0, 7.0])
        return MemberOutcomes(outcome, settling, np.array([1.0, 4.0, 2.0, 3.0, 8.0, 5.0, 6.0, 7.0]), np.full(8, 50.0))

    monkeypatch.setattr(candidates, "outcomes_of", outcomes_of)
    of = trials()
    found = evaluate_batch(of, "slow", np.array([[0.1], [-1.0], [0.04]]), lambda _: None)
    assert given["values"]["p.mass"].tolist() == given["values"]["q.mass"].tolist() == [0.1] * 4 + [0.04] * 4
    assert given["values"]["d.unbalance"] == pytest.approx([0.0, 8e-3, 16e-3, 24e-3] * 2)
    assert set(given["question"].varied_paths) == {"p.mass", "q.mass", "d.unbalance"} and given["question"].model == "slow"
    row = of.machine.row(of.machine.body("q").coordinate.position)
    assert given["starts"][row] == pytest.approx(np.tile(0.5 + of.phases[1], 2)), "as placed to the rotor, which has turned"
    assert found.is_allowed.tolist() == [True, False, True]
    assert found.objectives[:, SETTLING] == pytest.approx([2.5, math.nan, 7.5], nan_ok=True)
    assert found.objectives[:, RESIDUAL] == pytest.approx([4e-3, math.nan, 16e-3], nan_ok=True)
    assert found.objectives[:, PEAK] == pytest.approx([4.0, math.nan, 8.0], nan_ok=True)
    assert found.objectives[:, CAPTURE] == pytest.approx([0.0, math.nan, 0.25], nan_ok=True)
    assert found.outcomes[:, [PASSED, CAPTURED]].tolist() == [[1.0, 0.0], [0.0, 0.0], [0.75, 0.25]]
    normal = math.sqrt(math.pi / 2)
    assert found.error == pytest.approx(
        [normal * math.sqrt(1.25) / 2, math.nan, normal * np.std([6.0, 7.0, 8.0]) / math.sqrt(3)], nan_ok=True
    )
    assert found.times.tolist() == [[1.0, 2.0, 3.0, 4.0], [np.inf] * 4, [8.0, np.inf, 6.0, 7.0]]
    assert found.outcome[[0, 2]].tolist() == [[PASSED] * 4, [PASSED, CAPTURED, PASSED, PASSED]]
    assert (found.outcome[1] == OUTCOMES.index(Outcome.FAILED)).all()
    picked = found.pick(2)
    assert (picked.numbers.tolist(), picked.error.tolist()) == ([[0.04]], [found.error[2]])
    assert CandidateResults.join([picked, found]).numbers.ravel().tolist() == [0.04, 0.1, -1.0, 0.04]


def test_candidates_come_back_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    def batch(_: Any, model: str, rows: np.ndarray, report: Any) -> CandidateResults:
        n = len(rows)
        return replace(CandidateResults.unknown(n, 1, SAMPLES), numbers=rows, error=rows[:, 0])

    monkeypatch.setattr(candidates, "evaluate_batch", batch)
    numbers = np.arange(35.0)[:, None]
    assert evaluate_candidates(trials(), "full", numbers, Work(), "").error.tolist() == numbers.ravel().tolist()


def test_shares_of_runs_that_are_captured_and_open() -> None:
    shares = np.zeros((1, len(OUTCOMES)))
    shares[0, [OUTCOMES.index(o) for o in RESONANCE_PASSED]] = 0.125
    shares[0, [OUTCOMES.index(o) for o in OPEN_OUTCOMES]] = 0.0625
    passed, undecided = 0.125 * len(RESONANCE_PASSED), 0.0625 * len(OPEN_OUTCOMES)
    of = replace(CandidateResults.unknown(1, 1, SAMPLES), outcomes=shares)
    assert of.undecided_share == pytest.approx([undecided])
    assert of.captured_share == pytest.approx([max(1 - passed - undecided, 0.0)])


def test_unbalances_and_phases_of_the_runs() -> None:
    assert trials().spread == pytest.approx([0.0, 8e-3, 16e-3, 24e-3]) and trials(ends=(2.0, 2.0)).spread.tolist() == [2.0] * 4
    assert not np.array_equal(trials().phases, trials(fresh=True).phases)
    assert trials().phases.shape == (2, 4) and [power_of_two(n) for n in (1, 2, 3, 4, 5, 64, 65)] == [1, 2, 4, 4, 8, 64, 128]


def states(monkeypatch: pytest.MonkeyPatch, *known: tuple[float | None, bool | None, bool]) -> list[str]:
    """States by their residual, and their stability by the averaged equations and by the full ones."""
    names = [f"s{k}" for k in range(len(known))]
    of = dict(zip(names, known, strict=True))

    def describe(state: str, stability: Any) -> Any:
        leading = None if of[state][0] is None else -2.0 + 3j
        slow = SimpleNamespace(stable=of[state][1], leading=leading)
        return SimpleNamespace(residual=of[state][0], slow=slow, name=state)

    patch = monkeypatch.setattr
    patch(damping_optimum, "machine_at_speed", lambda *_: None)
    patch(damping_optimum, "averaged_equations_of", lambda *_: None)
    patch(damping_optimum.SteadyTorques, "from_averaged_equations", lambda *_: None)
    patch(damping_optimum, "AveragedStability", lambda *_: None)
    describer = SimpleNamespace(averaged_stability=SimpleNamespace(stability=lambda _: None), describe=describe)
    patch(damping_optimum, "ConfigurationDescriber", lambda *_: describer)
    full = SimpleNamespace(stability=lambda state: SimpleNamespace(stable=of[state][2]))
    patch(damping_optimum, "FullStability", lambda *_: full)
    return names


@pytest.mark.parametrize(
    ("known", "slow", "full"),
    [
        (((0.2, True, True), (0.1, True, True), (0.0, False, True)), "s1", "s1"),
        (((0.2, True, True), (0.1, True, False)), "s1", "s0"), (((0.2, True, True), (0.1, None, True)), "s0", "s1"),
        (((0.2, False, True), (None, True, True)), None, None), ((), None, None),
    ],
)  # fmt: skip
def test_the_stable_state_that_leaves_least(
    monkeypatch: pytest.MonkeyPatch, known: tuple[Any, ...], slow: str | None, full: str | None
) -> None:
    of: Any = states(monkeypatch, *known)
    for by_full, name in ((False, slow), (True, full)):
        found: Any = compensated_state(None, by_full, of)  # type: ignore[arg-type]
        assert (None if found is None else found.name) == name
    rate = decay_rate(None, of)  # type: ignore[arg-type]
    assert rate == pytest.approx(math.nan if slow is None else 2.0, nan_ok=True)


@pytest.mark.parametrize(("speed", "resonances"), [(None, True), (100.0, False)])
def test_states_above_their_resonance(monkeypatch: pytest.MonkeyPatch, speed: float | None, resonances: bool) -> None:
    """Their resonances are at 90, at 120, and nowhere; at a prescribed speed all count."""
    of = [SimpleNamespace(speed=100.0, phases=np.array([k, 0.0])) for k in (90.0, 120.0, np.nan)]
    patch = monkeypatch.setattr
    steady = SimpleNamespace(bodies=["d", "p"], rotor="d", group=lambda _: ["d", "p"])
    patch(damping_optimum, "machine_at_speed", lambda *_: steady)
    patch(damping_optimum, "averaged_equations_of", lambda *_: None)
    patch(damping_optimum.SteadyTorques, "from_averaged_equations", lambda *_: SimpleNamespace(fixed_speed=speed))
    patch(damping_optimum, "driven_speeds", lambda *_: ((1.0, 300.0), False))
    patch(damping_optimum, "all_states", lambda *_: SimpleNamespace(states=of))

    def last_maximum(high: float, phases: np.ndarray) -> float | None:
        assert high == 300.0
        return None if np.isnan(phases[0]) else float(phases[0])

    vibration = SimpleNamespace(select_bodies=lambda index: SimpleNamespace(last_maximum=last_maximum))
    patch(damping_optimum.Vibration, "of", lambda *_: vibration)
    found = damping_optimum.states_at_speed(None)  # type: ignore[arg-type]
    assert list(found) == ([of[0], of[2]] if resonances else of)


def test_the_curve_over_the_damping() -> None:
    """Where fewer runs pass its settling times are drawn, but are not the shortest."""
    objectives = np.column_stack([[1.0, 3.0, 4.0], np.zeros(3), np.zeros(3), [0.5, 0.25, 0.25]])
    dampings = np.array([0.1, 0.2, 0.3])
    results = replace(CandidateResults.unknown(3, 1, SAMPLES), numbers=dampings[:, None], objectives=objectives)
    curve = damping_curve(dampings, results, (np.array([7.0, 8.0, 9.0]), 0.25))
    assert (curve.settling_time.tolist(), curve.share_through.tolist()) == ([1.0, 3.0, 4.0], [0.5, 0.75, 0.75])
    assert (curve.rate.tolist(), curve.optimum, curve.rate_optimum) == ([7.0, 8.0, 9.0], 0.2, 0.25)
    assert curve.damping.tolist() == dampings.tolist()


def median(outcomes: list[int], settling: list[float], end: float = 50.0) -> tuple[float, float]:
    n = len(outcomes)
    return candidates._median_settling(MemberOutcomes(np.array(outcomes), np.array(settling), np.zeros(n), np.full(n, end)))


def test_a_median_settling_time() -> None:
    """Of all runs, those that are captured take for ever; one without a verdict as long as it was followed."""
    failed = OUTCOMES.index(Outcome.FAILED)
    assert median([PASSED] * 3, [1.0, 3.0, 8.0])[0] == 3.0
    assert median([PASSED, PASSED, CAPTURED], [1.0, 3.0, np.nan])[0] == 3.0
    assert np.isnan(median([PASSED, CAPTURED, CAPTURED], [1.0, np.nan, np.nan])).all()
    assert median([PASSED, OPEN, OPEN], [1.0, np.nan, np.nan]) == (
        50.0, pytest.approx(math.sqrt(math.pi / 2) * np.std([1.0, 50.0, 50.0]) / math.sqrt(3)),
    )  # fmt: skip
    assert np.isnan(median([OPEN] * 3, [np.nan] * 3)).all(), "none has passed"
    assert np.isnan(median([PASSED, PASSED, failed], [1.0, 3.0, np.nan])).all()


def test_the_first_of_several_candidates_is_picked_alone() -> None:
    numbers = np.array([[1.0], [2.0], [3.0]])
    results = replace(CandidateResults.unknown(3, 1, SAMPLES), numbers=numbers)
    assert [results.pick(k).numbers.tolist() for k in range(3)] == [[[1.0]], [[2.0]], [[3.0]]]
