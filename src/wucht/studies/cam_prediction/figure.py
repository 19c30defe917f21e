"""The figure of a prediction: speed, spectrum, power, what is left cam after cam, and what springs make of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.page import small
from wucht.plots.style import COLOURS, GREY
from wucht.results.conventions import summary_of
from wucht.results.formatting import with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

Panel = Callable[["Axes", "xr.Dataset"], None]
_COLOURS = {"original": COLOURS[1], "corrected": COLOURS[0]}
_RPM = 30 / math.pi
_LOWEST = 1e-8  # of the largest order: what is smaller is not seen
_MOST_BARS = 24
_CLEAN = 1e-6  # of order 1: nothing
_NOTHING = 1e-12  # of order 1: orders of the law that are rounding
_APART = 0.13  # of the panel: labels nearer to each other are left out
_FEWEST_ROWS = 4
_SIMULATED = "simulated"
_DASHES = {"original": "--", "corrected": "-"}  # where the two curves lie on each other both are seen
_DOT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 2.6, "color": "black", "zorder": 5}


def figure(result: xr.Dataset) -> Figure:
    """Four panels; with a drive one more, with an elastic output two, with an elastic shaft one; the law fills the last row."""
    panels: list[Panel] = [_speed, _spectrum, _power]
    panels += [_drive] if summary_of(result)["driven"] == "drive" else []
    panels += [_cuts] if len(result.cut) else [_law]
    panels += [_over_speed, _excited] if "residual_deviation" in result else []
    panels += [_twist] if "twist_residual" in result and len(result.twisted) else []
    if len(panels) % 2:
        panels.append(_law if _law not in panels else _travel)
    drawn, axes = sheet.new_grid(len(panels), result.attrs["title"], _heading(result))
    for axis, draw in zip(axes, panels, strict=True):
        draw(axis, result)
    return drawn


def _heading(result: xr.Dataset) -> str:
    """The verdict, on lines that fit the page."""
    return "\n".join(str(result.attrs["sentence"]).split(": ", 1))


def _decades(values: np.ndarray) -> tuple[float, float]:
    """Limits of a logarithmic axis, so that it has ticks."""
    seen = values[values > 0]
    low, high = (seen.min(), seen.max()) if len(seen) else (0.1, 1.0)
    return float(10 ** np.floor(np.log10(0.8 * low))), float(10 ** np.ceil(np.log10(1.25 * high)))


def _plain(axis: Axis) -> None:
    """Decades, and no numbers between them."""
    style.plain_decades(axis)
    axis.set_minor_formatter(lambda _value, _position: "")


def _turn(axis: Axes, name: str) -> None:
    axis.set_xlim(0, 360)
    axis.set_xticks(np.arange(0, 361, 60))
    axis.set_xlabel(name)


def _legend(axis: Axes) -> None:
    """Above the panel: the cams first, what is simulated last."""
    sheet.legend_above(axis, sorted(sheet.named_in([axis]), key=lambda line: line.get_label() == _SIMULATED))


def _speed(axis: Axes, result: xr.Dataset) -> None:
    degrees = np.degrees(result.tau.values)
    for name, colour in _COLOURS.items():
        drawn: dict[str, Any] = {"color": colour, "linewidth": 1.3, "linestyle": _DASHES[name], "label": f"{name} cam"}
        axis.plot(degrees, _RPM * result.speed.sel(cam=name).values, **drawn)
    if "simulated_speed" in result:
        at = np.degrees(result.simulated_tau.values)
        for n, row in enumerate(_RPM * result.simulated_speed.values):
            axis.plot(at, row, label=_SIMULATED if n == 0 else None, **_DOT)
    mean = summary_of(result)["corrected"]["mean_speed"]
    axis.axhline(_RPM * mean, color=GREY, linestyle=":", linewidth=0.9)
    axis.set_ylabel("speed of the shaft (rpm)")
    axis.ticklabel_format(axis="y", useOffset=False)
    _turn(axis, "time of a turn (°)")
    _legend(axis)


def _spectrum(axis: Axes, result: xr.Dataset) -> None:
    shown = result.output_acceleration.values[:, :_MOST_BARS]
    k, lowest = result.order.values[: shown.shape[1]], _LOWEST * shown.max()
    axis.set_axisbelow(True)
    for row, (name, colour), aside in zip(shown, _COLOURS.items(), (-0.2, 0.2), strict=True):
        high = np.where(row > lowest, row, np.nan)
        axis.bar(
            k + aside, high - lowest, bottom=lowest, width=0.4, color=colour, label=f"{name} cam", **style.HATCHED[aside < 0]
        )
        if "simulated_acceleration" in result:
            dots = result.simulated_acceleration.sel(cam=name).values[: len(k)]
            axis.plot(k + aside, np.where(dots > lowest, dots, np.nan), label=_SIMULATED if aside > 0 else None, **_DOT)
    count = summary_of(result)["above"]["orders"]
    if k[0] <= count < k[-1]:
        axis.axvline(count + 0.5, color=GREY, linestyle=":", linewidth=0.9)
    axis.set_yscale("log")
    axis.set_ylim(lowest, 3 * shown.max())
    _plain(axis.yaxis)
    axis.set_xlim(0.3, k[-1] + 0.7)
    axis.locator_params(axis="x", integer=True)
    axis.set_xlabel("order")
    axis.set_ylabel(with_unit("acceleration, amplitude", str(result.output_acceleration.attrs["units"]).replace("^2", "²")))
    _legend(axis)


def _power(axis: Axes, result: xr.Dataset) -> None:
    """What an even speed would take, beside what the drive gives."""
    degrees = np.degrees(result.tau.values)
    even = result.power_at_constant_speed.values / 1e3
    axis.plot(degrees, even, color=COLOURS[6], linewidth=1.1, linestyle="--", label="at constant speed", zorder=3)
    if summary_of(result)["driven"] == "eigenmotion":
        axis.axhline(0.0, color=COLOURS[0], linewidth=1.3, label="eigenmotion")
    else:
        power = result.drive_power.sel(cam="corrected").values / 1e3
        axis.plot(degrees, power, color=_COLOURS["corrected"], linewidth=1.3, label="drive, corrected cam")
    axis.set_ylabel("power (kW)")
    _turn(axis, "time of a turn (°)")
    _legend(axis)


def _drive(axis: Axes, result: xr.Dataset) -> None:
    """The power of the drive alone, on its own scale."""
    degrees, power = np.degrees(result.tau.values), result.drive_power
    kilo = np.abs(power.values).max() >= 1e3
    for name, colour in _COLOURS.items():
        values = power.sel(cam=name).values / (1e3 if kilo else 1.0)
        axis.plot(degrees, values, color=colour, linewidth=1.3, linestyle=_DASHES[name], label=f"{name} cam")
    axis.set_ylabel(f"power of the drive alone ({'kW' if kilo else 'W'})")
    _turn(axis, "time of a turn (°)")
    _legend(axis)


def _cuts(axis: Axes, result: xr.Dataset) -> None:
    axis.plot(result.cut.values, result.cut_residual.values, "o-", color=COLOURS[1], linewidth=1.1, markersize=5)
    own = summary_of(result)["above"]["law"]
    if own > _NOTHING:
        axis.axhline(own, color=GREY, linestyle=":", linewidth=0.9, label="the law itself")
        sheet.legend_above(axis)
    axis.set_yscale("log")
    axis.set_ylim(*_decades(result.cut_residual.values))
    _plain(axis.yaxis)
    axis.set_xticks(result.cut.values)
    axis.set_xlim(0.5, result.cut.values[-1] + 0.5)
    axis.set_xlabel("cam, cut for the speed with the one before")
    axis.set_ylabel(f"above order {summary_of(result)['above']['orders']}, over order 1")


def _law(axis: Axes, result: xr.Dataset) -> None:
    _of_cam(axis, result, "acceleration", "/rad²")
    axis.set_ylabel(f"acceleration of the cam's law ({axis.get_ylabel()})")


def _travel(axis: Axes, result: xr.Dataset) -> None:
    _of_cam(axis, result, "position", "")
    axis.set_ylabel(f"law of the corrected cam ({axis.get_ylabel()})")


def _of_cam(axis: Axes, result: xr.Dataset, name: str, by: str) -> None:
    """A derivative of the corrected cam's law; labelled with its unit."""
    angle = result.position.attrs["units"] == "rad"
    scale, unit = (np.degrees(1.0), "°") if angle else (1e3, "mm")
    axis.plot(np.degrees(result.cam_angle.values), scale * result[name].values, color=COLOURS[0], linewidth=1.3)
    axis.set_ylabel(f"{unit}{by}")
    _turn(axis, "cam angle (°)")


def _over_speed(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = _small(result)
    speeds = _RPM * result.swept_speed.values
    for i, name in enumerate(result.lever.values.tolist()):
        colour, dashes = ((COLOURS[1], "--"), (COLOURS[0], "-"), (COLOURS[2], "-."))[i]
        axis.plot(speeds, scale * result.residual_deviation.values[i], dashes, color=colour, linewidth=1.2, label=name)
    marks = zip(result.resonance_order.values.tolist(), _RPM * result.resonance_speed.values, strict=True)
    named = math.inf
    for k, at in marks:  # from the fastest on
        axis.axvline(at, color=GREY, linestyle=":", linewidth=0.6)
        if named - at < _APART * (speeds[-1] - speeds[0]):
            continue
        named = at
        axis.annotate(
            f"k = {k}", (at, 0.0), (0, 4), xycoords=("data", "axes fraction"), textcoords="offset points", fontsize=small(),
            color=GREY, ha="center", bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )  # fmt: skip
    mean = _RPM * summary_of(result)["corrected"]["mean_speed"]
    if speeds[0] <= mean <= speeds[-1]:
        axis.axvline(mean, label="mean speed", **style.FREE)
    axis.set_yscale("log")
    low, high = _decades(scale * result.residual_deviation.values)
    axis.set_ylim(low, high)
    _plain(axis.yaxis)
    axis.set_xlim(speeds[0], speeds[-1])
    axis.set_xlabel("mean speed (rpm)")
    axis.set_ylabel(with_unit("deviation in the dwell", unit))
    sheet.legend_above(axis)


def _excited(axis: Axes, result: xr.Dataset) -> None:
    """What stays in the dwell at the mean speed, the quietest motion on top."""
    scale, unit = _small(result)
    names, size = result.excited.values.tolist(), scale * result.excited_deviation.values
    own = [name in result.lever.values.tolist() for name in names]
    lowest, highest = _decades(size)
    _bars(axis, size, [COLOURS[0] if o else COLOURS[4] for o in own], names, (lowest, highest))
    axis.set_xlabel(with_unit("deviation in the dwell at this speed", unit))


def _twist(axis: Axes, result: xr.Dataset) -> None:
    """What each cam leaves behind the shaft that twists."""
    names, left = result.twisted.values.tolist(), result.twist_residual.values
    named = [f"{name}: {100 * x:.3g} %" if x > _CLEAN else f"{name}: nothing" for name, x in zip(names, left, strict=True)]
    highest = _decades(left)[1]
    colours = [_COLOURS.get(name.removesuffix(" cam"), COLOURS[2]) for name in names]
    _bars(axis, left, colours, named, (_CLEAN, max(highest, 1.0)))
    own = summary_of(result)["above"]["law"]
    if own > _CLEAN:
        axis.axvline(own, color=GREY, linestyle=":", linewidth=0.9)
        axis.annotate("the law itself", (own, 0.0), (-3, 4), xycoords=("data", "axes fraction"),
                      textcoords="offset points", fontsize=small(), color=GREY, ha="right")  # fmt: skip
    axis.set_xlabel(f"shaft that twists: above order {summary_of(result)['above']['orders']}, over order 1")


def _bars(axis: Axes, size: np.ndarray, colours: list[str], names: list[str], limits: tuple[float, float]) -> None:
    """One below the other from the lower limit on, on a logarithmic axis, each with its name above."""
    at = np.arange(len(names))[::-1]
    axis.barh(at, np.maximum(size - limits[0], 0.0), left=limits[0], height=0.34, color=colours)
    axis.set_xscale("log")
    axis.set_xlim(*limits)
    axis.set_ylim(min(len(names) - _FEWEST_ROWS, 0) - 0.5, len(names) - 0.2)
    _plain(axis.xaxis)
    style_of_name: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "fontsize": small()}
    for y, name in zip(at, names, strict=True):
        axis.annotate(name, (0.0, y + 0.2), (3, 0), va="bottom", **style_of_name)
    axis.set_yticks([])


def _small(result: xr.Dataset) -> tuple[float, str]:
    """The factor by which deviations are drawn, and their unit there."""
    return (np.degrees(1.0), "°") if result.residual_deviation.attrs["units"] == "rad" else (1e3, "mm")
