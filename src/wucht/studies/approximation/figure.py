"""The figure of the study ``approximation``, in the manner of 002 figures 5.16 to 5.19."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from wucht.plots.sheet import legend_above, legend_below, named_in, new_grid
from wucht.plots.stability_lines import draw_classes
from wucht.plots.style import COLOURS, GREY, line_style
from wucht.results.formatting import label, printed_unit, with_unit

_SMALLEST = 1e-6  # of the largest deviation: lower limit of the scale
_MOST_NAMED = 9
# 1: the outcomes agree; 0: they differ; -1: there is none yet.
_OUTCOMES = {1: ("o", COLOURS[0], "same outcome"), 0: ("s", "white", "outcomes differ"), -1: ("X", GREY, "no outcome yet")}
_LIMIT: dict[str, Any] = {"color": GREY, "linestyle": (0, (9, 2)), "linewidth": 1.6, "zorder": 1}


def figure(result: xr.Dataset) -> Figure:
    """Draw the deviations over the rotor's angle, over the parameter, and over epsilon, from the Dataset alone."""
    varied, measured = bool(np.isfinite(result.value.values).any()), result.wucht.summary["order_of_error"] is not None
    drawn, (speed, amplitude, *rest) = new_grid(2 + varied + measured, result.attrs["title"], result.attrs["sentence"])
    _over_angle(speed, result, "speed_over_angle")
    _over_angle(amplitude, result, "amplitude_over_angle")
    if varied:
        _along(rest[0], result)
    if measured:
        _order(rest[-1], result)
    legend_below(drawn, named_in([speed, amplitude]))
    return drawn


def _over_angle(axis: Axes, result: xr.Dataset, name: str) -> None:
    scale, unit = printed_unit(result, name)
    values, own = scale * result[name].values, len(result.value) - 1
    for k, value in enumerate(result.value.values):
        shown = f"{value:.4g} {result.value.attrs['units']}".rstrip() if np.isfinite(value) else "nominal"
        appearance = {"color": "#000000", "linewidth": 1.4} if k == own else line_style(k)
        axis.plot(result.angle.values, values[k], label=shown if k < _MOST_NAMED or k == own else None, **appearance)
    largest = float(np.nanmax(values, initial=0.0))
    if largest > 0:
        axis.set_yscale("log")
        axis.set_ylim(max(_SMALLEST * largest, float(np.nanmin(values[values > 0], initial=largest)) / 2), 2 * largest)
    _criterion(axis, result, name.partition("_")[0])
    of = "amplitudes" if name.startswith("amplitude") else f"speeds of {result.wucht.summary['speeds_of']}"
    axis.set(xlabel="angle of the rotor $\\varphi$ (rad)", ylabel=with_unit(f"{of} differ by", unit))


def _criterion(axis: Axes, result: xr.Dataset, of: str) -> None:
    """Draw the largest acceptable deviation of the averaged equations for this machine, the last value."""
    shares = {of: result.attrs.get(f"trusted_{of}", 0.0) for of in ("speed", "amplitude")}
    for limit in shares[of] * _largest(result, of)[-1:]:  # none before the first run
        if limit > 0:
            # In the legend both criteria have one line.
            name = f"trusted: {', '.join(_share_of(share, of) for of, share in shares.items() if share)}"
            axis.axhline(printed_unit(result, f"{of}_deviation")[0] * limit, **_LIMIT, label=name)


def _share_of(share: float, of: str) -> str:
    return f"{100 * share:g} % of the largest {of}"


def _largest(result: xr.Dataset, of: str) -> np.ndarray:
    """Largest value of the full run at each value of the parameter: a deviation over its share."""
    with np.errstate(all="ignore"):
        return np.asarray(result[f"{of}_deviation"].values / result[f"relative_{of}_deviation"].values)


def _along(axis: Axes, result: xr.Dataset) -> None:
    varied = result.isel(value=np.isfinite(result.value.values))
    at, same, deviation = (varied[name].values for name in ("value", "same_outcome", "speed_deviation"))
    axis.set_ylabel(with_unit("largest difference of speeds", result.speed_deviation.attrs["units"]))
    axis.set_xlabel(label(result, "value"))
    axis.plot(at, deviation, color=COLOURS[0], linewidth=1.0)
    classes = ((same == code, *look) for code, look in _OUTCOMES.items())
    draw_classes(axis, at, deviation, classes, color=COLOURS[0], markersize=6)
    share = result.attrs.get("trusted_speed")
    if share and np.isfinite(limit := share * _largest(varied, "speed")).any():
        axis.plot(at, limit, **_LIMIT, label=_share_of(share, "speed"))
    if (deviation > 0).any():
        axis.set_yscale("log")
        _numbers(axis.yaxis)
    if at[0] > 0 and at[-1] / at[0] >= 10:
        axis.set_xscale("log")
    legend_above(axis)


def _order(axis: Axes, result: xr.Dataset) -> None:
    factor, error, summary = result.factor.values, result.error.values, result.wucht.summary
    order, nominal = summary["order_of_error"], summary["nominal_order"]
    axis.set(xlabel="factor of $\\varepsilon$", ylabel=with_unit("error of the speeds", result.error.attrs["units"]))
    axis.loglog(factor, error, color=COLOURS[1], marker="s", markersize=5, linewidth=1.0, label=f"measured: order {order:.2f}")
    axis.loglog(factor, error[-1] * (factor / factor[-1]) ** nominal, color=GREY, linestyle="--", label=f"order {nominal:g}")
    axis.set_xticks(factor, [f"{f:g}" for f in factor])
    axis.xaxis.set_minor_locator(NullLocator())
    _numbers(axis.yaxis)
    legend_above(axis)


def _numbers(ticks: Axis) -> None:
    """Format the ticks of a logarithmic scale that may be shorter than a decade."""
    ticks.set_major_formatter(lambda value, _position: f"{value:g}")
    ticks.set_minor_formatter(lambda value, _position: f"{value:g}" if f"{value:e}"[0] in "25" else "")
