"""The figure of entrainment: phases and speed over the parameter, the band of existence and that reached from the start."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import summary_of
from wucht.results.style import COLOURS, GREY, line_style, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARGIN = 0.03  # of the range, so that what lies at its ends is seen whole
_SHADE, _REACHED = COLOURS[4], COLOURS[2]


def figure(result: xr.Dataset) -> Figure:
    """Two panels from the Dataset alone: phases in degrees, stable solid and unstable dashed; and the mean speed."""
    summary = summary_of(result)
    drawn, axes = new_figure(2, 6.4, result.attrs["title"], _subtitle(result, summary))
    phase, speed = axes
    _phases(phase, result)
    _speeds(speed, result)
    low, high = _limits(result, summary)
    for axis in axes:
        axis.set_xlim(low - _MARGIN * (high - low), high + _MARGIN * (high - low))
        _bands(axis, summary, low, high, named=axis is phase)
        axis.axvline(summary["value"], color=GREY, linestyle=":", linewidth=1.0, zorder=1)
        if axis.get_legend_handles_labels()[0]:
            axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)
    speed.annotate("this machine", (summary["value"], 0.02), xycoords=("data", "axes fraction"), color=GREY, fontsize=7,
                   rotation=90, ha="right", va="bottom")  # fmt: skip
    unit = result.attrs["along_unit"]
    speed.set_xlabel(result.attrs["along"] + (f" ({unit})" if unit else ""))
    return drawn


def _subtitle(result: xr.Dataset, summary: dict[str, Any]) -> str:
    """The bands; else the answer in words."""
    if not result.attrs["finished"] or summary["existence_band"] is None:
        return str(result.attrs["sentence"])
    unit = result.attrs["along_unit"]
    text = f"exists {_between(summary['existence_band'], unit)} (slow equations)"
    reached = summary["band_from_rest"]
    return text + ("; not reached from the start" if reached is None else f"; reached from the start {_between(reached, unit)}")


def _between(band: list[float | None], unit: str) -> str:
    low, high = band
    end = f" {unit}" if unit else ""
    if low is None and high is None:
        return "in all of the range"
    if low is None:
        return f"below {high:.6g}{end}"
    return f"above {low:.6g}{end}" if high is None else f"from {low:.6g} to {high:.6g}{end}"


def _limits(result: xr.Dataset, summary: dict[str, Any]) -> tuple[float, float]:
    if summary["range"] is not None:
        return summary["range"][0], summary["range"][1]
    values = [*result.value.values, *result.run_value.values, summary["value"]]
    low, high = min(values), max(values)
    return (low, high) if high > low else (low - 1, high + 1)


def _bands(axis: Axes, summary: dict[str, Any], low: float, high: float, named: bool) -> None:
    """The band of existence shaded; the edges of that from the start as lines."""
    exists, reached = summary["existence_band"], summary["band_from_rest"]
    if exists is not None:
        begin, end = (low if exists[0] is None else exists[0]), (high if exists[1] is None else exists[1])
        axis.axvspan(begin, end, color=_SHADE, alpha=0.18, linewidth=0, zorder=0, label="band of existence" if named else None)
    if reached is not None:
        for k, edge in enumerate(e for e in reached if e is not None):
            name = "reached from the start" if named and k == 0 else None
            axis.axvline(edge, color=_REACHED, linestyle="-.", linewidth=1.3, zorder=2, label=name)


def _phases(axis: Axes, result: xr.Dataset) -> None:
    dimensional = not result.attrs["dimensionless"]
    scale, turn = (180 / math.pi, 360.0) if dimensional else (1.0, 2 * math.pi)
    names = [str(n) for n in result.body.values]
    shown, own = set(), summary_of(result)["branch"]
    top = _top(result, own)
    shaken = "frequency" in result.attrs
    for i, name in enumerate(names):
        what = f"{name}: " if len(names) > 1 else ""
        for k in np.unique(result.branch.values):
            one = result.isel(point=result.branch.values == k)
            other = own is not None and k != own  # such as exciters that hang in a resonance together
            colour = GREY if other else line_style(i)["color"]
            for stable, dash in ((True, "-"), (False, "--")):
                phases = _wrapped(one.phase.sel(body=name).values, top)
                x, y = _part(one.value.values, phases, one.stable.values.astype(bool), stable, top)
                kind = "others" if other else "slow" if what else "slow equations"
                title = f"{what}{kind}, {'stable' if stable else 'unstable'}"
                if np.isfinite(y).any():
                    axis.plot(
                        x, scale * y, dash, color=colour, linewidth=0.8 if other else 1.3,
                        label=None if title in shown else title,
                    )  # fmt: skip
                    shown.add(title)
        if result.sizes["orbit"]:
            # the slow equations are an approximation: marks that lie beside their lines show its error
            axis.plot(
                result.orbit_value, scale * _wrapped(result.orbit_phase.sel(body=name).values, top), "o", color=COLOURS[6],
                markersize=3.5, markerfacecolor="white", label=f"{what}full{'' if what else ' equations'}, periodic", zorder=4,
            )  # fmt: skip
    axis.set_ylabel(f"phase{' to the vibration' if shaken and len(names) == 1 else ''}" + (" (°)" if dimensional else ""))
    high = scale * top
    axis.set_ylim(high - turn, high)
    if dimensional:
        axis.set_yticks(np.arange(high - turn, high + 1, turn / 8))


def _top(result: xr.Dataset, own: int | None) -> float:
    """Where the circle of phases is cut, in rad: away from the phases of the machine."""
    if "frequency" in result.attrs:
        return math.pi
    mine = result.phase.values[:, (result.branch.values == own) & (result.stable.values == 1)]
    seen = np.concatenate([mine.ravel(), result.orbit_phase.values.ravel()])
    return math.pi if len(seen) and np.nanmean(np.cos(seen)) > 0 else 2 * math.pi


def _wrapped(phases: np.ndarray, top: float) -> np.ndarray:
    """Phases in (top - 2 pi, top]."""
    found: np.ndarray = top - np.remainder(top - phases, 2 * math.pi)
    return found


def _part(x: np.ndarray, y: np.ndarray, stable: np.ndarray, wanted: bool, top: float) -> tuple[np.ndarray, np.ndarray]:
    """The stable or unstable part of a branch in its order, with gaps elsewhere; a phase that wraps goes to the border."""
    chosen = stable == wanted
    if not wanted:  # so that the two kinds of line meet
        chosen = chosen | np.concatenate([[False], chosen[:-1]]) | np.concatenate([chosen[1:], [False]])
    shown = np.where(chosen, y, np.nan)
    wraps = np.flatnonzero(np.abs(np.diff(y)) > math.pi) + 1
    places, abscissae, ordinates = list[int](), list[float](), list[float]()
    for k in wraps:
        upward = y[k - 1] > y[k]
        leaving, entering = (top, top - 2 * math.pi) if upward else (top - 2 * math.pi, top)
        share = (leaving - y[k - 1]) / ((leaving - y[k - 1]) + (y[k] - entering) or 1.0)
        at = float(x[k - 1] + share * (x[k] - x[k - 1]))
        places += [int(k)] * 3
        abscissae += [at] * 3
        ordinates += [leaving, math.nan, entering] if chosen[k - 1] and chosen[k] else [math.nan] * 3
    return np.insert(x, places, abscissae), np.insert(shown, places, ordinates)


def _speeds(axis: Axes, result: xr.Dataset) -> None:
    """The runs' mean speeds: filled where taken along; what the drive alone would reach."""
    x, y, taken = result.run_value.values, result.run_speed.values, result.run_taken.values.astype(bool)
    own = summary_of(result)["branch"]
    for k in np.unique(result.branch.values) if "frequency" not in result.attrs else ():
        one = result.isel(point=result.branch.values == k)
        stable = one.stable.values.astype(bool)
        if stable.any():
            axis.plot(
                one.value.values, np.where(stable, one.speed.values, np.nan), color=COLOURS[0] if k == own else GREY,
                linewidth=1.2 if k == own else 0.8, label="slow equations, stable" if k == own else None, zorder=2,
            )  # fmt: skip
    for chosen, face, name in ((taken, COLOURS[1], "taken along"), (~taken, "white", "not taken along")):
        if chosen.any():
            axis.plot(x[chosen], y[chosen], "o", color=COLOURS[1], markersize=4, markerfacecolor=face, zorder=4,
                      label=f"run: {name}")  # fmt: skip
    if "frequency" in result.attrs:
        axis.axhline(result.attrs["frequency"], color=COLOURS[0], linewidth=1.0, label="frequency of the vibration", zorder=1)
    free = np.abs(result.free_speed.values)
    if np.isfinite(free).any() and np.ptp(free[np.isfinite(free)]) > 0:
        axis.plot(x, free, color=GREY, linestyle="--", linewidth=0.9, label="speed without vibration", zorder=1)
    unit = result.run_speed.attrs["units"]
    axis.set_ylabel(f"mean speed ({unit})" if unit else "mean speed")
