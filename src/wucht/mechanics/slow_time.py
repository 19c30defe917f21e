"""Refusals of right-hand sides whose dependence on time and epsilon makes averaging over times 1/epsilon wrong.

Each refusal is a ``WuchtError`` with a remedy: most often the slow quantity becomes an additional state.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from wucht.errors import WuchtError, nearest
from wucht.mechanics.trigonometric import waves
from wucht.system import TIME, System

_KINKS = (sp.Abs, sp.sign, sp.Heaviside, sp.Max, sp.Min, sp.Piecewise, sp.floor, sp.ceiling, sp.frac, sp.Mod, sp.arg)


def refuse_unknown_parameter(system: System, small: sp.Symbol) -> None:
    """Raises ``WuchtError`` where epsilon, or k, is not a parameter of the System."""
    if small in system.parameters:
        return
    if not isinstance(small, sp.Symbol):
        raise WuchtError(
            f"{small!r} is not a symbol: a parameter of the System is allowed, {', '.join(system.parameter_names) or 'none'}",
            code="no-symbol",
        )
    if small.name in system.parameter_names:
        raise WuchtError(
            f"{small} is not a parameter: the one of that name was made with other assumptions (real=True, positive=True, ...)",
            code="other-assumptions",
        )
    raise WuchtError(
        f"{small} is not a parameter of the System; {nearest(small.name, system.parameter_names)}", code="no-parameter"
    )


def refuse_other_orders(order: int, method: str) -> None:
    """Raises ``WuchtError`` for an order that is not the integer 1 or 2."""
    if isinstance(order, bool) or not isinstance(order, int) or order not in (1, 2):
        raise WuchtError(f"{method} of order {order!r}: must be 1 or 2", code="order")


def refuse_small_frequencies(rates: Sequence[sp.Expr], small: sp.Symbol | None) -> None:
    """Raises ``WuchtError`` for a frequency with epsilon: cos((1 + epsilon s) t) is not near cos(t) for times 1/epsilon."""
    for wave, frequency in (pair for e in rates for pair in waves(e, TIME).items()):
        if small is not None and small in frequency.free_symbols:
            raise WuchtError(
                f"the frequency in {wave} depends on {small}: over times 1/{small} it cannot be expanded. "
                "Make the slow part of the angle a state",
                code="slow-frequency",
            )


def refuse_slow_time(rate: sp.Expr, leading: sp.Expr, small: sp.Symbol | None, state: sp.Symbol) -> None:
    """Raises ``WuchtError`` where a rate depends on epsilon t, which is no longer small at t = 1/epsilon.

    leading: the averaged factor, without epsilon: time outside of evenly turning functions is refused separately there.
    """
    if small is not None and TIME in _without_waves(rate).free_symbols and TIME not in _without_waves(leading).free_symbols:
        raise WuchtError(
            f"the rate of {state} depends on {TIME} in a way that disappears with {small}: over times 1/{small} such a slow "
            f"time is not small. Make it a state: s' = {small} in the place of {small} {TIME}",
            code="slow-time",
        )


def refuse_turning_with(moving: Iterable[sp.Symbol], e: sp.Expr) -> None:
    """Raises ``WuchtError`` for a frequency that depends on a state: X grows without bound when differentiated (3.8)."""
    for wave, frequency in waves(e, TIME).items():
        turning = sorted(map(str, frequency.free_symbols & {*moving}))
        if turning:
            raise WuchtError(
                f"the frequency in {wave} depends on {', '.join(turning)}: there is no uniform mean, 002 (3.8). "
                "Make the angle itself a state, or the independent variable"
            )


def refuse_kinks(rate: sp.Expr, small: sp.Symbol, state: sp.Symbol) -> None:
    """Raises ``WuchtError`` where a rate has a kink at epsilon = 0, like |epsilon|: it has no expansion there."""
    for a in rate.atoms(*_KINKS):
        smooth = isinstance(a, sp.Abs | sp.sign | sp.Heaviside) and a.args[0].xreplace({small: sp.S.Zero}) != 0
        if small in a.free_symbols and not smooth:
            raise WuchtError(
                f"the rate of {state} has no expansion in powers of {small}: {a} may have a kink at {small} = 0",
                code="no-expansion",
            )


def _without_waves(e: sp.Expr) -> sp.Expr:
    """The expression with a symbol for each function that turns evenly: any remaining time is another dependence."""
    bounded_waves = [a for a, w in waves(e, TIME).items() if not isinstance(a, sp.exp) or (w / sp.I).is_real]
    return e.xreplace({a: sp.Dummy() for a in bounded_waves})
