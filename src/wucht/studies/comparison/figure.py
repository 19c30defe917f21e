"""The figure of a comparison: the curves of all variants in common panels, and numbers over the varied keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import style
from wucht.plots.page import current_page, small
from wucht.plots.scales import printed_values
from wucht.plots.sheet import labelled_handles, legend_above, legend_below, new_grid
from wucht.plots.time_courses import TurnWindows, draw_course, shown_until
from wucht.results.comparison_table import shown_numbers, variant_names
from wucht.results.formatting import printed_unit, value_in_words, wrap_text
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_CURVES, _MOST_NUMBERS, _MOST_NAMED = 2, 2, 14
_PANEL, _LINE = 2.1, 0.19  # inches: of a panel, and of a line of text
_LETTERS = 14.0  # of text in an inch
_COUNTS = ("count", "pole_pairs", "seed")  # keys with whole numbers: there is nothing between their values to join them by
_MARKS, _LINES = "os^Dv", ("-", "--", "-.", ":")
_MOST_WRITTEN = 8  # variants named below a panel; further ones are only counted
_WORDS, _APART = 40, 2  # letters that fit there side by side, and between two names


def figure(result: xr.Dataset) -> Figure:
    """Draw up to two panels of curves, and up to two of numbers where keys are varied or no study has curves.

    A variant's mark has the colour of its curve.
    """
    count, title, sentence = len(_abscissae(result)), result.attrs["title"], answer_in_print(result)
    curves, numbers = range(1, min(count, _MOST_CURVES) + 1), shown_numbers(result)[:_MOST_NUMBERS]
    if not count and not numbers:
        return _text_figure(result)
    numbers = numbers if result.wucht.summary["vary"] or not count else []
    has_one_abscissa, panels = len({tuple(x.attrs.values()) for x in _abscissae(result)}) == 1, len(curves) + len(numbers)
    columns = 1 if panels == 1 or (not numbers and has_one_abscissa) else 2
    fig, axes = new_grid(max(panels, 1), title, sentence, columns=columns, heights=_PANEL)
    for k, axis in zip(curves, axes, strict=False):
        _curves(axis, result, k, _legend_names(result))
    for name, axis in zip(numbers, axes[len(curves) :], strict=False):
        _numbers(axis, result, name)
    handles, paths = axes[0].get_legend_handles_labels()[0], list(result.wucht.summary["vary"])
    if curves:
        legend_below(fig, handles, "; ".join(_titles(result, paths)) or None)
    if numbers and (groups := labelled_handles(axes[len(curves) : len(curves) + 1])):
        legend_above(axes[len(curves)], groups, "; ".join(_titles(result, paths[1:])) or None)
    return fig


def _text_figure(result: xr.Dataset) -> Figure:
    """Write the verdicts where there are neither curves nor numbers."""
    letters = int(current_page().width * _LETTERS)
    results = [f"{name}: {text}" for name, text in zip(result.variant.values, result.sentence.values, strict=True)]
    lines = ["\n".join(wrap_text(entry, letters)) for entry in results[:_MOST_WRITTEN]]
    text = "\n".join([*lines, *([f"and {len(results) - len(lines)} more"] if len(results) > len(lines) else [])])
    height = (text.count("\n") + 1) * _LINE / current_page().height
    fig, [axis] = new_grid(1, result.attrs["title"], answer_in_print(result), columns=1, heights=height)
    axis.set_axis_off()
    axis.text(0.0, 1.0, text, va="top", fontsize=small(), linespacing=1.5, parse_math=False)
    return fig


def _abscissae(result: xr.Dataset) -> list[xr.DataArray]:
    return [result[n] for n in result.variables if str(n).startswith("curve_") and str(n).endswith("_x")]


def _legend_names(result: xr.Dataset) -> list[str]:
    """Return the names of the variants in the legend, below the varied keys."""
    words = [_variant_label(result, k) for k in range(result.sizes["variant"])]
    names = [f"{name}: {outcome}" if outcome else name for name, outcome in zip(words, result.outcome.values, strict=True)]
    return names if len(names) <= _MOST_NAMED else [*names[: _MOST_NAMED - 1], f"and {len(names) - _MOST_NAMED + 1} more"]


def _variants_with_curves(result: xr.Dataset) -> list[int]:
    """Return the variants with curves: not those that failed."""
    has_curve = [result[f"curve_{k}_y"].notnull().any(f"sample_{k}").values for k in range(1, len(_abscissae(result)) + 1)]
    return [int(k) for k in np.flatnonzero(np.any(has_curve, axis=0))] if has_curve else []


def _variant_label(result: xr.Dataset, variant: int, paths: Sequence[str] | None = None) -> str:
    """Return the label of a variant: its name and the values of varied keys (paths: of these only)."""
    paths = list(result.wucht.summary["vary"]) if paths is None else paths
    name = variant_names(result)[variant]
    return "; ".join([*([name] if name else []), *(_value(result, path, variant) for path in paths)])


def _value(result: xr.Dataset, path: str, variant: int) -> str:
    return value_in_words(result[path].values[variant].item(), *printed_unit(result, path))


def _titles(result: xr.Dataset, paths: Sequence[str]) -> list[str]:
    return [str(result[path].attrs["long_name"]) for path in paths]


def _curves(axis: Axes, result: xr.Dataset, number: int, names: list[str]) -> None:
    (x, x_name), (y, y_name) = (printed_values(result, f"curve_{number}_{n}") for n in "xy")
    has_time_axis = result[f"curve_{number}_x"].attrs["long_name"] == "time"
    summaries = [variant.get("summary", {}) for variant in result.wucht.summary["variants"]]
    for k in _variants_with_curves(result):
        look = style.line_style(k) | {"label": names[k] if k < len(names) else None}
        inside = np.isfinite(x[k]) & np.isfinite(y[k])
        if not inside.any():  # it has another one of the curves alone
            continue
        if has_time_axis:
            until = min(shown_until(summaries, float(np.nanmax(x))), float(x[k][inside].max(initial=-np.inf)))
            draw_course(axis, TurnWindows.even(x[k][inside], until), y[k][inside], **look)
        else:
            axis.plot(x[k], y[k], **look)
    axis.set(xlabel=x_name, ylabel=y_name)


def _numbers(axis: Axes, result: xr.Dataset, name: str) -> None:
    """Draw a number over the first varied key, a line for each file and value of the second; else over the variants."""
    (values, axis_label), paths = printed_values(result, name), list(result.wucht.summary["vary"])
    is_continuous = bool(paths) and result[paths[0]].dtype.kind == "f" and paths[0].split(".")[-1] not in _COUNTS
    axis.set_ylabel(axis_label)
    groups = _groups(result, paths[1:]) if paths else [list(range(len(values)))]
    x = _abscissa(axis, result, paths)
    for j, members in enumerate(groups):
        at = [members[k] for k in np.argsort(x[members], kind="stable")]
        marker, dashes = _MARKS[j % len(_MARKS)], _LINES[j // len(_MARKS) % len(_LINES)] if is_continuous else ""
        group = _variant_label(result, members[0], paths[1:]) if 1 < len(groups) <= _MOST_NAMED else None
        mark: dict[str, Any] = {"marker": marker, "markersize": 6, "markerfacecolor": "none", "markeredgewidth": 1.4}
        axis.plot(x[at], values[at], label=group, color=style.GREY, linewidth=0.9, linestyle=dashes, **mark)
        for k in at:
            axis.plot(x[k], values[k], color=style.line_style(k)["color"], linestyle="", **mark)


def _groups(result: xr.Dataset, paths: Sequence[str]) -> list[list[int]]:
    """Return the variants of each file and of each value of the other varied keys."""
    groups: dict[tuple[Any, ...], list[int]] = {}
    for k in range(result.sizes["variant"]):
        groups.setdefault((str(result.source.values[k]), *(result[p].values[k] for p in paths)), []).append(k)
    return list(groups.values())


def _abscissa(axis: Axes, result: xr.Dataset, paths: Sequence[str]) -> np.ndarray:
    """Return the places (n,) of the variants on the axis: by the first varied key, its texts, or one after the other."""
    if paths and result[paths[0]].dtype.kind == "f":
        x, name = printed_values(result, paths[0])
        axis.set_xlabel(name)
        if (np.round(x) == x).all():
            axis.locator_params(axis="x", integer=True)
        return x
    texts = [str(v) for v in (result[paths[0]].values if paths else result.variant.values)]
    places = list(dict.fromkeys(texts))
    axis.set_xlim(-0.5, len(places) - 0.5)
    axis.set_xlabel(_titles(result, paths)[0] if paths else "variant")
    if len(places) <= _MOST_WRITTEN:
        axis.set_xticks(range(len(places)), ["\n".join(wrap_text(t, max(_WORDS // len(places) - _APART, 5))) for t in places])
    return np.array([places.index(text) for text in texts], float)
