"""What motions of equations tend to, projected on two states: points, orbits, and the thin lines of chaotic sets and tori."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.style import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TRANSIENT: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 0.6, "alpha": 0.8, "zorder": 2}
_POINT: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 4.5, "zorder": 5}
_ORBIT: dict[str, Any] = {"linewidth": 1.5, "zorder": 4}
_LINE: dict[str, Any] = {"linewidth": 0.35, "alpha": 0.55, "zorder": 3}
_DOTS: dict[str, Any] = {"linestyle": "", "marker": ".", "markersize": 1, "markeredgewidth": 0, "zorder": 3}
_MOST_OSCILLATIONS = 150  # that are drawn: more fill the panel
_FEWEST, _SMOOTH = 8, 80  # samples in an oscillation: of a curve that can be interpolated, and of one without corners


def draw_limit_set(
    axis: Axes, states: np.ndarray, turning: np.ndarray, kind: str, begin: tuple[float, float] = (-np.pi, -np.pi), **look: Any
) -> None:
    """Draw what a motion tends to.

    Parameters
    ----------
    axis : Axes
    states : ndarray, (2, N)
        Evenly spaced in time, NaN at the end where there are fewer; angles are not wrapped.
    turning : ndarray of bool, (2,)
        True for angles.
    kind : str
        ``"equilibrium"``, ``"periodic"``, ``"quasi-periodic"`` or ``"chaotic"``.
    begin : pair of float
        Where the turn begins in which each angle is drawn.
    **look
        Of the lines and points.
    """
    states = states[:, np.isfinite(states).all(axis=0)]
    look = {"color": COLOURS[1]} | look
    if kind == "equilibrium":
        axis.plot(*_wrap_angles(states, turning, begin), **_POINT | look)
    elif kind == "periodic":
        axis.plot(*wrapped_curve(states, turning, begin), **_ORBIT | look)
    elif (course := _fine_course(states)) is not None:
        axis.plot(*wrapped_curve(course, turning, begin), **_LINE | look)
    else:
        axis.plot(*_wrap_angles(states, turning, begin), **_DOTS | look)


def wrapped_curve(states: np.ndarray, turning: np.ndarray, begin: tuple[float, float] = (-np.pi, -np.pi)) -> np.ndarray:
    """Return a curve (2, N) with angles in one turn, interrupted where one is wrapped."""
    curve = _wrap_angles(states, turning, begin)
    with np.errstate(invalid="ignore"):
        jumps = ((np.abs(np.diff(curve, axis=1)) > np.pi) & (turning[:, None] > 0)).any(axis=0)
    return np.asarray(np.insert(curve, np.flatnonzero(jumps) + 1, np.nan, axis=1))


def _wrap_angles(states: np.ndarray, turning: np.ndarray, begin: tuple[float, float]) -> np.ndarray:
    low = np.array(begin)[:, None]
    return np.where(turning[:, None] > 0, low + np.remainder(states - low, 2 * np.pi), states)


def _fine_course(states: np.ndarray) -> np.ndarray | None:
    """Return a stretch of a motion (2, N) with enough samples for a smooth line; None where it has too few to interpolate."""
    from scipy.interpolate import CubicSpline

    count = states.shape[1]
    above = states > states.mean(axis=1, keepdims=True)
    oscillations = max(int((~above[:, :-1] & above[:, 1:]).sum(axis=1).max(initial=0)), 1)
    density = count / oscillations
    if density < _FEWEST:
        return None
    stretch = states[:, : min(count, int(density * _MOST_OSCILLATIONS) + 1)]
    factor = int(np.ceil(_SMOOTH / density))
    at = np.linspace(0, stretch.shape[1] - 1, factor * (stretch.shape[1] - 1) + 1)
    return stretch if factor == 1 else np.asarray(CubicSpline(np.arange(stretch.shape[1]), stretch, axis=1)(at))
