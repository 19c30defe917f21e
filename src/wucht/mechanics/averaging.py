"""Averaging of x' = epsilon X(x, t), first or second order: 002 (3.1)-(3.10), after Bogoliubov and Mitropolsky.

With x = y + epsilon u(y, t) + O(epsilon^2), u of mean zero over t (3.2), (3.6), and <.> the mean over t (3.5), (3.9):

    y' = epsilon <X>                                                       error O(epsilon) over times 1/epsilon,
    y' = epsilon <X> + epsilon^2 (<(dX/dx) u> + <X_2>)                     error O(epsilon^2) with u put back,

where X_2 is what stands at epsilon^2 in the right-hand side. A System goes in and a System comes out, in the same symbols; its
outputs ``full.<state>`` are the states with the fast part put back.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.means import Mean, mean_and_frequencies
from wucht.mechanics.slow_time import (
    refuse_kinks,
    refuse_other_orders,
    refuse_slow_time,
    refuse_small_frequencies,
    refuse_turning_with,
    refuse_unknown_parameter,
)
from wucht.mechanics.trigonometric import NotTrigonometricError, common_period, harmonics, is_whole
from wucht.mechanics.zero_testing import identically_zero
from wucht.system import TIME, Output, System

FULL = "full"
_NO_VALUE = (sp.zoo, sp.nan, sp.oo, -sp.oo, sp.AccumBounds)


@dataclass(frozen=True)
class Averaged:
    """The result of averaging, in the symbols of the System, whose states are now the slow ones.

    Attributes
    ----------
    system : System
        y' (n states).
    first, second : tuple of sympy.Expr, n
        The factors of epsilon and epsilon^2 in it; second is empty at order 1.
    fast : tuple of sympy.Expr, n
        u(y, t); empty where it has no closed form.
    start : tuple of sympy.Expr, n
        The slow states that belong to full states at time t, y = x - epsilon u(x, t), to the order of the averaging; x itself
        where u is not known.
    period : sympy.Expr or None
        Of all that was averaged, X and at order 2 X_2; None where it has none (the mean exists nevertheless).
    divisors : tuple of sympy.Expr
        Frequencies that hold parameters: those by which is divided, and those in the means of order 2 and of quadratures.
        Where one of them is zero, there is a resonance and another mean.
    reason : str
        Why u is not known.
    """

    system: System
    first: tuple[sp.Expr, ...]
    second: tuple[sp.Expr, ...]
    fast: tuple[sp.Expr, ...]
    start: tuple[sp.Expr, ...]
    period: sp.Expr | None
    divisors: tuple[sp.Expr, ...]
    reason: str = ""


def averaged(system: System, small: sp.Symbol | None = None, order: int = 1, period: sp.Expr | None = None) -> Averaged:
    """Average a System in standard form over its independent variable ``TIME``.

    Parameters
    ----------
    system : System
    small : sympy.Symbol, optional
        The parameter epsilon, at least a factor of every right-hand side; None: all of the right-hand side is taken as small.
    order : {1, 2}
    period : sympy.Expr, optional
        Checked to be a period; else that of the frequencies.

    Returns
    -------
    Averaged

    Raises
    ------
    WuchtError
        With the reason, where the System has no standard form or there is no mean: secular terms, slow time, a frequency that
        depends on a state, functions other than sines and cosines; at order 2 also where u has no closed form.

    Notes
    -----
    Outputs keep their names and are those of the full states; where u is not known those of the slow ones, which at order 1
    have the same order of error. Quadratures integrate the mean of their rate: the growth without the bounded oscillation.
    """
    refuse_other_orders(order, "averaging")
    if small is not None:
        refuse_unknown_parameter(system, small)
    epsilon = sp.S.One if small is None else small
    opened = [regular(_needed(system, d, small, order), small) for d in system.derivatives]
    refuse_small_frequencies(opened, small)
    terms = [in_powers(f, small, s) for f, s in zip(opened, system.states, strict=True)]
    X = [a for a, _ in terms]
    for f, a, s in zip(opened, X, system.states, strict=True):
        refuse_slow_time(f, a, small, s)
    means = [_mean(a, s, system) for a, s in zip(X, system.states, strict=True)]
    oscillating = [w for m in means for w in m.frequencies]
    fast, reason = _fast_part(X)
    second: list[Mean] = []
    if order == 2:
        if reason:
            raise WuchtError(f"no averaging of second order: {reason}")
        bent = [_along(a, system.states, fast) + further for a, (_, further) in zip(X, terms, strict=True)]
        second = [_mean(e, s, system) for e, s in zip(bent, system.states, strict=True)]
        oscillating += [w for _, further in terms for w in mean_and_frequencies(further, TIME).frequencies]
    quadratures = [_quadrature(q, system, epsilon, fast, small, order) for q in system.quadratures]
    divisors = [
        *oscillating,
        *(w for m in second for w in m.frequencies),
        *(w for _, frequencies in quadratures for w in frequencies),
    ]
    first, beyond = (tuple(m.value for m in column) for column in (means, second))
    return Averaged(
        _slow(system, epsilon, (first, beyond), fast, small, tuple(q for q, _ in quadratures)),
        first,
        beyond,
        fast,
        tuple(s - epsilon * u for s, u in zip(system.states, fast, strict=True)) if fast else system.states,
        _checked(period, dict.fromkeys(oscillating)),
        tuple(w for w in dict.fromkeys(divisors) if w.free_symbols),
        reason,
    )


def _fast_part(X: Sequence[sp.Expr]) -> tuple[tuple[sp.Expr, ...], str]:
    """u, and no reason; or nothing, and the reason."""
    try:
        return tuple(harmonics(e, TIME).antiderivative for e in X), ""
    except NotTrigonometricError as error:
        return (), str(error)


def in_powers(f: sp.Expr, small: sp.Symbol | None, state: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """The factors of epsilon and epsilon^2 in a rate. Raises ``WuchtError`` where something is left without epsilon."""
    if small is None:
        return f, sp.S.Zero
    rest, once, twice = expanded(f, small, state)
    if not identically_zero(rest):
        raise WuchtError(
            f"the rate of {state} is not small: without {small} it is {rest}. The standard form is x' = {small} X(x, t); "
            "an angle becomes the independent variable, an oscillation an amplitude and a phase, before"
        )
    return once, twice


def expanded(f: sp.Expr, small: sp.Symbol, state: sp.Symbol) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """The factors of 1, epsilon and epsilon^2 in a rate. Raises ``WuchtError`` where it has no such expansion."""
    refuse_kinks(f, small, state)
    once = sp.diff(f, small)
    coefficients = [e.xreplace({small: sp.S.Zero}) for e in (f, once, sp.diff(once, small) / 2)]
    if any(e.has(*_NO_VALUE) for e in coefficients):
        raise WuchtError(f"the rate of {state} has no expansion in powers of {small}")
    return coefficients[0], coefficients[1], coefficients[2]


def regular(f: sp.Expr, small: sp.Symbol | None) -> sp.Expr:
    """The rate over one denominator where 1/epsilon stands in it: an inertia J/epsilon in a denominator is no pole."""
    polar = any(p.exp.is_negative and p.base == small for p in f.atoms(sp.Pow))
    return sp.together(f) if polar else f


def full_states(system: System) -> dict[sp.Symbol, sp.Symbol]:
    """States and definitions -> the symbols ``full.<name>`` of the same with the fast part put back."""
    return {s: sp.Symbol(f"{FULL}.{s.name}", real=s.is_real) for s in (*system.states, *(d for d, _ in system.definitions))}


def put_back(
    system: System, full: Mapping[sp.Symbol, sp.Expr]
) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[Output, ...]]:
    """Definitions and outputs of a slow System: ``full.<state>`` for the given full states, then all outputs of them.

    full: of those states whose fast part is known; the others stand for themselves.
    """
    renamed = {s: r for s, r in full_states(system).items() if s in full or s not in system.states}
    lines = [(renamed[s], sp.sympify(e)) for s, e in full.items()]
    if system.outputs:
        lines += [(renamed[s], e.xreplace(renamed)) for s, e in system.definitions]
    states = [Output(renamed[s].name, renamed[s], long_name=f"{s.name} with its fast part") for s in full]
    return tuple(lines), (*states, *(_of(o, o.expression.xreplace(renamed), o.jump.xreplace(renamed)) for o in system.outputs))


def _of(output: Output, expression: sp.Expr, jump: sp.Expr) -> Output:
    return Output(output.name, expression, output.unit, output.long_name, jump)


def _slow(
    system: System,
    epsilon: sp.Expr,
    means: tuple[Sequence[sp.Expr], Sequence[sp.Expr]],
    fast: Sequence[sp.Expr],
    small: sp.Symbol | None,
    quadratures: tuple[Output, ...],
) -> System:
    """The averaged System: rates, the definitions that they still use, outputs with the fast part, mean quadratures."""
    first, second = means
    rates = [epsilon * a for a in first]
    if second:
        rates = [r + epsilon**2 * b for r, b in zip(rates, second, strict=True)]
    full = {s: s + epsilon * u for s, u in zip(system.states, fast, strict=True)} if fast else {}
    lines, outputs = put_back(system, full)
    moving = _moving(system, small)
    return System(
        states=system.states,
        derivatives=tuple(rates),
        parameters=system.parameters,
        definitions=(*((s, e) for s, e in system.definitions if s not in moving), *lines),
        outputs=outputs,
        quadratures=quadratures,
        angles=system.angles,
    )


def _quadrature(
    q: Output, system: System, epsilon: sp.Expr, fast: Sequence[sp.Expr], small: sp.Symbol | None, order: int
) -> tuple[Output, tuple[sp.Expr, ...]]:
    """A quadrature with the mean of its rate, at order 2 with <(dg/dx) u> epsilon besides, and the frequencies met."""
    rate = _needed(system, q.expression, small, order)
    refuse_small_frequencies([rate], small)
    symbol = sp.Symbol(q.name)
    means = [_mean(rate, symbol, system)]
    if order == 2:
        means.append(_mean(_along(rate, system.states, fast), symbol, system))
    jump = sp.sympify(system.explicit(q.jump))
    if TIME in jump.free_symbols:
        raise WuchtError(f"the jumps of {q.name} depend on {TIME}: they have no mean")
    value = sp.Add(*(epsilon**i * m.value for i, m in enumerate(means)))
    return _of(q, value, jump), tuple(w for m in means for w in m.frequencies)


def _along(e: sp.Expr, states: Sequence[sp.Symbol], fast: Sequence[sp.Expr]) -> sp.Expr:
    """(de/dx) u."""
    return sp.Add(*(sp.diff(e, s) * u for s, u in zip(states, fast, strict=True)))


def _moving(system: System, small: sp.Symbol | None) -> set[sp.Symbol]:
    """The definitions that depend on time or epsilon: they cannot stay as they are in the mean."""
    moving = {TIME} if small is None else {TIME, small}
    for symbol, expression in system.definitions:
        if expression.free_symbols & moving:
            moving.add(symbol)
    return moving - {TIME, small}


def _needed(system: System, e: sp.Expr, small: sp.Symbol | None, order: int) -> sp.Expr:
    """The expression without definitions that depend on time or epsilon; at order 2, which differentiates it, without any."""
    if order == 2:
        return sp.sympify(system.explicit(e))
    moving = _moving(system, small)
    for symbol, meaning in reversed(system.definitions):
        if symbol in moving and symbol in e.free_symbols:
            e = e.xreplace({symbol: meaning})
    return sp.sympify(e)


def _mean(e: sp.Expr, state: sp.Symbol, system: System) -> Mean:
    """The mean of a state's rate, or the sentence why it has none."""
    try:
        refuse_turning_with((*system.states, *(d for d, _ in system.definitions)), e)
        return mean_and_frequencies(e, TIME)
    except WuchtError as error:
        raise type(error)(f"the rate of {state} cannot be averaged: {error}") from error


def _checked(period: sp.Expr | None, frequencies: Iterable[sp.Expr]) -> sp.Expr | None:
    """The period found, or the one given after a check that it is one."""
    if period is None:
        return common_period(frequencies)
    if isinstance(period, str):
        raise WuchtError(f"the period {period!r} is a text: a number or an expression of parameters is allowed")
    period = sp.sympify(period)
    if period.is_positive is False or period.is_extended_real is False or period.is_infinite:
        raise WuchtError(f"{period} is no period: a positive time is allowed")
    for w in frequencies:
        if not is_whole(w * period / (2 * sp.pi)):
            raise WuchtError(f"{period} is no period: the frequency {w} is present")
    return period
