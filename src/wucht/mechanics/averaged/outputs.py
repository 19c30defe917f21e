"""Outputs of the averaged equations: amplitudes, fluctuations, torques, and works that balance."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from wucht.mechanics.averaged.bodies import RotatingBodies, absolute
from wucht.mechanics.averaged.explicit_form import Solution, weights_of
from wucht.mechanics.phasors import TURN, ZERO, Lines, Phasor, product
from wucht.system import Output

ROTOR_ANGLE, SUPPLIED, LOST, SHAKEN = "rotor_angle", "supplied_work", "dissipated_work", "vibration_work"


def outputs_of(bodies: RotatingBodies, lines: Lines, solution: Solution) -> tuple[list[Output], list[Output]]:
    """Outputs and quadratures, as ``AveragedSystem`` lists them; definitions are added to the lines.

    The powers' integrals balance the change of the stored energy. Without inertia all work at the speed of their rotor, each
    body with its weight: so the first order balances exactly.
    """
    torques, every = solution.torques, range(len(bodies.names))
    follows = every if solution.inertia else bodies.heads
    v, rates = (sp.Matrix([column[i] for i in follows]) for column in (solution.speeds, solution.accelerations))
    weights, inner = [sp.S.One] * len(every), bodies.relative * v
    if not solution.inertia:
        weights = [weights_of(bodies, bodies.group(h))[i] for i, h in enumerate(bodies.heads)]
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
