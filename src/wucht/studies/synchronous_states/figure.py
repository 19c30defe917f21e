"""The figure of steady phase configurations, and the stability map.

Of each it draws the balance of forces, as 000 Bild 3 to 6; of exciters alone the deck with its line of throw.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.machine_drawing import MachineShape, shape_in_result
from wucht.plots.page import current_page, small
from wucht.plots.scales import name_speeds
from wucht.plots.sheet import legend_beside, legend_over, new_grid, write_counts
from wucht.plots.stability_lines import draw_region, entry, field
from wucht.plots.style import COLOURS, GREY
from wucht.results.attributes import number_in
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS, _NARROW, _MOST = 4, 2, 12  # force balances a row, in a column of a journal, and in all
_ROW, _DECK, _MAP = 1.5, 2.2, 2.4  # inches
_FORCE, _THROW, _ROOM = 0.32, 0.6, 0.2  # length of an arrow and of a path, space around the deck, over its size
_TURN = np.linspace(0.0, 2 * math.pi, 181)
_PATTERNS, _HATCH = ("", "///", "...", "\\\\\\\\", "xx", "++", "oo", "--"), "#777777"
_ROTOR, _RESIDUAL_COLOUR = COLOURS[6], COLOURS[1]
_BODIES = (COLOURS[0], COLOURS[5], COLOURS[2], COLOURS[3], COLOURS[4])  # the first two differ in grey, too
_RESIDUAL_DASHES = (0, (2.5, 1.5))  # of the residual
# Light enough to be distinguished in grey, too: regions of the map, and where nothing is stable.
_REGIONS = ("#8FC7E8", "#F0B27A", "#FBE3A1", "#B7A0CF", "#C9E4CA", "#E8B7D4", "#9E9E9E", "#D7CCC8")
# Frames by the verdict on a state: colour, line, width, label.
_FRAMES: dict[str, tuple[str, Any, float, str]] = {
    "stable": (COLOURS[2], "-", 2.0, "stable"),
    "slow": (COLOURS[5], (0, (5, 1.5, 1, 1.5)), 2.0, "stable (averaged equations only)"),
    "overlapping": (COLOURS[6], (0, (1, 1.5)), 1.6, "bodies overlap"),
    "undecided": (GREY, (0, (5, 1.5, 1, 1.5)), 1.4, "undecided"),
    "unstable": (GREY, (0, (3, 3)), 0.8, "not stable"),
}
_MOST_PHASES = 3  # phases written out above a force balance
_WORDS = {1: "stable", 0: "unstable", -1: "undecided"}


def select_states(verdicts: Sequence[str], most: int) -> list[int]:
    """Select the states to be shown, in their order: of too many, unstable ones are left out first."""
    return sorted(sorted(range(len(verdicts)), key=lambda k: verdicts[k].startswith("unstable"))[:most])


def figure(result: xr.Dataset) -> Figure:
    """Draw, from the Dataset alone, the force balances of up to 12 states, and below them the stability map if any."""
    states, has_map, deck = select_states(result.verdict.values.tolist(), _MOST), "map_stable" in result, _deck_shape(result)
    rest = result.sizes["state"] - len(states)
    columns, row = (_COLUMNS, _ROW) if deck is None else (_NARROW, _DECK)
    heights = (*[row] * math.ceil(len(states) / (columns if current_page().columns >= columns else _NARROW)), _MAP)
    fig, axes = new_grid(
        len(states) + has_map,
        result.attrs["title"],
        answer_in_print(result),
        columns=columns,
        narrow=_NARROW,
        heights=heights,
        last=has_map,
    )
    if rest:
        write_counts(fig, f"{rest} more states are not drawn")
    for axis, k in zip(axes, states, strict=False):
        if deck is None:
            _force_balance(axis, result, k)
        else:
            _draw_deck(axis, result, k, deck)
    if states:
        title = "centrifugal forces"
        if deck is not None:
            title += " where their sum is along the throw"
        elif not number_in(result, "comparable"):
            title += ", each in the sense of its body"
        legend_over(fig, _legend(result, {_frame_kind(result, k) for k in states}, deck is not None), title)
    if has_map:
        _draw_map(axes[-1], result)
    return fig


def _force_balance(axis: Axes, result: xr.Dataset, k: int) -> None:
    """Draw centrifugal forces head to tail from the axis, that of the rotor to the right, and their resultant."""
    sizes, angles = result.unbalance.values, result.force_angle.values[k]
    sides = sizes * np.exp(1j * angles)
    ends = np.concatenate([[0.0], np.cumsum(sides)])
    whole = float(sizes.sum()) or 1.0
    looks = [_appearance(i) for i in range(len(sides))]
    arrows = list(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))
    if abs(ends[-1]) > 1e-6 * whole and number_in(result, "comparable"):
        arrows.append((0j, complex(ends[-1])))
        looks.append({"color": _RESIDUAL_COLOUR, "linestyle": _RESIDUAL_DASHES})
    offset_arrows = _separate_arrows(arrows, min(0.07, 0.45 / len(arrows)) * whole)
    for (start, end), look in zip(offset_arrows, looks, strict=True):
        if start != end:
            _arrow(axis, start, end, **look)
    axis.plot(0, 0, "o", color="black", markersize=3)
    _frame(axis, result, k, np.array([0j, *(point for arrow in offset_arrows for point in arrow)]), whole)
    axis.set_title(_title(result, k), fontsize=small(), pad=3)


def _deck_shape(result: xr.Dataset) -> MachineShape | None:
    """The shape of a carrier with exciters alone, each on another axis; else None, and where no throw was computed."""
    if all(state.get("throw_direction") is None for state in result.wucht.summary["states"]):
        return None
    shape = shape_in_result(result.wucht)
    if shape is None or any(rotor.bodies for rotor in shape.rotors):
        return None
    return shape if len({(rotor.x, rotor.y) for rotor in shape.rotors}) == len(shape.rotors) else None


def _draw_deck(axis: Axes, result: xr.Dataset, k: int, shape: MachineShape) -> None:
    """Draw the carrier, the centrifugal force of each exciter at its place, and the path of the centre of mass."""
    from matplotlib.patches import Circle, Rectangle

    state = result.wucht.summary["states"][k]
    direction, senses, phases = state.get("throw_direction"), result.sense.values, result.phase.values[k]
    relative = result.unbalance.values * np.exp(1j * (phases - senses * (direction or 0.0)))
    angles = senses * (phases - np.angle(relative.sum()))  # the sum of forces along the direction of throw is largest
    left, bottom, right, top = shape.box
    axis.add_patch(Rectangle((left, bottom), right - left, top - bottom, facecolor="#F1F3F5", edgecolor=GREY, linewidth=0.8))
    names = [str(name) for name in result.body_name.values]
    rotors = {rotor.name: rotor for rotor in shape.rotors}
    for i, (name, angle) in enumerate(zip(names, angles.tolist(), strict=True)):
        rotor = rotors[name]
        axis.add_patch(Circle((rotor.x, rotor.y), rotor.radius, facecolor="white", edgecolor="black", linewidth=0.8))
        place = complex(rotor.x, rotor.y)
        _arrow(axis, place, place + _FORCE * shape.size * np.exp(1j * angle), **_appearance(i))
    axis.plot(0, 0, "o", color=_RESIDUAL_COLOUR, markersize=4)
    throw = ""
    if direction is not None:
        ellipse = np.exp(1j * direction) * (np.cos(_TURN) + 1j * state["throw_ratio"] * np.sin(_TURN))
        axis.plot(*(_THROW * shape.size / 2 * np.array([ellipse.real, ellipse.imag])), color=_RESIDUAL_COLOUR, linewidth=2.0)
        throw = f"\nstroke {1e3 * state['stroke']:.4g} mm at {math.degrees(direction):.1f}°"
    room = _ROOM * shape.size
    axis.set(xlim=(left - room, right + room), ylim=(bottom - room, top + room), aspect="equal", xticks=[], yticks=[])
    _draw_frame(axis, result, k)
    axis.set_title(f"{_title(result, k)}{throw}", fontsize=small(), pad=3)


def _separate_arrows(arrows: list[tuple[complex, complex]], step: float) -> list[tuple[complex, complex]]:
    """Return arrows, each moved sideways as far as needed to avoid an overlap with one before it."""
    offset_arrows: list[tuple[complex, complex]] = []
    for start, end in arrows:
        aside = -1j * step * (end - start) / (abs(end - start) or 1.0)
        tries = ((start + n * aside, end + n * aside) for n in range(2 * len(arrows) + 1))
        offset_arrows.append(
            next((a for a in tries if not any(_arrows_overlap(a, b, step) for b in offset_arrows)), (start, end))
        )
    return offset_arrows


def _arrows_overlap(arrow: tuple[complex, complex], reference: tuple[complex, complex], near: float) -> bool:
    """True if two nearly collinear arrows overlap."""
    size = abs(reference[1] - reference[0])
    if size == 0 or arrow[0] == arrow[1]:
        return False
    along = (reference[1] - reference[0]) / size
    first, second = ((point - reference[0]) / along for point in arrow)
    low, high = sorted((first, second), key=lambda p: p.real)
    overlap = min(high.real, size) - max(low.real, 0.0)
    if overlap <= 0.25 * near:
        return False
    share = (np.clip([max(low.real, 0.0), min(high.real, size)], low.real, high.real) - low.real) / ((high - low).real or 1.0)
    beside = low.imag + share * (high.imag - low.imag)
    return bool(np.abs(beside).max() < 0.8 * near)


def _arrow(axis: Axes, start: complex, end: complex, **style: Any) -> None:
    style |= {"arrowstyle": "-|>", "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8}
    axis.annotate("", xy=(end.real, end.imag), xytext=(start.real, start.imag), arrowprops=style)


def _appearance(i: int) -> dict[str, Any]:
    """Return the style of a body's force: hollow beyond the fifth body, where colours repeat."""
    from matplotlib.patheffects import Stroke

    colour = _ROTOR if i == 0 else _BODIES[(i - 1) % len(_BODIES)]
    hollow = [Stroke(linewidth=3.2, foreground=colour), Stroke(linewidth=1.4, foreground="white")]
    return {"color": colour, "path_effects": hollow if i > len(_BODIES) else None}


def _frame(axis: Axes, result: xr.Dataset, k: int, points: np.ndarray, whole: float) -> None:
    extremes = np.array([[points.real.min(), points.imag.min()], [points.real.max(), points.imag.max()]])
    reach = 1.25 * 0.5 * max(*np.ptp(extremes, axis=0), 0.2 * whole)
    (x_low, y_low), (x_high, y_high) = extremes.mean(axis=0) - reach, extremes.mean(axis=0) + reach
    axis.set(xlim=(x_low, x_high), ylim=(y_low, y_high), aspect="equal", xticks=[], yticks=[])
    _draw_frame(axis, result, k)


def _draw_frame(axis: Axes, result: xr.Dataset, k: int) -> None:
    colour, line, width, _ = _FRAMES[_frame_kind(result, k)]
    for spine in axis.spines.values():
        spine.set(visible=True, color=colour, linestyle=line, linewidth=width)


def _frame_kind(result: xr.Dataset, k: int) -> str:
    """Return the key of a state's frame: "stable" needs the full equations, and bodies without overlap."""
    verdict = str(result.verdict.values[k])
    if not verdict.startswith("stable"):
        return "undecided" if verdict == "undecided" else "unstable"
    if result.overlapping.values[k]:
        return "overlapping"
    return "stable" if verdict == "stable" else "slow"


def _title(result: xr.Dataset, k: int) -> str:
    name = str(result["name"].values[k]) or "state"
    full, slow = int(result.stable_full[k]), int(result.stable_slow[k])
    word = str(result.verdict.values[k]).replace("in the averaged equations only", "(averaged)")
    if _frame_kind(result, k) == "overlapping":
        word = "bodies overlap"
    elif full not in (-1, slow):
        word = f"averaged: {_WORDS[slow]}, full: {_WORDS[full]}"
    phases = np.degrees(result.phase.values[k, 1:])
    several = len(phases) > _MOST_PHASES
    angles = ", ".join(f"{round(p, 1) % 360:.1f}°" for p in phases[: _MOST_PHASES - several]) + (", ..." if several else "")
    unit = result.speed.attrs["units"]
    speed = f"at {float(result.speed[k]):.5g} {unit}" if unit else f"at speed {float(result.speed[k]):.5g}"
    return f"{name}: {word}\n{angles}\n{speed}" if angles else f"{name}: {word}\n{speed}"


def _legend(result: xr.Dataset, frames: set[str], has_deck: bool) -> list[Any]:
    """Return entries of the bodies and of the drawn frames."""
    handles = [entry(str(name), linewidth=2, **_appearance(i)) for i, name in enumerate(result.body_name.values)]
    if has_deck:
        handles.append(entry("path of the centre of mass", color=_RESIDUAL_COLOUR, linewidth=2))
    elif number_in(result, "comparable"):
        handles.append(entry("resultant", color=_RESIDUAL_COLOUR, linewidth=2, linestyle=_RESIDUAL_DASHES))
    for colour, line, width, words in (frame for name, frame in _FRAMES.items() if name in frames):
        handles.append(field(words, "none", edge=colour, linestyle=line, linewidth=width))
    return handles


def _draw_map(axis: Axes, result: xr.Dataset) -> None:
    """Draw the states that are stable in the averaged equations, over speed and unbalance ratio."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    names = [str(n) for n in result.region.values]
    code = np.tensordot(2 ** np.arange(len(names)), result.map_stable.values.astype(int), 1)
    unique, index = np.unique(code, return_inverse=True)
    present: list[int] = unique.tolist()
    colours = _colours(present)
    at = result.map_speed.values, result.map_ratio.values, index.reshape(code.shape)
    cmap, norm = ListedColormap(list(colours.values())), BoundaryNorm(np.arange(len(present) + 1) - 0.5, len(present))
    axis.pcolormesh(*at, cmap=cmap, norm=norm, shading="nearest", rasterized=True)
    hatches = _hatches(present)
    for number, c in enumerate(present):
        if hatches[c] and min(at[2].shape) > 1:
            draw_region(axis, at[0], at[1], at[2] == number, hatches[c], _HATCH)
    words = {c: " and ".join(n for k, n in enumerate(names) if c >> k & 1) or "none" for c in present}
    handles = [field(words[c], colours[c], hatches[c]) for c in present]
    frequencies = np.unique(np.round(np.abs(result.natural_frequency.values), 9))
    for f in frequencies[(frequencies >= float(result.map_speed[0])) & (frequencies <= float(result.map_speed[-1]))]:
        axis.axvline(float(f), color=GREY, linestyle=":", linewidth=1.0)
    handles.append(entry("natural frequencies", color=GREY, linestyle=":"))
    handles += _machine_point(axis, result)
    axis.set_ylabel("unbalance of the balancing bodies over that of the rotor")
    name_speeds(axis, result, "map_speed", "x")
    legend_beside(axis, handles, "stable (averaged equations)")


def _colours(present: list[int]) -> dict[int, str]:
    """Return a colour for each combination of states, a bit each: fixed for a single state, a remaining one for others."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    single = {c: _REGIONS[c.bit_length() - 1] for c in present if c.bit_count() == 1 and c.bit_length() <= len(_REGIONS)}
    combinations = [c for c in present if c and c not in single]
    further = map(to_hex, colormaps["viridis"](np.linspace(0.35, 1.0, len(combinations))))
    free_colours = [*(c for c in reversed(_REGIONS) if c not in single.values()), *further]
    table = {0: "white"} | single | dict(zip(combinations, free_colours, strict=False))
    return {c: table[c] for c in present}


def _hatches(present: list[int]) -> dict[int, str]:
    """Return a hatch for each combination, so that regions differ in grey too; none where nothing is stable."""
    single = {c: _PATTERNS[(c.bit_length() - 1) % len(_PATTERNS)] for c in present if c.bit_count() == 1}
    free_hatches = [h for h in reversed(_PATTERNS) if h not in single.values()] or list(_PATTERNS)
    combinations = [c for c in present if c and c not in single]
    return {0: ""} | single | {c: free_hatches[k % len(free_hatches)] for k, c in enumerate(combinations)}


def _machine_point(axis: Axes, result: xr.Dataset) -> list[Any]:
    """Draw the machine's place on the map, where it has one."""
    unbalances, (low, high), (first, last) = result.unbalance.values, axis.get_ylim(), axis.get_xlim()
    ratio = unbalances[1:].sum() / unbalances[0] if unbalances[0] else math.inf
    speeds = np.unique(np.round(np.abs(result.speed.values), 6))
    inside = speeds[(speeds >= first) & (speeds <= last)]
    is_visible = low <= ratio <= high and len(inside)
    look: dict[str, Any] = {"color": "black", "markerfacecolor": "white", "markersize": 5, "label": "states above"}
    return list(axis.plot(inside, np.full(len(inside), ratio), "o", **look)) if is_visible else []
