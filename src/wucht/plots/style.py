"""Appearance of figures: printable, and readable with any colour vision."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import legend_above, legend_beside, rpm_axis
from wucht.results.formatting import abscissa_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# M. Okabe, K. Ito, "Color Universal Design", 2008: distinguishable with every kind of colour vision (less its pale yellow).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
DASHES = ("-", "--", "-.", ":")
MOST_LOOKS = 28  # lines that can be distinguished, in grey too
GREY = "#666666"
GUIDE: dict[str, Any] = {"color": GREY, "linestyle": ":", "linewidth": 0.9}  # lines at reference values
# The speed of a drive without vibration: with dashes that no other line has.
FREE: dict[str, Any] = {"color": GREY, "linestyle": (0, (10, 3)), "linewidth": 0.9}
SLOW: dict[str, Any] = {"color": "#000000", "linestyle": (0, (3, 4)), "linewidth": 1.0, "zorder": 4}  # averaged equations
# Bars beside each other, the second kind with a hatch: in grey, too, they are two kinds.
BAR_STYLES: tuple[dict[str, Any], ...] = (
    {"edgecolor": GREY, "linewidth": 0.3},
    {"edgecolor": "white", "linewidth": 0.0, "hatch": "////"},
)
_BRIGHTEST = 0.9  # of the scale of colours
_MOST_NAMED = 14  # of many lines in shades
_MARKS, _MARK_EVERY = "osv", 0.12  # of lines whose colours are repeated; of the panel's diagonal


def line_style(index: int) -> dict[str, Any]:
    """Colour and dash of the index-th line: neighbours differ in both; with markers where the colours are repeated."""
    look = {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)], "linewidth": 1.1}
    again = index // len(COLOURS) % (len(_MARKS) + 1)
    if not again:
        return look
    # Not at the same places, so that markers of coinciding curves are side by side.
    every = (_MARK_EVERY * (index % len(COLOURS)) / len(COLOURS), _MARK_EVERY)
    return look | {"marker": _MARKS[again - 1], "markersize": 3.5, "markerfacecolor": "white", "markevery": every}


def shades(count: int, scale: str = "viridis") -> list[str]:
    """Colours of many ordered lines, of a scale of matplotlib: from dark to the lightest visible on white."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [str(to_hex(colormaps[scale](_BRIGHTEST * k / max(count - 1, 1)))) for k in range(count)]


def mark_levels(axis: Axes, values: Iterable[float], name: str) -> None:
    """Draw dotted lines across a panel, of which the first has the name."""
    for k, value in enumerate(values):
        axis.axhline(value, **GUIDE, label=None if k else name)


def mark_natural_frequencies(axis: Axes, values: Sequence[float]) -> None:
    """Draw natural frequencies across a panel of speeds."""
    mark_levels(axis, values, "natural frequencies" if len(values) > 1 else "natural frequency")


def looks_of_many(labels: Sequence[str], linewidths: tuple[float, float]) -> list[dict[str, Any]]:
    """The styles of many lines with their names: in shades where they are more than can be told apart, of which few are named.

    linewidths: of lines that can be told apart, and in shades.
    """
    few, tones = len(labels) <= MOST_LOOKS, shades(len(labels))
    return [
        (line_style(k) | {"linewidth": linewidths[0]} if few else {"color": tones[k], "linewidth": linewidths[1]})
        | ({"label": text} if few or k < _MOST_NAMED else {})
        for k, text in enumerate(labels)
    ]


def mark_speeds(
    axes: Sequence[Axes], result: Any, natural: tuple[str, str], free: tuple[float, str], legend_panel: int
) -> None:
    """Finish panels over the speed: mark speeds that lie in the range, set the range, write legends and the abscissa's name.

    A line that has the same look and name in several panels is in the legend of the first of them. The legend of a single panel
    is above it, in columns, so that the panel has the width of the page.

    natural: name of a natural frequency, singular and plural; they are marked for both senses of rotation. free: the speed that
    the drive reaches, and its name. legend_panel: the panel whose legend has these.
    """
    low, high = float(result.speed[0]), float(result.speed[-1])
    frequencies = np.round(result.natural_frequency.values, 9)
    visible_frequencies = sorted(f for f in {*frequencies, *-frequencies} if low <= f <= high)
    marks: list[tuple[float, Any, str | None]] = [
        (f, ":", natural[len(visible_frequencies) > 1] if k == 0 else None) for k, f in enumerate(visible_frequencies)
    ]
    marks += [(free[0], FREE["linestyle"], free[1])] if low <= free[0] <= high else []
    earlier_looks, place_legend = set[tuple[str, ...]](), legend_beside if len(axes) > 1 else legend_above
    for axis in axes:
        for speed, dashes, name in marks:
            shown_name = name if axis is axes[legend_panel] else None
            axis.axvline(speed, color=GREY, linestyle=dashes, linewidth=0.9, label=shown_name, zorder=1)
        axis.set_xlim(low, high)
        looks = {_legend_key(handle): handle for handle in axis.get_legend_handles_labels()[0]}
        place_legend(axis, [handle for look, handle in looks.items() if look not in earlier_looks])
        earlier_looks |= set(looks)
    rpm_axis(axes[0], str(result.speed.attrs["units"]), "x")
    axes[-1].set_xlabel(abscissa_label(result, "speed"))


def _legend_key(handle: Any) -> tuple[str, ...]:
    """The name and look of a line in a legend."""
    return tuple(map(str, (handle.get_label(), handle.get_color(), handle.get_linestyle(), handle.get_marker())))
