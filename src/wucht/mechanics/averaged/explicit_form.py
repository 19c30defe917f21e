"""The averaged equations solved for their rates: with the inertia of the balancing bodies, or strongly damped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaged.bodies import RotatingBodies, absolute, named, rate_of_given
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import Lines, Phasor

Rows = tuple[tuple[sp.Expr, sp.Expr], ...]
ExplicitForm = tuple[list[sp.Expr], list[sp.Expr], Rows]
"""Speeds theta_i' and accelerations theta_i'' of all bodies (n), and the rows they come from."""


@dataclass(frozen=True)
class Solution:
    """The averaged equations solved: displacement amplitudes z of the carrier (m), and of the bodies (n) the vibration torques,
    speeds theta' and accelerations theta''; the rows they come from. inertia: whether the balancing bodies keep theirs.
    """

    motion: Sequence[Phasor]
    torques: Sequence[sp.Expr]
    speeds: list[sp.Expr]
    accelerations: list[sp.Expr]
    rows: Rows
    inertia: bool


def with_inertia(bodies: RotatingBodies, lines: Lines, torques: Sequence[sp.Expr]) -> ExplicitForm:
    """J theta'' + B theta' = L + V."""
    names, j, free, given = bodies.names, bodies.inertia, bodies.free, rate_of_given(bodies)
    speeds = [bodies.speed(i) for i in range(len(names))]
    inner = bodies.relative * sp.Matrix(speeds)
    rows = [
        (
            sp.Add(*(j[i, k] * named(names[k], "speed.rate") for k in free)),
            absolute(bodies, i, speeds[i]) - inner[i] + torques[i] - (j[i, 0] * given if 0 not in free else 0),
        )
        for i in free
    ]
    solution = solve_by_elimination(j.extract(free, free), [r for _, r in rows], [names[i] for i in free], lines, "theta'' ")
    accelerations = dict(zip(free, solution, strict=True))
    return speeds, [accelerations.get(i, given) for i in range(len(names))], tuple(rows)


def without_inertia(bodies: RotatingBodies, lines: Lines, torques: Sequence[sp.Expr]) -> ExplicitForm:
    """w' of each rotor and nu = theta' - w of its bodies."""
    names, j = bodies.names, bodies.inertia
    speeds, accelerations, rows = dict[int, sp.Expr](), dict[int, sp.Expr](), list[tuple[sp.Expr, sp.Expr]]()
    for head in bodies.rotors:
        group, w = bodies.group(head), bodies.speed(head)
        others, speeds[head] = group[1:], w
        weights = weights_of(bodies, group)
        loads = {i: absolute(bodies, i, w) + torques[i] for i in group}
        total = {i: sp.Add(*(j[i, k] for k in group)) for i in group}
        written = rate = rate_of_given(bodies)
        if head in bodies.free:
            effective = sp.Add(*(weights[i] * j[i, k] for i in group for k in group))
            pushed = sp.Add(*(weights[i] * loads[i] for i in group))
            written = named(names[head], "speed.rate")
            rows.append((effective * written, pushed))
            rate = lines.name(pushed / effective, f"theta''[{names[head]}]")
        accelerations |= dict.fromkeys(group, rate)
        damping = sp.ImmutableMatrix(bodies.relative.extract(others, others))
        right = [loads[i] - total[i] * rate for i in others]
        nu = solve_by_elimination(damping, right, [names[i] for i in others], lines, "nu ")
        slips = sp.Matrix(len(others), 1, [named(names[i], "slip") for i in others])
        for i, slip, left in zip(others, nu, damping * slips, strict=True):
            speeds[i] = w + lines.name(slip, f"nu[{names[i]}]")
            rows.append((left, loads[i] - total[i] * written))
    every = range(len(names))
    return [speeds[i] for i in every], [accelerations[i] for i in every], tuple(rows)


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
