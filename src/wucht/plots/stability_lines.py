"""Branches of steady states and orbits, solid where stable, dashed where not; marked points, regions, and legend entries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.style import COLOURS, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Symbol = tuple[str, str, str]  # marker, face, name
_SIZE = 5
_FRAME = 0.5  # line width of the frame of a region in a legend
OVERLAPPING = "bodies overlapping"  # bodies of a track, as contacts between them are left out here
_UNSTABLE: dict[str, Any] = {"color": GREY, "linestyle": "--", "linewidth": 0.84}
_COLOURS = (COLOURS[0], COLOURS[3], COLOURS[5], COLOURS[4])
_THINNER = 0.7
_BETWEEN = 8  # segments of a smooth curve between two points
_FEWEST = 4  # least number of points for a smooth curve instead of a polygon


def entry(name: str, **look: Any) -> Any:
    """A line or a marker in a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=name, **look)


def field(name: str, tone: str, hatch: str = "", edge: str = GREY, **look: Any) -> Any:
    """A region in a legend."""
    from matplotlib.patches import Patch

    return Patch(facecolor=tone, hatch=hatch, edgecolor=edge, label=name, **{"linewidth": _FRAME} | look)


def draw_classes(
    axis: Axes, x: np.ndarray, y: np.ndarray, classes: Iterable[tuple[np.ndarray, str, str, str | None]], **look: Any
) -> None:
    """Draw points (N,) in classes: mask (N,) of each class, its marker, face colour and name. An empty class has no name."""
    for chosen, marker, face, name in classes:
        if chosen.any():
            axis.plot(x[chosen], y[chosen], marker, markerfacecolor=face, label=name, **look)


def draw_kinds(axis: Axes, x: np.ndarray, y: np.ndarray, kinds: np.ndarray, symbols: Mapping[str, Symbol]) -> None:
    """Draw special points (N,), each with the symbol of its kind; points without a kind are left out."""
    for kind in _present(kinds):
        marker, face, _ = _symbol(kind, symbols)
        at = kinds.astype(str) == kind
        axis.plot(x[at], y[at], marker, color="black", markerfacecolor=face, markersize=_SIZE, markeredgewidth=1.0, zorder=5)


def kind_entries(kinds: np.ndarray, symbols: Mapping[str, Symbol]) -> list[Any]:
    """Legend entries of special points."""
    kind_symbols = [_symbol(kind, symbols) for kind in _present(kinds)]
    look: dict[str, Any] = {"color": "black", "linestyle": "", "markersize": _SIZE}
    return [entry(name, marker=marker, markerfacecolor=face, **look) for marker, face, name in kind_symbols]


def _present(kinds: np.ndarray) -> list[str]:
    return [kind for kind in dict.fromkeys(kinds.astype(str).tolist()) if kind]


def _symbol(kind: str, symbols: Mapping[str, Symbol]) -> Symbol:
    """The symbol of a kind; by default that of the kind without a name."""
    marker, face, name = symbols.get(kind, symbols[""])
    return marker, face, name or kind.replace("-", " ")


def draw_region(axis: Axes, x: np.ndarray, y: np.ndarray, inside: np.ndarray, hatch: str, edge: str, **look: Any) -> None:
    """Draw a hatched region of the plane: x (M,), y (N,), mask (N, M). look: with ``colors``, if it is coloured too."""
    contours = axis.contourf(x, y, inside.astype(float), levels=[0.5, 1.5], hatches=[hatch], **{"colors": ["none"]} | look)
    contours.set(edgecolor=edge, linewidth=0.0)


def equal_stretches(kinds: np.ndarray) -> list[tuple[int, int]]:
    """Runs of equal values in (N,): the first index of each, and that of the next run."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(kinds)) + 1, [len(kinds)]])
    return [(a, b) for a, b in pairwise(edges.tolist()) if b > a]


def extend_both_ways(mask: np.ndarray) -> np.ndarray:
    """Extend the stretches of a mask (N,) by one point at either end, so that their line meets those before and behind."""
    return np.asarray(mask | np.concatenate([[False], mask[:-1]]) | np.concatenate([mask[1:], [False]]))


def smooth_curve(points: np.ndarray, panel: tuple[float, float], begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Smooth curve between two points of a branch (2, N): Akima's cubics over the polygon's length, which do not overshoot.

    panel: its width and height.
    """
    from scipy.interpolate import Akima1DInterpolator

    (x, y), steps = points, np.hypot(*(np.diff(points, axis=1) / np.array(panel)[:, None]))
    at = np.concatenate([[0.0], np.cumsum(steps)])
    apart = np.concatenate([[True], np.diff(at) > 0])  # a step may be lost in the rounding of the sum
    if apart.sum() < _FEWEST or not np.isfinite(at).all():
        return x[begin : end + 1], y[begin : end + 1]
    knots, share = at[begin : end + 1], np.arange(_BETWEEN) / _BETWEEN
    fine = np.append((knots[:-1, None] + share * np.diff(knots)[:, None]).ravel(), knots[-1])
    curve = Akima1DInterpolator(at[apart], points[:, apart], axis=1)(fine)
    return curve[0], np.maximum(curve[1], y[begin : end + 1].min())


def draw_by_stability(axis: Axes, x: np.ndarray, y: np.ndarray, stable: np.ndarray, name: str, **look: Any) -> None:
    """Draw the torque (N,) that resists a drive, dashed where a working point is not stable (N,); both lines have a name."""
    axis.plot(x, np.where(stable, y, np.nan), label=name, **look)
    if not stable.all():
        axis.plot(
            x,
            np.where(extend_both_ways(~stable), y, np.nan),
            label="no stable working point",
            **look | {"linestyle": "--"},
        )


def draw_configurations(axis: Axes, result: Any, values: np.ndarray, width: float = 1.2) -> None:
    """Draw values (configuration, speed) of a result, with one colour per name while colours last.

    The result has ``configuration_name``, ``stable`` and ``overlapping``.
    """
    names, over = list(map(str, result.configuration_name.values)), result.overlapping.values.astype(bool)
    stable = result.stable.values.astype(bool) & ~over[:, None]
    visible_names = [n for k, n in enumerate(names) if not over[k]]
    ordered_names = sorted(
        dict.fromkeys(visible_names), key=lambda n: not any(stable[k].any() for k in range(len(names)) if names[k] == n)
    )
    colours, legend_texts, has_dashes = dict(zip(ordered_names, _COLOURS, strict=False)), set[str](), False
    for k in np.argsort([ordered_names.index(n) if n in ordered_names else len(ordered_names) for n in names], kind="stable"):
        line: dict[str, Any] = {"linewidth": width, "color": colours.get(names[k], GREY)}
        name, thin = names[k] if names[k] in colours else "others", {"linestyle": "--", "linewidth": _THINNER * width}
        parts = [(stable[k], name, line), (extend_both_ways(~stable[k]), name, line | thin)]
        if over[k]:
            parts = [(~stable[k], OVERLAPPING, {"linestyle": ":", "linewidth": _THINNER, "color": GREY})]
        for mask, text, style in parts:
            segment = np.where(mask, values[k], np.nan)
            if np.isfinite(segment).any():
                axis.plot(result.speed.values, segment, label=None if text in legend_texts else text, **style)
                legend_texts.add(text)
                has_dashes |= style.get("linestyle") == "--"
    if has_dashes:
        axis.plot([], [], label="not stable", **_UNSTABLE)
