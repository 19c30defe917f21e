"""Studies in the form of version 0.1: five functions, and the names that they use."""

from __future__ import annotations

import math

import pytest
import xarray as xr

from wucht.extending_0_1 import Quantity, ReportLines, formats, report_lines, result_dataset, table

POINTS = [{"speed": 10.0, "torque": 2.0, "name": "low"}, {"speed": 20.0, "torque": None, "name": "high"}]
PARTS = {"speed": ("speed", "rad/s"), "torque": ("torque", "N m"), "name": ("name", "")}
QUANTITIES = [
    Quantity("free_speed", 104.72, "speed without vibration", "rad/s"),
    Quantity("missing", None, "speed that is not there", "rad/s"),
    Quantity("peaks", {"velocity": 2e-3, "jerk": 3.0}, "peaks", parts={"velocity": ("v", "m"), "jerk": ("j", "m/rad^3")}),
    Quantity("amplitudes", {"x": 2e-6, "y": 0.5}, "amplitudes", "m"),
    Quantity("share", 0.12345, "share"),
    *table("points", POINTS, "points", PARTS),
]


def result(dimensionless: bool = False) -> xr.Dataset:
    return result_dataset(QUANTITIES, "it works").assign_attrs(title="A title", dimensionless=int(dimensionless))


def test_lines_of_a_report_are_written_with_their_units() -> None:
    lines = ReportLines(result())
    lines.add("free", "{free_speed} without vibration")
    lines.add("nothing", "{missing}")  # left out
    lines.add("share", "{share:%} or {share:.4%} or {share}")
    lines.add("jerk", "{peaks.jerk}, {peaks.velocity}")
    lines.add("each", "{amplitudes}")
    lines.add("point", "{speed}: {torque}, {name} {text}", POINTS[0], "points", text="{as it is}")
    assert lines.report("fine") == [
        "A title",
        "verdict: fine",
        "  free         104.72 rad/s (1000 rpm) without vibration",
        "  share        12.3 % or 12.35 % or 0.1235",
        "  jerk         3000 mm/rad³, 2 mm",
        "  each         x: 2 µm, y: 500 mm",
        "  point        10 rad/s (95 rpm): 2 N m, low {as it is}",
    ]


@pytest.mark.parametrize(("speed", "words"), [(-100 * math.pi / 3, "-104.72 rad/s (-1000 rpm)"), (None, "none")])
def test_a_speed_is_stated_in_both_units(speed: float | None, words: str) -> None:
    assert formats(result())[0](speed) == words
    assert formats(result(), "rad")[1](math.pi / 8) == "22.5°"


def test_a_report_of_lines_that_are_written() -> None:
    assert report_lines(result(), "FINE", [("speed", "1"), ("", "2")]) == [
        "A title",
        "verdict: FINE",
        "  speed        1",
        "               2",
    ]
