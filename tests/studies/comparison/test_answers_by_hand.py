"""Answers of variants that are made by hand: curves of results, tables over the variants, sentences common to all."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import variable, warnings_of

from wucht.studies.comparison import computation
from wucht.studies.comparison.computation import Case, Findings, Plan, VariantCurve, VariantResult, _curve, _numbers_by_path
from wucht.studies.comparison.dataset import _merged_sentences, _path_label, dataset, is_constant
from wucht.studies.comparison.spec import Comparison
from wucht.studies.comparison.variants import Variant, VariedKey, _common_unit, _name, _uniquely_named

NAN = math.nan
SLOPE = VariedKey("drive.slope", "slope of the drive", "N m s", "mN m s")
MODEL = VariedKey("study.model", "model", None)


def case(name: str, slope: float, model: Any, source: str = "a.toml") -> Case:
    variant = Variant(name, source, {"drive.slope": slope, "study.model": model}, (SLOPE, MODEL))
    return Case(variant, None, None, "")


def curve(first: float, count: int, kind: str = "speed") -> VariantCurve:
    x = first + np.arange(float(count))
    return VariantCurve(("time", kind), ("s", "rad/s" if kind == "speed" else "m"), x, 10 * x)


def answer(outcome: str, numbers: dict[str, float], *curves: VariantCurve, **other: Any) -> VariantResult:
    common = {"units": {"final_speed": "rad/s", "final_phases.p1": "rad"}, "headlines": ("final_speed",)}
    return VariantResult("run-up", "A machine", outcome, f"it {outcome}", "", numbers=numbers, curves=curves, **common | other)


PLAN = Plan(
    Comparison(of=("a.toml",), vary={"drive.slope": [1e-3, 2e-3, 3e-3]}), "Three",
    (case("", 1e-3, "slow"), case("", 2e-3, "full"), case("", 3e-3, "slow", "b.toml")),
)  # fmt: skip
ANSWERS = (
    answer("passed", {"final_speed": 1.0, "turns": 7.0}, curve(0.0, 3), curve(1.0, 2, "amplitude"), warnings=("w", "all")),
    answer(
        "captured", {"final_speed": 2.0, "final_phases.p1": 0.5}, curve(5.0, 4), warnings=("all",), headlines=("turns", "x")
    ),
    VariantResult("run-up", "A machine", "failed", "it burst", "it burst", warnings=("all", "v")),
)


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    made: xr.Dataset = dataset(PLAN, Findings(ANSWERS))
    return made


def test_numbers_of_all_variants(result: xr.Dataset) -> None:
    assert result.final_speed.values == pytest.approx([1.0, 2.0, NAN], nan_ok=True)
    assert result.turns.values == pytest.approx([7.0, NAN, NAN], nan_ok=True)
    assert result["final_phases.p1"].values == pytest.approx([NAN, 0.5, NAN], nan_ok=True)
    assert result["final_phases.p1"].attrs == {"long_name": "final phases, p1", "units": "rad"}
    assert result.final_speed.attrs["units"] == "rad/s" and result.turns.attrs["units"] == ""
    assert result.outcome.values.tolist() == ["passed", "captured", "failed"]
    assert result.failure.values.tolist() == ["", "", "it burst"] and result.study.values.tolist() == ["run-up"] * 3
    s = result.wucht.summary
    assert s["outcomes"] == {"passed": 1, "captured": 1, "failed": 1} and s["failed"] == 1
    assert s["headline"] == ["final_speed", "turns"], "only what there is"
    assert [v["failure"] for v in s["variants"]] == [None, None, "it burst"]
    assert [v["varied"]["drive.slope"] for v in s["variants"]] == [1e-3, 2e-3, 3e-3]
    assert s["varied"]["drive.slope"] == {"what": "slope of the drive", "unit": "N m s"}
    assert result.attrs["sentence"].startswith("3 variants: 1 passed, 1 captured, 1 failed")


def test_varied_values_are_coordinates(result: xr.Dataset) -> None:
    slope = result["drive.slope"]
    assert slope.values.tolist() == [1e-3, 2e-3, 3e-3] and slope.attrs["units"] == "N m s"
    assert slope.attrs["printed_units"] == "mN m s" and slope.attrs["printed_factor"] == pytest.approx(1e3)
    assert result["study.model"].values.tolist() == ["slow", "full", "slow"]
    assert result.source.values.tolist() == ["a.toml", "a.toml", "b.toml"]
    assert result.variant.values.tolist()[1].replace("\N{NO-BREAK SPACE}", " ") == "slope of the drive = 2 mN m s; model = full"
    flags = Plan(PLAN.spec, "", (case("", 1e-3, True), case("", 2e-3, 1.5)))
    assert dataset(flags, Findings(ANSWERS[:2]))["study.model"].dtype.kind == "U", "true and false are no numbers"


def test_curves_of_one_kind_are_padded_to_the_longest(result: xr.Dataset) -> None:
    assert result.curve_1_x.values == pytest.approx(np.array([[0, 1, 2, NAN], [5, 6, 7, 8], [NAN] * 4]), nan_ok=True)
    assert result.curve_1_y.values == pytest.approx(10 * result.curve_1_x.values, nan_ok=True)
    assert result.curve_2_x.values == pytest.approx(np.array([[1, 2], [NAN] * 2, [NAN] * 2]), nan_ok=True)
    assert (result.curve_1_y.attrs["long_name"], result.curve_2_y.attrs["long_name"]) == ("speed", "amplitude")
    assert (result.curve_1_x.attrs["units"], result.curve_1_y.attrs["units"], result.curve_2_y.attrs["units"]) == (
        "s",
        "rad/s",
        "m",
    )


def test_sentences_common_to_all_are_told_once(result: xr.Dataset) -> None:
    labels = result.variant.values.tolist()
    assert [w for w in warnings_of(result) if "dimensionless" not in w] == ["all", f"{labels[0]}: w", f"{labels[2]}: v"]
    assert _merged_sentences(PLAN.cases[:1], [("w", "v")]) == ["w", "v"]
    part = dataset(PLAN, Findings(ANSWERS[:2]))
    assert part.attrs["sentence"].startswith("2 of 3 variants: ") and part.sizes["variant"] == 2


def test_labels_and_constant_numbers() -> None:
    assert _path_label("final_phases.p1") == "final phases, p1" and _path_label("final_speed") == "final speed"
    assert is_constant(np.array([1.0, 1.0])) and not is_constant(np.array([1.0, 2.0])) and not is_constant(np.array([1.0]))
    assert is_constant(np.array([760.89, 760.891])) and not is_constant(np.array([760.8, 760.89])), "as they are printed"
    assert not is_constant(np.array([1.0, np.nan]))


def test_numbers_of_a_summary() -> None:
    """Those in tables by path; lists and words are not compared."""
    summary = {"a": 1, "b": {"c": 2.5, "d": {"e": 3}, "f": "word"}, "g": [1, 2], "h": None, "i": True}
    assert _numbers_by_path(summary) == {"a": 1.0, "b.c": 2.5, "b.d.e": 3.0, "i": 1.0}


# --- curves of a result ---


def test_branches_are_parts_of_a_curve() -> None:
    """From each to the next there is a gap."""
    made = xr.Dataset({
        "value": variable("point", [1.0, 2.0, 3.0, 1.0, 2.0], "slope", "N m s"),
        "speed": variable("point", [5.0, 6.0, 7.0, 8.0, 9.0], "speed", "rad/s"),
        "branch": variable("point", [0, 0, 0, 1, 1], "branch"),
    })  # fmt: skip
    found = _curve(made, "value", "speed", {})
    assert found is not None and found.kind == ("slope", "speed", "N m s", "rad/s")
    assert found.x == pytest.approx([1, 2, 3, NAN, 1, 2], nan_ok=True)
    assert found.y == pytest.approx([5, 6, 7, NAN, 8, 9], nan_ok=True)


def test_of_several_bodies_the_first_is_taken_and_directions_follow_each_other() -> None:
    made = xr.Dataset({
        "time": variable("time", [0.0, 1.0], "time", "s"), "speed": variable("body time", [[1.0, 2.0], [3.0, 4.0]], "speed"),
        "grid": variable("direction place", [[1.0, 2.0], [2.0, 1.0]], "slope"),
        "up": variable("direction place", [[5.0, 6.0], [7.0, 8.0]], "speed"),
        "cases": variable("case time", [[1.0, 2.0]], "cases"), "nothing": variable("empty", np.empty(0), "nothing"),
    })  # fmt: skip
    first = _curve(made, "time", "speed", {})
    assert first is not None and first.y.tolist() == [1.0, 2.0]
    both = _curve(made, "grid", "up", {})
    assert both is not None and both.x == pytest.approx([1, 2, NAN, 2, 1], nan_ok=True)
    assert both.y == pytest.approx([5, 6, NAN, 7, 8], nan_ok=True)
    for x, y in (("time", "none"), ("none", "time"), ("time", "cases"), ("nothing", "nothing"), ("grid", "time")):
        assert _curve(made, x, y, {}) is None


def test_a_curve_keeps_its_detail_until_the_run_has_settled() -> None:
    """Of 100,000 samples over 100 s all extremes of the first 1.5 s are kept, and the whole is there."""
    time = np.linspace(0.0, 100.0, 100_001)
    made = xr.Dataset({"time": variable("time", time, "time", "s"), "speed": variable("time", np.sin(40 * time), "speed")})
    curve = _curve(made, "time", "speed", {"settling_time": 1.0})
    assert curve is not None and np.count_nonzero(curve.x <= 1.5) == 1501 and curve.x[-1] == 100.0 and len(curve.x) < 8000
    coarse = _curve(made, "time", "speed", {})
    assert coarse is not None and np.count_nonzero(coarse.x <= 1.5) < 100


@pytest.mark.parametrize(("stable", "overlapping", "expected"), [
    ([[1, 0], [1, 1]], [0, 0], [5, NAN, NAN, 7, 8]), ([[1, 0], [1, 1]], [0, 1], [5, NAN, NAN, NAN, NAN]),
    ([[0, 0], [0, 0]], [0, 0], [5, 6, NAN, 7, 8]),
])  # fmt: skip
def test_of_configurations_the_stable_ones_are_taken_if_any_is(stable: Any, overlapping: Any, expected: list[float]) -> None:
    made = xr.Dataset({
        "speed": variable("speed", [1.0, 2.0], "speed"),
        "amplitude": variable("configuration speed", [[5.0, 6.0], [7.0, 8.0]], "a"),
        "stable": variable("configuration speed", stable, "stable"), "overlapping": variable("configuration", overlapping, "o"),
    })  # fmt: skip
    found = _curve(made, "speed", "amplitude", {})
    assert found is not None and found.x == pytest.approx([1, 2, NAN, 1, 2], nan_ok=True)
    assert found.y == pytest.approx(expected, nan_ok=True)


# --- variants ---


def test_units_in_which_values_are_written() -> None:
    assert _common_unit(SLOPE, ["1 mN m s", "2.5e-1 mN m s"]) == "mN m s" and _common_unit(SLOPE, ["1 mN m s", "2 N m s"]) == ""
    assert _common_unit(SLOPE, [1.0, 2.0]) == "" and _common_unit(MODEL, ["1 slow", "2 slow"]) == ""
    assert SLOPE.to_si("5 mN m s") == pytest.approx(5e-3) and SLOPE.to_si(["1 mN m s", 2.0]) == pytest.approx([1e-3, 2.0])
    assert MODEL.to_si("slow") == "slow" and SLOPE.to_si("slow") == "slow"


def test_names_that_distinguish_the_variants() -> None:
    def named(*variants: Variant) -> list[str]:
        return [v.name for v in _uniquely_named(list(variants))]

    one, two, other = (Variant("", source, {}) for source in ("x/a.toml", "y/a.toml", "b.toml"))
    varied = [Variant("", "x/a.toml", {"drive.slope": w}, (SLOPE,)) for w in (1e-3, 2e-3, 2e-3)]
    assert named(one) == ["a"] and named(one, other) == ["a", "b"] and named(one, two) == ["x/a.toml", "y/a.toml"]
    assert named(*varied) == ["", "", "(2)"] and named(*varied[:2], other) == ["a", "a", "b"]
    assert named(one, one) == ["a", "a (2)"]
    assert [_name(s) for s in ("x/a.toml", "out/result.nc", "practice/fan")] == ["a", "out", "fan"]


def test_a_study_that_fails_is_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    refusal = Case(Variant("a", "a.toml", {}), None, None, "not allowed")
    found = computation._run_case(refusal, SimpleNamespace())  # type: ignore[arg-type]
    assert (found.outcome, found.failure, found.sentence, found.study) == ("failed", "not allowed", "not allowed", "")
    sizes: Any = [SimpleNamespace(study=SimpleNamespace(numbers=lambda plan: plan), plan=n) for n in (3.0, 7.0, 5.0)]
    plan: Any = SimpleNamespace(cases=[*sizes, refusal])
    assert computation.numbers(plan) == 7.0, "one study runs after the other"
