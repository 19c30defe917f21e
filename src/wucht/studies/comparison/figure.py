"""The figure of a comparison: the curves of all variants upon each other, and numbers over what is varied."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results import style
from wucht.results.conventions import summary_of
from wucht.results.sheet import legend_above, legend_below, new_grid
from wucht.studies.comparison.report import shown_numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_CURVES, _MOST_NUMBERS, _MOST_NAMED = 2, 2, 14
_PANEL = 2.1  # inches
_MARKS = "os^Dv"


def figure(result: xr.Dataset) -> Figure:
    """Up to two panels of curves, and up to two of numbers where something is varied or no study has curves."""
    count, title, sentence = len(_abscissae(result)), result.attrs["title"], result.attrs["sentence"]
    curves, numbers = range(1, min(count, _MOST_CURVES) + 1), shown_numbers(result)[:_MOST_NUMBERS]
    numbers = numbers if summary_of(result)["vary"] or not count else []
    alike, panels = len({tuple(x.attrs.values()) for x in _abscissae(result)}) == 1, len(curves) + len(numbers)
    columns = 1 if panels == 1 or (not numbers and alike) else 2
    drawn, axes = new_grid(max(panels, 1), title, sentence, columns=columns, heights=_PANEL)
    for k, axis in zip(curves, axes, strict=False):
        _curves(axis, result, k, _names(result))
    for name, axis in zip(numbers, axes[len(curves) :], strict=False):
        _numbers(axis, result, name)
    if curves:
        legend_below(drawn, axes[0].get_legend_handles_labels()[0])
    return drawn


def _abscissae(result: xr.Dataset) -> list[xr.DataArray]:
    return [result[n] for n in result.data_vars if str(n).startswith("curve_") and str(n).endswith("_x")]


def _names(result: xr.Dataset) -> list[str]:
    """What the variants are called in the legend."""
    pairs = zip(result.variant.values, result.outcome.values, strict=True)
    names = [f"{variant}: {outcome}" if outcome else str(variant) for variant, outcome in pairs]
    return names if len(names) <= _MOST_NAMED else [*names[: _MOST_NAMED - 1], f"and {len(names) - _MOST_NAMED + 1} more"]


def _curves(axis: Axes, result: xr.Dataset, number: int, names: list[str]) -> None:
    x, y = (result[f"curve_{number}_{n}"] for n in "xy")
    (x_scale, x_unit), (y_scale, y_unit) = (style.printed_unit(result, str(v.name)) for v in (x, y))
    for k in range(result.sizes["variant"]):
        name = names[k] if k < len(names) else None
        axis.plot(x_scale * x.values[k], y_scale * y.values[k], label=name, **style.line_style(k))
    axis.set_xlabel(style.label(result, str(x.name), x_unit))
    axis.set_ylabel(style.label(result, str(y.name), y_unit))


def _numbers(axis: Axes, result: xr.Dataset, name: str) -> None:
    """A number over the first key that is varied, a line for each file and value of the second; else a mark a variant."""
    scale, unit = style.printed_unit(result, name)
    values, paths = scale * result[name].values, list(summary_of(result)["vary"])
    axis.set_ylabel(style.label(result, name, unit))
    if not paths or result[paths[0]].dtype.kind != "f":
        axis.plot(np.arange(len(values)), values, linestyle="", marker="o", color=style.COLOURS[0])
        axis.set_xlim(-0.5, len(values) - 0.5)
        axis.set_xticks(np.arange(len(values)), [str(v) for v in result.variant.values], rotation=25, ha="right", fontsize=7)
        return
    x_scale, x_unit = style.printed_unit(result, paths[0])
    groups: dict[tuple[Any, ...], list[int]] = {}
    for k in range(len(values)):
        groups.setdefault((str(result.source.values[k]), *(result[p].values[k] for p in paths[1:])), []).append(k)
    several = len(set(result.source.values)) > 1
    for j, members in enumerate(groups.values()):
        at = np.argsort(result[paths[0]].values[members])
        label = _group(result, members[0], paths, several)
        line = style.line_style(j) | {"marker": _MARKS[j % len(_MARKS)], "markersize": 4}
        axis.plot(x_scale * result[paths[0]].values[members][at], values[members][at], label=label or None, **line)
    axis.set_xlabel(style.label(result, paths[0], x_unit))
    if 1 < len(groups) <= _MOST_NAMED:
        legend_above(axis)


def _group(result: xr.Dataset, first: int, paths: list[str], several: bool) -> str:
    """What the variants of a line have in common: their file, and the value of the second key."""
    named = [str(result.source.values[first])] if several else []
    for path in paths[1:]:
        value, (scale, unit) = result[path].values[first], style.printed_unit(result, path)
        named.append(f"{path} = {f'{scale * value:.6g} {unit}'.rstrip() if result[path].dtype.kind == 'f' else value}")
    return "; ".join(named)
