"""The figure of a prediction: speed, spectrum, power, residuals cam after cam, and the effect of springs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.cam_drawings import CAM_LOOKS, draw_bars_from, draw_motion, order_scale
from wucht.plots.page import small
from wucht.plots.scales import decades_about, plain_decades, prefixed_unit, travel_unit, turn_scale
from wucht.plots.sheet import draw_panels, labelled_handles, legend_above
from wucht.plots.style import BAR_STYLES, COLOURS, FREE, GREY, GUIDE
from wucht.results.formatting import with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    Panel = Callable[[Axes, xr.Dataset], None]
_COLOURS: dict[str, str] = {name: look["color"] for name, look in CAM_LOOKS.items()}
_RPM = 30 / math.pi
_LOWEST = 1e-8  # of the largest order: the lower end of the axis
_MOST_BARS = 24
_CLEAN = 1e-6  # of order 1: nothing
_APART = 0.13  # of the panel: labels nearer to each other are left out
_FEWEST_ROWS = 4
_SIMULATION_LABEL = "simulated"
_DOT: dict[str, Any] = {"linestyle": "none", "markersize": 3.4, "markeredgewidth": 0.6, "markeredgecolor": "black", "zorder": 5}
_DOT_MARKERS = {"original": "^", "corrected": "o"}
_TURN = "time of a turn (°)"


def draw_prediction(result: xr.Dataset) -> Figure:
    """Draw four panels; one more with a drive, two with an elastic output, one with an elastic shaft; the law fills the row."""
    panels: list[Panel] = [_speed, _spectrum, _power]
    panels += [_drive] if result.wucht.summary["driven"] == "drive" else []
    panels += [_cuts] if len(result.cut) else [_law]
    panels += [_speed_sweep, _excitations] if "residual_deviation" in result else []
    panels += [_twist] if "twist_residual" in result and len(result.twisted) else []
    if len(panels) % 2:
        panels.append(_law if _law not in panels else _travel)
    return draw_panels(result, panels, _legend)[0]


def _legend(axis: Axes) -> None:
    """Place the legend above the panel: the cams first, simulations last."""
    legend_above(axis, sorted(labelled_handles([axis]), key=lambda line: str(line.get_label()).startswith(_SIMULATION_LABEL)))


def _draw_cams(axis: Axes, result: xr.Dataset, values: xr.DataArray) -> None:
    """Draw a line for each cam over a turn."""
    for name, look in CAM_LOOKS.items():
        axis.plot(np.degrees(result.tau.values), values.sel(cam=name).values, linewidth=1.3, label=f"{name} cam", **look)
    turn_scale(axis, _TURN)


def _speed(axis: Axes, result: xr.Dataset) -> None:
    _draw_cams(axis, result, _RPM * result.speed)
    if "simulated_speed" in result:
        at = np.degrees(result.simulated_tau.values)
        for name in _COLOURS:
            _draw_simulated(axis, at, _RPM * result.simulated_speed.sel(cam=name).values, name)
    if "measured_speed" in result:
        look: dict[str, Any] = {"color": COLOURS[2], "linewidth": 1.1, "linestyle": ":", "label": "measured"}
        axis.plot(np.degrees(result.tau.values), _RPM * result.measured_speed.values, **look)
    axis.axhline(_RPM * result.wucht.summary["corrected"]["mean_speed"], **GUIDE)
    axis.set_ylabel("speed of the shaft (rpm)")
    axis.ticklabel_format(axis="y", useOffset=False)


def _spectrum(axis: Axes, result: xr.Dataset) -> None:
    amplitudes = result.output_acceleration.values[:, :_MOST_BARS]
    k, lowest = result.order.values[: amplitudes.shape[1]], _LOWEST * amplitudes.max()
    for row, (name, colour), aside in zip(amplitudes, _COLOURS.items(), (-0.2, 0.2), strict=True):
        high = np.where(row > lowest, row, np.nan)
        draw_bars_from(axis, lowest, k + aside, high, color=colour, label=f"{name} cam", **BAR_STYLES[aside < 0])
        if "simulated_acceleration" in result:
            dots = result.simulated_acceleration.sel(cam=name).values[: len(k)]
            _draw_simulated(axis, k + aside, np.where(dots > lowest, dots, np.nan), name)
    count = result.wucht.summary["above"]["orders"]
    if count is not None and k[0] <= count < k[-1]:
        axis.axvline(count + 0.5, **GUIDE)
    axis.set(yscale="log", ylim=(lowest, 3 * amplitudes.max()))
    plain_decades(axis.yaxis, alone=True)
    order_scale(axis, k)
    axis.set_ylabel(with_unit("acceleration, amplitude", str(result.output_acceleration.attrs["units"])))


def _draw_simulated(axis: Axes, at: np.ndarray, values: np.ndarray, name: str) -> None:
    """Draw points of a simulation with a cam, in its colour."""
    look: dict[str, Any] = _DOT | {"marker": _DOT_MARKERS[name], "markerfacecolor": _COLOURS[name]}
    axis.plot(at, values, label=f"{_SIMULATION_LABEL}, {name} cam", **look)


def _power(axis: Axes, result: xr.Dataset) -> None:
    """Draw the power that constant speed would need, beside the power of the drive."""
    degrees = np.degrees(result.tau.values)
    scale, unit = _power_unit(result)
    even = scale * result.power_at_constant_speed.values
    axis.plot(degrees, even, color=COLOURS[6], linewidth=1.1, linestyle="--", label="at constant speed", zorder=3)
    if result.wucht.summary["driven"] == "eigenmotion":
        axis.axhline(0.0, color=COLOURS[0], linewidth=1.3, label="eigenmotion")
    else:
        power = scale * result.drive_power.sel(cam="corrected").values
        axis.plot(degrees, power, color=_COLOURS["corrected"], linewidth=1.3, label="drive, corrected cam")
    axis.set_ylabel(f"power ({unit})")
    turn_scale(axis, _TURN)


def _power_unit(result: xr.Dataset) -> tuple[float, str]:
    """The factor and the unit of power, one for all panels."""
    powers = [result[name].values for name in ("power_at_constant_speed", "drive_power") if name in result]
    return prefixed_unit(np.concatenate([np.nan_to_num(values).ravel() for values in powers]), "W")


def _drive(axis: Axes, result: xr.Dataset) -> None:
    """Draw the power of the drive alone, on a separate scale."""
    scale, unit = _power_unit(result)
    _draw_cams(axis, result, scale * result.drive_power)
    axis.set_ylabel(f"power of the drive alone ({unit})")


def _cuts(axis: Axes, result: xr.Dataset) -> None:
    cuts, residuals = result.cut.values, result.cut_residual.values
    axis.plot(cuts, residuals, "o-", color=COLOURS[1], linewidth=1.1, markersize=5)
    axis.set(yscale="log", ylim=decades_about(residuals), xticks=cuts, xlim=(0.5, cuts[-1] + 0.5))
    plain_decades(axis.yaxis, alone=True)
    axis.set_xlabel("cam, cut for the speed with the one before")
    axis.set_ylabel(_measure(result))


def _measure(result: xr.Dataset) -> str:
    """The measure of an output against its law, as the name of an axis."""
    above = result.wucht.summary["above"]
    of = "orders off the law's" if above["orders"] is None else f"above order {above['orders']}"
    return f"{of}, over order {above.get('reference_order', 1)}"  # results of earlier versions lack it


def _law(axis: Axes, result: xr.Dataset) -> None:
    unit = draw_motion(axis, result, "acceleration", "/rad²", color=COLOURS[0], linewidth=1.3)
    axis.set_ylabel(f"acceleration of the cam's law ({unit})")
    turn_scale(axis)


def _travel(axis: Axes, result: xr.Dataset) -> None:
    unit = draw_motion(axis, result, "position", color=COLOURS[0], linewidth=1.3)
    axis.set_ylabel(f"law of the corrected cam ({unit})")
    turn_scale(axis)


def _speed_sweep(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = travel_unit(result.residual_deviation)
    speeds, deviations = _RPM * result.swept_speed.values, scale * result.residual_deviation.values
    for i, name in enumerate(result.lever.values.tolist()):
        colour, dashes = ((COLOURS[1], "--"), (COLOURS[0], "-"), (COLOURS[2], "-."))[i]
        axis.plot(speeds, deviations[i], dashes, color=colour, linewidth=1.2, label=name)
    last_label = math.inf
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
    for k, at in zip(result.resonance_order.values.tolist(), _RPM * result.resonance_speed.values, strict=True):
        axis.axvline(at, **GUIDE | {"linewidth": 0.6})
        if last_label - at >= _APART * (speeds[-1] - speeds[0]):  # from the fastest on
            last_label = at
            _annotate_foot(axis, f"k = {k}", at, 0, ha="center", bbox=box)
    mean = _RPM * result.wucht.summary["corrected"]["mean_speed"]
    if speeds[0] <= mean <= speeds[-1]:
        axis.axvline(mean, label="mean speed", **FREE)
    axis.set(yscale="log", ylim=decades_about(deviations), xlim=(speeds[0], speeds[-1]))
    plain_decades(axis.yaxis, alone=True)
    axis.set(xlabel="mean speed (rpm)", ylabel=with_unit("deviation in the dwell", unit))


def _annotate_foot(axis: Axes, text: str, x: float, aside: float, **look: Any) -> None:
    """Write a word at the lower edge of a panel."""
    place: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
    axis.annotate(text, (x, 0.0), (aside, 4), fontsize=small(), color=GREY, **place, **look)


def _excitations(axis: Axes, result: xr.Dataset) -> None:
    """Draw the residual vibration in the dwell at the mean speed, the smallest on top."""
    scale, unit = travel_unit(result.residual_deviation)
    names, size = result.excited.values.tolist(), scale * result.excited_deviation.values
    levers = result.lever.values.tolist()
    _bars(axis, size, [COLOURS[0] if name in levers else COLOURS[4] for name in names], names, decades_about(size))
    axis.set_xlabel(with_unit("deviation in the dwell at this speed", unit))


def _twist(axis: Axes, result: xr.Dataset) -> None:
    """Draw the residual of each cam behind an elastic shaft."""
    names, residuals = result.twisted.values.tolist(), result.twist_residual.values
    labels = [
        f"{name}: {100 * x:.3g} %" if x > _CLEAN else f"{name}: nothing" for name, x in zip(names, residuals, strict=True)
    ]
    colours = [_COLOURS.get(name.removesuffix(" cam"), COLOURS[2]) for name in names]
    _bars(axis, residuals, colours, labels, (_CLEAN, max(decades_about(residuals)[1], 1.0)))
    axis.set_xlabel(f"elastic shaft: {_measure(result)}")


def _bars(axis: Axes, size: np.ndarray, colours: list[str], names: list[str], limits: tuple[float, float]) -> None:
    """Draw bars one below the other from the lower limit on, on a logarithmic axis, each with its name above."""
    at = np.arange(len(names))[::-1]
    axis.barh(at, np.maximum(size - limits[0], 0.0), left=limits[0], height=0.34, color=colours)
    axis.set(xscale="log", xlim=limits, ylim=(min(len(names) - _FEWEST_ROWS, 0) - 0.5, len(names) - 0.2), yticks=[])
    plain_decades(axis.xaxis, alone=True)
    place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "fontsize": small()}
    for y, name in zip(at, names, strict=True):
        axis.annotate(name, (0.0, y + 0.2), (3, 0), va="bottom", **place)
