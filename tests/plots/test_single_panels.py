"""Single panels of a figure, in axes of the user's own or in a figure of their own: drawn as in the whole figure."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tests.refusals import refused

import wucht
from wucht.plots.sheet import has_sheet


@cache
def result() -> Any:
    return wucht.run(wucht.RunUp(until=2.0, start={"p1": 0.3, "p2": -0.5}), "drozdetskaya-2020/r1")


NAMES = ["speed", "amplitude of the axis", "phase to the rotor", "motor power"]


def lines(axis: Axes) -> list[tuple[str, list[float], list[float]]]:
    return [(str(line.get_label()), *np.nan_to_num(np.asarray(line.get_data(), float)).tolist()) for line in axis.get_lines()]


def test_panels_in_axes_of_the_users_own_are_those_of_the_whole_figure() -> None:
    assert wucht.panel_names(result()) == NAMES
    whole = [axis for axis in wucht.draw(result()).axes if axis.get_ylabel()]
    figure = Figure()
    left, right = figure.subplots(1, 2, sharex=True)
    assert wucht.draw(result(), panels=["phase to the rotor", "speed"], axes=[left, right]) is figure
    assert figure.axes == [left, right] and not has_sheet(figure)
    for axis, model in ((left, whole[2]), (right, whole[0])):
        assert lines(axis) == lines(model) and axis.get_ylabel() == model.get_ylabel()
        assert axis.get_xlim() == model.get_xlim() and axis.get_ylim() == model.get_ylim()
        assert axis.get_xlabel() == "time (s)" and axis.xaxis.get_tick_params()["labelbottom"]
    assert [text.get_text() for text in left.get_legend().get_texts()] == ["p1", "p2"]
    figure.canvas.draw()
    after = [axis for axis in wucht.draw(result()).axes if axis.get_ylabel()]  # nothing of it remains
    assert [lines(axis) for axis in after] == [lines(axis) for axis in whole]


def test_numbers_at_an_abscissa_in_common_stay_hidden() -> None:
    upper, lower = Figure().subplots(2, 1, sharex=True)
    wucht.draw(result(), panels=NAMES[:2], axes=np.array([upper, lower]))
    assert not upper.xaxis.get_tick_params()["labelbottom"] and upper.get_xlabel() == ""
    assert lower.get_xlabel() == "time (s)" and lower.get_legend() is None  # its name says what its only curve is


def test_panels_have_a_figure_of_their_own_otherwise() -> None:
    whole = {axis.get_ylabel(): lines(axis) for axis in wucht.draw(result()).axes}
    panel = wucht.draw(result(), panels="motor power").axes[0]
    assert lines(panel) == whole[panel.get_ylabel()] and panel.get_xlabel() == "time (s)"
    assert panel.figure.get_suptitle().startswith("R1")
    several = wucht.draw(result(), wucht.JOURNAL, panels=NAMES[1:3])
    assert [lines(axis) for axis in several.axes] == [whole[" ".join(axis.get_ylabel().split())] for axis in several.axes] != []


def test_panels_with_an_aspect_and_a_second_scale() -> None:
    cam = wucht.run(wucht.CamContour(), "kaltofen-cam/dwell-and-return")
    names = wucht.panel_names(cam)
    assert len(names) == len(set(names)) > 2
    axes = Figure().subplots(1, len(names))
    wucht.draw(cam, axes=axes)
    assert all(axis.get_lines() or axis.patches for axis in axes)


def test_what_is_refused() -> None:
    axis = Figure().subplots()
    with refused("panels", *NAMES, given="sped"):
        wucht.draw(result(), panels="sped")
    for names in (["speed", "speed"], [], [1]):
        with refused("panels", *NAMES, given=names):
            wucht.draw(result(), panels=names)
    for axes in (axis, 3, [axis, 3]):
        with refused("axes", "2", *NAMES[:2], given=axes):
            wucht.draw(result(), panels=NAMES[:2], axes=axes)
    with pytest.raises(TypeError):
        wucht.draw(result(), wucht.PRINT, "speed")  # type: ignore[misc]
