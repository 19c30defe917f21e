"""One printed equation against its derivation: what is printed, its residual, and the form whose residual is zero.

Zero is exact. A residual is brought to a normal form, a ratio of polynomials in the symbols and in the sines and cosines of
single angles, in which sin^2 is 1 - cos^2: it is zero there or nowhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

import sympy as sp

Relation = tuple[sp.Symbol, sp.Expr]
"""A symbol and a polynomial in it that is zero: (R, R^2 - 2) for the root of 2."""


@dataclass(frozen=True)
class Claim:
    """What is printed, its residual against the derivation, and what is right where the print is not.

    printed, corrected: an expression or a matrix of several. residual: of such an expression, zero if it is right. relations:
    between the symbols, used to find out whether a residual is zero. put: definitions put into the residual.
    """

    printed: sp.Basic
    residual: Callable[[sp.Basic], sp.Basic]
    corrected: sp.Basic | None = None
    relations: tuple[Relation, ...] = ()
    put: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)

    def left_over(self, expression: sp.Basic) -> sp.Basic:
        """The residual of an expression in normal form."""
        actual = self.residual(expression)
        if isinstance(actual, sp.MatrixBase):
            return sp.ImmutableMatrix(actual).applyfunc(lambda e: reduced(e.subs(self.put), self.relations))
        return reduced(sp.sympify(actual).subs(self.put), self.relations)


def equal(
    printed: sp.Basic,
    derived: sp.Basic,
    corrected: sp.Basic | None = None,
    relations: tuple[Relation, ...] = (),
    put: Mapping[sp.Symbol, sp.Expr] | None = None,
) -> Claim:
    """A printed right-hand side against the derived one: the residual is the derived less the printed."""
    return Claim(printed, lambda e: derived - e, corrected, relations, put or {})


@dataclass(frozen=True)
class Check:
    """An equation of a source, its left-hand side in LaTeX, what is done in a sentence, and the claim, made when asked for."""

    source: str
    equation: str
    left: str
    says: str
    claim: Callable[[], Claim]

    @property
    def misprinted(self) -> bool:
        """Whether another form than the printed one is right."""
        return self.claim().corrected is not None

    @property
    def of_print(self) -> sp.Basic:
        """The residual of what is printed."""
        return _left_over(self.claim, False)

    @property
    def of_correction(self) -> sp.Basic:
        """The residual of the corrected form."""
        return _left_over(self.claim, True)

    def __str__(self) -> str:
        return f"{self.source} {self.equation}"


def check(source: str, equation: str, left: str, says: str) -> Callable[[Callable[[], Claim]], Check]:
    """Make a Check of a function that returns a Claim."""
    return lambda claim: Check(source, equation, left, says, cache(claim))


@cache
def _left_over(claim: Callable[[], Claim], corrected: bool) -> sp.Basic:
    actual = claim()
    return actual.left_over(actual.corrected if corrected else actual.printed)


def is_zero(residual: sp.Basic) -> bool:
    """Whether a residual, or each of several, is zero."""
    return all(e == 0 for e in residual) if isinstance(residual, sp.MatrixBase) else residual == 0


def reduced(expression: sp.Expr, relations: tuple[Relation, ...] = ()) -> sp.Expr:
    """The normal form. Raises ``ZeroDivisionError`` where a denominator is zero."""
    expanded, back = single_angles(expression)
    waves = sorted(expanded.atoms(sp.sin, sp.cos), key=str)
    put = {w: sp.Dummy(f"{w.func}{i}") for i, w in enumerate(waves)}
    rules = list(relations)
    for angle in sorted({w.args[0] for w in waves}, key=str):
        s, c = (put.setdefault(f(angle), sp.Dummy(str(f))) for f in (sp.sin, sp.cos))
        rules.append((s, s**2 + c**2 - 1))
    top, bottom = (_remainder(sp.expand(e), rules) for e in sp.fraction(sp.together(expanded.xreplace(put))))
    if bottom == 0:
        raise ZeroDivisionError(f"the denominator of {expression} is zero")
    if top == 0:
        return sp.S.Zero
    return sp.factor(sp.cancel(top / bottom)).xreplace({d: w for w, d in put.items()}).xreplace(back)


def single_angles(expression: sp.Expr) -> tuple[sp.Expr, dict[sp.Symbol, sp.Expr]]:
    """Sines and cosines of sums and multiples written in those of single symbols, and what turns symbols back.

    Where halves of an angle occur, its symbol comes to mean the half.
    """
    halves = set[sp.Symbol]()
    for wave in expression.atoms(sp.sin, sp.cos):
        halves |= {x for x in wave.args[0].free_symbols if sp.expand(wave.args[0]).coeff(x).q == 2}
    doubled = expression.xreplace({x: 2 * x for x in halves})
    actual = doubled.replace(lambda e: isinstance(e, (sp.sin, sp.cos)), lambda e: sp.expand_trig(e.func(sp.expand(e.args[0]))))
    return actual, {x: x / 2 for x in halves}


def turned(expression: sp.Expr, angles: Mapping[sp.Symbol, tuple[sp.Expr, sp.Expr]]) -> sp.Expr:
    """The expression with the sine and the cosine of angles put in."""
    put = {f(a): value for a, pair in angles.items() for f, value in zip((sp.sin, sp.cos), pair, strict=True)}
    return single_angles(expression)[0].xreplace(put)


def _remainder(polynomial: sp.Expr, rules: list[Relation]) -> sp.Expr:
    for symbol, zero in rules:
        if symbol in polynomial.free_symbols:
            polynomial = sp.expand(sp.rem(polynomial, zero, symbol))
    return polynomial
