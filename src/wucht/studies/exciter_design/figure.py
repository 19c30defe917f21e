"""The figure of a design: spectra, a beat, what can be reached, the search, tolerances."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import sheet, style
from wucht.results.conventions import summary_of
from wucht.results.formatting import label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TICKS = 5
_WANTED: dict[str, Any] = {
    "marker": "*",
    "color": style.COLOURS[1],
    "markeredgecolor": "black",
    "markersize": 14,
    "linestyle": "",
}
_DESIGN: dict[str, Any] = {"marker": "X", "color": "white", "markeredgecolor": "black", "markersize": 9, "linestyle": ""}
_LINES: dict[str, tuple[str, dict[str, Any]]] = {
    "amplitude_wanted": ("wanted", {"color": "black", "linestyle": "-", "linewidth": 1.8}),
    "amplitude_slow": ("averaged equations", {"color": style.COLOURS[0], "linestyle": "--", "linewidth": 1.2}),
    "amplitude_full": ("full equations", {"color": style.COLOURS[1], "linestyle": "-.", "linewidth": 1.2}),
}


def figure(result: xr.Dataset) -> Figure:
    """Up to six panels from a design's Dataset alone."""
    scale, unit = printed_unit(result, "amplitude_wanted")
    panels: list[Callable[[Axes, xr.Dataset], None]] = [
        partial(_spectra, scale=scale, unit=unit, by_number=by_number) for by_number in (True, False)
    ]
    panels += [partial(_beat, scale=scale, unit=unit)] if len(result["beat_time"]) else []
    panels += [partial(_reach, scale=scale, unit=unit)]
    panels += [_search] if np.isfinite(result["tried_distance"].values).any() else []
    panels += [_tolerances] if np.isfinite(result["tolerance_distance"].values).any() else []
    drawn, axes = sheet.new_grid(len(panels), result.attrs["title"], result.attrs["sentence"])
    for panel, axis in zip(panels, axes, strict=True):
        panel(axis, result)
        sheet.legend_above(axis)
    return drawn


def _spectra(axis: Axes, result: xr.Dataset, scale: float, unit: str, by_number: bool) -> None:
    """002 figure 6.6: amplitude over cumulative cycles; or over their share, the area between two lines being a distance."""
    x = result["share"].values * (float(result["wanted_cycles"]) if by_number else 1.0)
    for name, (words, look) in _LINES.items():
        if np.isfinite(result[name].values).any():
            axis.plot(x, scale * result[name].values, label=words, **look)
    if by_number:
        axis.set_xscale("log")
        style.plain_decades(axis.xaxis)
    axis.set_title("cumulative spectrum")
    axis.set_xlabel("cumulative cycles" if by_number else "share of the cycles that reach the amplitude")
    axis.set_ylabel(with_unit("amplitude", unit))
    axis.set_ylim(bottom=0)


def _beat(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    axis.set_title("one beat of the design")
    axis.set_xlabel("time $\\tau$" if result.attrs["dimensionless"] else label(result, "beat_time"))
    axis.set_ylabel(with_unit("amplitude", unit))
    axis.set_ylim(0, None)
    time, amplitude = result["beat_time"].values, scale * result["beat_amplitude"].values
    axis.fill_between(
        time, -amplitude, amplitude, color=style.COLOURS[4], alpha=0.5, linewidth=0, label="the vibration lies here"
    )
    axis.plot(time, amplitude, label="amplitude", **style.line_style(0))
    axis.set_ylim(-1.1 * amplitude.max(), 1.1 * amplitude.max())


def _reach(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    """Which largest amplitudes and which ratios the exciter can have within the ranges, and how full its spectra are."""
    axis.set_title("what can be reached")
    axis.set_xlabel(with_unit("largest amplitude", unit))
    axis.set_ylabel("smallest over largest amplitude")
    x, y = scale * result["tried_upper"].values, result["tried_ratio"].values
    known = np.isfinite(x)
    if known.any():
        colours: Any = axis.scatter(
            x[known], y[known], c=result["tried_fullness"].values[known], s=9, cmap="cividis", label="tried, by fullness"
        )
        sheet.colour_bar(axis, colours, "fullness")
    axis.plot(scale * float(result["wanted_upper"]), float(result["wanted_ratio"]), label="wanted", **_WANTED)
    if len(result["beat_amplitude"]):
        amplitude = result["beat_amplitude"].values
        axis.plot(scale * amplitude.max(), amplitude.min() / amplitude.max(), label="design, averaged equations", **_DESIGN)
    axis.set_xlim(left=0)
    axis.set_ylim(0, 1)


def _search(axis: Axes, result: xr.Dataset) -> None:
    axis.set_title("search with the averaged equations")
    axis.set_xlabel("candidate")
    axis.set_ylabel(f"distance, {summary_of(result)['metric']}")
    far = result["tried_distance"].values
    number, known = np.arange(1, len(far) + 1), np.isfinite(far)
    axis.plot(number[known], far[known], ".", color="#AAAAAA", markersize=3, label="candidate")
    best = np.minimum.accumulate(np.where(known, far, np.inf))
    axis.plot(number, np.where(np.isfinite(best), best, np.nan), label="best so far", **style.line_style(0))
    axis.axvline(len(result["reach_distance"]) + 0.5, color=style.GREY, linestyle=":", linewidth=0.9, label="search begins")
    for name, marker, colour in (("run_slow", "v", style.COLOURS[0]), ("run_full", "o", style.COLOURS[1])):
        runs = result[name].values
        equations = "averaged" if name == "run_slow" else "full"
        axis.plot(
            len(far) * 1.03 + np.arange(len(runs)) * 0.02 * len(far),
            runs,
            marker,
            color=colour,
            markersize=4,
            label=f"checked, {equations}",
        )
    axis.set_yscale("log")
    style.plain_decades(axis.yaxis)


def _tolerances(axis: Axes, result: xr.Dataset) -> None:
    """The share of the exciters within tolerances that are nearer than a distance."""
    s = summary_of(result)
    axis.set_title("exciters within tolerances")
    axis.set_xlabel(f"distance, {s['metric']}")
    axis.set_ylabel("share that is nearer")
    axis.set_ylim(0, 1.02)
    far = result["tolerance_distance"].values
    near = np.sort(far[np.isfinite(far)])
    if len(near):
        spread = s["tolerances"]["spread"]
        axis.step(
            near,
            np.arange(1, len(near) + 1) / len(far),
            where="post",
            label=f"all that is varied, ±{spread:.1%}",
            **style.line_style(0),
        )
    if s["distance"] is not None:
        axis.locator_params(axis="x", nbins=_TICKS)
        axis.axvline(s["distance"], color=style.COLOURS[1], linestyle="--", linewidth=1.0, label="design")
