"""The averaged equations solved for their rates, with the inertia of the balancing bodies or strongly damped; outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import IMAGINARY_UNIT, ZERO, Lines, Phasor, product
from wucht.mechanics.rotating_bodies.bodies import RotatingBodies, absolute_torque, body_symbol, fixed_speed_rate
from wucht.system import Output

Rows = tuple[tuple[sp.Expr, sp.Expr], ...]
ExplicitForm = tuple[list[sp.Expr], list[sp.Expr], Rows]
"""Speeds theta_i' and accelerations theta_i'' of all bodies (n), and the rows they come from."""
ROTOR_ANGLE, SUPPLIED_WORK, DISSIPATED_WORK, VIBRATION_WORK = (
    "rotor_angle",
    "supplied_work",
    "dissipated_work",
    "vibration_work",
)


@dataclass(frozen=True)
class AveragedSolution:
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
    names, j, free, fixed_rate = bodies.names, bodies.inertia, bodies.free, fixed_speed_rate(bodies)
    speeds = [bodies.speed(i) for i in range(len(names))]
    inner = bodies.relative * sp.Matrix(speeds)
    rows = [
        (
            sp.Add(*(j[i, k] * body_symbol(names[k], "speed.rate") for k in free)),
            absolute_torque(bodies, i, speeds[i]) - inner[i] + torques[i] - (j[i, 0] * fixed_rate if 0 not in free else 0),
        )
        for i in free
    ]
    solution = solve_by_elimination(j.extract(free, free), [r for _, r in rows], [names[i] for i in free], lines, "theta'' ")
    accelerations = dict(zip(free, solution, strict=True))
    return speeds, [accelerations.get(i, fixed_rate) for i in range(len(names))], tuple(rows)


def without_inertia(bodies: RotatingBodies, lines: Lines, torques: Sequence[sp.Expr]) -> ExplicitForm:
    """Solve for w' of each rotor and nu = theta' - w of its bodies."""
    names, j = bodies.names, bodies.inertia
    speeds, accelerations, rows = dict[int, sp.Expr](), dict[int, sp.Expr](), list[tuple[sp.Expr, sp.Expr]]()
    for head in bodies.rotors:
        group, w = bodies.group(head), bodies.speed(head)
        followers, speeds[head] = group[1:], w
        weights = _weights_of(bodies, group)
        loads = {i: absolute_torque(bodies, i, w) + torques[i] for i in group}
        total = {i: sp.Add(*(j[i, k] for k in group)) for i in group}
        rate_symbol = rate = fixed_speed_rate(bodies)
        if head in bodies.free:
            effective = sp.Add(*(weights[i] * j[i, k] for i in group for k in group))
            total_torque = sp.Add(*(weights[i] * loads[i] for i in group))
            rate_symbol = body_symbol(names[head], "speed.rate")
            rows.append((effective * rate_symbol, total_torque))
            rate = lines.name(total_torque / effective, f"theta''[{names[head]}]")
        accelerations |= dict.fromkeys(group, rate)
        damping = sp.ImmutableMatrix(bodies.relative.extract(followers, followers))
        right = [loads[i] - total[i] * rate for i in followers]
        nu = solve_by_elimination(damping, right, [names[i] for i in followers], lines, "nu ")
        slips = sp.Matrix(len(followers), 1, [body_symbol(names[i], "slip") for i in followers])
        for i, slip, lhs in zip(followers, nu, damping * slips, strict=True):
            speeds[i] = w + lines.name(slip, f"nu[{names[i]}]")
            rows.append((lhs, loads[i] - total[i] * rate_symbol))
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


def outputs_of(bodies: RotatingBodies, lines: Lines, solution: AveragedSolution) -> tuple[list[Output], list[Output]]:
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
    if bodies.fixed_speed is not None:
        inertia_torques = bodies.inertia * rates + inner
        members = [0] if solution.inertia else bodies.group(0)
        missing = [weights[i] * (inertia_torques[i] - absolute_torque(bodies, i, v[i]) - torques[i]) for i in members]
        drives[0] += lines.name(sp.Add(*missing), "reaction")
    powers = {
        SUPPLIED_WORK: drives,
        DISSIPATED_WORK: [bodies.losses[i](v[i]) + inner[i] for i in every],
        VIBRATION_WORK: [-t for t in torques],
    }
    stored_energy = sp.Add(*(weights[i] * bodies.inertia[i, k] * v[i] * v[k] / 2 for i in every for k in every))
    outputs = [
        Output("amplitude", _largest_radius(bodies, lines, solution.motion)),
        *complex_outputs("amplitude", bodies.labels, solution.motion),
        *(Output(f"vibration_torque[{name}]", t) for name, t in zip(bodies.names, torques, strict=True)),
        *(Output(f"speed[{name}]", s) for name, s in zip(bodies.names, solution.speeds, strict=True)),
        Output("motor_torque", drives[0]),
        Output("stored_energy", stored_energy),
    ]
    works = [
        Output(name, sp.Add(*(p * v[i] * weights[i] for i, p in enumerate(body_powers))))
        for name, body_powers in powers.items()
    ]
    return outputs, [Output(ROTOR_ANGLE, solution.speeds[0], "rad", "angle of the main rotor"), *works]


def complex_outputs(quantity: str, names: Sequence[str], amplitudes: Sequence[Phasor]) -> list[Output]:
    """An output for the real and the imaginary part of each amplitude."""
    named_amplitudes = list(zip(names, amplitudes, strict=True))
    return [
        Output(f"{quantity}.{part}[{n}]", value) for n, a in named_amplitudes for part, value in (("re", a.re), ("im", a.im))
    ]


def _largest_radius(bodies: RotatingBodies, lines: Lines, motion: Sequence[Phasor]) -> sp.Expr:
    """The semi-major axis of the orbit: the sum of the circles it runs through counter-clockwise and clockwise."""
    at = [product([Phasor(a) for a in bodies.axis.row(k)], motion) for k in range(bodies.axis.rows)]
    x, y = [lines.phasor(p, f"axis[{k}]") for k, p in enumerate([*at, ZERO, ZERO][:2])]
    return sp.Add(
        *(sp.sqrt(c.re**2 + c.im**2) for c in ((x + y * IMAGINARY_UNIT) * sp.S.Half, (x - y * IMAGINARY_UNIT) * sp.S.Half))
    )
