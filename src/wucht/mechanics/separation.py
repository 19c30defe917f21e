"""The direct separation of motions: 001 (1)-(7), after Kapitza and Blekhman.

    m x'' = F(x', x, t) + Phi(x', x, t, k t),  k >> 1,    x(t) = X(t) + xi(t, theta),  theta = k t,  <xi> = 0 (3).

With X', X, t held (7) is solved to leading order in 1/k: m k^2 d2xi/dtheta2 = Phi - <Phi>. Then (5), with xi of the order
Phi/k^2 and its rate of the order Phi/k: F at the speed X' + xi', and Phi to first order in xi and xi',

    m X'' = <F(X' + xi', X, t)> + <Phi> + <(dPhi/dx) xi + (dPhi/dx') xi'>   (6).

Where Phi does not depend on the speed it may be as large as O(k); else it must be O(1), and terms O(1/k^2) are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaging import put_back
from wucht.mechanics.means import harmonics, mean
from wucht.system import TIME, Output, System

THETA = sp.Symbol("theta_fast", real=True)
"""The fast time theta = k t in the expressions of a ``Separation``."""


@dataclass(frozen=True)
class Separation:
    """What direct separation gave; X and X' keep the symbols of the states.

    system: X' and X'' as a System, with outputs ``full.<state>`` of X + xi, X' + xi'. fast: xi(X', X, t, theta), and rate: its
    time derivative k d xi/d theta (n each). slow_force: F, fast_force: Phi. vibration_force: what the mean of all forces has
    more than F: the vibrational force. All forces n each, m x'' as in (1): times the mass, where one was given.
    """

    system: System
    fast: tuple[sp.Expr, ...]
    rate: tuple[sp.Expr, ...]
    slow_force: tuple[sp.Expr, ...]
    fast_force: tuple[sp.Expr, ...]
    vibration_force: tuple[sp.Expr, ...]


def separated(system: System, positions: Sequence[sp.Symbol], fast: sp.Symbol, mass: sp.Matrix | None = None) -> Separation:
    """Separate the motions of a System of second order.

    positions: n of its states, whose rates are n other states, and which with them are all states. fast: the parameter k:
    what turns with k t is fast; t elsewhere is slow. mass: m, n x n and constant, by which forces are told from
    accelerations (1 if left out). The acceleration's terms that turn with k t are Phi, the others F.

    Raises ``WuchtError`` with the reason where the System has no such form, nothing turns with k t, something turns with
    another multiple of it than a whole one, or a mean does not exist or was not found.
    """
    velocities = _velocities(system, positions)
    explicit = {s: sp.sympify(system.explicit(f)) for s, f in zip(system.states, system.derivatives, strict=True)}
    slow, quick = [], []
    for v in velocities:
        waves = harmonics(_in_theta(explicit[v], fast, v), THETA)
        slow.append(waves.mean)
        quick.append(waves)
    if not any(w.frequencies for w in quick):
        raise WuchtError(f"no force turns with {fast} t: there is no fast part to be separated")
    rate = tuple(w.antiderivative / fast for w in quick)
    xi = tuple(harmonics(r, THETA).antiderivative / fast for r in rate)
    shift = {v: v + r for v, r in zip(velocities, rate, strict=True)}
    Phi = [w.oscillation for w in quick]
    means = []
    for v, a, phi in zip(velocities, slow, Phi, strict=True):
        first = [sp.diff(phi, p) * e for p, e in zip(positions, xi, strict=True)]
        first += [sp.diff(phi, q) * e for q, e in zip(velocities, rate, strict=True)]
        try:
            means.append(mean(a.xreplace(shift), THETA) + mean(sp.Add(*first), THETA))
        except WuchtError as error:
            raise type(error)(f"the mean force on {v} was not found: {error}") from error
    turned = {THETA: fast * TIME}
    full = {p: p + e.xreplace(turned) for p, e in zip(positions, xi, strict=True)}
    full |= {v: v + r.xreplace(turned) for v, r in zip(velocities, rate, strict=True)}
    lines, outputs = put_back(system, full)
    found = dict(zip(velocities, means, strict=True))
    done = System(
        states=system.states,
        derivatives=tuple(found.get(s, system.derivatives[i]) for i, s in enumerate(system.states)),
        parameters=system.parameters,
        definitions=lines,
        outputs=outputs,
        quadratures=tuple(_quadrature(q, system, fast, shift) for q in system.quadratures),
        angles=system.angles,
    )
    m = sp.eye(len(positions)) if mass is None else sp.Matrix(mass)
    vibration = [sp.expand(a - f) for a, f in zip(means, slow, strict=True)]
    return Separation(done, xi, rate, *(tuple(m * sp.Matrix(f)) for f in (slow, Phi, vibration)))


def _velocities(system: System, positions: Sequence[sp.Symbol]) -> list[sp.Symbol]:
    """The states that are the rates of the positions."""
    rate = dict(zip(system.states, system.derivatives, strict=True))
    unknown = [p.name for p in positions if p not in rate]
    if unknown:
        raise WuchtError(f"{', '.join(unknown)} is no state: {', '.join(system.state_names)}")
    found = [rate[p] for p in positions]
    if sorted(map(str, [*positions, *found])) != sorted(map(str, system.states)):
        raise WuchtError(f"the rates of {', '.join(map(str, positions))} are not the other states: no form m x'' = F + Phi")
    return found


def _in_theta(e: sp.Expr, fast: sp.Symbol, what: sp.Symbol) -> sp.Expr:
    """The expression with theta for k t in the arguments of its functions."""
    moving = {a for a in e.atoms(sp.sin, sp.cos, sp.exp) if {fast, TIME} <= a.args[0].free_symbols}
    moving = {
        a for a in moving if not a.args[0].atoms(sp.sin, sp.cos, sp.exp) & moving
    }  # of functions within others: the inner
    turned = {}
    for a in moving:
        argument = sp.expand(a.args[0])
        slope = sp.diff(argument, fast, TIME)
        rest = sp.expand(argument - slope * fast * TIME)
        if slope.free_symbols or fast in rest.free_symbols:
            raise WuchtError(f"{a} in the force on {what} is no function of {fast} t and slow quantities")
        if not slope.is_Integer and not (isinstance(a, sp.exp) and (slope / sp.I).is_Integer):
            raise WuchtError(f"{a} in the force on {what} has not the period 2 pi in {fast} t")
        turned[a] = a.func(slope * THETA + rest)
    return e.xreplace(turned)


def _quadrature(q: Output, system: System, fast: sp.Symbol, shift: dict[sp.Symbol, sp.Expr]) -> Output:
    """A quadrature with the mean of its rate at the speeds X' + xi', to leading order."""
    rate = _in_theta(sp.sympify(system.explicit(q.expression)), fast, sp.Symbol(q.name)).xreplace(shift)
    return Output(q.name, mean(rate, THETA), q.unit, q.long_name, system.explicit(q.jump))
