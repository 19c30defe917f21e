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
from wucht.piecewise import ABSOLUTE, PiecewiseCubic, step
from wucht.schema import LARGEST

_LONGEST, _DEEPEST = 5000, 60  # characters of a formula, brackets in one another
_TOKEN = re.compile(
    r"(?P<number>\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d]\w*)|(?P<sign>\*\*|[-+*/^(),])|(?P<unknown>\S)"
)
_HIGHEST = 1000  # exponent: derivatives of higher powers take very long, and are of no use
_EXACT = 18  # digits of a number that is kept as a fraction, and largest exponent with which a fraction is raised exactly
_SIGN = step("sign", 0.0, -1.0, 1.0)

FUNCTIONS: dict[str, tuple[int, Callable[..., sp.Expr]]] = {
    **{f.__name__: (1, f) for f in (sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan)},
    **{f.__name__: (1, f) for f in (sp.sinh, sp.cosh, sp.tanh, sp.exp, sp.log)},
    "sqrt": (1, sp.sqrt), "abs": (1, sp.Abs), "sign": (1, sp.sign), "atan2": (2, sp.atan2),
    "min": (2, lambda a, b: (a + b - sp.Abs(a - b)) / 2), "max": (2, lambda a, b: (a + b + sp.Abs(a - b)) / 2),
}  # fmt: skip
CONSTANTS: dict[str, sp.Expr] = {"pi": sp.pi}


def formula(text: object, known: Mapping[str, sp.Symbol], where: str, constant: frozenset[sp.Symbol] = frozenset()) -> sp.Expr:
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
        raise InputError(where, text, 'must be a formula, a text such as "mu*x - x^3", or a number')
    written = text if isinstance(text, str) else repr(text)
    if len(written) > _LONGEST:
        raise InputError(where, written, f"must be a formula of at most {_LONGEST} characters; definitions make it shorter")
    if not written.strip():
        raise InputError(where, text, 'must be a formula, a text such as "mu*x - x^3", or a number')
    expression = _Reader(written, known, where).whole()

    def moves(e: sp.Expr) -> bool:
        return bool(e.free_symbols - constant)

    # SymPy also writes sqrt(x^2) as |x|.
    expression = expression.replace(lambda e: isinstance(e, sp.Abs) and moves(e), lambda e: PiecewiseCubic(e.args[0], ABSOLUTE))
    return expression.replace(lambda e: isinstance(e, sp.sign) and moves(e), lambda e: PiecewiseCubic(e.args[0], _SIGN))


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    place: int


class _Reader:
    """Reads one formula from left to right."""

    def __init__(self, written: str, known: Mapping[str, sp.Symbol], where: str) -> None:
        self._written, self._known, self._where = written, known, where
        self._at, self._depth = 0, 0
        self._tokens = [_Token(str(t.lastgroup), t[0], t.start() + 1) for t in _TOKEN.finditer(written)]
        for token in self._tokens:
            if token.kind == "unknown":
                raise self._wrong(f"{token.text!r} at character {token.place} is not allowed in a formula")
        self._tokens.append(_Token("end", "", len(written) + 1))

    def whole(self) -> sp.Expr:
        value = self._sum()
        if self._next.kind == "end":
            if any(abs(number) > LARGEST for number in value.atoms(sp.Number)):  # constant factors, multiplied
                raise self._wrong(f"a number in it is beyond {LARGEST:g}")
            return value
        if self._next.text in (")", ","):
            raise self._wrong(f"there is no '(' that matches the {self._next.text!r} at character {self._next.place}")
        raise self._wrong(f"an operator is missing before {self._shown()}; a product is written with *")

    @property
    def _next(self) -> _Token:
        return self._tokens[self._at]

    def _taken(self, *signs: str) -> str | None:
        """Accept the next sign if it is one of these, and return it; else None."""
        if self._next.kind == "sign" and self._next.text in signs:
            self._at += 1
            return self._tokens[self._at - 1].text
        return None

    def _sum(self) -> sp.Expr:
        value = self._product()
        while sign := self._taken("+", "-"):
            other = self._product()
            value = self._real(value + other if sign == "+" else value - other)
        return value

    def _product(self) -> sp.Expr:
        value = self._factor()
        while sign := self._taken("*", "/"):
            other = self._factor()
            if sign == "/" and other == 0:
                raise self._wrong("a division by zero")
            value = self._real(value * other if sign == "*" else value / other)
        return value

    def _factor(self) -> sp.Expr:
        sign = self._taken("+", "-")
        if sign is None:
            return self._power()
        value = self._nested(self._factor)
        return -value if sign == "-" else value

    def _power(self) -> sp.Expr:
        base = self._atom()
        if self._taken("^", "**") is None:
            return base
        exponent = self._nested(self._factor)
        if exponent.is_number and not base.is_number and abs(exponent) > _HIGHEST:
            raise self._wrong(f"an exponent is beyond {_HIGHEST}")
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
            self._at += 1
            exact = "e" not in token.text.lower() and len(token.text) <= _EXACT
            return sp.Rational(token.text) if exact else self._real(sp.Float(float(token.text)))
        if token.kind == "name":
            self._at += 1
            return self._named(token)
        if self._taken("("):
            value = self._nested(self._sum)
            self._closed(token)
            return value
        what = "it ends too early" if token.kind == "end" else f"a number, a name or '(' is missing before {self._shown()}"
        raise self._wrong(what)

    def _named(self, token: _Token) -> sp.Expr:
        opened = self._next
        if not self._taken("("):
            if token.text in FUNCTIONS and token.text not in self._known:
                raise self._wrong(f"{token.text} is a function: {token.text}(...)")
            if token.text not in self._known and token.text not in CONSTANTS:
                raise self._wrong(f"unknown name {token.text!r}; {nearest(token.text, [*self._known, *CONSTANTS])}")
            return self._known.get(token.text, CONSTANTS.get(token.text))
        if token.text not in FUNCTIONS:
            if token.text in self._known or token.text in CONSTANTS:
                raise self._wrong(f"{token.text} is not a function; a product is written with *")
            raise self._wrong(f"unknown function {token.text!r}; {nearest(token.text, FUNCTIONS)}")
        values = [self._nested(self._sum)]
        while self._taken(","):
            values.append(self._nested(self._sum))
        self._closed(opened)
        count, function = FUNCTIONS[token.text]
        if len(values) != count:
            needed = "one argument" if count == 1 else f"{count} arguments"
            raise self._wrong(f"{token.text} has {needed}, not {len(values)}")
        return self._real(function(*values))

    def _nested(self, read: Callable[[], sp.Expr]) -> sp.Expr:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._wrong(f"more than {_DEEPEST} brackets or signs are nested; definitions make it shorter")
        value = read()
        self._depth -= 1
        return value

    def _closed(self, opened: _Token) -> None:
        if not self._taken(")"):
            raise self._wrong(f"the '(' at character {opened.place} is not closed")

    def _real(self, value: sp.Expr) -> sp.Expr:
        """Return the value. Raises ``InputError`` where it is not real, or a number that is not finite."""
        finite = not value.has(sp.nan, sp.zoo, sp.oo, -sp.oo, sp.I)
        if finite and value.is_number:
            try:
                finite = math.isfinite(float(value))
            except (OverflowError, TypeError):
                finite = False
        if not finite:
            raise self._wrong("a part of it is not a finite real number")
        if value.is_number and abs(float(value)) > LARGEST:
            raise self._wrong(f"a number in it is beyond {LARGEST:g}")
        return value

    def _shown(self) -> str:
        return "the end" if self._next.kind == "end" else f"{self._next.text!r} at character {self._next.place}"

    def _wrong(self, why: str) -> InputError:
        return InputError(self._where, self._written, f"cannot be read as a formula: {why}")
