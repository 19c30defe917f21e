"""The figure of entrainment: phases and speed over the parameter, the band of existence and the band reached from the start."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds, parameter_label
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.stability_lines import draw_classes, extend_both_ways
from wucht.plots.style import COLOURS, FREE, GREY, line_style
from wucht.results.attributes import number_in
from wucht.results.formatting import with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARGIN = 0.03  # of the range, so that curves and marks at its ends are visible
_EXISTENCE_COLOUR, _CAPTURE_COLOUR = COLOURS[4], COLOURS[2]
_BRANCH_STYLE: dict[str, Any] = {"color": GREY, "linewidth": 0.8}  # branches other than that of the band

_ORBIT_STYLE: dict[str, Any] = {"color": COLOURS[6], "markersize": 3.5, "markerfacecolor": "white", "zorder": 4}


def figure(result: xr.Dataset) -> Figure:
    """Draw two panels from the Dataset alone: phases in degrees, stable solid and unstable dashed; and the mean speed."""
    summary = result.wucht.summary
    fig, (phase, speed) = new_figure(2, result.attrs["title"], answer_in_print(result), 2.4)
    _phases(phase, result, summary["branch"])
    _speeds(speed, result, summary["branch"])
    low, high = summary["range"] or _limits(result, summary["value"])
    for axis in (phase, speed):
        axis.set_xlim(low - _MARGIN * (high - low), high + _MARGIN * (high - low))
        _bands(axis, summary, low, high, has_labels=axis is phase)
        name = "this machine" if axis is phase else None
        axis.axvline(summary["value"], color=GREY, linestyle=":", linewidth=1.0, zorder=1, label=name)
        legend_beside(axis)
    speed.set_xlabel(parameter_label(result))
    return fig


def _limits(result: xr.Dataset, nominal_value: float) -> tuple[float, float]:
    """Return the limits of the values that an interrupted study has reached."""
    values = [*result.value.values, *result.run_value.values, nominal_value]
    low, high = min(values), max(values)
    return (low, high) if high > low else (low - 1, high + 1)


def _bands(axis: Axes, summary: dict[str, Any], low: float, high: float, has_labels: bool) -> None:
    """Shade the band of existence, and draw the edges of the band reached from the start as lines."""
    existence_band, capture_band = summary["existence_band"], summary["band_from_rest"] or ()
    if existence_band is not None:
        begin, end = (
            (low if existence_band[0] is None else existence_band[0]),
            (high if existence_band[1] is None else existence_band[1]),
        )
        axis.axvspan(
            begin,
            end,
            color=_EXISTENCE_COLOUR,
            alpha=0.18,
            linewidth=0,
            zorder=0,
            label="band of existence" if has_labels else None,
        )
    for k, edge in enumerate(e for e in capture_band if e is not None):
        name = "reached from the start" if has_labels and k == 0 else None
        axis.axvline(edge, color=_CAPTURE_COLOUR, linestyle="-.", linewidth=1.3, zorder=2, label=name)


def _phases(axis: Axes, result: xr.Dataset, main_branch: int | None) -> None:
    dimensional, shaken = not result.attrs["dimensionless"], "frequency" in result.attrs
    scale, turn = (180 / math.pi, 360.0) if dimensional else (1.0, 2 * math.pi)
    names, titles = [str(n) for n in result.body.values], set[str]()
    top = math.pi if shaken else _phase_cut(result, main_branch)
    for i, name in enumerate(names):
        body = f"{name}: " if len(names) > 1 else ""
        for k, stable in itertools.product(np.unique(result.branch.values), (True, False)):
            branch = result.isel(point=result.branch.values == k)
            is_side_branch = main_branch is not None and k != main_branch  # such as exciters captured at a resonance together
            phases = _wrap_below(branch.phase.sel(body=name).values, top)
            x, y = _stability_part(branch.value.values, phases, branch.stable.values.astype(bool), stable, top)
            if np.isfinite(y).any():
                kind = "others" if is_side_branch else "averaged" if body else "averaged equations"
                title = f"{body}{kind}, {'stable' if stable else 'unstable'}"
                look = (_BRANCH_STYLE if is_side_branch else line_style(i) | {"linewidth": 1.3}) | {
                    "linestyle": "-" if stable else "--"
                }
                axis.plot(x, scale * y, label=None if title in titles else title, **look)
                titles.add(title)
        if result.sizes["orbit"]:
            # the averaged equations are an approximation: marks that lie beside their lines show its error
            orbits = scale * _wrap_below(result.orbit_phase.sel(body=name).values, top)
            axis.plot(
                result.orbit_value, orbits, "o", label=f"{body}full{'' if body else ' equations'}, periodic", **_ORBIT_STYLE
            )
    to = " to the vibration" if shaken and len(names) == 1 else ""
    axis.set_ylabel(with_unit(f"phase{to}", "°" if dimensional else ""))
    axis.set_ylim(scale * top - turn, scale * top)
    if dimensional:
        axis.set_yticks(np.arange(scale * top - turn, scale * top + 1, turn / 8))


def _phase_cut(result: xr.Dataset, main_branch: int | None) -> float:
    """Return where the circle of phases is cut, in rad: away from the phases of the machine."""
    averaged_phases = result.phase.values[:, (result.branch.values == main_branch) & (result.stable.values == 1)]
    phases = np.concatenate([averaged_phases.ravel(), result.orbit_phase.values.ravel()])
    return math.pi if len(phases) and np.nanmean(np.cos(phases)) > 0 else 2 * math.pi


def _wrap_below(phases: np.ndarray, top: float) -> np.ndarray:
    """Wrap phases into (top - 2 pi, top]."""
    return np.asarray(top - np.remainder(top - phases, 2 * math.pi))


def _stability_part(
    x: np.ndarray, y: np.ndarray, stable: np.ndarray, draws_stable: bool, top: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the stable or unstable part of a branch, with gaps elsewhere; a phase that wraps continues at the border."""
    chosen = stable == draws_stable
    if not draws_stable:  # so that the two kinds of line meet, at both ends
        chosen = extend_both_ways(chosen)
    k = np.flatnonzero(np.abs(np.diff(y)) > math.pi) + 1  # the points after a wrap
    upward = y[k - 1] > y[k]
    leaving, entering = np.where(upward, top, top - 2 * math.pi), np.where(upward, top - 2 * math.pi, top)
    way = (leaving - y[k - 1]) + (y[k] - entering)
    at = x[k - 1] + (leaving - y[k - 1]) / np.where(way == 0, 1.0, way) * (x[k] - x[k - 1])
    border = np.where(chosen[k - 1] & chosen[k], [leaving, np.full(len(k), math.nan), entering], math.nan).T.ravel()
    thrice = np.repeat(k, 3)
    return np.insert(x, thrice, np.repeat(at, 3)), np.insert(np.where(chosen, y, np.nan), thrice, border)


def _speeds(axis: Axes, result: xr.Dataset, main_branch: int | None) -> None:
    """Draw the mean speeds of the runs, filled where entrained, and the speed without vibration."""
    x, y, is_entrained = result.run_value.values, result.run_speed.values, result.run_taken.values.astype(bool)
    frequency = number_in(result, "frequency") if "frequency" in result.attrs else None
    free = np.abs(result.free_speed.values)
    for k in np.unique(result.branch.values[result.stable.values == 1]) if frequency is None else ():
        branch = result.isel(point=result.branch.values == k)
        style = (
            {"color": COLOURS[0], "linewidth": 1.2, "label": "averaged equations, stable"}
            if k == main_branch
            else _BRANCH_STYLE
        )
        axis.plot(branch.value.values, branch.speed.where(branch.stable == 1).values, zorder=2, **style)
    runs = ((is_entrained, "o", COLOURS[1], "run: entrained"), (~is_entrained, "o", "white", "run: not entrained"))
    draw_classes(axis, x, y, runs, color=COLOURS[1], markersize=4, zorder=4)
    if frequency is not None:
        axis.axhline(frequency, color=COLOURS[0], linewidth=1.0, label="frequency of the vibration", zorder=1)
    if np.isfinite(free).any() and np.ptp(free[np.isfinite(free)]) > 0:
        axis.plot(x, free, label="speed without vibration", zorder=1, **FREE)
    name_speeds(axis, result, "run_speed")
