"""Figures and tables of comparisons of recited answers: numbers over texts and groups, answers in words, very many."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.studies.comparison.recital import Reciter, Say, compare, nothing, speed

import wucht
from wucht import RunError
from wucht.extending import Answer
from wucht.plots.style import GREY

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


def test_groups_are_files_and_values_of_other_keys() -> None:
    def told(a: Answer, subject: Reciter) -> None:
        slope, mass = subject.values[SLOPE], subject.values[MASS]
        speed(slope + 10 * mass + 100 * (subject.title == "y"))(a, subject)

    (axis,) = wucht.draw(compare(told, of=("x", "y"), vary={SLOPE: [1.0, 2.0], MASS: [0.0, 1.0]})).axes
    assert [(name, y) for name, _, y in points(axis)] == [
        ("x; 0 kg", [1.0, 2.0]), ("x; 1 kg", [11.0, 12.0]), ("y; 0 kg", [101.0, 102.0]), ("y; 1 kg", [111.0, 112.0]),
    ]  # fmt: skip


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
    time, first, numbers = wucht.draw(compare(curves, vary=SLOPES)).axes
    assert [line.get_label() for line in time.get_lines()] == ["3 N m s: passed", "1 N m s"]
    assert [(line.get_label(), list(line.get_ydata())) for line in first.get_lines()] == [
        ("3 N m s: passed", [0.0, 1.0, 2.0]), ("1 N m s", [10.0, 11.0, 12.0]),
    ]  # fmt: skip
    assert (first.get_xlabel(), first.get_ylabel()) == ("x axis (s)", "speed (rad/s)")
    assert numbers.get_ylabel() == "final speed (rad/s)"


@pytest.mark.parametrize("count", [2, 8, 9, 15, 62])
def test_answers_in_words_and_in_numbers_over_their_names(count: int) -> None:
    """However many there are."""
    words, values = compare(nothing, of=files(count)), compare(speed(30.0), speed(10.0), of=files(count))
    told = wucht.report(words)[2:]
    assert [line.split() for line in told[:2]] == [["v0", "answer", "0"], ["v1", "answer", "0"]]
    assert len(told) == min(count, 61)
    (axis,) = wucht.draw(words).axes
    assert axis.texts[0].get_text().startswith("v0: answer 0\nv1: answer 0") and not axis.axison
    (axis,) = wucht.draw(values).axes
    assert [(x, y) for _, x, y in points(axis)] == [(list(range(count)), [30.0, *[10.0] * (count - 1)])]
    assert ("v0" in [text.get_text() for text in axis.get_xticklabels()]) is (count < 9)


@pytest.mark.parametrize(("path", "joined"), [("b.count", False), (SLOPE, True)])
def test_between_numbers_of_balls_there_is_no_line(path: str, joined: bool) -> None:
    (axis,) = wucht.draw(compare(speed(3.0), vary={path: [4.0, 6.0, 8.0]})).axes
    (line,) = [line for line in axis.get_lines() if line.get_color() == GREY]
    assert (line.get_linestyle() not in ("None", "")) is joined


# --- the report ---


@pytest.mark.parametrize(("values", "is_last"), [
    ([760.89, 760.891], True), ([760.8, 760.89], False), ([1.0, None], False), ([-1.0, -1.0], True), ([0.0, 0.0], True),
])  # fmt: skip
def test_numbers_that_are_the_same_as_they_are_printed_come_last(values: list[float | None], is_last: bool) -> None:
    def told(value: float | None, other: float) -> Say:
        return lambda a, _: (a.number("first", value, "first", headline=True), a.number("last", other, "last", headline=True))

    heads = wucht.report(compare(told(values[0], 1.0), told(values[1], 2.0)))[2].split()
    assert heads == (["says", "last", "first"] if is_last else ["says", "first", "last"])
