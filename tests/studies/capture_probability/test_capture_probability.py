"""Probabilities over a parameter: against a border between two steady speeds that is known, and against maps of basins."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from known_borders import DAMPING, MASS, SPEED, STIFFNESS, asked, machine, rail, share_above_border
from wucht import CaptureProbability, draw, report
from wucht import run as ask
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.studies.study_file import read_study

ANGLE = {"drum": {"speed": SPEED["drum"]["speed"], "angle": {"uniform": [0.0, 6.0]}}}
ALL = 100 * 0.025 ** (1 / 64)  # percent: lower bound where all of 64 runs are counted


@cache
def rising() -> xr.Dataset:
    """The share that passes rises with the slope of the motor, from about 0.60 to 0.65 and 0.70."""
    return asked()


@cache
def sensitive() -> xr.Dataset:
    return asked(points=2, random=ANGLE, sensitivity=True, at=0.0065)


def test_each_band_holds_the_probability() -> None:
    result = rising()
    assert result.parameter.values == pytest.approx([0.005, 0.0065, 0.008])
    known = np.array([share_above_border(slope) for slope in result.parameter.values])
    assert known == pytest.approx([0.603, 0.653, 0.705], abs=1e-3)
    assert ((result.low <= known) & (known <= result.high)).all()
    assert result.estimate.values == pytest.approx(known, abs=0.02)
    assert float((result.high - result.low).max()) < 0.15 and not result.not_identified.values.any()
    s = result.wucht.summary
    assert (s["runs"], s["samples"], s["replicates"], s["smallest"], s["wanted"]) == (192, 64, 16, None, None)
    assert (s["searched"], s["values"], s["range"], s["confidence"]) == (0, [3, 3], [0.005, 0.008], 0.95)
    share = float(result.estimate[1])
    assert s["probability"][1] == {
        "drive.slope": float(result.parameter[1]), "estimate": share, "low": float(result.low[1]),
        "high": float(result.high[1]), "not_identified": 0.0, "fractions": {"passed": share, "captured": 1 - share},
    }  # fmt: skip
    assert report(result) and draw(result).axes


def test_the_wanted_probability_is_searched_for() -> None:
    """0.65 is reached at 0.0064: the value found is above that by no more than the band is wide, to 0.001 of the range."""
    result = asked(range=[0.005, 0.02], probability=0.65, samples=256)
    s = result.wucht.summary
    at = result.parameter.values.tolist()
    assert at == sorted(at)
    k = at.index(s["smallest"])
    assert 0.65 < share_above_border(at[k]) < 0.65 + 0.05
    assert float(result.low[k]) >= 0.65 > float(result.low[k - 1])
    assert 0 < at[k] - at[k - 1] <= 1e-3 * 0.015
    assert s["searched"] == result.searched.values.sum() == len(at) - 3 >= 8 and s["values"] == [3, 3]
    assert result.searched.sel(parameter=[0.005, 0.0125, 0.02]).values.tolist() == [0, 0, 0]
    sentence = "with 95 % confidence at least 0.65 of the starts end as compensated or passed from slope"
    assert s["sentence"].startswith(sentence)
    assert report(result) and draw(result).axes


@pytest.mark.slow
def test_the_same_random_numbers_at_all_values() -> None:
    """A run that gets through with a weaker motor does with a stronger one: no estimate falls, however near two values are."""
    result, again, other = (asked(points=8, seed=seed).estimate.values for seed in (0, 0, 1))
    assert (np.diff(result) >= 0).all()
    assert np.array_equal(result, again)
    assert not np.array_equal(other, again)


@pytest.mark.parametrize(
    ("keys", "smallest", "says"),
    [
        (
            {"outcome": "captured", "range": [0.005, 0.02], "probability": 0.2}, None,
            "no smallest slope of the torque-speed curve, drive: with 95 % confidence the share that ends as captured falls",
        ),
        ({"probability": 0.9}, None, "0.9 is not reached up to slope of the torque-speed curve, drive = 0.008 N m s: "),
        ({"probability": 0.5}, 0.005, "0.005 N m s on, the lowest computed value"),
    ],
)  # fmt: skip
def test_where_there_is_none_it_says_why(keys: dict[str, Any], smallest: float | None, says: str) -> None:
    result = asked(**keys)
    s = result.wucht.summary
    assert (s["smallest"], s["searched"]) == (smallest, 0)
    assert says in s["sentence"]
    assert s["sentence"].count(" % ") <= 5
    draw(result)


def test_what_is_counted_is_asked() -> None:
    held, both = asked(outcome="captured"), asked(outcome=["captured", "passed"])
    assert rising().estimate.values == pytest.approx(1 - held.estimate.values)
    assert held.wucht.summary["outcome"] == ["captured"] and "end as captured at" in held.wucht.summary["sentence"]
    assert (both.estimate == 1.0).all()
    assert both.low.values == pytest.approx(ALL / 100)


def test_which_quantity_matters() -> None:
    """Only the speed does; at a strong motor, which gets through from all, nothing."""
    result = sensitive()
    s = result.wucht.summary
    assert (s["sensitivity"]["at"], s["sensitivity"]["runs"], s["sensitivity"]["used"]) == (0.0065, 64 * 4, [64, 64])
    assert s["runs"] == 2 * 64 + 64 * 4
    speed, angle = (s["sensitivity"]["indices"][name] for name in ("drum.speed", "drum.angle"))
    assert speed["total"] == pytest.approx(1.0, abs=0.15) and 0.1 < speed["total_off"] < 0.5
    assert angle == {"first_order": 0.0, "first_order_off": 0.0, "total": 0.0, "total_off": 0.0}
    assert result.quantity.values.tolist() == ["drum.speed", "drum.angle"]
    for name in ("first_order", "first_order_off", "total", "total_off"):
        assert result[name].values.tolist() == [speed[name], 0.0]
    assert report(result) and len(draw(result).axes) == 2
    assert not any("left out of the indices" in w for w in result.wucht.warnings)


def test_where_all_end_alike_nothing_matters() -> None:
    nothing = asked(points=2, random=ANGLE, sensitivity=True, at=0.02)
    assert nothing.wucht.summary["sensitivity"]["indices"] is None
    assert any("all runs with a verdict have one outcome: no random quantity matters" in w for w in nothing.wucht.warnings)
    assert len(draw(nothing).axes) == 1
    assert report(nothing)


def test_samples_that_fill_unevenly_are_warned_of() -> None:
    warning = "samples = 80 is not a power of two: Sobol' points fill the space evenly with 64 or 128"
    assert warning in asked(samples=80, points=2).wucht.warnings
    assert rising().wucht.warnings == []


def test_runs_without_a_verdict_are_counted_neither_way() -> None:
    """A motor so weak that some have not settled when the runs end: the lower bound is as if none of these got through, the
    upper one as if all did."""
    result, longer = asked(until=20.0, range=[0.004, 0.005], points=2), asked(range=[0.004, 0.005], points=2, until=100.0)
    open_ = result.not_identified.values
    assert 0.4 < open_[0] < 0.7 and not longer.not_identified.values.any()
    captured = 1 - longer.estimate.values[0]
    assert result.estimate.values[0] < longer.estimate.values[0] <= result.high.values[0]
    assert result.low.values[0] < 1 - captured - open_[0] + 0.05 and result.high.values[0] > 1 - captured
    (told,) = (w for w in result.wucht.warnings if "no verdict" in w)
    assert told.startswith(
        f"up to {100 * open_.max():.4g} % of the runs (at slope of the torque-speed curve, drive = 0.004 N m s)"
    )
    assert report(result) and draw(result).axes and draw(result.isel(parameter=[0])).axes


def final_speeds(unbalances: np.ndarray, slope: float, end: float) -> np.ndarray:
    """Final speeds (N,) of a rotor with each of some unbalances, run up from rest by its motor, by SciPy."""
    inertia, count = 0.02, len(unbalances)

    def rates(_t: float, s: np.ndarray) -> np.ndarray:
        x, y, u, v, angle, speed = s.reshape(6, count)
        sine, cosine = np.sin(angle), np.cos(angle)
        fx = unbalances * speed**2 * cosine - DAMPING * u - STIFFNESS * x
        fy = unbalances * speed**2 * sine - DAMPING * v - STIFFNESS * y
        torque = slope * (150.0 - speed) + unbalances / MASS * (fx * sine - fy * cosine)
        change = torque / (inertia - unbalances**2 / MASS)
        accelerations = (fx + unbalances * sine * change) / MASS, (fy - unbalances * cosine * change) / MASS
        return np.concatenate([u, v, *accelerations, speed, change])

    run = solve_ivp(rates, (0.0, end), np.zeros(6 * count), "DOP853", t_eval=[end], rtol=1e-8, atol=1e-9)
    return np.asarray(run.y[5 * count :, -1])


UNDECIDED: dict[str, Any] = {
    "range": [1e-4, 0.01], "points": 2, "until": 20.0, "model": "full",
    "random": {"drum.unbalance": {"uniform": [2e-3, 12e-3]}},
}  # fmt: skip


@cache
def undecided() -> xr.Dataset:
    return asked(**UNDECIDED)


@pytest.mark.slow
def test_a_machine_whose_first_value_is_undecided() -> None:
    """Its weak motor still accelerates, a tenth of the way, when the runs end. The other one passes with the small unbalances,
    of those from 2 to 12 g m, which an integration of our own finds."""
    result = undecided()
    s = result.wucht.summary
    first, second = s["probability"]
    unbalances = np.linspace(2e-3, 12e-3, 51)
    assert np.ptp(final_speeds(unbalances, 1e-4, 20.0)) < 1.0, "nowhere near the resonance at 100 rad/s"
    assert (first["estimate"], first["low"], first["high"], first["not_identified"]) == (None, 0.0, 1.0, 1.0)
    assert np.isnan(result.estimate.values[0])
    passes = final_speeds(unbalances, 0.01, 20.0) > 110.0
    assert passes[: passes.sum()].all(), "one limit"
    known = (unbalances[passes.sum()] - 2e-3) / 10e-3
    assert 0.3 < known < 0.5 and second["low"] < known < second["high"] < second["low"] + 0.2
    assert second["not_identified"] == 0.0 and "advice" not in second
    assert second["estimate"] == pytest.approx(known, abs=2 / 64 + 0.02), "samples that are spread evenly, and a step"
    assert s["sentence"].endswith("; no probability at 1 of 2 values")
    assert report(result) and draw(result).axes


def test_the_advice_is_that_of_the_run_up_of_the_first_sample() -> None:
    result = undecided()
    s, first = result.wucht.summary, result.wucht.summary["probability"][0]
    weak = machine().with_values({"drive.slope": 1e-4, "drum.unbalance": 7e-3})
    verdict = run_to_end(weak, {}, RunSettings(until=20.0, tolerance=1e-6)).verdict
    assert verdict.outcome is Outcome.UNIDENTIFIED and verdict.needed_time is not None and verdict.needed_time > 20.0
    assert first["advised_time"] == pytest.approx(verdict.needed_time, rel=0.02)
    assert (s["advice"], s["advised_time"]) == (first["advice"], first["advised_time"])
    (warning,) = result.wucht.warnings
    assert warning.endswith(f"give a longer study.until than 20, as {first['advised_time']:g} s")


@pytest.mark.slow
def test_a_target_beside_a_value_without_a_probability() -> None:
    """The search comes down to the undecided value; where the last one is undecided, of a heavy rotor, nothing is known."""
    s = asked(**UNDECIDED | {"probability": 0.2}).wucht.summary
    assert " of the machines end as compensated or passed from slope" in s["sentence"] and s["searched"] > 3
    s = asked(**UNDECIDED | {"along": "drum.inertia", "range": [0.02, 2.0], "probability": 0.2}).wucht.summary
    assert s["sentence"].startswith("whether 0.2 is reached is not known: no run at moment of inertia")
    assert s["sentence"].endswith(" = 2 kg m^2 has a verdict") and s["smallest"] is None


@pytest.mark.slow
def test_where_no_value_has_a_probability() -> None:
    """The answer says so, and how long a run must be; nothing is searched, and no influence computed. Six values are named."""
    random = UNDECIDED["random"] | SPEED
    more = {"points": 7, "range": [1e-4, 7e-4], "until": 0.1, "probability": 0.5, "random": random}
    result = asked(**UNDECIDED | more, sensitivity=True, at=1e-4)
    s = result.wucht.summary
    assert (s["runs"], s["searched"], s["sensitivity"]) == (7 * 64, 0, None)
    where = "7 values of slope of the torque-speed curve, drive"
    assert s["sentence"] == f"there is no probability: none of {7 * 64} runs at {where} has a verdict"
    warnings = "\n".join(result.wucht.warnings)
    assert "drive = 0.0001, 0.0002, 0.0003, 0.0004, 0.0005, 0.0006 and 1 more values N m s: no run there" in warnings
    assert "the sensitivity is not computed: no run at any value has a verdict" in warnings
    assert draw(result).get_axes()


def test_one_by_one_without_a_verdict_no_more_runs_are_made_and_failures_have_their_places() -> None:
    """One of each of the 16 replicates, as only a limit ends the runs. A third of the places is taken; failed runs are named by
    their own samples."""
    question = CaptureProbability(
        along="drive.torque", range=[0.5, 1.0], points=2, samples=64, until=0.05,
        random={"b1": {"uniform": [0.0, 2 * math.pi]}}, start={"b2": 0.0},
    )  # fmt: skip
    result = ask(question, rail({"kind": "constant-torque", "torque": 0.5}))
    s = result.wucht.summary
    assert s["runs"] == 2 * 16 and s["probability"][0]["fractions"]["failed"] == pytest.approx(1 / 3, abs=0.15)
    assert "64 at each of 2 values; fewer at 2 of them, where none has a verdict" in "\n".join(report(result))
    assert "members are run up one by one" in s["integration"]
    told = [w for w in result.wucht.warnings if w.startswith("the run at torque of the drive = 0.5 N m, b1 = ")]
    assert len(told) == 3
    for sentence in told:
        angle = float(sentence.partition("b1 = ")[2].split()[0])
        assert min(angle, 2 * math.pi - angle) < math.pi / 3
        assert "failed: 'b" in sentence
    failed = round(32 * s["probability"][0]["fractions"]["failed"])
    assert result.wucht.warnings[-1] == f"{failed - 3} more runs failed"


SHARES = {1.0: 0.0396, 2.5: 0.2488, 3.0: 0.6326}  # of the basins of cases.md, on 64 x 64 cells


def of_basins(result: xr.Dataset) -> list[float]:
    """The values of u whose share of the basin is known, each within its band."""
    known = [u for u in result.parameter.values.tolist() if u in SHARES]
    for u in known:
        one = result.sel(parameter=u)
        assert float(one.low) - 0.002 <= SHARES[u] <= float(one.high) + 0.002, u
    return known


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
