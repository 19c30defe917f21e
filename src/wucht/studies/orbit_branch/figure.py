"""The figure of a branch of orbits, as 002 figures 5.6, 5.7 and A.3: its extremes and period, and some orbits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.limit_set_curves import wrapped_curve
from wucht.plots.scales import parameter_label
from wucht.plots.sheet import legend_below, new_grid, rpm_axis, sheet_of
from wucht.plots.stability_lines import Symbol, draw_kinds, entry, equal_stretches, kind_entries
from wucht.plots.style import COLOURS, shades
from wucht.results.attributes import number_in, text_in
from wucht.results.formatting import formula_in_print, label, printed_unit, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STABLE: dict[str, Any] = {"linestyle": "-", "linewidth": 1.8, "zorder": 3}
_UNSTABLE: dict[str, Any] = {"linestyle": (0, (4, 2)), "linewidth": 1.1, "zorder": 3}
_MARKS: dict[str, Symbol] = {
    "": ("o", "white", ""), "period-doubling": ("^", "white", ""), "torus": ("D", "white", ""),
    "branch-point": ("s", "black", ""), "unresolved": ("*", "white", "special point not located"),
}  # fmt: skip
_ENDS = {
    "saddle-node-on-orbit": ("X", "saddle-node on the orbit"), "saddle-connection": ("P", "saddle connection"),
    "hopf": ("d", "Hopf point"), "not-identified": ("$?$", "end not identified"),
}  # fmt: skip
_END: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 0.9}
_STEADY, _MOST_DRAWN = COLOURS[6], 6  # number of orbits that are drawn
_TICKS = 5
_ORBIT_WIDTH, _SHORT_DASHES = 1.2, (0, (2, 1))
_PALE = 0.12
_SCALE = "cividis"  # of the drawn orbits, less its light end: even steps in grey, too
_SHORT = 6  # characters of a parameter's path: a longer one is not repeated for each orbit
_SHOWN_GROWTH = 8.0  # times the shortest period: longer ones are beyond the panel


def orbit_figure(result: xr.Dataset) -> Figure:
    """Draw four panels from the Dataset of a branch of orbits alone: extremes and period over the parameter, and some orbits.

    Without orbits there is the first panel alone, with the steady states.
    """
    orbits = len(result.value) > 0
    columns, height, drawn_orbits = (2, 2.1, _drawn_orbits(result)) if orbits else (1, 3.4, [])
    fig, axes = new_grid(columns**2, result.attrs["title"], answer_in_print(result), columns=columns, heights=height)
    _extremes(axes[0], result)
    if orbits:
        _periods(axes[2], result)
        course = "orbit_state" if text_in(result, "state") else "orbit_speed"
        _runs(axes[1], result, drawn_orbits, course)
        vibrates = "orbit_amplitude" in result and bool(np.isfinite(result.orbit_amplitude.values).any())
        if result.sizes.get("state", 0) > 1:
            _phase_space(axes[3], result, drawn_orbits)
        else:
            _runs(axes[3], result, drawn_orbits, "orbit_amplitude" if vibrates else course, share=not vibrates)
        if len(rows := sheet_of(fig).rows) == len(axes):  # in one column: what is over the parameter, then orbits
            rows[1], rows[2] = rows[2], rows[1]
    legend_below(fig, _legend(result, drawn_orbits))
    return fig


def _extremes(axis: Axes, result: xr.Dataset) -> None:
    state = text_in(result, "state")
    least, largest = (f"{end}_{state or 'speed'}" for end in ("min", "max"))
    value, low, high = (result[name].values for name in ("value", least, largest))
    steady = [result[f"steady_{name}"].values for name in ("value", "state" if state else "speed", "stable")]
    for at in _branch_points(result.steady_branch.values):
        _pieces(axis, steady[0][at], [steady[1][at]], steady[2][at], _STEADY)
    for k, at in enumerate(_branch_points(result.branch.values)):
        axis.fill_between(value[at], low[at], high[at], color=_colour(k), alpha=_PALE, linewidth=0)
        _pieces(axis, value[at], [low[at], high[at]], result.stable.values[at], _colour(k))
    _special(axis, result, least, largest)
    ends = result["end_state" if state else "end_speed"].values
    for x, y, kind in zip(result.end_value.values, ends, result.end_kind.values.astype(str), strict=True):
        if kind in _ENDS and np.isfinite(y):
            axis.plot(x, y, _ENDS[kind][0], color="black", markersize=6, zorder=6)
    unit = str(result[least].attrs["units"])
    axis.set_ylabel(state or with_unit(text_in(result, "shown"), unit))
    rpm_axis(axis, unit)
    _abscissa(axis, result)


def _periods(axis: Axes, result: xr.Dataset) -> None:
    name = "period_phi" if number_in(result, "rotor") else "period"
    value, period = result.value.values, result[name].values
    for k, at in enumerate(_branch_points(result.branch.values)):
        _pieces(axis, value[at], [period[at]], result.stable.values[at], _colour(k))
    _special(axis, result, name)
    for v, kind in zip(result.end_value.values, result.end_kind.values.astype(str), strict=True):
        if kind in _ENDS:
            axis.axvline(v, zorder=1, **_END)
    if len(period):
        least = [period[at].min() for at in _branch_points(result.branch.values) if len(at)]
        axis.set_ylim(0, min(1.05 * period.max(), _SHOWN_GROWTH * max(least)))  # a part of each branch
    axis.set_ylabel("period, angle of the main rotor (rad)" if number_in(result, "rotor") else label(result, name))
    _abscissa(axis, result)


def _abscissa(axis: Axes, result: xr.Dataset) -> None:
    axis.locator_params(axis="x", nbins=_TICKS)  # small values are long numbers
    axis.set(xlim=(number_in(result, "low"), number_in(result, "high")), xlabel=parameter_label(result))


def _branch_points(branch: np.ndarray) -> list[np.ndarray]:
    """Return the points of each branch, by their numbers (N,)."""
    return [np.flatnonzero(branch == k) for k in range(int(branch.max(initial=-1)) + 1)]


def _colour(branch: int) -> str:
    return COLOURS[branch % len(COLOURS)]


def _orbit_styles(result: xr.Dataset, drawn_orbits: list[int]) -> list[dict[str, Any]]:
    """The styles of orbits: from dark to light over the parameter, solid where stable, dashed where not."""
    stable = (result.orbit_exponent_re.values[:, drawn_orbits] < 0).all(axis=0)
    return [
        {"color": c, "linestyle": "-" if s else _SHORT_DASHES, "linewidth": _ORBIT_WIDTH, "zorder": 3}
        for s, c in zip(stable, shades(len(drawn_orbits) + 1, _SCALE)[:-1], strict=True)
    ]


def _pieces(axis: Axes, x: np.ndarray, curves: list[np.ndarray], stable: np.ndarray, colour: str) -> None:
    """Draw curves along a branch, solid where stable; the unstable stretches reach to the stable points beside them."""
    for a, b in equal_stretches(stable):
        first, last = (a, b) if stable[a] else (max(a - 1, 0), b + 1)
        for y in curves:
            axis.plot(x[first:last], y[first:last], color=colour, **(_STABLE if stable[a] else _UNSTABLE))


def _special(axis: Axes, result: xr.Dataset, *names: str) -> None:
    for name in names:
        draw_kinds(axis, result.orbit_value.values, result[f"orbit_{name}"].values, result.orbit_kind.values, _MARKS)


def _drawn_orbits(result: xr.Dataset) -> list[int]:
    """Return the indices of the reported orbits to be drawn: those of the first branch, spread over its range."""
    first = np.flatnonzero((result.orbit_branch.values == 0) & (result.orbit_kind.values.astype(str) == ""))
    if len(first) <= _MOST_DRAWN:
        return [int(i) for i in first]
    return [int(first[i]) for i in np.linspace(0, len(first) - 1, _MOST_DRAWN).round().astype(int)]


def _runs(axis: Axes, result: xr.Dataset, drawn_orbits: list[int], name: str, share: bool = False) -> None:
    """Draw orbits over the rotor's angle, or time, or the share of their period."""
    abscissa = "orbit_turned" if number_in(result, "rotor") else "orbit_time"
    factor, unit = printed_unit(result, name)
    for k, look in zip(drawn_orbits, _orbit_styles(result, drawn_orbits), strict=True):
        x, y = result[abscissa].values[k], factor * result[name].values[k]
        ordinate = result["orbit_state" if text_in(result, "state") else "orbit_speed"].values[k, :-1]
        begin = int(ordinate.argmin())  # at the least value
        x = np.concatenate([x[begin:-1], x[-1] + x[: begin + 1]]) - x[begin]
        y = np.concatenate([y[begin:-1], y[: begin + 1]])
        axis.plot(x / x[-1] if share else x, y, **look)
    axis.set(
        xlabel="share of the period" if share else label(result, abscissa),
        ylabel=text_in(result, "state") or label(result, name, unit),
    )


def _phase_space(axis: Axes, result: xr.Dataset, drawn_orbits: list[int]) -> None:
    """Draw orbits projected on the state of the other panels and on the first other one, if possible one that is no angle."""
    names, turning = result.state.values.astype(str).tolist(), result.turning.values > 0
    first = names.index(text_in(result, "state"))
    second = min((k for k in range(len(names)) if k != first), key=lambda k: bool(turning[k]))
    for k, look in zip(drawn_orbits, _orbit_styles(result, drawn_orbits), strict=True):
        states = result.orbit_states.values[k, [first, second]]
        axis.plot(*wrapped_curve(states, turning[[first, second]], (0.0, 0.0)), **look)
    axis.set(xlabel=names[first], ylabel=names[second])


def _legend(result: xr.Dataset, drawn_orbits: list[int]) -> list[Any]:
    handles = list[Any]()
    branches, stable = _branch_points(result.branch.values), result.stable.values.astype(bool)
    for k, at in enumerate(branches if drawn_orbits else ()):
        name = "orbits" if len(branches) == 1 else f"branch {k + 1}"
        handles += [entry(f"{name}, stable", color=_colour(k), **_STABLE)] if stable[at].any() else []
        handles += [] if stable[at].all() else [entry(f"{name}, unstable", color=_colour(k), **_UNSTABLE)]
    if result.sizes["steady"]:
        line = _STABLE if result.steady_stable.values.any() or not drawn_orbits else _UNSTABLE
        handles.append(entry("steady states" if drawn_orbits else "steady states, stable", color=_STEADY, **line))
        handles += [] if drawn_orbits else [entry("steady states, unstable", color=_STEADY, **_UNSTABLE)]
    handles += kind_entries(result.orbit_kind.values, _MARKS)
    ends = [_ENDS[kind] for kind in dict.fromkeys(result.end_kind.values.astype(str).tolist()) if kind in _ENDS]
    handles += [entry(name, color="black", linestyle="", marker=marker, markersize=6) for marker, name in ends]
    if drawn_orbits and ends:
        handles.append(entry("end of the orbits", **_END))
    path, unit = text_in(result, "along"), text_in(result, "along_unit")
    before = f"{formula_in_print(path)} = " if len(path) <= _SHORT else "at "
    for k, look in zip(drawn_orbits, _orbit_styles(result, drawn_orbits), strict=True):
        handles.append(entry(f"{before}{result.orbit_value.values[k]:.4g} {unit}".rstrip(), **look))
    return handles
