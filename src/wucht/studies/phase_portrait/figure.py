"""The figure of phase portraits: the unrolled cylinder with fixed points, separatrices, closed curves, as 002 figure 5.5."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import fraction_of_pi
from wucht.plots.sheet import legend_below, new_grid
from wucht.plots.stability_lines import entry
from wucht.plots.style import COLOURS
from wucht.results.attributes import number_in
from wucht.results.formatting import with_unit
from wucht.results.report import answer_in_print
from wucht.studies.phase_portrait.state_projection_figure import draw_projection

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_UNSTABLE: dict[str, Any] = {"color": COLOURS[1], "linewidth": 1.7, "linestyle": "-", "zorder": 4}
_STABLE: dict[str, Any] = {"color": COLOURS[0], "linewidth": 1.7, "linestyle": (0, (4, 1.6)), "zorder": 4}
_CLOSED_CURVES: dict[str, dict[str, Any]] = {
    kind: {"color": COLOURS[2], "linewidth": 2.8, "zorder": 5, "linestyle": line}
    for kind, line in (("stable", "-"), ("unstable", ":"))
}
_TRAJECTORY: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 0.6, "zorder": 2}
_NULLCLINES = ((COLOURS[3], (0, (1, 1.4))), (COLOURS[5], (0, (5, 1.2, 1, 1.2))))
_POINT: dict[str, Any] = {"linestyle": "", "color": "black", "markersize": 6.5}
_POINTS: dict[str, tuple[str, dict[str, Any]]] = {
    "stable": ("stable fixed point", {"marker": "o", "markerfacecolor": "black"}),
    "within": ("stable within the section only", {"marker": "o", "markerfacecolor": "black", "fillstyle": "bottom"}),
    "unstable": ("unstable fixed point", {"marker": "o", "markerfacecolor": "white"}),
    "saddle": ("saddle", {"marker": "x", "markeredgewidth": 2.0}),
    "other": ("centre or degenerate", {"marker": "o", "markerfacecolor": "white", "markeredgewidth": 0.8, "fillstyle": "none"}),
}
_FEW = 3  # portraits beside each other


def figure(result: xr.Dataset) -> Figure:
    """Draw a panel for each portrait, from the Dataset alone."""
    if "equilibria" in result:
        return draw_projection(result)
    cases = result.sizes.get("case", 1)
    columns = 1 if cases == 1 else 2 if cases in (2, 4) else _FEW
    height = 4.2 if cases == 1 else 2.4 if columns == 2 else 1.9
    fig, axes = new_grid(cases, result.attrs["title"], answer_in_print(result), columns=columns, heights=height)
    for k, (axis, one) in enumerate(zip(axes, _portraits(result), strict=True)):
        _panel(axis, one)
        _scales(axis, result)
        if not result.turn.values.any() and np.ptp(result.drawn.values[0]) == np.ptp(result.drawn.values[1]):
            axis.set_aspect("equal", adjustable="box")
        if cases > 1:
            axis.set_title(str(result.case.values[k]))
    legend_below(fig, _legend(result))
    return fig


def _portraits(result: xr.Dataset) -> list[xr.Dataset]:
    return [result.isel(case=k) for k in range(result.sizes["case"])] if "case" in result.sizes else [result]


def _order(result: xr.Dataset) -> list[int]:
    """Return the indices of the states of the abscissa and of the ordinate."""
    return [int(number_in(result, "abscissa")), 1 - int(number_in(result, "abscissa"))]


def _panel(axis: Axes, one: xr.Dataset) -> None:
    """Draw one portrait."""
    order = _order(one)
    box, turns = one.drawn.values[order], one.turn.values[order]
    axis.set(xlim=box[0], ylim=box[1])
    if "rate" in one:
        grid = [np.linspace(low, high, one.sizes[d]) for (low, high), d in zip(box, ("abscissa", "ordinate"), strict=True)]
        for i, (colour, dashes) in zip(order, _NULLCLINES, strict=True):
            look: dict[str, Any] = {"colors": [colour], "linestyles": [dashes], "linewidths": 1.0, "zorder": 3}
            axis.contour(*grid, one.rate.values[i], levels=[0.0], **look)
    for states in one.trajectories.values:
        _curve(axis, states[order], box, turns, _TRAJECTORY, 6.0)
    for states, stable in zip(one.separatrices.values, one.separatrix_stable.values, strict=True):
        if np.isfinite(stable):
            path = states[order][:, ::-1] if stable else states[order]
            _curve(axis, path, box, turns, _STABLE if stable else _UNSTABLE, 11.0)
    for states, kind in zip(one.closed_curves.values, one.closed_curve_kind.values.astype(str), strict=True):
        if kind in _CLOSED_CURVES:  # those of a family are drawn as trajectories
            _curve(axis, states[order], box, turns, _CLOSED_CURVES[kind], 11.0)
    for state, symbol in zip(one.fixed_points.values, _classes(one), strict=True):
        for shift in _shifts(state[order][:, None], box, turns):
            axis.plot(*(state[order] + shift), zorder=7, clip_on=False, **_POINT | _POINTS[symbol][1])


def _classes(one: xr.Dataset) -> list[str]:
    """Return the symbol of each fixed point."""
    classes = []
    for kind, growth in zip(one.fixed_point_kind.values.astype(str), one.transverse_growth.values, strict=True):
        if kind.startswith("stable"):
            classes.append("within" if growth > 0 else "stable")
        else:
            classes.append("unstable" if kind.startswith("unstable") else "saddle" if kind == "saddle" else "other")
    return classes


def _shifts(states: np.ndarray, box: np.ndarray, turns: np.ndarray) -> list[np.ndarray]:
    """Return the whole turns of angles that move curves or points (2, N) into the box."""
    fine = states[:, np.isfinite(states).all(axis=0)]
    if not fine.size:
        return []
    shifts = []
    for i in range(2):
        if not turns[i]:
            shifts.append([0.0])
            continue
        slack = 1e-9 * turns[i]
        first = math.ceil((box[i, 0] - fine[i].max() - slack) / turns[i])
        last = math.floor((box[i, 1] - fine[i].min() + slack) / turns[i])
        shifts.append([k * turns[i] for k in range(first, last + 1)])
    return [np.array([a, b]) for a in shifts[0] for b in shifts[1]]


def _curve(axis: Axes, states: np.ndarray, box: np.ndarray, turns: np.ndarray, style: dict[str, Any], head: float) -> None:
    """Draw a curve (2, N) with an arrow, repeated by whole turns."""
    fine = states[:, np.isfinite(states).all(axis=0)]
    if fine.shape[1] < 2:
        return
    for shift in _shifts(fine, box, turns):
        x = fine + shift[:, None]
        axis.plot(*x, **style)
        _arrow(axis, x, box, style, head)


def _arrow(axis: Axes, x: np.ndarray, box: np.ndarray, style: dict[str, Any], head: float) -> None:
    """Draw an arrow in the middle of the visible part of a curve, unless this is too short."""
    share = (x - box[:, :1]) / (box[:, 1:] - box[:, :1])
    is_visible = ((share > 0.02) & (share < 0.98)).all(axis=0)
    steps = np.hypot(*np.diff(share, axis=1)) * (is_visible[:-1] & is_visible[1:])
    whole = float(steps.sum())
    if whole < 0.06:
        return
    at = min(int(np.searchsorted(np.cumsum(steps), whole / 2)), len(steps) - 1)
    ahead = min(at + 1 + int((np.cumsum(steps[at:]) < 0.004).sum()), x.shape[1] - 1)
    if not is_visible[at] or ahead == at:
        return
    arrow = {"arrowstyle": "-|>", "color": style["color"], "linewidth": 0.0, "mutation_scale": head, "shrinkA": 0, "shrinkB": 0}
    axis.annotate("", xy=tuple(x[:, ahead]), xytext=tuple(x[:, at]), arrowprops=arrow, zorder=style["zorder"] + 0.5)


def _scales(axis: Axes, result: xr.Dataset) -> None:
    """Set names and ticks of both axes; angles in parts of pi."""
    for i, one in zip(_order(result), (axis.xaxis, axis.yaxis), strict=True):
        name, unit = str(result.state_label.values[i]), str(result.state_unit.values[i])
        symbol = {"psi": "$\\psi$", "speed": "$\\omega$"}.get(str(result.state.values[i]), "")
        one.set_label_text(with_unit(f"{name} {symbol}".strip() if number_in(result, "section") else name, unit))
        if result.turn.values[i]:
            low, high = result.drawn.values[i]
            parts = 2 if high - low <= 2.1 * math.pi else 1
            step = math.pi / parts
            ticks = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
            one.set_ticks([t * step for t in ticks], [fraction_of_pi(t, parts) for t in ticks])


def _legend(result: xr.Dataset) -> list[Any]:
    """Return the legend's entries of the drawn symbols and lines."""
    there = {c for p in _portraits(result) for c, kind in zip(_classes(p), p.fixed_point_kind.values, strict=True) if kind}
    entries = [entry(name, **_POINT | style) for symbol, (name, style) in _POINTS.items() if symbol in there]
    if result.sizes["separatrix"]:
        entries.append(entry("unstable manifold: leaves the saddle", **_UNSTABLE))
        entries.append(entry("stable manifold: leads to the saddle", **_STABLE))
    kinds = {str(k) for k in np.ravel(result.closed_curve_kind.values)}
    entries += [entry(f"closed curve, {kind}", **look) for kind, look in _CLOSED_CURVES.items() if kind in kinds]
    if result.sizes["trajectory"]:
        entries.append(entry("trajectory", **_TRAJECTORY))
    for i, (colour, dashes) in zip(_order(result), _NULLCLINES, strict=True) if "rate" in result else ():
        entries.append(entry(f"nullcline of {result.state.values[i]}", color=colour, linestyle=dashes))
    return entries
