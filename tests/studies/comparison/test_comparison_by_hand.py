"""Figures and tables of comparisons that are made by hand: numbers over texts and groups, answers in words, very many."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import answered, drawn, five_functions, variable
from tests.refusals import refused

import wucht
from wucht.errors import InputError
from wucht.plots.style import GREY, line_style
from wucht.studies.comparison.spec import Comparison
from wucht.studies.study_file import read_comparison
from wucht.studies.subjects import subject_of

STUDY = five_functions("comparison")


def comparison(count: int = 2, vary: dict[str, Any] | None = None, curves: int = 0, **more: Any) -> xr.Dataset:
    """vary: (values, words, unit) by path. Other keywords: numbers (values, unit) by name, in the headline."""
    numbers = {k: v for k, v in more.items() if k not in ("names", "sources", "failures", "outcomes")}
    labels, varied = [f"v{k}" for k in range(count)], vary or {}
    names = more.get("names", [""] * count if varied else labels)
    failures = more.get("failures", [""] * count)
    data: dict[str, Any] = {
        "outcome": variable("variant", np.array(more.get("outcomes", [""] * count), str), "outcome"),
        "sentence": variable("variant", np.array([f"answer {k}" for k in range(count)]), "answer in words"),
    }
    data |= {
        name: variable("variant", np.array(values, float), name.replace("_", " "), u) for name, (values, u) in numbers.items()
    }
    for k in range(1, curves + 1):
        x = np.arange(3.0) + 10 * np.arange(count)[:, None]
        data |= {
            f"curve_{k}_x": variable(f"variant sample_{k}", x, f"time {k}", "s"),
            f"curve_{k}_y": variable(
                f"variant sample_{k}", np.where(np.array(failures)[:, None] == "", k * x, np.nan), "speed", "rad/s"
            ),
        }
    coordinates = {
        "variant": variable("variant", np.array(labels), "variant"),
        "name": variable("variant", np.array(names, str), "name"),
        "source": variable("variant", np.array(more.get("sources", ["a"] * count)), "file"),
    } | {path: variable("variant", np.array(values), what, unit) for path, (values, what, unit) in varied.items()}
    summary = {
        "vary": {path: [] for path in varied}, "headline": list(numbers),
        "variants": [{"label": a, "failure": f or None} for a, f in zip(labels, failures, strict=True)],
    }  # fmt: skip
    made = answered(xr.Dataset(data, coordinates), summary, "two of them")
    return made.assign_attrs(title="A comparison", dimensionless=0)


def shown(made: xr.Dataset) -> Figure:
    return drawn("comparison", made)


def points(axis: Any) -> list[tuple[str, list[float], list[float]]]:
    """The lines that join numbers: label, where, and values."""
    joined = [line for line in axis.get_lines() if line.get_color() == GREY]
    return [(str(line.get_label()), list(line.get_xdata()), list(line.get_ydata())) for line in joined]


SLOPE_OF_TWO = {"drive.slope": ([3.0, 1.0], "slope of the drive", "N m s")}
SLOPE = {"drive.slope": ([3.0, 1.0, 2.5], "slope of the drive", "N m s")}


def test_between_numbers_of_balls_there_is_no_line() -> None:
    for path, joined in (("b.count", False), ("drive.slope", True)):
        made = comparison(3, {path: ([4.0, 6.0, 8.0], "a key", "")}, final_speed=([30.0, 10.0, 20.0], "rad/s"))
        (axis,) = shown(made).axes
        (line,) = [line for line in axis.get_lines() if line.get_color() == GREY]
        assert (line.get_linestyle() not in ("None", "")) is joined


def test_runs_are_compared_until_the_last_has_settled() -> None:
    made = comparison(2, SLOPE_OF_TWO, curves=1)
    made["curve_1_x"] = made.curve_1_x.copy(data=[[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]]).assign_attrs(long_name="time")
    for settled, end in (((0.2, 0.7), 1.0), ((0.2, None), 2.0)):
        summary = json.loads(made.attrs["summary"])
        for variant, time in zip(summary["variants"], settled, strict=True):
            variant["summary"] = {"settling_time": time}
        axis = shown(made.assign_attrs(summary=json.dumps(summary))).axes[0]
        assert [line.get_xdata()[-1] for line in axis.get_lines()] == [end, end]


def test_numbers_over_a_key_with_numbers() -> None:
    figure = shown(comparison(3, SLOPE, final_speed=([30.0, 10.0, 20.0], "rad/s")))
    (axis,) = figure.axes
    assert axis.get_xlabel() == "slope of the drive (N·m·s)" and axis.get_ylabel() == "final speed (rad/s)"
    assert [(x, y) for _, x, y in points(axis)] == [([1.0, 2.5, 3.0], [10.0, 20.0, 30.0])]
    marks = {line.get_color(): (line.get_xdata()[0], line.get_ydata()[0]) for line in axis.get_lines()[1:]}
    assert marks == {line_style(k)["color"]: at for k, at in enumerate([(3.0, 30.0), (1.0, 10.0), (2.5, 20.0)])}
    assert {line.get_linestyle() for line in axis.get_lines()[1:]} == {"None"}
    assert axis.get_lines()[0].get_linestyle() == "-" and axis.get_legend() is None


def test_whole_numbers_have_whole_ticks() -> None:
    for values, same in (([1.0, 2.0, 3.0], True), ([1.0, 1.25, 1.5], False)):
        (axis,) = shown(comparison(3, {"points": (values, "points", "")}, final_speed=([3.0, 1.0, 2.0], ""))).axes
        ticks = [t for t in axis.get_xticks() if values[0] <= t <= values[-1]]
        assert (list(ticks) == [float(round(t)) for t in ticks]) is same


def test_numbers_over_a_key_with_texts() -> None:
    vary = {"study.model": (["slow", "full", "slow"], "model", ""), "p1.mass": ([1.0, 1.0, 2.0], "mass of p1", "kg")}
    (axis,) = shown(comparison(3, vary, final_speed=([30.0, 10.0, 20.0], "rad/s"))).axes
    assert [t.get_text() for t in axis.get_xticklabels()] == ["slow", "full"]
    assert axis.get_xlabel() == "model" and axis.get_xlim() == (-0.5, 1.5)
    assert points(axis) == [("1 kg", [0.0, 1.0], [30.0, 10.0]), ("2 kg", [0.0], [20.0])]
    assert {line.get_linestyle() for line in axis.get_lines()} == {"None"}
    assert axis.get_legend().get_title().get_text() == "mass of p1"
    assert [line.get_marker() for line in axis.get_lines() if line.get_color() == GREY] == ["o", "s"]


def test_numbers_over_the_variants_themselves() -> None:
    (axis,) = shown(comparison(3, final_speed=([30.0, 10.0, 20.0], "rad/s"))).axes
    assert axis.get_xlabel() == "variant" and [t.get_text() for t in axis.get_xticklabels()] == ["v0", "v1", "v2"]
    assert [(x, y) for _, x, y in points(axis)] == [([0.0, 1.0, 2.0], [30.0, 10.0, 20.0])]
    (many,) = shown(comparison(9, final_speed=(list(range(9)), "rad/s"))).axes
    assert "v0" not in [t.get_text() for t in many.get_xticklabels()] and many.get_xlim() == (-0.5, 8.5)
    (eight,) = shown(comparison(8, final_speed=(list(range(8)), "rad/s"))).axes
    assert [t.get_text() for t in eight.get_xticklabels()] == [f"v{k}" for k in range(8)]
    words = {"study.model": ([f"abcd {k}" for k in range(8)], "model", "")}
    (narrow,) = shown(comparison(8, words, final_speed=(list(range(8)), "rad/s"))).axes
    assert [t.get_text() for t in narrow.get_xticklabels()] == [f"abcd\n{k}" for k in range(8)]


def test_groups_are_files_and_values_of_other_keys() -> None:
    vary = {"a": ([1.0, 2.0] * 4, "a", ""), "b": ([0.0, 0.0, 1.0, 1.0] * 2, "b", "")}
    sources = ["one"] * 4 + ["two"] * 4
    made = comparison(8, vary, names=["x"] * 4 + ["y"] * 4, sources=sources, final_speed=(list(range(8)), ""))
    (axis,) = shown(made).axes
    told = [(name, y) for name, _, y in points(axis)]
    assert told == [("x; 0", [0.0, 1.0]), ("x; 1", [2.0, 3.0]), ("y; 0", [4.0, 5.0]), ("y; 1", [6.0, 7.0])]
    assert [line.get_marker() for line in axis.get_lines() if line.get_color() == GREY] == list("os^D")


def test_curves_and_numbers_side_by_side() -> None:
    made = comparison(
        3, SLOPE, 3, outcomes=["passed", "", "failed"], failures=["", "", "why"], final_speed=([3, 1, np.nan], "rad/s")
    )
    first, second, numbers = shown(made).axes
    assert [(line.get_label(), list(line.get_ydata())) for line in first.get_lines()] == [
        ("3 N m s: passed", [0.0, 1.0, 2.0]), ("1 N m s", [10.0, 11.0, 12.0]),
    ]  # fmt: skip
    assert [list(line.get_ydata()) for line in second.get_lines()] == [[0.0, 2.0, 4.0], [20.0, 22.0, 24.0]]
    assert (second.get_xlabel(), second.get_ylabel()) == ("time 2 (s)", "speed (rad/s)")
    assert numbers.get_ylabel() == "final speed (rad/s)"
    (legend,) = shown(made).legends
    assert legend.get_title().get_text() == "slope of the drive"
    assert len(shown(comparison(2, None, 1, final_speed=([1.0, 2.0], "rad/s"))).axes) == 1, "numbers are told in the table"


def test_many_variants_are_counted() -> None:
    for count, last in ((14, "v13"), (15, "and 2 more")):
        (axis,) = shown(comparison(count, None, 1)).axes
        names = [str(line.get_label()) for line in axis.get_lines() if not str(line.get_label()).startswith("_")]
        assert len(names) == 14 and names[-1] == last and names[12] == "v12"
        assert len(axis.get_lines()) == count


def test_answers_that_are_no_numbers_are_written() -> None:
    (axis,) = shown(comparison(2)).axes
    (text,) = axis.texts
    assert text.get_text() == "v0: answer 0\nv1: answer 1" and not axis.axison and not text.get_parse_math()
    heights = []
    for count, last in ((8, "v7: answer 7"), (9, "and 1 more"), (10, "and 2 more")):
        figure = shown(comparison(count))
        lines = figure.axes[0].texts[0].get_text().splitlines()
        assert len(lines) == min(count, 9) and lines[-1] == last and lines[7] == "v7: answer 7"
        heights.append(figure.get_figheight())
    assert heights[0] < heights[1] == heights[2]
    long = comparison(1).assign(sentence=variable("variant", np.array(["word " * 60]), "answer in words"))
    lines = shown(long).axes[0].texts[0].get_text().splitlines()
    assert len(lines) == 3 and max(map(len, lines)) < 110 and " ".join(lines).split() == ["v0:", *["word"] * 60]


# --- the report ---


def test_the_table() -> None:
    made = comparison(
        3, SLOPE, outcomes=["passed", "passed", "captured"], failures=["", "", "why"],
        same=([1.0, 1.0, 1.0], "m"), final_speed=([30.0, 10.0, np.nan], "rad/s"),
    )  # fmt: skip
    assert STUDY.report(made) == [
        "A comparison",
        "verdict: two of them",
        "   slope of the            final speed",
        "  drive (N·m·s)  outcome       (rad/s)  same (mm)",
        "              3  passed             30       1000",
        "              1  passed             10       1000",
        "            2.5  captured                    1000",
        "  v2: why",
    ]


def test_answers_in_words_where_there_is_no_number() -> None:
    assert STUDY.report(comparison(2))[2:] == ["  v0  answer 0", "  v1  answer 1"]
    many = STUDY.report(comparison(62))
    assert many[-1] == "  and 2 more" and many[-2] == "  v59  answer 59"


# --- refusals ---


def test_what_is_compared_is_named_by_files() -> None:
    with refused("study.of", given="drum"):
        subject_of(Comparison(of=("a.toml", "b.toml"))).describe("drum")
    with pytest.raises(InputError, match=r"study\.set: given 3; must be a table: set = \{ PATH = VALUE, \.\.\. \}"):
        Comparison.from_table({"kind": "comparison", "of": ["a.toml", "b.toml"], "set": 3})


def test_a_comparison_names_no_machine(here: Any, wucht: Any) -> None:
    for table, key in (("[machine]\nuse = 'a'", "machine"), ("[system]\nx = 'a'", "system")):
        (here / "c.toml").write_text(f"{table}\n[study]\nkind = 'comparison'\nof = ['a.toml']\n", encoding="utf-8")
        done = wucht("run", "c.toml", "--json")
        assert done.code == 2 and json.loads(done.out)["key"] == key


def test_results_that_cannot_be_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    made = comparison(2)
    monkeypatch.setattr("wucht.studies.comparison.variants.load_result", lambda _: made.assign_attrs(study="comparison"))
    with refused("study.of", given="c.nc"):
        read_comparison(["c.nc", "d.nc"])
    monkeypatch.setattr("wucht.studies.comparison.variants.load_result", lambda _: made.assign_attrs(study="sweeep"))
    with pytest.raises(InputError, match=r"^c\.nc: study\.kind: given 'sweeep'"):
        read_comparison(["c.nc", "d.nc"])


@pytest.mark.parametrize("of", [["A", "  "], ["A", ""], [], "A"])
def test_blank_names_are_not_compared(of: Any) -> None:
    with refused("study.of", "catalogue names"):
        Comparison(of=of)


def test_a_comparison_begins_anew_unless_it_is_to_resume(tmp_path: Path) -> None:
    short = {"study.until": "0.05 s"}
    wucht.compare(["drozdetskaya-2020/r1"], short, {"p1.damping": ["0.1 N m s", "0.2 N m s"]}, folder=tmp_path)
    other = wucht.compare(["drozdetskaya-2020/r1"], short, {"p2.damping": ["0.1 N m s", "0.2 N m s"]}, folder=tmp_path)
    assert list(other.wucht.summary["varied"]) == ["p2.damping"]
    with refused("--resume", code="other-question"):
        wucht.compare(["drozdetskaya-2020/r1"], short, {"p1.damping": ["0.2 N m s", "0.3 N m s"]}, folder=tmp_path, resume=True)
