"""The figure of a stability map: regions in tones and hatches, boundaries as lines, as 002 figure 5.9a."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.page import small
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import named, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TONES = ("#FFFFFF", "#F3D9C0", "#8FB8D6", "#BFDDD0")  # of falling lightness where it matters: white, 0.87, 0.70
_HATCHES = ("", "///", "...", "\\\\\\", "xxx", "ooo")
_HEIGHT = 4.2  # inches
_DASHES = ("-", "--", "-.", ":", (0, (6, 1.5, 1, 1.5, 1, 1.5)), (0, (8, 3)))
_MARKERS = ("*", "D", "P", "X", "v", "h")
_LABELLED = 0.012  # of the plane: a region that is large enough for its name
_WRAPPED, _CHARACTERS = 20, 65  # characters of a region's name in a line at most, and in the whole width of the plane


def figure(result: xr.Dataset) -> Figure:
    """The plane of both parameters, from a stability map's Dataset alone."""
    drawn, (axis,) = new_figure(1, result.attrs["title"], result.attrs["sentence"], _HEIGHT)
    axis.grid(visible=False)
    handles = [*_regions(axis, result), *_boundaries(axis, result), *_marks(axis, result)]
    handles += _places(axis, result)
    axis.set_xlim(result.attrs["low"], result.attrs["high"])
    axis.set_ylim(result.attrs["second_low"], result.attrs["second_high"])
    axis.set_xlabel(with_unit(_what(result, "along"), result.attrs["along_unit"]))
    axis.set_ylabel(with_unit(_what(result, "second"), result.attrs["second_unit"]))
    legend_beside(axis, handles, f"besides {result.attrs['everywhere']}:" if result.attrs["everywhere"] else None)
    return drawn


def _what(result: xr.Dataset, of: str) -> str:
    return named(str(result.attrs[of]), str(result.attrs[f"{of}_what"]))


def _regions(axis: Axes, result: xr.Dataset) -> list[Any]:
    from matplotlib.patches import Patch

    index, x, y = result.region.values, result.x.values, result.y.values
    labels, handles = result.region_label.values.astype(str), dict[str, Any]()
    width, height = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    edges = [np.concatenate([[v[0] - h], v[1:-1], [v[-1] + h]]) for v, h in ((x, width), (y, height))]
    order = sorted(range(len(labels)), key=lambda k: (-int(result.region_tone[k]), labels[k]))
    for k in order:
        tone = _TONES[int(result.region_tone[k]) % len(_TONES)]
        hatch = _HATCHES[int(result.region_hatch[k]) % len(_HATCHES)]
        inside = index == k
        if inside.any():
            axis.contourf(*edges, inside.astype(float), levels=[0.5, 1.5], colors=[tone], hatches=[hatch], zorder=0)
        handles.setdefault(labels[k], Patch(facecolor=tone, hatch=hatch, edgecolor=GREY, linewidth=0.5, label=labels[k]))
    for collection in axis.collections:
        collection.set_edgecolor("#FFFFFF00" if not getattr(collection, "hatches", None) else "#9A9A9A")
        collection.set_linewidth(0.0)
    largest = {
        label: max((k for k in range(len(labels)) if labels[k] == label), key=lambda k: int((index == k).sum()))
        for label in dict.fromkeys(labels.tolist())
    }
    for label, k in largest.items():
        if (index == k).mean() < _LABELLED * 3:
            continue
        box = {"facecolor": "white", "alpha": 0.82, "edgecolor": "none", "pad": 1.5}
        at = float(result.region_x[k]), float(result.region_y[k])
        row = index[np.abs(y - at[1]).argmin()] == k
        room = int(np.clip(_CHARACTERS * row.mean(), 9, _WRAPPED))
        axis.text(*at, textwrap.fill(label, room), ha="center", va="center", fontsize=small(), bbox=box, zorder=6)
    return list(handles.values())


def _boundaries(axis: Axes, result: xr.Dataset) -> list[Any]:
    groups = list(dict.fromkeys(result.boundary_group.values.astype(str).tolist()))
    handles = []
    number = result.boundary.values
    for i, group in enumerate(groups):
        of_orbit = group.startswith("modulated motion") or "|" in group
        style: dict[str, Any] = {
            "color": COLOURS[i % len(COLOURS)] if of_orbit else "#000000" if i == 0 else GREY,
            "linestyle": _DASHES[i % len(_DASHES)], "linewidth": 2.0 if of_orbit else 1.0, "zorder": 4 if of_orbit else 3,
        }  # fmt: skip
        line = None
        for k in np.flatnonzero(result.boundary_group.values.astype(str) == group).tolist():
            at = number == k
            (line,) = axis.plot(result.boundary_x.values[at], result.boundary_y.values[at], **style)
        if line is not None:
            line.set_label(group)
            handles.append(line)
    return handles


def _marks(axis: Axes, result: xr.Dataset) -> list[Any]:
    handles = []
    labels = result.mark_label.values.astype(str)
    for i, label in enumerate(dict.fromkeys(labels.tolist())):
        at = labels == label
        (points,) = axis.plot(
            result.mark_x.values[at], result.mark_y.values[at], _MARKERS[i % len(_MARKERS)], color="black",
            markerfacecolor="white", markersize=9, markeredgewidth=1.1, linestyle="", zorder=7, label=label,
        )  # fmt: skip
        handles.append(points)
    return handles


def _places(axis: Axes, result: xr.Dataset) -> list[Any]:
    (points,) = axis.plot(
        result.place_x.values, result.place_y.values, ".", color=GREY, markersize=2.5, linestyle="", zorder=2,
        label="looked at one by one",
    )  # fmt: skip
    return [points]
