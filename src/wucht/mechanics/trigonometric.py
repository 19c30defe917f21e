"""Sums and products of sines and cosines of a variable, written as sum a cos(w t + p) + b sin(w t + p).

w, p, a, b are free of t; the product formulas alone are used. Frequencies may be numbers or hold parameters, in any ratio.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.zero_testing import SAME, cancels, identically_zero


class NotTrigonometricError(WuchtError):
    """The expression is no polynomial in sines and cosines of multiples of the variable."""


@dataclass(frozen=True)
class Harmonic:
    """``cosine * cos(frequency t + phase) + sine * sin(frequency t + phase)``; frequency 0 has phase 0 and no sine."""

    frequency: sp.Expr
    phase: sp.Expr
    cosine: sp.Expr
    sine: sp.Expr


Key = tuple[sp.Expr, sp.Expr]
Terms = dict[Key, tuple[sp.Expr, sp.Expr]]
CONSTANT: Key = (sp.S.Zero, sp.S.Zero)
TURNING = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc, sp.exp)
_SHORT = 200
"""Operations up to which a coefficient is expanded to see whether that makes it shorter."""


@dataclass(frozen=True)
class Harmonics:
    """A trigonometric polynomial in ``variable``. Its frequencies may be numbers or hold parameters, in any ratio."""

    variable: sp.Symbol
    terms: tuple[Harmonic, ...]

    @property
    def mean(self) -> sp.Expr:
        """The mean over all of the variable's range."""
        return tidy(sp.Add(*(h.cosine for h in self.terms if h.frequency == 0)))

    @property
    def frequencies(self) -> tuple[sp.Expr, ...]:
        """The frequencies other than zero, each once."""
        return tuple(dict.fromkeys(h.frequency for h in self.terms if h.frequency != 0))

    @property
    def oscillation(self) -> sp.Expr:
        """What is left without the mean."""
        return self._expression([h for h in self.terms if h.frequency != 0])

    @property
    def antiderivative(self) -> sp.Expr:
        """The antiderivative of ``oscillation`` whose mean is zero: 002 (3.6). It divides by the frequencies."""
        return self._expression(
            [
                Harmonic(h.frequency, h.phase, -h.sine / h.frequency, h.cosine / h.frequency)
                for h in self.terms
                if h.frequency != 0
            ]
        )

    def _expression(self, terms: Sequence[Harmonic]) -> sp.Expr:
        angle = [h.frequency * self.variable + h.phase for h in terms]
        return sp.Add(*(tidy(h.cosine) * sp.cos(a) + tidy(h.sine) * sp.sin(a) for h, a in zip(terms, angle, strict=True)))


def tidy(expression: sp.Expr) -> sp.Expr:
    """The expression, expanded where that makes it shorter; a long one stays as it is."""
    if expression.is_Atom or expression.count_ops() > _SHORT:
        return expression
    expanded = sp.expand(expression)
    return expanded if expanded.count_ops() <= expression.count_ops() else expression


def harmonics(expression: sp.Expr, variable: sp.Symbol) -> Harmonics:
    """The expression as a trigonometric polynomial in the variable.

    Raises ``WuchtError`` where the variable stands outside of sines and cosines (secular terms), and
    ``NotTrigonometricError`` where it is no polynomial in them.
    """
    terms = Expansion(variable)(sp.sympify(expression))
    nonzero = [Harmonic(*key, *pair) for key, pair in terms.items() if not all(map(identically_zero, pair))]
    return Harmonics(
        variable, tuple(sorted(nonzero, key=lambda h: (sp.default_sort_key(h.frequency), sp.default_sort_key(h.phase))))
    )


@dataclass
class Expansion:
    """Writes expressions as trigonometric polynomials, each subexpression once."""

    variable: sp.Symbol

    def __post_init__(self) -> None:
        self.memo: dict[sp.Expr, Terms] = {}

    def __call__(self, e: sp.Expr) -> Terms:
        """The harmonics of an expression. Raises as ``harmonics``."""
        if self.variable not in e.free_symbols:
            return {CONSTANT: (e, sp.S.Zero)}
        if e not in self.memo:
            self.memo[e] = self._expand(e)
        return self.memo[e]

    def _expand(self, e: sp.Expr) -> Terms:
        t = self.variable
        if e.is_Add:
            return _sum([self(a) for a in e.args])
        if e.is_Mul:
            factor, moving = e.as_independent(t, as_Add=False)
            product: Terms = {CONSTANT: (factor, sp.S.Zero)}
            for a in sp.Mul.make_args(moving):
                product = _product(product, self(a))
            return product
        if e.is_Pow and e.exp.is_Integer:
            return self._power(e)
        if isinstance(e, sp.sin | sp.cos):
            frequency, phase = self._linear(e, e.args[0])
            return _sum([_single(frequency, phase, sp.S.One, e.func)])
        if isinstance(e, sp.exp):
            frequency, phase = self._linear(e, sp.expand(-sp.I * e.args[0]))
            if {frequency.is_real, phase.is_real} != {True}:
                raise NotTrigonometricError(f"{e} is neither a sine nor a cosine of {t}")
            return _sum([_single(frequency, phase, sp.S.One, sp.cos), _single(frequency, phase, sp.I, sp.sin)])
        if e == t or (e.is_Pow and e.base == t):
            raise secular(t)
        raise NotTrigonometricError(f"{e} is no polynomial in sines and cosines of {t}")

    def _power(self, e: sp.Pow) -> Terms:
        base, count = self(e.base), int(e.exp)
        if count < 0:
            left = {k: c for k, c in base.items() if not all(map(identically_zero, c))}
            if set(left) != {CONSTANT}:
                raise NotTrigonometricError(f"{e} has {self.variable} in its denominator")
            return {CONSTANT: (left[CONSTANT][0] ** count, sp.S.Zero)}
        power = base
        for _ in range(count - 1):
            power = _product(power, base)
        return power

    def _linear(self, e: sp.Expr, argument: sp.Expr) -> Key:
        key = evenly(argument, self.variable)
        if key is None:
            raise NotTrigonometricError(f"the argument of {e} does not grow evenly with {self.variable}")
        return key


def evenly(argument: sp.Expr, t: sp.Symbol) -> Key | None:
    """frequency and phase of an argument ``frequency t + phase``, both free of t, or None where it is none."""
    argument = sp.expand(argument)
    frequency = sp.diff(argument, t)
    if t in frequency.free_symbols:
        return None
    if frequency.has(sp.Float):
        frequency = sp.nsimplify(frequency, rational=True)  # 3 * 0.1 - 0.3 is zero
    frequency = sp.expand(frequency)
    phase = sp.expand(argument.xreplace({t: sp.S.Zero}))
    return (sp.S.Zero if identically_zero(frequency, SAME) else frequency), phase


def waves(e: sp.Expr, t: sp.Symbol) -> dict[sp.Expr, sp.Expr]:
    """The functions in an expression that turn evenly with t, or grow or decay like exp(t), and the frequency of each."""
    keys = {a: evenly(a.args[0], t) for a in e.atoms(*TURNING) if t in a.free_symbols}
    return {a: key[0] for a, key in sorted(keys.items(), key=lambda pair: sp.default_sort_key(pair[0])) if key is not None}


def common_period(frequencies: Iterable[sp.Expr]) -> sp.Expr | None:
    """The least period that all frequencies have in common, or None where their ratios are not rational, or there is none."""
    nonzero = [sp.sympify(w) for w in frequencies if w != 0]
    if not nonzero:
        return None
    ratios = [sp.simplify(w / nonzero[0]) for w in nonzero]
    if not all(r.is_Rational for r in ratios):
        return None
    largest = sp.Rational(sp.igcd(0, *(r.p for r in ratios)), sp.ilcm(1, *(r.q for r in ratios)))
    base = nonzero[0] * largest
    return 2 * sp.pi / (-base if base.could_extract_minus_sign() else base)


def is_whole(ratio: sp.Expr) -> bool:
    """Whether a ratio is a whole number, to the accuracy of decimal numbers."""
    value = sp.simplify(ratio)
    if not value.has(sp.Float):
        return bool(value.is_Integer)
    return bool(value.is_real and cancels(value, -sp.Integer(round(value)), value - round(value)))


def secular(t: sp.Symbol) -> WuchtError:
    """The error of a term that grows with t."""
    return WuchtError(
        f"{t} stands outside of sines and cosines: such a secular term has no mean over {t}, or none that is uniform"
    )


def _single(frequency: sp.Expr, phase: sp.Expr, factor: sp.Expr, function: type[sp.Function]) -> Terms:
    """factor * function(frequency t + phase), with the sign of the frequency made unique."""
    if frequency == 0:
        return {CONSTANT: (factor * function(phase), sp.S.Zero)}
    odd = function is sp.sin
    if frequency.could_extract_minus_sign():
        frequency, phase, factor = -frequency, -phase, -factor if odd else factor
    return {(frequency, sp.expand(phase)): (sp.S.Zero, factor) if odd else (factor, sp.S.Zero)}


def _sum(parts: Sequence[Terms]) -> Terms:
    collected: dict[Key, tuple[list[sp.Expr], list[sp.Expr]]] = {}
    for part in parts:
        for key, (a, b) in part.items():
            cosines, sines = collected.setdefault(key, ([], []))
            cosines.append(a)
            sines.append(b)
    return {key: (sp.Add(*a), sp.Add(*b)) for key, (a, b) in collected.items()}


def _product(left: Terms, right: Terms) -> Terms:
    parts = []
    for (w, p), (a, b) in left.items():
        for (v, q), (c, d) in right.items():
            if CONSTANT in ((w, p), (v, q)):
                # The sine of a constant term is zero: its cosine alone multiplies.
                factor, key, pair = (a, (v, q), (c, d)) if (w, p) == CONSTANT else (c, (w, p), (a, b))
                parts.append({key: (factor * pair[0], factor * pair[1])})
                continue
            for sign, cosine, sine in ((1, a * c - b * d, b * c + a * d), (-1, a * c + b * d, b * c - a * d)):
                frequency, phase = sp.expand(w + sign * v), p + sign * q
                if cancels(w, sign * v, frequency):
                    frequency = sp.S.Zero
                parts.append(_single(frequency, phase, cosine / 2, sp.cos))
                parts.append(_single(frequency, phase, sine / 2, sp.sin))
    return _sum(parts)
