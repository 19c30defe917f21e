"""What every figure must be: complete, readable in grey, with nothing upon or beyond anything else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

_LEGENDS = 0.25  # of the figure: all legends together
_TOUCHING = 1.5  # pixels of 150 an inch: by so much boxes of letters, which have a rim, may share
_APART = 0.1  # of black to white: greys that can be told from each other


def check(figure: Figure) -> None:
    """All of it, for a figure that has been arranged."""
    figure.draw_without_rendering()
    panels = [axis for axis in figure.axes if axis.get_visible() and axis.axison]
    assert [axis.get_ylabel() for axis in panels if not _drawn(axis)] == [], "panels that are empty"
    assert [axis for axis in panels if not _named(axis)] == [], "panels whose scales have no name"
    assert legend_share(figure) < _LEGENDS
    for axis in panels:
        assert alike(axis.get_lines()) == [], "lines that cannot be told from each other"
    assert beyond(figure) == [], "words that are not on the page"
    assert overlapping(figure) == [], "words upon each other"


def legend_share(figure: Figure) -> float:
    """How much of a figure its legends take."""
    boxes = [box for _, box in _words(figure) if _ == "legend"]
    return float(sum(box.width * box.height for box in boxes) / (figure.bbox.width * figure.bbox.height))


def alike(lines: Iterable[Line2D]) -> list[tuple[str, str]]:
    """Lines with a name that have the same dashes and marks, and greys that are too near to each other."""
    named = [line for line in lines if not str(line.get_label()).startswith("_")]
    return [
        (str(a.get_label()), str(b.get_label()))
        for a, b in combinations(named, 2)
        if a.get_label() != b.get_label() and _look(a) == _look(b) and abs(_grey(a.get_color()) - _grey(b.get_color())) < _APART
    ]


def _look(line: Line2D) -> tuple[Any, ...]:
    dashes: Any = line._unscaled_dash_pattern  # type: ignore[attr-defined]
    face = str(line.get_markerfacecolor()) if line.get_marker() not in ("None", None, "") else ""
    return str(dashes), str(line.get_linestyle()), str(line.get_marker()), face, round(float(line.get_linewidth()))


def _grey(colour: Any) -> float:
    """How bright a colour is printed in grey (ITU-R BT.601)."""
    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))


def beyond(figure: Figure) -> list[str]:
    """What is not on the page as a whole."""
    page = figure.bbox.padded(_touching(figure))
    return [text for text, box in _words(figure) if not (page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1))]


def overlapping(figure: Figure) -> list[tuple[str, str]]:
    """What lies upon each other of titles, names and numbers of scales, and legends."""
    touching, found = _touching(figure), list[tuple[str, str]]()
    for (one, a), (other, b) in combinations(_words(figure), 2):
        both = Bbox.intersection(a, b)
        if both is not None and min(both.width, both.height) > touching:
            found.append((one, other))
    return found


def _touching(figure: Figure) -> float:
    return _TOUCHING * figure.dpi / 150


def _words(figure: Figure) -> list[tuple[str, Bbox]]:
    """Everything that is written outside of the panels, with its box in pixels."""
    renderer: Any = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    title: Any = figure._suptitle  # type: ignore[attr-defined]
    texts = [title] if title is not None else []
    legends = [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend() is not None)]
    for axis in figure.axes:
        if axis.get_visible() and axis.axison:
            texts += [axis.title, *_of_scales(axis)]
            for inner in axis.child_axes:
                texts += _of_scales(inner)
    seen = [t for t in texts if t.get_visible() and t.get_text().strip()]
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for t in seen]
    return [*boxes, *(("legend", legend.get_window_extent(renderer)) for legend in legends)]


def _of_scales(axis: Axes) -> Iterator[Any]:
    for scale in (axis.xaxis, axis.yaxis):
        if scale.get_visible():
            yield scale.label
            low, high = sorted(scale.get_transform().transform(np.asarray(scale.get_view_interval(), float)))
            for tick in scale.get_major_ticks():
                at = float(scale.get_transform().transform(np.array([float(tick.get_loc())]))[0])
                inside = low - 1e-9 * (high - low) <= at <= high + 1e-9 * (high - low)
                yield from (label for label in (tick.label1, tick.label2) if inside and label.get_visible())


def _drawn(axis: Axes) -> bool:
    """Whether something of the answer is in a panel: more than levels across it."""
    lines = [line for line in axis.get_lines() if len(np.atleast_1d(line.get_xdata())) > 0]
    return bool(lines or axis.collections or axis.images or axis.patches)


def _named(axis: Axes) -> bool:
    """Whether the scales of a panel have names; the upper ones of panels over one abscissa take that of the last."""
    shared = len(axis.get_shared_x_axes().get_siblings(axis)) > 1
    bare = not axis.get_xticks().size and not axis.get_yticks().size
    return bare or (bool(axis.get_xlabel() or shared) and bool(axis.get_ylabel() or not axis.get_yticks().size))


def sizes(figure: Figure) -> set[float]:
    """Of all letters, in points."""
    legends = [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend() is not None)]
    texts = [text for legend in legends for text in legend.get_texts()]
    for axis in figure.axes:
        if axis.get_visible() and axis.axison:
            texts += [*axis.texts, *_of_scales(axis), *([axis.title] if axis.get_title() else [])]
    return {round(float(text.get_fontsize()), 3) for text in texts if text.get_text().strip()}
