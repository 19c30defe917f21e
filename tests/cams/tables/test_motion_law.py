"""The law of a cam file: its units, the arcs on which it rests, and its extremes, against closed forms."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.laws.synthesis import Band, Cap
from wucht.cams.tables.kinds_of_law import STANDARD, PointsTable, _line_number
from wucht.cams.tables.motion_law import MotionLaw, SeriesMotionLaw, read_output, unit_of_output
from wucht.numerics.fourier_series import FourierSeries
from wucht.schema import validate_table


@pytest.mark.parametrize(
    ("unit", "value", "order", "expected"),
    [
        ("rad", "180 deg", 0, math.pi),
        ("rad", "180 deg/rad", 1, math.pi),
        ("rad", "180 deg/rad^2", 2, math.pi),
        ("m", "12 mm/rad^3", 3, 0.012),
        ("m", "12 mm", 2, 0.012),
        ("m", 0.5, 1, 0.5),
        ("rad", 2.5, 0, 2.5),
    ],
)
def test_derivatives_may_omit_the_cam_angle(unit: str, value: float | str, order: int, expected: float) -> None:
    assert read_output(unit, value, "law.x", order) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("unit", "value", "order"),
    [("m", "12 mm/rad^2", 1), ("m", "12 mm/rad", 0), ("rad", "deg/rad^3", 2), ("m", "12 mm/s", 1), ("rad", "1 rad/s", 0)],
)
def test_the_power_of_the_cam_angle_is_the_order(unit: str, value: str, order: int) -> None:
    with refused("law.x", given=value):
        read_output(unit, value, "law.x", order)


def test_the_unit_of_the_output_is_that_of_its_first_quantity() -> None:
    assert unit_of_output([("a", 1.0), ("b", "3 mm"), ("c", 2.0)], None) == "m"
    assert unit_of_output([("a", 1.0), ("b", "3 deg/rad^2")], None) == "rad"
    assert unit_of_output([("b", "3°")], None) == "rad"
    assert unit_of_output([("a", 1.0)], None) == unit_of_output([], None) == "rad"
    assert unit_of_output([("a", 1.0)], "m") == "m"
    with refused("b", given="3 kg"):
        unit_of_output([("b", "3 kg")], None)
    with refused("c", given="3 deg", code="dimension"):
        unit_of_output([("b", "3 mm"), ("c", "3 deg")], None)


def test_arcs_whose_band_is_at_most_a_tenth_of_the_stroke_are_dwells() -> None:
    """The stroke of -0.3 cos phi is 0.6."""
    law = FourierSeries.of(0.0, [-0.3])
    narrow, wide = Band("narrow", 0, 0.1, 0.4, 0.0, 0.0599), Band("wide", 0, 0.1, 0.4, 0.0, 0.0601)
    velocity, point = Band("velocity", 1, 0.1, 0.4, 0.0, 0.01), Band("point", 0, 0.4, 0.4, 0.0, 0.01)
    motion = MotionLaw(law, "m", 1, (wide, velocity, narrow, point, Cap("cap", 1, 0.2)))
    assert motion.dwells == (narrow,)


def test_extremes_on_an_arc() -> None:
    """-0.3 cos phi on a quarter of a turn, and at a point; its velocity 0.3 sin phi."""
    law = FourierSeries.of(0.0, [-0.3])
    for motion in (MotionLaw(law, "m"), SeriesMotionLaw(law, "m", 1)):
        assert motion.extremes(Band("", 0, 0.0, math.pi / 2, 0.0, 1.0)) == pytest.approx((-0.3, 0.0), abs=1e-12)
        assert motion.extremes(Band("", 1, math.pi / 4, math.pi, 0.0, 1.0)) == pytest.approx((0.0, 0.3), abs=1e-6)
        assert motion.extremes(Band("", 0, 1.0, 1.0, 0.0, 1.0)) == pytest.approx((-0.3 * math.cos(1.0),) * 2)


def test_a_standard_law_of_a_file() -> None:
    kinds = {table.kind: table for table in STANDARD}  # type: ignore[attr-defined]
    entries = {"stroke": "20 mm", "rise": ["0 deg", "90 deg"], "return": ["180 deg", "360 deg"]}
    table = validate_table(kinds["3-4-5"], entries, "law")
    motion = table.make_motion_law("m")
    assert list(table.output_values()) == [("law.stroke", "20 mm")] and motion.unit == "m"
    at = np.radians([0.0, 45.0, 90.0, 135.0, 180.0, 270.0])
    assert motion.function(at) == pytest.approx([0.0, 0.01, 0.02, 0.02, 0.02, 0.01], abs=1e-15)
    half = validate_table(kinds["simple-harmonic"], entries, "law").make_motion_law("m").function(math.pi / 8)
    assert half == pytest.approx(0.02 * (1 - math.cos(math.pi / 4)) / 2)
    spline = (
        validate_table(kinds["cubic-spline"], entries | {"points": [[0.5, 0.25]]}, "law")
        .make_motion_law("m")
        .function(math.pi / 4)
    )
    assert spline == pytest.approx(0.005), "through its point"


def test_a_motion_by_points_of_a_file(tmp_path: Path) -> None:
    rows = [(k * 45, 10 - 10 * math.cos(math.radians(45 * k))) for k in range(8)]
    text = "angle (deg),lift (mm)\n" + "".join(f"{angle},{lift:.9f}\n" for angle, lift in rows)
    (tmp_path / "lift.csv").write_text(text, encoding="utf-8")
    for unit in ("m", None):
        entries = PointsTable.with_file_contents({"file": "lift.csv", "degree": 3}, tmp_path, unit)
        assert set(entries) == {"points", "unit", "degree"} and entries["unit"] == "m"
        table = validate_table(PointsTable, dict(entries), "law")
        assert table.stated_unit == "m" and table.make_motion_law("m").function(math.pi / 4) == pytest.approx(rows[1][1] / 1e3)
    with refused("law.file", given="lift.csv"):
        PointsTable.with_file_contents({"file": "lift.csv"}, tmp_path, "rad")
    with refused("law.file", given=" "):
        PointsTable.with_file_contents({"file": " "}, tmp_path, "rad")
    with refused("law.file", given="lift.csv"):
        PointsTable.with_file_contents({"file": "lift.csv", "points": []}, tmp_path, "m")
    assert PointsTable.with_file_contents({"points": 1}, tmp_path, "m") == {"points": 1}
    assert (_line_number("line 12: no number"), _line_number("the file")) == (12, 0)
