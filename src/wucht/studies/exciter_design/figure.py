"""The figure of a design: spectra, a beat, reachable spectra, the search, tolerances."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import decades_about, plain_decades
from wucht.plots.sheet import colour_bar, draw_panels
from wucht.plots.style import COLOURS, GUIDE, line_style
from wucht.results.formatting import abscissa_label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TICKS = 5
_FULLNESS = "fullness: mean amplitude, 0 as\nthe smallest, 1 as the largest"
_MARK: dict[str, Any] = {"markeredgecolor": "black", "linestyle": ""}
_TARGET_MARK: dict[str, Any] = _MARK | {"marker": "*", "color": COLOURS[1], "markersize": 14, "label": "target"}
_DESIGN_MARK: dict[str, Any] = _MARK | {"marker": "X", "color": "white", "markersize": 9, "label": "design, averaged equations"}
_LINES: dict[str, dict[str, Any]] = {
    "amplitude_wanted": {"label": "target", "color": "black", "linestyle": "-", "linewidth": 1.8},
    "amplitude_slow": {"label": "averaged equations", "color": COLOURS[0], "linestyle": "--", "linewidth": 1.2},
    "amplitude_full": {"label": "full equations", "color": COLOURS[1], "linestyle": "-.", "linewidth": 1.2},
}


def figure(result: xr.Dataset) -> Figure:
    """Draw up to six panels from a design's Dataset alone."""
    panels: list[Callable[[Axes, xr.Dataset], None]] = [partial(_spectra, by_number=by_number) for by_number in (True, False)]
    panels += [_beat] if len(result["beat_time"]) else []
    panels += [_reach]
    panels += [_search] if np.isfinite(result["tried_distance"].values).any() else []
    panels += [_tolerances] if np.isfinite(result["tolerance_distance"].values).any() else []
    return draw_panels(result, panels)[0]


def _spectra(axis: Axes, result: xr.Dataset, by_number: bool) -> None:
    """Draw amplitude over cumulative cycles (002 figure 6.6), or over their share: an area between lines is a distance."""
    scale, unit = printed_unit(result, "amplitude_wanted")
    x = result["share"].values * (float(result["wanted_cycles"]) if by_number else 1.0)
    for name, look in _LINES.items():
        if np.isfinite(result[name].values).any():
            axis.plot(x, scale * result[name].values, **look)
    if by_number:
        axis.set_xscale("log")
        plain_decades(axis.xaxis)
    over = "cumulative cycles" if by_number else "share of the cycles that reach the amplitude"
    axis.set(title="cumulative spectrum", xlabel=over, ylabel=with_unit("amplitude", unit), ylim=(0, None))


def _beat(axis: Axes, result: xr.Dataset) -> None:
    """Draw the vibration of the full equations between its turning points, and the amplitude of the averaged ones."""
    scale, unit = printed_unit(result, "amplitude_wanted")
    time, amplitude = result["beat_time"].values, scale * result["beat_amplitude"].values
    turning_time, values = result["turning_time"].values, scale * result["turning_value"].values
    axis.plot(turning_time, values, color=COLOURS[4], linewidth=0.8, label="full equations")
    for sign, name in ((1, "amplitude, averaged equations"), (-1, None)):
        axis.plot(time, sign * amplitude, label=name, **line_style(0) | {"linestyle": "--"})
    largest = float(np.abs(np.concatenate([values, amplitude])).max())
    axis.set(title="one beat of the design", xlabel=abscissa_label(result, "beat_time", "time"))
    axis.set(ylabel=with_unit("amplitude", unit), ylim=(-1.1 * largest, 1.1 * largest))


def _reach(axis: Axes, result: xr.Dataset) -> None:
    """Draw largest amplitudes and ratios that the exciter reaches within the ranges, and the fullness of its spectra."""
    scale, unit = printed_unit(result, "amplitude_wanted")
    x, y = scale * result["tried_upper"].values, result["tried_ratio"].values
    is_finite = np.isfinite(x)
    if is_finite.any():
        look: dict[str, Any] = {"s": 9, "cmap": "cividis", "label": "candidates"}
        colour_bar(
            axis, axis.scatter(x[is_finite], y[is_finite], c=result["tried_fullness"].values[is_finite], **look), _FULLNESS
        )
    axis.plot(scale * float(result["wanted_upper"]), float(result["wanted_ratio"]), **_TARGET_MARK)
    if len(result["beat_amplitude"]):
        amplitude = result["beat_amplitude"].values
        axis.plot(scale * amplitude.max(), amplitude.min() / amplitude.max(), **_DESIGN_MARK)
    axis.set(title="reachable spectra", xlabel=with_unit("largest amplitude", unit), xlim=(0, None), ylim=(0, 1))
    axis.set_ylabel("smallest over largest amplitude")


def _search(axis: Axes, result: xr.Dataset) -> None:
    far = result["tried_distance"].values
    number, is_finite = np.arange(1, len(far) + 1), np.isfinite(far)
    axis.plot(number[is_finite], far[is_finite], ".", color="#AAAAAA", markersize=3, label="candidate")
    best = np.minimum.accumulate(np.where(is_finite, far, np.inf))
    axis.plot(number, np.where(np.isfinite(best), best, np.nan), label="best so far", **line_style(0))
    axis.axvline(len(result["reach_distance"]) + 0.5, **GUIDE, label="search begins")
    for name, marker, k, equations in (("run_slow", "v", 0, "averaged"), ("run_full", "o", 1, "full")):
        runs = result[name].values
        beside = len(far) * 1.03 + np.arange(len(runs)) * 0.02 * len(far)
        axis.plot(beside, runs, marker, color=COLOURS[k], markersize=4, label=f"checked, {equations}")
    axis.set(yscale="log", ylim=decades_about(np.concatenate([far[is_finite], result.run_slow.values, result.run_full.values])))
    plain_decades(axis.yaxis, alone=True)
    axis.set(title="search with the averaged equations", xlabel="candidate")
    axis.set_ylabel(f"distance, {result.wucht.summary['metric']}")


def _tolerances(axis: Axes, result: xr.Dataset) -> None:
    """Draw the share of the exciters within tolerances that are nearer than a distance."""
    s, far = result.wucht.summary, result["tolerance_distance"].values
    near = np.sort(far[np.isfinite(far)])
    if len(near):
        name = f"all that is varied, ±{100 * s['tolerances']['spread']:.1f} %"
        axis.step(near, np.arange(1, len(near) + 1) / len(far), where="post", label=name, **line_style(0))
    if s["distance"] is not None:
        axis.locator_params(axis="x", nbins=_TICKS)
        axis.axvline(s["distance"], color=COLOURS[1], linestyle="--", linewidth=1.0, label="design")
    axis.set(
        title="exciters within tolerances", xlabel=f"distance, {s['metric']}", ylabel="share that is nearer", ylim=(0, 1.02)
    )
