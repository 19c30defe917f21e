"""What a candidate is worth, against run-ups one by one; and what has no peak on the way."""

from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import refused

from wucht import OptimiseBalancer, RunUp, load_machine
from wucht import run as ask
from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, evaluate_batch
from wucht.dynamics.balancers.damping_optimum import compensated_state
from wucht.dynamics.verdicts.outcomes import RESONANCE_PASSED

FAST = load_machine("drozdetskaya-2020/r1-u80")
SPEC = OptimiseBalancer(vary={"damping": [0.01, 1.0]}, unbalance=[8e-3, 12e-3], samples=2, population=4, evaluations=4)


def test_objectives_are_those_of_run_ups_one_by_one() -> None:
    trials = SPEC.prepare(FAST)[0].as_it_is
    each = []
    for phases, unbalance in zip(trials.phases.T.tolist(), trials.spread.tolist(), strict=True):
        own = {"drum.eccentricity": unbalance, "p1.damping": 0.05, "p2.damping": 0.05}
        start = dict(zip(("p1", "p2"), phases, strict=True))
        each.append(ask(RunUp(start=start, until=12.0), FAST.with_values(own)).wucht.summary)
    seen = evaluate_batch(trials, "full", np.array([[0.05]]), lambda _share: None)
    assert seen.objectives[0, PEAK] == pytest.approx(max(s["peak_amplitude"] for s in each), rel=2e-3)
    through = [s for s in each if s["outcome"] in RESONANCE_PASSED]
    assert seen.objectives[0, CAPTURE] == 1 - len(through) / len(each)
    assert seen.objectives[0, SETTLING] == pytest.approx(np.median([s["settling_time"] for s in through]), rel=0.03)


@pytest.mark.parametrize(("drum", "speed", "left"), [(9.75, 199.94, 2.539e-3), (1.5, 159.85, 26.01e-3)])
def test_what_stands_is_where_run_ups_end(drum: float, speed: float, left: float) -> None:
    """Bodies too light for the unbalance: beyond the resonance, a light rotor is held by its vibration far below the speed of
    the drive, where the bodies even add to the unbalance."""
    mass = 0.07 if drum < 9 else 0.06
    bodies = {"p1.mass": mass, "p2.mass": mass, "p1.damping": 0.1, "p2.damping": 0.1}
    machine = FAST.with_values({**bodies, "drum.mass": drum, "drum.eccentricity": 15e-3 / drum})
    run = ask(RunUp(until=10.0, start={"p1": 2.8, "p2": -2.6, "drum": {"speed": 180.0}}), machine).wucht.summary
    state = compensated_state(machine, full=True)
    assert state is not None
    assert run["outcome"] == "passed"
    assert state.speed == pytest.approx(run["final_speed"], rel=1e-6)
    assert state.residual == pytest.approx(run["final_residual_unbalance"] * 15e-3, rel=1e-4)
    assert state.speed == pytest.approx(speed, rel=0.01)
    assert state.residual == pytest.approx(left, rel=0.02)


def test_averaged_equations_see_too_high_a_peak_where_the_passage_is_fast() -> None:
    """Which is why they are not those of the search by default, and what is said where they are asked for."""
    search, doubts = SPEC.model_copy(update={"model": "slow"}).prepare(FAST)
    assert any("too high where a resonance is passed fast" in doubt for doubt in doubts)
    assert SPEC.model_copy(update={"model": "slow", "objectives": ("residual",)}).prepare(FAST)[1] == ()
    slow, full = (evaluate_batch(search.as_it_is, m, np.array([[0.05]]), lambda _share: None) for m in ("slow", "full"))
    assert slow.objectives[0, PEAK] > 1.3 * full.objectives[0, PEAK]
    assert slow.objectives[0, SETTLING] == pytest.approx(full.objectives[0, SETTLING], rel=0.2)


def test_a_held_speed_passes_no_resonance() -> None:
    """There the largest amplitude is that of the jolt with which a run begins, and says nothing of the bodies."""
    held = load_machine("sperling-rollers/figure-9")
    search, _ = OptimiseBalancer(vary={"damping": [1e-5, 1e-4]}).prepare(held)
    assert search.objectives == (SETTLING, RESIDUAL, CAPTURE)
    with refused("study.objectives", given="peak"):
        OptimiseBalancer(vary={"damping": [1e-5, 1e-4]}, objectives=["peak"]).prepare(held)


@pytest.mark.parametrize("start", [{"psi": 1.0}, {"p1": 0.3}, {"p2": {"angle": 0.3, "speed": 1.0}}])
def test_phases_are_not_given(start: dict[str, object]) -> None:
    with refused(f"study.start.{next(iter(start))}", given=next(iter(start.values()))):
        SPEC.model_copy(update={"start": start}).prepare(FAST)


@pytest.mark.parametrize(("key", "ends", "bad"), [("radius", [0.004, 1.0], 1.0), ("track_radius", [0.001, 0.2], 0.001)])
def test_either_end_of_a_range_may_be_what_the_parts_do_not_allow(key: str, ends: list[float], bad: float) -> None:
    """Balls of 5 mm in a ring of 115 mm."""
    with refused(f"study.vary.{key}", given=bad):
        OptimiseBalancer(vary={key: ends}).prepare(load_machine("practice/balls-at-resonance"))
