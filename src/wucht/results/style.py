"""How figures look: printable, and readable with any colour vision."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.sheet import legend_beside, rpm_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

# M. Okabe, K. Ito, "Color Universal Design", 2008: distinguishable with every kind of colour vision (less its pale yellow).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
DASHES = ("-", "--", "-.", ":")
MOST_LOOKS = 28  # lines that can be told from each other, in grey too
GREY = "#666666"
# What a drive reaches without vibration: with dashes that no line has.
FREE: dict[str, Any] = {"color": GREY, "linestyle": (0, (10, 3)), "linewidth": 0.9}
SLOW: dict[str, Any] = {"color": "#000000", "linestyle": (0, (3, 4)), "linewidth": 1.0, "zorder": 4}  # averaged equations
# Bars beside each other, the second kind with a hatch: in grey, too, they are two kinds.
HATCHED: tuple[dict[str, Any], ...] = (
    {"edgecolor": GREY, "linewidth": 0.3},
    {"edgecolor": "white", "linewidth": 0.0, "hatch": "////"},
)
_MARKS, _MARK_EVERY = "osv", 0.12  # of lines whose colours come again; of the panel's diagonal
_SYMBOLS = {"time": "$\\tau$", "speed": "$\\omega$"}  # of a dimensionless machine


def plain_decades(axis: Axis) -> None:
    """Ticks of a logarithmic axis as 1e-9: matplotlib's own typesetting of powers takes as long as all the rest of a figure."""
    axis.set_major_formatter(lambda value, _position: f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e"))


def line_style(index: int) -> dict[str, Any]:
    """Colour and dash of the index-th line: neighbours differ in both; marks besides where the colours come again."""
    look = {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)], "linewidth": 1.1}
    again = index // len(COLOURS) % (len(_MARKS) + 1)
    if not again:
        return look
    # Not at the same places: where curves lie upon each other the marks are seen side by side.
    every = (_MARK_EVERY * (index % len(COLOURS)) / len(COLOURS), _MARK_EVERY)
    return look | {"marker": _MARKS[again - 1], "markersize": 3.5, "markerfacecolor": "white", "markevery": every}


def label(result: Any, name: str, factor_unit: str | None = None) -> str:
    """``amplitude (mm)``: axis label from a variable's long name and units."""
    attributes = result[name].attrs
    return with_unit(attributes.get("long_name", name), attributes.get("units", "") if factor_unit is None else factor_unit)


def with_unit(text: str, unit: str) -> str:
    """``text (unit)``, without brackets where there is no unit; powers raised."""
    return f"{text} ({unit.replace('^2', '²').replace('^3', '³')})" if unit else text


def printed_unit(result: Any, name: str) -> tuple[float, str]:
    """The factor by which a variable is drawn, and its unit there: its own ``printed_units``; else lengths in mm."""
    attributes = result[name].attrs
    if "printed_units" in attributes:
        return float(attributes["printed_factor"]), str(attributes["printed_units"])
    return unit_in_print(str(attributes["units"]))


def unit_in_print(unit: str) -> tuple[float, str]:
    """The factor by which numbers of a unit are printed, and their unit there: lengths in mm."""
    return (1e3, "mm") if unit == "m" else (1.0, unit)


def value_in_words(value: Any, factor: float, unit: str) -> str:
    """A number or several, as they are printed, with their unit: ``1.5 mm``; what is none as it is."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(value_in_words(one, factor, '') for one in value)}] {unit}".rstrip()
    if not isinstance(value, int | float) or isinstance(value, bool):
        return str(value)
    return f"{factor * value:.6g} {unit}".rstrip()


def abscissa_label(result: Any, name: str) -> str:
    """``time (s)``, and with its symbol where there is no unit."""
    return label(result, name) if result[name].attrs["units"] else f"{name} {_SYMBOLS[name]}"


def mark_levels(axis: Axes, values: Iterable[float], name: str) -> None:
    """Dotted lines across a panel, the first of which has the name."""
    for k, value in enumerate(values):
        axis.axhline(value, color=GREY, linestyle=":", linewidth=0.9, label=None if k else name)


def mark_speeds(axes: Sequence[Axes], result: Any, natural: tuple[str, str], free: tuple[float, str], named: int) -> None:
    """Finish panels over the speed: mark speeds that lie in the range, set the range, write legends and the abscissa's name.

    natural: what the natural frequencies are called, one of them and several; they are marked for both senses. free: the speed
    that the drive reaches, and what it is called. named: the panel whose legend has these.
    """
    low, high = float(result.speed[0]), float(result.speed[-1])
    frequencies = np.round(result.natural_frequency.values, 9)
    shown = sorted(f for f in {*frequencies, *-frequencies} if low <= f <= high)
    marks: list[tuple[float, Any, str | None]] = [
        (f, ":", natural[len(shown) > 1] if k == 0 else None) for k, f in enumerate(shown)
    ]
    marks += [(free[0], FREE["linestyle"], free[1])] if low <= free[0] <= high else []
    for axis in axes:
        for speed, dashes, name in marks:
            shown_name = name if axis is axes[named] else None
            axis.axvline(speed, color=GREY, linestyle=dashes, linewidth=0.9, label=shown_name, zorder=1)
        axis.set_xlim(low, high)
        legend_beside(axis)
    rpm_axis(axes[0], str(result.speed.attrs["units"]), "x")
    axes[-1].set_xlabel(abscissa_label(result, "speed"))


def named(path: str, what: str) -> str:
    """A parameter in words; where it has no others, by its path. Symbols of dimensionless machines stand before the words."""
    if what in (path, f"parameter {path}"):
        return path
    return what if "." in path else f"{path}: {what}"
