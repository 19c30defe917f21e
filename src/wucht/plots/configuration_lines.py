"""Curves of steady phase configurations over the speed: solid where stable, dashed where not, each with its name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.style import COLOURS, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OVERLAPPING = "bodies overlapping"  # those of a track, as nothing keeps them apart here
_UNSTABLE: dict[str, Any] = {"color": GREY, "linestyle": "--", "linewidth": 0.84}
_COLOURS = (COLOURS[0], COLOURS[3], COLOURS[5], COLOURS[4])
_THINNER = 0.7


def draw_configurations(axis: Axes, result: Any, values: np.ndarray, width: float = 1.2) -> None:
    """Draw values (configuration, speed) of a result, a colour for each name as long as there are any.

    The result has ``configuration_name``, ``stable`` and ``overlapping``.
    """
    names, over = list(map(str, result.configuration_name.values)), result.overlapping.values.astype(bool)
    stable = result.stable.values.astype(bool) & ~over[:, None]
    shown = [n for k, n in enumerate(names) if not over[k]]
    ranked = sorted(dict.fromkeys(shown), key=lambda n: not any(stable[k].any() for k in range(len(names)) if names[k] == n))
    colours, named, dashed = dict(zip(ranked, _COLOURS, strict=False)), set[str](), False
    for k in np.argsort([ranked.index(n) if n in ranked else len(ranked) for n in names], kind="stable"):
        line: dict[str, Any] = {"linewidth": width, "color": colours.get(names[k], GREY)}
        name = names[k] if names[k] in colours else "others"
        if over[k]:
            dotted = line | {"linestyle": ":", "linewidth": _THINNER, "color": GREY}
            parts = [(np.ones_like(stable[k]), OVERLAPPING, dotted)]
        else:
            parts = [
                (stable[k], name, line),
                (_meeting(~stable[k]), name, line | {"linestyle": "--", "linewidth": _THINNER * width}),
            ]
        for where, text, style in parts:
            drawn = np.where(where, values[k], np.nan)
            if np.isfinite(drawn).any():
                axis.plot(result.speed.values, drawn, label=None if text in named else text, **style)
                named.add(text)
                dashed |= style.get("linestyle") == "--"
    if dashed:
        axis.plot([], [], label="not stable", **_UNSTABLE)


def _meeting(dashed: np.ndarray) -> np.ndarray:
    """The same with the neighbours below (N,), so that the two kinds of line meet."""
    meeting = dashed.copy()
    meeting[1:] |= dashed[:-1]
    return meeting
