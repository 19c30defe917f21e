"""The figure of steady phase configurations: the force balance of each, as 000 Bild 3 to 6, and the stability map."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.style import COLOURS, GREY
from wucht.studies.synchronous_states.figure_of_map import draw_map

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS, _MOST = 4, 12  # force balances a row, and in all
_WIDTH, _ROW, _MAP, _ENTRY = 8.0, 2.05, 3.2, 0.175  # inches
_ROTOR, _LEFT = COLOURS[6], COLOURS[1]
_BODIES = (COLOURS[0], COLOURS[2], COLOURS[3], COLOURS[4], COLOURS[5])
# Frames by what is said of a state: colour, line, width, words.
_FRAMES: dict[str, tuple[str, Any, float, str]] = {
    "stable": (COLOURS[2], "-", 2.0, "stable"),
    "slow": (COLOURS[5], (0, (5, 1.5, 1, 1.5)), 2.0, "stable (slow\nequations only)"),
    "overlapping": (COLOURS[6], (0, (1, 1.5)), 1.6, "bodies overlap"),
    "undecided": (GREY, (0, (5, 1.5, 1, 1.5)), 1.4, "undecided"),
    "unstable": (GREY, (0, (3, 3)), 0.8, "not stable"),
}
_NAMED = 3  # phases written out above a force balance
_WORDS = {1: "stable", 0: "unstable", -1: "undecided"}
_LINE = 100  # characters of the heading


def figure(result: xr.Dataset) -> Figure:
    """The force balances of up to 12 states, and below them the stability map if there is one: from the Dataset alone."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    mpl.rcParams.update({"font.size": 9, "axes.linewidth": 0.7})
    shown, mapped = _chosen(result), "map_stable" in result
    rows = math.ceil(len(shown) / _COLUMNS)
    heading = textwrap.wrap(result.attrs["sentence"], _LINE)
    above = 0.8 + 0.17 * (len(heading) - 1)
    balances = max(rows * _ROW, 0.0 if mapped else _ROW, (result.sizes["body"] + 7) * _ENTRY if shown else 0.0)
    height = above + balances + (_MAP if mapped else 0.0)
    drawn = Figure(figsize=(_WIDTH, height), dpi=150)
    FigureCanvasAgg(drawn)
    title = drawn.suptitle("\n".join([result.attrs["title"], *heading]), fontsize=10, y=1 - 0.12 / height, va="top")
    title.set_parse_math(False)
    for place, k in enumerate(shown):
        row, column = divmod(place, _COLUMNS)
        top = height - above + 0.2 - row * _ROW
        where = ((0.1 + 1.62 * column) / _WIDTH, (top - _ROW + 0.05) / height, 1.5 / _WIDTH, 1.5 / height)
        _force_balance(drawn.add_axes(where), result, k)
    if shown:
        _legend(drawn, result, height, above)
    if mapped:
        draw_map(drawn.add_axes((0.75 / _WIDTH, 0.5 / height, 4.9 / _WIDTH, (_MAP - 0.8) / height)), result)
    rest = result.sizes["state"] - len(shown)
    if rest:
        drawn.text(0.99, 0.01, f"and {rest} more", ha="right", fontsize=8, color=GREY)
    return drawn


def _chosen(result: xr.Dataset) -> list[int]:
    """The states that are drawn, in their order: where there are too many, those are left out first that are not stable."""
    order = sorted(range(result.sizes["state"]), key=lambda k: str(result.verdict.values[k]).startswith("unstable"))
    return sorted(order[:_MOST])


def _force_balance(axis: Axes, result: xr.Dataset, k: int) -> None:
    """Centrifugal forces head to tail from the axis, that of the rotor to the right, and what is left of them."""
    sizes, angles = result.unbalance.values, result.force_angle.values[k]
    sides = sizes * np.exp(1j * angles)
    ends = np.concatenate([[0.0], np.cumsum(sides)])
    whole = float(sizes.sum()) or 1.0
    flat = bool((np.abs(sides.imag) <= 0.25 * np.abs(sides)).all())  # in line the arrows would lie on each other
    shift = -1j * min(0.06, 0.3 / len(sides)) * whole * np.arange(len(sides)) * flat
    for i, (start, side) in enumerate(zip(ends[:-1], sides, strict=True)):
        _arrow(axis, start + shift[i], start + side + shift[i], _colour(i), 1.6, hollow=i > len(_BODIES))
    left = ends[-1]
    if abs(left) > 1e-6 * whole and result.attrs["comparable"]:
        aside = 1j * 0.09 * whole if flat else 0.0
        _arrow(axis, aside, left + aside, _LEFT, 1.6, dashed=True)
    axis.plot(0, 0, "o", color="black", markersize=3)
    every = np.concatenate([ends, ends[1:] + shift, [0.09j * whole if flat else 0.0]])
    _frame(axis, result, k, every, whole)
    axis.set_title(_title(result, k), fontsize=7.5, pad=3)


def _arrow(
    axis: Axes, start: complex, end: complex, colour: str, width: float, dashed: bool = False, hollow: bool = False
) -> None:
    style: dict[str, Any] = {
        "arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8,
        "linestyle": (0, (2.5, 1.5)) if dashed else "-", "path_effects": _hollow(colour) if hollow else None,
    }  # fmt: skip
    axis.annotate("", xy=(end.real, end.imag), xytext=(start.real, start.imag), arrowprops=style)


def _hollow(colour: str) -> list[Any]:
    """How bodies beyond the fifth, whose colours come again, are drawn."""
    from matplotlib.patheffects import Stroke

    return [Stroke(linewidth=3.2, foreground=colour), Stroke(linewidth=1.4, foreground="white")]


def _frame(axis: Axes, result: xr.Dataset, k: int, points: np.ndarray, whole: float) -> None:
    x, y = points.real, points.imag
    centre, half = ((x.max() + x.min()) / 2, (y.max() + y.min()) / 2), 0.5 * max(np.ptp(x), np.ptp(y), 0.2 * whole)
    axis.set_xlim(centre[0] - 1.25 * half, centre[0] + 1.25 * half)
    axis.set_ylim(centre[1] - 1.25 * half, centre[1] + 1.25 * half)
    axis.set_aspect("equal")
    axis.set_xticks([])
    axis.set_yticks([])
    colour, line, width, _ = _FRAMES[_framed(result, k)]
    for spine in axis.spines.values():
        spine.set_visible(True)
        spine.set_color(colour)
        spine.set_linestyle(line)
        spine.set_linewidth(width)


def _framed(result: xr.Dataset, k: int) -> str:
    """Which frame a state has: only what the full equations say is stable, with bodies that have room, is framed so."""
    verdict = str(result.verdict.values[k])
    if not verdict.startswith("stable"):
        return "undecided" if verdict == "undecided" else "unstable"
    if result.overlapping.values[k]:
        return "overlapping"
    return "stable" if verdict == "stable" else "slow"


def _title(result: xr.Dataset, k: int) -> str:
    name = str(result["name"].values[k]) or "state"
    full, slow = int(result.stable_full[k]), int(result.stable_slow[k])
    word = str(result.verdict.values[k]).replace("in the slow equations only", "(slow)")
    if _framed(result, k) == "overlapping":
        word = "bodies overlap"
    elif full not in (-1, slow):
        word = f"slow: {_WORDS[slow]}, full: {_WORDS[full]}"
    phases = np.degrees(result.phase.values[k, 1:])
    several = len(phases) > _NAMED
    angles = ", ".join(f"{round(p, 1) % 360:.1f}°" for p in phases[: _NAMED - several]) + (", ..." if several else "")
    unit = result.speed.attrs["units"]
    lines = [f"{name}: {word}", angles]
    if np.ptp(result.speed.values) > 0:
        lines.append(f"at {float(result.speed[k]):.5g} {unit}".rstrip())
    return "\n".join(lines)


def _colour(i: int) -> str:
    return _ROTOR if i == 0 else _BODIES[(i - 1) % len(_BODIES)]


def _legend(drawn: Figure, result: xr.Dataset, height: float, above: float) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Line2D([], [], color=_colour(i), linewidth=2, label=n, path_effects=_hollow(_colour(i)) if i > len(_BODIES) else None)
        for i, n in enumerate(str(n) for n in result.body_name.values)
    ]
    if result.attrs["comparable"]:
        handles.append(Line2D([], [], color=_LEFT, linewidth=2, linestyle=(0, (2.5, 1.5)), label="what is left"))
    present = {_framed(result, k) for k in range(min(result.sizes["state"], _MOST))}
    for name in (n for n in _FRAMES if n in present):
        colour, line, width, words = _FRAMES[name]
        handles.append(Patch(facecolor="none", edgecolor=colour, linestyle=line, linewidth=width, label=words))
    place = (6.62 / _WIDTH, (height - above + 0.08) / height)
    title = "centrifugal forces" if result.attrs["comparable"] else "forces, each turned\nin its body's sense"
    drawn.legend(handles=handles, loc="upper left", bbox_to_anchor=place, frameon=False, fontsize=8, title=title)
