"""What a search states, found anew from its candidates, its check and its comparison."""

from __future__ import annotations

import sys
import tomllib
from typing import Any

import numpy as np
import pytest
from searches import DAMPINGS, HELD, R1, SEARCHES, SMALL, searched, told
from tests import stated
from tests.refusals import refused

from wucht import OptimiseBalancer, draw, run
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, RESONANCE_PASSED

OBJECTIVES = ["settling-time", "residual", "peak", "capture-probability"]
LONG = ("by mass", "averaged")
NAMES = [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in SEARCHES]


def best_of(rows: np.ndarray) -> np.ndarray:
    """Rows that none of the others dominates: as small in all columns, and smaller in one."""
    return np.array([not any((o <= row).all() and (o < row).any() for o in rows) for row in rows], bool)


@pytest.mark.parametrize("name", NAMES)
def test_all_of_a_search_is_as_stated(name: str) -> None:
    result = searched(name)
    stated.check(f"optimise-balancer-{name.replace(' ', '-')}", result, draw(result))


@pytest.mark.parametrize("name", NAMES)
def test_the_front_has_what_no_candidate_dominates(name: str) -> None:
    """Where capture is no objective, what is captured more often than the machine as it is does not count; as often does."""
    result = searched(name)
    s, tried, own = result.wucht.summary, result.tried_objective.values, result.own_objective.values
    columns = [OBJECTIVES.index(o) for o in s["objectives"]]
    counts = np.isfinite(tried[:, columns]).all(axis=1)
    if 3 not in columns:
        open_ones, own_open = result.tried_undecided.values, s["as_it_is"]["undecided"]
        counts &= (tried[:, 3] <= own[3]) & (tried[:, 3] - open_ones <= own[3] - own_open)
    rows = np.unique(tried[counts][:, columns], axis=0) if counts.any() else np.empty((0, len(columns)))
    best = {tuple(row) for row in rows[best_of(rows)].tolist()}
    assert s["found"] == len(best) and s["candidates"] == len(tried) == 8
    points = [tuple(row) for row in result.front_objective.values[: min(3, len(best)), columns].tolist()]
    assert set(points) <= best and len(set(points)) == min(3, len(best)) and points == sorted(points)


@pytest.mark.parametrize("name", NAMES)
def test_a_point_holds_that_no_other_dominates_by_the_check(name: str) -> None:
    """Four runs by the search, sixteen by the check; probabilities are shares of them, those without a verdict captured."""
    result = searched(name)
    s = result.wucht.summary
    columns = [OBJECTIVES.index(o) for o in s["objectives"]]
    holds = best_of(result.front_checked.values[:, columns])
    assert result.front_holds.values.tolist() == [p["holds"] for p in s["front"]] == holds.tolist()
    assert [list(p["checked"].values()) for p in s["front"]] == result.front_checked.values.tolist()
    names = result.outcome.values.tolist()
    through, open_ones = ([names.index(o) for o in outcomes] for outcomes in (RESONANCE_PASSED, OPEN_OUTCOMES))
    for runs, outcome, objective in ((4, "front_outcome", "front_objective"), (16, "front_checked_outcome", "front_checked")):
        shares = result[outcome].values
        assert np.array_equal(runs * shares, np.round(runs * shares)) and (shares.sum(axis=1) == 1).all()
        assert np.array_equal(result[objective].values[:, 3], 1 - shares[:, through].sum(axis=1))
        assert np.array_equal(result[outcome.replace("outcome", "undecided")].values, shares[:, open_ones].sum(axis=1))


@pytest.mark.parametrize("name", NAMES)
def test_what_is_recommended_is_the_best_of_what_is_shown(name: str) -> None:
    """By runs of its own; the machine as it is, unless another one is better beyond chance."""
    result = searched(name)
    s = result.wucht.summary
    recommended, rows = s["recommended"], s["compared"]
    if recommended is None:
        assert name == "too short" and s["front"] == [] and not s["as_it_is"]["balances"]
        return
    (chosen,) = [row for row in rows if row["parameters"] == recommended["parameters"]]
    beside = [row for row in rows if row["fails"] <= chosen["fails"] and row["what"] != "damping alone"]
    assert recommended["runs"] == 16 and recommended["settling_time"] == chosen["settling_time"]
    assert recommended["fails"] == chosen["fails"] < 0.5
    if recommended["changes"]:
        assert chosen["settling_time"] == min(row["settling_time"] for row in beside)
        point = result.front_checked.values[recommended["point"]]
        assert point[0] == recommended["settling_time"] and point[3] <= recommended["fails"]
        pasted = tomllib.loads(told(result)["to paste"])["machine"]["set"]
        machine = SEARCHES[name][1].with_values({path: float(value.split()[0]) for path, value in pasted.items()})
        for parameter, value in recommended["parameters"].items():
            assert machine.values[f"p1.{parameter}"] == machine.values[f"p2.{parameter}"] == pytest.approx(value, rel=1e-3)
    else:
        assert recommended["parameters"] == s["as_it_is"]["parameters"] and "to paste" not in told(result)
        duel = s["duel"]  # of further runs, where another one came first
        assert (duel is None) == (rows[0]["what"] == "as it is")
        if duel is not None and duel["settling_time"] is not None:
            assert duel["settling_time"] > duel["as_it_is"] - 3 * duel["difference_error"]
    for alone in (row for row in rows if row["what"] == "damping alone"):
        assert alone["parameters"] == {"damping": pytest.approx(s["damping"]["optimum"])}
        assert alone["settling_time"] < recommended["settling_time"]


def test_what_settles_sooner_but_is_captured_more_often_is_not_recommended() -> None:
    result = searched("kept")
    s = result.wucht.summary
    sooner = [row for row in s["compared"] if row["settling_time"] and row["settling_time"] < s["recommended"]["settling_time"]]
    assert sooner and s["recommended"]["point"] is None
    assert s["recommended"]["fails_for_certain"] < s["recommended"]["fails"], "some runs of 6 s have no verdict"
    (warning,) = [w for w in result.wucht.warnings if "without a verdict" in w]
    assert warning.startswith(f"{int((result.tried_undecided.values > 0).sum()) + 1} candidates") and "study.until" in warning


def test_the_damping_curve_has_its_least_settling_time_where_it_is_said() -> None:
    """About where runs that are integrated by hand settle first."""
    result = searched("held")
    dampings, times = result.damping.values, result.settling_time.values
    optimum = result.wucht.summary["damping"]["optimum"]
    assert optimum == dampings[np.nanargmin(times)] and (result.through.values == 1).all()
    assert dampings[[0, -1]] == pytest.approx(DAMPINGS) and np.ptp(np.diff(np.log(dampings))) < 1e-9
    by_hand = HELD.settling_times(dampings[::4], 12.0)
    assert by_hand[np.abs(np.log(dampings[::4] / optimum)).argmin()] < 1.3 * by_hand.min()


@pytest.mark.parametrize(
    ("vary", "curve", "low", "high"),
    [
        ({"mass": [0.05, 0.1]}, 25, 8e-3 * 10**-1.5, 8e-3 * 10**1.5),
        ({"damping": [0.0, 8e-3]}, 25, 8e-6, 8e-3), ({"damping": [2e-3, 8e-3]}, 0, 2e-3, 8e-3),
    ],
)  # fmt: skip
def test_dampings_and_runs_of_a_search(vary: dict[str, Any], curve: int, low: float, high: float) -> None:
    """A decade and a half on either side of the largest of the machine, or over the range in which all of them are varied. A
    check has four times as many runs; there are no more points than candidates."""
    keys: dict[str, Any] = {"samples": 2, "population": 4, "evaluations": 4, "points": 50, "until": 0.05}
    machine = HELD.machine(8e-3).with_values({"p1.damping": 1e-3})
    result = run(OptimiseBalancer(vary=vary, damping_curve=bool(curve), **keys), machine)
    assert result.wucht.summary["runs"] == 2 * (1 + curve + 4 + 4 * (1 + 4))
    assert ("damping" in result.coords) is bool(curve)
    if curve:
        assert result.damping.values[[0, -1]] == pytest.approx([low, high]) and result.sizes["damping"] == curve
    if "mass" in vary:
        assert result.tried_value.values[0].tolist() == [HELD.pendulum_mass], "the machine as it is comes first"


def test_what_is_refused_of_a_machine() -> None:
    still = R1.with_values({"drum.eccentricity": 0.0})
    with refused("drum.eccentricity", "study.unbalance", given=0.0):
        run(OptimiseBalancer(vary={"damping": [1e-3, 1e-2]}), still)
    with refused("study.vary", given="drum.mass"):
        run(OptimiseBalancer(vary={"drum.mass": [5.0, 10.0]}), R1)


def test_bodies_without_damping_have_no_curve() -> None:
    undamped = HELD.machine(1e-3).with_values({"p1.damping": 0.0, "p2.damping": 0.0})
    keys = SMALL | {"until": 0.05, "damping_curve": True}
    result = run(OptimiseBalancer(vary={"mass": [0.05, 0.1]}, **keys), undamped)
    assert "damping" not in result.coords and any("there is no damping curve" in w for w in result.wucht.warnings)


def test_without_pymoo_a_sentence_says_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in [name for name in sys.modules if name.split(".")[0] == "pymoo"] + ["pymoo"]:
        monkeypatch.setitem(sys.modules, module, None)
    with refused("study.kind", "wucht[optimise]", given="optimise-balancer"):
        run(OptimiseBalancer(vary={"damping": [1e-3, 1e-2]}), R1)
