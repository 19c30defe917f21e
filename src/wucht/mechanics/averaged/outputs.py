"""Outputs of the averaged equations: amplitudes, fluctuations, torques, and works that balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.averaged.bodies import RotatingBodies, absolute
from wucht.mechanics.averaged.explicit_form import Solution, weights_of
from wucht.mechanics.averaged.ripple import Ripple
from wucht.mechanics.phasors import ZERO, Lines, Phasor, product
from wucht.system import Output

ROTOR_ANGLE, SUPPLIED, LOST, SHAKEN = "rotor_angle", "supplied_work", "dissipated_work", "vibration_work"


def outputs_of(bodies: RotatingBodies, lines: Lines, solution: Solution) -> tuple[list[Output], list[Output]]:
    """Outputs and quadratures, as ``AveragedSystem`` lists them; definitions are added to the lines."""
    works = _works(bodies, lines, solution)
    outputs = [Output("amplitude", _largest_radius(bodies, lines, solution.motion))]
    outputs += _parts("amplitude", bodies.labels, solution.motion)
    for what, values in (("vibration_torque", solution.torques), ("speed", solution.explicit.speeds)):
        outputs += [Output(f"{what}[{name}]", v) for name, v in zip(bodies.names, values, strict=True)]
    outputs += [Output("motor_torque", works.motor), Output("stored_energy", works.stored)]
    angle = Output(ROTOR_ANGLE, solution.explicit.speeds[0], "rad", "angle of the main rotor")
    return outputs, [angle, *(Output(name, power) for name, power in works.powers.items())]


def ripple_outputs(bodies: RotatingBodies, pulsing: Ripple) -> list[Output]:
    """The fluctuation of the bodies, as ``AveragedSystem.fast`` lists it."""
    return [*_parts("gravity", bodies.names, pulsing.once), *_parts("ripple", bodies.names, pulsing.twice)]


def _parts(what: str, names: Sequence[str], amplitudes: Sequence[Phasor]) -> list[Output]:
    named = list(zip(names, amplitudes, strict=True))
    return [Output(f"{what}.{part}[{n}]", value) for n, a in named for part, value in (("re", a.re), ("im", a.im))]


@dataclass(frozen=True)
class _Works:
    """Torque of the main rotor's motor, energy of rotation, and the powers whose integrals balance its change."""

    motor: sp.Expr
    stored: sp.Expr
    powers: dict[str, sp.Expr]


def _works(bodies: RotatingBodies, lines: Lines, solution: Solution) -> _Works:
    """Without inertia all work at the speed of their rotor, each body with its weight: so the first order balances exactly."""
    torques, explicit, inertia = solution.torques, solution.explicit, solution.inertia
    n, j, every = len(bodies.names), bodies.inertia, range(len(bodies.names))
    speeds = explicit.speeds if inertia else [bodies.speed(h) for h in bodies.heads]
    rates = explicit.accelerations if inertia else [explicit.accelerations[h] for h in bodies.heads]
    weights = [sp.S.One] * n
    if not inertia:
        weights = [weights_of(bodies, bodies.group(h))[i] for i, h in enumerate(bodies.heads)]
    inner = [sp.Add(*(bodies.relative[i, k] * speeds[k] for k in every)) if inertia else sp.S.Zero for i in every]
    drives = [bodies.drive[i](speeds[i]) for i in every]
    if bodies.given is not None:
        members = [0] if inertia else bodies.group(0)
        missing = [
            weights[i] * (sp.Add(*(j[i, k] * rates[k] for k in every)) - absolute(bodies, i, speeds[i]) - torques[i] + inner[i])
            for i in members
        ]
        drives[0] += lines.name(sp.Add(*missing), "reaction")
    powers = {
        SUPPLIED: [d * v * m for d, v, m in zip(drives, speeds, weights, strict=True)],
        LOST: [(bodies.losses[i](speeds[i]) + inner[i]) * speeds[i] * weights[i] for i in every],
        SHAKEN: [-t * v * m for t, v, m in zip(torques, speeds, weights, strict=True)],
    }
    stored = [weights[i] * j[i, k] * speeds[i] * speeds[k] / 2 for i in every for k in every]
    return _Works(drives[0], sp.Add(*stored), {name: sp.Add(*terms) for name, terms in powers.items()})


def _largest_radius(bodies: RotatingBodies, lines: Lines, motion: Sequence[Phasor]) -> sp.Expr:
    """The semi-major axis of the orbit: the sum of the circles it runs through counter-clockwise and clockwise."""
    at = [product([Phasor(a) for a in bodies.axis.row(k)], motion) for k in range(bodies.axis.rows)]
    x, y = [lines.phasor(p, f"axis[{k}]") for k, p in enumerate([*at, ZERO, ZERO][:2])]
    circles = ((x + y.turned.scaled(sense)).scaled(sp.S.Half) for sense in (sp.S.One, -sp.S.One))
    return sp.Add(*(sp.sqrt(c.re**2 + c.im**2) for c in circles))
