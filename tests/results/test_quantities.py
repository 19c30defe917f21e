"""Quantities: variables, summary, units and lines of a report follow from one statement."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.refusals import rejected

from wucht.extending_0_1 import result_dataset
from wucht.results.quantities import Quantity, group, table

POINTS = [
    {"speed": 10.0, "torque": 2.0, "stable": True, "name": "low"},
    {"speed": 20.0, "torque": None, "stable": False, "name": "high"},
]
PARTS = {
    "drive.slope": ("slope", "N m s"), "speed": ("speed", "rad/s"), "torque": ("torque", "N m"),
    "stable": ("whether it is stable", ""), "name": ("name", ""),
}  # fmt: skip
COLUMNS: dict[str, type] = {"speed": float, "torque": float, "stable": np.int8, "name": str}
QUANTITIES = [
    Quantity("speed", [10.0, 20.0], "speed", "rad/s", "speed"),
    Quantity("label", ["a", "b"], "label", "", "speed", coordinate=True),
    Quantity("free_speed", 104.72, "speed without vibration", "rad/s", "", in_summary=True, headline=True),
    Quantity("missing", None, "speed that is not there", "rad/s", "", in_summary=True),
    Quantity(
        "peaks",
        {"velocity": 2e-3, "jerk": 3.0},
        "peaks",
        parts={"velocity": ("v", "m"), "jerk": ("j", "m/rad^3")},
        headline=["jerk"],
    ),
    Quantity("amplitudes", {"x": 2e-6, "y": 0.5}, "amplitudes", "m"),
    Quantity("share", 0.12345, "share"),
    *table("points", POINTS, "points", PARTS, "point", COLUMNS),
]


def made(**more: object) -> xr.Dataset:
    result = result_dataset(QUANTITIES, "it works", ["a warning"], ["an assumption"], engine="compiled", **more)
    return result.assign_attrs(study="test", title="A title", dimensionless=0, finished=1)


def test_the_summary_has_its_keys_in_order() -> None:
    says = made().wucht
    assert list(says.summary) == ["sentence", "free_speed", "missing", "peaks", "amplitudes", "share", "points"]
    assert says.summary["points"] == POINTS
    assert says.summary["missing"] is None
    assert (says.sentence, says.warnings, says.assumed, says.failure) == ("it works", ["a warning"], ["an assumption"], "")


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("points[1].torque", "N m"),
        ("points[0].drive.slope", "N m s"),
        ("peaks.velocity", "m"),
        ("amplitudes.x", "m"),
        ("of_an_earlier_version", ""),
    ],
)
def test_units_by_path(path: str, unit: str) -> None:
    assert made().wucht.unit_at(path) == unit


def test_attributes_are_texts_and_numbers_so_that_anyone_can_write_the_dataset(tmp_path: Path) -> None:
    made().to_netcdf(tmp_path / "own.nc", engine="h5netcdf")
    again = xr.load_dataset(tmp_path / "own.nc", engine="h5netcdf")
    assert again.wucht.summary == made().wucht.summary
    assert json.loads(again.attrs["quantities"])["points"]["parts"]["torque"] == {"what": "torque", "unit": "N m"}


def test_a_name_is_given_once() -> None:
    twice = Quantity("speed", 1.0, "speed", "rad/s")
    with rejected("taken"):
        result_dataset([twice, Quantity("speed", 2.0, "another speed")], "")
    both = result_dataset(
        [twice, Quantity("speed", [1.0], "speeds", "rad/s", "body")], ""
    )  # one in the summary, one in the Dataset
    assert both.wucht.summary["speed"] == 1.0


def test_a_group_is_a_table_of_quantities_that_may_be_tables() -> None:
    inner = Quantity("peaks", {"velocity": 2.0, "speed": 3.0}, "peaks", parts={"velocity": ("v", "m"), "speed": ("s", "m")})
    says = result_dataset([group("motion", [inner, Quantity("speed", 1.0, "speed", "rad/s")], "motion")], "").wucht
    assert says.summary["motion"] == {"peaks": {"velocity": 2.0, "speed": 3.0}, "speed": 1.0}
    assert [says.unit_at(f"motion.{path}") for path in ("speed", "peaks.velocity")] == ["rad/s", "m"]
    assert says.quantities["motion"]["what"] == "motion"
