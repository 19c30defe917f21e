"""What is stated of a search, and in which words: of runs whose ends are known, in place of the integration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from known_fronts import CAUGHT, MACHINE, OPEN, OWN, RANGE, Candidate, End, KnownRuns, ask_known, told, x_of
from tests.refusals import refused

from interrupting import stop_at
from wucht.dynamics.balancers.candidates import least_residual
from wucht.dynamics.balancers.recommendation import motor_time
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.studies.runner import draw

Patch = pytest.MonkeyPatch
UNBALANCE = 9.75e-3  # kg m, of 9.75 kg at 1 mm
ABOVE = {"vary": {"damping": [1e-4, 1e-2]}}  # ranges without the machine as it is, whose x is 0.7
BY_MASS = {"vary": {"mass": [0.01, 0.02]}}  # g: two of these bodies leave some of the unbalance


def is_own(candidate: Candidate) -> bool:
    return abs(candidate.x - OWN) < 1e-6


def three(candidate: Candidate) -> Any:
    """As it is 10 s, with less damping 5 s, with more 12 s; captured in 25 %, 12.5 % and none of the runs."""
    if is_own(candidate):
        return [(0.25, CAUGHT), (0.75, End(10.0, 4e-3))]
    return [(0.125, CAUGHT), (0.875, End(5.0, 6e-3))] if candidate.x < OWN else End(12.0, 1e-3)


def another(result: xr.Dataset) -> list[str]:
    return [warning for warning in result.wucht.warnings if "give another" in warning]


def test_the_lines_of_a_front(monkeypatch: Patch) -> None:
    """A point that is the best in several objectives is told once; of equally good ones that which is captured least."""
    result = ask_known(monkeypatch, three)
    lines = told(result)
    assert list(lines)[:6] == ["searched", "as it is", "recommended", "compared", "to paste", "min settling"]
    assert list(lines)[6:8] == ["min residual", "integrated"], "it has the least peak, too"
    assert lines["searched"] == (
        "4 candidates, 8 runs each from random phases, unbalance 0.00975 kg·m; evaluated with the full equations"
    )
    alike = "0 kg·m residual unbalance"
    own = "2 bodies, damping 5e-05 N·m·s: median settling time 10 s"
    assert lines["as it is"] == f"{own}, {alike}, peak 4 mm, 25 % captured"
    assert lines["min settling"].endswith(
        f"median settling time 5 s, {alike}, peak 6 mm, 12.5 % captured (time -50 %, peak +50 %)"
    )
    assert lines["min residual"].endswith(
        f"median settling time 12 s, {alike}, peak 1 mm, 0 % captured (time +20 %, peak -75 %)"
    )
    assert result.wucht.sentence.endswith("; a front of 3 points from 4 candidates; 3 of 3 checked points are confirmed")
    assert lines["compared"] == (
        "settling time 12 ± 0 s in 32 runs of its own; from the same starts neighbours 12 s, 2 fail more often"
    )
    assert "; with 99 % less damping 12.5 % fail; " in result.wucht.sentence
    slow = told(ask_known(monkeypatch, three, model="slow", unbalance=[2e-3, 6e-3], objectives=["peak"]))
    assert slow["searched"].endswith("unbalance 0.002 to 0.006 kg·m; evaluated with the averaged equations")
    assert "N·m·s: peak 1 mm (peak -75 %)" in slow["min peak"] and "min settling" not in slow


def test_the_machine_as_it_is_has_its_values_and_both_evaluations(monkeypatch: Patch) -> None:
    """What the bodies leave is by the check that of the stable state, not that of the runs."""

    def ends(candidate: Candidate) -> Any:
        through = End(9.0, 0.75) if candidate.is_full else End(8.0, 0.25)
        return [(0.25 if candidate.is_full else 0.125, OPEN), (0.75 if candidate.is_full else 0.875, through)]

    s = (result := ask_known(monkeypatch, ends, model="slow", stands=lambda _: 0.625)).wucht.summary
    names = ("settling-time", "residual", "peak", "capture-probability")
    assert s["as_it_is"] == {
        "bodies": 2, "parameters": {"damping": 5e-5}, "undecided": 0.125, "checked_undecided": 0.25, "balances": True,
        "objectives": dict(zip(names, (8.0, 0.0, 0.25, 0.125), strict=True)), "fails": 0.25,
        "checked": dict(zip(names, (9.0, 0.625, 0.75, 0.25), strict=True)),
    }  # fmt: skip
    assert result.own_objective.values.tolist() == [8.0, 0.0, 0.25, 0.125]
    assert result.own_checked.values.tolist() == [9.0, 0.625, 0.75, 0.25]
    assert s["units"] == {"settling-time": "s", "residual": "kg m", "peak": "m", "capture-probability": ""}
    assert "settling-time in s, residual in kg m, peak in m, capture-probability in 1" in result.own_objective.long_name
    assert s["variables"] == {"damping": {"paths": ["p1.damping", "p2.damping"], "range": RANGE, "unit": "N m s"}}
    assert "median settling time at least 9 s" in told(result)["as it is"]
    assert told(result)["as it is"].endswith("0 % to 25 % (the rest without a verdict) captured")


def test_the_unbalance_is_that_of_the_rotor_or_that_of_the_question(monkeypatch: Patch) -> None:
    engine = KnownRuns(three)
    assert ask_known(monkeypatch, engine).wucht.summary["unbalance"] == pytest.approx([UNBALANCE] * 2)
    asked = ask_known(monkeypatch, engine, unbalance=[2e-3, 6e-3]).wucht.summary
    assert asked["unbalance"] == pytest.approx([2e-3, 6e-3])
    with refused("drum.eccentricity", "study.unbalance", given=0.0):
        ask_known(monkeypatch, engine, MACHINE.with_values({"drum.eccentricity": 0.0}))


def test_the_number_of_runs_counts_the_machine_twice_and_each_candidate_and_point_once(monkeypatch: Patch) -> None:
    """A check has four times as many; there are no more points than candidates."""
    engine, small = KnownRuns(three), {"samples": 8, "evaluations": 8, "points": 5}
    runs = [
        ask_known(monkeypatch, engine, **small | more).wucht.summary["runs"]
        for more in ({"damping_curve": True}, {}, {"points": 50})
    ]
    assert runs == [8 * (1 + 25 + 8 + 4 * 6), 8 * (1 + 8 + 4 * 6), 8 * (1 + 8 + 4 * 9)]
    assert sum(runs) < engine.members, "the comparison that follows is not counted"


@pytest.mark.parametrize(
    ("asked", "shares"),
    [({"damping_curve": True}, (2 / 14, 9 / 14)), ({}, (2 / 9, 4 / 9)), ({"evaluations": 80}, (2 / 27, 22 / 27))],
)
def test_the_progress_counts_units_of_work(asked: dict[str, Any], shares: tuple[float, float], monkeypatch: Patch) -> None:
    """6 candidates of 10 runs are a unit: 2 units for the machine as it is, 5 for the curve, 1 a generation, 5 points; the
    comparison from which the recommendation follows is 0.3 of all."""
    reached = dict[str, float]()

    def note(share: float, what: str) -> None:
        reached[what.partition(",")[0]] = share

    ask_known(monkeypatch, three, progress=note, **{"samples": 10, "evaluations": 8, "points": 5} | asked)
    assert (reached["the machine as it is"], reached["2 bodies"]) == pytest.approx(tuple(0.7 * share for share in shares))
    assert reached["check with the full equations"] == pytest.approx(0.7)


def slower_by_check(candidate: Candidate) -> End:
    """As it is 10 s, by the check 20 s; with less damping 1 s, by the check 40 s; with more 5 s by both."""
    by_search, by_check = (10.0, 20.0) if is_own(candidate) else (1.0, 40.0) if candidate.x < OWN else (5.0, 5.0)
    return End(by_check if candidate.is_full else by_search, 3e-3 if candidate.x < OWN - 1e-6 else 1e-3)


def test_points_are_confirmed_by_the_check_alone(monkeypatch: Patch) -> None:
    """The fastest of the search is dominated in the check, and not told; the gain compares checks with checks."""
    result = ask_known(monkeypatch, slower_by_check, model="slow", objectives=["settling-time", "peak"])
    s, lines = result.wucht.summary, told(result)
    assert result.front_objective.values[:, 0].tolist() == [1.0, 5.0]
    assert [p["checked"]["settling-time"] for p in s["front"]] == result.front_checked.values[:, 0].tolist() == [40.0, 5.0]
    assert [p["holds"] for p in s["front"]] == [False, True] and result.front_holds.values.tolist() == [0, 1]
    assert [p["bodies"] for p in s["front"]] == result.front_bodies.values.tolist() == [2, 2]
    assert (s["candidates"], s["found"], s["front"][1]["checked_undecided"]) == (4, 2, 0.0)
    assert lines["min settling"].endswith("N·m·s: median settling time 5 s, peak 1 mm (time -75 %)") and "min peak" not in lines
    assert s["sentence"].endswith("; a front of 2 points from 4 candidates; 1 of 2 checked points are confirmed")
    assert s["recommended"]["point"] == 1
    assert lines["compared"].endswith("from the same starts the machine as it is 20 s, neighbours 5 s, others 40 s")
    assert "; with 99 % less damping the settling time is 40 s; " in s["sentence"]


def test_what_lacks_an_objective_in_the_check_is_not_the_best(monkeypatch: Patch) -> None:
    """The fastest one has no stable state: it is not confirmed, and not told."""
    asked: dict[str, Any] = {"model": "slow", "objectives": ["settling-time", "residual", "peak"]}
    fastest = {"stands": lambda machine: None if machine.values["p1.damping"] < 4e-5 else 0.0}
    result = ask_known(monkeypatch, lambda of: End(1.0, 3e-3) if of.x < OWN - 1e-6 else End(5.0), **fastest, **asked)
    assert result.front_checked.values[:2, 0].tolist() == [1.0, 5.0] and result.front_holds.values[:2].tolist() == [0, 1]
    assert "median settling time 5 s, 0 kg·m residual unbalance" in told(result)["min settling"]


def test_what_is_not_checked_yet_is_neither_confirmed_nor_refuted(monkeypatch: Patch, tmp_path: Path) -> None:
    """Stopped while the second point is checked."""
    asked = {"model": "slow", "objectives": ["settling-time", "peak"], "folder": tmp_path}
    result = ask_known(monkeypatch, slower_by_check, progress=stop_at(4, "check with the full equations"), **asked)
    s = result.wucht.summary
    assert [p["holds"] for p in s["front"]] == [True, None] and result.front_holds.values.tolist() == [1, 0]
    assert s["front"][1]["checked"] is None and s["front"][1]["checked_undecided"] is None
    assert np.isnan(result.front_checked.values[1]).all() and np.isnan(result.front_checked_outcome.values[1]).all()
    assert s["sentence"] == "a front of 2 points from 4 candidates; 1 of 1 checked points are confirmed"
    assert (s["recommended"], s["compared"], s["duel"]) == (None, [], None), "not before the comparison"
    assert "median settling time 5 s" in told(result)["min settling"], "by the search, as long as there is no check"


def test_equal_candidates_count_once_and_a_front_is_thinned_evenly(monkeypatch: Patch) -> None:
    """Of four steps the last one is dominated, and points without an objective are none."""
    steps = [End(3.0, 1e-3), End(2.0, 2e-3), End(1.0, 3e-3), End(3.5, 3.5e-3)]

    def ends(candidate: Candidate) -> End:
        return steps[min(int(candidate.x + 1), 3)]

    asked = {"objectives": ["settling-time", "peak"], "population": 16, "evaluations": 16}
    whole = ask_known(monkeypatch, ends, **asked, points=5)
    assert whole.wucht.summary["found"] == 3
    assert whole.front_objective.values[:3, 0].tolist() == [1.0, 2.0, 3.0]
    for time, value in zip((1.0, 2.0, 3.0), whole.front_value.values[:, 0].tolist(), strict=False):
        equal = whole.tried_objective.values[:, 0] == time
        assert value == whole.tried_value.values[equal, 0][0], "the first of those that are equal"
    spread = "points, spread over the front, represent its 3"
    assert not any(spread in w for w in whole.wucht.warnings)
    two = ask_known(monkeypatch, ends, **asked, points=2)
    assert two.front_objective.values[:2, 0].tolist() == [1.0, 3.0] and two.wucht.summary["found"] == 3


def test_a_search_without_a_front_says_so_once_it_is_finished(monkeypatch: Patch, tmp_path: Path) -> None:
    """Eight candidates in all, which are all captured: four are half of them."""
    none, asked = "no candidate has all objectives", {"evaluations": 8, "folder": tmp_path}
    begun = ask_known(monkeypatch, lambda _: CAUGHT, progress=stop_at(1, "2 bodies, generation 1"), **asked)
    assert (begun.wucht.sentence, begun.wucht.summary["damping"]) == ("there is no front yet", None)
    half = ask_known(monkeypatch, lambda _: CAUGHT, progress=stop_at(1, "2 bodies, generation 2"), **asked)
    assert half.wucht.sentence == none and not any(w.startswith(none) for w in half.wucht.warnings)
    whole = ask_known(monkeypatch, lambda _: CAUGHT, evaluations=8)
    assert whole.wucht.sentence == none and any(w.startswith(none) for w in whole.wucht.warnings)
    assert whole.wucht.summary["front"] == [] and draw(whole)
    assert told(whole)["as it is"].endswith("100 % captured, does not balance")
    unknown = ask_known(monkeypatch, lambda _: CAUGHT, objectives=["settling-time"])
    assert told(unknown)["as it is"].endswith("N·m·s: no objective is known, does not balance")


@pytest.mark.parametrize(("time", "gain"), [(10.049, "10 s"), (10.051, "10.1 s (time +1 %)")])
def test_gains_below_half_a_percent_are_none(time: float, gain: str, monkeypatch: Patch) -> None:
    result = ask_known(monkeypatch, lambda of: End(10.0 if is_own(of) else time), objectives=["settling-time"], **ABOVE)
    assert told(result)["min settling"].endswith(f"median settling time {gain}")


def test_new_unbalance_is_told_where_it_is_an_objective(monkeypatch: Patch) -> None:
    """Two bodies of 20 g leave some of an unbalance that those of 125 g take up."""
    result = ask_known(monkeypatch, lambda _: End(10.0), objectives=["residual"], **BY_MASS)
    left = result.wucht.summary["front"][0]["checked"]["residual"]
    assert 0 < left < UNBALANCE
    assert told(result)["min residual"].endswith(
        f"{left:.3g} kg·m residual unbalance (residual unbalance where there was none)"
    )
    heavy = ask_known(monkeypatch, lambda _: End(10.0), objectives=["residual"], unbalance=[0.03, 0.031], **BY_MASS)
    assert "(residual unbalance +" in told(heavy)["min residual"] and "none)" not in told(heavy)["min residual"]
    other = ask_known(monkeypatch, lambda _: End(10.0), objectives=["settling-time"], **BY_MASS)
    assert "none)" not in told(other)["min settling"]


def test_what_does_not_balance_is_not_offered_first(monkeypatch: Patch) -> None:
    """However fast it gets through; and if nothing else is there, it says so."""

    def ends(candidate: Candidate) -> End:
        return End(5.0, 2e-3, Outcome.PASSED) if candidate.x < OWN - 1e-6 else End(9.0, 1e-3)

    asked = {"objectives": ["settling-time", "peak"]}
    both = ask_known(monkeypatch, ends, **asked)
    assert [p["balances"] for p in both.wucht.summary["front"][:2]] == [False, True]
    assert "median settling time 9 s" in told(both)["min settling"] and "min peak" not in told(both)
    alone = ask_known(monkeypatch, lambda _: End(5.0, 2e-3, Outcome.PASSED), **asked)
    assert told(alone)["min settling"].endswith("settling time 5 s, peak 2 mm, does not balance")


# --- doubts ---


@pytest.mark.parametrize("is_told", [False, True])
@pytest.mark.parametrize(
    ("objective", "within", "beyond"),
    [("settling-time", 12.28, 12.30), ("peak", 1.19e-3, 1.21e-3), ("capture-probability", 19 / 32, 20 / 32)],
)
def test_chance_explains_some_of_the_difference_between_two_draws_of_phases(
    objective: str, within: float, beyond: float, is_told: bool, monkeypatch: Patch
) -> None:
    """A tenth of the time and 2.6 standard errors, a fifth of the peak; of a share, one run and 2.6 standard deviations of the
    difference of a share of 8 and one of 32. Half of the runs take a second longer than 10 s, half a second less."""
    seen = beyond if is_told else within

    def ends(candidate: Candidate) -> Any:
        time, peak, captured = 10.0, 1e-3, 0.0
        if candidate.is_full:
            time = seen if objective == "settling-time" else time
            peak = seen if objective == "peak" else peak
            captured = seen if objective == "capture-probability" else captured
        if captured:
            return [(captured, CAUGHT), (1 - captured, End(time, peak))]
        return [(0.5, End(time - 1, peak)), (0.5, End(time + 1, peak))]

    result = ask_known(monkeypatch, ends, model="slow", objectives=[objective], points=1)
    assert bool(another(result)) is is_told
    assert all(f"another {objective} at 1 of 1 points: at point 1 " in warning for warning in another(result))


@pytest.mark.parametrize(("share", "is_told"), [(0.0099, False), (0.0101, True)])
def test_a_hundredth_of_the_greatest_unbalance_is_no_deviation(share: float, is_told: bool, monkeypatch: Patch) -> None:
    asked: dict[str, Any] = {"objectives": ["residual"], "unbalance": [2e-3, 8e-3]}
    result = ask_known(monkeypatch, lambda _: End(10.0), stands=lambda machine: least_residual(machine) + share * 8e-3, **asked)
    assert bool(another(result)) is is_told


def test_deviations_name_the_worst_point_and_both_of_its_values(monkeypatch: Patch) -> None:
    """Peaks of 2 mm and 1 mm become 2.5 mm (1.25 tolerances) and 1.5 mm (2.5 tolerances)."""

    def ends(candidate: Candidate) -> End:
        time, peak = (1.0, 2e-3) if candidate.x < OWN else (2.0, 1e-3)
        return End(time, peak + 5e-4 if candidate.is_full else peak)

    asked: dict[str, Any] = {"model": "slow", "objectives": ["settling-time", "peak"], "vary": {"damping": [1e-6, 4e-5]}}
    (warning,) = another(ask_known(monkeypatch, ends, **asked | {"vary": {"damping": RANGE}}))
    assert warning.endswith("another peak at 2 of 2 points: at point 2 0.001 m by the search, 0.0015 m by the check")
    none = ask_known(monkeypatch, lambda of: CAUGHT if of.is_full else End(1.0), **asked | {"objectives": ["settling-time"]})
    assert another(none)[0].endswith("at 1 of 1 points: at point 1 1 s by the search, none by the check")


def test_a_residual_that_cannot_be_checked_is_no_deviation(monkeypatch: Patch) -> None:
    def none(_machine: Machine) -> float:
        raise InputError("machine", None, "no state")

    result = ask_known(monkeypatch, lambda of: End(9.0 if of.is_full else 1.0), stands=none, model="slow")
    assert not another(result) and any(w.endswith("with the full equations: no state") for w in result.wucht.warnings)


def test_a_check_has_the_largest_residual_of_both_ends_of_the_unbalance(monkeypatch: Patch) -> None:
    """None where there is no stable state at one of them."""
    ends = lambda _: End(1.0)  # noqa: E731
    asked: dict[str, Any] = {"unbalance": [2e-3, 8e-3], "objectives": ["settling-time"]}
    eccentricities = ask_known(monkeypatch, ends, stands=lambda of: of.values["drum.eccentricity"], **asked)
    assert eccentricities.own_checked.values[1] == pytest.approx(8e-3 / 9.75)
    one = ask_known(monkeypatch, ends, stands=lambda of: 1.0 if of.values["drum.eccentricity"] < 5e-4 else None, **asked)
    assert np.isnan(one.own_checked.values[1])


def test_runs_without_a_verdict_may_need_more_time_or_a_smaller_tolerance(monkeypatch: Patch) -> None:
    """Of the machine as it is, which is no candidate of these ranges; of two candidates, too."""

    def open_ones(candidate: Candidate) -> Any:
        share = 0.125 if is_own(candidate) else 0.5 if candidate.x > some else 0.0
        return [(share, OPEN), (1 - share, End(10.0))] if share else End(10.0)

    some = np.inf
    result = ask_known(monkeypatch, open_ones, **ABOVE)
    (warning,) = (w for w in result.wucht.warnings if "without a verdict" in w)
    assert warning.startswith("1 candidate has runs without a verdict, up to 12.5 %") and "study.tolerance" in warning
    some = np.sort(x_of(result.tried_value.values[:, 0]))[2] + 1e-9
    limited = ask_known(monkeypatch, open_ones, until=5.0, **ABOVE)
    (warning,) = (w for w in limited.wucht.warnings if "without a verdict" in w)
    assert warning.startswith("2 candidates have runs without a verdict, up to 50 %") and "study.until" in warning
    assert not any("without a verdict" in w for w in ask_known(monkeypatch, lambda _: End(1.0)).wucht.warnings)


# --- the recommended balancer ---


@pytest.mark.parametrize(
    ("ends", "words", "share"),
    [
        (End(40.0), "40 s, 0 % fail", "all end compensated"),
        ([(0.25, CAUGHT), (0.75, End(40.0))], "40 s, 25 % fail", "25 % do not end compensated"),
        (
            [(0.125, CAUGHT), (0.125, OPEN), (0.75, End(20.0))], "at least 20 s, 12.5 % to 25 % fail",
            "12.5 % to 25 % do not end compensated",
        ),
    ],
)  # fmt: skip
def test_the_recommended_balancer_in_words(ends: Any, words: str, share: str, monkeypatch: Patch) -> None:
    result = ask_known(monkeypatch, lambda of: [(0.5, CAUGHT), (0.5, OPEN)] if is_own(of) else ends, **ABOVE)
    assert result.wucht.sentence.startswith(f"2 bodies: median settling time {words}")
    assert told(result)["recommended"].endswith(f"N·m·s: of its runs {share}")


def test_a_standard_error_that_is_not_known_is_left_out(monkeypatch: Patch) -> None:
    """Five of eight runs settle: of some draws of them most do not."""
    result = ask_known(monkeypatch, lambda _: [(0.375, CAUGHT), (0.625, End(9.0))], objectives=["settling-time"], **ABOVE)
    assert result.wucht.summary["recommended"]["error"] is None
    assert told(result)["compared"].startswith("settling time 9 s in 32 runs of its own; from the same starts ")


def test_further_runs_decide_between_the_best_one_and_the_machine_as_it_is(monkeypatch: Patch) -> None:
    """Medians of 9.75 s and 10 s, of few runs: the machine is kept, as that may be chance."""

    def ends(candidate: Candidate) -> Any:
        return [(0.5, End(9.0 if is_own(candidate) else 8.5)), (0.5, End(11.0))]

    result = ask_known(monkeypatch, ends, objectives=["settling-time"])
    duel = result.wucht.summary["duel"]
    assert (duel["runs"], duel["settling_time"], duel["as_it_is"]) == (128, 9.75, 10.0)
    assert duel["difference_error"] == pytest.approx(0.25, rel=0.05)
    assert told(result)["compared"].splitlines()[1] == (
        "in 128 further runs the best one 9.75 s, the machine as it is 10 s, the difference to "
        f"{duel['difference_error']:.2g} s"
    )
    assert told(result)["recommended"].startswith("to keep the machine as it is, 2 bodies, damping 5e-05 N·m·s: ")
    s, keep = result.wucht.summary, "nothing is better beyond chance than the machine as it is, keep it: 2 bodies: median "
    assert (s["recommended"]["point"], s["recommended"]["changes"]) == (None, {}) and "to paste" not in told(result)
    assert s["recommended"]["parameters"] == {"damping": 5e-5} and s["sentence"].startswith(keep)


@pytest.mark.parametrize(("ratio", "is_told"), [(0.81, True), (0.79, False)])
def test_the_motor_may_set_the_settling_time(ratio: float, is_told: bool, monkeypatch: Patch) -> None:
    """Where it takes eight tenths of it without any vibration."""
    needed = motor_time(MACHINE, {})
    result = ask_known(monkeypatch, lambda of: End(9 * needed if is_own(of) else needed / ratio))
    line = f"sets the settling time of {needed / ratio:.3g} s, not the balancer: without vibration it needs {needed:.3g} s"
    assert told(result).get("motor") == (line if is_told else None)


def test_what_to_paste_into_the_file(monkeypatch: Patch) -> None:
    more = {"objectives": ["settling-time"], "bodies": [2, 3]}
    result = ask_known(monkeypatch, lambda of: End(5.0 if of.bodies == 3 else 10.0), **more, evaluations=8)
    damping = f"{result.wucht.summary['recommended']['parameters']['damping']:.4g} N·m·s"
    assert told(result)["to paste"].splitlines() == [
        "# with 3 bodies, each like the first one: p1, p2, p1_2", "[machine.set]",
        *(f'"{body}.damping" = "{damping}"' for body in ("p1", "p2", "p1_2")),
    ]  # fmt: skip
    assert result.tried_bodies.values.tolist() == [2] * 4 + [3] * 4
    assert result.wucht.summary["front"][0]["bodies"] == 3
    same = told(ask_known(monkeypatch, three))["to paste"].splitlines()
    assert same[0] == "[machine.set]" and len(same) == 3


# --- the damping curve ---


@pytest.mark.parametrize(
    ("best", "captured", "of_rates", "line"),
    [
        (0.0, False, np.nan, "1e-05 N·m·s settles fastest from random phases"),
        (
            0.0, True, 2e-3, "1e-05 N·m·s settles fastest from random phases, of those with the fewest captured runs; small "
            "deviations decay fastest with 0.002 N·m·s",
        ),
        (-1.0, False, np.nan, "1e-06 N·m·s settles fastest from random phases, the lowest of the curve"),
        (3.0, False, np.nan, "0.01 N·m·s settles fastest from random phases, the highest of the curve"),
    ],
)  # fmt: skip
def test_the_best_damping(best: float, captured: bool, of_rates: float, line: str, monkeypatch: Patch) -> None:
    def ends(candidate: Candidate) -> Any:
        through = End(2 + (candidate.x - best) ** 2)
        return [(0.25, CAUGHT), (0.75, through)] if captured and candidate.x > 2.5 else through

    def rates(dampings: np.ndarray) -> tuple[np.ndarray, float]:
        return (2 * dampings, of_rates)

    result = ask_known(monkeypatch, ends, rates=rates, damping_curve=True)
    dampings = result.damping.values
    assert told(result)["damping"] == f"of the machine as it is, {line}"
    assert result.wucht.summary["damping"] == {
        "optimum": pytest.approx(10 ** (best - 5)), "of_rates": None if np.isnan(of_rates) else of_rates,
        "as_many": not captured, "range": pytest.approx(RANGE), "unit": "N m s",
    }  # fmt: skip
    assert result.settling_time.values == pytest.approx(2 + (x_of(dampings) - best) ** 2)
    assert np.unique(result.through.values).tolist() == ([0.75, 1.0] if captured else [1.0])
    assert result.decay_rate.values == pytest.approx(2 * dampings)
    units = [result[name].attrs["units"] for name in ("damping", "settling_time", "through", "decay_rate")]
    assert units == ["N m s", "s", "", "1/s"]


def test_a_curve_without_an_optimum_has_no_line(monkeypatch: Patch) -> None:
    result = ask_known(monkeypatch, lambda _: CAUGHT, damping_curve=True)
    assert result.wucht.summary["damping"]["optimum"] is None and "damping" not in told(result)


@pytest.mark.parametrize(
    ("vary", "low", "high"),
    [
        ({"mass": [0.1, 0.2]}, 8e-5 * 10**-1.5, 8e-5 * 10**1.5),
        ({"damping": {"of": ["p1"], "range": [2e-5, 8e-5]}}, 8e-5 * 10**-1.5, 8e-5 * 10**1.5),
        ({"damping": [2e-5, 8e-5]}, 2e-5, 8e-5),
        ({"damping": [0.0, 8e-5]}, 8e-8, 8e-5),
    ],
)
def test_dampings_of_the_curve(vary: dict[str, Any], low: float, high: float, monkeypatch: Patch) -> None:
    """A decade and a half on either side of the largest of the machine, or over the range in which all of them are varied."""
    machine = MACHINE.with_values({"p2.damping": 8e-5})
    dampings = ask_known(monkeypatch, lambda _: End(1.0), machine, vary=vary, damping_curve=True).damping.values
    assert (dampings[0], dampings[-1], len(dampings)) == (pytest.approx(low), pytest.approx(high), 25)
    assert np.diff(np.log(dampings)) == pytest.approx(np.log(high / low) / 24)


def test_bodies_without_damping_have_no_curve(monkeypatch: Patch) -> None:
    undamped = MACHINE.with_values({"p1.damping": 0.0, "p2.damping": 0.0})
    none = "there is no damping curve: some balancing body has no damping that could be varied"
    masses, dampings = {"mass": [0.1, 0.2]}, {"damping": RANGE}
    for machine, vary, asked, is_told in (
        (undamped, masses, True, True), (undamped, masses, False, False), (MACHINE, masses, True, False),
        (undamped, dampings, True, False),
    ):  # fmt: skip
        result = ask_known(monkeypatch, lambda _: End(1.0), machine, vary=vary, damping_curve=asked)
        assert (none in result.wucht.warnings) is is_told and ("damping" in result.coords) is (asked and not is_told)


# --- what is varied ---


def test_bodies_keep_their_inertia_unless_it_is_declined(monkeypatch: Patch) -> None:
    for inertia in (None, True, False):
        engine = KnownRuns(three)
        ask_known(monkeypatch, engine, model="slow", **({} if inertia is None else {"inertia": inertia}))
        assert {question.inertia for question in engine.questions if question.model == "slow"} == {inertia is not False}


def test_the_mass_of_a_rotor_with_an_eccentricity_is_not_varied(monkeypatch: Patch) -> None:
    """Its unbalance is their product."""
    with refused("study.vary", given="drum.mass"):
        ask_known(monkeypatch, three, vary={"drum.mass": [5.0, 10.0]})


@pytest.mark.parametrize(
    ("dampings", "is_first"), [(RANGE, True), ([6e-5, 1e-2], False), ([1e-6, 4e-5], False), ([5e-5, 1e-2], True)]
)
def test_the_machine_as_it_is_comes_first_if_all_that_is_varied_lies_in_its_range(
    dampings: list[float], is_first: bool, monkeypatch: Patch
) -> None:
    result = ask_known(monkeypatch, three, vary={"mass": [0.1, 0.2], "damping": dampings})
    mass, damping = result.tried_value.values[0]
    assert (mass == pytest.approx(0.125)) == (damping == pytest.approx(5e-5)) == is_first
