"""Figures of run-ups with both models: the slow lines beside the full ones, over the same abscissae."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from wucht import RunUp
from wucht.files.catalogue import load_machine
from wucht.plots.run_panels import RunView
from wucht.plots.style import SLOW
from wucht.studies.runner import draw, run

START = {"psi": 0.0, "delta": 0.5}


def answer(name: str = "drozdetskaya-2020/table-5.1", **keys: Any) -> xr.Dataset:
    machine = load_machine(name)
    return run(RunUp.from_table({"kind": "run-up", "model": "both"} | keys), machine)


def slow_lines(axis: Axes) -> list[Line2D]:
    return [
        line for line in axis.get_lines() if line.get_color() == SLOW["color"] and line.get_linewidth() == SLOW["linewidth"]
    ]


@pytest.fixture(scope="module")
def modulated() -> xr.Dataset:
    return answer(until=1000.0, start=START, over="phi")


def test_slow_lines_in_speed_amplitude_and_phase(modulated: xr.Dataset) -> None:
    speed, amplitude, phase, power = draw(modulated).axes[:4]
    assert [len(slow_lines(a)) for a in (speed, amplitude, phase, power)] == [1, 1, 2, 0]
    labels = [[t.get_text() for t in a.get_legend().get_texts()].count("averaged equations") for a in (amplitude, phase)]
    assert labels == [1, 1], "named once a panel"
    assert "rotor, averaged equations" in [t.get_text() for t in speed.get_legend().get_texts()]


def test_each_model_over_its_own_angle(modulated: xr.Dataset) -> None:
    """The slow rotor is elsewhere at the same time: its line must not be drawn over the angle of the full one."""
    view = RunView(modulated)
    full, slow = view.x, view.slow_x
    assert slow is not None
    assert view.name == "angle of the rotor $\\varphi$ (rad)"
    assert full == pytest.approx(modulated.angle.values[0])
    assert slow == pytest.approx(modulated.slow_angle.values[0])
    assert np.abs(full - slow).max() > 1.0
    [line] = slow_lines(draw(modulated).axes[0])
    drawn = np.interp(line.get_xdata(), slow, modulated.slow_speed.values[0])
    assert line.get_ydata() == pytest.approx(drawn, abs=1e-9)


def test_over_time_and_over_the_phase(modulated: xr.Dataset) -> None:
    import json

    for over in ("time", "psi"):
        shown = modulated.copy()
        asked = json.loads(modulated.attrs["input"])
        asked["study"]["over"] = over
        shown.attrs["input"] = json.dumps(asked)
        at = RunView(shown).slow_x
        angle = modulated.slow_angle.values
        expected = modulated.time.values if over == "time" else angle[1:].mean(axis=0) - angle[0]
        assert at == pytest.approx(expected)
        assert draw(shown).axes


def test_the_phase_of_an_entrained_rotor_has_a_slow_line() -> None:
    result = answer("sperling-vibration/figure-2a", until=20.0)
    assert result.slow_rotor_phase.dims == result.rotor_phase.dims
    panel = next(a for a in draw(result).axes if "phase to the vibration" in a.get_ylabel())
    assert len(slow_lines(panel)) == 1


def test_without_the_slow_equations_there_is_no_slow_line() -> None:
    result = answer(until=50.0, start=START, model="full")
    assert not any(slow_lines(a) for a in draw(result).axes)


@pytest.mark.parametrize("over", ["time", "phi"])
def test_many_runs(over: str) -> None:
    result = answer(until=300.0, start=START, along="u", values=[1.0, 7.0], over=over)
    speed, amplitude = draw(result).axes
    assert len(slow_lines(speed)) == len(slow_lines(amplitude)) == 2
    last = result.isel(case=1)
    line = slow_lines(speed)[1]
    at = last["slow_abscissa" if over == "phi" else "time"].values
    inside = np.isfinite(at)
    assert (line.get_xdata()[0], line.get_xdata()[-1]) == pytest.approx((at[inside][0], at[inside][-1]))
    assert line.get_ydata()[-1] == pytest.approx(last.slow_speed.values[0][inside][-1])
    [legend] = speed.figure.legends
    assert [t.get_text() for t in legend.get_texts()].count("averaged equations") == 1
