"""The Dataset of a search whose results are made by hand: what is stated where, and which warnings follow."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import answered, variable, warnings_of
from tests.refusals import refused

from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, CandidateResults
from wucht.dynamics.balancers.damping_optimum import DampingCurve
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.optimise_balancer import balancer_plan as plan_module
from wucht.studies.optimise_balancer import computation, figure
from wucht.studies.optimise_balancer.computation import Baseline, Findings, FrontPoint, FullCheck, Plan, prepare
from wucht.studies.optimise_balancer.dataset import _tolerances, dataset
from wucht.studies.optimise_balancer.spec import OBJECTIVES, OptimiseBalancer

COMPENSATED, OPEN = OUTCOMES.index(Outcome.COMPENSATED), OUTCOMES.index(Outcome.UNIDENTIFIED)


@cache
def machine(*dampings: float) -> Machine:
    drum = {"kind": "rotor", "name": "drum", "mass": 4.0, "inertia": 0.03, "eccentricity": 1e-3}
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1}
    balls = [ball | {"name": f"b{k}", "damping": d} for k, d in enumerate(dampings)]
    carrier = {"mass": 1.0, "stiffness": 1e5, "damping": 200.0}
    drive = {"kind": "linear", "slope": 0.04, "no_load_speed": 500.0}
    return machine_from({"carrier": carrier, "bodies": [drum, *balls], "drive": drive})


def plan(**asked: Any) -> Plan:
    common: dict[str, Any] = {"vary": {"length": [0.05, 0.2], "damping": [0.25, 1.0]}, "samples": 10, "population": 4}
    common["evaluations"] = 8
    return prepare(OptimiseBalancer(**common | {"points": 5, "model": "slow"} | asked), machine(0.5, 0.5))


def results(*rows: tuple[float, float, float, float], undecided: float = 0.0, error: float = 0.0) -> CandidateResults:
    """Objectives of candidates, whose variables are ten times their number and one more."""
    count = len(rows)
    outcomes = np.zeros((count, len(OUTCOMES)))
    outcomes[:, COMPENSATED], outcomes[:, OPEN] = 1 - undecided, undecided
    numbers = np.array([[10.0 * k, 10.0 * k + 1] for k in range(count)])
    return CandidateResults(numbers, np.array(rows), np.full(count, error), outcomes, np.ones(count, bool))


OWN = results((8.0, 0.5, 0.25, 0.0), undecided=0.125)
OWN_CHECK = FullCheck(results((9.0, 7.0, 0.75, 0.5), undecided=0.25), 0.625)
BASELINE = Baseline(OWN, OWN_CHECK)


def checked(*rows: tuple[float, float, float, float], residual: float = 0.0, reason: str = "") -> FullCheck:
    return FullCheck(results(*rows), residual, reason)


def summary(of: Plan, findings: Findings) -> dict[str, Any]:
    return dict(dataset(of, findings).wucht.summary)


def test_the_machine_as_it_is_has_its_values_and_both_evaluations() -> None:
    """What the bodies leave is by the check that of the stable state, not that of the runs."""
    result = dataset(plan(), Findings(BASELINE))
    s = result.wucht.summary
    assert s["as_it_is"] == {
        "bodies": 2, "parameters": {"length": 0.1, "damping": 0.5}, "undecided": 0.125, "checked_undecided": 0.25,
        "objectives": dict(zip(OBJECTIVES, (8.0, 0.5, 0.25, 0.0), strict=True)),
        "checked": dict(zip(OBJECTIVES, (9.0, 0.625, 0.75, 0.5), strict=True)), "balances": True, "fails": 0.25,
    }  # fmt: skip
    assert result.own_objective.values.tolist() == [8.0, 0.5, 0.25, 0.0]
    assert result.own_checked.values.tolist() == [9.0, 0.625, 0.75, 0.5]
    assert s["units"] == {"settling-time": "s", "residual": "kg m", "peak": "m", "capture-probability": ""}
    assert "settling-time in s, residual in kg m, peak in m, capture-probability in 1" in result.own_objective.long_name
    assert (s["sentence"], s["damping"], s["front"]) == ("there is no front yet", None, [])
    assert [(v["range"], v["unit"]) for v in s["variables"].values()] == [([0.05, 0.2], "m"), ([0.25, 1.0], "N m s")]


def test_the_unbalance_is_that_of_the_rotor_or_that_of_the_question() -> None:
    """The rotor has an eccentricity of 1 mm and 4 kg."""
    assert summary(plan(), Findings(BASELINE))["unbalance"] == pytest.approx([4e-3, 4e-3])
    assert summary(plan(unbalance=(2e-3, 6e-3)), Findings(BASELINE))["unbalance"] == pytest.approx([2e-3, 6e-3])
    assert plan(unbalance=(2e-3, 6e-3)).as_it_is.ends == pytest.approx((0.5e-3, 1.5e-3)), "as eccentricities"


def test_the_number_of_runs_counts_the_machine_twice_and_each_candidate_and_point_once() -> None:
    of = plan()
    assert (of.generations, len(of.curve[1]) if of.curve else 0) == (2, 25)
    assert of.runs == 10 * (1 + 25 + 8 + 4 * 6), "a check has four times as many"
    assert replace(of, curve=None).runs == 10 * (1 + 8 + 4 * 6)
    assert replace(of, spec=of.spec.model_copy(update={"points": 50})).runs == 10 * (1 + 25 + 8 + 4 * 9), (
        "no more than there are"
    )


def test_the_progress_counts_units_of_work() -> None:
    """6 candidates of 10 runs are a unit: 2 units for the machine as it is, 5 for the curve, 1 a generation, 5 points."""
    of = plan()
    before = 0.7  # the rest is the comparison from which the recommendation follows
    assert computation._shares(of) == pytest.approx(before * np.array([2, 7, 9]) / 14)
    assert computation._shares(replace(of, curve=None)) == pytest.approx(before * np.array([2, 2, 4]) / 9)
    assert computation._shares(replace(of, generations=100)) == pytest.approx(before * np.array([2, 7, 107]) / 112), "long"


def front() -> tuple[FrontPoint, ...]:
    """The second is dominated by the first in the check, the third is not yet checked."""
    rows = (1.0, 0.4, 0.1, 0.0), (2.0, 0.3, 0.2, 0.0), (3.0, 0.2, 0.3, 0.1)
    checks = (checked((1.0, 9.0, 0.1, 0.0), residual=0.1), checked((2.0, 9.0, 0.2, 0.0), residual=0.3), None)
    return tuple(FrontPoint(2 + k, results(row), check) for k, (row, check) in enumerate(zip(rows, checks, strict=True)))


def test_points_are_confirmed_by_the_check_alone() -> None:
    tried = ((2, results((1.0, 0.4, 0.1, 0.0), (5.0, 0.5, 0.5, 0.0))), (3, results((2.0, 0.3, 0.2, 0.0))))
    result = dataset(plan(), Findings(BASELINE, None, tried, front(), 7))
    s = result.wucht.summary
    assert [p["holds"] for p in s["front"]] == [True, False, None]
    assert [p["bodies"] for p in s["front"]] == result.front_bodies.values.tolist() == [2, 3, 4]
    assert [p["checked"] and p["checked"]["residual"] for p in s["front"]] == [0.1, 0.3, None]
    assert [p["checked_undecided"] for p in s["front"]] == [0.0, 0.0, None]
    assert s["front"][0]["parameters"] == {"length": 0.0, "damping": 1.0}
    assert result.front_holds.values.tolist() == [1, 0, 0]
    assert np.isnan(result.front_checked.values[2]).all() and np.isnan(result.front_checked_outcome.values[2]).all()
    assert result.front_objective.values[:, SETTLING].tolist() == [1.0, 2.0, 3.0]
    assert (s["candidates"], s["found"]) == (3, 7)
    assert result.tried_bodies.values.tolist() == [2, 2, 3]
    assert result.tried_value.values.tolist() == [[0.0, 1.0], [10.0, 11.0], [0.0, 1.0]]
    assert s["sentence"] == "a front of 7 points from 3 candidates; 1 of 2 checked points are confirmed"
    assert (s["recommended"], s["compared"]) == (None, []), "not before its comparison"
    assert any(w.startswith("3 points, spread over the front, represent its 7") for w in warnings_of(result))
    whole = dataset(plan(), Findings(BASELINE, None, tried, front(), 3))
    assert not any("spread over the front" in w for w in warnings_of(whole))


def test_a_search_without_a_front_says_so_once_it_is_finished() -> None:
    """Eight candidates in all: four are half of them."""
    half = ((2, results(*[(np.nan,) * 4] * 4)),)
    none = "no candidate has all objectives"
    unfinished = dataset(plan(), Findings(BASELINE, None, half))
    assert unfinished.wucht.summary["sentence"] == none
    assert not any(w.startswith(none) for w in warnings_of(unfinished))
    assert any(w.startswith(none) for w in warnings_of(dataset(plan(), Findings(BASELINE, None, half * 2))))
    assert not any(w.startswith(none) for w in warnings_of(dataset(plan(), Findings(BASELINE))))


def test_chance_explains_some_of_the_difference_between_two_draws_of_phases() -> None:
    """A tenth of the time and 2.6 standard errors, a hundredth of the unbalance, a fifth of the peak; of a share, one run and
    2.6 standard deviations of the difference of a share of ten and one of forty."""
    of = plan(unbalance=(2e-3, 6e-3))
    search, check = results((10.0, 0.0, 2.0, 0.3), error=0.3), results((99.0, 0.0, 99.0, 0.1), error=0.4)
    tolerances = _tolerances(of, search, check)
    assert tolerances[SETTLING] == pytest.approx(1.0 + 2.6 * 0.5)
    assert tolerances[RESIDUAL] == pytest.approx(6e-5)
    assert tolerances[PEAK] == pytest.approx(0.4)
    assert tolerances[CAPTURE] == pytest.approx(0.1 + 2.6 * np.sqrt(1.25 * 0.2 * 0.8 / 10))


def test_deviations_name_the_worst_point_and_both_of_its_values() -> None:
    """Peaks of 1 m and 2 m become 1.5 m (2.5 tolerances) and 2.5 m (1.25 tolerances); a third is as expected."""
    rows = [(1.0, 0.0, 2.0, 0.0), (1.0, 0.0, 1.0, 0.0), (1.0, 0.0, 4.0, 0.0)]
    checks = [(1.0, 0.0, 2.5, 0.0), (1.0, 0.0, 1.5, 0.0), (1.0, 0.0, 4.0, 0.0)]
    points = tuple(FrontPoint(2, results(a), checked(b)) for a, b in zip(rows, checks, strict=True))
    (warning,) = (w for w in warnings_of(dataset(plan(), Findings(BASELINE, None, (), points, 3))) if "another" in w)
    assert "another peak at 2 of 3 points: at point 2 1 m by the search, 1.5 m by the check" in warning
    none = FrontPoint(2, results((1.0, 0.0, 1.0, 0.0)), checked((1.0, 0.0, np.nan, 0.0)))
    (warning,) = (w for w in warnings_of(dataset(plan(), Findings(BASELINE, None, (), (none,), 1))) if "another" in w)
    assert "at 1 of 1 points: at point 1 1 m by the search, none by the check" in warning
    unchecked = FrontPoint(2, results((1.0, 0.0, 1.0, 0.0)), checked((1.0, 0.0, 9.0, 0.0), residual=np.nan, reason="no state"))
    told = warnings_of(dataset(plan(), Findings(BASELINE, None, (), (unchecked,), 1)))
    assert not any("another" in w for w in told) and any(w.endswith("the full equations: no state") for w in told)


def test_runs_without_a_verdict_may_need_more_time_or_a_smaller_tolerance() -> None:
    (told,) = (w for w in warnings_of(dataset(plan(), Findings(BASELINE))) if "without a verdict" in w)
    assert told.startswith("1 candidate has runs without a verdict, up to 12.5 %") and "study.tolerance" in told
    limited = dataset(plan(until=5.0), Findings(BASELINE, None, ((2, results((1.0, 0.0, 0.0, 0.0), undecided=0.5)),)))
    (told,) = (w for w in warnings_of(limited) if "without a verdict" in w)
    assert told.startswith("2 candidates have runs without a verdict, up to 50 %") and "study.until" in told
    some = Findings(BASELINE, None, ((2, results((1.0, 0.0, 0.0, 0.0))),))
    assert any(w.startswith("1 candidate has") for w in warnings_of(dataset(plan(), some)))
    decided = Findings(Baseline(results((8.0, 0.5, 0.25, 0.0)), OWN_CHECK))
    assert not any("without a verdict" in w for w in warnings_of(dataset(plan(), decided)))


def test_the_curve_of_the_damping_with_its_ends_and_best_values() -> None:
    dampings = np.array([0.25, 0.5, 1.0])
    curve = DampingCurve(dampings, np.array([3.0, 1.0, 2.0]), np.array([0.5, 1.0, 1.0]), np.array([4.0, 6.0, 5.0]), 0.5, np.nan)
    result = dataset(plan(), Findings(BASELINE, curve))
    assert result.wucht.summary["damping"] == {
        "optimum": 0.5, "of_rates": None, "as_many": False, "range": [0.25, 1.0], "unit": "N m s",
    }  # fmt: skip
    assert result.settling_time.values.tolist() == [3.0, 1.0, 2.0] and result.settling_time.attrs["units"] == "s"
    assert result.through.values.tolist() == [0.5, 1.0, 1.0] and result.through.attrs["units"] == ""
    assert result.decay_rate.values.tolist() == [4.0, 6.0, 5.0] and result.decay_rate.attrs["units"] == "1/s"
    alike = summary(plan(), Findings(BASELINE, replace(curve, share_through=np.full(3, 0.5), rate_optimum=1.0)))["damping"]
    assert (alike["as_many"], alike["of_rates"]) == (True, 1.0)


# --- plan ---


def test_either_end_of_a_range_may_be_what_the_parts_do_not_allow() -> None:
    for low, high, bad in ((-1.0, 2.0, -1.0), (1.0, -2.0, -2.0)):
        trials = replace(plan().as_it_is, variables=(replace(plan().variables[1], low=low, high=high),))
        with refused("study.vary.damping", given=bad):
            plan_module._check_ends(trials)


def test_bodies_keep_their_inertia_unless_it_is_declined() -> None:
    assert plan().as_it_is.inertia
    assert not plan(inertia=False).as_it_is.inertia


def test_a_range_of_the_damping_of_one_body_is_not_that_of_the_curve() -> None:
    curve = plan(vary={"b0.damping": [0.2, 0.8]}).curve
    assert curve is not None
    assert curve[0].variables[0].paths == ("b0.damping", "b1.damping")
    assert (curve[1][0], curve[1][-1]) == (pytest.approx(0.5 * 10**-1.5), pytest.approx(0.5 * 10**1.5))


def test_a_check_without_a_stable_state_at_one_end_has_no_residual(monkeypatch: pytest.MonkeyPatch) -> None:
    trials = plan(unbalance=(2e-3, 6e-3)).as_it_is
    states = [SimpleNamespace(residual=1.0), None]
    phases: list[tuple[int, int]] = []

    def evaluate(of: Any, *_: Any) -> tuple[None, None]:
        phases.append((of.stream, of.settings.samples))
        return None, None

    monkeypatch.setattr(computation, "evaluate_runs", evaluate)
    monkeypatch.setattr(computation, "compensated_state", lambda _machine, full: states.pop(0) if full else None)
    assert np.isnan(computation.verify_candidate(trials, np.array([0.1, 0.5]), lambda _share: None).residual)
    assert (states, phases) == ([], [(1, 40)]), "four times as many runs, from other phases"


def test_a_front_is_in_order_of_its_objectives_and_counts_all_its_points() -> None:
    """Equal candidates count once, those that are dominated or lack an objective not at all."""
    of = plan(objectives=("settling-time", "residual"), points=2)
    tried = (
        (2, results((3.0, 1.0, 0.0, 0.0), (2.0, 2.0, 0.0, 0.0), (3.0, 3.0, 0.0, 0.0))),
        (3, results((2.0, 2.0, 9.0, 0.0), (1.0, 3.0, np.nan, 0.0), (0.5, np.nan, 0.0, 0.0))),
    )
    points, size = computation.front_of(of, Findings(BASELINE, None, tried))
    assert size == 3
    assert [(p.bodies, *p.evaluation.objectives[0, :2]) for p in points] == [(3, 1.0, 3.0), (2, 3.0, 1.0)]
    assert points[0].numbers.tolist() == [10.0, 11.0]
    every, _ = computation.front_of(plan(objectives=("settling-time", "residual")), Findings(BASELINE, None, tried))
    assert [(p.bodies, p.numbers[0]) for p in every] == [(3, 10.0), (2, 10.0), (2, 0.0)], "the first of those that are equal"


# --- figure ---


def test_limits_leave_room_on_both_sides_and_twice_as_much_above() -> None:
    assert figure._limits(np.array([1.0, np.nan]), np.array([3.0])) == pytest.approx((0.84, 3.32))
    assert figure._limits(np.array([-2.0, -2.0])) == pytest.approx((-2.2, -1.6))
    assert figure._limits(np.zeros(2)) == (-1.0, 2.0)
    assert figure._limits(np.array([np.nan])) == (None, None)


def drawable() -> xr.Dataset:
    """One point of two bodies, whose check has the peak and the residual the other way round; captured once in ten runs."""
    axes = "point objective"
    return xr.Dataset(
        {
            "front_objective": variable(axes, [[1.0, 0.02, 3e-3, 0.5]], ""),
            "front_checked": variable(axes, [[1.0, 0.04, 6e-3, 0.25]], ""),
            "own_objective": variable("objective", [1.0, 0.08, 9e-3, 0.5], ""),
            "own_checked": variable("objective", [1.0, 0.07, np.nan, 0.75], ""),
            "tried_objective": variable("candidate objective", [[1.0, 0.09, 1e-3, 0.5], [1.0, 0.05, 2e-3, 0.5]], ""),
            "front_bodies": variable("point", [2], ""),
            "front_undecided": variable("point", [0.25], ""),
            "front_checked_undecided": variable("point", [0.125], ""),
        },
        {"objective": list(OBJECTIVES)},
        {"title": "A machine"},
    )


def drawn(objectives: list[str], result: xr.Dataset) -> Figure:
    units = {"settling-time": "s", "residual": "kg m", "peak": "m", "capture-probability": ""}
    s = {
        "sentence": "", "objectives": objectives, "units": units, "numbers_of_bodies": [2], "damping": None,
        "as_it_is": {"checked_undecided": 0.5, "undecided": 0.375},
    }  # fmt: skip
    return figure.figure(answered(result, s, dimensionless=True).assign_attrs(title="A machine"))


def test_objectives_that_do_not_vary_have_no_panel() -> None:
    fig = drawn(["settling-time", "residual", "peak"], drawable())
    (axis,) = (a for a in fig.axes if a.lines)
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("residual unbalance (g·mm)", "peak amplitude (mm)")
    lines = {str(line.get_label()): np.c_[line.get_data()] for line in axis.lines}
    assert lines["candidates"] == pytest.approx(np.array([[9e4, 1.0], [5e4, 2.0]]))
    assert lines["front, 2 bodies: by the search"] == pytest.approx(np.array([[2e4, 3.0]]))
    assert lines["front, 2 bodies: checked"] == pytest.approx(np.array([[4e4, 6.0]]))
    assert lines["machine as it is"] == pytest.approx(np.array([[8e4, 9.0]])), "the check has no peak"
    assert np.c_[axis.lines[1].get_data()] == pytest.approx(np.array([[2e4, 3.0], [4e4, 6.0]])), "from the search to the check"
    assert axis.get_xlim() == pytest.approx((2e4 - 0.08 * 6e4, 8e4 + 0.16 * 6e4))
    assert axis.get_ylim() == pytest.approx((3 - 0.08 * 6, 9 + 0.16 * 6))


@pytest.mark.parametrize("capture_first", [True, False])
def test_runs_without_a_verdict_are_a_bar_along_the_capture_probability(capture_first: bool) -> None:
    names = ["capture-probability", "residual"] if capture_first else ["residual", "capture-probability"]
    (axis,) = (a for a in drawn(names, drawable()).axes if a.lines)
    bars = [np.c_[line.get_data()][:, :: 1 if capture_first else -1] for line in axis.lines[-3:]]
    assert bars[0] == pytest.approx(np.array([[25.0, 2e4], [50.0, 2e4]])), "of the search"
    assert bars[1] == pytest.approx(np.array([[12.5, 4e4], [25.0, 4e4]])), "of the check"
    assert bars[2] == pytest.approx(np.array([[25.0, 7e4], [75.0, 7e4]])), "of the machine, whose check is complete here"


def test_values_that_differ_by_rounding_do_not_vary() -> None:
    assert not figure._differs(drawable(), 0)
    assert figure._differs(drawable(), 1)
    other = drawable()
    other.own_checked.values[0] = 1 + 1e-6
    assert figure._differs(other, 0), "the machine as it is counts"
    other.own_checked.values[0] = 1 + 1e-12
    assert not figure._differs(other, 0)


def test_the_curve_shows_where_all_pass_and_when_small_deviations_have_decayed() -> None:
    """To a hundredth, at the rate that is stated; none where there is no decay."""
    result = drawable().assign_coords(damping=("damping", [0.01, 0.1, 1.0], {"units": "N m s"}))
    result["settling_time"] = variable("damping", [2.0, 1.0, 4.0], "", "s")
    result["through"] = variable("damping", [0.5, 1.0, 1.0], "")
    result["decay_rate"] = variable("damping", [2.0, 4.0, -1.0], "", "1/s")
    s = {
        "sentence": "", "objectives": ["residual", "peak"], "numbers_of_bodies": [2],
        "units": {"residual": "kg m", "peak": "m"}, "damping": {"optimum": 0.1, "of_rates": 0.01},
        "as_it_is": {"checked_undecided": 0.5, "undecided": 0.375},
    }  # fmt: skip
    axis = figure.figure(answered(result, s, dimensionless=True).assign_attrs(title="A machine")).axes[1]
    lines = {str(line.get_label()): np.asarray(line.get_xydata(), float) for line in axis.lines}
    assert np.isnan(lines["runs"][0, 1]) and lines["runs"][1:].tolist() == [[0.1, 1.0], [1.0, 4.0]]
    assert lines["more runs captured"].tolist() == [[0.01, 2.0]]
    assert lines["linearised, to 1 %"][:2, 1] == pytest.approx(np.log(100) / np.array([2.0, 4.0]))
    assert np.isnan(lines["linearised, to 1 %"][2, 1])
    assert (lines["best of the runs"][0, 0], lines["best linearised"][0, 0]) == (0.1, 0.01)
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("damping of the bodies (N·m·s)", "median settling time (s)")
    assert axis.get_ylim() == pytest.approx((1 / 1.5, 6.0))
    assert (axis.get_xscale(), axis.get_yscale()) == ("log", "log")
    words = axis.xaxis.get_major_formatter()
    assert [words(x, 0) for x in (0.002, 0.01, 0.5, 20.0)] == ["2·10⁻³", "0.01", "0.5", "20"]
