"""Reports from lines that are stored as data: filled with numbers of the summary, and what is none of them is left out."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht import WuchtError
from wucht.extending import Answer
from wucht.machines.structure import Units
from wucht.results.report import report_of

PLAIN = Units("", "", "", "", "", "", "")


def answer(units: Units | None = None) -> Answer:
    a = Answer(units)
    a.sentence = "it turns"
    a.number("speed", 100.0, "speed", "speed", headline=True)
    a.number("slip", 0.0128, "slip")
    a.number("none", None, "nothing")
    a.number("forces", {"a": 3.0, "b": 4.0}, "forces", "force")
    a.table("jumps", "jumps", speed=([10.0, 20.0], "speed there", "speed"), sense=(["up", "down"], "sense"))
    return a


def stored(lines: Any, verdict: str | None = None, units: Units | None = None) -> xr.Dataset:
    result = answer(units).to_dataset().assign_attrs(title="A machine", dimensionless=int(units is PLAIN))
    return result.assign_attrs(lines=lines if isinstance(lines, str) else json.dumps({"verdict": verdict, "lines": lines}))


def filled(text: str, units: Units | None = None, **texts: str) -> str:
    (line,) = report_of(stored([["x", text, texts]], units=units))[2:]
    assert line.startswith("  x            ")
    return line[15:]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("{speed}", "100 rad/s (955 rpm)"),
        ("{speed:.1f} and {slip:%}", "100.0 rad/s and 1.28 %"),
        ("{forces}", "a: 3 N, b: 4 N"),
        ("{forces.b:.3g}", "4 N"),
        ("{jumps[1].speed} {jumps[1].sense}", "20 rad/s (191 rpm) down"),
    ],
)
def test_fields_are_numbers_of_the_summary_with_their_units(text: str, line: str) -> None:
    assert filled(text) == line


def test_numbers_and_lines_within_a_table_are_its_own() -> None:
    a = answer()
    with a.group("loads", "loads"):
        a.number("largest", 5.0, "largest load", "force")
        with a.group("inner", "of the inside"):
            a.number("torque", 7.0, "torque", "torque")
            a.line("inside", "{torque}, {word}", word="{braces}")
        a.line("loads", "{largest}, {inner.torque}")
    result = a.to_dataset().assign_attrs(title="A machine", dimensionless=0)
    assert result.wucht.summary["loads"] == {"largest": 5.0, "inner": {"torque": 7.0}}
    assert [result.wucht.unit_at(path) for path in ("loads.largest", "loads.inner.torque")] == ["N", "N m"]
    assert [line.split(maxsplit=1)[1] for line in report_of(result)[2:]] == ["7 N m, {braces}", "5 N, 7 N m"]


def test_a_subject_without_units_has_none() -> None:
    assert filled("{speed}, {forces.a}", PLAIN) == "100, 3"


def test_a_line_without_its_number_is_left_out_in_silence() -> None:
    assert report_of(stored([["x", "{none} of {speed}", {}]], "TURNS")) == ["A machine", "verdict: TURNS"]


def test_a_line_is_one_line_of_printable_letters() -> None:
    assert filled("{name} µ", name="a\nverdict: b\x1b[31m") == "a?verdict: b?[31m µ"
    assert len(filled("y" * 10_000)) == 10_000


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (["x", "{speed:.10000000f}", {}], "'.10000000f' is no format"),
        (["x", "{speed:.17g}", {}], "'.17g' is no format"),
        (["x", "{speed!r}", {}], "'speed!r' is no number"),
        (["x", "{speed.__class__}", {}], "'speed.__class__' is no number"),
        (["x", "{jumps[2].speed}", {}], "'jumps[2].speed' is no number"),
        (["x", "{sentence[0]}", {}], "'sentence[0]' is no number"),
        (["x", "y" * 10_001, {}], "a text has at most 10,000 characters"),
        (["x", 3, {}], "a line is a heading"),
    ],
)
def test_what_is_no_line_is_left_out_with_one_note(line: Any, reason: str) -> None:
    lines = report_of(stored([["first", "{speed}", {}], line, ["last", "{slip}", {}]]))
    assert [one.split()[0] for one in lines[2:]] == ["first", "last", "note"]
    assert lines[-1].startswith(f"  note         a line that is left out cannot be read: {reason}")
    assert len(report_of(stored([line] * 3))) == 3, "one note"


def test_a_report_has_at_most_200_lines() -> None:
    line = ["x", "{speed}", {}]
    assert len(report_of(stored([line] * 200))) == 202
    longer = report_of(stored([line] * 201))
    assert len(longer) == 203 and "a line that is left out cannot be read: at most 200 lines" in longer[-1]


@pytest.mark.parametrize("lines", ["[]", '{"lines": 3}', "[" * 10**5])
def test_without_lines_the_main_numbers_are_reported(lines: str) -> None:
    """As of a result of an earlier version, which has no such attribute."""
    result = stored(lines)
    expected = ["A machine", "verdict: it turns", "               speed: 100 rad/s (955 rpm)"]
    assert report_of(result) == expected
    assert len(result.wucht.faults) == 1
    del result.attrs["lines"]
    assert report_of(result.copy()) == expected


def test_a_line_for_each_row_and_paths_within_a_table() -> None:
    a = answer()
    a.line("jump", "{sense} at {speed} of {name}", at="jumps", name="a drum")
    a.line("second", "{speed}", at="jumps[1]")
    lines = report_of(a.to_dataset().assign_attrs(title="", dimensionless=0))[2:]
    assert [line[15:] for line in lines] == [
        "up at 10 rad/s (95 rpm) of a drum", "down at 20 rad/s (191 rpm) of a drum", "20 rad/s (191 rpm)"
    ]  # fmt: skip


def test_columns_of_a_table_are_variables() -> None:
    a = Answer()
    a.table(
        "points", "points", over="point", kinds={"speed": float, "stable": np.int8}, headline=("speed",),
        speed=([1.0, None], "speed", "speed"), stable=([True, False], "stable"), word=(["a", "b"], "word"),
    )  # fmt: skip
    a.table("poles", "poles", over="pole", size=(np.array([2.0, 3.0]), "size", "length"))
    result = a.to_dataset()
    assert result.wucht.summary["points"] == [
        {"speed": 1.0, "stable": True, "word": "a"}, {"speed": None, "stable": False, "word": "b"}
    ]  # fmt: skip
    assert set(result.variables) == {"point_speed", "point_stable", "pole_size"}
    assert result.point_stable.dtype == np.int8 and np.isnan(result.point_speed.values[1])
    assert result.pole_size.dims == ("pole",) and result.pole_size.attrs == {"long_name": "size", "units": "m"}
    assert result.wucht.headlines == ["points.speed"] and result.wucht.unit_at("points[0].speed") == "rad/s"


def test_an_answer_whose_statement_was_stopped_is_stated_anew() -> None:
    calls = list[int]()

    def state(a: Answer) -> None:
        calls.append(1)
        a.number("speed", 100.0, "speed")
        if len(calls) == 1:
            raise KeyboardInterrupt
        a.sentence = "it turns"

    a = Answer(fill=state)
    a.warn("a doubt")
    with pytest.raises(KeyboardInterrupt):
        a.to_dataset()
    result = a.to_dataset()
    assert (result.wucht.summary, result.wucht.warnings) == ({"sentence": "it turns", "speed": 100.0}, ["a doubt"])


def test_a_number_is_stated_once() -> None:
    a = answer()
    a.number("speed", 3.0, "another speed")
    with pytest.raises(WuchtError, match="'speed'"):
        a.to_dataset()


def test_numbers_of_arrays_are_numbers_of_the_summary() -> None:
    a = Answer()
    a.number("count", np.int64(3), "count")
    a.number("shares", np.array([0.5, np.nan]), "shares")
    assert a.to_dataset().wucht.summary == {"sentence": "", "count": 3, "shares": [0.5, None]}
