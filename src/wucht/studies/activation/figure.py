"""The figure of an activation: amplitude over the speed of the rotor, and the peaks over orientation or activation speed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.sheet import draw_panels, legend_beside
from wucht.plots.style import COLOURS, DASHES, FREE, GREY, line_style
from wucht.results.formatting import label, printed_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RIGID = "rigid"  # name of the runs in the Dataset
_OPENING = ("switchable", "balanced")  # variants whose pendulums open

# By variant; orientations differ by their dashes.
_MARKS: dict[str, dict[str, Any]] = {
    RIGID: {"marker": "x", "markersize": 4, "markevery": 0.06, "alpha": 0.7},
    "balanced": {"marker": "o", "markersize": 3, "markerfacecolor": "white", "markevery": 0.06},
}


def figure(result: xr.Dataset) -> Figure:
    """Draw an activation from its Dataset: two panels, or one for a single orientation and activation speed."""
    several = result.peak.sizes["orientation"] * result.peak.sizes["activation_speed"] > 1
    panels = [_curves, _peaks] if several else [_curves]
    return draw_panels(result, panels, legend_beside, columns=1, heights=2.5)[0]


def _curves(axis: Axes, result: xr.Dataset) -> None:
    amplitudes, amplitude_label = printed_values(result, "curve_amplitude")
    names = list(map(str, result.curve.values))
    angle_names = list(dict.fromkeys(name.partition(", ")[2] for name in names if ", " in name))
    for i, name in enumerate(names):
        kind, _, angle = name.partition(", ")
        colour = COLOURS[angle_names.index(angle) % (len(COLOURS) - 1)] if angle else COLOURS[-1]
        look: dict[str, Any] = {"linestyle": DASHES[angle_names.index(angle) % len(DASHES)] if angle else "-", "linewidth": 1.2}
        axis.plot(result.curve_speed.values[i], amplitudes[i], label=name, color=colour, **look | _MARKS.get(kind, {}))
    first = float(result.activation_speed.values[0])
    if any(name.startswith(_OPENING) for name in names):
        axis.axvline(first, **FREE, label=f"activation speed {first:.4g} rad/s")
    name_speeds(axis, result, "curve_speed", "x")
    axis.set(ylabel=amplitude_label, ylim=(0, None))


def _peaks(axis: Axes, result: xr.Dataset) -> None:
    """Draw the peaks over the orientation; over the activation speed if there is only one orientation."""
    (scale, unit), speeds = printed_unit(result, "peak"), result.activation_speed.values
    degrees, over_speed = np.degrees(result.orientation.values), len(result.orientation) == 1 and len(speeds) > 1
    rows = [result.peak.values[:, 0]] if over_speed else list(result.peak.values)
    at = speeds if over_speed else degrees
    for i, row in enumerate(rows):
        look = line_style(i)
        name = "switchable" if over_speed or len(speeds) == 1 else f"switchable, {speeds[i]:.4g} rad/s"
        if np.isfinite(row).any():
            _band(axis, at, scale * row, look["color"], look["linestyle"], name)
    for name, colour, dashes in (("balanced", COLOURS[3], "-."), (RIGID, GREY, ":")):
        reference_peaks = scale * result[f"{name}_peak"].values
        if np.isfinite(reference_peaks).any():
            _band(
                axis, at, np.repeat(reference_peaks, len(at), axis=0) if over_speed else reference_peaks, colour, dashes, name
            )
    if np.isfinite(float(result.none_peak)):
        axis.axhline(scale * float(result.none_peak), color=COLOURS[6], linewidth=0.9, label="without pendulums")
    axis.set_xlabel(label(result, "activation_speed") if over_speed else "orientation at the start (°)")
    if not over_speed:
        axis.set_xticks(degrees)
    axis.set(ylabel=label(result, "peak", unit), ylim=(0, None))


def _band(axis: Axes, at: np.ndarray, peaks: np.ndarray, colour: str, dashes: str, name: str) -> None:
    """Draw peaks (n, phases): their mean and their range."""
    is_complete = np.isfinite(peaks).all(axis=1)
    inside, abscissa = peaks[is_complete], at[is_complete]
    axis.plot(abscissa, inside.mean(axis=1), "o", linestyle=dashes, color=colour, markersize=3.5, linewidth=1.1, label=name)
    if peaks.shape[1] > 1:
        axis.fill_between(abscissa, inside.min(axis=1), inside.max(axis=1), color=colour, alpha=0.2, linewidth=0)
