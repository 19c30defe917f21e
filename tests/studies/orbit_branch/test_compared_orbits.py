"""Orbits of one's own equations in a comparison: their period is compared, whatever their states are called."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import wucht

# r' = r (mu - r^2), its phase at a pace: orbits are circles of period 2 pi/pace. Their `speed` is a state, and no rotor's.
CIRCLE = """
title = "A circle"
[system]
parameters = { mu = 1.0, pace = 2.0 }
definitions = { s = "mu - speed^2 - y^2" }
states = { speed = "s*speed - pace*y", y = "pace*speed + s*y" }
[study]
kind = "orbit-branch"
along = "mu"
range = [0.8, 1.2]
at = 1.0
values = [1.1]
start = { speed = 0.9 }
"""


def test_a_state_that_is_called_speed_is_no_mean_speed(here: Path) -> None:
    """Of a machine the rotor's mean speed is compared beside the period; these equations have the period alone."""
    Path("circle.toml").write_text(CIRCLE, encoding="utf-8")
    result = wucht.compare(["circle.toml"], None, {"pace": [2.0, 4.0]})
    drawn = {str(name): result[name].attrs["long_name"] for name in result.variables if str(name).startswith("curve_")}
    assert drawn == {"curve_1_x": "parameter mu", "curve_1_y": "period"}
    for periods, period in zip(result.curve_1_y.values, (np.pi, np.pi / 2), strict=True):
        assert periods == pytest.approx(np.full_like(periods, period), rel=1e-4)
