"""The figure of a stability map: regions in tones and hatches, boundaries as lines, as 002 figure 5.9a."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.page import current_page, small
from wucht.plots.scales import parameter_label
from wucht.plots.sheet import LETTER, legend_beside, new_figure
from wucht.plots.stability_lines import draw_region, field
from wucht.plots.style import COLOURS, GREY
from wucht.results.attributes import number_in, text_in
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TONES = ("#FFFFFF", "#F3D9C0", "#8FB8D6", "#BFDDD0", "#DDDDDD")  # of decreasing lightness: white, 0.87, 0.70; not decided
_ORBITS = ("modulated motion", "periodic orbit")  # beginnings of the names of their boundaries
_HATCHES, _HATCH = ("", "///", "...", "\\\\\\", "xxx", "ooo"), "#9A9A9A"
_HEIGHT = 4.2  # inches
_DASHES = ("-", "--", "-.", ":", (0, (6, 1.5, 1, 1.5, 1, 1.5)), (0, (8, 3)))
_MARKERS = ("*", "D", "P", "X", "v", "h")
_LABEL_SHARE = 0.036  # of the plane: least size of a region for its name
_LABEL_WIDTH, _WIDTH_SHARE = 20, 0.48  # characters of a region's name in a line at most; of the page: width of the plane


def map_figure(result: xr.Dataset) -> Figure:
    """Draw the plane of both parameters, from a stability map's Dataset alone."""
    fig, (axis,) = new_figure(1, result.attrs["title"], answer_in_print(result), _HEIGHT)
    axis.grid(visible=False)
    handles = [*_regions(axis, result), *_boundaries(axis, result), *_marks(axis, result)]
    limits = {"xlim": (number_in(result, "low"), number_in(result, "high"))}
    limits["ylim"] = (number_in(result, "second_low"), number_in(result, "second_high"))
    axis.set(**limits, xlabel=parameter_label(result), ylabel=parameter_label(result, "second"))
    everywhere = text_in(result, "everywhere")
    legend_beside(axis, handles, f"besides {everywhere}:" if everywhere else None)
    return fig


def _regions(axis: Axes, result: xr.Dataset) -> list[Any]:
    index, x, y = result.region.values, result.x.values, result.y.values
    labels, handles = result.region_label.values.astype(str), dict[str, Any]()
    edges = [np.concatenate([[(3 * v[0] - v[1]) / 2], v[1:-1], [v[-1] + (v[1] - v[0]) / 2]]) for v in (x, y)]
    for k in sorted(range(len(labels)), key=lambda k: (-int(result.region_tone[k]), labels[k])):
        tone = _TONES[int(result.region_tone[k]) % len(_TONES)]
        hatch = _HATCHES[int(result.region_hatch[k]) % len(_HATCHES)]
        if (index == k).any():
            draw_region(axis, edges[0], edges[1], index == k, hatch, _HATCH, colors=[tone], zorder=0)
        handles.setdefault(labels[k], field(labels[k], tone, hatch))
    for label in dict.fromkeys(labels.tolist()):
        k = max(np.flatnonzero(labels == label).tolist(), key=lambda k: int((index == k).sum()))  # the largest with this label
        if (index == k).mean() >= _LABEL_SHARE:
            at = float(result.region_x[k]), float(result.region_y[k])
            row = index[np.abs(y - at[1]).argmin()] == k
            page = current_page()
            characters = _WIDTH_SHARE * page.width * 72 / (LETTER * page.small)  # in the whole width of the plane
            text = textwrap.fill(label, int(np.clip(characters * row.mean(), 9, _LABEL_WIDTH)))
            box = {"facecolor": "white", "alpha": 0.82, "edgecolor": "none", "pad": 1.5}
            axis.text(*at, text, ha="center", va="center", fontsize=small(), bbox=box, zorder=6)
    return list(handles.values())


def _boundaries(axis: Axes, result: xr.Dataset) -> list[Any]:
    groups, number, handles = result.boundary_group.values.astype(str), result.boundary.values, []
    for i, group in enumerate(dict.fromkeys(groups.tolist())):
        of_orbit = group.startswith(_ORBITS) or "|" in group
        style: dict[str, Any] = {
            "color": COLOURS[i % len(COLOURS)] if of_orbit else "#000000" if i == 0 else GREY,
            "linestyle": _DASHES[i % len(_DASHES)], "linewidth": 2.0 if of_orbit else 1.0, "zorder": 4 if of_orbit else 3,
        }  # fmt: skip
        lines = [
            axis.plot(result.boundary_x.values[at], result.boundary_y.values[at], **style)[0]
            for at in (number == k for k in np.flatnonzero(groups == group))
        ]
        lines[-1].set_label(group)
        handles.append(lines[-1])
    return handles


def _marks(axis: Axes, result: xr.Dataset) -> list[Any]:
    """Draw special points of the boundaries, and the examined places."""
    handles, labels = list[Any](), result.mark_label.values.astype(str)
    look: dict[str, Any] = {"color": "black", "markerfacecolor": "white", "markersize": 9, "markeredgewidth": 1.1, "zorder": 7}
    for i, label in enumerate(dict.fromkeys(labels.tolist())):
        at, marker = labels == label, _MARKERS[i % len(_MARKERS)]
        handles += axis.plot(result.mark_x.values[at], result.mark_y.values[at], marker, linestyle="", label=label, **look)
    places: dict[str, Any] = {"color": GREY, "markersize": 2.5, "zorder": 2, "label": "examined places"}
    return handles + axis.plot(result.place_x.values, result.place_y.values, ".", **places)
