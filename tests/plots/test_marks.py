"""Marks: points in classes and kinds, and what legends say of them."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from wucht.plots.marks import Symbol, draw_classes, draw_kinds, draw_region, entries_of_kinds, field

SYMBOLS: dict[str, Symbol] = {"": ("^", "white", ""), "hopf": ("D", "white", "Hopf point"), "branch-point": ("s", "black", "")}
KINDS = np.array(["hopf", "", "branch-point", "hopf", "torus"])


def test_classes_without_points_are_neither_drawn_nor_named() -> None:
    axis = Figure().add_subplot()
    x = np.arange(3.0)
    draw_classes(axis, x, x, [(x > 0, "o", "white", "open"), (x > 9, "s", "black", "none")], linestyle="")
    (line,) = axis.get_lines()
    assert (line.get_label(), np.asarray(line.get_xdata()).tolist()) == ("open", [1.0, 2.0])


def test_special_points_and_their_legend_have_the_same_symbols() -> None:
    axis = Figure().add_subplot()
    draw_kinds(axis, np.arange(5.0), np.arange(5.0), KINDS, SYMBOLS)
    handles = entries_of_kinds(KINDS, SYMBOLS)
    assert [h.get_label() for h in handles] == ["Hopf point", "branch point", "torus"]
    assert [line.get_marker() for line in axis.get_lines()] == [h.get_marker() for h in handles] == ["D", "s", "^"]
    assert [len(np.atleast_1d(line.get_xdata())) for line in axis.get_lines()] == [2, 1, 1]


def test_a_region_has_its_hatch_in_the_map_and_in_the_legend() -> None:
    axis = Figure().add_subplot()
    inside = np.array([[True, True], [False, False]])
    draw_region(axis, np.arange(2.0), np.arange(2.0), inside, "//", "white", colors=["#8FB8D6"])
    (drawn,) = axis.collections
    assert drawn.hatches == ["//"]  # type: ignore[attr-defined]
    handle = field("stable", "#8FB8D6", "//")
    assert (handle.get_label(), handle.get_hatch()) == ("stable", "//")
    assert handle.get_facecolor()[:3] == to_rgb("#8FB8D6")
