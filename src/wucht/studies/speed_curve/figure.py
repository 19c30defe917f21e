"""The figure of a speed curve: speed and amplitude over the parameter, as 002 figures 3.2, 5.2, 5.3 and A.1."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.page import small
from wucht.plots.sheet import legend_beside, new_figure, rpm_axis
from wucht.plots.stability_lines import Symbol, draw_kinds, entry, equal_stretches, kind_entries, smooth_curve
from wucht.plots.style import COLOURS, GREY, GUIDE, shades
from wucht.results.attributes import number_in, text_in
from wucht.results.formatting import label, parameter_in_words, printed_unit, units_in_print, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Transform = Callable[[np.ndarray, np.ndarray], np.ndarray]  # (values of the parameter, variable) -> ordinate

_LINES: dict[int, dict[str, Any]] = {  # by the number of growing disturbances; 2: or more
    0: {"linestyle": "-", "linewidth": 1.8, "zorder": 3},
    1: {"linestyle": (0, (4, 2)), "linewidth": 1.1, "zorder": 2},
    2: {"linestyle": (0, (5, 1.5, 1, 1.5)), "linewidth": 1.1, "zorder": 2},
    3: {"linestyle": (0, (1, 1)), "linewidth": 2.0, "zorder": 3},
}
_SOME_MEMBERS = 3  # line of families with some stable members
_WORDS = {
    0: "stable", 1: "unstable", 2: "unstable, several\ndisturbances grow", _SOME_MEMBERS: "some members of\nthe family stable",
}  # fmt: skip
_STATE_COLOURS = {"compensating": 2, "together": 0, "opposed": 1}  # fixed colours of these states
_MARKS: dict[str, Symbol] = {
    "fold": ("o", "white", ""), "hopf": ("D", "white", "Hopf point"), "branch-point": ("s", "black", ""),
    "some-stable": ("<", "white", "first members stable"), "all-stable": (">", "white", "all members stable"),
    "unresolved": ("x", "white", "not resolved"), "": ("^", "white", ""),
}  # fmt: skip
_SECOND_MARKS = ("P", "X", "*", "v", "h")
_DECADES = 100.0  # a range over which the abscissa is logarithmic
_ROOM = 0.06
_NO_NAME = "steady states"
_SAMPLE = 4.0  # width of a colour's sample in a legend, whose thin lines show the kinds of line
_WIDEST = 23  # characters of a line of a legend
_MOST_NAMED = 7  # values of the second parameter in the legend, if a colour scale is needed
_SMALLEST_DIVISOR = 1e-3  # of the largest value: a ratio to a smaller one is not drawn
_AS_PRESCRIBED = 1e-9


def speed_figure(result: xr.Dataset) -> Figure:
    """Draw panels over the parameter from a speed curve's Dataset alone: speed, amplitude if there is one, and the curves of
    special points where there is a second parameter with a range.
    """
    vibrates, plane = "amplitude" in result and bool((result.amplitude.values > 0).any()), "curve_value" in result
    panels = 1 + vibrates + plane
    fig, axes = new_figure(panels, result.attrs["title"], answer_in_print(result), 2.5 if panels > 1 else 3.4)
    colours, line_codes = _colours(result), set[int]()
    ratio = _ratio(result)
    _branches(axes[0], result, "speed", ratio, colours, line_codes)
    axes[0].set_ylabel(_ordinate_label(result, ratio))
    _types(axes[0], result, "speed", ratio)
    if vibrates:
        scale, unit = printed_unit(result, "amplitude")
        _branches(axes[1], result, "amplitude", lambda value, y: scale * y, colours, line_codes)
        _types(axes[1], result, "amplitude", lambda value, y: scale * y)
        axes[1].set(ylabel=label(result, "amplitude", unit), ylim=(0, None))
    if plane:
        _plane(axes[-1], result, colours)
    if _logarithmic(result):
        axes[-1].set_xscale("log")
    axes[-1].set_xlim(*_ends(result))
    axes[-1].set_xlabel(with_unit(_parameter_name(result), text_in(result, "along_unit")))
    if ratio is None and "speed" in result:
        rpm_axis(axes[0], str(result.speed.attrs["units"]))
    legend_beside(axes[0], _legend(colours, line_codes, result))
    return fig


def _ordinate_label(result: xr.Dataset, ratio: Transform | None) -> str:
    """Return the label of the first panel; user equations have the name of the state alone."""
    if "speed" not in result:
        return str(result.wucht.summary["show"])
    return label(result, "speed") if ratio is None else f"{result.speed.attrs['long_name']} / {_parameter_name(result)}"


def _ordinates(result: xr.Dataset, prefix: str, name: str) -> np.ndarray:
    """Return a variable of points; user equations have the state that is drawn instead of a speed."""
    if name == "speed" and "speed" not in result:
        row = result.state_name.values.tolist().index(result.wucht.summary["show"])
        return np.asarray(result[f"{prefix}state"].values[row])
    return np.asarray(result[f"{prefix}{name}"].values)


def _ratio(result: xr.Dataset) -> Transform | None:
    """Return the ratio of the ordinate to the parameter if both are speeds. None: the ordinate is drawn unchanged."""
    if "speed" not in result:
        return None
    criteria = (result.wucht.summary["show"], text_in(result, "along_unit"), result.speed.attrs["units"])
    if not result.sizes["point"] or criteria[0] is not None or not criteria[1] or criteria[1] != criteria[2]:
        return None
    least = _SMALLEST_DIVISOR * max(map(abs, _ends(result)))

    def speed_ratio(value: np.ndarray, speed: np.ndarray) -> np.ndarray:
        return np.where(np.abs(value) < least, np.nan, speed / np.where(np.abs(value) < least, 1.0, value))

    is_prescribed = np.nanmax(np.abs(speed_ratio(result.value.values, result.speed.values) - 1), initial=0.0) < _AS_PRESCRIBED
    return None if is_prescribed else speed_ratio


def _branches(
    axis: Axes, result: xr.Dataset, name: str, transform: Transform | None, colours: dict[str, str], line_codes: set[int]
) -> None:
    """Draw all branches with their special points. line_codes: collects the styles of the drawn lines."""
    ordinate = transform or (lambda _, y: y)
    y = ordinate(result.value.values, _ordinates(result, "", name))
    size = max(float(np.ptp(y[np.isfinite(y)])), _AS_PRESCRIBED) if np.isfinite(y).any() else 1.0
    low, high = _ends(result)
    for branch, pieces in _pieces(result):
        points = np.stack([result.value.values[branch], y[branch]])
        for begin, end, key, code in pieces:
            line_codes.add(code)
            panel = (high - low, size)
            axis.plot(*smooth_curve(points, panel, begin, end), color=colours[key], **_LINES[code])
    special = result.special_value.values, ordinate(result.special_value.values, _ordinates(result, "special_", name))
    draw_kinds(axis, *special, result.special_kind.values.astype(str), _MARKS)
    if result.sizes["own"]:
        axis.axvline(result.wucht.summary["value"], zorder=1, **GUIDE)
    axis.margins(y=_ROOM)
    if np.nanmin(y, initial=np.inf) >= 0 and (transform is None or name == "amplitude"):
        axis.set_ylim(bottom=0)


def _types(axis: Axes, result: xr.Dataset, variable: str, transform: Transform | None) -> None:
    """Write the type of its states on each branch, farthest from the others and from special points, if there is room."""
    if np.isfinite(result.second_value.values).any():
        return

    def panel_points(prefix: str) -> np.ndarray:
        """Return points in coordinates of the panel (2, N)."""
        value, y = result[f"{prefix}value"].values, _ordinates(result, prefix, variable)
        y = y if transform is None else transform(value, y)
        low, high = (np.log10(end) if _logarithmic(result) else end for end in _ends(result))
        return np.stack([((np.log10(value) if _logarithmic(result) else value) - low) / (high - low), y])

    at, special = panel_points(""), panel_points("special_")
    size = np.array([[1.0], [max(float(np.nanmax(at[1], initial=0.0) - np.nanmin(at[1], initial=0.0)), _AS_PRESCRIBED)]])
    for k, name in enumerate(result.branch_type.values.astype(str).tolist()):
        inside = (result.branch.values == k) & (at[0] > _ROOM) & (at[0] < 1 - _ROOM)
        if not name or not inside.any():
            continue
        obstacles = np.concatenate([at[:, result.branch.values != k], special], axis=1) / size
        room = np.hypot(*((at[:, inside] / size)[:, :, None] - obstacles[:, None, :])).min(axis=1, initial=1.0)
        best = int(np.nan_to_num(room).argmax())
        if room[best] > _ROOM:
            place = float(result.value.values[inside][best]), float(at[1, inside][best])
            box = {"pad": 0.8, "fc": "white", "ec": "none"}
            axis.annotate(name, place, ha="center", va="center", fontsize=small(), zorder=4, bbox=box)


def _logarithmic(result: xr.Dataset) -> bool:
    """True for a wide range of a parameter of a machine; one of other equations has a value at which something happens."""
    is_machine = "bodies" in result.wucht.machine
    low, high = _ends(result)
    return is_machine and 0 < _DECADES * low <= high


def _ends(result: xr.Dataset) -> tuple[float, float]:
    """Return the ends of the range of the parameter."""
    return number_in(result, "low"), number_in(result, "high")


def _plane(axis: Axes, result: xr.Dataset, colours: dict[str, str]) -> None:
    """Draw the curves of folds and Hopf points in both parameters."""
    number, legend_names = result.curve.values, set[str]()
    for k in range(result.sizes["curve_number"]):
        at, curve_type, steady_states = number == k, str(result.curve_of.values[k]), str(result.curve_label.values[k])
        name = f"{_MARKS[curve_type][2] or curve_type}s" + ("" if steady_states == _NO_NAME else f", {steady_states}")
        style: dict[str, Any] = {"color": colours.get(steady_states, GREY), "linestyle": "-" if curve_type == "fold" else "--"}
        x, y = result.curve_value.values[at], result.curve_second.values[at]
        axis.plot(x, y, linewidth=1.3, label=None if name in legend_names else _wrap_label(name), **style)
        legend_names.add(name)
    kinds = result.curve_kind.values.astype(str)
    for i, kind in enumerate(dict.fromkeys(k for k in kinds.tolist() if k)):
        at = kinds == kind
        x, y, marker = result.curve_value.values[at], result.curve_second.values[at], _SECOND_MARKS[i % len(_SECOND_MARKS)]
        name = kind.replace("-", " ").replace("hopf", "Hopf").replace("bogdanov takens", "Bogdanov-Takens")
        axis.plot(x, y, marker, color="black", markerfacecolor="white", markersize=6, zorder=5, label=_wrap_label(name))
    axis.set_ylabel(with_unit(text_in(result, "second_symbol"), text_in(result, "second_unit")))
    axis.axhline(result.wucht.summary["second_value"], zorder=1, **GUIDE)
    legend_beside(axis)


def _parameter_name(result: xr.Dataset) -> str:
    path, description = text_in(result, "along"), text_in(result, "along_what")
    return (
        description if "." in path else parameter_in_words(path, description).replace(path, text_in(result, "along_symbol"), 1)
    )


def _with_its_unit(number: str, unit: str) -> str:
    """Return a number with its unit, without a line break between them."""
    return units_in_print(f"{number} {unit}".rstrip()).replace(" ", "\N{NO-BREAK SPACE}")


def _wrap_label(text: str) -> str:
    """Wrap a name in a legend into lines that fit beside the panels."""
    return "\n".join(part for line in text.splitlines() for part in textwrap.wrap(line, _WIDEST))


def _key(result: xr.Dataset, branch: int) -> str:
    """Return the key of a branch's colour: the value of the second parameter, or the label of its states."""
    second = float(result.second_value[branch])
    if np.isnan(second):
        return str(result.branch_label.values[branch])
    path = text_in(result, "second")
    name = parameter_in_words(path, text_in(result, "second_what")) if "." in path else text_in(result, "second_symbol")
    return f"{name} = {_with_its_unit(_second_text(result, second), text_in(result, 'second_unit'))}"


def _second_text(result: xr.Dataset, second: float) -> str:
    """Return a value of the second parameter with four digits, or with six where four do not distinguish the values."""
    values = np.unique(result.second_value.values)
    digits = 4 if len({f"{v:.4g}" for v in values.tolist()}) == len(values) else 6
    return f"{second:.{digits}g}"


def _colours(result: xr.Dataset) -> dict[str, str]:
    """Return colours by key: fixed ones for named states, where a name has a single key; a scale for values."""
    values = {_key(result, k): float(result.second_value[k]) for k in range(result.sizes["branch"])}
    if np.isfinite(list(values.values())).all():
        return dict(zip(sorted(values, key=lambda key: values[key]), shades(len(values)), strict=True))
    keys = {_key(result, k): str(result.branch_name.values[k]) for k in range(result.sizes["branch"])}
    by_name = bool(np.isnan(result.second_value.values).all()) and any(keys.values())
    free_colours = [c for c in COLOURS if not by_name or c not in {COLOURS[i] for i in _STATE_COLOURS.values()}]
    colours: dict[str, str] = {}
    for key, name in keys.items():
        state_colour = COLOURS[_STATE_COLOURS[name]] if by_name and name in _STATE_COLOURS else None
        is_free = state_colour is not None and state_colour not in colours.values()
        colours[key] = (
            str(state_colour)
            if is_free
            else free_colours[len([c for c in colours.values() if c in free_colours]) % len(free_colours)]
        )
    return colours


def _pieces(result: xr.Dataset) -> Iterator[tuple[np.ndarray, list[tuple[int, int, str, int]]]]:
    """Yield the points of each branch and its stretches that are drawn as one line: first, last, key, and style."""
    share, grow = result.stable_share.values, result.unstable.values
    code = np.where(result.stable.values > 0, 0, np.where((share > 0) & (share < 1), _SOME_MEMBERS, np.clip(grow, 1, 2)))
    neutral = (code == 1) & (grow == 0)
    code = np.where((result.at_special.values > 0) | neutral, -1, code)
    number = result.branch.values
    for k in range(result.sizes["branch"]):
        at = np.flatnonzero(number == k)
        branch_codes = code[at]
        of_segment = np.where(branch_codes[:-1] >= 0, branch_codes[:-1], branch_codes[1:])
        of_segment = np.where(of_segment >= 0, of_segment, 1)
        yield at, [(a, b, _key(result, k), int(of_segment[a])) for a, b in equal_stretches(of_segment)]


def _legend(colours: dict[str, str], line_codes: set[int], result: xr.Dataset) -> list[Any]:
    single = next(iter(colours.values())) if len(colours) == 1 else GREY
    colour_entries = {key: colour for key, colour in colours.items() if key != _NO_NAME or len(colours) > 1}
    if np.isfinite(result.second_value.values).all() and len(colour_entries) > len(COLOURS):
        indices = np.linspace(0, len(colour_entries) - 1, _MOST_NAMED).round().astype(int).tolist()
        colour_entries = {key: colour_entries[key] for key in [list(colour_entries)[i] for i in indices]}
    handles = [entry(_wrap_label(key), color=colour, linewidth=_SAMPLE) for key, colour in colour_entries.items()]
    handles += [entry(_WORDS[code], color=single, **_LINES[code]) for code in sorted(line_codes)]
    handles += kind_entries(result.special_kind.values, _MARKS)
    if result.sizes["own"]:
        value_text = _with_its_unit(f"{result.wucht.summary['value']:.5g}", text_in(result, "along_unit"))
        value = (
            f"present: {value_text}"
            if "." in text_in(result, "along")
            else f"present:\n{text_in(result, 'along_symbol')} = {value_text}"
        )
        handles.append(entry(value, **GUIDE))
    return handles
