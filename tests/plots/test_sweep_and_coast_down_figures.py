"""The figures of sweeps and coast-downs: panels, labels, marks."""

from __future__ import annotations

import math

import pytest
import xarray as xr

from wucht.machines.catalogue import load_machine
from wucht.plots import draw
from wucht.studies.coast_down import CoastDown, coast_down
from wucht.studies.sweep import Sweep, sweep

FIGURE_5, FIGURE_7 = "sperling-vibration/figure-5", "sperling-vibration/figure-7"


@pytest.fixture(scope="module")
def swept() -> xr.Dataset:
    return sweep(load_machine(FIGURE_5), Sweep("drive.no_load_speed", (8.0, 11.0), 0.01, jump_tolerance=1e-3))


@pytest.fixture(scope="module")
def coasted() -> xr.Dataset:
    start = {"disc": {"angle": math.pi / 2, "speed": 1.0}, "s1": 0.0, "s2": 0.0}
    return coast_down(load_machine(FIGURE_7), CoastDown(until=300.0, start=start))


def _labels(axis: object) -> list[str]:
    return [t.get_text() for t in axis.get_legend().get_texts()]  # type: ignore[attr-defined]


def test_a_sweep_shows_both_ways_and_its_jumps(swept: xr.Dataset) -> None:
    speed, amplitude = draw(swept).axes
    assert speed.get_ylabel() == "mean speed (rad/s)"
    assert amplitude.get_ylabel() == "amplitude of the axis (mm)"
    assert amplitude.get_xlabel() == "drive.no_load_speed (rad/s)"
    assert amplitude.get_xlim() == (8.0, 11.0)
    assert _labels(speed) == ["rising", "falling", "end of a branch", "no-load speed"]
    assert _labels(amplitude) == ["rising", "falling", "end of a branch"]
    assert len(speed.texts) == len(amplitude.texts) == 2  # an arrow a jump


def test_the_title_of_a_sweep_names_the_jumps(swept: xr.Dataset) -> None:
    heading = draw(swept)._suptitle.get_text()  # type: ignore[attr-defined]
    assert "rising" in heading
    assert "falling" in heading
    assert heading.count("\n") == 1


def test_an_interrupted_sweep_is_drawn() -> None:
    def stop(_done: float, _goal: float) -> None:
        raise KeyboardInterrupt

    found = sweep(load_machine(FIGURE_5), Sweep("drive.no_load_speed", (8.0, 11.0)), stop)
    assert draw(found).axes


def test_a_coast_down_on_a_fixed_axis_has_two_panels(coasted: xr.Dataset) -> None:
    speed, energy = draw(coasted).axes
    assert speed.get_ylabel() == "speed of the rotor (rad/s)"
    assert energy.get_yscale() == "log"
    assert energy.get_xlabel() == "time (s)"
    assert "turns back" in _labels(speed)


def test_a_coast_down_on_a_carrier_has_three() -> None:
    found = coast_down(load_machine("drozdetskaya-2020/table-3.1-laval"), CoastDown(until=100.0))
    speed, amplitude, _ = draw(found).axes
    assert amplitude.get_ylabel() == "amplitude of the axis"
    assert "natural frequency" in _labels(speed)
