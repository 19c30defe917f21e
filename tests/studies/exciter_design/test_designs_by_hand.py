"""Every number and line of a design that is made by hand: of unlike candidates and unlike metrics."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, five_functions, titled, warnings_of
from tests.refusals import refused

import wucht
from wucht.dynamics.exciters.design_trials import Candidates, CheckedCandidate, LocalOptimum
from wucht.dynamics.exciters.slow_beats import MOTIONS, Beat
from wucht.errors import InputError
from wucht.studies.exciter_design import computation
from wucht.studies.exciter_design.computation import Findings
from wucht.studies.exciter_design.spec import ExciterDesign

STUDY = five_functions("exciter-design")
RANGES = {"drive.slope": ["2e-4 N m s", "3e-3 N m s"], "p1.mass": ["0.3 kg", "3 kg"]}
STEPPED = {"table": [["1 mm", 1e6], ["2 mm", 1e3]], "stepped": True}
BEAT = Beat("modulated", 2.0, 10.0, np.array([2.5, 7.5]), np.array([1e-3, 2.5e-3]), np.array([3.0, 5.0]))
COLUMN = {"amplitude": 0, "cumulative": 1, "damage": 2}


@pytest.fixture(scope="module")
def machine() -> wucht.Machine:
    return wucht.load_machine("practice/exciter")


@pytest.fixture(scope="module", params=["amplitude", "cumulative", "damage"])
def plan(machine: wucht.Machine, request: pytest.FixtureRequest) -> Any:
    return STUDY.prepare(ExciterDesign(target=STEPPED, vary=RANGES, metric=request.param, slope=5.0), machine)


def checked(plan: Any, *distances: float, **other: Any) -> CheckedCandidate:
    counted = np.array([2e-3, 3e-3]), np.array([150.0, 50.0])
    numbers = np.array([distances[0] * 1e-3, distances[0] + 1.0])
    turns = np.array([2.5, 5.0, 7.5]), np.array([-1e-3, 3e-3, -2e-3])
    made = CheckedCandidate(numbers, BEAT, *counted, np.array(distances), 50.0, "captured-modulated", True, "", *turns)
    return replace(made, **other)


def candidates(first: float, motions: str) -> Candidates:
    """Of unlike distances; m: modulated, s: steady."""
    n, beats = len(motions), np.array([m == "m" for m in motions])
    far = first + 0.25 * np.arange(n)
    form = np.where(beats, far, np.nan)
    return Candidates(
        np.stack([1e-3 * far, far], axis=1), np.stack([form, 10 + form[::-1], 20 + 2 * form], axis=1),
        np.where(beats, MOTIONS.index("modulated"), MOTIONS.index("steady")), 1e-3 * form, 0.1 * form, 0.2 * form,
    )  # fmt: skip


REACH, LATER, SEARCH = candidates(1.0, "msm"), candidates(4.0, "mm"), candidates(2.0, "mms")
SAMPLES = candidates(0.5, "m" * 18 + "ss")


@pytest.fixture(scope="module")
def runs(plan: Any) -> tuple[CheckedCandidate, ...]:
    return (
        checked(plan, 0.5, 0.125, 0.75, outcome="passed", beats=False), checked(plan, 0.25, 0.75, 0.5),
        checked(plan, 0.375, 0.5, 0.625), checked(plan, 0.75, 0.625, 0.25), checked(plan, np.nan, np.nan, np.nan),
    )  # fmt: skip


@pytest.fixture(scope="module")
def result(plan: Any, runs: tuple[CheckedCandidate, ...]) -> xr.Dataset:
    optima = (LocalOptimum(np.array([1e-3, 1.5]), 0.0625), LocalOptimum(np.array([2e-3, 2.5]), 0.125))
    return titled(STUDY.dataset(plan, Findings((REACH, LATER), (SEARCH,), optima, runs, (SAMPLES,), complete=True)))


BEST = {"amplitude": 1, "cumulative": 2, "damage": 3}


def test_the_design_is_the_nearest_that_beats_by_the_metric_that_is_chosen(
    plan: Any, runs: tuple[CheckedCandidate, ...], result: xr.Dataset
) -> None:
    s, metric = result.wucht.summary, plan.spec.metric
    best = runs[BEST[metric]]
    assert s["metric"] == metric and s["distance"] == best.distances[COLUMN[metric]]
    assert s["parameters"] == pytest.approx({"drive.slope": best.numbers[0], "p1.mass": best.numbers[1]})
    assert s["distances"]["full"] == dict(zip(COLUMN, best.distances, strict=True))
    assert [run["full"] for run in s["runs"]] == [
        None if np.isnan(d) else d for d in (r.distances[COLUMN[metric]] for r in runs)
    ]
    assert [run["outcome"] for run in s["runs"]] == ["passed", *["captured-modulated"] * 4]
    assert [run["parameters"]["p1.mass"] for run in s["runs"]][:4] == [1.5, 1.25, 1.375, 1.75]
    assert result.run_beats.values.tolist() == [0, 1, 1, 1, 1]
    assert result.run_value.values[:4, 0] == pytest.approx([5e-4, 2.5e-4, 3.75e-4, 7.5e-4])
    assert result.run_full.values[:4].tolist() == [r.distances[COLUMN[metric]] for r in runs[:4]]
    assert [p["distance"] for p in s["polished"]] == [0.0625, 0.125] and s["polished"][1]["p1.mass"] == 2.5


def test_the_beat_of_the_averaged_equations_against_the_target(plan: Any, result: xr.Dataset) -> None:
    """15 cycles of 1 mm and 25 of 2.5 mm in a beat, of the target 0.999 of 1 mm and 0.001 of 2 mm."""
    s = result.wucht.summary
    amplitude = (0.625 * 1.5 - 0.001) / 2  # the area between the two curves, over the largest amplitude of 2 mm
    assert s["distances"]["slow"]["amplitude"] == pytest.approx(amplitude, rel=1e-3)
    assert s["distances"]["slow"]["cumulative"] == pytest.approx(0.625, rel=1e-2)  # beyond 2 mm
    slow = s["distances"]["slow"][plan.spec.metric]
    assert result.run_slow.values == pytest.approx([slow] * 5) and s["runs"][0]["slow"] == pytest.approx(slow)
    assert (s["beat"], s["cycles_per_beat"]) == (10.0, 40.0)
    assert result.beat_time.values.tolist() == [2.5, 7.5] and result.beat_rate.values.tolist() == [3.0, 5.0]
    assert result.beat_amplitude.values.tolist() == [1e-3, 2.5e-3]
    at = result.share.values
    beside = np.abs(at - 0.625) > 1e-9
    assert result.amplitude_slow.values[beside] == pytest.approx(np.where(at < 0.625, 2.5e-3, 1e-3)[beside])


def test_the_cycles_of_the_full_equations_against_the_target(result: xr.Dataset) -> None:
    """Of 200 cycles in 50 s 150 have a range of 2 mm and 50 one of 3 mm; the target has 1000 of 4 mm among 1e6."""
    s = result.wucht.summary
    assert s["upper"] == pytest.approx(1.5e-3) and s["duration"] == pytest.approx(2.5e5) and s["beyond"] == pytest.approx(1e3)
    assert s["damage_ratio"] == pytest.approx((0.75 + 0.25 * 1.5**5) / (0.999 + 0.001 * 2**5), rel=1e-9)
    assert s["spectrum"] == [
        {"range": 2e-3, "mean": 0.0, "count": pytest.approx(7.5e5)},
        {"range": 3e-3, "mean": 0.0, "count": pytest.approx(2.5e5)},
    ]  # fmt: skip
    form = {"upper": 2e-3, "ratio": 0.5, "fullness": 1e-3, "cycles": 1e6}
    assert s["target"] == pytest.approx(form)
    assert {key: float(result[f"wanted_{key}"]) for key in form} == pytest.approx(form)


def test_many_ranges_are_put_into_classes(machine: wucht.Machine) -> None:
    """200 ranges each have a row; of 201 each class has a hundredth of the largest, and the sum of all ranges stays."""
    plan = STUDY.prepare(ExciterDesign(target=STEPPED, vary=RANGES), machine)
    for count, rows in ((200, 200), (201, 101)):
        ranges = np.linspace(1e-5, 2e-3, count)
        made = checked(plan, 0.1, 0.1, 0.1, ranges=ranges, counts=np.ones(count))
        spectrum = STUDY.dataset(plan, Findings(full_runs=(made,))).wucht.summary["spectrum"]
        assert len(spectrum) in (rows, rows - 1) and sum(row["count"] for row in spectrum) == pytest.approx(1e6)
        assert sum(row["count"] * row["range"] for row in spectrum) == pytest.approx(1e6 * ranges.mean())


def test_a_target_of_one_amplitude_has_no_fullness(machine: wucht.Machine) -> None:
    plan = STUDY.prepare(ExciterDesign(target={"table": [["2 mm", 1e6]], "stepped": True}, vary=RANGES), machine)
    assert STUDY.dataset(plan, Findings()).wucht.summary["target"] == {
        "upper": pytest.approx(2e-3), "ratio": pytest.approx(1.0), "fullness": None, "cycles": pytest.approx(1e6),
    }  # fmt: skip


def test_candidates_of_all_batches(plan: Any, result: xr.Dataset) -> None:
    column = COLUMN[plan.spec.metric]
    batches = {"reach": (REACH, LATER), "tried": (REACH, LATER, SEARCH), "tolerance": (SAMPLES,)}
    for name, of in batches.items():
        for key in ("upper", "ratio", "fullness"):
            together = np.concatenate([getattr(b, key) for b in of])
            assert result[f"{name}_{key}"].values == pytest.approx(together, nan_ok=True), (name, key)
        far = np.concatenate([b.distances[:, column] for b in of])
        assert result[f"{name}_distance"].values == pytest.approx(far, nan_ok=True)
        assert result[f"{name}_value"].values == pytest.approx(np.concatenate([b.numbers for b in of]))
        assert result[f"{name}_motion"].values.tolist() == np.concatenate([b.motion for b in of]).tolist()
    s = result.wucht.summary
    assert s["candidates"] == 8 and (s["motions"]["modulated"], s["motions"]["steady"]) == (6, 2)
    assert s["reach"] == {
        "modulated": 0.8, "upper": pytest.approx([1e-3, 4.25e-3]), "ratio": pytest.approx([0.1, 0.425]),
        "fullness": pytest.approx([0.2, 0.85]),
    }  # fmt: skip


def test_quantiles_of_the_tolerances(plan: Any, result: xr.Dataset) -> None:
    """Of 20 exciters two do not beat: those with the 95 % quantile among them."""
    far = np.sort(SAMPLES.distances[:, COLUMN[plan.spec.metric]][:18] if plan.spec.metric != "cumulative" else
                  SAMPLES.distances[2:, 1])  # fmt: skip
    t = result.wucht.summary["tolerances"]
    assert (t["q05"], t["median"], t["q95"], t["modulated"]) == (far[1], far[10], None, 0.9)
    assert t["spread"] == plan.spec.spread


def test_variables_and_their_ranges(plan: Any, result: xr.Dataset) -> None:
    s = result.wucht.summary
    assert s["variables"] == {
        "drive.slope": {"paths": ["drive.slope"], "range": [2e-4, 3e-3], "unit": "N m s"},
        "p1.mass": {"paths": ["p1.mass"], "range": [0.3, 3.0], "unit": "kg"},
    }
    values = plan.machine.values
    assert s["as_it_is"] == {"drive.slope": values["drive.slope"], "p1.mass": values["p1.mass"]}
    assert result.variable.values.tolist() == ["drive.slope", "p1.mass"] and s["unit"] == "m"


def test_the_figure(plan: Any, result: xr.Dataset) -> None:
    panels = [a for a in drawn("exciter-design", result).axes if a.get_title()]
    by_number, by_share, beat, reach, search, tolerances = panels
    shown = [{str(x.get_label()): x for x in axis.get_lines()} for axis in panels]
    for k, axis in enumerate((by_number, by_share)):
        x = result.share.values * (1e6, 1.0)[k]
        assert (axis.get_xscale(), axis.get_ylim()[0]) == (("log", "linear")[k], 0.0)
        for name, label in (("wanted", "target"), ("slow", "averaged equations"), ("full", "full equations")):
            assert shown[k][label].get_xdata() == pytest.approx(x)
            assert shown[k][label].get_ydata() == pytest.approx(1e3 * result[f"amplitude_{name}"].values)
    full, above, below = beat.get_lines()
    assert (full.get_label(), above.get_label()) == ("full equations", "amplitude, averaged equations")
    assert full.get_xdata() == pytest.approx([2.5, 5.0, 7.5]) and full.get_ydata() == pytest.approx([-1.0, 3.0, -2.0])
    assert above.get_ydata() == pytest.approx([1.0, 2.5]) and below.get_ydata() == pytest.approx([-1.0, -2.5])
    assert beat.get_ylim() == pytest.approx((-3.3, 3.3))
    places = np.asarray(reach.collections[0].get_offsets())
    beats = np.isfinite(result.tried_upper.values)
    assert places == pytest.approx(np.stack([1e3 * result.tried_upper.values[beats], result.tried_ratio.values[beats]], axis=1))
    assert np.asarray(reach.collections[0].get_array()) == pytest.approx(result.tried_fullness.values[beats])
    target, design = shown[3]["target"], shown[3]["design, averaged equations"]
    assert (target.get_xdata()[0], target.get_ydata()[0]) == pytest.approx((2.0, 0.5))
    assert (design.get_xdata()[0], design.get_ydata()[0]) == pytest.approx((2.5, 0.4))
    far = result.tried_distance.values
    number = np.arange(1, 9)
    assert shown[4]["candidate"].get_xdata() == pytest.approx(number[np.isfinite(far)])
    assert shown[4]["candidate"].get_ydata() == pytest.approx(far[np.isfinite(far)])
    lowest = [min((d for d in far[: k + 1] if np.isfinite(d)), default=np.nan) for k in range(8)]
    assert shown[4]["best so far"].get_ydata() == pytest.approx(lowest, nan_ok=True)
    assert shown[4]["best so far"].get_xdata() == pytest.approx(number)
    assert shown[4]["search begins"].get_xdata()[0] == 5.5, "after the five random points"
    assert shown[4]["checked, full"].get_ydata() == pytest.approx(result.run_full.values, nan_ok=True)
    assert shown[4]["checked, averaged"].get_ydata() == pytest.approx(result.run_slow.values)
    assert shown[4]["checked, full"].get_xdata().min() > 8
    near = np.sort(result.tolerance_distance.values)[:18]
    line = next(x for label, x in shown[5].items() if label.startswith("all that is varied"))
    assert line.get_xdata() == pytest.approx(near) and line.get_ydata() == pytest.approx(np.arange(1, 19) / 20)
    assert shown[5]["design"].get_xdata()[0] == result.wucht.summary["distance"]
    decades = np.log10(search.get_ylim())
    assert decades == pytest.approx(np.round(decades)), "the scale begins and ends with a number"
    assert reach.child_axes[0].get_ylabel() == "fullness: mean amplitude, 0 as\nthe smallest, 1 as the largest", (
        "it is said what that is"
    )
    assert search.get_ylabel() == f"distance, {plan.spec.metric}" and tolerances.get_ylim() == (0.0, 1.02)


def test_panels_of_an_interrupted_design(plan: Any) -> None:
    def titles(findings: Findings) -> list[str]:
        return [a.get_title() for a in drawn("exciter-design", titled(STUDY.dataset(plan, findings))).axes if a.get_title()]

    assert titles(Findings()) == ["cumulative spectrum"] * 2 + ["reachable spectra"]
    assert titles(Findings((REACH,)))[2:] == ["reachable spectra", "search with the averaged equations"]
    assert STUDY.dataset(plan, Findings()).attrs["sentence"] == "no exciter that beats so far"


def target(machine: wucht.Machine, **given: Any) -> Any:
    return STUDY.prepare(ExciterDesign(target=given, vary=RANGES), machine).target


def test_a_table_may_have_its_rows_in_any_order_and_other_units(machine: wucht.Machine) -> None:
    ordered = target(machine, table=[["1 mm", 1e6], ["1.5 mm", 1e4], ["2 mm", 1e3]])
    mixed = target(machine, table=[["0.2 cm", "1e3 cycles"], ["1 mm", 1e6], ["1.5 mm", 1e4]])
    assert mixed.total == pytest.approx(1e6) and np.array_equal(mixed.ranges, ordered.ranges)


@pytest.mark.parametrize(("rows", "stepped", "words"), [
    ([["1 mm", 1e6]], False, "two rows"), ([], True, "two rows"),
    ([["-1 mm", 1e6], ["2 mm", 1e3]], False, "none below 0"), ([["1 mm", 1e6], ["1 mm", 1e3]], False, "different amplitudes"),
    ([["0 mm", 1e6]], True, "different amplitudes"),
    ([["1 mm", 1e3], ["2 mm", 1e6]], False, "do not increase"), ([["1 mm", 1e3], ["2 mm", 0.0]], False, "greater than 0"),
])  # fmt: skip
def test_tables_that_are_no_spectra(machine: wucht.Machine, rows: list[Any], stepped: bool, words: str) -> None:
    with refused("study.target.table", words):
        target(machine, table=rows, stepped=stepped)


def test_tables_on_the_border(machine: wucht.Machine) -> None:
    assert target(machine, table=[["0 mm", 1e3], ["1 mm", 1e3]]).largest == pytest.approx(2e-3)
    with refused("study.target.largest", given="0 mm"):
        target(machine, shape="normal", largest="0 mm", cycles=1e6)
    assert target(machine, shape="constant", largest="2 mm", cycles=1e6).ranges == pytest.approx(4e-3)


def test_few_cycles_are_resolved_by_their_logarithm(result: xr.Dataset) -> None:
    """Below a quarter of a percent the shares are evenly spaced by their logarithm, from one cycle on."""
    few = result.share.values[result.share.values < 1 / 400]
    assert few[1:] / few[:-1] == pytest.approx(np.full(len(few) - 1, 1e6 ** (1 / 119)), rel=1e-9)


@pytest.mark.parametrize(("count", "warned"), [(990.0, False), (1010.0, True)])
def test_many_missed_cycles_are_warned_of(machine: wucht.Machine, count: float, warned: bool) -> None:
    """A thousandth of a million."""
    table = {"table": [["1 mm", 1e6], ["2 mm", count]], "stepped": True}
    plan = STUDY.prepare(ExciterDesign(target=table, vary=RANGES), machine)
    made = STUDY.dataset(plan, Findings(full_runs=(checked(plan, 0.1, 0.1, 0.1),), complete=True))
    assert any("exceed the largest reached amplitude" in w for w in warnings_of(made)) is warned


@pytest.mark.parametrize("bad", [2e-4, 3e-3])
def test_both_ends_of_a_range_must_be_allowed(plan: Any, bad: float) -> None:
    def candidate_machine(numbers: np.ndarray) -> None:
        asked.append(numbers.tolist())
        if numbers[0] == bad:
            raise InputError("drive.slope", bad, "must be another")

    asked: list[list[float]] = []
    trials: Any = SimpleNamespace(variables=plan.trials.variables, candidate_machine=candidate_machine)
    with refused("study.vary.drive.slope", given=bad):
        computation._check_ends(trials, plan.numbers)
    assert all(other == plan.numbers[1] for _, other in asked), "with nominal values otherwise"
