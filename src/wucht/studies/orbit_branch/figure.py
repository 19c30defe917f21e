"""The figure of a branch of orbits, as 002 figures 5.6, 5.7 and A.3: its extremes and period, and how some orbits run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import legend_below, new_grid, rpm_axis
from wucht.plots.style import COLOURS, line_style
from wucht.results.formatting import label, named, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STABLE: dict[str, Any] = {"linestyle": "-", "linewidth": 1.8, "zorder": 3}
_UNSTABLE: dict[str, Any] = {"linestyle": (0, (4, 2)), "linewidth": 1.1, "zorder": 3}
_MARKS = {
    "fold": ("o", "white"), "period-doubling": ("^", "white"), "torus": ("D", "white"), "branch-point": ("s", "black"),
    "unresolved": ("*", "white"),
}  # fmt: skip
_NAMES = {"unresolved": "special point not located"}
_ENDS = {
    "saddle-node-on-orbit": ("X", "saddle-node on the orbit"), "saddle-connection": ("P", "saddle connection"),
    "hopf": ("d", "Hopf point"), "not-identified": ("$?$", "end not identified"),
}  # fmt: skip
_STEADY, _DRAWN = COLOURS[6], 6  # how many orbits are drawn as they run
_TICKS = 5
_PALE = 0.12
_SHORT = 6  # characters of a parameter's path that is repeated for each orbit
_SHOWN_GROWTH = 8.0  # times the shortest period: longer ones are beyond the panel


def figure(result: xr.Dataset) -> Figure:
    """Four panels from the Dataset of a branch of orbits alone: extremes and period over the parameter, and some orbits.

    Without orbits the first one alone, with the steady states.
    """
    found = len(result.value) > 0
    columns = 2 if found else 1
    drawn, axes = new_grid(
        columns**2, result.attrs["title"], result.attrs["sentence"], columns=columns, heights=2.1 if found else 3.4
    )
    _extremes(axes[0], result)
    chosen = _chosen(result) if found else []
    if found:
        _periods(axes[2], result)
        _runs(axes[1], result, chosen, "orbit_speed")
        vibrates = bool(np.isfinite(result.orbit_amplitude.values).any())
        _runs(axes[3], result, chosen, "orbit_amplitude" if vibrates else "orbit_speed", share=not vibrates)
    legend_below(drawn, _legend(result, chosen))
    return drawn


def _what(result: xr.Dataset) -> str:
    return with_unit(named(str(result.attrs["along"]), str(result.attrs["along_what"])), str(result.attrs["along_unit"]))


def _extremes(axis: Axes, result: xr.Dataset) -> None:
    value, low, high = (result[name].values for name in ("value", "min_speed", "max_speed"))
    for k in range(int(result.steady_branch.values.max(initial=-1)) + 1):
        at = np.flatnonzero(result.steady_branch.values == k)
        _pieces(
            axis, result.steady_value.values[at], [result.steady_speed.values[at]], result.steady_stable.values[at], _STEADY
        )
    for k in _branches(result):
        at = np.flatnonzero(result.branch.values == k)
        axis.fill_between(value[at], low[at], high[at], color=_colour(k), alpha=_PALE, linewidth=0)
        _pieces(axis, value[at], [low[at], high[at]], result.stable.values[at], _colour(k))
    _marks(axis, result, ("min_speed", "max_speed"))
    for i, kind in enumerate(result.end_kind.values.astype(str)):
        if kind in _ENDS and np.isfinite(result.end_speed.values[i]):
            axis.plot(
                result.end_value.values[i], result.end_speed.values[i], _ENDS[kind][0], color="black", markersize=6, zorder=6
            )
    axis.set_ylabel(
        str(result.attrs["shown"]) + (f" ({result.min_speed.attrs['units']})" if result.min_speed.attrs["units"] else "")
    )
    rpm_axis(axis, str(result.min_speed.attrs["units"]))
    _abscissa(axis, result)


def _periods(axis: Axes, result: xr.Dataset) -> None:
    name = "period_phi" if result.attrs["rotor"] else "period"
    value, period = result.value.values, result[name].values
    for k in _branches(result):
        at = np.flatnonzero(result.branch.values == k)
        _pieces(axis, value[at], [period[at]], result.stable.values[at], _colour(k))
    _marks(axis, result, (name,))
    for v, kind in zip(result.end_value.values, result.end_kind.values.astype(str), strict=True):
        if kind in _ENDS:
            axis.axvline(v, color="black", linestyle=":", linewidth=0.9, zorder=1)
    if len(period):
        axis.set_ylim(0, min(1.05 * period.max(), _SHOWN_GROWTH * period.min()))
    axis.set_ylabel("period, angle of the main rotor (rad)" if result.attrs["rotor"] else label(result, name))
    _abscissa(axis, result)


def _abscissa(axis: Axes, result: xr.Dataset) -> None:
    axis.set_xlim(result.attrs["low"], result.attrs["high"])
    axis.locator_params(axis="x", nbins=_TICKS)  # small values are long numbers
    axis.set_xlabel(_what(result))


def _branches(result: xr.Dataset) -> range:
    return range(int(result.branch.values.max(initial=-1)) + 1)


def _colour(branch: int) -> str:
    return COLOURS[branch % len(COLOURS)]


def _pieces(axis: Axes, x: np.ndarray, curves: list[np.ndarray], stable: np.ndarray, colour: str) -> None:
    """Curves along a branch, stretches that are stable and unstable in their own style."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(stable)) + 1, [len(x)]])
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        for y in curves:
            axis.plot(x[a : b + 1], y[a : b + 1], color=colour, **(_STABLE if stable[a] else _UNSTABLE))


def _marks(axis: Axes, result: xr.Dataset, names: tuple[str, ...]) -> None:
    """The special orbits on a branch's curves."""
    own = {kind for kind in result.orbit_kind.values.astype(str).tolist() if kind}
    for kind in own:
        marker, face = _MARKS.get(kind, ("o", "white"))
        at = result.orbit_kind.values.astype(str) == kind
        for name in names:
            x, y = result.orbit_value.values[at], result[f"orbit_{name}"].values[at]
            axis.plot(x, y, marker, color="black", markerfacecolor=face, markersize=5, zorder=5)


def _chosen(result: xr.Dataset) -> list[int]:
    """Which of the reported orbits are drawn: of the first branch, over its range."""
    first = np.flatnonzero((result.orbit_branch.values == 0) & (result.orbit_kind.values.astype(str) == ""))
    if len(first) <= _DRAWN:
        return [int(i) for i in first]
    return [int(first[i]) for i in np.linspace(0, len(first) - 1, _DRAWN).round().astype(int)]


def _runs(axis: Axes, result: xr.Dataset, chosen: list[int], name: str, share: bool = False) -> None:
    """Orbits over the rotor's angle, or time, or the share of their period."""
    over = "orbit_turned" if result.attrs["rotor"] else "orbit_time"
    factor, unit = printed_unit(result, name)
    for i, k in enumerate(chosen):
        x = result[over].values[k]
        y = factor * result[name].values[k]
        begin = int(result.orbit_speed.values[k, :-1].argmin())  # each where the speed is least
        x = np.concatenate([x[begin:-1], x[-1] + x[: begin + 1]]) - x[begin]
        y = np.concatenate([y[begin:-1], y[: begin + 1]])
        axis.plot(x / x[-1] if share else x, y, **line_style(i))
    axis.set_xlabel("share of the period" if share else label(result, over))
    axis.set_ylabel(label(result, name, unit))


def _legend(result: xr.Dataset, chosen: list[int]) -> list[Any]:
    from matplotlib.lines import Line2D

    handles = list[Any]()
    if chosen:
        looks = {"orbits, stable": _STABLE, "orbits, unstable": _UNSTABLE}
        handles += [Line2D([], [], color=COLOURS[0], label=name, **look) for name, look in looks.items()]
    if result.sizes["steady"]:
        alone = ", stable" if not chosen else ""
        handles.append(Line2D([], [], color=_STEADY, label=f"steady states{alone}", **_STABLE))
        if alone:
            handles.append(Line2D([], [], color=_STEADY, label="steady states, unstable", **_UNSTABLE))
    for kind in dict.fromkeys(k for k in result.orbit_kind.values.astype(str).tolist() if k):
        marker, face = _MARKS.get(kind, ("o", "white"))
        style = {"marker": marker, "markerfacecolor": face, "markersize": 5, "label": _NAMES.get(kind, kind.replace("-", " "))}
        handles.append(Line2D([], [], color="black", linestyle="", **style))
    for kind in dict.fromkeys(result.end_kind.values.astype(str).tolist()):
        if kind in _ENDS:
            marker, name = _ENDS[kind]
            handles.append(Line2D([], [], color="black", linestyle="", marker=marker, markersize=6, label=name))
    if chosen and {*result.end_kind.values.astype(str)} & {*_ENDS}:
        handles.append(Line2D([], [], color="black", linestyle=":", linewidth=0.9, label="end of the orbits"))
    path, unit = str(result.attrs["along"]), result.attrs["along_unit"]
    before = f"{path} = " if len(path) <= _SHORT else "at "
    for i, k in enumerate(chosen):
        name = f"{before}{result.orbit_value.values[k]:.4g} {unit}".rstrip()
        handles.append(Line2D([], [], label=name, **line_style(i)))
    return handles
