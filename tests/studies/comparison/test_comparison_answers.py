"""What a comparison keeps of answers that are recited: numbers, curves, sentences and failures, and names of the variants."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused
from tests.studies.comparison.recital import Reciter, compare, nothing, recited

import wucht
from wucht import RunError
from wucht.extending import Answer

NAN = math.nan
pytestmark = pytest.mark.usefixtures("recital")
SLOPE, SAYS = "drive.slope", "study.says"


def passing(a: Answer, _: Reciter) -> None:
    """With a list, a text and what there is none of: they are not compared."""
    a.number("outcome", "passed", "outcome")
    a.number("final_speed", 1.0, "speed", "rad/s", headline=True)
    a.number("turns", 7, "turns")
    a.number("sizes", [1.0, 2.0], "sizes")
    a.number("missing", None, "nothing")
    a.number("steady", True, "whether it is steady")
    a.warn("w", "all")
    a.assume("x")
    state_speeds(a, 0.0, 3)
    a.curve("sway", [3.0] * 3, "amplitude", "m", "time")


def captured(a: Answer, _: Reciter) -> None:
    a.number("outcome", "captured", "outcome")
    a.number("turns", None, "turns", headline=True)
    a.number("final_speed", 2.0, "speed", "rad/s")
    a.number("lost", None, "nothing", headline=True)
    phases = {"p1": 0.5, "deep": {"p2": 1.5}, "name": "word"}
    a.number("final_phases", phases, "phases", parts={"p1": ("phase", "rad")})
    a.warn("w", "all")
    state_speeds(a, 5.0, 4)


def bursting(a: Answer, _: Reciter) -> None:
    a.sentence = a.failure = "it burst"
    a.warn("all", "v")


def state_speeds(a: Answer, first: float, count: int) -> None:
    x = first + np.arange(float(count))
    a.curve("time", x, "time", "s")
    a.curve("swing", 10 * x, "speed", "rad/s", "time")


@pytest.fixture
def result() -> xr.Dataset:
    return compare(passing, captured, bursting)


def numbers(result: xr.Dataset, name: str) -> Any:
    return pytest.approx(result[name].values.tolist(), nan_ok=True)


def test_numbers_of_all_variants(result: xr.Dataset) -> None:
    assert numbers(result, "final_speed") == [1.0, 2.0, NAN] and numbers(result, "turns") == [7.0, NAN, NAN]
    assert numbers(result, "final_phases.p1") == [NAN, 0.5, NAN] and numbers(result, "final_phases.deep.p2") == [NAN, 1.5, NAN]
    assert numbers(result, "steady") == [1.0, NAN, NAN], "true is a number"
    assert not {"sizes", "missing", "lost", "final_phases.name"} & set(result.variables)
    assert result["final_phases.p1"].attrs == {"long_name": "final phases, p1", "units": "rad"}
    assert result.final_speed.attrs == {"long_name": "final speed", "units": "rad/s"} and result.turns.attrs["units"] == ""
    assert result.outcome.values.tolist() == ["passed", "captured", "failed"]
    assert result.failure.values.tolist() == ["", "", "it burst"] and result.study.values.tolist() == ["recital"] * 3
    assert result.sentence.values.tolist() == ["answer 0", "answer 1", "it burst"]
    s = result.wucht.summary
    assert s["outcomes"] == {"passed": 1, "captured": 1, "failed": 1} and s["failed"] == 1
    assert s["headline"] == ["final_speed", "turns"], "only what there is"
    assert [v["failure"] for v in s["variants"]] == [None, None, "it burst"]
    assert [v["varied"][SAYS] for v in s["variants"]] == [0, 1, 2]
    assert s["varied"][SAYS] == {"what": "says", "unit": ""}
    assert result.wucht.sentence == "3 variants: 1 passed, 1 captured, 1 failed"
    assert result.wucht.unit_at("variants[1].summary.final_phases.p1") == "rad"


def test_varied_values_are_coordinates() -> None:
    result = compare(nothing, vary={SLOPE: ["1 mN m s", "2.5e-1 mN m s"], "study.word": ["slow", "full"]})
    assert result[SLOPE].values == pytest.approx([1e-3, 1e-3, 2.5e-4, 2.5e-4])
    assert result[SLOPE].attrs == {
        "long_name": "slope of the drive", "units": "N m s", "printed_units": "mN m s", "printed_factor": pytest.approx(1e3),
    }  # fmt: skip
    assert result.wucht.summary["varied"][SLOPE] == {"what": "slope of the drive", "unit": "N m s"}
    assert result["study.word"].values.tolist() == ["slow", "full"] * 2 and set(result.coords) >= {SLOPE, "study.word"}
    assert result.source.values.tolist() == ["a.toml"] * 4
    labels = [label.replace("\N{NO-BREAK SPACE}", " ") for label in result.variant.values.tolist()]
    assert labels[1] == "slope of the drive = 1 mN m s; word = full"


@pytest.mark.parametrize(("values", "si", "unit"), [
    (["1 mN m s", "2 N m s"], [1e-3, 2.0], ""), ([1.0, 2.0], [1.0, 2.0], ""),
    (["2 mN m s", 1.0], [2e-3, 1.0], ""), (["1 mN m s", True], ["0.001 N m s", "True"], ""),
    ([["1 mN m s", 2.0], 1.0], ["[0.001, 2] N m s", "1 N m s"], ""),
])  # fmt: skip
def test_units_in_which_values_are_written(values: list[Any], si: list[Any], unit: str) -> None:
    """They are printed where all are in one unit; true is no number."""
    key = compare(nothing, vary={SLOPE: values})[SLOPE]
    texts = [str(v).replace("\N{NO-BREAK SPACE}", " ") for v in key.values.tolist()]
    assert (key.values == pytest.approx(si)) if key.dtype.kind == "f" else (texts == si), texts
    assert key.attrs.get("printed_units", "") == unit


def test_curves_of_one_kind_are_padded_to_the_longest(result: xr.Dataset) -> None:
    nothing_there = [NAN] * 4
    assert result.curve_1_x.values == pytest.approx(np.array([[0, 1, 2, NAN], [5, 6, 7, 8], nothing_there]), nan_ok=True)
    assert result.curve_1_y.values == pytest.approx(10 * result.curve_1_x.values, nan_ok=True)
    assert result.curve_2_y.values == pytest.approx(np.array([[3, 3, 3], nothing_there[:3], nothing_there[:3]]), nan_ok=True)
    assert (result.curve_1_y.attrs["long_name"], result.curve_2_y.attrs["long_name"]) == ("speed", "amplitude")
    units = [result[f"curve_{name}"].attrs["units"] for name in ("1_x", "1_y", "2_y")]
    assert units == ["s", "rad/s", "m"] and "curve_1_x" in result.coords and "curve_3_x" not in result


def test_sentences_common_to_all_are_told_once(result: xr.Dataset) -> None:
    assert result.wucht.warnings == ["all", "says = 0: w", "says = 1: w", "says = 2: v"]
    assert result.wucht.assumed[-1] == "says = 0: x"


def test_one_without_units_beside_others() -> None:
    says = "bare: dimensionless; its numbers have no units and cannot be compared with others"
    assert compare(nothing, of=("a", "bare")).wucht.warnings == [says]
    alone = compare(nothing, nothing, of=("bare",))
    assert alone.wucht.warnings == [] and alone.wucht.dimensionless


# --- curves of a result ---

Variables = Mapping[str, tuple[Any, str]]  # values and dimensions by name


def curve_of(variables: Variables, number: int = 1) -> tuple[Any, Any] | None:
    """A curve of an answer with these variables."""

    def told(a: Answer, _: Reciter) -> None:
        for name, (values, dimensions) in variables.items():
            a.curve(name, np.asarray(values), name, "", dimensions)

    first = compare(told, told)[{"variant": 0}]
    if f"curve_{number}_x" not in first:
        return None
    return numbers(first, f"curve_{number}_x"), numbers(first, f"curve_{number}_y")


def test_branches_are_parts_of_a_curve() -> None:
    """From each to the next there is a gap."""
    x, y, branch = [1.0, 2.0, 3.0, 1.0, 2.0], [5.0, 6.0, 7.0, 8.0, 9.0], [0, 0, 0, 1, 1]
    curve = curve_of({"x": (x, "point"), "y": (y, "point"), "branch": (branch, "point")})
    assert curve == ([1, 2, 3, NAN, 1, 2], [5, 6, 7, NAN, 8, 9])


def test_of_several_bodies_the_first_is_taken_and_directions_follow_each_other() -> None:
    bodies = {"time": ([0.0, 1.0], "time"), "swing": ([[1.0, 2.0], [3.0, 4.0]], "body time")}
    directions = {"x": ([[1.0, 2.0], [4.0, 3.0]], "direction place"), "y": ([[5.0, 6.0], [7.0, 8.0]], "direction place")}
    assert curve_of(bodies | directions) == ([0, 1], [1, 2])
    assert curve_of(bodies | directions, 2) == ([1, 2, NAN, 4, 3], [5, 6, NAN, 7, 8])


@pytest.mark.parametrize("variables", [
    {"x": ([1.0, 2.0], "place")}, {"y": ([1.0, 2.0], "place")}, {"x": ([], "place"), "y": ([], "place")},
    {"x": ([1.0, 2.0], "place"), "y": ([[1.0, 2.0]], "case place")},
    {"x": ([[1.0], [2.0]], "body place"), "y": ([1.0], "place")},
])  # fmt: skip
def test_what_is_no_curve(variables: Variables) -> None:
    """A variable that is not there, that is empty, that is one of several cases, that has no value for each abscissa."""
    assert curve_of(variables) is None


@pytest.mark.parametrize(("stable", "overlapping", "amplitudes"), [
    ([[1, 0], [1, 1]], [0, 0], [5, NAN, NAN, 7, 8]), ([[1, 0], [1, 1]], [0, 1], [5, NAN, NAN, NAN, NAN]),
    ([[0, 0], [0, 0]], [0, 0], [5, 6, NAN, 7, 8]),
])  # fmt: skip
def test_of_configurations_the_stable_ones_are_taken_if_any_is(stable: Any, overlapping: Any, amplitudes: list[float]) -> None:
    of_both = {"y": ([[5.0, 6.0], [7.0, 8.0]], "configuration speed"), "stable": (stable, "configuration speed")}
    curve = curve_of({"x": ([1.0, 2.0], "speed"), **of_both, "overlapping": (overlapping, "configuration")})
    assert curve == ([1, 2, NAN, 1, 2], amplitudes)


def test_a_curve_keeps_its_detail_until_the_run_has_settled() -> None:
    """Of 100,000 samples over 100 s all extremes of the first 1.5 s are kept, and the whole is there."""
    time = np.linspace(0.0, 100.0, 100_001)

    def moving(a: Answer, subject: Reciter) -> None:
        a.number("settling_time", subject.values[SLOPE] or None, "settling time", "s")
        a.curve("time", time, "time", "s")
        a.curve("swing", np.sin(40 * time), "speed", "", "time")

    fine, coarse = compare(moving, vary={SLOPE: [1.0, 0.0]}).curve_1_x.values
    assert np.count_nonzero(fine <= 1.5) == 1501 and np.nanmax(fine) == 100.0 and np.isfinite(fine).sum() < 8000
    assert np.count_nonzero(coarse <= 1.5) < 100


def test_of_equations_the_state_that_is_drawn_is_compared() -> None:
    """The one that is shown; of a run the first one, over time."""

    def branch(a: Answer, _: Reciter) -> None:
        a.attribute(subject="system")
        a.number("show", "y", "state that is drawn")
        a.curve("value", [1.0, 2.0], "parameter mu", "", "point")
        a.curve("state", [[1.0, 2.0], [3.0, 4.0]], "states of the equations", "", "state point")
        a.curve("state_name", ["x", "y"], "names", "", "state", coordinate=True)

    def motion(a: Answer, _: Reciter) -> None:
        a.attribute(subject="system")
        a.curve("time", [0.0, 1.0], "time")
        a.curve("state", ["x", "y"], "state")
        a.curve("states", [[5.0, 6.0], [7.0, 8.0]], "value of the state", "", "state time")

    result = compare(branch, motion)
    labels = [(result[f"curve_{k}_x"].attrs["long_name"], result[f"curve_{k}_y"].attrs["long_name"]) for k in (1, 2)]
    assert labels == [("parameter mu", "y"), ("time", "value of x")]
    assert result.curve_1_y.values[0].tolist() == [3.0, 4.0] and result.curve_2_y.values[1].tolist() == [5.0, 6.0]


# --- variants ---


def test_names_that_distinguish_the_variants() -> None:
    """Of files where there are several, with their folders where those alone differ; numbered where nothing does."""

    def names(*of: str, vary: dict[str, Any] | None = None) -> list[str]:
        return [str(name) for name in compare(nothing, of=of, vary=vary or {})["name"].values]

    for folder in ("x", "y"):
        Path(folder).mkdir()
    assert names("x/a", "b") == ["a", "b"] and names("x/a", "y/a") == ["x/a.toml", "y/a.toml"]
    slopes = {SLOPE: [1e-3, 2e-3, 2e-3]}
    assert names("a", vary=slopes) == ["", "", "(2)"]
    assert names("x/a", "b", vary={SLOPE: [1e-3, 2e-3]}) == ["a", "a", "b", "b"]
    assert names("a", "a") == ["a", "a (2)"]


def test_a_study_that_fails_is_an_answer() -> None:
    """It is refused when it is prepared, or ends with an error."""

    def fails(a: Answer, subject: Reciter) -> None:
        if subject.values[SLOPE] > 1:
            raise RunError("it burst")

    result = compare(fails, vary={SLOPE: [1.0, 2.0], "study.word": ["decent", "unspeakable"]})
    refusal = "a.toml: study.word: given 'unspeakable'; must be decent"
    assert result.failure.values.tolist() == ["", refusal, "it burst", refusal] == ["", *result.sentence.values.tolist()[1:]]
    assert result.outcome.values.tolist() == ["", "failed", "failed", "failed"]
    assert recited == ["a 0", "a 0"], "the others are not begun"
    assert [v["summary"] for v in result.wucht.summary["variants"]] == [{"sentence": "answer 0"}, {}, {}, {}]
    assert result.study.values.tolist() == ["recital"] * 4 and result.machine.values.tolist() == ["a"] * 4
    with refused("study.word", given="unspeakable", file="a.toml"):
        compare(nothing, vary={"study.word": ["unspeakable", "unspeakable"]})


def test_what_was_computed_is_not_computed_again() -> None:
    def stop(share: float, _what: str) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    answers = (passing, captured, bursting)
    part = compare(*answers, folder="out", progress=stop)
    assert part.wucht.sentence == "2 of 3 variants: 1 passed, 1 captured" and not part.wucht.finished
    assert part.sizes["variant"] == 2 and recited == ["a 0", "a 1"]
    whole = compare(*answers, folder="out", resume=True)
    assert recited == ["a 2"] and whole.wucht.finished
    fresh = compare(*answers)
    assert whole.drop_attrs(deep=False).equals(fresh.drop_attrs(deep=False))
    assert whole.wucht.summary == fresh.wucht.summary and whole.wucht.warnings == fresh.wucht.warnings


def test_results_that_cannot_be_compared() -> None:
    made = compare(nothing, nothing, folder="out")
    with refused("study.of", given="out"):
        wucht.compare(["out", "a.toml"])
    made.assign_attrs(study="recitall").to_netcdf("other.nc", engine="h5netcdf")
    with refused("study.kind", "recital", given="recitall", code="unknown-name", file="other.nc"):
        wucht.compare(["other.nc", "a.toml"])


def test_what_is_compared_is_named_by_files() -> None:
    with refused("study.of", given="drum"):
        wucht.run(wucht.Comparison(of=("a.toml", "b.toml")), "drum")
    with refused("study.set", given=3):
        wucht.Comparison.from_table({"kind": "comparison", "of": ["a.toml", "b.toml"], "set": 3})


@pytest.mark.parametrize("of", [["A", "  "], []])
def test_blank_names_are_not_compared(of: Any) -> None:
    with refused("study.of", "catalogue names"):
        wucht.Comparison(of=of)
