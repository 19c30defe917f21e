"""The figure of a coast-down: panels, labels, marks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht import CoastDown, draw, load_machine, run

FIGURE_7 = "sperling-vibration/figure-7"


def _labels(axis: object) -> list[str]:
    return [t.get_text() for t in axis.get_legend().get_texts()]  # type: ignore[attr-defined]


def test_the_oscillation_after_the_reversal_is_a_band_and_no_dark_block() -> None:
    """A mean speed falls, then there are hundreds of swings in less than half of the panel."""
    start = {"disc": {"angle": math.pi / 2, "speed": 1.6}, "s1": 0.0, "s2": 0.0}
    result = run(CoastDown(until=3000.0, start=start), load_machine(FIGURE_7))
    begin = result.wucht.summary["reversal_time"]
    (axis,) = draw(result).axes
    (late,) = (line for line in axis.get_lines() if len(line.get_xdata()) > 5 and min(line.get_xdata()) > 0.9 * begin)
    at, mean = (np.asarray(v, float) for v in late.get_data())
    after = at > 1.1 * begin  # windows before that reach back to the last turns
    assert after.any() and np.abs(mean[after]).max() < 0.1 * np.ptp(result.speed.values[result.time.values > begin])
    (band,) = axis.collections
    corners = band.get_paths()[0].vertices
    speed = result.speed.values[result.time.values > 1.1 * begin]
    assert np.ptp(corners[corners[:, 0] > 1.1 * begin, 1]) == pytest.approx(np.ptp(speed), rel=0.1)


def test_every_rotor_has_its_mean_speed_and_the_range_no_gaps() -> None:
    """Of two exciters, however few rows there are; the largest amplitude is not averaged away."""
    result = run(CoastDown(until=60.0), load_machine("sperling-vibration/self-synchronisation-soft"))
    speed, amplitude = draw(result).axes
    assert _labels(speed)[:3] == ["least to greatest", "e1, from together", "e2, from together"]
    (line,) = [x for x in speed.get_lines() if x.get_label() == "e2, from together"]
    at, drawn = (np.asarray(v, float) for v in line.get_data())
    angle, time = result.rotor_angle.sel(rotor="e2").values, result.time.values
    assert np.trapezoid(drawn, at) == pytest.approx(angle[-1] - angle[0], rel=1e-2)
    (band,) = speed.collections
    corners = band.get_paths()[0].vertices
    widths = [np.ptp(corners[np.abs(corners[:, 0] - x) < 0.05, 1]) for x in np.linspace(15.0, 20.0, 11)]
    assert min(widths) > 0.2 * max(widths), "no white gaps"
    line = amplitude.get_lines()[0]
    assert np.max(line.get_ydata()) == pytest.approx(1e3 * result.wucht.summary["peak_amplitude"], rel=0.02)
    assert time[0] == at[0] and time[-1] == at[-1]
