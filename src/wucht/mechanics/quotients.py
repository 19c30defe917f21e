"""Exact means of quotients of trigonometric polynomials: by the residues within |z| = 1 of z = exp(i w t).

A sum is taken term by term. A denominator D has to be real, of one period, and numbers but for a common factor and a phase.
What is needed are the moments <exp(i k theta)/D>, which are numbers; the numerator may hold any symbols. D must be a product
of polynomials of z of degree 1 and 2 over the rational complex numbers, as A + B cos + C sin is, so that each residue holds
one root and the moments are short. Each is compared with a quadrature before it is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, reduce
from math import gcd

import mpmath  # type: ignore[import-untyped]  # SymPy brings it along
import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.trigonometric import (
    CONSTANT,
    Expansion,
    NotTrigonometricError,
    Terms,
    common_period,
    secular,
    waves,
)
from wucht.mechanics.zero_testing import identically_zero, number

Laurent = tuple[tuple[int, sp.Expr], ...]
"""Powers of z and their coefficients, which are complex numbers."""
Factors = tuple[tuple[Laurent, int], ...]
"""Of a denominator, each with the power at which it stands."""
Moment = tuple[sp.Expr, sp.Expr]
_Z = sp.Dummy("z")
_BY_SINE_AND_COSINE = {
    sp.tan: lambda a: sp.sin(a) / sp.cos(a),
    sp.cot: lambda a: sp.cos(a) / sp.sin(a),
    sp.sec: lambda a: 1 / sp.cos(a),
    sp.csc: lambda a: 1 / sp.sin(a),
}
_DEGREE = 16
"""Largest degree of a denominator in z: beyond it the closed forms fill pages."""
_ON_THE_CIRCLE, _AGREES = 1e-25, 1e-12


def mean_of_quotients(e: sp.Expr, t: sp.Symbol) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """The mean over t of a sum of quotients of trigonometric polynomials, and the frequencies above and below in them.

    Raises ``WuchtError`` where none was found.
    """
    for function, quotient in _BY_SINE_AND_COSINE.items():
        e = e.replace(function, quotient)
    _refuse_other_functions(e, t)
    numerators: dict[sp.Expr, list[sp.Expr]] = {}
    for term in sp.Add.make_args(sp.expand_mul(e)):
        above, below = sp.fraction(sp.together(term), exact=True)
        still, moving = below.as_independent(t, as_Add=False)
        numerators.setdefault(moving, []).append(above / still)
    expansion, total, frequencies = Expansion(t), sp.S.Zero, list[sp.Expr]()
    for below, terms in numerators.items():
        above = _kept(expansion(sp.Add(*terms)))
        powers = [a.as_base_exp() for a in sp.Mul.make_args(below)]
        factors = [(_kept(expansion(base)), int(n)) for base, n in powers]
        total += _mean(above, factors, below, t)
        frequencies += [w for polynomial in (above, *(f for f, _ in factors)) for w, _ in polynomial if w != 0]
    return total, tuple(dict.fromkeys(frequencies))


def _kept(terms: Terms) -> Terms:
    return {key: pair for key, pair in terms.items() if not all(map(identically_zero, pair))}


def _refuse_other_functions(e: sp.Expr, t: sp.Symbol) -> None:
    even = waves(e, t)
    for a in e.atoms(sp.sin, sp.cos):
        if t in a.free_symbols and a not in even:
            raise NotTrigonometricError(f"the argument of {a} does not grow evenly with {t}")
    if not any(isinstance(a, sp.sin | sp.cos) for a in even):
        raise NotTrigonometricError(f"{e} is no polynomial in sines and cosines of {t}, and has no period that is certain")
    marks = {a: sp.Dummy() for a in even}
    rest = e.xreplace(marks)
    if not rest.is_rational_function(*marks.values()):
        raise NotTrigonometricError(f"{e} is no rational function of sines and cosines of {t}: its mean was not found")
    if t in rest.free_symbols:
        raise secular(t)


def _mean(above: Terms, below: Sequence[tuple[Terms, int]], written: sp.Expr, t: sp.Symbol) -> sp.Expr:
    """The mean of a trigonometric polynomial over a product of powers of such. written: the product."""
    if not all(terms for terms, _ in below):
        raise WuchtError(f"the denominator {written} is zero at all times")
    still = sp.prod([terms[CONSTANT][0] ** n for terms, n in below if set(terms) == {CONSTANT}])
    turning = [(terms, n) for terms, n in below if set(terms) != {CONSTANT}]
    if not turning:
        return above.get(CONSTANT, (sp.S.Zero, sp.S.Zero))[0] / still
    period = common_period([w for terms, _ in turning for w, _ in terms])
    if period is None:
        raise NotTrigonometricError(
            f"1/({written}) is no polynomial in sines and cosines of {t}, and has no period that is certain"
        )
    base = 2 * sp.pi / period
    slowest, phase = min(
        ((sp.simplify(w / base), p) for terms, _ in turning for w, p in terms if w != 0), key=lambda pair: pair[0]
    )
    shift, factors = phase / slowest, []
    for terms, n in turning:
        factor, laurent = _laurent(terms, base, shift, written)
        still *= factor**n
        factors.append((laurent, n))
    total = sp.S.Zero
    for (w, p), (cosine, sine) in above.items():
        k = sp.simplify(w / base)
        if not k.is_Rational:
            raise NotTrigonometricError(
                f"the ratio of {w} and {base}, frequencies above and below in a quotient, is not certain"
            )
        if k.is_Integer:
            re, im = _moment_over(written, int(k), tuple(factors))
            angle = p - k * shift
            c, s = sp.cos(angle), sp.sin(angle)
            total += cosine * (re * c - im * s) + sine * (re * s + im * c)
    return total / still


def _laurent(terms: Terms, base: sp.Expr, shift: sp.Expr, below: sp.Expr) -> tuple[sp.Expr, Laurent]:
    """A common factor, and the powers of z = exp(i (base t + shift)) without it."""
    factor = next(c for pair in terms.values() for c in pair if not identically_zero(c))
    powers: dict[int, sp.Expr] = {}
    for (w, p), pair in terms.items():
        k = int(sp.simplify(w / base))
        rest = sp.expand(p - k * shift)
        cosine, sine = (sp.nsimplify(sp.cancel(c / factor), rational=True) if c != 0 else c for c in pair)
        if cosine.free_symbols | sine.free_symbols | rest.free_symbols:
            raise NotTrigonometricError(
                f"the zeros of the denominator {below} depend on parameters or states: its mean was not found"
            )
        if not (cosine.is_real and sine.is_real):
            raise NotTrigonometricError(f"the denominator {below} is not real: its mean was not found")
        turn = sp.exp(sp.I * rest) if rest != 0 else sp.S.One
        if k == 0:
            powers[0] = powers.get(0, sp.S.Zero) + cosine
            continue
        half = (cosine - sp.I * sine) / 2
        powers[k] = sp.expand(powers.get(k, sp.S.Zero) + half * turn)
        powers[-k] = sp.expand(powers.get(-k, sp.S.Zero) + sp.conjugate(half) / turn)
    return factor, tuple(sorted(powers.items()))


def _moment_over(below: sp.Expr, k: int, factors: Factors) -> Moment:
    try:
        return _moment(k, factors)
    except WuchtError as error:
        raise type(error)(f"the mean of a quotient was not found; of its denominator {below}: {error}") from error


@lru_cache(maxsize=256)
def _moment(k: int, factors: Factors) -> Moment:
    """Real and imaginary part of <exp(i k theta)/D>."""
    if k < 0:
        re, im = _moment(-k, factors)
        return re, -im
    step = reduce(gcd, (j for laurent, _ in factors for j, _ in laurent))
    if k % step:
        return sp.S.Zero, sp.S.Zero
    if step > 1:
        return _moment(k // step, tuple((tuple((j // step, c) for j, c in laurent), n) for laurent, n in factors))
    below = [(_polynomial(laurent), n) for laurent, n in factors]
    power = k - 1 + sum(max(j for j, _ in laurent) * n for laurent, n in factors)
    leading, irreducible = _factored(below)
    residues, poles = [], []
    for factor, n in irreducible.items():
        others = sp.Mul(*(g.as_expr() ** m for g, m in irreducible.items() if g != factor))
        roots = _roots(factor)
        poles += roots
        for root in (r for r in roots if _inside(r)):
            # Without (z - root)^n, differentiated: the residue of a pole of that order.
            rest = _Z**power / (others * (factor.LC() * sp.prod(_Z - r for r in roots if r != root)) ** n)
            residues.append(sp.diff(rest, _Z, n - 1).xreplace({_Z: root}) / (sp.factorial(n - 1) * leading))
    parts = [sp.expand_complex(sp.radsimp(r)).as_real_imag() for r in residues]
    moment = (
        tuple(sp.Add(*(sp.radsimp(sp.expand(p)) for p in column)) for column in zip(*parts, strict=True)) or (sp.S.Zero,) * 2
    )
    _compare(moment, k, factors, poles)
    return moment[0], moment[1]


def _polynomial(laurent: Laurent) -> sp.Poly:
    degree = max(j for j, _ in laurent)
    return sp.Poly(sp.Add(*(c * _Z ** (j + degree) for j, c in laurent)), _Z, extension=True)


def _factored(product: Sequence[tuple[sp.Poly, int]]) -> tuple[sp.Expr, dict[sp.Poly, int]]:
    """A constant, and the irreducible factors of a product of polynomials with their powers."""
    degree = sum(P.degree() * n for P, n in product)
    if degree > _DEGREE:
        raise NotTrigonometricError(f"its degree in sines and cosines is {degree // 2}, more than {_DEGREE // 2}")
    constant, powers = sp.S.One, dict[sp.Poly, int]()
    for P, n in product:
        c, factors = P.factor_list()
        constant *= c**n
        for factor, m in factors:
            constant *= factor.LC() ** (m * n)
            powers[factor.monic()] = powers.get(factor.monic(), 0) + m * n
    return constant, powers


def _roots(factor: sp.Poly) -> list[sp.Expr]:
    """The zeros of an irreducible polynomial, where it is linear or quadratic."""
    if factor.degree() > 2:
        raise NotTrigonometricError(
            f"its zeros in z = exp(i theta), of {factor.as_expr(sp.Symbol('z'))}, have no short closed form"
        )
    a, b, c = [sp.S.Zero, *factor.monic().all_coeffs()][-3:]
    if a == 0:
        return [sp.expand(-c / b)]
    if sp.radsimp(sp.expand(c * sp.conjugate(c))) == 1:
        # Of A + B cos + C sin: times what makes b and the discriminant real, 2 A and 4 (A^2 - B^2 - C^2).
        a = sp.I if c == -1 else 1 + sp.conjugate(c)
        b, c = sp.radsimp(sp.expand(a * b)), sp.radsimp(sp.expand(a * c))
    root = sp.sqrt(sp.factor_terms(sp.radsimp(sp.expand(b**2 - 4 * a * c))))
    return [sp.expand((-b + sign * root) / (2 * a)) for sign in (1, -1)]


def _inside(pole: sp.Expr) -> bool:
    distance = abs(number(pole)) - 1
    if abs(distance) < _ON_THE_CIRCLE:
        raise WuchtError("it has a zero, so that the quotient has a pole: it is not bounded and has no mean")
    return bool(distance < 0)


def _compare(moment: Sequence[sp.Expr], k: int, factors: Factors, poles: Sequence[sp.Expr]) -> None:
    """Refuse a moment that is not that of a quadrature, with its intervals divided where a pole is nearest."""
    numbers = [([(j, number(c)) for j, c in laurent], n) for laurent, n in factors]

    def integrand(angle: mpmath.mpf) -> mpmath.mpc:
        z = mpmath.expj(angle)
        return z**k / mpmath.fprod(mpmath.fsum(c * z**j for j, c in laurent) ** n for laurent, n in numbers)

    with mpmath.workdps(25):
        near = sorted({mpmath.arg(number(p)) for p in poles})
        turn = [-mpmath.pi, *near, mpmath.pi]
        by_quadrature, size = mpmath.quad(integrand, turn) / (2 * mpmath.pi), mpmath.quad(lambda a: abs(integrand(a)), turn)
        exact = number(moment[0] + sp.I * moment[1])
        if not abs(exact - by_quadrature) <= _AGREES * size:
            raise NotTrigonometricError("its residues do not agree with a quadrature")
