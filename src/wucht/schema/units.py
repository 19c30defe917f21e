"""Units at the edge: ``"2.5 kg"`` in a file becomes a float in SI; inside, everything is SI floats.

Angles are radians, so that a speed of one turn a second is 2 pi rad/s. ``Hz`` given for an angular speed counts turns, and an
angular speed given for a frequency is 2 pi times it: 50 Hz, 3000 rpm and 314.159 rad/s are the same.

Units are read as people write them: ``N m``, ``Nm``, ``N*m``, ``N.m``; ``kg m^2``, ``kgm2``, ``kg m²``; ``rpm``, ``RPM``,
``1/min``, ``U/min``; ``deg``, ``°``, ``grad`` (the German degree; the gradian is ``gon``). Each unit is written once, with its
power: ``m/s^2``, not ``m/s/s``. To Pint a radian is 1 and a degree 0.0175, so that an angle too many would only scale a number:
there is at most one, to the power 1 or -1, and only where the quantity can have one.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from wucht.disk_cache import derived_once
from wucht.errors import FieldError
from wucht.schema.python_values import python_value

if TYPE_CHECKING:
    import pint

# Largest value in SI, beyond all quantities of mechanics; products and quotients of several still are finite numbers.
LARGEST = 1e30
SMALLEST = 1 / LARGEST


@dataclass(frozen=True)
class Unit:
    """The SI unit of a field, the long name of its value, and its symbol in printed equations."""

    si: str
    long_name: str
    symbol: str = ""

    def parse_quantity(self, raw_value: object) -> float:
        """Return a number (already SI) or a string with a unit as an SI float.

        Raises ``ValueError`` with a sentence: not a number, a wrong dimension, an unknown unit, NaN, infinity, or beyond
        ``LARGEST``.
        """
        value = _parse(raw_value, self.si, self.long_name)
        if not math.isfinite(value):
            raise FieldError(f"must be a finite {self.long_name}" + (f" in {self.si}" if self.si else ""), code="not-finite")
        if abs(value) > LARGEST:
            end = f"at most {self.value_text(LARGEST)}" if value > 0 else f"at least {self.value_text(-LARGEST)}"
            raise FieldError(f"must be {article(self.long_name)} of {end}", code="limits")
        return value

    def accepts(self, raw_value: object) -> bool:
        """True if the value is a quantity of this kind, of any size."""
        try:
            _parse(raw_value, self.si, self.long_name)
        except ValueError:
            return False
        return True

    def parse_positive(self, raw_value: object) -> float:
        """Parse as ``parse_quantity`` does.

        A positive value must be at least ``SMALLEST``, since other numbers are divided by it.
        """
        value = self.parse_quantity(raw_value)
        if 0 < value < SMALLEST:
            raise FieldError(
                f"must be {article(self.long_name)} greater than {self.value_text(0)}, and of at least "
                f"{self.value_text(SMALLEST)}",
                code="limits",
            )
        return value

    def value_text(self, value: float) -> str:
        """A number with the unit, in a sentence."""
        return f"{value:g} {self.si}".rstrip()


def article(noun: str) -> str:
    """The noun with its indefinite article, ``an angle``; without one where it is a plural, ``orders that are kept``."""
    head = _AFTER_HEAD.split(noun, maxsplit=1)[0]
    if head.endswith("s") and not head.endswith(("ss", "us", "is", "as")):
        return noun
    return f"{'an' if noun[:1] in 'aeiou' and not noun.startswith('unit') else 'a'} {noun}"


_AFTER_HEAD = re.compile(r",? (?:of|in|at|that|with|where|to|from|by|for|about|between|[^a-z ].*)\b")
_NUMBER = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:inf|nan)(?![a-z]))\s*(.*)", re.IGNORECASE | re.DOTALL
)
_UNIT = re.compile(
    r"[^\W\d_][\w°%·⋅*/^()²³⁻¹ .-]*|[°%](?:/[a-z]+)?"
)  # begins with a letter: no second number, no decimal comma
# Units of loggers, in any case: Pint reads U as an enzyme unit, and does not take 1/min as turns.
_TURNS = r"(?:u|umdr\.?|umdrehung(?:en)?|revs?)"
_TURN = re.compile(_TURNS, re.IGNORECASE)
_TURNS_A_MINUTE = re.compile(rf"rpm|upm|(?:{_TURNS}|r|1)?\s*/\s*min\.?|(?:{_TURNS}\s*)?min\s*\^?\s*(?:-1|⁻¹)", re.IGNORECASE)
_TURNS_A_SECOND = re.compile(rf"(?:{_TURNS}|r)\s*/\s*s(?:ec|ek)?\.?", re.IGNORECASE)
# Below a stroke it is a speed as well, V/(1/min) for V/rpm, but to Pint a number of minutes.
_TURNS_BELOW = re.compile(rf"/\s*\(?\s*(?:(?:{_TURNS}|r|1)\s*/\s*min\b|min\s*\^?\s*\(?\s*-\s*1)", re.IGNORECASE)
# Frequent mistakes in a number with a unit, for which the error names a remedy.
_DECIMAL_COMMA = re.compile(r"\s*[+-]?[\d.]*,\d")
_DIGITS_APART = re.compile(r"\s*[+-]?\d+(?:[ '\u00a0\u2009\u202f]\d{3})+(?!\d)")
_POWER_OF_TEN = re.compile(r"\s*(?:[+-]?[\d.]+\s*[*x·⋅×]?\s*)?10\s*(?:\^|\*\*)")
# Spellings of units of mechanics that Pint does not know.
_PRODUCT = re.compile(r"\s*[*·⋅]\s*|(?<=\w)\.(?=[^\W\d_])")
_POWER = re.compile(r"(?<=[^\W\d_])([234])(?!\w)")
_SUPERSCRIPTS = str.maketrans({"⁻": "^-", "¹": "1", "²": "^2", "³": "^3"})
_TO = r"(?:\^?[234])?"
_TOGETHER = re.compile(rf"\b(?:([kmM]?N)(?=[a-z])([cm]?m{_TO})?(s{_TO})?|([km]?g|t)([cm]?m{_TO}))(?!\w)")
# Pint computes powers of powers, however long that takes.
_POWER_SIGN = re.compile(r"\^|\*\*")
_PLAIN_POWER = re.compile(r"(?:\^|\*\*)\s*\(?\s*[+-]?\d{1,2}(?:\.\d{1,3})?\s*\)?(?!\s*(?:\^|\*\*|[\d.]))")
_FACTOR = re.compile(r"([/()])|([^\W\d_]\w*)(\s*\^\s*(?:\(\s*-[\d.\s]*\)|-))?")
_LONGEST = 60  # characters of a unit
_DEGREE = re.compile(r"\b[Gg]rad\b|°(?!C)")
_OHM = re.compile(r"\b([mkM]?)Ohm\b")


def is_in_rpm(text: str) -> bool:
    """True if a text is a number in revolutions per minute, however it is written."""
    split = _NUMBER.fullmatch(text)
    return split is not None and _TURNS_A_MINUTE.fullmatch(split[2].strip()) is not None


def _parse(raw_value: object, si: str, long_name: str) -> float:
    raw_value = python_value(raw_value)
    examples = f"a number in {si} or a string with a unit such as '1 {si}'" if si else "a number without unit"
    requirement = f"must be {article(long_name)}, {examples}"
    if isinstance(raw_value, bool) or not isinstance(raw_value, int | float | str):
        raise FieldError(requirement, code="no-quantity")
    if not isinstance(raw_value, str):
        try:
            return float(raw_value)
        except OverflowError:
            raise FieldError(f"{requirement}; this one is too large", code="limits") from None
    split = _NUMBER.fullmatch(raw_value)
    unit = split[2].strip() if split else ""
    if len(unit) > _LONGEST:  # patterns below would take a square of its length
        raise FieldError(
            f"{requirement}; {unit[:_LONGEST]!r} is not a known unit: it has more than {_LONGEST} characters",
            code="unknown-unit",
        )
    if split is None or (unit not in ("", si) and not _UNIT.fullmatch(unit) and _logger_factor(unit, si) is None):
        raise FieldError(
            f"{requirement}; this cannot be read as a number and a unit ({_remedy(raw_value, si)})", code="no-quantity"
        )
    return float(split[1]) * (_factor(unit, si, requirement) if unit else 1.0)


def _remedy(raw_text: str, si: str) -> str:
    """Remedy for a text that cannot be read as a number and a unit."""
    if _DECIMAL_COMMA.match(raw_text):
        return "write a decimal point, no comma"
    if _DIGITS_APART.match(raw_text):
        return "write the digits of a number together"
    if _POWER_OF_TEN.match(raw_text):
        return "write powers of ten as 1e3"
    return "write rpm, Hz or rad/s" if si in ("rad/s", "Hz") else "a decimal point, no comma"


def _factor(unit: str, si: str, requirement: str) -> float:
    """Factor of a unit to SI. Raises ``ValueError`` for an unknown unit, or one of another dimension."""
    if si == "Hz":
        return _factor(unit, "rad/s", requirement) / (2 * math.pi)
    if (logger_factor := _logger_factor(unit, si)) is not None:
        return logger_factor
    plain = _spelt_out(unit)
    if plain == si:
        return 1.0
    if (plain, si) in COMMON:
        return COMMON[plain, si]
    for unit_text in (unit, si):
        if len(_POWER_SIGN.findall(unit_text)) != len(_PLAIN_POWER.findall(unit_text)) or len(unit_text) > _LONGEST:
            raise FieldError(
                f"{requirement}; {unit_text[:_LONGEST]!r} is not a known unit: a power in a unit is a number below 100",
                code="unknown-unit",
            )
    if _TURNS_BELOW.search(plain):
        raise FieldError(
            f"{requirement}; {unit!r} does not say whether turns or radians: write rpm or rad/s below the stroke",
            code="unclear-unit",
        )
    return _pint_factor(unit, plain, si, requirement)


@lru_cache(maxsize=256)
@derived_once
def _pint_factor(unit: str, plain: str, si: str, requirement: str) -> float:
    """Factor of a unit to SI by Pint. plain: its SI spelling. Raises ``ValueError`` as ``_factor`` does.

    Loading Pint takes as long as a run: a factor is derived once. Pint's own files are pickle that is not authenticated.
    """
    import pint as pint_

    try:
        pint_unit: Any = _registry().parse_units(plain)
    except Exception:
        # Pint's parser raises whatever Python's tokenizer does on a malformed string; to the user it is one error.
        raise FieldError(f"{requirement}; {unit!r} is not a known unit", code="unknown-unit") from None
    try:
        factor, thrice = (
            float(_registry().Quantity(size, pint_unit).to(si or "dimensionless").magnitude) for size in (1.0, 3.0)
        )
    except pint_.DimensionalityError:
        raise FieldError(f"{requirement}; this one is {article(_dimension(pint_unit))}", code="dimension") from None
    except Exception:
        factor, thrice = 1.0, math.nan
    if not math.isclose(thrice, 3 * factor):
        reason = f"{unit!r} has an offset or a logarithmic scale, which cannot be used here"
        raise FieldError(f"{requirement}; {reason}", code="unknown-unit")
    names = str(pint_unit)
    if si != "rad/s" and "hertz" in names:
        raise FieldError(
            f"{requirement}; Hz counts turns, so that {unit!r} is not clear: write it with s or rad/s", code="unclear-unit"
        )
    _refuse_repeated(unit, plain, requirement)
    _refuse_angles(unit, pint_unit, si, requirement)
    if si == "rad/s":
        turns = "hertz" in names
        if not turns and not any(angle in names for angle in ("radian", "degree", "turn", "revolution", "rpm", "grad", "arc")):
            raise FieldError(
                f"{requirement}; {unit!r} does not say whether turns or radians: write rpm, Hz or rad/s", code="unclear-unit"
            )
        return factor * (2 * math.pi if turns else 1.0)
    return factor


def _refuse_repeated(unit: str, plain: str, requirement: str) -> None:
    """Raise ``FieldError`` for a unit that has a name more than once above the stroke, or below it."""
    for (name, _), count in Counter(_signed_names(plain)).items():
        if count > 1:
            remedy = f"write {name} once, with its power, as in m/s^2"
            raise FieldError(f"{requirement}; {unit!r} has {name} more than once: {remedy}", code="repeated-unit")


def _signed_names(unit: str) -> Iterator[tuple[str, int]]:
    """The names in a unit, each with 1 above the stroke, -1 below it. A stroke is for the next factor, as to Pint."""
    signs, sign = [1], 1  # of the brackets that are open, and of the next factor in the innermost
    for mark, name, negative_power in _FACTOR.findall(unit):
        if mark == "(":
            signs.append(signs[-1] * sign)
        elif mark == ")":
            signs = signs[:-1] or [1]
        elif name:
            yield name, signs[-1] * sign * (-1 if negative_power else 1)
        sign = -1 if mark == "/" else 1


def _refuse_angles(unit: str, pint_unit: Any, si: str, requirement: str) -> None:
    """Raise ``FieldError`` for angles in a unit that has the right dimension to Pint, but no meaning as that quantity.

    Allowed is the power of the angle in the SI unit, or none: N m for N m/rad. Where the SI unit has no angle, one is allowed
    in a number, in 1/s, and where the quantity is made of work, time and current: V s/rad for Wb, N m/rpm for N m s.
    """
    powers = _angle_powers(pint_unit)
    if not powers or powers == (of_si := _angle_powers(_registry().parse_units(si))):
        return
    dimension = pint_unit.dimensionality
    has_place = not dimension or set(dimension) == {"[time]"} or (dimension.get("[mass]"), dimension.get("[length]")) == (1, 2)
    if of_si or not has_place or powers not in ([1], [-1]):
        raise FieldError(f"{requirement}; the angles in {unit!r} are not those of this quantity", code="angle")


def _angle_powers(pint_unit: Any) -> list[float]:
    """The powers of the angles in a unit."""
    items: Any = _registry().Quantity(1.0, pint_unit).unit_items()
    return [power * of_angle for name, power in items if (of_angle := _power_of_angle(name))]


@lru_cache
def _power_of_angle(name: str) -> float:
    """The power of the angle in a unit of one name; Hz counts turns."""
    base: Any = _registry().Quantity(1.0, name).to_base_units()
    return 1.0 if "hertz" in name else float(dict(base.unit_items()).get("radian", 0.0))


def _logger_factor(unit: str, si: str) -> float | None:
    """Factor to SI of a unit of turns that Pint does not know or misreads; None for other units."""
    if si == "rad" and _TURN.fullmatch(unit):
        return 2 * math.pi
    if si in ("rad/s", "Hz") and _TURNS_A_MINUTE.fullmatch(unit):
        return 2 * math.pi / 60
    if si in ("rad/s", "Hz") and _TURNS_A_SECOND.fullmatch(unit):
        return 2 * math.pi
    return None


def _spelt_out(unit: str) -> str:
    """The unit in SI spelling: factors apart, powers with ``^``, the names of Pint.

    ``Nms`` is N m s, not newton milliseconds; to Pint ``Nm`` is the fineness of a yarn, ``Grad`` 1e9 rad, ``grad`` a gradian.
    """
    unit = _DEGREE.sub("deg", _OHM.sub(r"\1ohm", unit)).translate(_SUPERSCRIPTS).replace("-^", "-").replace("**", "^")
    apart = _TOGETHER.sub(lambda m: " ".join(filter(None, m.groups())), _PRODUCT.sub(" ", unit))
    return _POWER.sub(r"^\1", apart)


# Loading Pint takes as long as a run: a file with only these units does without.
COMMON = {
    ("g", "kg"): 1e-3, ("mm", "m"): 1e-3, ("deg", "rad"): math.pi / 180, ("rpm", "rad/s"): 2 * math.pi / 60,
    ("Hz", "rad/s"): 2 * math.pi,
}  # fmt: skip
_DIMENSIONS = {
    "kg": "mass", "m": "length", "s": "time", "1/s": "rate or angular speed", "": "number or angle", "N/m": "stiffness",
    "N s/m": "damping", "kg m^2": "moment of inertia", "kg m": "unbalance", "N": "force", "N m": "torque",
    "N m s": "rotational damping", "W": "power", "A": "current", "V": "voltage", "ohm": "resistance", "H": "inductance",
    "Wb": "magnetic flux",
}  # fmt: skip


def _dimension(unit: Any) -> str:
    for example, name in _DIMENSIONS.items():
        if _registry().parse_units(example).dimensionality == unit.dimensionality:
            return name
    return f"quantity of dimension {unit.dimensionality}"


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    import pint as pint_

    return pint_.UnitRegistry(cache_folder=None)
