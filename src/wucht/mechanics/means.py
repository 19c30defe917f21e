"""Exact means over a variable, and antiderivatives of mean zero, of sums, products and quotients of sines and cosines.

The mean is that of 002 (3.5) and (3.9), lim 1/T int_0^T, which exists for any frequencies, commensurate or not. Quotients of
sines and cosines with one period have a mean by the residues within |z| = 1 of z = exp(i w t), where their poles are numbers.
All other expressions are refused.

A sum is taken term by term. A denominator D has to be real, of one period, and numbers but for a common factor and a phase.
The moments <exp(i k theta)/D> are needed, which are numbers; the numerator may hold any symbols. D must be a product
of polynomials of z of degree 1 and 2 over the rational complex numbers, as A + B cos + C sin is, so that each residue holds
one root and the moments are short. Each is compared with a quadrature before it is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import mpmath  # type: ignore[import-untyped]  # SymPy brings it along
import sympy as sp
from sympy.simplify.fu import TR1, TR2

from wucht.errors import WuchtError
from wucht.mechanics.trigonometric import (
    CONSTANT,
    NOTHING,
    NotTrigonometricError,
    Terms,
    common_period,
    error_context,
    harmonic_terms,
    nonzero,
    secular_error,
    trigonometric_polynomial,
    waves,
)
from wucht.mechanics.zero_testing import is_identically_zero, number

_Z = sp.Dummy("z")
_DEGREE = 16
"""Largest degree of a denominator in z: beyond it the closed forms are too long."""
_ON_THE_CIRCLE, _AGREES = 1e-25, 1e-12


def _mean_of_quotients(e: sp.Expr, t: sp.Symbol) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """The mean over t of a sum of quotients of trigonometric polynomials, and the frequencies above and below in them.

    Raises ``WuchtError`` where it cannot be computed.
    """
    e = TR2(TR1(e))  # of sines and cosines alone
    _refuse_other_functions(e, t)
    numerators: dict[sp.Expr, list[sp.Expr]] = {}
    for term in sp.Add.make_args(sp.expand_mul(e)):
        above, below = sp.fraction(sp.together(term), exact=True)
        still, moving = below.as_independent(t, as_Add=False)
        numerators.setdefault(moving, []).append(above / still)
    total, frequencies = sp.S.Zero, list[sp.Expr]()
    for below, terms in numerators.items():
        above = nonzero(harmonic_terms(sp.Add(*terms), t))
        powers = [a.as_base_exp() for a in sp.Mul.make_args(below)]
        factors = [(nonzero(harmonic_terms(base, t)), int(n)) for base, n in powers]
        total += _mean(above, factors, below, t)
        frequencies += [w for polynomial in (above, *(f for f, _ in factors)) for w, _ in polynomial if w != 0]
    return total, tuple(dict.fromkeys(frequencies))


def _refuse_other_functions(e: sp.Expr, t: sp.Symbol) -> None:
    even = waves(e, t)
    for a in e.atoms(sp.sin, sp.cos):
        if t in a.free_symbols and a not in even:
            raise NotTrigonometricError(f"the argument of {a} is not linear in {t}", code="uneven-argument")
    if not any(isinstance(a, sp.sin | sp.cos) for a in even):
        raise NotTrigonometricError(
            f"{e} is not a polynomial in sines and cosines of {t}, and has no certain period", code="no-period"
        )
    marks = {a: sp.Dummy() for a in even}
    rest = e.xreplace(marks)
    if not rest.is_rational_function(*marks.values()):
        raise NotTrigonometricError(
            f"{e} is not a rational function of sines and cosines of {t}: its mean cannot be computed", code="not-rational"
        )
    if t in rest.free_symbols:
        raise secular_error(t)


def _mean(above: Terms, below: Sequence[tuple[Terms, int]], denominator: sp.Expr, t: sp.Symbol) -> sp.Expr:
    """The mean of a trigonometric polynomial over a product of powers of such. denominator: the product."""
    if not all(terms for terms, _ in below):
        raise WuchtError(f"the denominator {denominator} is zero at all times", code="zero-denominator")
    still = sp.prod([terms[CONSTANT][0] ** n for terms, n in below if set(terms) == {CONSTANT}])
    turning = [(terms, n) for terms, n in below if set(terms) != {CONSTANT}]
    if not turning:
        return above.get(CONSTANT, NOTHING)[0] / still
    period = common_period([w for terms, _ in turning for w, _ in terms])
    if period is None:
        raise NotTrigonometricError(
            f"1/({denominator}) is not a polynomial in sines and cosines of {t}, and has no certain period", code="no-period"
        )
    base = 2 * sp.pi / period
    slowest, phase = min(
        ((sp.simplify(w / base), p) for terms, _ in turning for w, p in terms if w != 0), key=lambda pair: pair[0]
    )
    shift = phase / slowest
    polynomials = [(*_polynomial(terms, base, shift, denominator), n) for terms, n in turning]
    still *= sp.prod(common**n for common, _, n in polynomials)
    P = sp.prod(factor**n for _, factor, n in polynomials)
    total = sp.S.Zero
    for (w, p), (cosine, sine) in above.items():
        k = sp.simplify(w / base)
        if not k.is_Rational:
            raise NotTrigonometricError(
                f"the ratio of {w} and {base}, frequencies in numerator and denominator, is not known to be rational",
                code="frequency-ratio",
            )
        if k.is_Integer:
            with error_context(f"the mean of a quotient cannot be computed because of its denominator {denominator}"):
                re, im = _moment(int(k), P)
            angle = p - k * shift
            c, s = sp.cos(angle), sp.sin(angle)
            total += cosine * (re * c - im * s) + sine * (re * s + im * c)
    return total / still


def _polynomial(terms: Terms, base: sp.Expr, shift: sp.Expr, denominator: sp.Expr) -> tuple[sp.Expr, sp.Poly]:
    """A common factor, and P of degree 2 d, without it the polynomial is z^-d P(z) with z = exp(i (base t + shift))."""
    factor = next(c for pair in terms.values() for c in pair if not is_identically_zero(c))
    powers: dict[int, sp.Expr] = {}
    for (w, p), pair in terms.items():
        k = int(sp.simplify(w / base))
        rest = sp.expand(p - k * shift)
        cosine, sine = (sp.nsimplify(sp.cancel(c / factor), rational=True) if c != 0 else c for c in pair)
        if cosine.free_symbols | sine.free_symbols | rest.free_symbols:
            raise NotTrigonometricError(
                f"the zeros of the denominator {denominator} depend on parameters or states: its mean cannot be computed",
                code="parameters-decide",
            )
        if not (cosine.is_real and sine.is_real):
            raise NotTrigonometricError(
                f"the denominator {denominator} is not real: its mean cannot be computed", code="not-real"
            )
        turn = sp.exp(sp.I * rest)
        half = (cosine - sp.I * sine) / 2
        powers[k] = sp.expand(powers.get(k, sp.S.Zero) + half * turn)
        powers[-k] = sp.expand(powers.get(-k, sp.S.Zero) + sp.conjugate(half) / turn)
    degree = max(powers)
    return factor, sp.Poly(sp.Add(*(c * _Z ** (j + degree) for j, c in powers.items())), _Z, extension=True)


@lru_cache(maxsize=256)
def _moment(k: int, P: sp.Poly) -> tuple[sp.Expr, sp.Expr]:
    """Real and imaginary part of <exp(i k theta)/D>, D = z^-d P(z)."""
    if k < 0:
        re, im = _moment(-k, P)
        return re, -im
    if P.degree() > _DEGREE:
        raise NotTrigonometricError(f"its degree in sines and cosines is {P.degree() // 2}, more than {_DEGREE // 2}")
    monic = {factor.monic(): n for factor, n in P.factor_list()[1]}
    roots = {factor: _roots(factor) for factor in monic}
    residues = []
    for factor, n in monic.items():
        other_factors = sp.Mul(*(g.as_expr() ** m for g, m in monic.items() if g != factor))
        for root in (r for r in roots[factor] if _inside(r)):
            # Without (z - root)^n, differentiated: the residue of a pole of that order.
            rest = _Z ** (k - 1 + P.degree() // 2) / (other_factors * sp.prod(_Z - r for r in roots[factor] if r != root) ** n)
            residues.append(sp.diff(rest, _Z, n - 1).xreplace({_Z: root}) / (sp.factorial(n - 1) * P.LC()))
    parts = [sp.expand_complex(sp.radsimp(r)).as_real_imag() for r in residues]
    re, im = (sp.Add(*(sp.radsimp(sp.expand(part[i])) for part in parts)) for i in (0, 1))
    _compare(re + sp.I * im, k, P, [r for of_factor in roots.values() for r in of_factor])
    return re, im


def _roots(factor: sp.Poly) -> list[sp.Expr]:
    """The zeros of an irreducible monic polynomial, where it is linear or quadratic."""
    if factor.degree() > 2:
        raise NotTrigonometricError(
            f"its zeros in z = exp(i theta), of {factor.as_expr(sp.Symbol('z'))}, have no short closed form"
        )
    a, b, c = [sp.S.Zero, *factor.all_coeffs()][-3:]
    if a == 0:
        return [sp.expand(-c / b)]
    if sp.radsimp(sp.expand(c * sp.conjugate(c))) == 1:
        # For A + B cos + C sin: a factor makes b and the discriminant real, 2 A and 4 (A^2 - B^2 - C^2).
        a = sp.I if c == -1 else 1 + sp.conjugate(c)
        b, c = sp.radsimp(sp.expand(a * b)), sp.radsimp(sp.expand(a * c))
    root = sp.sqrt(sp.factor_terms(sp.radsimp(sp.expand(b**2 - 4 * a * c))))
    return [sp.expand((-b + sign * root) / (2 * a)) for sign in (1, -1)]


def _inside(pole: sp.Expr) -> bool:
    distance = abs(number(pole)) - 1
    if abs(distance) < _ON_THE_CIRCLE:
        raise WuchtError("it has a zero, so that the quotient has a pole: it is not bounded and has no mean")
    return bool(distance < 0)


def _compare(moment: sp.Expr, k: int, P: sp.Poly, poles: Sequence[sp.Expr]) -> None:
    """Refuse a moment that disagrees with a quadrature, whose intervals are divided where a pole is nearest."""
    coefficients = [number(c) for c in P.all_coeffs()]

    def integrand(angle: mpmath.mpf) -> mpmath.mpc:
        z = mpmath.expj(angle)
        return z ** (k + P.degree() // 2) / mpmath.polyval(coefficients, z)

    with mpmath.workdps(25):
        turn = [-mpmath.pi, *sorted({mpmath.arg(number(p)) for p in poles}), mpmath.pi]
        by_quadrature, size = mpmath.quad(integrand, turn) / (2 * mpmath.pi), mpmath.quad(lambda a: abs(integrand(a)), turn)
        if not abs(number(moment) - by_quadrature) <= _AGREES * size:
            raise NotTrigonometricError("its residues do not agree with a quadrature")


def mean(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """Return the mean of an expression over all of a variable's range, lim (1/T) int_0^T, exact.

    Parameters
    ----------
    expression : sympy.Expr
        A polynomial in sines and cosines of the variable, or a quotient of such.
    variable : sympy.Symbol

    Returns
    -------
    sympy.Expr

    Raises
    ------
    WuchtError
        With the reason where there is no mean, or where it cannot be computed.

    Examples
    --------
    >>> import sympy as sp
    >>> from wucht.mechanics import mean
    >>> t = sp.Symbol("t", real=True)
    >>> mean(sp.cos(t) ** 2 + sp.sin(3 * t), t), mean(1 / (2 + sp.cos(t)), t)
    (1/2, sqrt(3)/3)
    """
    return mean_and_frequencies(expression, variable)[0]


def mean_and_frequencies(expression: sp.Expr, variable: sp.Symbol) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """The mean, and the frequencies of oscillating terms, which must not be zero for it to hold. Raises ``WuchtError``."""
    try:
        waves = trigonometric_polynomial(expression, variable)
        return waves.mean, waves.frequencies
    except NotTrigonometricError:
        return _mean_of_quotients(sp.sympify(expression), variable)


def antiderivative(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """The antiderivative, of mean zero, of the expression minus its mean. Raises as ``trigonometric_polynomial``."""
    return trigonometric_polynomial(expression, variable).antiderivative
