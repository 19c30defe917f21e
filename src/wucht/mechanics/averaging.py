"""Averaging of x' = epsilon X(x, t), first or second order: 002 (3.1)-(3.10), after Bogoliubov and Mitropolsky.

With x = y + epsilon u(y, t) + O(epsilon^2), u of mean zero over t (3.2), (3.6), and <.> the mean over t (3.5), (3.9):

    y' = epsilon <X>                                                       error O(epsilon) over times 1/epsilon,
    y' = epsilon <X> + epsilon^2 (<(dX/dx) u> + <X_2>)                     error O(epsilon^2) with u put back,

where X_2 is what stands at epsilon^2 in the right-hand side. A System goes in and a System comes out, in the same symbols; its
outputs ``full.<state>`` are the states with the fast part put back.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.means import NotTrigonometricError, common_period, harmonics, mean
from wucht.system import TIME, Output, System

FULL = "full"


@dataclass(frozen=True)
class Averaged:
    """What averaging gave. All expressions are in the symbols of the System, whose states are now the slow ones.

    system: y' (n states). first, second: the factors of epsilon and epsilon^2 in it (n each; second is empty at order 1).
    fast: u(y, t) (n), or empty where it was not found (``reason`` says why). start: the slow states that belong to full
    states at time t, y = x - epsilon u(x, t) (n), to the order of the averaging. period: of X in t, None where it has none
    (the mean exists nevertheless). divisors: frequencies that hold parameters and by which is divided: none may be zero.
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

    small: the parameter epsilon, at least a factor of every right-hand side; None where none is written: all of the right-hand
    side is taken as small. order: 1 or 2. period: what is checked to be a period; else it is found from the frequencies.
    Outputs keep their names and are those of the full states; quadratures integrate the mean of their rate: of an integral
    that grows, its growth without its bounded oscillation.

    Raises ``WuchtError`` with the reason where the System has no standard form, or there is no mean: secular terms, a frequency
    that depends on a state, functions other than sines and cosines; at order 2 also where u is not found in closed form.
    """
    if order not in (1, 2):
        raise WuchtError(f"averaging of order {order}: allowed is 1 or 2")
    epsilon = sp.S.One if small is None else small
    opened = [regular(_needed(system, d, small, order), small) for d in system.derivatives]
    refuse_small_frequencies(opened, small)
    terms = [in_powers(f, small, s) for f, s in zip(opened, system.states, strict=True)]
    X = [a for a, _ in terms]
    first = tuple(_mean(e, s, system) for e, s in zip(X, system.states, strict=True))
    try:
        waves = [harmonics(e, TIME) for e in X]
    except NotTrigonometricError as error:
        if order == 2:
            raise WuchtError(f"no averaging of second order: {error}") from error
        turning = [w for e in X for _, w in _waves(e)]
        slow = _slow(system, epsilon, first, (), (), small, order)
        return Averaged(slow, first, (), (), (), _checked(period, turning), (), str(error))
    fast = tuple(w.antiderivative for w in waves)
    second: tuple[sp.Expr, ...] = ()
    if order == 2:
        second = tuple(
            _mean(_along(e, system.states, fast) + further, s, system)
            for e, (_, further), s in zip(X, terms, system.states, strict=True)
        )
    frequencies = tuple(dict.fromkeys(f for w in waves for f in w.frequencies))
    return Averaged(
        _slow(system, epsilon, first, second, fast, small, order),
        first,
        second,
        fast,
        tuple(s - epsilon * u for s, u in zip(system.states, fast, strict=True)),
        _checked(period, frequencies),
        tuple(f for f in frequencies if f.free_symbols),
    )


def in_powers(f: sp.Expr, small: sp.Symbol | None, state: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """The factors of epsilon and epsilon^2 in a rate. Raises ``WuchtError`` where something is left without epsilon."""
    if small is None:
        return f, sp.S.Zero
    none = {small: sp.S.Zero}
    rest = f.xreplace(none)
    if rest.has(sp.zoo, sp.nan, sp.oo):
        raise WuchtError(f"the rate of {state} has no expansion in powers of {small}")
    if rest != 0 and sp.simplify(rest) != 0:
        raise WuchtError(
            f"the rate of {state} is not small: without {small} it is {rest}. The standard form is x' = {small} X(x, t); "
            "an angle becomes the independent variable, an oscillation an amplitude and a phase, before"
        )
    once = sp.diff(f, small)
    found = once.xreplace(none), (sp.diff(once, small) / 2).xreplace(none)
    if any(e.has(sp.zoo, sp.nan, sp.oo) for e in found):
        raise WuchtError(f"the rate of {state} has no expansion in powers of {small}")
    return found


def regular(f: sp.Expr, small: sp.Symbol | None) -> sp.Expr:
    """The rate over one denominator where 1/epsilon stands in it: an inertia J/epsilon in a denominator is no pole."""
    polar = any(p.exp.is_negative and p.base == small for p in f.atoms(sp.Pow))
    return sp.together(f) if polar else f


def refuse_small_frequencies(rates: Sequence[sp.Expr], small: sp.Symbol | None) -> None:
    """Raises ``WuchtError`` for a frequency with epsilon: cos((1 + epsilon s) t) is not near cos(t) for times 1/epsilon."""
    for wave, frequency in (pair for e in rates for pair in _waves(e)):
        if small is not None and small in frequency.free_symbols:
            raise WuchtError(
                f"the frequency in {wave} depends on {small}: over times 1/{small} it cannot be expanded. "
                "Make the slow part of the angle a state"
            )


def full_states(system: System) -> dict[sp.Symbol, sp.Symbol]:
    """States and definitions -> the symbols ``full.<name>`` of the same with the fast part put back."""
    return {s: sp.Symbol(f"{FULL}.{s.name}", real=s.is_real) for s in (*system.states, *(d for d, _ in system.definitions))}


def put_back(
    system: System, full: Mapping[sp.Symbol, sp.Expr]
) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[Output, ...]]:
    """Definitions and outputs of a slow System: ``full.<state>`` for the given full states, then all outputs of them."""
    renamed = full_states(system)
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
    first: Sequence[sp.Expr],
    second: Sequence[sp.Expr],
    fast: Sequence[sp.Expr],
    small: sp.Symbol | None,
    order: int,
) -> System:
    """The averaged System: rates, the definitions that they still use, outputs with the fast part, mean quadratures."""
    rates = [epsilon * a for a in first]
    if second:
        rates = [r + epsilon**2 * b for r, b in zip(rates, second, strict=True)]
    lines, outputs = (
        put_back(system, {s: s + epsilon * u for s, u in zip(system.states, fast, strict=True)}) if fast else ((), ())
    )
    moving = _moving(system, small)
    return System(
        states=system.states,
        derivatives=tuple(rates),
        parameters=system.parameters,
        definitions=(*((s, e) for s, e in system.definitions if s not in moving), *lines),
        outputs=outputs,
        quadratures=tuple(_quadrature(q, system, epsilon, fast, small, order) for q in system.quadratures),
        angles=system.angles,
    )


def _quadrature(
    q: Output, system: System, epsilon: sp.Expr, fast: Sequence[sp.Expr], small: sp.Symbol | None, order: int
) -> Output:
    """A quadrature with the mean of its rate, at order 2 with <(dg/dx) u> epsilon besides."""
    rate = _needed(system, q.expression, small, order)
    symbol = sp.Symbol(q.name)
    found = _mean(rate, symbol, system)
    if order == 2:
        found += epsilon * _mean(_along(rate, system.states, fast), symbol, system)
    jump = system.explicit(q.jump)
    if TIME in jump.free_symbols:
        raise WuchtError(f"the jumps of {q.name} depend on {TIME}: they have no mean")
    return _of(q, found, jump)


def _along(e: sp.Expr, states: Sequence[sp.Symbol], fast: Sequence[sp.Expr]) -> sp.Expr:
    """(de/dx) u."""
    return sp.Add(*(sp.diff(e, s) * u for s, u in zip(states, fast, strict=True)))


def _moving(system: System, small: sp.Symbol | None) -> set[sp.Symbol]:
    """The definitions that depend on time or epsilon: they cannot stay as they are in the mean."""
    found = {TIME} if small is None else {TIME, small}
    for symbol, expression in system.definitions:
        if expression.free_symbols & found:
            found.add(symbol)
    return found - {TIME, small}


def _needed(system: System, e: sp.Expr, small: sp.Symbol | None, order: int) -> sp.Expr:
    """The expression without definitions that depend on time or epsilon; at order 2, which differentiates it, without any."""
    if order == 2:
        return sp.sympify(system.explicit(e))
    moving = _moving(system, small)
    for symbol, meaning in reversed(system.definitions):
        if symbol in moving and symbol in e.free_symbols:
            e = e.xreplace({symbol: meaning})
    return sp.sympify(e)


def _mean(e: sp.Expr, state: sp.Symbol, system: System) -> sp.Expr:
    """The mean of a state's rate, or the sentence why it has none."""
    try:
        _refuse_turning_with_states(e, system)
        return mean(e, TIME)
    except WuchtError as error:
        raise type(error)(f"the rate of {state} cannot be averaged: {error}") from error


def _waves(e: sp.Expr) -> list[tuple[sp.Expr, sp.Expr]]:
    """The functions that turn evenly with time, each with its frequency."""
    found = [(a, sp.diff(a.args[0], TIME)) for a in e.atoms(sp.sin, sp.cos, sp.exp)]
    return [(a, w) for a, w in found if TIME not in w.free_symbols]


def _refuse_turning_with_states(e: sp.Expr, system: System) -> None:
    """A frequency that depends on a state makes X grow without bound when differentiated: (3.8) does not hold."""
    defined = {d for d, _ in system.definitions}
    for wave, frequency in _waves(e):
        turning = sorted(map(str, frequency.free_symbols & ({*system.states} | defined)))
        if turning:
            raise WuchtError(
                f"the frequency in {wave} depends on {', '.join(turning)}: no uniform mean (3.8). "
                "Make the angle itself a state, or the independent variable"
            )


def _checked(period: sp.Expr | None, frequencies: Sequence[sp.Expr]) -> sp.Expr | None:
    """The period found, or the one given after a check that it is one."""
    if period is None:
        return common_period(frequencies)
    period = sp.sympify(period)
    for w in frequencies:
        if not sp.simplify(w * period / (2 * sp.pi)).is_Integer:
            raise WuchtError(f"{period} is no period: the frequency {w} is present")
    return period
