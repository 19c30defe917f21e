"""Comparisons: the numbers are those of each study alone, what fails stands beside what does not, and resuming."""

from __future__ import annotations

from collections.abc import Callable
from datetime import date, time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests import refusals
from tests.refusals import check_refusal

import wucht as package
from wucht.results.formatting import printed_unit
from wucht.studies.registry import studies
from wucht.studies.study_file import read_comparison

Study = Callable[..., Path]
SHORT = {"study.until": "0.02 s"}
SLOPES, SLOPE = ["0.03 N m s", "0.05 N m s"], "slope of the torque-speed curve, drive"


REFUSED: dict[str, tuple[dict[str, Any], dict[str, list[Any]]]] = {
    "a date": ({}, {"drive.slope": [date(1979, 5, 27), 0.03]}),
    "a time of day": ({}, {"study.start.p1": [0.1, [time(12)]]}),
    "a table of nothing": ({"bogus": {}}, {"drive.slope": [0.03, 0.04]}),
    "far too many": ({}, {"drive.slope": [0.03] * 3000, "p1.mass": [0.1] * 3000}),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_varied_is_refused_at_once(study: Study, name: str) -> None:
    set_, vary = REFUSED[name]
    check_refusal(f"comparison: {name}", lambda: read_comparison([str(study())], set_, vary))


def test_each_variant_is_what_its_study_says_alone(study: Study) -> None:
    """Over a grid of two keys, the last one fastest: numbers, curves, and the values in SI."""
    vary = {"drive.slope": SLOPES, "p1.mass": ["125 g", 0.15]}
    result = package.compare([study()], SHORT, vary)
    assert result.variant.values.tolist() == [
        f"{SLOPE} = {slope} N m s; mass of p1 = {mass} kg" for slope in (0.03, 0.05) for mass in (0.125, 0.15)
    ]  # fmt: skip
    assert result["drive.slope"].values.tolist() == [0.03, 0.03, 0.05, 0.05]
    assert result["p1.mass"].values == pytest.approx([0.125, 0.15, 0.125, 0.15])
    assert (result["p1.mass"].attrs["units"], result.final_speed.attrs["units"]) == ("kg", "rad/s")
    alone = package.run_file(study(), SHORT | {"drive.slope": SLOPES[1], "p1.mass": 0.15})
    entry = result.wucht.summary["variants"][3]
    assert entry["summary"] == alone.wucht.summary
    assert result.final_speed.values[3] == alone.wucht.summary["final_speed"]
    assert result["natural_frequencies.x"].values[3] == alone.wucht.summary["natural_frequencies"]["x"]
    assert np.array_equal(result.curve_1_y.values[3], alone.speed.sel(body="drum").values)
    assert np.array_equal(result.curve_2_y.values[3], alone.amplitude.values)
    assert result.curve_1_x.attrs == alone.time.attrs
    assert result.coords["curve_1_x"].dims == ("variant", "sample_1")
    assert result.coords["variant_number"].values.tolist() == [1, 2, 3, 4]
    speeds = result.wucht.table("variants")["summary.final_speed [rad/s]"]
    assert speeds.tolist() == result.final_speed.values.tolist()
    assert result.wucht.summary["varied"] == {
        "drive.slope": {"what": SLOPE, "unit": "N m s"}, "p1.mass": {"what": "mass of p1", "unit": "kg"},
    }  # fmt: skip
    assert result.wucht.finished and result.wucht.summary["outcomes"] == {"unidentified": 4}


WORDS = {
    "lengths in mm": ({"p1.length": ["104 mm", 0.11]}, "length of p1", ["104 mm", "110 mm"], (1e3, "mm")),
    "as they are written": ({"drive.no_load_speed": ["1000 rpm", "1500rpm"]}, "no-load speed of the drive",
                            ["1000 rpm", "1500 rpm"], (30 / np.pi, "rpm")),
    "a start": ({"study.start.p1": ["10 deg", "20 deg"]}, "angle of p1 to drum at the start", ["10 deg", "20 deg"],
                (180 / np.pi, "deg")),
    "a pair": ({"carrier.stiffness": [["1e5 N/m", 2e5], 1e5]}, "stiffness of the carrier",
               ["[100000, 200000] N/m", "100000 N/m"], (1.0, "")),
    "not allowed": ({"drive.slope": [0.03, "-1 N m s"]}, SLOPE, ["0.03 N m s", "-1 N m s"], (1.0, "N m s")),
    "twice the same": ({"drive.slope": [0.03, 0.03]}, SLOPE, ["0.03 N m s", "0.03 N m s"], (1.0, "N m s")),
}  # fmt: skip


@pytest.mark.parametrize(("vary", "what", "values", "printed"), WORDS.values(), ids=WORDS.keys())
def test_variants_are_called_what_the_engineer_calls_them(
    study: Study, vary: dict[str, list[Any]], what: str, values: list[str], printed: tuple[float, str]
) -> None:
    result = package.compare([study()], SHORT, vary)
    again = "(2); " if values[0] == values[1] else ""
    assert result.variant.values.tolist() == [f"{what} = {values[0]}", f"{again}{what} = {values[1]}"]
    assert result.wucht.title == f"Comparison of study, varied: {what}"
    [path] = vary
    assert result[path].attrs["long_name"] == what
    assert printed_unit(result, path) == (pytest.approx(printed[0]), printed[1])


def test_curves_are_those_of_stable_configurations(study: Study) -> None:
    """Bodies compensate above the resonance alone; below it the amplitude is not theirs there."""
    held = 'start = { p1 = "0.3 rad", p2 = "-0.5 rad" }'
    result = package.compare(
        [study('kind = "run-up"', 'kind = "response"', 'until = "0.5 s"', "", held, "")], {}, {"drive.slope": SLOPES}
    )
    assert result.curve_1_y.attrs["long_name"] == "amplitude of the axis"
    largest = result.curve_1_y.max("sample_1").values
    assert largest == pytest.approx(result.peak_amplitude.values, rel=1e-3) and (largest > 0).all()


def test_files_and_results_side_by_side(study: Study, here: Path) -> None:
    study(name="a.toml")
    study('"9 kg"', '"11 kg"', name="b.toml")
    for name in "ab":
        package.run_file(f"{name}.toml", SHORT, folder=Path(name))
    asked, stored = package.compare(["a.toml", "b.toml"], SHORT), package.compare(["a", "b/result.nc"])
    assert asked.variant.values.tolist() == ["a", "b"]
    assert stored.variant.values.tolist() == ["a", "b"]
    for name in ("final_speed", "peak_amplitude", "curve_1_x", "curve_2_y"):
        assert np.array_equal(asked[name].values, stored[name].values), name
    assert asked.final_speed.values[0] != asked.final_speed.values[1]


def test_what_holds_for_all_is_refused(study: Study) -> None:
    with refusals.refused("machine.drive.slope", given=-1, code="limits"):
        package.compare([study()], SHORT, {"drive.slope": [-1, -2]})
    with refusals.refused("study.start.p9", code="unknown-key", file="study.toml"):
        package.compare([study()], SHORT, {"study.start.p9": [0.1, 0.2]})
    with refusals.refused("study.until", file="study.toml"):
        package.compare([study()], {}, {"study.until": ["1e9 h", "2e9 h"]})


def test_studies_whose_curves_are_others_are_drawn(study: Study) -> None:
    """One over time, one over the speed: each in its own panel."""
    at_rest = study('until = "0.5 s"\nstart = { p1 = "0.3 rad", p2 = "-0.5 rad" }', "")
    result = package.compare([at_rest], {}, {"study.kind": ["coast-down", "torque-balance"]})
    assert result.wucht.warnings == []
    panels = [panel for panel in package.draw(result).axes if panel.get_xlabel().startswith(("time", "speed"))]
    assert [len(panel.lines) for panel in panels] == [1] * len(panels)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [k for k, s in studies().items() if k != "comparison" and s.study.curves])
def test_every_study_has_the_curves_and_numbers_that_it_names(here: Path, kind: str) -> None:
    Path("study.toml").write_text(studies()[kind].template, encoding="utf-8")
    result = package.run_file("study.toml", folder=here / "out")
    one = package.compare(["out", "out/result.nc"])
    spec = studies()[kind].study
    drawn = {n for n in one.variables if str(n).startswith("curve_")}
    assert len(drawn) == 2 * len(spec.curves)
    for name in result.wucht.headlines:  # of a table one of its names, none of which need be there
        first, _, rest = name.partition(".")
        assert first in result.wucht.summary and (name in one or not rest or first == "fractions"), name
    assert package.draw(one) is not None


def test_machines_side_by_side(study: Study, here: Path) -> None:
    """Machines that are in no file: the numbers of the same ones in files, and of variants of them."""
    file = study(name="soft.toml")
    soft = package.load_machine(file)
    stiff = soft.with_values({"carrier.stiffness": "2e5 N/m"})
    settings = SHORT | {"study.start": {"p1": "0.3 rad", "p2": "-0.5 rad"}}
    made = package.compare([soft, file, stiff], settings, {"p1.mass": ["125 g", 0.15]}, folder=here / "out")
    title = soft.title
    assert made["name"].values.tolist() == [title, title, "soft", "soft", f"{title} (2)", f"{title} (2)"]
    assert made["p1.mass"].values == pytest.approx([0.125, 0.15] * 3)
    assert made.final_speed.values[:2].tolist() == made.final_speed.values[2:4].tolist()
    alone = package.run(package.RunUp(until="0.02 s", start=settings["study.start"]), stiff.with_values({"p1.mass": 0.15}))
    assert made.wucht.summary["variants"][5]["summary"] == alone.wucht.summary
    assert made.final_speed.values[5] != made.final_speed.values[3]
    assert "document" not in made.attrs, "no study file could repeat it"
    assert package.report(package.load(here / "out"))[0] == made.attrs["title"]


def test_what_a_machine_in_a_comparison_cannot_be(study: Study) -> None:
    machine = package.load_machine(study())
    with refusals.refused("drive.slop", "drive.slope", given=0.1, file=machine.title):
        package.compare([machine, machine], {"drive.slop": 0.1})
    with refusals.refused("study.of", "wucht.Machine"):
        package.compare([machine, package.RunUp(until=1.0)])  # type: ignore[list-item]
    with refusals.refused("study.of", "1"):
        package.compare(machine)
