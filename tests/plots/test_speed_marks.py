"""Panels over the speed: marks of natural frequencies, and legends in which a line of one name and look stands once."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wucht.plots.arranging import arrange
from wucht.plots.sheet import new_figure
from wucht.plots.style import mark_speeds


def marked(*looks: tuple[str, dict[str, Any]]) -> list[list[str]]:
    """The legend's names of each of two panels, the second of which has a line of each look, the first the first one."""
    figure, axes = new_figure(2, "a title", "", 2.0)
    for axis, shown in zip(axes, (looks[:1], looks), strict=True):
        for name, look in shown:
            axis.plot([0.0, 100.0], [1.0, 2.0], label=name, **look)
    speed = ("speed", np.array([0.0, 100.0]), {"units": "rad/s", "long_name": "speed"})
    result = xr.Dataset({"natural_frequency": ("mode", [50.0])}, {"speed": speed})
    mark_speeds(axes, result, ("natural frequency", "natural frequencies"), (200.0, "no-load speed"), 0)
    arrange(figure)
    return [[text.get_text() for text in axis.get_legend().get_texts()] if axis.get_legend() else [] for axis in axes]


def test_a_line_of_another_colour_is_another_line() -> None:
    first, second = marked(("amplitude", {"color": "red"}), ("amplitude", {"color": "blue"}), ("force", {"color": "red"}))
    assert sorted(first) == ["amplitude", "natural frequency"]
    assert sorted(second) == ["amplitude", "force"], "the red one is in the legend above"
