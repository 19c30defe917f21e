"""Figures and tables of comparisons of recited answers: numbers over texts and groups, answers in words, very many."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.studies.comparison.recital import Reciter, Say, compare, nothing, speed

import wucht
from wucht import RunError
from wucht.extending import Answer
from wucht.plots.style import GREY, line_style

pytestmark = pytest.mark.usefixtures("recital")
SLOPE, MASS = "drive.slope", "p1.mass"
SLOPES = {SLOPE: [3.0, 1.0, 2.5]}
SPEEDS = {3.0: 30.0, 1.0: 10.0, 2.5: 20.0}


def speed_of_slope(a: Answer, subject: Reciter) -> None:
    speed(SPEEDS[subject.values[SLOPE]])(a, subject)


def files(count: int) -> tuple[str, ...]:
    return tuple(f"v{k}" for k in range(count))


def points(axis: Any) -> list[tuple[str, list[float], list[float]]]:
    """The lines that join numbers: label, where, and values."""
    joined = [line for line in axis.get_lines() if line.get_color() == GREY]
    return [(str(line.get_label()), list(line.get_xdata()), list(line.get_ydata())) for line in joined]


def tick_texts(axis: Any) -> list[str]:
    return [text.get_text() for text in axis.get_xticklabels()]


def test_between_numbers_of_balls_there_is_no_line() -> None:
    for path, joined in (("b.count", False), (SLOPE, True)):
        (axis,) = wucht.draw(compare(speed(3.0), vary={path: [4.0, 6.0, 8.0]})).axes
        (line,) = [line for line in axis.get_lines() if line.get_color() == GREY]
        assert (line.get_linestyle() not in ("None", "")) is joined


def test_runs_are_compared_until_the_last_has_settled() -> None:
    def told(a: Answer, subject: Reciter) -> None:
        a.number("settling_time", subject.values[SLOPE] or None, "settling time", "s")
        a.curve("time", [0.0, 1.0, 2.0], "time", "s")
        a.curve("swing", [0.0, 1.0, 2.0], "speed", "", "time")

    for settled, end in (([0.2, 0.7], 1.0), ([0.2, 0.0], 2.0)):
        axis = wucht.draw(compare(told, vary={SLOPE: settled})).axes[0]
        assert [line.get_xdata()[-1] for line in axis.get_lines()] == [end, end]


def test_numbers_over_a_key_with_numbers() -> None:
    (axis,) = wucht.draw(compare(speed_of_slope, vary=SLOPES)).axes
    assert axis.get_xlabel() == "slope of the drive (N·m·s)" and axis.get_ylabel() == "final speed (rad/s)"
    assert [(x, y) for _, x, y in points(axis)] == [([1.0, 2.5, 3.0], [10.0, 20.0, 30.0])]
    marks = {line.get_color(): (line.get_xdata()[0], line.get_ydata()[0]) for line in axis.get_lines()[1:]}
    assert marks == {line_style(k)["color"]: at for k, at in enumerate([(3.0, 30.0), (1.0, 10.0), (2.5, 20.0)])}
    assert {line.get_linestyle() for line in axis.get_lines()[1:]} == {"None"}
    assert axis.get_lines()[0].get_linestyle() == "-" and axis.get_legend() is None


def test_whole_numbers_have_whole_ticks() -> None:
    for values, same in (([1.0, 2.0, 3.0], True), ([1.0, 1.25, 1.5], False)):
        (axis,) = wucht.draw(compare(speed(3.0), vary={"b.turns": values})).axes
        ticks = [t for t in axis.get_xticks() if values[0] <= t <= values[-1]]
        assert (list(ticks) == [float(round(t)) for t in ticks]) is same


def test_numbers_over_a_key_with_texts() -> None:
    def told(a: Answer, subject: Reciter) -> None:
        speed(10.0 * subject.values[MASS])(a, subject)

    (axis,) = wucht.draw(compare(told, vary={"study.word": ["slow", "full"], MASS: [1.0, 2.0]})).axes
    assert tick_texts(axis) == ["slow", "full"] and axis.get_xlabel() == "word" and axis.get_xlim() == (-0.5, 1.5)
    assert points(axis) == [("1 kg", [0.0, 1.0], [10.0, 10.0]), ("2 kg", [0.0, 1.0], [20.0, 20.0])]
    assert {line.get_linestyle() for line in axis.get_lines()} == {"None"}
    assert axis.get_legend().get_title().get_text() == "mass of p1"
    assert [line.get_marker() for line in axis.get_lines() if line.get_color() == GREY] == ["o", "s"]


def test_numbers_over_the_variants_themselves() -> None:
    (axis,) = wucht.draw(compare(speed(30.0), speed(10.0), speed(20.0), of=files(3))).axes
    assert axis.get_xlabel() == "variant" and tick_texts(axis) == ["v0", "v1", "v2"]
    assert [(x, y) for _, x, y in points(axis)] == [([0.0, 1.0, 2.0], [30.0, 10.0, 20.0])]
    (many,) = wucht.draw(compare(speed(1.0), of=files(9))).axes
    assert "v0" not in tick_texts(many) and many.get_xlim() == (-0.5, 8.5)
    (eight,) = wucht.draw(compare(speed(1.0), of=files(8))).axes
    assert tick_texts(eight) == list(files(8))
    (narrow,) = wucht.draw(compare(speed(1.0), vary={"study.word": [f"abcd {k}" for k in range(8)]})).axes
    assert tick_texts(narrow) == [f"abcd\n{k}" for k in range(8)]


def test_groups_are_files_and_values_of_other_keys() -> None:
    def told(a: Answer, subject: Reciter) -> None:
        slope, mass = subject.values[SLOPE], subject.values[MASS]
        speed(slope + 10 * mass + 100 * (subject.title == "y"))(a, subject)

    (axis,) = wucht.draw(compare(told, of=("x", "y"), vary={SLOPE: [1.0, 2.0], MASS: [0.0, 1.0]})).axes
    assert [(name, y) for name, _, y in points(axis)] == [
        ("x; 0 kg", [1.0, 2.0]), ("x; 1 kg", [11.0, 12.0]), ("y; 0 kg", [101.0, 102.0]), ("y; 1 kg", [111.0, 112.0]),
    ]  # fmt: skip
    assert [line.get_marker() for line in axis.get_lines() if line.get_color() == GREY] == list("os^D")


def curves(a: Answer, subject: Reciter) -> None:
    """Three; of the first slope with an outcome, of the third one none."""
    slope = subject.values[SLOPE]
    if slope == SLOPES[SLOPE][2]:
        raise RunError("why")
    if slope == SLOPES[SLOPE][0]:
        a.number("outcome", "passed", "outcome")
    for name, of in (("x", "y"), ("u", "w")):
        a.curve(name, np.arange(3.0), f"{name} axis", "s")
        a.curve(of, (1 if of == "y" else 2) * (np.arange(3.0) + 10 * (slope == 1.0)), "speed", "rad/s", name)
    a.curve("time", np.arange(3.0), "time", "s")
    a.curve("sway", np.arange(3.0), "amplitude", "m", "time")
    speed_of_slope(a, subject)


def test_curves_and_numbers_side_by_side() -> None:
    result = compare(curves, vary=SLOPES)
    figure = wucht.draw(result)
    time, first, numbers = figure.axes
    assert [line.get_label() for line in time.get_lines()] == ["3 N m s: passed", "1 N m s"]
    assert [(line.get_label(), list(line.get_ydata())) for line in first.get_lines()] == [
        ("3 N m s: passed", [0.0, 1.0, 2.0]), ("1 N m s", [10.0, 11.0, 12.0]),
    ]  # fmt: skip
    assert (first.get_xlabel(), first.get_ylabel()) == ("x axis (s)", "speed (rad/s)")
    assert numbers.get_ylabel() == "final speed (rad/s)" and "curve_3_y" in result
    (legend,) = figure.legends
    assert legend.get_title().get_text() == "slope of the drive"

    def one_curve(a: Answer, _: Reciter) -> None:
        a.curve("x", np.arange(3.0), "x axis")
        a.curve("y", np.arange(3.0), "speed", "rad/s", "x")
        speed(1.0)(a, _)

    assert len(wucht.draw(compare(one_curve, of=files(2))).axes) == 1, "numbers are told in the table"
    for count, last in ((14, "v13"), (15, "and 2 more")):
        (axis,) = wucht.draw(compare(one_curve, of=files(count))).axes
        names = [str(line.get_label()) for line in axis.get_lines() if not str(line.get_label()).startswith("_")]
        assert len(names) == 14 and names[-1] == last and names[12] == "v12"
        assert len(axis.get_lines()) == count


def test_answers_that_are_no_numbers_are_written() -> None:
    (axis,) = wucht.draw(compare(nothing, nothing, of=files(2))).axes
    (text,) = axis.texts
    assert text.get_text() == "v0: answer 0\nv1: answer 1" and not axis.axison and not text.get_parse_math()
    heights = []
    for count, last in ((8, "v7: answer 0"), (9, "and 1 more"), (10, "and 2 more")):
        figure = wucht.draw(compare(nothing, of=files(count)))
        lines = figure.axes[0].texts[0].get_text().splitlines()
        assert len(lines) == min(count, 9) and lines[-1] == last and lines[7] == "v7: answer 0"
        heights.append(figure.get_figheight())
    assert heights[0] < heights[1] == heights[2]

    def long(a: Answer, _: Reciter) -> None:
        a.sentence = " ".join(["word"] * 60)

    lines = wucht.draw(compare(long, nothing, of=files(2))).axes[0].texts[0].get_text().splitlines()
    assert len(lines) == 4 and max(map(len, lines)) < 110 and " ".join(lines[:3]).split() == ["v0:", *["word"] * 60]


# --- the report ---


def test_the_table() -> None:
    def told(a: Answer, subject: Reciter) -> None:
        slope = subject.values[SLOPE]
        a.number("outcome", "captured" if slope == SLOPES[SLOPE][2] else "passed", "outcome")
        a.number("same", 1.0, "same", "m", headline=True)
        speed(SPEEDS[slope] if slope != SLOPES[SLOPE][2] else None)(a, subject)
        if slope == SLOPES[SLOPE][2]:
            a.failure = "why"

    assert wucht.report(compare(told, vary=SLOPES)) == [
        "Comparison of a, varied: slope of the drive",
        "verdict: 3 variants: 2 passed, 1 captured",
        "   slope of the            final speed",
        "  drive (N·m·s)  outcome       (rad/s)  same (mm)",
        "              3  passed             30       1000",
        "              1  passed             10       1000",
        "            2.5  captured                    1000",
        "  slope of the drive = 2.5 N·m·s: why",
    ]


@pytest.mark.parametrize(("values", "is_last"), [
    ([760.89, 760.891], True), ([760.8, 760.89], False), ([1.0, None], False), ([-1.0, -1.0], True), ([0.0, 0.0], True),
])  # fmt: skip
def test_numbers_that_are_the_same_as_they_are_printed_come_last(values: list[float | None], is_last: bool) -> None:
    def told(value: float | None, other: float) -> Say:
        return lambda a, _: (a.number("first", value, "first", headline=True), a.number("last", other, "last", headline=True))

    heads = wucht.report(compare(told(values[0], 1.0), told(values[1], 2.0)))[2].split()
    assert heads == (["says", "last", "first"] if is_last else ["says", "first", "last"])


def test_most_numbers_in_a_row() -> None:
    def told(a: Answer, _: Reciter) -> None:
        for k in range(7):
            a.number(f"n{k}", float(k), "number", headline=True)

    assert wucht.report(compare(told, told))[2].split() == ["says", *(f"n{k}" for k in range(6))]


def test_answers_in_words_where_there_is_no_number() -> None:
    assert wucht.report(compare(nothing, nothing, of=files(2)))[2:] == ["  v0  answer 0", "  v1  answer 1"]
    many = wucht.report(compare(nothing, of=files(62)))
    assert many[-2:] == ["  v59  answer 0", "  and 2 more"]
    assert not any("more" in line for line in wucht.report(compare(nothing, of=files(60))))
    names = [line.split()[0] for line in wucht.report(compare(nothing, of=("a" * 60, "b" * 61)))[2:]]
    assert names == ["a" * 60, f"{'b' * 57}..."]
