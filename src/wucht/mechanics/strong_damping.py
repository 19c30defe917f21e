"""Averaging of partially strongly damped systems: 002 (3.14)-(3.26), with their corrections.

    x' = epsilon X(x, y, t),    y' = K(x) y + g(x, t) + epsilon Y(x, y, t),    K stable for every x.

After a time O(ln(1/epsilon)) y is on a manifold over the slow x. With x constant, it is the forced solution eta_0 of
y' = K y + g; without g, as in 002, eta_0 = 0 (3.25). (A stable periodic solution in the place of a fixed point: Pontryagin and
Rodygin, [59] of 002.) With the slow change of x and Y, y = eta_0(x, t) + epsilon eta_1(x, t),
d eta_1/dt = K eta_1 + Y - (d eta_0/dx) X.
On the manifold x' = epsilon X(x, eta_0, t) + epsilon^2 (dX/dy) eta_1 is a standard form, which is averaged: (3.24).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaging import (
    Averaging,
    averaged,
    directional_derivative,
    full_states,
    joined_fraction,
    power_coefficients,
    restore_fast_part,
    small_factors,
)
from wucht.mechanics.slow_time import (
    refuse_other_orders,
    refuse_slow_time,
    refuse_small_frequencies,
    refuse_turning_with,
    refuse_unknown_parameter,
)
from wucht.mechanics.trigonometric import error_context, trigonometric_polynomial
from wucht.system import TIME, System

_SHORT = 100
"""Operations up to which an expression is factored: second-order ones would take minutes, and shorten little."""


@dataclass(frozen=True)
class StrongDamping:
    """A strongly damped System reduced to its slow states, and averaged.

    Attributes
    ----------
    averaging : Averaging
        Averaged equations of the slow states; their System has outputs ``full.<state>`` for the damped ones too.
    manifold : tuple of sympy.Expr, n
        eta_0(x, t).
    next : tuple of sympy.Expr
        eta_1(x, t), where needed or where the manifold is zero, else empty.
    rates : sympy.ImmutableMatrix, n x n
        K(x).
    conditions : tuple of sympy.Expr
        In parameters and slow states; all must be positive, or K is not stable. The other conditions of Hurwitz follow from the
        assumptions of the symbols.
    """

    averaging: Averaging
    manifold: tuple[sp.Expr, ...]
    next: tuple[sp.Expr, ...]
    rates: sp.ImmutableMatrix
    conditions: tuple[sp.Expr, ...]


def strongly_damped(system: System, damped_states: Sequence[sp.Symbol], small: sp.Symbol, order: int = 1) -> StrongDamping:
    """Put the damped states on their manifold, and average the others.

    Parameters
    ----------
    system : System
    damped_states : sequence of sympy.Symbol, n
        States whose rates are K(x) y + g(x, t) at epsilon = 0.
    small : sympy.Symbol
        epsilon, a parameter.
    order : {1, 2}
        1: x with an error O(epsilon) for ln(1/epsilon) <= t <= 1/epsilon (3.26). 2: O(epsilon^2) for a run that begins on the
        manifold (in another x moves by O(epsilon) before y is there).

    Returns
    -------
    StrongDamping

    Raises
    ------
    WuchtError
        Where a damped rate is not linear in the damped states at epsilon = 0, K depends on time or is not stable, g is no sum
        of sines and cosines or has a frequency that depends on a slow state, and as ``averaged``.
    """
    refuse_other_orders(order, "strong damping")
    refuse_unknown_parameter(system, small)
    slow = [s for s in system.states if s not in damped_states]
    unknown = [s.name for s in damped_states if s not in system.states]
    if unknown or not damped_states or not slow:
        raise WuchtError(
            f"damped states {', '.join(unknown) or 'none'}: must be some of {', '.join(system.state_names)}, not all",
            code="damped-states",
        )
    rate = {
        s: joined_fraction(sp.sympify(system.explicit(f)), small)
        for s, f in zip(system.states, system.derivatives, strict=True)
    }
    refuse_small_frequencies(list(rate.values()), small)
    X = [small_factors(rate[s], small, s) for s in slow]
    powers = {s: power_coefficients(rate[s], small, s) for s in damped_states}
    for s, leading in (*zip(slow, (a for a, _ in X), strict=True), *((s, powers[s][0]) for s in damped_states)):
        refuse_slow_time(rate[s], leading, small, s)
    K, forcing = _linear([powers[s][0] for s in damped_states], damped_states)
    conditions = stability_conditions(K)
    eta = _forced_response(K, forcing, damped_states, slow)
    on_manifold = dict(zip(damped_states, eta, strict=True))
    first = [a.xreplace(on_manifold) for a, _ in X]
    rates = [small * f for f in first]
    following: tuple[sp.Expr, ...] = ()
    if order == 2 or not any(eta):
        Y = [
            powers[s][1].xreplace(on_manifold) - directional_derivative(e, slow, first)
            for s, e in zip(damped_states, eta, strict=True)
        ]
        following = _forced_response(K, Y, damped_states, slow)
    if order == 2:
        for i, (a, b) in enumerate(X):
            manifold_correction = sp.Add(
                *(sp.diff(a, y).xreplace(on_manifold) * e for y, e in zip(damped_states, following, strict=True))
            )
            rates[i] += small**2 * (b.xreplace(on_manifold) + manifold_correction)
    y = [e + small * f for e, f in zip(eta, following or [sp.S.Zero] * len(eta), strict=True)]
    at = dict(zip(damped_states, y, strict=True))
    slow_system = System(
        states=tuple(slow),
        derivatives=tuple(rates),
        parameters=system.parameters,
        quadratures=tuple(
            replace(
                q,
                expression=sp.sympify(system.explicit(q.expression)).xreplace(at),
                jump=sp.sympify(system.explicit(q.jump)).xreplace(at if order == 2 else on_manifold),
            )
            for q in system.quadratures
        ),
        angles=system.angles & set(slow),
    )
    averaging = averaged(slow_system, small, order)
    symbols, full_definitions = full_states(system), dict(averaging.system.definitions)
    to_full = {s: symbols[s] for s in slow} if averaging.fast else {}
    # eta_0 and eta_1 over the full slow states, not their means.
    full = {s: full_definitions[r] for s, r in to_full.items()} | {s: e.xreplace(to_full) for s, e in at.items()}
    lines, outputs = restore_fast_part(system, full)
    whole = replace(averaging, system=replace(averaging.system, definitions=lines, outputs=outputs))
    return StrongDamping(whole, eta, following, K, conditions)


def stability_conditions(matrix: sp.Matrix) -> tuple[sp.Expr, ...]:
    """The conditions of Hurwitz for all eigenvalues to have negative real parts, without those known to hold.

    matrix: n x n. For a stable matrix there is a norm in which its logarithmic norm is negative, as 002 demands for (3.15); in
    the Euclidean norm it need not be (an oscillator's is not). Raises ``WuchtError`` where a condition is known not to hold.
    """
    mark = sp.Dummy("s")
    coefficients = [sp.factor(c) for c in matrix.charpoly(mark).all_coeffs()]
    n = matrix.rows
    hurwitz = sp.Matrix(n, n, lambda i, j: coefficients[k] if 0 <= (k := 2 * j - i + 1) <= n else sp.S.Zero)
    open_conditions = []
    for size in range(1, n + 1):
        minor = sp.factor(hurwitz[:size, :size].det())
        if minor.is_nonpositive or (minor.is_number and not minor.evalf() > 0):
            raise WuchtError(
                f"the matrix K = {matrix.tolist()} of the damped states is not stable (Hurwitz: {minor} > 0 does not hold): "
                "undamped states have no slow manifold",
                code="unstable",
            )
        if not minor.is_positive:
            open_conditions.append(minor)
    return tuple(dict.fromkeys(open_conditions))


def _linear(rates: Sequence[sp.Expr], damped_states: Sequence[sp.Symbol]) -> tuple[sp.ImmutableMatrix, list[sp.Expr]]:
    """K and g of rates that are K y + g."""
    K = sp.ImmutableMatrix(rates).jacobian(damped_states).applyfunc(sp.simplify)
    if K.free_symbols & set(damped_states):
        raise WuchtError(
            "without epsilon the rates of the damped states are not linear in them: there is no K as in 002 (3.15)",
            code="not-linear",
        )
    if TIME in K.free_symbols:
        raise WuchtError(
            f"the matrix K of the damped states depends on {TIME}: its eigenvalues do not decide its stability",
            code="not-constant",
        )
    return K, [r.xreplace(dict.fromkeys(damped_states, sp.S.Zero)) for r in rates]


def _forced_response(
    K: sp.ImmutableMatrix, forcing: Sequence[sp.Expr], damped_states: Sequence[sp.Symbol], slow: Sequence[sp.Symbol]
) -> tuple[sp.Expr, ...]:
    """The bounded solution of y' = K y + g(t), g a sum of harmonics: for each, (K^2 + w^2) a = -K g_c - w g_s and so on."""
    amplitudes: dict[tuple[sp.Expr, sp.Expr], sp.Matrix] = {}
    for i, force in enumerate(forcing):
        with error_context(f"the forcing of {damped_states[i]} cannot be averaged"):
            refuse_turning_with(slow, force)
            waves = trigonometric_polynomial(force, TIME).terms
        for key, pair in waves.items():
            amplitudes.setdefault(key, sp.zeros(len(damped_states), 2))[i, :] = sp.Matrix([pair])
    total = sp.zeros(len(damped_states), 1)
    for (w, p), g in amplitudes.items():
        cosine, sine = g[:, 0], g[:, 1]
        if w == 0:
            total -= _solve(K, cosine)
            continue
        square = K * K + w**2 * sp.eye(K.rows)
        total += _solve(square, -K * cosine - w * sine) * sp.cos(w * TIME + p)
        total += _solve(square, -K * sine + w * cosine) * sp.sin(w * TIME + p)
    return tuple(total)


def _solve(matrix: sp.Matrix, right: sp.Matrix) -> sp.Matrix:
    """The solution of matrix * a = right, in lowest terms where these are cheap to compute."""
    determinant = sp.factor(matrix.det())
    numerators = matrix.adjugate() * right
    return numerators.applyfunc(lambda e: sp.factor(e / determinant) if e.count_ops() <= _SHORT else e / determinant)
