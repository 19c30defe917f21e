"""Probabilities over a parameter: with known borders in the place of the engine, and by the engine against maps of basins."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

from known_basins import MACHINE, engine, phases
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.capture_probability import computation as running
from wucht.studies.capture_probability.computation import prepare
from wucht.studies.capture_probability.spec import CaptureProbability
from wucht.studies.run_up.study import RunUp
from wucht.studies.runner import draw, load, report
from wucht.studies.runner import run as ask
from wucht.studies.study_file import read_study

PSI = {"uniform": [0.0, 2 * math.pi]}
DELTA = {"uniform": [0.0, math.pi]}
Region = Callable[[np.ndarray, np.ndarray], np.ndarray]


def turn_and_u(starts: np.ndarray, machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """psi as a share of a turn, and u, of members."""
    share = phases(starts, machine)[0] / (2 * math.pi)
    return share, np.full(len(share), machine.values["u"])


def rising(share: np.ndarray, u: np.ndarray) -> np.ndarray:
    """With probability (u - 1)/4."""
    return np.asarray(share < (u - 1) / 4)


def asked(monkeypatch: pytest.MonkeyPatch, inside: Region = rising, fail: Region | None = None, **more: Any) -> xr.Dataset:
    monkeypatch.setattr(running, "outcomes_of", engine(inside, fail=fail, read=turn_and_u))
    given = {"along": "u", "range": [1.0, 5.0], "points": 5, "random": {"psi": PSI, "delta": DELTA}, "model": "slow"}
    return ask(CaptureProbability(**given | more), MACHINE)


def test_each_band_holds_the_probability(monkeypatch: pytest.MonkeyPatch) -> None:
    result = asked(monkeypatch)
    assert result.parameter.values.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    true = (result.parameter - 1) / 4
    assert ((result.low <= true) & (true <= result.high)).all()
    assert ((result.low <= result.estimate) & (result.estimate <= result.high)).all()
    assert float((result.high - result.low).max()) < 0.04
    assert not result.not_identified.values.any()
    s = result.wucht.summary
    assert (s["runs"], s["smallest"], s["searched"]) == (5 * 256, None, 0)
    assert s["probability"][2] == {
        "u": 3.0,
        "estimate": float(result.estimate[2]),
        "low": float(result.low[2]),
        "high": float(result.high[2]),
        "not_identified": 0.0,
        "fractions": {"compensated": float(result.estimate[2]), "captured": 1 - float(result.estimate[2])},
    }
    assert "0 to 1.43 % of the starts end as compensated or passed at u = 1, 98.6 to 100 % at u = 5" in report(result)[1]


def test_the_wanted_probability_is_searched_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.6 is reached at u = 3.4: the value found is above that by no more than the band is wide, to 0.001 of the range."""
    result = asked(monkeypatch, probability=0.6)
    s = result.wucht.summary
    assert 3.4 < s["smallest"] < 3.4 + 4 * 0.04
    assert s["searched"] == result.searched.values.sum() == 8
    at = result.parameter.values.tolist()
    assert at == sorted(at)
    k = at.index(s["smallest"])
    assert float(result.low[k]) >= 0.6 > float(result.low[k - 1])
    assert at[k] - at[k - 1] < 4e-3
    sentence = f"with 95 % confidence at least 0.6 of the starts end as compensated or passed from u = {at[k]:.5g} on"
    assert report(result)[1] == f"verdict: {sentence}"
    lines = [text.get_text() for text in draw(result).axes[0].get_legend().get_texts()]  # type: ignore[union-attr]
    assert lines == [
        "95\N{NO-BREAK SPACE}% confidence",
        "estimate",
        "of the search",
        "target: 0.6",
        f"reached at u = {at[k]:.4g}",
    ]


def test_the_same_random_numbers_at_all_values(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that gets through with a smaller u does with a larger one: no estimate falls, however near two values are."""
    result = asked(monkeypatch, points=50, samples=64)
    assert (np.diff(result.estimate) >= 0).all()
    again, other = (asked(monkeypatch, points=50, samples=64, seed=seed).estimate.values for seed in (0, 1))
    assert np.array_equal(result.estimate.values, again)
    assert not np.array_equal(other, again)


@pytest.mark.parametrize(
    ("inside", "smallest", "says"),
    [
        (
            lambda share, u: share < (5 - u) / 4,
            None,
            "no smallest u: with 95 % confidence the share that ends as compensated or",
        ),
        (lambda share, u: share < 0.5 + 0 * u, None, "0.9 is not reached up to u = 5: there with 95 % confidence 4"),
        (lambda share, u: share < 2 + 0 * u, 1.0, "from u = 1 on, the lowest computed value"),
    ],
)
def test_where_there_is_none_it_says_why(
    inside: Region, smallest: float | None, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = asked(monkeypatch, inside, probability=0.9, samples=64)
    s = result.wucht.summary
    assert (s["smallest"], s["searched"]) == (smallest, 0)
    assert says in s["sentence"]
    assert says in report(result)[1]
    draw(result)


def test_runs_without_a_verdict_are_drawn_beyond_those_that_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """At u = 3 half of the runs are counted and a fifth is open: as shares of all runs, from 0.5 to 0.7."""
    result = asked(monkeypatch, fail=lambda share, u: share > 0.8 + 0 * u)
    (band,) = [c for c in draw(result).axes[0].collections if c.get_label() == "no verdict"]
    corners = band.get_paths()[0].vertices
    middle = np.sort(np.unique(corners[corners[:, 0] == 3.0, 1]))
    assert middle == pytest.approx([0.5, 0.7], abs=0.02)


def test_runs_without_a_verdict_are_counted_neither_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fifth of them: the lower bound is as if none of these got through, the upper one as if all did."""
    failing: Region = lambda share, u: share > 0.8 + 0 * u  # noqa: E731
    known, open_ = asked(monkeypatch), asked(monkeypatch, fail=failing)
    middle = known.parameter.values <= 4
    assert np.array_equal(known.low.values[middle], open_.low.values[middle])
    assert open_.not_identified.values == pytest.approx(0.2, abs=0.01)
    more = open_.high.values[middle] - known.high.values[middle]
    assert more == pytest.approx(0.2, abs=0.03)
    assert open_.estimate.values[2] == pytest.approx(0.5 / 0.8, abs=0.02)
    assert open_.estimate.values[-1] == 1.0
    assert float(open_.low[-1]) < 0.81
    warnings = open_.wucht.warnings
    assert any("of the runs (at u = 1) have no verdict: they may count or not, which widens the band" in w for w in warnings)
    assert sum("failed: it is a test" in w for w in warnings) == 3
    assert any(w.endswith("more runs failed") for w in warnings)
    assert "without a verdict" in "\n".join(report(open_))
    legend = draw(open_).axes[0].get_legend()
    assert legend is not None
    assert "no verdict" in [text.get_text() for text in legend.get_texts()]


def test_where_no_run_has_a_verdict_nothing_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    result = asked(monkeypatch, fail=lambda share, u: share < 2 + 0 * u, samples=64, probability=0.5)
    assert np.isnan(result.estimate).all()
    assert (float(result.low[0]), float(result.high[0])) == (0.0, 1.0)
    assert result.wucht.summary["probability"][0]["estimate"] is None
    assert "not known (0 to 100 %)" in "\n".join(report(result))
    draw(result)


def test_what_is_counted_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    through, held = asked(monkeypatch), asked(monkeypatch, outcome="captured")
    assert through.estimate.values == pytest.approx(1 - held.estimate.values)
    assert held.wucht.summary["outcome"] == ["captured"]
    both = asked(monkeypatch, outcome=["captured", "compensated"])
    assert (both.estimate == 1.0).all()


def test_which_quantity_matters(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    """Only psi does."""
    result = asked(monkeypatch, sensitivity=True, at=2.5, sensitivity_samples=128)
    s = result.wucht.summary["sensitivity"]
    assert (s["at"], s["runs"], s["used"]) == (2.5, 128 * 4, [128, 128])
    assert s["indices"]["psi"]["total"] == pytest.approx(1.0, abs=0.15)
    assert s["indices"]["delta"] == {"first_order": 0.0, "first_order_off": 0.0, "total": 0.0, "total_off": 0.0}
    assert result.quantity.values.tolist() == ["psi", "delta"]
    lines = "\n".join(report(result))
    assert "at u = 2.5, share of the variance of the outcome" in lines
    drawn = draw(result)
    assert [t.get_text() for t in drawn.axes[1].get_yticklabels()] == ["$\\psi$", "$\\delta$"]
    nothing = asked(monkeypatch, sensitivity=True, at=5.0, samples=64)
    assert nothing.wucht.summary["sensitivity"]["indices"] is None
    assert any("all runs with a verdict have one outcome" in w for w in nothing.wucht.warnings)
    assert len(draw(nothing).axes) == 1
    assert "no random quantity matters: all runs have the same outcome" in "\n".join(report(nothing))


def test_written_and_read_back(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setattr(running, "outcomes_of", engine(rising, read=turn_and_u))
    question = CaptureProbability(
        along="u", range=[1, 5], points=3, random={"psi": PSI, "delta": DELTA}, model="slow", samples=64, probability=0.5,
        sensitivity=True, at=3.0,
    )  # fmt: skip
    result = ask(question, MACHINE, folder=tmp_path)
    again = load(tmp_path / "result.nc")
    for name in result.variables:
        assert np.array_equal(again[name], result[name]), name
    assert report(again) == report(result)
    draw(again)


def test_each_run_starts_as_a_run_up_would() -> None:
    """With the parameters and starts of its own sample; where the carrier rests follows."""
    random = {
        "p2": {"speed": {"triangular": [0.0, 1.0, 4.0]}},
        "carrier": {"x": {"normal": ["0 mm", "1 mm"]}},
        "drum": {"eccentricity": {"log-normal": ["1 mm", 1.2]}},
    }
    machine = load_machine("drozdetskaya-2020/r1")
    spec = CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=random, start={"p1": 0.3}, samples=64)
    plan = prepare(spec, machine)
    assert [v.name for v in plan.random_quantities] == ["p2.speed", "carrier.x", "drum.eccentricity"]
    states, values = plan.members(0.015, plan.samples)
    assert values.keys() == {"drum.eccentricity"}
    assert np.median(values["drum.eccentricity"]) == pytest.approx(1e-3, rel=0.05)
    question = plan.question(0.015)
    assert question.varied_paths == ("drum.eccentricity",)
    assert question.machine.values["drive.slope"] == 0.015
    for m in (0, 17, 63):
        speed, x, eccentricity = plan.samples[:, m]
        alone = machine.with_values({"drive.slope": 0.015, "drum.eccentricity": eccentricity})
        start = {"p1": 0.3, "p2": {"speed": speed}, "carrier": {"x": x}}
        assert np.array_equal(states[:, m], initial_state(alone, start))
        assert values["drum.eccentricity"][m] == eccentricity


@pytest.mark.slow
def test_random_parameters_end_as_their_run_ups() -> None:
    """The weakest and the strongest of 64 drives, by the study ``run-up``: captured, and not."""
    machine = load_machine("drozdetskaya-2020/r1")
    random = {"drive.slope": {"uniform": [4e-4, 0.04]}, "p1": {"uniform": [0.0, 3.0]}}
    spec = CaptureProbability(along="drum.eccentricity", range=["1 mm", "2 mm"], random=random, model="slow", samples=64)
    plan = prepare(spec, machine)
    chosen = np.argsort(plan.samples[0])[[0, 1, -2, -1]]
    members = running._compute_members(plan, 2e-3, plan.samples[:, chosen], Work())
    outcomes = [str(OUTCOMES[k]) for k in members.outcome]
    assert outcomes == ["captured", "captured", "compensated", "compensated"]
    for (slope, p1), outcome in zip(plan.samples[:, chosen].T, outcomes, strict=True):
        alone = machine.with_values({"drive.slope": slope, "drum.eccentricity": 2e-3})
        assert ask(RunUp(start={"p1": p1}, model="slow"), alone).wucht.summary["outcome"] == outcome


SHARES = {1.0: 0.0396, 2.5: 0.2488, 3.0: 0.6326}  # of the basins of cases.md, on 64 x 64 cells


def of_basins(result: xr.Dataset) -> list[float]:
    """The values of u whose share of the basin is known, each within its band."""
    known = [u for u in result.parameter.values.tolist() if u in SHARES]
    for u in known:
        one = result.sel(parameter=u)
        assert float(one.low) - 0.002 <= SHARES[u] <= float(one.high) + 0.002, u
    return known


@pytest.mark.slow
def test_the_catalogue_file_agrees_with_the_basins_of_figure_5_10() -> None:
    few = {"study.range": [1.0, 2.5], "study.points": 2, "study.probability": 0.9, "study.sensitivity_samples": 64}
    study = read_study("drozdetskaya-2020/how-likely-it-compensates", few)
    result = ask(study.spec, study.subject)
    assert of_basins(result) == [1.0, 2.5]
    assert float((result.high - result.low).max()) < 0.08
    s = result.wucht.summary
    assert "0.9 is not reached up to u = 2.5" in s["sentence"]
    # The border of figure 5.10 runs across all delta: the mean phase decides.
    assert s["sensitivity"]["indices"]["psi"]["total"] > 2 * s["sensitivity"]["indices"]["delta"]["total"]


@pytest.mark.slow
def test_the_catalogue_file_as_it_stands() -> None:
    """1024 runs at each value: the shares of all three basins; beyond u = 3.08, where the modulated motion loses its stability
    by cases.md, nearly all starts compensate."""
    study = read_study("drozdetskaya-2020/how-likely-it-compensates", {"study.samples": 1024})
    result = ask(study.spec, study.subject)
    assert of_basins(result) == [1.0, 2.5, 3.0]
    assert float((result.high - result.low).sel(parameter=[1.0, 2.5, 3.0]).max()) < 0.05
    smallest = result.wucht.summary["smallest"]
    assert 3.0800128 < smallest < 3.0800128 + 0.06
    assert result.low.values[result.parameter.values > 3.2].min() > 0.99
