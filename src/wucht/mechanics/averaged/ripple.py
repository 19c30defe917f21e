"""The fast part of the bodies' rotation: its fluctuation within a turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaged.bodies import RotatingBodies, slope_of_absolute
from wucht.mechanics.averaged.coupling import Coupling, is_round
from wucht.mechanics.phasors import TURN, ZERO, HarmonicResponse, Phasor


@dataclass(frozen=True)
class Ripple:
    """The bodies' fluctuation psi_i = Re[once_i exp(i theta) + twice_i exp(2 i theta)], and the torques that cause it."""

    once: list[Phasor]
    twice: list[Phasor]
    weight: list[Phasor]
    alternating: list[Phasor]


def ripple(bodies: RotatingBodies, coupling: Coupling, motion: Sequence[Phasor]) -> Ripple:
    """J psi'' + k psi' = Re[weight exp(i theta) + T exp(2 i theta)]: 001 (26), (41), (54), (61), and gravity.

    k holds the dampers and the slopes of the drives. T is zero where all directions are alike.
    """
    nothing = [ZERO] * len(bodies.names)
    alternating = nothing if is_round(bodies) else coupling.alternating(motion)
    weight = [g * c for g, c in zip(bodies.weight or nothing, coupling.direction, strict=True)]
    over_w = [t * (1 / bodies.frequency) for t in alternating]  # T goes as w^2: there is no division by w at rest
    twice = _fluctuation(bodies, coupling, over_w, 2, "T", "P")
    return Ripple(_fluctuation(bodies, coupling, weight, 1, "W", "G"), twice, weight, alternating)


def _fluctuation(
    bodies: RotatingBodies, coupling: Coupling, torque: Sequence[Phasor], times: int, cause: str, label: str
) -> list[Phasor]:
    n, w, free = len(bodies.names), bodies.frequency, bodies.free
    if all(t.is_zero for t in torque):
        return [ZERO] * n
    names = [bodies.names[i] for i in free]
    own = sp.diag(*(slope_of_absolute(bodies, i, bodies.speed(h)) for i, h in enumerate(bodies.heads)))
    inertia, damping = (sp.Matrix(a.extract(free, free)) for a in (bodies.inertia, bodies.relative - own))
    if damping != damping.T:
        raise WuchtError("dampers that are not reciprocal: the fluctuation within a turn is not computed for them")
    # Solved for the velocities i times w P, whose matrix k + i times w J is regular at rest where the drives have a slope.
    massless = sp.zeros(len(free), len(free))
    response = HarmonicResponse(massless, inertia, damping, times * w, names, coupling.lines, f"Q{times}")
    velocities = response(coupling.lines.phasors([torque[i] for i in free], cause, names), f"{label}'")
    fluctuations = velocities * TURN * (-1 / (times * w ** (2 - times)))
    amplitudes = dict(zip(free, coupling.lines.phasors(fluctuations, label, names), strict=True))
    return [amplitudes.get(i, ZERO) for i in range(n)]
