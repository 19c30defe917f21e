"""Units at the edge: ``"2.5 kg"`` in a file becomes a float in SI; inside, everything is SI floats.

Angles are radians, so that a speed of one turn a second is 2 pi rad/s. ``Hz`` given for an angular speed counts turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pint


@dataclass(frozen=True)
class Unit:
    """The SI unit of a field, what its value is called, and the symbol it has in printed equations."""

    si: str
    what: str
    symbol: str = ""

    def parse(self, given: object) -> float:
        """A number (already SI) or a string with a unit, as an SI float.

        Raises ``ValueError`` with a sentence: not a number, a wrong dimension, an unknown unit, NaN or infinity.
        """
        value = _parse(given, self.si, self.what)
        if not math.isfinite(value):
            raise ValueError(f"allowed is a finite {self.what}{self._in_unit}")
        return value

    @property
    def _in_unit(self) -> str:
        return f" in {self.si}" if self.si else ""


def article(noun: str) -> str:
    """The noun with its indefinite article: ``an angle``."""
    return f"{'an' if noun[:1] in 'aeiou' and not noun.startswith('unit') else 'a'} {noun}"


def _parse(given: object, si: str, what: str) -> float:
    allowed = f"allowed is {article(what)}, a number" + (
        f" in {si} or a string with a unit such as '1 {si}'" if si else " without unit"
    )
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise ValueError(allowed)
    if isinstance(given, int | float):
        try:
            return float(given)
        except OverflowError:
            raise ValueError(f"{allowed}; this one is too large") from None
    try:
        return float(given)
    except ValueError:
        pass  # not a bare number: it should carry a unit
    import pint as pint_

    try:
        quantity: Any = _registry().Quantity(given)
        turns = 2 * math.pi if si == "rad/s" and "hertz" in str(quantity.units) else 1.0
        return float(quantity.to(si or "dimensionless").magnitude) * turns
    except pint_.DimensionalityError:
        raise ValueError(f"{allowed}; this one is {article(_dimension(given))}") from None
    except Exception:
        # Pint's parser raises whatever Python's tokenizer does on a malformed string; to the user they are one thing.
        raise ValueError(f"{allowed}; this cannot be read as a quantity") from None


def _dimension(given: str) -> str:
    dimensionality = str(_registry().Quantity(given).dimensionality)
    names = {
        "[mass]": "mass", "[length]": "length", "[time]": "time", "1 / [time]": "rate or angular speed",
        "dimensionless": "number or angle", "[mass] / [time] ** 2": "stiffness", "[mass] / [time]": "damping",
        "[length] ** 2 * [mass]": "moment of inertia", "[length] * [mass]": "unbalance",
    }  # fmt: skip
    return names.get(dimensionality, f"quantity of dimension {dimensionality}")


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    import pint as pint_

    return pint_.UnitRegistry(cache_folder=":auto:")


def pretty(value: float, unit: str, digits: int = 4) -> str:
    """``0.00974 m`` for people: a number with its unit and at most ``digits`` significant digits."""
    return f"{value:.{digits}g} {unit}".rstrip()
