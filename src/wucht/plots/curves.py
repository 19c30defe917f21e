"""Curves with more detail than a print can show: thinned, broken where angles wrap, as a band where they swing fast."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_POINTS = 4000
_NEAR_ZERO = 45.0  # degrees: angles that end this close to 0 are not drawn at the edge of the panel
_STRIPS = 100
_DENSE, _VISIBLE_SHARE = 3, 0.01  # turning points in a strip, and the least visible swing as a share of the panel's height
_BAND: dict[str, Any] = {"alpha": 0.35, "linewidth": 0.6, "zorder": 2}


def thin_curve(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Thin a curve to the points that a print can show: smallest and largest value of each interval, in their order."""
    if len(x) <= _MOST_POINTS:
        return x, y
    size = len(x) // (_MOST_POINTS // 2) + 1
    begins = np.arange(0, len(x) - size + 1, size)
    blocks = y[: len(begins) * size].reshape(len(begins), size)
    if np.isnan(blocks).any():
        return x, y
    low, high = begins + blocks.argmin(axis=1), begins + blocks.argmax(axis=1)
    rest = np.arange(len(begins) * size, len(x))
    keep = np.unique(np.concatenate([[0], low, high, rest, [len(x) - 1]]))
    return x[keep], y[keep]


def without_jumps(phase: np.ndarray, period: float) -> np.ndarray:
    """A wrapped angle with a gap where it wraps, so that no line crosses the panel."""
    curve = phase.copy()
    curve[1:][np.abs(np.diff(phase)) > period / 2] = np.nan
    return curve


def angle_panel(axis: Axes, angles: Iterable[np.ndarray]) -> float:
    """Set the axis of a panel of angles (degrees) to one turn.

    Returns its lower limit: -180 if all angles end near 0, else 0.
    """
    last = [a[np.isfinite(a)][-1] for a in angles if np.isfinite(a).any()]
    near = bool(last) and all(abs((x + 180) % 360 - 180) < _NEAR_ZERO for x in last)
    begin = -180.0 if near else 0.0
    axis.set_ylim(begin, begin + 360)
    axis.set_yticks(begin + np.array([0, 90, 180, 270, 360]))
    return begin


def draw_swings(axis: Axes, x: np.ndarray, y: np.ndarray, **look: Any) -> None:
    """Draw a curve (N,) over x (N,); where it swings too fast to be drawn, a band between its extremes replaces a black block.

    look: of the line, with its ``label``.
    """
    fast, strip = _fast_swings(x, y, axis.get_yscale() == "log")
    name = look.pop("label", None)
    at, line = thin_curve(x, np.where(fast, np.nan, y)) if fast.any() else thin_curve(x, y)
    if not fast.all():
        axis.plot(at, line, label=name, **look)
    if not fast.any():
        return
    low, high = _extremes(strip, y)
    edges, dense = np.linspace(x[0], x[-1], _STRIPS + 1), np.isin(np.arange(_STRIPS), strip[fast])
    middles = (edges[:-1] + edges[1:]) / 2
    for k, run in enumerate(np.split(np.flatnonzero(dense), np.flatnonzero(np.diff(np.flatnonzero(dense)) > 1) + 1)):
        first, last = int(run[0]), int(run[-1])
        # Level with the middles of the strips: steps would look like jumps.
        knots = np.concatenate([[edges[first]], middles[run], [edges[last + 1]]])
        inside = np.r_[first, run, last]
        band = _BAND | {"color": look.get("color"), "label": name if fast.all() and not k else None}
        axis.fill_between(knots, low[inside], high[inside], **band)


def _extremes(strip: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and largest value in each strip."""
    low, high = np.full(_STRIPS, np.inf), np.full(_STRIPS, -np.inf)
    np.minimum.at(low, strip, y)
    np.maximum.at(high, strip, y)
    return low, high


def _fast_swings(x: np.ndarray, y: np.ndarray, logarithmic: bool) -> tuple[np.ndarray, np.ndarray]:
    """Mask (N,) of the points where a curve swings too fast to be drawn, and the strip of the panel (N,) of each point."""
    span = float(x[-1] - x[0]) if len(x) > 1 else 0.0
    if not span > 0 or not np.isfinite(span) or not np.isfinite(y).all() or (np.diff(x) < 0).any():
        return np.zeros(len(x), bool), np.zeros(len(x), int)
    strip = np.minimum(((x - x[0]) / (span / _STRIPS)).astype(int), _STRIPS - 1)
    height = np.log10(np.maximum(y, y[y > 0].min(initial=1.0))) if logarithmic else y
    steps = np.diff(y)
    moving = np.flatnonzero(steps)
    turns = moving[1:][steps[moving[1:]] * steps[moving[:-1]] < 0]
    count = np.bincount(strip[turns], minlength=_STRIPS)
    swung = np.bincount(strip[turns[1:]], np.abs(np.diff(height[turns])), minlength=_STRIPS)
    is_visible = swung > _VISIBLE_SHARE * float(np.ptp(height)) * count
    dense = (count >= _DENSE) & is_visible
    beside = np.r_[False, dense[:-1]] | np.r_[dense[1:], False]
    dense |= (count >= _DENSE - 1) & beside & is_visible  # so that band and line do not alternate
    return dense[strip], strip
