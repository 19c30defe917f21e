"""The figure of a speed curve: speed and amplitude over the parameter, as 002 figures 3.2, 5.2, 5.3 and A.1."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import summary_of
from wucht.results.style import COLOURS, GREY, label, legend_beside, new_figure, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINES: dict[int, dict[str, Any]] = {  # by how many disturbances grow; 2: or more
    0: {"linestyle": "-", "linewidth": 1.8, "zorder": 3},
    1: {"linestyle": (0, (4, 2)), "linewidth": 1.1, "zorder": 2},
    2: {"linestyle": (0, (5, 1.5, 1, 1.5)), "linewidth": 1.1, "zorder": 2},
}
_WORDS = {0: "stable", 1: "unstable", 2: "unstable, several\ndisturbances grow"}
_NAMED = {"compensating": 2, "together": 0, "opposed": 1}  # colours of these, whatever else there is
_MARKS = {"fold": ("o", "white"), "hopf": ("D", "white"), "branch-point": ("s", "black")}
_OTHER_MARK = ("^", "white")
_SECOND_MARKS = ("P", "X", "*", "v", "h")
_SHOWN = {"hopf": "Hopf point", "branch-point": "branch point"}
_HEIGHTS = (4.6, 7.0, 9.4)
_DECADES = 100.0  # a range over which the abscissa is logarithmic
_ROOM = 0.06
_LINE, _HEADING_LINE = 95, 0.17  # of the heading: characters, and height in inches
_NO_NAME = "steady states"


def figure(result: xr.Dataset) -> Figure:
    """Panels over the parameter from a speed curve's Dataset alone: speed, amplitude if something vibrates, and the curves of
    special points where there is a second parameter with a range.
    """
    heading = textwrap.fill(result.attrs["sentence"], _LINE)
    vibrates, plane = bool((result.amplitude.values > 0).any()), "curve_value" in result
    height = _HEIGHTS[vibrates + plane]
    drawn, axes = new_figure(1 + vibrates + plane, height, result.attrs["title"], heading)
    drawn.subplots_adjust(top=1 - (0.55 + _HEADING_LINE * heading.count("\n")) / height)
    colours, used = _colours(result), set[int]()
    _branches(axes[0], result, "speed", 1.0, colours, used)
    axes[0].set_ylabel(label(result, "speed"))
    if vibrates:
        scale, unit = printed_unit(result, "amplitude")
        _branches(axes[1], result, "amplitude", scale, colours, used)
        axes[1].set_ylabel(label(result, "amplitude", unit))
        axes[1].set_ylim(bottom=0)
    if plane:
        _plane(axes[-1], result, colours)
    low, high = result.attrs["low"], result.attrs["high"]
    if 0 < _DECADES * low <= high:
        axes[-1].set_xscale("log")
    axes[-1].set_xlim(low, high)
    axes[-1].set_xlabel(with_unit(_what(result), result.attrs["along_unit"]))
    axes[0].legend(
        handles=_legend(colours, used, result), loc="upper left", bbox_to_anchor=(1.01, 1.02), frameon=False, fontsize=8
    )
    return drawn


def _branches(axis: Axes, result: xr.Dataset, name: str, factor: float, colours: dict[str, str], used: set[int]) -> None:
    """All branches with their special points. used: which kinds of lines are drawn."""
    y = factor * result[name].values
    for points, key, code in _pieces(result):
        used.add(code)
        axis.plot(result.value.values[points], y[points], color=colours[key], **_LINES[code])
    _special_points(axis, result, name, factor)
    if result.sizes["own"]:
        axis.axvline(summary_of(result)["value"], color=GREY, linestyle=":", linewidth=0.9, zorder=1)
    axis.margins(y=_ROOM)
    if np.nanmin(y, initial=np.inf) >= 0:
        axis.set_ylim(bottom=0)


def _plane(axis: Axes, result: xr.Dataset, colours: dict[str, str]) -> None:
    """The curves of folds and Hopf points in both parameters."""
    number, named = result.curve.values, set[str]()
    for k in range(result.sizes["curve_number"]):
        at, of, states = number == k, str(result.curve_of.values[k]), str(result.curve_label.values[k])
        name = f"{_SHOWN.get(of, of)}s" + ("" if states == _NO_NAME else f", {states}")
        style: dict[str, Any] = {"color": colours.get(states, GREY), "linestyle": "-" if of == "fold" else "--"}
        x, y = result.curve_value.values[at], result.curve_second.values[at]
        axis.plot(x, y, linewidth=1.3, label=None if name in named else name, **style)
        named.add(name)
    kinds = result.curve_kind.values.astype(str)
    for i, kind in enumerate(dict.fromkeys(k for k in kinds.tolist() if k)):
        at = kinds == kind
        x, y, marker = result.curve_value.values[at], result.curve_second.values[at], _SECOND_MARKS[i % len(_SECOND_MARKS)]
        name = kind.replace("-", " ").replace("hopf", "Hopf").replace("bogdanov takens", "Bogdanov-Takens")
        axis.plot(x, y, marker, color="black", markerfacecolor="white", markersize=6, zorder=5, label=name)
    axis.set_ylabel(with_unit(str(result.attrs["second"]), result.attrs["second_unit"]))
    summary = summary_of(result)
    axis.axhline(summary["second_value"], color=GREY, linestyle=":", linewidth=0.9, zorder=1)
    legend_beside(axis)


def _what(result: xr.Dataset) -> str:
    """The parameter's path, with what it is where that says more."""
    path, what = str(result.attrs["along"]), str(result.attrs["along_what"])
    return path if what in (path, f"parameter {path}") else f"{path}: {what}"


def _key(result: xr.Dataset, branch: int) -> str:
    """What the branches of one colour have in common: the value of the second parameter, or what their states are called."""
    second = float(result.second_value[branch])
    if np.isnan(second):
        return str(result.branch_label.values[branch])
    return f"{result.attrs['second']} = {second:.6g} {result.attrs['second_unit']}".rstrip()


def _colours(result: xr.Dataset) -> dict[str, str]:
    """By key: of named states always the same, where a name stands for a single key."""
    keys = {_key(result, k): str(result.branch_name.values[k]) for k in range(result.sizes["branch"])}
    by_name = bool(np.isnan(result.second_value.values).all()) and any(keys.values())
    left = [c for c in COLOURS if not by_name or c not in {COLOURS[i] for i in _NAMED.values()}]
    colours: dict[str, str] = {}
    for key, name in keys.items():
        own = COLOURS[_NAMED[name]] if by_name and name in _NAMED else None
        free = own is not None and own not in colours.values()
        colours[key] = str(own) if free else left[len([c for c in colours.values() if c in left]) % len(left)]
    return colours


def _pieces(result: xr.Dataset) -> Iterator[tuple[slice, str, int]]:
    """The stretches of branches that are drawn as one line: their points, key, and how many disturbances grow."""
    code = np.where(result.stable.values > 0, 0, np.clip(result.unstable.values, 1, 2))
    code = np.where(result.at_special.values > 0, -1, code)
    number = result.branch.values
    for k in range(result.sizes["branch"]):
        at = np.flatnonzero(number == k)
        own = code[at]
        of_segment = np.where(own[:-1] >= 0, own[:-1], own[1:])
        of_segment = np.where(of_segment >= 0, of_segment, 1)
        begins = np.concatenate([[0], np.flatnonzero(np.diff(of_segment)) + 1, [len(of_segment)]])
        for a, b in zip(begins[:-1].tolist(), begins[1:].tolist(), strict=True):
            if b > a:
                yield slice(int(at[a]), int(at[b]) + 1), _key(result, k), int(of_segment[a])


def _special_points(axis: Axes, result: xr.Dataset, name: str, factor: float) -> None:
    kinds = result.special_kind.values.astype(str)
    for kind in dict.fromkeys(kinds.tolist()):
        marker, face = _MARKS.get(kind, _OTHER_MARK)
        at = kinds == kind
        x, y = result.special_value.values[at], factor * result[f"special_{name}"].values[at]
        axis.plot(x, y, marker, color="black", markerfacecolor=face, markersize=5, markeredgewidth=1.0, zorder=5)


def _legend(colours: dict[str, str], used: set[int], result: xr.Dataset) -> list[Any]:
    from matplotlib.lines import Line2D

    single = next(iter(colours.values())) if len(colours) == 1 else GREY
    named = {key: colour for key, colour in colours.items() if key != _NO_NAME or len(colours) > 1}
    handles = [Line2D([], [], color=colour, linewidth=1.8, label=key) for key, colour in named.items()]
    handles += [Line2D([], [], color=single, label=_WORDS[code], **_LINES[code]) for code in sorted(used)]
    for kind in dict.fromkeys(result.special_kind.values.astype(str).tolist()):
        marker, face = _MARKS.get(kind, _OTHER_MARK)
        style = {"marker": marker, "markerfacecolor": face, "markersize": 5, "label": _SHOWN.get(kind, kind)}
        handles.append(Line2D([], [], color="black", linestyle="", **style))
    if result.sizes["own"]:
        value = f"{result.attrs['along']} = {summary_of(result)['value']:.5g} {result.attrs['along_unit']}".rstrip()
        handles.append(Line2D([], [], color=GREY, linestyle=":", linewidth=0.9, label=f"as it is:\n{value}"))
    return handles
