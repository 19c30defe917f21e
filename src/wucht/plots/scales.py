"""Scales of panels: their names, units and ticks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import rpm_axis
from wucht.results.attributes import text_in
from wucht.results.formatting import label, parameter_in_words, printed_unit, with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PARTS_OF_PI = (8, 4, 2, 1)  # ticks of an angle are multiples of pi over one of these, at most:
_MOST_TICKS = 5
_HUNDREDTH = 0.01
_LEAST, _MOST = 0.05, 5000.0  # values between them are drawn without a prefix


def printed_values(result: Any, name: str) -> tuple[np.ndarray, str]:
    """The values of a variable as they are drawn, and the name of their scale."""
    factor, unit = printed_unit(result, name)
    return np.asarray(factor * result[name].values), label(result, name, unit)


def prefixed_unit(values: np.ndarray, unit: str) -> tuple[float, str]:
    """The factor and the unit in which values of a unit without prefix are drawn: in thousands of it or thousandths.

    Without a unit they are drawn as they are.
    """
    largest = float(np.abs(values).max(initial=0.0))
    if not unit or not 0 < largest < math.inf or _LEAST <= largest < _MOST:
        return 1.0, unit
    return (1e-3, f"k{unit}") if largest >= _MOST else (1e3, f"m{unit}")


def name_speeds(axis: Axes, result: Any, name: str = "speed", of: str = "y") -> None:
    """Name a scale of speeds, and add the second scale in revolutions per minute."""
    getattr(axis, f"set_{of}label")(label(result, name))
    rpm_axis(axis, str(result[name].attrs["units"]), of)


def parameter_label(result: Any, of: str = "along") -> str:
    """Name of a parameter with its unit, from the attributes ``along``, ``along_what``, ``along_unit`` of a result."""
    return with_unit(parameter_in_words(*(text_in(result, key) for key in (of, f"{of}_what"))), text_in(result, f"{of}_unit"))


def travel_unit(values: Any) -> tuple[float, str]:
    """The factor by which a motion in rad or m is drawn, and its unit there."""
    return (math.degrees(1.0), "°") if values.attrs["units"] == "rad" else (1e3, "mm")


def turn_scale(axis: Axes, name: str = "cam angle (°)") -> None:
    """Set the abscissa of a panel to a whole turn, in degrees."""
    axis.set(xlim=(0, 360), xticks=np.arange(0, 361, 60), xlabel=name)


def plain_decades(axis: Axis, alone: bool = False) -> None:
    """Write ticks of a logarithmic axis as 10⁻⁹, in letters: typesetting powers takes as long as the rest of a figure.

    alone: without numbers between the decades.
    """
    axis.set_major_formatter(lambda value, _position: power_text(value))
    if alone:
        axis.set_minor_formatter(lambda _value, _position: "")


def label_one_two_five(axis: Axis) -> None:
    """Write ticks of a logarithmic axis at 1, 2 and 5 of each decade, as plain numbers; as powers of ten below a hundredth."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(lambda value, _position: f"{value:g}" if value >= _HUNDREDTH else power_text(value))
    axis.set_minor_formatter(NullFormatter())


def limits_about(values: np.ndarray) -> tuple[float | None, float | None]:
    """Limits of a scale for values of any shape, with room on both sides, twice as much above; none if none is finite."""
    if not np.isfinite(values).any():
        return None, None
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.08 * (high - low) or 0.1 * abs(high) or 1.0
    return low - room, high + 2 * room


def power_text(value: float) -> str:
    """A number to one digit with a power of ten: ``2·10⁻⁵``."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{'' if digit == '1' else f'{digit}·'}10{str(int(exponent)).translate(SUPERSCRIPTS)}"


def decades_about(values: np.ndarray) -> tuple[float, float]:
    """Limits of a logarithmic scale for values (N,), whole decades so that it has ticks."""
    positive = values[values > 0]
    low, high = (positive.min(), positive.max()) if len(positive) else (0.1, 1.0)
    return float(10 ** np.floor(np.log10(0.8 * low))), float(10 ** np.ceil(np.log10(1.25 * high)))


def multiples_of_pi(low: float, high: float) -> list[tuple[float, str]]:
    """Ticks of an angle with their labels; none if fewer than two of them lie in the range."""
    ticks: list[tuple[float, str]] = []
    for parts in _PARTS_OF_PI:
        step, little = math.pi / parts, 1e-3 * (high - low)
        numbers = range(math.ceil((low - little) / step), math.floor((high + little) / step) + 1)
        ticks = [(n * step, fraction_of_pi(n, parts)) for n in numbers]
        if len(ticks) <= _MOST_TICKS:
            break
    return ticks if 2 <= len(ticks) <= 2 * _MOST_TICKS else []


def fraction_of_pi(n: int, parts: int) -> str:
    """The fraction n pi / parts as text: ``3π/4``."""
    common = math.gcd(n, parts)
    n, parts = n // common, parts // common
    if n == 0:
        return "0"
    head = {1: "π", -1: "−π"}.get(n, f"{n}π".replace("-", "−"))
    return head if parts == 1 else f"{head}/{parts}"
