"""The recommendation of a search: it is chosen by fresh runs, and never worse than what it is compared with."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from known_fronts import END, MACHINE, RANGE, KnownRuns, ask_known, told, x_of

from wucht import draw, report
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome

QUESTION: dict[str, Any] = {
    "vary": {"damping": RANGE}, "objectives": ["settling-time", "capture-probability"], "samples": 16, "population": 8,
    "evaluations": 16, "damping_curve": True,
}  # fmt: skip
SLOW = MACHINE.with_values({"p1.damping": 1e-6, "p2.damping": 1e-6})  # x = -1: 4.25 s
BEST = 0.5  # of x, for which the median settling time is 2 s
ANGLE = MACHINE.row(MACHINE.group(MACHINE.rotor)[1].coordinate.position)  # differs from run to run


def time_of(x: np.ndarray) -> np.ndarray:
    """Median settling time without chance."""
    return np.asarray(2 + (x - BEST) ** 2)


class Chances(KnownRuns):
    """Runs whose settling times are 2 s + (x - 0.5)^2, times a lognormal factor of their start and of x; beyond a cliff none
    ends compensated. With so much chance the best of many candidates is the luckiest one."""

    def __init__(self, cliff: float = np.inf) -> None:
        self.cliff = cliff

    def __call__(self, question: Any, starts: np.ndarray, values: Any, report: Any = None) -> MemberOutcomes:
        count = starts.shape[1]
        x = x_of(values.get("p1.damping", np.full(count, question.machine.values["p1.damping"])))
        luck = np.sin(1e4 * starts[ANGLE] + 50 * x)
        settling = time_of(x) * np.exp(0.8 * luck)
        outcome = np.full(count, OUTCOMES.index(Outcome.COMPENSATED), np.int8)
        outcome[x > self.cliff] = OUTCOMES.index(Outcome.CAPTURED)
        return MemberOutcomes(outcome, settling, np.ones(count), np.full(count, END))


def ask_with(engine: Chances, monkeypatch: pytest.MonkeyPatch, machine: Any = SLOW, **changes: Any) -> xr.Dataset:
    return ask_known(monkeypatch, engine, machine, **QUESTION | changes)


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 11))])
def test_nothing_that_is_shown_with_it_is_better(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the check it is the best of all; without chance it is as good as the best of them, to the error that is stated."""
    result = ask_with(Chances(), monkeypatch, seed=seed)
    s = result.wucht.summary
    recommended, rows = s["recommended"], s["compared"]
    assert {"as it is", "damping curve", "neighbour"} <= {r["what"] for r in rows} | (
        {"damping curve"} if s["damping"]["optimum"] == pytest.approx(recommended["parameters"]["damping"], rel=1e-3) else set()
    )
    assert recommended["settling_time"] == min(r["settling_time"] for r in rows)
    assert all(r["difference"] >= 0 for r in rows) and recommended["runs"] == 64
    true = time_of(x_of(np.array([r["parameters"]["damping"] for r in rows])))
    assert time_of(x_of(np.array(recommended["parameters"]["damping"]))) < true.min() + 2 * recommended["error"]
    assert abs(x_of(np.array(recommended["parameters"]["damping"])) - BEST) < 1.0
    assert result.front_checked.values[recommended["point"], 0] == pytest.approx(recommended["settling_time"])
    assert any("± " in line and "runs of its own" in line for line in report(result))
    draw(result)


def test_the_cliff_is_stated_with_its_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """All runs are captured beyond x = 0.9, 8 times the damping of 10^-5 N m s."""
    s = ask_with(Chances(cliff=0.9), monkeypatch).wucht.summary
    cliff = s["recommended"]["cliff"]
    assert cliff["inside"] <= 10**-4.1 < cliff["value"] and cliff["fails"] == 1.0 and cliff["settling_time"] is None
    best = s["recommended"]["parameters"]["damping"]
    assert cliff["distance"] == pytest.approx(cliff["value"] / best - 1)
    assert f"with {100 * cliff['distance']:.2g} % more damping 100 % fail" in s["sentence"]


def test_a_damping_that_is_not_varied_is_named_where_it_gains_more(monkeypatch: pytest.MonkeyPatch) -> None:
    result = ask_with(Chances(), monkeypatch, vary={"mass": [0.1, 0.2]})
    assert "alone, which is not varied, settles sooner: " in result.attrs["warnings"]
    assert "that damping, which is not varied, " in told(result)["compared"]
    assert [r["parameters"] for r in result.wucht.summary["compared"] if r["what"] == "damping alone"] == [
        {"damping": pytest.approx(result.wucht.summary["damping"]["optimum"])}
    ]
    assert "which is not varied" not in ask_with(Chances(), monkeypatch).attrs["warnings"]
