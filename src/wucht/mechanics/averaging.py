"""Averaging of x' = epsilon X(x, t), first or second order: 002 (3.1)-(3.10), after Bogoliubov and Mitropolsky.

With x = y + epsilon u(y, t) + O(epsilon^2), u of mean zero over t (3.2), (3.6), and <.> the mean over t (3.5), (3.9):

    y' = epsilon <X>                                                       error O(epsilon) over times 1/epsilon,
    y' = epsilon <X> + epsilon^2 (<(dX/dx) u> + <X_2>)                     error O(epsilon^2) with u put back,

where X_2 is the factor of epsilon^2 in the right-hand side. A System goes in and a System comes out, in the same symbols; its
outputs ``full.<state>`` are the states with the fast part put back.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from wucht.earlier_names import provide_earlier_names
from wucht.errors import WuchtError
from wucht.mechanics.means import mean_and_frequencies
from wucht.mechanics.slow_time import (
    refuse_kinks,
    refuse_other_orders,
    refuse_slow_time,
    refuse_small_frequencies,
    refuse_turning_with,
    refuse_unknown_parameter,
)
from wucht.mechanics.trigonometric import NotTrigonometricError, common_period, error_context, trigonometric_polynomial
from wucht.mechanics.zero_testing import SAME, is_identically_zero
from wucht.system import TIME, Output, System, substitute_definitions

FULL = "full"
_NO_VALUE = (sp.zoo, sp.nan, sp.oo, -sp.oo, sp.AccumBounds)


@dataclass(frozen=True)
class Averaging:
    """Result of averaging, in the symbols of the System, whose states are now the slow ones.

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
        where u has no closed form.
    period : sympy.Expr or None
        Period of all averaged terms, X and at order 2 X_2; None where there is none (the mean exists nevertheless).
    divisors : tuple of sympy.Expr
        Frequencies with parameters: divisors, and those in the means of order 2 and of quadratures. Where one of them is
        zero, there is a resonance and another mean.
    reason : str
        Reason why u is not known.
    """

    system: System
    first: tuple[sp.Expr, ...]
    second: tuple[sp.Expr, ...]
    fast: tuple[sp.Expr, ...]
    start: tuple[sp.Expr, ...]
    period: sp.Expr | None
    divisors: tuple[sp.Expr, ...]
    reason: str = ""


def averaged(system: System, small: sp.Symbol | None = None, order: int = 1, period: sp.Expr | None = None) -> Averaging:
    """Average a System in standard form over its independent variable ``TIME``.

    Parameters
    ----------
    system : System
    small : sympy.Symbol, optional
        The parameter epsilon, at least a factor of every right-hand side; None: the whole right-hand side counts as small.
    order : {1, 2}
    period : sympy.Expr, optional
        Checked to be a period; else that of the frequencies.

    Returns
    -------
    Averaging

    Raises
    ------
    WuchtError
        With the reason, where the System has no standard form or there is no mean: secular terms, slow time, a frequency that
        depends on a state, functions other than sines and cosines; at order 2 also where u has no closed form.

    Notes
    -----
    Outputs keep their names and are those of the full states; where u is not known those of the slow ones, which at order 1
    have the same order of error. Quadratures integrate the mean of their rate: the growth without the bounded oscillation.

    Examples
    --------
    >>> import sympy as sp
    >>> from wucht.mechanics import averaged
    >>> from wucht.system import TIME, System
    >>> x, mu = sp.symbols("x mu", real=True)
    >>> averaged(System((x,), (mu * (x - x**3) * sp.sin(TIME) ** 2,), (mu,)), mu).system.derivatives
    (mu*(-x**3/2 + x/2),)
    """
    refuse_other_orders(order, "averaging")
    if small is not None:
        refuse_unknown_parameter(system, small)
    system.require_formulas()
    epsilon, states = sp.S.One if small is None else small, system.states
    # Definitions of time or epsilon, and all at order 2, which differentiates, are substituted before averaging.
    moving = {s for s, _ in system.definitions} if order == 2 else _moving(system, small)
    rates = [joined_fraction(_substitute_moving(moving, system, d), small) for d in system.derivatives]
    refuse_small_frequencies(rates, small)
    powers = [small_factors(f, small, s) for f, s in zip(rates, states, strict=True)]
    X = [a for a, _ in powers]
    for f, a, s in zip(rates, X, states, strict=True):
        refuse_slow_time(f, a, small, s)
    means = [_mean(a, s, system) for a, s in zip(X, states, strict=True)]
    first, oscillating = tuple(m for m, _ in means), [w for _, frequencies in means for w in frequencies]
    fast, reason = _fast_part(X)
    second, beyond = list[sp.Expr](), list[sp.Expr]()
    if order == 2:
        if reason:
            raise WuchtError(f"no averaging of second order: {reason}", code="no-second-order")
        for (a, further), s in zip(powers, states, strict=True):
            value, frequencies = _mean(directional_derivative(a, states, fast) + further, s, system)
            second.append(value)
            beyond += frequencies
            oscillating += mean_and_frequencies(further, TIME)[1]
    quadratures = []
    for q in system.quadratures:
        rate, jump = _substitute_moving(moving, system, q.expression), sp.sympify(system.explicit(q.jump))
        refuse_small_frequencies([rate], small)
        changes = [directional_derivative(rate, states, fast)] if order == 2 else []
        orders = [_mean(e, sp.Symbol(q.name), system) for e in (rate, *changes)]
        if TIME in jump.free_symbols:
            raise WuchtError(f"the jumps of {q.name} depend on {TIME}: they have no mean", code="jumps")
        value = sp.Add(*(epsilon**i * m for i, (m, _) in enumerate(orders)))
        quadratures.append(replace(q, expression=value, jump=jump))
        beyond += [w for _, frequencies in orders for w in frequencies]
    fluctuation = [epsilon * u for u in fast]
    lines, outputs = restore_fast_part(system, {s: s + u for s, u in zip(states, fluctuation, strict=False)})
    slow = replace(
        system,
        derivatives=tuple(epsilon * a + epsilon**2 * b for a, b in zip(first, second or [sp.S.Zero] * len(first), strict=True)),
        definitions=(*((s, e) for s, e in system.definitions if s not in _moving(system, small)), *lines),
        outputs=outputs,
        quadratures=tuple(quadratures),
        second_order=None,
    )
    return Averaging(
        slow,
        first,
        tuple(second),
        fast,
        tuple(s - u for s, u in zip(states, fluctuation, strict=True)) if fast else states,
        _checked_period(period, dict.fromkeys(oscillating)),
        tuple(w for w in dict.fromkeys([*oscillating, *beyond]) if w.free_symbols),
        reason,
    )


def _fast_part(X: Sequence[sp.Expr]) -> tuple[tuple[sp.Expr, ...], str]:
    """u and an empty reason; or an empty tuple and the reason."""
    try:
        return tuple(trigonometric_polynomial(e, TIME).antiderivative for e in X), ""
    except NotTrigonometricError as error:
        return (), str(error)


def small_factors(f: sp.Expr, small: sp.Symbol | None, state: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """The factors of epsilon and epsilon^2 in a rate. Raises ``WuchtError`` where a term is without epsilon."""
    if small is None:
        return f, sp.S.Zero
    rest, once, twice = power_coefficients(f, small, state)
    if not is_identically_zero(rest):
        raise WuchtError(
            f"the rate of {state} is not small: without {small} it is {rest}. The standard form is x' = {small} X(x, t); "
            "before, make an angle the independent variable, and an oscillation an amplitude and a phase",
            code="not-small",
        )
    return once, twice


def power_coefficients(f: sp.Expr, small: sp.Symbol, state: sp.Symbol) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """The factors of 1, epsilon and epsilon^2 in a rate. Raises ``WuchtError`` where it has no such expansion."""
    refuse_kinks(f, small, state)
    once = sp.diff(f, small)
    coefficients = [e.xreplace({small: sp.S.Zero}) for e in (f, once, sp.diff(once, small) / 2)]
    if any(e.has(*_NO_VALUE) for e in coefficients):
        raise WuchtError(f"the rate of {state} has no expansion in powers of {small}", code="no-expansion")
    return coefficients[0], coefficients[1], coefficients[2]


def joined_fraction(f: sp.Expr, small: sp.Symbol | None) -> sp.Expr:
    """The rate over one denominator where it contains 1/epsilon: an inertia J/epsilon in a denominator is no pole."""
    polar = any(p.exp.is_negative and p.base == small for p in f.atoms(sp.Pow))
    return sp.together(f) if polar else f


def full_states(system: System) -> dict[sp.Symbol, sp.Symbol]:
    """States and definitions -> the symbols ``full.<name>`` of the same with the fast part put back."""
    return {s: sp.Symbol(f"{FULL}.{s.name}", real=s.is_real) for s in (*system.states, *(d for d, _ in system.definitions))}


def restore_fast_part(
    system: System, full: Mapping[sp.Symbol, sp.Expr]
) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[Output, ...]]:
    """Definitions and outputs of a slow System: ``full.<state>`` for the given full states, then all outputs of them.

    full: of the states whose fast part is known; the others are kept.
    """
    full_symbols = {s: r for s, r in full_states(system).items() if s in full or s not in system.states}
    lines = [(full_symbols[s], sp.sympify(e)) for s, e in full.items()]
    if system.outputs:
        lines += [(full_symbols[s], e.xreplace(full_symbols)) for s, e in system.definitions]
    states = [Output(full_symbols[s].name, full_symbols[s], long_name=f"{s.name} with its fast part") for s in full]
    return tuple(lines), (*states, *(substituted_output(full_symbols, o) for o in system.outputs))


def substituted_output(meaning: Mapping[sp.Symbol, sp.Expr], output: Output, factor: sp.Expr = sp.S.One) -> Output:
    """An output or quadrature with symbols replaced. factor: of a rate, not of its jumps."""
    return replace(
        output, expression=output.expression.xreplace(meaning) * factor, jump=sp.sympify(output.jump).xreplace(meaning)
    )


def directional_derivative(e: sp.Expr, states: Sequence[sp.Symbol], change: Sequence[sp.Expr]) -> sp.Expr:
    """(de/dx) u: the derivative of an expression along a change of the states."""
    return sp.Add(*(sp.diff(e, s) * u for s, u in zip(states, change, strict=True)))


def _moving(system: System, small: sp.Symbol | None) -> set[sp.Symbol]:
    """The definitions that depend on time or epsilon: they have to be substituted before averaging."""
    moving = {TIME, small}
    for symbol, expression in system.definitions:
        if expression.free_symbols & moving:
            moving.add(symbol)
    return moving - {TIME, small}


def _substitute_moving(moving: set[sp.Symbol], system: System, e: sp.Expr) -> sp.Expr:
    """Substitute these definitions in the expression."""
    return sp.sympify(substitute_definitions(e, [(s, meaning) for s, meaning in system.definitions if s in moving]))


def _mean(e: sp.Expr, state: sp.Symbol, system: System) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """The mean of a state's rate and its frequencies. Raises ``WuchtError`` where it has none, with the reason."""
    with error_context(f"the rate of {state} cannot be averaged"):
        refuse_turning_with((*system.states, *(d for d, _ in system.definitions)), e)
        return mean_and_frequencies(e, TIME)


def _checked_period(period: sp.Expr | None, frequencies: Iterable[sp.Expr]) -> sp.Expr | None:
    """The common period of the frequencies, or the given one after a check that it is a period."""
    if period is None:
        return common_period(frequencies)
    if isinstance(period, str):
        raise WuchtError(f"the period {period!r} is a text: a number or an expression of parameters is allowed", code="text")
    period = sp.sympify(period)
    if period.is_positive is False or period.is_extended_real is False or period.is_infinite:
        raise WuchtError(f"{period} is not a period: a positive time is allowed", code="not-positive")
    for w in frequencies:
        turns = sp.simplify(w * period / (2 * sp.pi))
        decimal = turns.has(sp.Float) and turns.is_real and abs(turns - round(turns)) <= SAME * abs(turns)
        if not (decimal or turns.is_Integer):
            raise WuchtError(f"{period} is not a period: the frequency {w} is present", code="other-period")
    return period


provide_earlier_names(__name__)
