"""What every figure must be: complete, readable in grey, with nothing upon or beyond anything else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import Bbox

from wucht.plots.page import JOURNAL
from wucht.plots.sheet import page_of

_LEGENDS = 0.25  # of the figure: all legends together
_TOUCHING = 1.5  # pixels of 150 an inch: by so much boxes of letters, which have a rim, may share
_APART = 0.1  # of black to white: greys that can be told from each other
_EMPTY, _LONG = 0.2, 1.45  # of a page: a strip at its side; height over width of paper, 297 mm over 210 mm and a little


def check(figure: Figure) -> None:
    """All of it, for a figure that has been arranged."""
    figure.draw_without_rendering()
    panels = [axis for axis in figure.axes if axis.get_visible() and axis.axison]
    assert [axis.get_ylabel() for axis in panels if not _drawn(axis)] == [], "panels that are empty"
    assert [axis for axis in panels if not _named(axis)] == [], "panels whose scales have no name"
    assert legend_share(figure) < _LEGENDS
    for axis in panels:
        assert alike(axis.get_lines()) == [], "lines that cannot be told from each other"
        assert bars_alike(axis) == [], "bars that cannot be told from each other"
    for legend in _legends(figure):
        told = [text.get_text() for axis in panels for text in axis.texts if text.get_text()]  # on the lines themselves
        lines = [line for line in legend.legend_handles if isinstance(line, Line2D)]
        assert alike(line for line in lines if not _told(str(line.get_label()), told)) == [], "the same of a legend"
        assert [patch for patch in legend.get_patches() if _hidden(patch)] == [], "hatches of a legend that are not seen"
    heading = figure.get_suptitle().split("\n")
    assert len(heading) <= 2, "a title of more than two lines"
    assert too_exact("\n".join(heading[1:])) == [], "numbers of more than four digits in a title"
    assert [axis for axis in panels if "energy" in axis.get_ylabel() and "residual" in axis.get_ylabel()] == [], "of no use"
    assert beyond(figure) == [], "words that are not on the page"
    assert overlapping(figure) == [], "words upon each other"
    scales = [scale for axis in panels for scale in (axis.xaxis, axis.yaxis)]
    offsets = [text.get_text() for text in (scale.get_offset_text() for scale in scales) if text.get_visible()]
    assert [text for text in offsets if text] == [], "a power of ten apart from the name of its scale"
    assert crossed(figure) == [], "names in panels that lines cross"
    assert empty_strip(figure) < _EMPTY, "a part of the page that is empty"
    width, height = figure.get_size_inches()
    assert height <= (JOURNAL.tallest if page_of(figure).name == JOURNAL.name else _LONG * width), "longer than a page"
    words = [text for text, _ in _words(figure)]
    assert [text for text in words if "(1)" in text] == [], "a ratio has no unit"
    words += [text.get_text() for legend in _legends(figure) for text in legend.get_texts()]
    assert [text for text in words if repeats_unit(text)] == [], "units that are given twice, or as in files"


def too_exact(text: str) -> list[str]:
    """Decimal numbers of more than four significant digits."""
    numbers = re.findall(r"(?<![\w.])\d+\.\d+", text)
    return [n for n in numbers if len(n.replace(".", "").strip("0")) > 4]


_UNIT = r"(?:[kMmµ]?(?:N|W|J|V|A|Pa|Hz|m|s|g)|rad|rpm|°|%)(?:[·/²³](?:mm|m|s|rad|kg)?)*"


def repeats_unit(text: str) -> bool:
    """Whether a name or title gives the unit of one quantity twice, or a product of units as files have it, ``N m s``."""
    flat = " ".join(text.split())
    in_brackets = re.findall(rf"\((?:10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ )?({_UNIT})\)", flat)
    before = re.findall(rf"(?<=\bin )({_UNIT})(?= \()", flat)
    twice = re.search(rf"\d ?({_UNIT}) \(?\1(?![\w·/²³])", flat)
    return len(in_brackets) > 1 or bool(in_brackets and before) or bool(twice) or bool(re.search(r"\b[km]?N m\b", flat))


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


def bars_alike(axis: Axes) -> list[tuple[str, str]]:
    """Kinds of bars that have the same hatch and greys that are too near to each other."""
    kinds = [bars for bars in axis.containers if isinstance(bars, BarContainer) and len(bars)]
    looks = [(bars.patches[0].get_hatch(), _grey(bars.patches[0].get_facecolor()[:3])) for bars in kinds]
    return [
        (str(kinds[i].get_label()), str(kinds[k].get_label()))
        for i, k in combinations(range(len(kinds)), 2)
        if looks[i][0] == looks[k][0] and abs(looks[i][1] - looks[k][1]) < 2 * _APART
    ]


def _hidden(patch: Patch) -> bool:
    """Whether a hatch has the grey of what it is upon."""
    face, edge = patch.get_facecolor(), patch.get_edgecolor()
    return bool(patch.get_hatch()) and face[3] > 0 and abs(_grey(face[:3]) - _grey(edge[:3])) < _APART


def crossed(figure: Figure) -> list[str]:
    """Names within panels through which a line goes; those on a ground of their own are read all the same."""
    renderer: Any = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    found = list[str]()
    for axis in figure.axes:
        for text in axis.texts:
            box = text.get_window_extent(renderer).padded(-_touching(figure))
            bare = text.get_text().strip() and text.get_bbox_patch() is None
            if bare and any(_through(line, box) for line in axis.get_lines()):
                found.append(text.get_text())
    return found


def _through(line: Line2D, box: Bbox) -> bool:
    return bool(
        line.get_linestyle() != "None"
        and line.get_transform().transform_path(line.get_path()).intersects_bbox(box, filled=False)
    )


def empty_strip(figure: Figure) -> float:
    """The widest strip at the left or right of all panels and words, as a share of the page."""
    renderer: Any = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = [*(axis.get_window_extent(renderer) for axis in figure.axes), *(box for _, box in _words(figure)[1:])]
    low, high = min(box.x0 for box in boxes), max(box.x1 for box in boxes)
    return float(max(low - figure.bbox.x0, figure.bbox.x1 - high) / figure.bbox.width)


def _told(name: str, told: Iterable[str]) -> bool:
    return any(re.search(rf"\b{re.escape(text)}\b", name) for text in told)


def _look(line: Line2D) -> tuple[Any, ...]:
    dashes: Any = line._unscaled_dash_pattern  # type: ignore[attr-defined]
    face = f"{line.get_fillstyle()} {line.get_markerfacecolor()}" if line.get_marker() not in ("None", None, "") else ""
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
    for axis in figure.axes:
        if axis.get_visible():
            texts += axis.texts
        if axis.get_visible() and axis.axison:
            texts += [axis.title, *_of_scales(axis)]
            for inner in axis.child_axes:
                texts += _of_scales(inner)
    seen = [t for t in texts if t.get_visible() and t.get_text().strip()]
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for t in seen]
    return [*boxes, *(("legend", legend.get_window_extent(renderer)) for legend in _legends(figure))]


def _legends(figure: Figure) -> list[Any]:
    return [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend() is not None)]


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
    texts = [text for legend in _legends(figure) for text in legend.get_texts()]
    for axis in figure.axes:
        if axis.get_visible() and axis.axison:
            texts += [*axis.texts, *_of_scales(axis), *([axis.title] if axis.get_title() else [])]
    return {round(float(text.get_fontsize()), 3) for text in texts if text.get_text().strip()}
