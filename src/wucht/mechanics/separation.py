"""The direct separation of motions: 001 (1)-(7), after Kapitza and Blekhman.

    m x'' = F(x', x, t) + Phi(x', x, t, k t),  k >> 1,    x(t) = X(t) + xi(t, theta),  theta = k t,  <xi> = 0 (3).

With X', X, t constant (7) is solved to leading order in 1/k: m k^2 d2xi/dtheta2 = Phi - <Phi>. Then (5), with xi of the order
Phi/k^2 and its rate of the order Phi/k: F at the speed X' + xi', and Phi to first order in xi and xi',

    m X'' = <F(X' + xi', X, t)> + <Phi> + <(dPhi/dx) xi + (dPhi/dx') xi'>   (6).

Where Phi does not depend on the speed it may be as large as O(k); else it must be O(1), and terms O(1/k^2) are neglected.
One power of k more is allowed with a parameter as factor, which then counts as O(1/k): a small amplitude, a k^2 cos.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaging import directional_derivative, restore_fast_part
from wucht.mechanics.means import mean
from wucht.mechanics.slow_time import refuse_unknown_parameter
from wucht.mechanics.trigonometric import TrigonometricPolynomial, error_context, trigonometric_polynomial
from wucht.mechanics.zero_testing import is_identically_zero
from wucht.system import TIME, Output, System

THETA = sp.Symbol("theta_fast", real=True)
"""The fast time theta = k t in the expressions of a ``Separation``."""


@dataclass(frozen=True)
class Separation:
    """The result of direct separation; X and X' keep the symbols of the states.

    Attributes
    ----------
    system : System
        X' and X'', with outputs ``full.<state>`` of X + xi, X' + xi'.
    fast : tuple of sympy.Expr, n
        xi(X', X, t, theta).
    rate : tuple of sympy.Expr, n
        Its time derivative k d xi/d theta.
    slow_force, fast_force : tuple of sympy.Expr, n
        F and Phi, m x'' as in (1): times the mass, where one was given.
    vibration_force : tuple of sympy.Expr, n
        The vibrational force: the mean of all forces minus F, likewise.
    """

    system: System
    fast: tuple[sp.Expr, ...]
    rate: tuple[sp.Expr, ...]
    slow_force: tuple[sp.Expr, ...]
    fast_force: tuple[sp.Expr, ...]
    vibration_force: tuple[sp.Expr, ...]


def separated(system: System, positions: Sequence[sp.Symbol], fast: sp.Symbol, mass: sp.Matrix | None = None) -> Separation:
    """Separate the motions of a System of second order.

    Parameters
    ----------
    system : System
    positions : sequence of sympy.Symbol, n
        States whose rates are n other states, and which with them are all states.
    fast : sympy.Symbol
        The parameter k. The terms of the acceleration that turn with k t are Phi, the others F; t elsewhere is slow.
    mass : sympy.Matrix, n x n, optional
        m, constant, by which accelerations are multiplied to give forces (1 if left out).

    Returns
    -------
    Separation

    Raises
    ------
    WuchtError
        With the reason, where the System has no such form, nothing turns with k t, something turns with another multiple of it
        than a whole one, a function of k t is neither sine, cosine nor exponential, Phi is larger than (5) allows, or a mean
        does not exist or has no closed form known here.
    """
    refuse_unknown_parameter(system, fast)
    system.require_formulas()
    velocities = _velocities(system, positions)
    explicit = {s: sp.sympify(system.explicit(f)) for s, f in zip(system.states, system.derivatives, strict=True)}
    forces = [trigonometric_polynomial(_substitute_theta(explicit[v], fast, v), THETA) for v in velocities]
    slow, Phi = [h.mean for h in forces], [h.oscillation for h in forces]
    for force, v in zip(slow, velocities, strict=True):
        if not is_identically_zero(sp.diff(_without_slow_functions(force, fast), fast, TIME)):
            raise WuchtError(
                f"{fast} t occurs outside of sines and cosines in the force on {v}: such a secular term has no mean",
                code="secular",
            )
    if not any(h.frequencies for h in forces):
        raise WuchtError(f"no force turns with {fast} t: there is no fast part to be separated", code="no-fast-force")
    _refuse_large(forces, fast, velocities, system)
    rate = tuple(h.antiderivative / fast for h in forces)
    xi = tuple(trigonometric_polynomial(r, THETA).antiderivative / fast for r in rate)
    moving, change = (*positions, *velocities), (*xi, *rate)
    shift = {v: v + r for v, r in zip(velocities, rate, strict=True)}
    means = []
    for v, a, phi in zip(velocities, slow, Phi, strict=True):
        with error_context(f"the mean force on {v} cannot be computed"):
            means.append(mean(a.xreplace(shift), THETA) + mean(directional_derivative(phi, moving, change), THETA))
    lines, outputs = restore_fast_part(
        system, {s: s + e.xreplace({THETA: fast * TIME}) for s, e in zip(moving, change, strict=True)}
    )
    accelerations = dict(zip(velocities, means, strict=True))
    slow_system = replace(
        system,
        derivatives=tuple(accelerations.get(s, f) for s, f in zip(system.states, system.derivatives, strict=True)),
        definitions=lines,
        outputs=outputs,
        quadratures=tuple(_quadrature(q, system, fast, shift) for q in system.quadratures),
        second_order=None,
    )
    m = sp.eye(len(positions)) if mass is None else sp.Matrix(mass)
    vibration = [sp.expand(a - f) for a, f in zip(means, slow, strict=True)]
    return Separation(slow_system, xi, rate, *(tuple(m * sp.Matrix(f)) for f in (slow, Phi, vibration)))


def _velocities(system: System, positions: Sequence[sp.Symbol]) -> list[sp.Symbol]:
    """The states that are the rates of the positions."""
    rate = dict(zip(system.states, system.derivatives, strict=True))
    unknown = [p.name for p in positions if p not in rate]
    if unknown:
        raise WuchtError(f"{', '.join(unknown)} is not a state; known: {', '.join(system.state_names)}", code="no-state")
    velocities = [rate[p] for p in positions]
    if sorted(map(str, [*positions, *velocities])) != sorted(map(str, system.states)):
        raise WuchtError(
            f"the rates of {', '.join(map(str, positions))} are not the other states: no form m x'' = F + Phi",
            code="other-states",
        )
    return velocities


def _substitute_theta(e: sp.Expr, fast: sp.Symbol, subject: sp.Symbol) -> sp.Expr:
    """The expression with theta for k t in the arguments of its functions."""
    moving = {a for a in e.atoms(sp.sin, sp.cos, sp.exp) if {fast, TIME} <= a.args[0].free_symbols}
    replacements, innermost = {}, [a for a in moving if not a.args[0].atoms(sp.sin, sp.cos, sp.exp) & moving]
    for a in innermost:
        argument = sp.expand(a.args[0])
        slope = sp.diff(argument, fast, TIME)
        rest = sp.expand(argument - slope * fast * TIME)
        if slope.free_symbols or fast in rest.free_symbols:
            raise WuchtError(
                f"{a} in the force on {subject} is not a function of {fast} t and slow quantities", code="not-fast"
            )
        if not slope.is_Integer and not (isinstance(a, sp.exp) and (slope / sp.I).is_Integer):
            raise WuchtError(f"{a} in the force on {subject} does not have the period 2 pi in {fast} t", code="other-period")
        replacements[a] = a.func(slope * THETA + rest)
    result = e.xreplace(replacements)
    for a in sp.preorder_traversal(_without_slow_functions(result, fast)):
        whole = a.is_Pow and a.exp.is_Integer and a.exp.is_nonnegative
        if {fast, TIME} <= a.free_symbols and not (a.is_Add or a.is_Mul or whole or a.is_Symbol):
            raise WuchtError(
                f"{a} in the force on {subject} may vary with {fast} t, and is not a sine, cosine or exponential of it",
                code="not-trigonometric",
            )
    return result


def _without_slow_functions(e: sp.Expr, fast: sp.Symbol) -> sp.Expr:
    """The expression with a symbol for each function of time that does not hold k."""
    return e.xreplace(
        {a: sp.Dummy() for a in e.atoms(sp.Function, sp.exp) if TIME in a.free_symbols and fast not in a.free_symbols}
    )


def _refuse_large(
    quick: Sequence[TrigonometricPolynomial], fast: sp.Symbol, velocities: Sequence[sp.Symbol], system: System
) -> None:
    """Raises ``WuchtError`` where Phi grows faster with k than (5) allows."""
    with_speed = any({*velocities} & w.oscillation.free_symbols for w in quick)
    small = {*system.parameters} - {fast}
    for v, waves in zip(velocities, quick, strict=True):
        for c in (c for pair in waves.turning.values() for c in pair if c != 0):
            power, leading = _growth(c, fast, v)
            beyond = power - (0 if with_speed else 1)
            if beyond > 1 or (beyond > 0 and not leading.free_symbols & small):
                limit = "O(1), as it depends on a speed" if with_speed else f"O({fast})"
                raise WuchtError(
                    f"the fast force on {v} grows like {fast}^{power} ({c}): it may be {limit}, or one power more with a "
                    f"small parameter O(1/{fast}), written as a symbol. Otherwise its motion is not small: no separation holds",
                    code="grows",
                )


def _growth(c: sp.Expr, fast: sp.Symbol, subject: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """The power of k with which an amplitude grows, and the factor of that power."""
    growth = []
    for part in sp.fraction(sp.together(c)):
        terms = [a.as_coeff_exponent(fast) for a in sp.Add.make_args(sp.expand(part))]
        if any(fast in a.free_symbols for a, _ in terms) or not all(p.is_real and p.is_number for _, p in terms):
            raise WuchtError(
                f"how the fast force on {subject} grows with {fast} does not follow from {c}: must be powers of {fast}",
                code="growth-unclear",
            )
        top = max(p for _, p in terms)
        growth.append((top, sp.Add(*(a for a, p in terms if p == top))))
    (above, a), (below, b) = growth
    return above - below, a / b


def _quadrature(q: Output, system: System, fast: sp.Symbol, shift: dict[sp.Symbol, sp.Expr]) -> Output:
    """A quadrature with the mean of its rate at the speeds X' + xi', to leading order."""
    rate, jump = (
        _substitute_theta(sp.sympify(system.explicit(e)), fast, sp.Symbol(q.name)).xreplace(shift)
        for e in (q.expression, q.jump)
    )
    if THETA in jump.free_symbols:
        raise WuchtError(f"the jumps of {q.name} depend on {fast} t: they have no mean", code="jumps")
    return replace(q, expression=mean(rate, THETA), jump=jump)
