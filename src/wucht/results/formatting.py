"""Numbers and names in engineering units, in reports, legends and at axes."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    pass

_ATOM = 1e-11  # m: a length that is less is none
_FEW = 10  # rpm: lower speeds with decimals
_VALUE = re.compile(r"= (-?[\d.]+(?:e[+-]\d+)?) rad/s(?! \(|\^|/| per)")
_DIGITS = re.compile(r"\.(\d+)g")
_LONG, _LARGE = 1e4, 1e7  # numbers from the first on have separators of thousands, from the second on an exponent
_SPEED = re.compile(r"(-?[\d.]+(?:e[+-]\d+)?) rad/s \((-?[\d.]+(?:e[+-]\d+)?) rpm\)")
_SYMBOLS = {"time": "$\\tau$", "speed": "$\\omega$"}  # of a dimensionless machine


def number_text(value: Any, unit: str, form: str = "", dimensionless: bool = False) -> str | None:
    """Format a number with its unit, several with their names; None for None. form: ``.4g``, or ``%`` for a share."""
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return ", ".join(f"{name}: {number_text(v, unit, form, dimensionless)}" for name, v in value.items()) or "none"
    if form.endswith("%"):
        return f"{100 * value:{form[:-1] or '.3g'}} %"
    unit = "" if dimensionless and unit != "rad" else unit
    base, per, order = unit.partition("/rad") if unit not in _FORMATTERS else (unit, "", "")
    if form or (dimensionless and base not in _FORMATTERS):
        digits = _DIGITS.fullmatch(form or ".5g")
        return f"{decimal_text(value, int(digits[1])) if digits else format(value, form)} {unit}".rstrip()
    if base in _FORMATTERS:
        return f"{_FORMATTERS[base](value)}{per}{_POWERS.get(order, order)}"
    name, size = engineering_unit(value, unit) if value else (unit, 1.0)
    return f"{decimal_text(value / size)} {name}".rstrip()


def decimal_text(value: float, digits: int = 4) -> str:
    """A number to significant digits, without an exponent where people write none: ``37,480`` for 37479.6."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:,.12g}" if _LONG <= abs(rounded) < _LARGE else f"{value:.{digits}g}"


def rpm_first(text: str) -> str:
    """A text whose speeds begin with revolutions per minute: ``1205 rpm (126.14 rad/s)`` for 126.14 rad/s (1205 rpm).

    So do values of parameters that the text states in rad/s alone, ``= 126.14 rad/s``.
    """
    rpm_text = _SPEED.sub(r"\2 rpm (\1 rad/s)", text)
    return _VALUE.sub(lambda value: f"= {float(value[1]) * 30 / math.pi:.5g} rpm ({value[1]} rad/s)", rpm_text)


def percent(share: float, off: float = 0.0) -> str:
    """A share with its uncertainty: ``24.88 % ± 0.40 %``, with as many decimals as the uncertainty justifies."""
    if not off > 0:
        return f"{100 * share:.4g} %"
    decimals = min(max(1 - math.floor(math.log10(100 * off)), 0), 6)
    return f"{100 * share:.{decimals}f} % ± {100 * off:.{decimals}f} %"


def round_numbers(text: str, digits: int = 4) -> str:
    """A text whose decimal numbers are rounded to significant digits: ``7.3071 s`` becomes ``7.307 s``.

    Numbers with fewer digits, and those without a decimal point, remain as they are.
    """

    def rounded(number: re.Match[str]) -> str:
        mantissa, exponent = number[1], number[2] or ""
        if len(mantissa.replace(".", "").lstrip("0")) <= digits:
            return number[0]
        value = float(f"{float(mantissa):.{digits}g}")
        decimals = digits - 1 - math.floor(math.log10(value))
        return f"{value:.{max(decimals, 0)}f}{exponent}"

    return re.sub(r"(?<![\w.])(\d+\.\d+)(e[+-]?\d+)?(?![\w.]*\d)", rounded, text)


def band_in_words(band: Sequence[float | None], unit: str, prefix: str = "", digits: int = 6) -> str:
    """Return a band (low, high) in words, None for an end beyond the range. prefix: written before its first value."""
    low, high = (None if edge is None else f"{edge:.{digits}g}" for edge in band)
    end = f" {unit}" if unit else ""
    if low is None:
        return "in the whole range" if high is None else f"below {prefix}{high}{end}"
    return f"above {prefix}{low}{end}" if high is None else f"between {prefix}{low} and {high}{end}"


def bodies_in_words(count: int) -> str:
    """The number of bodies in words: ``4 bodies``."""
    return "1 body" if count == 1 else f"{count} bodies"


def _angle(value: float) -> str:
    return f"{math.degrees(value):.4g}°"


def _speed(value: float) -> str:
    turns = value * 30 / math.pi
    return f"{value:.5g} rad/s ({f'{turns:.3g}' if abs(turns) < _FEW else f'{turns:.0f}'} rpm)"


def _length(value: float) -> str:
    if abs(value) < _ATOM:
        return "0 µm"
    return f"{value * 1e3:.4g} mm" if abs(value) >= 1e-5 else f"{value * 1e6:.3g} µm"


def label(result: Any, name: str, factor_unit: str | None = None) -> str:
    """Axis label from a variable's long name and units: ``amplitude (mm)``."""
    attributes = result[name].attrs
    return with_unit(attributes.get("long_name", name), attributes.get("units", "") if factor_unit is None else factor_unit)


def with_unit(text: str, unit: str) -> str:
    """Text with its unit as it is printed: ``text (N·m)``; without brackets if there is no unit. A formula is set as one."""
    return f"{text} ({units_in_print(unit)})" if unit else formula_in_print(text)


def formula_in_print(text: str) -> str:
    """A name with its symbol before a colon, and the ratio of products at its end, set as mathematics.

    ``beta_p: damping of the pendulums, b_r/(k J_P)``; a Greek letter also where it is the whole name.
    """
    with_symbol = _SYMBOL.sub(lambda symbol: f"${_BACKSLASH if symbol[1] else ''}{symbol[0]}$", text)
    return _FORMULA.sub(lambda formula: f"${formula[0].replace('*', '^*').replace(' ', f'{_BACKSLASH},')}$", with_symbol)


def units_in_print(text: str) -> str:
    """The units in a text as they are printed: N·m·s, kg·m², µm; in files and data they are N m s, kg m^2, um.

    Both are read alike. A product of units is known by its first one, N, kg or g, which no word of a sentence is.
    """
    for pattern, printed_form in _PRINTED_UNITS:
        text = pattern.sub(printed_form, text)
    return text


_BACKSLASH = "\\"
_GREEK = "alpha|beta|delta|epsilon|lambda|mu|omega|phi|psi|sigma|tau"
_SYMBOL = re.compile(rf"^(?:({_GREEK})(?:_[A-Za-z0-9])?(?=: |$)|[A-Za-z](?:_[A-Za-z0-9])?(?=: ))")
# After a comma up to the end: symbols of one letter, each with an index, a power or an asterisk, and one stroke.
_FORMULA = re.compile(r"(?<=, )(?=[^/]+/[^/]+$)(?:[ /()]|[2-9]|[A-Za-z](?:_[A-Za-z])?(?:\*|\^\d)?(?![a-z]))+$")
_POWERS = {"^2": "²", "^3": "³"}
_PRINTED_UNITS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"\b(?:[kmM]?N|kg|g)(?: (?:mm|cm|m|s)\b(?:\^[23])?)+"), lambda unit: unit[0].replace(" ", "·")),
    (re.compile(r"(?:^|(?<=\()|(?<=\d ))um\b"), lambda unit: "µm"),
    (re.compile(r"\b(mm|cm|m|s|rad|kg)(\^[23])\b"), lambda power: power[1] + _POWERS[power[2]]),
)


def printed_unit(result: Any, name: str) -> tuple[float, str]:
    """Factor and unit in which a variable is drawn: from its ``printed_units``; by default lengths in mm."""
    attributes = result[name].attrs
    if "printed_units" in attributes:
        return float(attributes["printed_factor"]), str(attributes["printed_units"])
    return unit_in_print(str(attributes["units"]))


def unit_in_print(unit: str) -> tuple[float, str]:
    """Factor and unit in which numbers of a unit are printed: lengths in mm."""
    return (1e3, "mm") if unit == "m" else (1.0, unit)


def value_in_words(value: Any, factor: float, unit: str) -> str:
    """One or several numbers as they are printed, with their unit: ``1.5 mm``; other values unchanged."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(value_in_words(one, factor, '') for one in value)}] {unit}".rstrip()
    if not isinstance(value, int | float) or isinstance(value, bool):
        return str(value)
    return f"{factor * value:.6g} {unit}".rstrip()


def abscissa_label(result: Any, name: str, of: str = "") -> str:
    """Label of an abscissa: ``time (s)``; without a unit the word ``of`` (by default the variable's name) with its symbol."""
    word = of or name
    return label(result, name) if result[name].attrs["units"] else f"{word} {_SYMBOLS[word]}"


def parameter_in_words(path: str, long_name: str) -> str:
    """A parameter in words, or its path if there are none. Symbols of dimensionless machines precede the words."""
    if long_name in (path, f"parameter {path}"):
        return path
    return long_name if "." in path else f"{path}: {long_name}"


def wrap_text(text: str, letters: int) -> list[str]:
    """Break a text into lines of this many letters, if possible; a unit in brackets is not broken."""
    whole = re.sub(r"\([^()]{1,12}\)$", lambda unit: unit[0].replace(" ", "\N{NO-BREAK SPACE}"), text)
    return [
        part
        for line in whole.split("\n")
        for part in textwrap.wrap(line, letters, break_long_words=False, break_on_hyphens=False) or [line]
    ]


_FORMATTERS: Mapping[str, Callable[[float], str]] = {"rad/s": _speed, "m": _length, "rad": _angle}

# Units in which engineers write numbers of an SI unit, each with the least number that is written so, and its size. Smaller
# numbers have the last one.
_ENGINEERING: Mapping[str, tuple[tuple[str, float, float], ...]] = {
    "kg": (("kg", 0.1, 1.0), ("g", 0.0, 1e-3)),
    "m": (("m", 10.0, 1.0), ("mm", 1e-5, 1e-3), ("um", 0.0, 1e-6)),
    "N/m": (("N/mm", 1e3, 1e3), ("N/m", 0.0, 1.0)),
    "kg m": (("kg m", 0.1, 1.0), ("kg mm", 1e-3, 1e-3), ("g mm", 0.0, 1e-6)),
    "kg m^2": (("kg m^2", 0.01, 1.0), ("kg cm^2", 0.0, 1e-4)),
    "N": (("kN", 1e3, 1e3), ("N", 0.0, 1.0)),
    "N m": (("kN m", 1e3, 1e3), ("N m", 0.0, 1.0)),
    "W": (("kW", 1e3, 1e3), ("W", 0.0, 1.0)),
    "J": (("kJ", 1e3, 1e3), ("J", 0.0, 1.0)),
    "H": (("H", 0.1, 1.0), ("mH", 0.0, 1e-3)),
    "Pa": (("MPa", 1e6, 1e6), ("kPa", 1e3, 1e3), ("Pa", 0.0, 1.0)),
    "ohm": (("Ω", 0.0, 1.0),),
}

_TURNING: Mapping[str, tuple[str, float]] = {"rad/s": ("rpm", math.pi / 30), "rad": ("°", math.pi / 180)}


def engineering_text(value: float, unit: str) -> str:
    """A number of an SI unit as a data sheet has it: ``10 N/mm``, ``29 mm``, ``1151.9 rad/s (11000 rpm)``."""
    if unit in ("rad/s", "rad"):
        return _FORMATTERS[unit](value)
    name, size = engineering_unit(value, unit)
    return units_in_print(f"{value / size:.5g} {name}".rstrip())


def engineering_unit(value: float, unit: str) -> tuple[str, float]:
    """The unit in which engineers write a number of an SI unit, as it is written in files, and its size: ``("mm", 1e-3)``.

    Angles are in degrees, speeds in rpm.
    """
    if unit in _TURNING:
        return _TURNING[unit]
    choices = _ENGINEERING.get(unit, ((unit, 0.0, 1.0),))
    name, _, size = choices[0] if value == 0 else next(one for one in choices if abs(value) >= one[1])
    return name, size
