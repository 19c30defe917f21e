"""The figure of the study ``approximation``, in the manner of 002 figures 5.16 to 5.19."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import labelled_handles, legend_above, legend_below, new_grid
from wucht.plots.stability_lines import draw_classes
from wucht.plots.style import COLOURS, GREY, line_style
from wucht.results.formatting import label, printed_unit, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_SMALLEST = 1e-6  # of the largest deviation: lower limit of the scale
_MOST_NAMED = 9
# 1: the outcomes agree; 0: they differ; -1: there is none yet.
_OUTCOMES = {1: ("o", COLOURS[0], "same outcome"), 0: ("s", "white", "outcomes differ"), -1: ("X", GREY, "no outcome yet")}
_LIMIT: dict[str, Any] = {"color": GREY, "linestyle": (0, (9, 2)), "linewidth": 1.6, "zorder": 1}


def figure(result: xr.Dataset) -> Figure:
    """Draw the deviations over the rotor's angle, over the parameter, and over epsilon, from the Dataset alone."""
    has_values, has_errors = bool(np.isfinite(result.value.values).any()), result.wucht.summary["order_of_error"] is not None
    fig, (speed, amplitude, *rest) = new_grid(2 + has_values + has_errors, result.attrs["title"], answer_in_print(result))
    _draw_over_angle(speed, result, "speed_over_angle")
    _draw_over_angle(amplitude, result, "amplitude_over_angle")
    if has_values:
        _draw_over_parameter(rest[0], result)
    if has_errors:
        _draw_order(rest[-1], result)
    legend_below(fig, labelled_handles([speed, amplitude]))
    return fig


def _draw_over_angle(axis: Axes, result: xr.Dataset, name: str) -> None:
    scale, unit = printed_unit(result, name)
    values, nominal_index = scale * result[name].values, len(result.value) - 1
    for k, value in enumerate(result.value.values):
        if value == result.attrs.get("nominal"):  # it is drawn as such
            continue
        value_text = f"{value:.4g} {result.value.attrs['units']}".rstrip() if np.isfinite(value) else "nominal"
        appearance = {"color": "#000000", "linewidth": 1.4} if k == nominal_index else line_style(k)
        axis.plot(
            result.angle.values, values[k], label=value_text if k < _MOST_NAMED or k == nominal_index else None, **appearance
        )
    largest = float(np.nanmax(values, initial=0.0))
    if largest > 0:
        axis.set_yscale("log")
        axis.set_ylim(max(_SMALLEST * largest, float(np.nanmin(values[values > 0], initial=largest)) / 2), 2 * largest)
    _draw_criterion(axis, result, name.partition("_")[0])
    of = "amplitudes" if name.startswith("amplitude") else f"speeds of {result.wucht.summary['speeds_of']}"
    axis.set(xlabel="angle of the rotor $\\varphi$ (rad)", ylabel=with_unit(f"{of} differ by", unit))


def _draw_criterion(axis: Axes, result: xr.Dataset, of: str) -> None:
    """Draw the largest acceptable deviation of the averaged equations for this machine, the last value."""
    shares = {of: result.attrs.get(f"trusted_{of}", 0.0) for of in ("speed", "amplitude")}
    for limit in shares[of] * _largest(result, of)[-1:]:  # none before the first run
        if limit > 0:
            # In the legend both criteria have one line.
            name = f"limits of agreement: {', '.join(_share_in_words(share, of) for of, share in shares.items() if share)}"
            axis.axhline(printed_unit(result, f"{of}_deviation")[0] * limit, **_LIMIT, label=name)


def _share_in_words(share: float, of: str) -> str:
    return f"{100 * share:g} % of the largest {of}"


def _largest(result: xr.Dataset, of: str) -> np.ndarray:
    """Largest value of the full run at each value of the parameter: a deviation over its share."""
    with np.errstate(all="ignore"):
        return np.asarray(result[f"{of}_deviation"].values / result[f"relative_{of}_deviation"].values)


def _draw_over_parameter(axis: Axes, result: xr.Dataset) -> None:
    variants = result.isel(value=np.isfinite(result.value.values))
    at, same, deviation = (variants[name].values for name in ("value", "same_outcome", "speed_deviation"))
    axis.set_ylabel(with_unit("largest difference of speeds", result.speed_deviation.attrs["units"]))
    axis.set_xlabel(label(result, "value"))
    axis.plot(at, deviation, color=COLOURS[0], linewidth=1.0)
    classes = ((same == code, *look) for code, look in _OUTCOMES.items())
    draw_classes(axis, at, deviation, classes, color=COLOURS[0], markersize=6)
    share = result.attrs.get("trusted_speed")
    if share and np.isfinite(limit := share * _largest(variants, "speed")).any():
        axis.plot(at, limit, **_LIMIT, label=_share_in_words(share, "speed"))
    if (deviation > 0).any():
        axis.set_yscale("log")
        _format_ticks(axis.yaxis)
    if at[0] > 0 and at[-1] / at[0] >= 10:
        axis.set_xscale("log")
    legend_above(axis)


def _draw_order(axis: Axes, result: xr.Dataset) -> None:
    from matplotlib.ticker import NullLocator

    factor, error, summary = result.factor.values, result.error.values, result.wucht.summary
    order, nominal = summary["order_of_error"], summary["nominal_order"]
    axis.set(xlabel="factor of $\\varepsilon$", ylabel=with_unit("error of the speeds", result.error.attrs["units"]))
    axis.loglog(factor, error, color=COLOURS[1], marker="s", markersize=5, linewidth=1.0, label=f"measured: order {order:.2f}")
    axis.loglog(factor, error[-1] * (factor / factor[-1]) ** nominal, color=GREY, linestyle="--", label=f"order {nominal:g}")
    axis.set_xticks(factor, [f"{f:g}" for f in factor])
    axis.xaxis.set_minor_locator(NullLocator())
    _format_ticks(axis.yaxis)
    legend_above(axis)


def _format_ticks(ticks: Axis) -> None:
    """Format the ticks of a logarithmic scale that may be shorter than a decade."""
    ticks.set_major_formatter(lambda value, _position: f"{value:g}")
    ticks.set_minor_formatter(lambda value, _position: f"{value:g}" if f"{value:e}"[0] in "25" else "")
