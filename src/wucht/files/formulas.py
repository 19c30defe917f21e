"""Formulas as they are written in a file, such as ``mu*x - x^3 + sin(theta)``: read symbol by symbol, nothing is executed.

sum     = product (("+" | "-") product)*           product = factor (("*" | "/") factor)*
factor  = ("+" | "-") factor | power               power   = atom (("^" | "**") factor)?
atom    = number | name | function "(" sum ("," sum)* ")" | "(" sum ")"
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sympy as sp

from wucht.errors import InputError, nearest
from wucht.piecewise import larger_value, smaller_value, with_located_kinks
from wucht.schema import LARGEST

_LONGEST, _DEEPEST = 5000, 60  # characters of a formula, brackets in one another
_TOKEN = re.compile(
    r"(?P<number>\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d]\w*)|(?P<sign>\*\*|[-+*/^(),])|(?P<unknown>\S)"
)
_HIGHEST = 1000  # exponent: derivatives of higher powers take very long, and are of no use
_EXACT = 18  # digits of a number that is kept as a fraction, and largest exponent with which a fraction is raised exactly

FUNCTIONS: dict[str, tuple[int, Callable[..., sp.Expr]]] = {
    **{f.__name__: (1, f) for f in (sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan)},
    **{f.__name__: (1, f) for f in (sp.sinh, sp.cosh, sp.tanh, sp.exp, sp.log)},
    "sqrt": (1, sp.sqrt), "abs": (1, sp.Abs), "sign": (1, sp.sign), "atan2": (2, sp.atan2),
    "min": (2, smaller_value), "max": (2, larger_value),
}  # fmt: skip
CONSTANTS: dict[str, sp.Expr] = {"pi": sp.pi}


def formula(
    text: object, symbols: Mapping[str, sp.Symbol], location: str, constant: frozenset[sp.Symbol] = frozenset()
) -> sp.Expr:
    """Read a text (or number) as an expression.

    Parameters
    ----------
    text : str or number
    symbols : mapping of str to sympy.Symbol
        Meaning of names, besides ``FUNCTIONS`` and ``CONSTANTS``.
    location : str
        The key, for errors.
    constant : frozenset of sympy.Symbol
        Those that do not change during a motion: kinks of ``abs`` and ``sign`` in all others are located exactly.

    Raises
    ------
    InputError
        For an invalid formula, with the place; for an unknown name, with the nearest known one; for numbers that are not
        real and finite.
    """
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise InputError(location, text, 'must be a formula, a text such as "mu*x - x^3", or a number')
    source = text if isinstance(text, str) else repr(text)
    if len(source) > _LONGEST:
        raise InputError(location, source, f"must be a formula of at most {_LONGEST} characters; definitions make it shorter")
    if not source.strip():
        raise InputError(location, text, 'must be a formula, a text such as "mu*x - x^3", or a number')
    return with_located_kinks(_Reader(source, symbols, location).read_all(), constant)


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    place: int


class _Reader:
    """Reads one formula from left to right."""

    def __init__(self, source: str, symbols: Mapping[str, sp.Symbol], location: str) -> None:
        self._source, self._symbols, self._location = source, symbols, location
        self._position, self._depth = 0, 0
        self._tokens = [_Token(str(t.lastgroup), t[0], t.start() + 1) for t in _TOKEN.finditer(source)]
        for token in self._tokens:
            if token.kind == "unknown":
                raise self._error(f"{token.text!r} at character {token.place} is not allowed in a formula")
        self._tokens.append(_Token("end", "", len(source) + 1))

    def read_all(self) -> sp.Expr:
        value = self._sum()
        if self._next.kind == "end":
            if any(abs(number) > LARGEST for number in value.atoms(sp.Number)):  # constant factors, multiplied
                raise self._error(f"a number in it is beyond {LARGEST:g}")
            return value
        if self._next.text in (")", ","):
            raise self._error(f"there is no '(' that matches the {self._next.text!r} at character {self._next.place}")
        raise self._error(f"an operator is missing before {self._position_text()}; a product is written with *")

    @property
    def _next(self) -> _Token:
        return self._tokens[self._position]

    def _accept_sign(self, *signs: str) -> str | None:
        """Accept the next sign if it is one of these, and return it; else None."""
        if self._next.kind == "sign" and self._next.text in signs:
            self._position += 1
            return self._tokens[self._position - 1].text
        return None

    def _sum(self) -> sp.Expr:
        value = self._product()
        while sign := self._accept_sign("+", "-"):
            term = self._product()
            value = self._real(value + term if sign == "+" else value - term)
        return value

    def _product(self) -> sp.Expr:
        value = self._factor()
        while sign := self._accept_sign("*", "/"):
            factor = self._factor()
            if sign == "/" and factor == 0:
                raise self._error("it divides by zero")
            value = self._real(value * factor if sign == "*" else value / factor)
        return value

    def _factor(self) -> sp.Expr:
        sign = self._accept_sign("+", "-")
        if sign is None:
            return self._power()
        value = self._read_nested(self._factor)
        return -value if sign == "-" else value

    def _power(self) -> sp.Expr:
        base = self._atom()
        if self._accept_sign("^", "**") is None:
            return base
        exponent = self._read_nested(self._factor)
        if exponent.is_number and not base.is_number and abs(exponent) > _HIGHEST:
            raise self._error(f"an exponent is beyond {_HIGHEST}")
        if not (base.is_number and exponent.is_number):
            return self._real(base**exponent)
        if base.is_Rational and exponent.is_Integer and abs(exponent) <= _EXACT and (base or exponent > 0):
            return self._real(base**exponent)
        try:
            value = float(base) ** float(exponent)
        except (OverflowError, ZeroDivisionError):
            value = math.inf
        return self._real(sp.Float(value) if isinstance(value, float) and math.isfinite(value) else sp.nan)

    def _atom(self) -> sp.Expr:
        token = self._next
        if token.kind == "number":
            self._position += 1
            exact = "e" not in token.text.lower() and len(token.text) <= _EXACT
            return sp.Rational(token.text) if exact else self._real(sp.Float(float(token.text)))
        if token.kind == "name":
            self._position += 1
            return self._read_name(token)
        if self._accept_sign("("):
            value = self._read_nested(self._sum)
            self._expect_closing(token)
            return value
        message = (
            "it ends too early" if token.kind == "end" else f"a number, a name or '(' is missing before {self._position_text()}"
        )
        raise self._error(message)

    def _read_name(self, token: _Token) -> sp.Expr:
        opening = self._next
        if not self._accept_sign("("):
            if token.text in FUNCTIONS and token.text not in self._symbols:
                raise self._error(f"{token.text} is a function: {token.text}(...)")
            if token.text not in self._symbols and token.text not in CONSTANTS:
                raise self._error(f"unknown name {token.text!r}; {nearest(token.text, [*self._symbols, *CONSTANTS])}")
            return self._symbols.get(token.text, CONSTANTS.get(token.text))
        if token.text not in FUNCTIONS:
            if token.text in self._symbols or token.text in CONSTANTS:
                raise self._error(f"{token.text} is not a function; a product is written with *")
            raise self._error(f"unknown function {token.text!r}; {nearest(token.text, FUNCTIONS)}")
        values = [self._read_nested(self._sum)]
        while self._accept_sign(","):
            values.append(self._read_nested(self._sum))
        self._expect_closing(opening)
        count, function = FUNCTIONS[token.text]
        if len(values) != count:
            argument_count = "one argument" if count == 1 else f"{count} arguments"
            raise self._error(f"{token.text} has {argument_count}, not {len(values)}")
        return self._real(function(*values))

    def _read_nested(self, rule: Callable[[], sp.Expr]) -> sp.Expr:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._error(f"more than {_DEEPEST} brackets or signs are nested; definitions make it shorter")
        value = rule()
        self._depth -= 1
        return value

    def _expect_closing(self, opening: _Token) -> None:
        if not self._accept_sign(")"):
            raise self._error(f"the '(' at character {opening.place} is not closed")

    def _real(self, value: sp.Expr) -> sp.Expr:
        """Return the value. Raises ``InputError`` where it is not real, or a number that is not finite."""
        finite = not value.has(sp.nan, sp.zoo, sp.oo, -sp.oo, sp.I)
        if finite and value.is_number:
            try:
                finite = math.isfinite(float(value))
            except (OverflowError, TypeError):
                finite = False
        if not finite:
            raise self._error("a part of it is not a finite real number")
        if value.is_number and abs(float(value)) > LARGEST:
            raise self._error(f"a number in it is beyond {LARGEST:g}")
        return value

    def _position_text(self) -> str:
        return "the end" if self._next.kind == "end" else f"{self._next.text!r} at character {self._next.place}"

    def _error(self, reason: str) -> InputError:
        return InputError(self._location, self._source, f"cannot be read as a formula: {reason}")
