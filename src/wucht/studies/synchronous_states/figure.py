"""The figure of steady phase configurations: the force balance of each, as 000 Bild 3 to 6, and the stability map."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.style import COLOURS, GREY, label
from wucht.studies.synchronous_states.report import chosen

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS, _MOST = 4, 12  # force balances a row, and in all
_WIDTH, _ROW, _MAP, _ENTRY = 8.0, 2.05, 3.2, 0.175  # inches
_ROTOR, _LEFT = COLOURS[6], COLOURS[1]
_BODIES = (COLOURS[0], *COLOURS[2:6])
_DASHED = (0, (2.5, 1.5))  # of what is left
# Light enough to be distinguished in grey, too: regions of the map, and where nothing is stable.
_REGIONS = ("#8FC7E8", "#F0B27A", "#FBE3A1", "#B7A0CF", "#C9E4CA", "#E8B7D4", "#9E9E9E", "#D7CCC8")
# Frames by the verdict on a state: colour, line, width, words.
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
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown, mapped = chosen(result.verdict.values.tolist(), _MOST), "map_stable" in result
    rows = math.ceil(len(shown) / _COLUMNS)
    heading = textwrap.wrap(result.attrs["sentence"], _LINE)
    above = 0.8 + 0.17 * (len(heading) - 1)
    balances = max(rows * _ROW, 0.0 if mapped else _ROW, (result.sizes["body"] + 7) * _ENTRY if shown else 0.0)
    height = above + balances + (_MAP if mapped else 0.0)
    drawn = Figure(figsize=(_WIDTH, height), dpi=150)
    FigureCanvasAgg(drawn)
    title = "\n".join([result.attrs["title"], *heading])
    drawn.suptitle(title, fontsize=10, y=1 - 0.12 / height, va="top").set_parse_math(False)
    for place, k in enumerate(shown):
        row, column = divmod(place, _COLUMNS)
        top = height - above + 0.2 - row * _ROW
        where = ((0.1 + 1.62 * column) / _WIDTH, (top - _ROW + 0.05) / height, 1.5 / _WIDTH, 1.5 / height)
        _force_balance(drawn.add_axes(where), result, k)
    if shown:
        _legend(drawn, result, {_framed(result, k) for k in shown}, (height - above + 0.08) / height)
    if mapped:
        _draw_map(drawn.add_axes((0.75 / _WIDTH, 0.5 / height, 4.9 / _WIDTH, (_MAP - 0.8) / height)), result)
    if rest := result.sizes["state"] - len(shown):
        drawn.text(0.99, 0.01, f"and {rest} more", ha="right", fontsize=8, color=GREY)
    return drawn


def _force_balance(axis: Axes, result: xr.Dataset, k: int) -> None:
    """Centrifugal forces head to tail from the axis, that of the rotor to the right, and what is left of them."""
    sizes, angles = result.unbalance.values, result.force_angle.values[k]
    sides = sizes * np.exp(1j * angles)
    ends = np.concatenate([[0.0], np.cumsum(sides)])
    whole = float(sizes.sum()) or 1.0
    flat = bool((np.abs(sides.imag) <= 0.25 * np.abs(sides)).all())  # in line the arrows would lie on each other
    shift = -1j * min(0.06, 0.3 / len(sides)) * whole * np.arange(len(sides)) * flat
    for i, (start, side) in enumerate(zip(ends[:-1] + shift, sides, strict=True)):
        _arrow(axis, start, start + side, **_appearance(i))
    left, aside = ends[-1], 0.09j * whole if flat else 0.0
    if abs(left) > 1e-6 * whole and result.attrs["comparable"]:
        _arrow(axis, aside, left + aside, color=_LEFT, linestyle=_DASHED)
    axis.plot(0, 0, "o", color="black", markersize=3)
    _frame(axis, result, k, np.concatenate([ends, ends[1:] + shift, [aside]]), whole)
    axis.set_title(_title(result, k), fontsize=7.5, pad=3)


def _arrow(axis: Axes, start: complex, end: complex, **style: Any) -> None:
    style |= {"arrowstyle": "-|>", "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8}
    axis.annotate("", xy=(end.real, end.imag), xytext=(start.real, start.imag), arrowprops=style)


def _appearance(i: int) -> dict[str, Any]:
    """How a body's force is drawn: hollow beyond the fifth body, where colours come again."""
    from matplotlib.patheffects import Stroke

    colour = _ROTOR if i == 0 else _BODIES[(i - 1) % len(_BODIES)]
    hollow = [Stroke(linewidth=3.2, foreground=colour), Stroke(linewidth=1.4, foreground="white")]
    return {"color": colour, "path_effects": hollow if i > len(_BODIES) else None}


def _frame(axis: Axes, result: xr.Dataset, k: int, points: np.ndarray, whole: float) -> None:
    extremes = np.array([[points.real.min(), points.imag.min()], [points.real.max(), points.imag.max()]])
    reach = 1.25 * 0.5 * max(*np.ptp(extremes, axis=0), 0.2 * whole)
    (left, bottom), (right, top) = extremes.mean(axis=0) - reach, extremes.mean(axis=0) + reach
    axis.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
    colour, line, width, _ = _FRAMES[_framed(result, k)]
    for spine in axis.spines.values():
        spine.set(visible=True, color=colour, linestyle=line, linewidth=width)


def _framed(result: xr.Dataset, k: int) -> str:
    """Which frame a state has: only what is stable in the full equations, with bodies that have room, is framed so."""
    verdict = str(result.verdict.values[k])
    if not verdict.startswith("stable"):
        return "undecided" if verdict == "undecided" else "unstable"
    if result.overlapping.values[k]:
        return "overlapping"
    return "stable" if verdict == "stable" else "slow"


def _title(result: xr.Dataset, k: int) -> str:
    name = str(result["name"].values[k]) or "state"
    full, slow = int(result.stable_full[k]), int(result.stable_slow[k])
    word = str(result.verdict.values[k]).replace("in the averaged equations only", "(slow)")
    if _framed(result, k) == "overlapping":
        word = "bodies overlap"
    elif full not in (-1, slow):
        word = f"slow: {_WORDS[slow]}, full: {_WORDS[full]}"
    phases = np.degrees(result.phase.values[k, 1:])
    several = len(phases) > _NAMED
    angles = ", ".join(f"{round(p, 1) % 360:.1f}°" for p in phases[: _NAMED - several]) + (", ..." if several else "")
    unit = result.speed.attrs["units"]
    speed = f"\nat {float(result.speed[k]):.5g} {unit}".rstrip() if np.ptp(result.speed.values) > 0 else ""
    return f"{name}: {word}\n{angles}{speed}"


def _legend(drawn: Figure, result: xr.Dataset, frames: set[str], top: float) -> None:
    """Of the bodies and of the frames that are drawn, from ``top`` down."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    names = map(str, result.body_name.values)
    handles: list[Any] = [Line2D([], [], linewidth=2, label=n, **_appearance(i)) for i, n in enumerate(names)]
    if result.attrs["comparable"]:
        handles.append(Line2D([], [], color=_LEFT, linewidth=2, linestyle=_DASHED, label="what is left"))
    for colour, line, width, words in (frame for name, frame in _FRAMES.items() if name in frames):
        handles.append(Patch(facecolor="none", edgecolor=colour, linestyle=line, linewidth=width, label=words))
    place = (6.62 / _WIDTH, top)
    title = "centrifugal forces" if result.attrs["comparable"] else "forces, each turned\nin its body's sense"
    drawn.legend(handles=handles, loc="upper left", bbox_to_anchor=place, frameon=False, fontsize=8, title=title)


def _draw_map(axis: Axes, result: xr.Dataset) -> None:
    """Which states are stable in the averaged equations, over speed and unbalance ratio."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    names = [str(n) for n in result.region.values]
    code = np.tensordot(2 ** np.arange(len(names)), result.map_stable.values.astype(int), 1)
    unique, index = np.unique(code, return_inverse=True)
    present: list[int] = unique.tolist()
    colours = _colours(present)
    at = result.map_speed.values, result.map_ratio.values, index.reshape(code.shape)
    cmap, norm = ListedColormap(list(colours.values())), BoundaryNorm(np.arange(len(present) + 1) - 0.5, len(present))
    axis.pcolormesh(*at, cmap=cmap, norm=norm, shading="nearest", rasterized=True)
    words = {c: " and ".join(n for k, n in enumerate(names) if c >> k & 1) or "none" for c in present}
    handles: list[Any] = [Patch(facecolor=colours[c], edgecolor=GREY, linewidth=0.5, label=words[c]) for c in present]
    frequencies = np.unique(np.round(np.abs(result.natural_frequency.values), 9))
    for f in frequencies[(frequencies >= float(result.map_speed[0])) & (frequencies <= float(result.map_speed[-1]))]:
        axis.axvline(float(f), color=GREY, linestyle=":", linewidth=1.0)
    handles.append(Line2D([], [], color=GREY, linestyle=":", label="natural frequencies"))
    handles += _this_machine(axis, result)
    axis.set(xlabel=label(result, "map_speed"), ylabel="unbalance of the balancing\nbodies over that of the rotor")
    axis.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1.02), frameon=False, fontsize=8,
        title="stable (averaged equations)",
    )  # fmt: skip


def _colours(present: list[int]) -> dict[int, str]:
    """A colour for each combination of states, a bit each: of a single state always the same, of others one that is left."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    single = {c: _REGIONS[c.bit_length() - 1] for c in present if c.bit_count() == 1 and c.bit_length() <= len(_REGIONS)}
    others = [c for c in present if c and c not in single]
    further = map(to_hex, colormaps["viridis"](np.linspace(0.35, 1.0, len(others))))
    left = [*(c for c in reversed(_REGIONS) if c not in single.values()), *further]
    table = {0: "white"} | single | dict(zip(others, left, strict=False))
    return {c: table[c] for c in present}


def _this_machine(axis: Axes, result: xr.Dataset) -> list[Any]:
    """The machine's own place, where it has one on the map."""
    own, (low, high), (first, last) = result.unbalance.values, axis.get_ylim(), axis.get_xlim()
    ratio = own[1:].sum() / own[0] if own[0] else math.inf
    speeds = np.unique(np.round(np.abs(result.speed.values), 6))
    inside = speeds[(speeds >= first) & (speeds <= last)]
    shown = low <= ratio <= high and len(inside)
    style: dict[str, Any] = {"color": "black", "markerfacecolor": "white", "markersize": 5, "label": "states above"}
    return axis.plot(inside, np.full(len(inside), ratio), "o", **style) if shown else []
