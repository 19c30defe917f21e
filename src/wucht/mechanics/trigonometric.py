"""Sums and products of sines and cosines of a variable, written as sum a cos(w t + p) + b sin(w t + p).

w, p, a, b are free of t; the product formulas alone are used. Frequencies may be numbers or hold parameters, in any ratio.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache, reduce

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.zero_testing import SAME, is_cancelled_sum, is_identically_zero


class NotTrigonometricError(WuchtError):
    """The expression is not a polynomial in sines and cosines of multiples of the variable."""


@contextmanager
def error_context(action: str) -> Iterator[None]:
    """Prefix errors with the action that failed."""
    try:
        yield
    except WuchtError as error:
        raise type(error)(f"{action}: {error}", code=error.code) from error


Key = tuple[sp.Expr, sp.Expr]
Terms = dict[Key, tuple[sp.Expr, sp.Expr]]
"""(frequency w, phase p) -> (a, b) of ``a cos(w t + p) + b sin(w t + p)``; frequency 0 has phase 0 and no sine."""
CONSTANT: Key = (sp.S.Zero, sp.S.Zero)
NOTHING = (sp.S.Zero, sp.S.Zero)
TURNING = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc, sp.exp)
_AMPLITUDES = {sp.cos: (sp.S.One, sp.S.Zero), sp.sin: (sp.S.Zero, sp.S.One), sp.exp: (sp.S.One, sp.I)}
_SHORT = 200
"""Operations up to which a coefficient is expanded to check if that makes it shorter."""


@dataclass(frozen=True)
class TrigonometricPolynomial:
    """A trigonometric polynomial in a variable; its frequencies may be numbers or hold parameters, in any ratio.

    Attributes
    ----------
    variable : sympy.Symbol
    terms : dict
        (frequency w, phase p) -> (a, b) of ``a cos(w t + p) + b sin(w t + p)``; the frequency 0 has phase 0 and no sine.
    """

    variable: sp.Symbol
    terms: Terms

    @property
    def mean(self) -> sp.Expr:
        """The mean over all of the variable's range."""
        return tidy(self.terms.get(CONSTANT, NOTHING)[0])

    @property
    def turning(self) -> Terms:
        """The terms without the mean."""
        return {key: pair for key, pair in self.terms.items() if key != CONSTANT}

    @property
    def frequencies(self) -> tuple[sp.Expr, ...]:
        """The frequencies other than zero, each once."""
        return tuple(dict.fromkeys(w for w, _ in self.turning))

    @property
    def oscillation(self) -> sp.Expr:
        """The expression minus its mean."""
        return self._expression(self.turning)

    @property
    def antiderivative(self) -> sp.Expr:
        """The antiderivative of ``oscillation`` whose mean is zero: 002 (3.6). It divides by the frequencies."""
        return self._expression({(w, p): (-b / w, a / w) for (w, p), (a, b) in self.turning.items()})

    def _expression(self, terms: Terms) -> sp.Expr:
        angles = {key: key[0] * self.variable + key[1] for key in terms}
        return sp.Add(*(tidy(a) * sp.cos(angles[k]) + tidy(b) * sp.sin(angles[k]) for k, (a, b) in terms.items()))


def tidy(expression: sp.Expr) -> sp.Expr:
    """The expression, expanded where that makes it shorter; a long one stays as it is."""
    if expression.is_Atom or expression.count_ops() > _SHORT:
        return expression
    expanded_form = sp.expand(expression)
    return expanded_form if expanded_form.count_ops() <= expression.count_ops() else expression


def trigonometric_polynomial(expression: sp.Expr, variable: sp.Symbol) -> TrigonometricPolynomial:
    """Write an expression as a trigonometric polynomial in a variable.

    Parameters
    ----------
    expression : sympy.Expr
    variable : sympy.Symbol

    Returns
    -------
    TrigonometricPolynomial
        With ``mean``, ``oscillation`` and ``antiderivative``.

    Raises
    ------
    WuchtError
        Where the variable occurs outside of sines and cosines (secular terms).
    NotTrigonometricError
        Where the expression is not a polynomial in them.
    """
    terms = nonzero(harmonic_terms(sp.sympify(expression), variable))
    return TrigonometricPolynomial(
        variable, {key: terms[key] for key in sorted(terms, key=lambda k: tuple(map(sp.default_sort_key, k)))}
    )


def nonzero(terms: Terms) -> Terms:
    """The terms whose coefficients are not both zero."""
    return {key: pair for key, pair in terms.items() if not all(map(is_identically_zero, pair))}


@lru_cache(maxsize=4096)
def harmonic_terms(e: sp.Expr, t: sp.Symbol) -> Terms:
    """The harmonics of an expression, unsorted. Raises as ``trigonometric_polynomial``."""
    if t not in e.free_symbols:
        return {CONSTANT: (e, sp.S.Zero)}
    if e.is_Add:
        return _sum([harmonic_terms(a, t) for a in e.args])
    if e.is_Mul:
        factor, moving = e.as_independent(t, as_Add=False)
        factors = [{CONSTANT: (factor, sp.S.Zero)}, *(harmonic_terms(a, t) for a in sp.Mul.make_args(moving))]
        return reduce(_product, factors)
    if e.is_Pow and e.exp.is_Integer:
        if e.exp > 0:
            return reduce(_product, [harmonic_terms(e.base, t)] * int(e.exp))
        base = nonzero(harmonic_terms(e.base, t))
        if set(base) != {CONSTANT}:
            raise NotTrigonometricError(f"{e} has {t} in its denominator", code="denominator")
        return {CONSTANT: (base[CONSTANT][0] ** e.exp, sp.S.Zero)}
    if isinstance(e, sp.sin | sp.cos | sp.exp):
        key = frequency_and_phase(-sp.I * e.args[0] if isinstance(e, sp.exp) else e.args[0], t)
        if key is None:
            raise NotTrigonometricError(f"the argument of {e} is not linear in {t}", code="uneven-argument")
        if isinstance(e, sp.exp) and {w.is_real for w in key} != {True}:
            raise NotTrigonometricError(f"{e} is neither a sine nor a cosine of {t}", code="not-trigonometric")
        return _wave(*key, *_AMPLITUDES[e.func])
    if e == t or (e.is_Pow and e.base == t):
        raise secular_error(t)
    raise NotTrigonometricError(f"{e} is not a polynomial in sines and cosines of {t}", code="no-polynomial")


def frequency_and_phase(argument: sp.Expr, t: sp.Symbol) -> Key | None:
    """frequency and phase of an argument ``frequency t + phase``, both free of t, or None for other arguments."""
    argument = sp.expand(argument)
    frequency = sp.diff(argument, t)
    if t in frequency.free_symbols:
        return None
    if frequency.has(sp.Float):
        frequency = sp.nsimplify(frequency, rational=True)  # 3 * 0.1 - 0.3 is zero
    frequency = sp.expand(frequency)
    phase = sp.expand(argument.xreplace({t: sp.S.Zero}))
    return (sp.S.Zero if is_identically_zero(frequency, SAME) else frequency), phase


def waves(e: sp.Expr, t: sp.Symbol) -> dict[sp.Expr, sp.Expr]:
    """The functions in an expression that turn evenly with t, or grow or decay like exp(t), and the frequency of each."""
    keys = {a: frequency_and_phase(a.args[0], t) for a in e.atoms(*TURNING) if t in a.free_symbols}
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


def secular_error(t: sp.Symbol) -> WuchtError:
    """The error of a term that grows with t."""
    return WuchtError(
        f"{t} occurs outside of sines and cosines: such a secular term has no mean over {t}, or none that is uniform",
        code="secular",
    )


def _wave(frequency: sp.Expr, phase: sp.Expr, cosine: sp.Expr, sine: sp.Expr) -> Terms:
    """One harmonic, with the sign of its frequency made unique."""
    if frequency == 0:
        return {CONSTANT: (cosine * sp.cos(phase) + sine * sp.sin(phase), sp.S.Zero)}
    if frequency.could_extract_minus_sign():
        frequency, phase, sine = -frequency, -phase, -sine
    return {(frequency, sp.expand(phase)): (cosine, sine)}


def _sum(parts: Sequence[Terms]) -> Terms:
    pairs_by_key: dict[Key, list[tuple[sp.Expr, sp.Expr]]] = {}
    for part in parts:
        for key, pair in part.items():
            pairs_by_key.setdefault(key, []).append(pair)
    return {key: (sp.Add(*(a for a, _ in pairs)), sp.Add(*(b for _, b in pairs))) for key, pairs in pairs_by_key.items()}


def _product(first: Terms, second: Terms) -> Terms:
    parts = []
    for ((w, p), (a, b)), ((v, q), (c, d)) in itertools.product(first.items(), second.items()):
        if (w, p) == CONSTANT:  # the sine of a constant term is zero: its cosine alone multiplies
            parts.append({(v, q): (a * c, a * d)})
        elif (v, q) == CONSTANT:
            parts.append({(w, p): (a * c, b * c)})
        else:
            for sign, cosine, sine in ((1, a * c - b * d, b * c + a * d), (-1, a * c + b * d, b * c - a * d)):
                frequency = sp.expand(w + sign * v)
                frequency = sp.S.Zero if is_cancelled_sum(w, sign * v, frequency) else frequency
                parts.append(_wave(frequency, p + sign * q, cosine / 2, sine / 2))
    return _sum(parts)
