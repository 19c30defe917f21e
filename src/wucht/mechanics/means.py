"""Exact means over a variable, and antiderivatives of mean zero, of sums and products of sines and cosines.

An expression is written as sum a cos(w t + p) + b sin(w t + p), w, p, a, b free of t, by the product formulas alone; its mean
is that of 002 (3.5) and (3.9), lim 1/T int_0^T, which exists for any frequencies w, commensurate or not. Rational functions of
sines and cosines with one period have a mean by the residue theorem where their poles are numbers. All else is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError


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


def mean(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """lim (1/T) int_0^T of the expression, exact.

    Raises ``WuchtError`` with the reason where there is none, or none was found.
    """
    try:
        return harmonics(expression, variable).mean
    except NotTrigonometricError:
        return _mean_by_residues(sp.sympify(expression), variable)


def antiderivative(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """The antiderivative, of mean zero, of what the expression is without its mean. Raises ``WuchtError`` as ``harmonics``."""
    return harmonics(expression, variable).antiderivative


def harmonics(expression: sp.Expr, variable: sp.Symbol) -> Harmonics:
    """The expression as a trigonometric polynomial in the variable.

    Raises ``WuchtError`` where the variable stands outside of sines and cosines (secular terms), and
    ``NotTrigonometricError`` where it is no polynomial in them.
    """
    found = _Expansion(variable)(sp.sympify(expression))
    kept = [Harmonic(*key, *pair) for key, pair in found.items() if not all(_vanishes(c) for c in pair)]
    return Harmonics(
        variable, tuple(sorted(kept, key=lambda h: (sp.default_sort_key(h.frequency), sp.default_sort_key(h.phase))))
    )


def common_period(frequencies: Iterable[sp.Expr]) -> sp.Expr | None:
    """The least period that all frequencies have in common, or None where their ratios are not rational, or there is none."""
    found = [sp.sympify(w) for w in frequencies if w != 0]
    if not found:
        return None
    ratios = [sp.simplify(w / found[0]) for w in found]
    if not all(r.is_Rational for r in ratios):
        return None
    largest = sp.Rational(sp.igcd(0, *(r.p for r in ratios)), sp.ilcm(1, *(r.q for r in ratios)))
    base = found[0] * largest
    return 2 * sp.pi / (-base if base.could_extract_minus_sign() else base)


@dataclass
class _Expansion:
    """Writes expressions as trigonometric polynomials, each subexpression once."""

    variable: sp.Symbol

    def __post_init__(self) -> None:
        self.memo: dict[sp.Expr, Terms] = {}

    def __call__(self, e: sp.Expr) -> Terms:
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
            found: Terms = {CONSTANT: (factor, sp.S.Zero)}
            for a in sp.Mul.make_args(moving):
                found = _product(found, self(a))
            return found
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
            raise _secular(t)
        raise NotTrigonometricError(f"{e} is no polynomial in sines and cosines of {t}")

    def _power(self, e: sp.Pow) -> Terms:
        base, count = self(e.base), int(e.exp)
        if count < 0:
            left = {k: c for k, c in base.items() if not all(_vanishes(x) for x in c)}
            if set(left) != {CONSTANT}:
                raise NotTrigonometricError(f"{e} has {self.variable} in its denominator")
            return {CONSTANT: (left[CONSTANT][0] ** count, sp.S.Zero)}
        found = base
        for _ in range(count - 1):
            found = _product(found, base)
        return found

    def _linear(self, e: sp.Expr, argument: sp.Expr) -> Key:
        argument = sp.expand(argument)
        frequency = sp.diff(argument, self.variable)
        if self.variable in frequency.free_symbols:
            raise NotTrigonometricError(f"the argument of {e} does not grow evenly with {self.variable}")
        if frequency.has(sp.Float):
            frequency = sp.nsimplify(frequency, rational=True)  # 3 * 0.1 - 0.3 is zero
        return sp.expand(frequency), sp.expand(argument.xreplace({self.variable: sp.S.Zero}))


def _secular(t: sp.Symbol) -> WuchtError:
    return WuchtError(
        f"{t} stands outside of sines and cosines: such a secular term has no mean over {t}, or none that is uniform"
    )


def _single(frequency: sp.Expr, phase: sp.Expr, factor: sp.Expr, function: type[sp.Function]) -> Terms:
    """factor * function(frequency t + phase), with the sign of the frequency made unique."""
    if _vanishes(frequency):
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
                parts.append(_single(frequency, phase, cosine / 2, sp.cos))
                parts.append(_single(frequency, phase, sine / 2, sp.sin))
    return _sum(parts)


def _vanishes(e: sp.Expr) -> bool:
    """Whether the expression is zero; numbers are decided exactly, symbols by expanding and cancelling."""
    if e.is_zero is not None or e.is_Symbol:
        return bool(e.is_zero)
    expanded = sp.expand(e)
    if not expanded.free_symbols:
        return bool(sp.simplify(expanded) == 0)
    return bool(expanded == 0)


def _mean_by_residues(e: sp.Expr, t: sp.Symbol) -> sp.Expr:
    """The mean of a rational function of sines and cosines with one period, by the poles within |z| = 1, z = exp(i w t)."""
    e = e.replace(lambda a: isinstance(a, sp.tan | sp.cot | sp.sec | sp.csc), lambda a: a.rewrite(sp.sin).rewrite(sp.cos))
    expansion, z = _Expansion(t), sp.Dummy("z")
    waves = {a: expansion._linear(a, a.args[0]) for a in e.atoms(sp.sin, sp.cos) if t in a.free_symbols}
    period = common_period([w for w, _ in waves.values()])
    if period is None:
        raise NotTrigonometricError(f"{e} is no polynomial in sines and cosines of {t}, and has no period that is certain")
    base, turned = 2 * sp.pi / period, {}
    for a, (w, p) in waves.items():
        forward, back = (z ** (s * sp.simplify(w / base)) * sp.exp(s * sp.I * p) for s in (1, -1))
        turned[a] = (forward + back) / 2 if isinstance(a, sp.cos) else (forward - back) / (2 * sp.I)
    rational = e.xreplace(turned)
    if t in rational.free_symbols:
        raise _secular(t)
    if not rational.is_rational_function(z):
        raise NotTrigonometricError(f"{e} is no rational function of sines and cosines of {t}: its mean was not found")
    above, below = sp.fraction(sp.cancel(sp.together(rational / z)))
    poles = sp.Poly(below, z)
    poles = poles.monic()
    if any(sp.simplify(c).free_symbols for c in poles.all_coeffs()):
        raise NotTrigonometricError(
            f"the zeros of the denominator of {e} depend on parameters or states: its mean was not found"
        )
    return _residues(above / sp.Poly(below, z).LC(), poles, z, e)


def _residues(above: sp.Expr, below: sp.Poly, z: sp.Symbol, e: sp.Expr) -> sp.Expr:
    roots = sp.roots(below)
    if sum(roots.values()) != below.degree():
        raise NotTrigonometricError(f"the zeros of the denominator of {e} have no closed form: its mean was not found")
    total = []
    for root, count in roots.items():
        distance = sp.Abs(root) - 1
        if distance.evalf(chop=True) == 0 or sp.simplify(distance) == 0:
            raise WuchtError(f"{e} has a pole: it is not bounded and has no mean")
        if distance.evalf() < 0:
            # Without (z - root)^count, differentiated: the residue of a pole of that order.
            rest = above / sp.prod([(z - other) ** n for other, n in roots.items() if other != root])
            total.append(sp.diff(rest, z, count - 1).subs(z, root) / sp.factorial(count - 1))
    return sp.simplify(sp.Add(*total))
