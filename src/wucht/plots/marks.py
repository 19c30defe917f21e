"""Points that are marked on curves, regions in tones and hatches, and what legends say of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.style import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Symbol = tuple[str, str, str]  # marker, face, name
_SIZE = 5
_FRAME = 0.5  # width of the frame of a region's field in a legend


def entry(name: str, **look: Any) -> Any:
    """A line or a mark in a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=name, **look)


def field(name: str, tone: str, hatch: str = "", edge: str = GREY, **look: Any) -> Any:
    """A region in a legend."""
    from matplotlib.patches import Patch

    return Patch(facecolor=tone, hatch=hatch, edgecolor=edge, label=name, **{"linewidth": _FRAME} | look)


def draw_classes(
    axis: Axes, x: np.ndarray, y: np.ndarray, classes: Iterable[tuple[np.ndarray, str, str, str | None]], **look: Any
) -> None:
    """Points (N,) in classes: which (N,) belong to each, its marker, its face and its name. One without points has no name."""
    for chosen, marker, face, name in classes:
        if chosen.any():
            axis.plot(x[chosen], y[chosen], marker, markerfacecolor=face, label=name, **look)


def draw_kinds(axis: Axes, x: np.ndarray, y: np.ndarray, kinds: np.ndarray, symbols: Mapping[str, Symbol]) -> None:
    """Special points (N,), each with the symbol of its kind; one without kind is none."""
    for kind in _present(kinds):
        marker, face, _ = _symbol(kind, symbols)
        at = kinds.astype(str) == kind
        axis.plot(x[at], y[at], marker, color="black", markerfacecolor=face, markersize=_SIZE, markeredgewidth=1.0, zorder=5)


def entries_of_kinds(kinds: np.ndarray, symbols: Mapping[str, Symbol]) -> list[Any]:
    """What a legend says of special points."""
    known = [_symbol(kind, symbols) for kind in _present(kinds)]
    look: dict[str, Any] = {"color": "black", "linestyle": "", "markersize": _SIZE}
    return [entry(name, marker=marker, markerfacecolor=face, **look) for marker, face, name in known]


def _present(kinds: np.ndarray) -> list[str]:
    return [kind for kind in dict.fromkeys(kinds.astype(str).tolist()) if kind]


def _symbol(kind: str, symbols: Mapping[str, Symbol]) -> Symbol:
    """That of a kind; of one that has none, that of the kind without a name."""
    marker, face, name = symbols.get(kind, symbols[""])
    return marker, face, name or kind.replace("-", " ")


def draw_region(axis: Axes, x: np.ndarray, y: np.ndarray, inside: np.ndarray, hatch: str, edge: str, **look: Any) -> None:
    """A region of the plane with a hatch: x (M,), y (N,), where it is (N, M). look: ``colors``, if it has a tone, too."""
    drawn = axis.contourf(x, y, inside.astype(float), levels=[0.5, 1.5], hatches=[hatch], **{"colors": ["none"]} | look)
    drawn.set(edgecolor=edge, linewidth=0.0)
