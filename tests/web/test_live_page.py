"""The built page, run in Node: which panel shows a measured curve, and where."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.node import run_in_node
from tests.web.built_page import needs_page

from wucht.web.shared_study import shared_page

PAGE = Path(__file__).with_name("page_in_node.mjs")
TIMES, SPEEDS, AMPLITUDES = [0.05, 0.1, 0.17], [100, 250, 300], [0.3, 0.1]


@needs_page
def test_a_measured_curve_is_drawn_in_its_own_panel_alone(tmp_path: Path) -> None:
    """Two curves in one file: a square for each value, at its time in both panels, the higher the larger it is."""
    page, file = tmp_path / "page.html", tmp_path / "run.csv"
    page.write_text(shared_page("drozdetskaya-2020/r1", {"study.until": 0.2}, verdict=False), encoding="utf-8")
    rows = [f"{time},{speed},{x}" for time, speed, x in zip(TIMES, SPEEDS, [*AMPLITUDES, ""], strict=True)]
    file.write_text("\n".join(["time (s),speed (rpm),amplitude (mm)", *rows]) + "\n", encoding="utf-8")
    drawn = json.loads(run_in_node(PAGE, page, file))
    assert {label: len(rectangles) for label, rectangles in drawn.items()} == {
        "speed over time": 3, "displacement of the axis over time": 2, "phases on the rotor over time": 0,
        "residual unbalance over time": 0, "motor power over time": 0,
    }  # fmt: skip
    (x, y, *sides), (x_of_amplitudes, y_of_amplitudes, *_) = (np.array(drawn[label]).T for label in list(drawn)[:2])
    assert np.ptp(sides) == 0, "squares of one size"
    assert np.diff(x) / (x[-1] - x[0]) == pytest.approx(np.diff(TIMES) / (TIMES[-1] - TIMES[0]))
    assert np.diff(y) / (y[-1] - y[0]) == pytest.approx(np.diff(SPEEDS) / (SPEEDS[-1] - SPEEDS[0]))
    assert y[0] > y[-1] and y_of_amplitudes[0] < y_of_amplitudes[1]
    assert x_of_amplitudes == pytest.approx(x[:2])
