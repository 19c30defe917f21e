"""The averaged equations solved for their rates: with the inertia of the balancing bodies, or strongly damped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaged.bodies import RotatingBodies, absolute, rate_of, rate_of_given, slip_of
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import Lines, Phasor


@dataclass(frozen=True)
class ExplicitForm:
    """Speeds theta_i' and accelerations theta_i'' of all bodies (n), and the rows they come from."""

    speeds: list[sp.Expr]
    accelerations: list[sp.Expr]
    rows: tuple[tuple[sp.Expr, sp.Expr], ...]


@dataclass(frozen=True)
class Solution:
    """Displacement amplitudes z of the carrier (m), vibration torques (n), and the equations solved with them.

    inertia: whether that of the balancing bodies is kept.
    """

    motion: Sequence[Phasor]
    torques: Sequence[sp.Expr]
    explicit: ExplicitForm
    inertia: bool


def with_inertia(bodies: RotatingBodies, lines: Lines, torques: Sequence[sp.Expr]) -> ExplicitForm:
    """J theta'' + B theta' = L + V."""
    n, j = len(bodies.names), bodies.inertia
    speeds = [bodies.speed(i) for i in range(n)]
    free = [i for i in range(n) if i or bodies.given is None]
    given = rate_of_given(bodies)
    right = [
        absolute(bodies, i, speeds[i]) - sp.Add(*(bodies.relative[i, k] * speeds[k] for k in range(n))) + torques[i]
        for i in range(n)
    ]
    rows = [
        (sp.Add(*(j[i, k] * rate_of(bodies, k) for k in free)), right[i] - (j[i, 0] * given if given != 0 else 0)) for i in free
    ]
    definitions, solution = solve_by_elimination(
        sp.ImmutableMatrix(j.extract(free, free)), sp.ImmutableMatrix([r for _, r in rows]), [bodies.names[i] for i in free],
        "theta'' ",
    )  # fmt: skip
    lines.pairs += definitions
    accelerations = dict(zip(free, solution, strict=True))
    return ExplicitForm(speeds, [accelerations.get(i, given) for i in range(n)], tuple(rows))


def without_inertia(bodies: RotatingBodies, lines: Lines, torques: Sequence[sp.Expr]) -> ExplicitForm:
    """w' of each rotor and nu = theta' - w of its bodies."""
    n, j = len(bodies.names), bodies.inertia
    speeds, accelerations, rows = [sp.S.Zero] * n, [sp.S.Zero] * n, list[tuple[sp.Expr, sp.Expr]]()
    for head in bodies.rotors:
        group, w = bodies.group(head), bodies.speed(head)
        weights = weights_of(bodies, group)
        loads = {i: absolute(bodies, i, w) + torques[i] for i in group}
        effective = sp.Add(*(weights[i] * j[i, k] for i in group for k in group))
        rate = rate_of_given(bodies)
        if head or bodies.given is None:
            pushed = sp.Add(*(weights[i] * loads[i] for i in group))
            rows.append((effective * rate_of(bodies, head), pushed))
            rate = lines.name(pushed / effective, f"theta''[{bodies.names[head]}]")
        accelerations[head], speeds[head] = rate, w
        others = group[1:]
        if others:
            right = [loads[i] - sp.Add(*(j[i, k] for k in group)) * rate for i in others]
            damping = sp.ImmutableMatrix(bodies.relative.extract(others, others))
            definitions, nu = solve_by_elimination(damping, sp.ImmutableMatrix(right), [bodies.names[i] for i in others], "nu ")
            lines.pairs += definitions
            for k, i in enumerate(others):
                slip = lines.name(nu[k], f"nu[{bodies.names[i]}]")
                speeds[i], accelerations[i] = w + slip, rate
                left = sp.Add(*(damping[k, m] * slip_of(bodies, q) for m, q in enumerate(others)))
                turning = rate_of(bodies, head) if head or bodies.given is None else rate
                rows.append((left, loads[i] - sp.Add(*(j[i, q] for q in group)) * turning))
    return ExplicitForm(speeds, accelerations, tuple(rows))


def weights_of(bodies: RotatingBodies, group: Sequence[int]) -> dict[int, sp.Expr]:
    """m with m^T B = 0, m = 1 for the rotor: all 1 where the dampers' torques are each other's reactions."""
    b, head = bodies.relative, group[0]
    alone = all(b[i, k] == 0 for i in group[1:] for k in group[1:] if i != k)
    for i in group[1:]:
        if b[i, i] == 0:
            raise WuchtError(f"{bodies.names[i]} is not damped against {bodies.names[head]}: it keeps its inertia")
    if all(b[i, k] == b[k, i] for i in group for k in group):
        return dict.fromkeys(group, sp.S.One)
    if not alone:
        raise WuchtError("dampers between several bodies that are not reciprocal: these averaged equations keep their inertia")
    return {head: sp.S.One} | {i: -b[head, i] / b[i, i] for i in group[1:]}
