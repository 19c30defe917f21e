"""The figure of a coast-down: panels, labels, marks."""

from __future__ import annotations

import math

import pytest
import xarray as xr

from wucht.files.catalogue import load_machine
from wucht.studies.coast_down import CoastDown
from wucht.studies.runner import draw, run

FIGURE_7 = "sperling-vibration/figure-7"


@pytest.fixture(scope="module")
def coasted() -> xr.Dataset:
    start = {"disc": {"angle": math.pi / 2, "speed": 1.0}, "s1": 0.0, "s2": 0.0}
    return run(CoastDown(until=300.0, start=start), load_machine(FIGURE_7))


def _labels(axis: object) -> list[str]:
    return [t.get_text() for t in axis.get_legend().get_texts()]  # type: ignore[attr-defined]


def test_a_coast_down_on_a_fixed_axis_has_two_panels(coasted: xr.Dataset) -> None:
    speed, energy = draw(coasted).axes
    assert speed.get_ylabel() == "speed of the rotor (rad/s)"
    assert energy.get_yscale() == "log"
    assert energy.get_xlabel() == "time (s)"
    assert "turns back" in _labels(speed)


def test_a_coast_down_on_a_carrier_has_three() -> None:
    result = run(CoastDown(until=100.0), load_machine("drozdetskaya-2020/table-3.1-laval"))
    speed, amplitude, _ = draw(result).axes
    assert amplitude.get_ylabel() == "amplitude of the axis"
    assert "natural frequency" in _labels(speed)
