"""Probabilities over a parameter: against a border between two steady speeds that is known, and against maps of basins."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.container import BarContainer
from scipy.integrate import solve_ivp

from known_borders import DAMPING, MASS, SPEED, STIFFNESS, asked, machine, rail, share_above_border
from wucht import CaptureProbability, draw, load, report
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
    bands = [f"{100 * low:.3g} to {100 * high:.3g} %" for low, high in zip(result.low.values, result.high.values, strict=True)]
    ends = "of the starts end as compensated or passed at slope of the torque-speed curve, drive"
    last = f"{bands[2]} at slope of the torque-speed curve, drive = 0.008 N m s"
    assert s["sentence"] == f"with 95 % confidence {bands[0]} {ends} = 0.005 N m s, {last}"
    assert [line.replace("·", " ") for line in report(result)[2:-1]] == [
        "  random       drum.speed uniform: low 95.0, high 115.0",
        f"  probability  drive.slope = 0.005 N m s: {100 * float(result.estimate[0]):.3g} % ({bands[0]})",
        f"               drive.slope = 0.0065 N m s: {100 * share:.3g} % ({bands[1]})",
        f"               drive.slope = 0.008 N m s: {100 * float(result.estimate[2]):.3g} % ({bands[2]})",
        "  runs         192: 64 at each of 3 values",
        "  integrated   members are integrated in batches",
    ]


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
    where = f"from slope of the torque-speed curve, drive = {at[k]:.5g} N m s on"
    sentence = f"with 95 % confidence at least 0.65 of the starts end as compensated or passed {where}"
    assert s["sentence"] == sentence
    assert f"{len(at)} values, {len(at) - 3} of them for the search" in "\n".join(report(result))
    axis = draw(result).axes[0]
    reached = f"reached at {at[k]:.4g} N·m·s"
    legend = [text.get_text().replace("\N{NO-BREAK SPACE}", " ") for text in axis.get_legend().get_texts()]  # type: ignore[union-attr]
    assert legend == ["95 % confidence", "estimate", "of the search", "target: 0.65", reached]
    lines = {str(line.get_label()): line.get_xydata() for line in axis.get_lines()}
    assert lines["target: 0.65"][:, 1].tolist() == [0.65, 0.65]
    assert lines[reached.replace("·", " ")][0, 0] == at[k]
    for name, searched in (("estimate", 0), ("of the search", 1)):
        assert lines[name][:, 0].tolist() == result.parameter.values[result.searched.values == searched].tolist()
    band = {tuple(corner) for corner in axis.collections[0].get_paths()[0].vertices}
    assert band >= {(x, y) for name in ("low", "high") for x, y in zip(at, result[name].values.tolist(), strict=True)}
    assert axis.get_xlim() == pytest.approx((0.005 - 0.015 * 0.015, 0.02 + 0.015 * 0.015))


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


@pytest.mark.parametrize(("random", "noun"), [
    (SPEED, "starts"), ({"drum.unbalance": {"uniform": [0.0049, 0.005]}}, "machines"),
    (SPEED | {"drive.no_load_speed": {"normal": [150.0, 0.1]}}, "runs"),
])  # fmt: skip
def test_what_is_random_is_named(random: dict[str, Any], noun: str) -> None:
    assert f" of the {noun} end as " in asked(points=2, random=random).wucht.summary["sentence"]


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
    lines = [line.strip() for line in report(result)]
    first = next(k for k, line in enumerate(lines) if "share of the variance of the outcome" in line)
    assert "at drive.slope = 0.0065 N·m·s, share" in lines[first] and lines[first].endswith("(256 runs)")
    numbers = (f"{speed[key]:.2f} ± {speed[f'{key}_off']:.2f}" for key in ("first_order", "total"))
    assert lines[first + 1] == "drum.speed: {} alone, {} with interactions".format(*numbers)
    assert lines[first + 2] == "drum.angle: 0.00 ± 0.00 alone, 0.00 ± 0.00 with interactions"
    assert not any("left out of the indices" in w for w in result.wucht.warnings)


def test_where_all_end_alike_nothing_matters() -> None:
    nothing = asked(points=2, random=ANGLE, sensitivity=True, at=0.02)
    assert nothing.wucht.summary["sensitivity"]["indices"] is None
    assert any("all runs with a verdict have one outcome: no random quantity matters" in w for w in nothing.wucht.warnings)
    assert len(draw(nothing).axes) == 1
    assert "no random quantity matters: all runs have the same outcome" in "\n".join(report(nothing))


def test_bars_of_indices_the_one_that_matters_most_at_the_top() -> None:
    columns = {"first_order": [0.1, 0.6], "first_order_off": [0.01, 0.06], "total": [0.2, 0.7], "total_off": [0.02, 0.07]}
    _, axis = draw(sensitive().assign({name: ("quantity", values) for name, values in columns.items()})).axes
    assert [text.get_text() for text in axis.get_yticklabels()] == ["drum.angle", "drum.speed"]
    assert axis.get_ylim()[0] > axis.get_ylim()[1], "downwards"
    first, total = (c for c in axis.containers if isinstance(c, BarContainer))
    for bars, widths, side in ((first, [0.6, 0.1], -0.18), (total, [0.7, 0.2], 0.18)):
        assert [b.get_width() for b in bars] == widths
        assert [b.get_y() + b.get_height() / 2 for b in bars] == pytest.approx([side, 1 + side])
        assert bars.errorbar is not None and bars.errorbar.has_xerr and not bars.errorbar.has_yerr
    assert axis.get_title() == "sensitivity at 0.0065 N·m·s"


def test_samples_that_fill_unevenly_are_warned_of() -> None:
    warning = "samples = 80 is not a power of two: Sobol' points fill the space evenly with 64 or 128"
    assert warning in asked(samples=80, points=2).wucht.warnings
    assert rising().wucht.warnings == []


def test_written_and_read_back(tmp_path: Any) -> None:
    question = CaptureProbability(along="drive.slope", range=[0.005, 0.02], points=2, random=SPEED, samples=64, until=20.0)
    result = ask(question, machine(), folder=tmp_path)
    again = load(tmp_path / "result.nc")
    for name in result.variables:
        assert np.array_equal(again[name], result[name]), name
    assert report(again) == report(result)
    draw(again)


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
    assert told.endswith("they may count or not, which widens the band; a longer study.until may identify them")
    assert f", {100 * open_[0]:.4g} % without a verdict" in "\n".join(report(result))
    axis = draw(result).axes[0]
    (hatched,) = [c for c in axis.collections if c.get_label() == "no verdict"]
    corners = hatched.get_paths()[0].vertices
    counted = result.estimate.values[0] * (1 - open_[0])
    assert np.sort(np.unique(corners[corners[:, 0] == 0.004, 1])) == pytest.approx([counted, counted + open_[0]])
    hardly = draw(result.assign(not_identified=0 * result.not_identified + 1e-4)).axes[0]
    assert "no verdict" not in [text.get_text() for text in hardly.get_legend().get_texts()]  # type: ignore[union-attr]
    alone = result.isel(parameter=[0])
    for one, bars in ((alone, 2), (alone.assign(not_identified=0 * alone.not_identified), 1)):
        axis = draw(one).axes[0]
        low, high = axis.get_xlim()
        boxes = [band.get_paths()[0].get_extents() for band in axis.collections]
        assert len(boxes) == bars, "the band of a single value, and the share without a verdict"
        assert all(box.width > 0.005 * (high - low) and low < box.x0 < 0.004 < box.x1 < high for box in boxes)
        assert (boxes[0].y0, boxes[0].y1) == (result.low.values[0], result.high.values[0])


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


def test_a_machine_whose_first_value_is_undecided() -> None:
    """Its weak motor still accelerates, a tenth of the way, when the runs end. The other one passes with the small unbalances,
    of those from 2 to 12 g m, which an integration of our own finds."""
    result = asked(**UNDECIDED)
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
    assert s["sentence"].startswith("with 95 % confidence ") and s["sentence"].count(" at ") == 2
    assert s["sentence"].endswith("; no probability at 1 of 2 values")
    assert "not known (0 to 100 %), 100 % without a verdict" in "\n".join(report(result))
    draw(result)


def test_the_advice_is_that_of_the_run_up_of_the_first_sample() -> None:
    s = asked(**UNDECIDED).wucht.summary
    first = s["probability"][0]
    weak = machine().with_values({"drive.slope": 1e-4, "drum.unbalance": 7e-3})
    verdict = run_to_end(weak, {}, RunSettings(until=20.0, tolerance=1e-6)).verdict
    assert verdict.outcome is Outcome.UNIDENTIFIED and verdict.needed_time is not None and verdict.needed_time > 20.0
    assert first["advised_time"] == pytest.approx(verdict.needed_time, rel=0.02)
    assert (s["advice"], s["advised_time"]) == (first["advice"], first["advised_time"])
    (warning,) = asked(**UNDECIDED).wucht.warnings
    place = "there is no probability at slope of the torque-speed curve, drive = 0.0001 N m s"
    advised = f"give a longer study.until than 20, as {first['advised_time']:g} s"
    assert warning == f"{place}: no run there has a verdict ({first['advice']}), and any share is possible; {advised}"


def test_a_target_beside_a_value_without_a_probability() -> None:
    """The search comes down to the undecided value; where the last one is undecided, of a heavy rotor, nothing is known."""
    s = asked(**UNDECIDED | {"probability": 0.2}).wucht.summary
    assert " of the machines end as compensated or passed from slope" in s["sentence"] and s["searched"] > 3
    s = asked(**UNDECIDED | {"along": "drum.inertia", "range": [0.02, 2.0], "probability": 0.2}).wucht.summary
    assert s["sentence"].startswith("whether 0.2 is reached is not known: no run at moment of inertia")
    assert s["sentence"].endswith(" = 2 kg m^2 has a verdict") and s["smallest"] is None


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
