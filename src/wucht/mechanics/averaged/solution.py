"""The averaged equations solved for their rates, with the inertia of the balancing bodies or strongly damped; outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaged.bodies import RotatingBodies, absolute, named, rate_of_given
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import TURN, ZERO, Lines, Phasor, product
from wucht.system import Output

Rows = tuple[tuple[sp.Expr, sp.Expr], ...]
ExplicitForm = tuple[list[sp.Expr], list[sp.Expr], Rows]
"""Speeds theta_i' and accelerations theta_i'' of all bodies (n), and the rows they come from."""
ROTOR_ANGLE, SUPPLIED, LOST, SHAKEN = "rotor_angle", "supplied_work", "dissipated_work", "vibration_work"


@dataclass(frozen=True)
class Solution:
    """The averaged equations solved: displacement amplitudes z of the carrier (m), and of the bodies (n) the vibration torques,
    speeds theta' and accelerations theta''; the rows they come from. inertia: the balancing bodies keep theirs.
    """

    motion: Sequence[Phasor]
    torques: Sequence[sp.Expr]
    speeds: list[sp.Expr]
    accelerations: list[sp.Expr]
    rows: Rows
    inertia: bool


def with_inertia(bodies: RotatingBodies, lines: Lines, torques: Sequence[sp.Expr]) -> ExplicitForm:
    """Solve J theta'' + B theta' = L + V."""
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
    """Solve for w' of each rotor and nu = theta' - w of its bodies."""
    names, j = bodies.names, bodies.inertia
    speeds, accelerations, rows = dict[int, sp.Expr](), dict[int, sp.Expr](), list[tuple[sp.Expr, sp.Expr]]()
    for head in bodies.rotors:
        group, w = bodies.group(head), bodies.speed(head)
        others, speeds[head] = group[1:], w
        weights = _weights_of(bodies, group)
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


def _weights_of(bodies: RotatingBodies, group: Sequence[int]) -> dict[int, sp.Expr]:
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


def outputs_of(bodies: RotatingBodies, lines: Lines, solution: Solution) -> tuple[list[Output], list[Output]]:
    """Outputs and quadratures, as ``AveragedSystem`` lists them; definitions are added to the lines.

    The powers' integrals balance the change of the stored energy. Without inertia the powers of bodies are taken at
    the speed of their rotor, each with its weight: so the first order balances exactly.
    """
    torques, every = solution.torques, range(len(bodies.names))
    follows = every if solution.inertia else bodies.heads
    v, rates = (sp.Matrix([column[i] for i in follows]) for column in (solution.speeds, solution.accelerations))
    weights, inner = [sp.S.One] * len(every), bodies.relative * v
    if not solution.inertia:
        weights = [_weights_of(bodies, bodies.group(h))[i] for i, h in enumerate(bodies.heads)]
        inner = sp.zeros(len(every), 1)
    drives = [bodies.drive[i](v[i]) for i in every]
    if bodies.given is not None:
        pushed = bodies.inertia * rates + inner
        members = [0] if solution.inertia else bodies.group(0)
        missing = [weights[i] * (pushed[i] - absolute(bodies, i, v[i]) - torques[i]) for i in members]
        drives[0] += lines.name(sp.Add(*missing), "reaction")
    powers = {SUPPLIED: drives, LOST: [bodies.losses[i](v[i]) + inner[i] for i in every], SHAKEN: [-t for t in torques]}
    stored = sp.Add(*(weights[i] * bodies.inertia[i, k] * v[i] * v[k] / 2 for i in every for k in every))
    outputs = [
        Output("amplitude", _largest_radius(bodies, lines, solution.motion)),
        *parts("amplitude", bodies.labels, solution.motion),
        *(Output(f"vibration_torque[{name}]", t) for name, t in zip(bodies.names, torques, strict=True)),
        *(Output(f"speed[{name}]", s) for name, s in zip(bodies.names, solution.speeds, strict=True)),
        Output("motor_torque", drives[0]),
        Output("stored_energy", stored),
    ]
    works = [Output(name, sp.Add(*(p * v[i] * weights[i] for i, p in enumerate(each)))) for name, each in powers.items()]
    return outputs, [Output(ROTOR_ANGLE, solution.speeds[0], "rad", "angle of the main rotor"), *works]


def parts(what: str, names: Sequence[str], amplitudes: Sequence[Phasor]) -> list[Output]:
    """An output for the real and the imaginary part of each amplitude."""
    named = list(zip(names, amplitudes, strict=True))
    return [Output(f"{what}.{part}[{n}]", value) for n, a in named for part, value in (("re", a.re), ("im", a.im))]


def _largest_radius(bodies: RotatingBodies, lines: Lines, motion: Sequence[Phasor]) -> sp.Expr:
    """The semi-major axis of the orbit: the sum of the circles it runs through counter-clockwise and clockwise."""
    at = [product([Phasor(a) for a in bodies.axis.row(k)], motion) for k in range(bodies.axis.rows)]
    x, y = [lines.phasor(p, f"axis[{k}]") for k, p in enumerate([*at, ZERO, ZERO][:2])]
    return sp.Add(*(sp.sqrt(c.re**2 + c.im**2) for c in ((x + y * TURN) * sp.S.Half, (x - y * TURN) * sp.S.Half)))
