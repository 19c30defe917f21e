"""Excitation of the carrier by the bodies, the vibration torques on them, and their fluctuation within a turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.phasors import IMAGINARY_UNIT, ZERO, HarmonicResponse, Lines, Phasor, dynamic_stiffness, product
from wucht.mechanics.rotating_bodies.bodies import RotatingBodies, absolute_torque_slope


class Coupling:
    """Excitation and response: exp(i alpha_i), the moments S = sum E_k exp(i alpha_k), and the response H(w).

    Their definitions are added to the lines. free: the coordinates whose motion is not prescribed.
    """

    def __init__(self, bodies: RotatingBodies, lines: Lines) -> None:
        self.bodies, self.lines = bodies, lines
        angles = [bodies.total_phase(i) for i in range(len(bodies.names))]
        self.direction = tuple(
            Phasor(lines.name(sp.cos(a), f"cos[{n}]"), lines.name(sp.sin(a), f"sin[{n}]"))
            for a, n in zip(angles, bodies.names, strict=True)
        )
        self.free = free = [d for d in range(len(bodies.labels)) if bodies.shaking is None or d != bodies.shaking.index]
        names = [bodies.labels[d] for d in free]
        self.moments = lines.phasors([product([e[d] for e in bodies.excitation], self.direction) for d in free], "S", names)
        M, C, K = (a.extract(free, free) for a in (bodies.mass, bodies.damping, bodies.stiffness))
        self.response = HarmonicResponse(M, C, K, bodies.frequency, names, lines)

    def motion(self, force: Sequence[Phasor] | np.ndarray, mark: str) -> list[Phasor]:
        """The displacement amplitudes z of all coordinates (m) for force amplitudes on the free ones."""
        b, label = self.bodies, f"z{mark}"
        if b.shaking is None:
            return list(self.response(force, label))
        p, x = b.shaking.index, b.shaking.amplitude
        net_force = [
            f - dynamic_stiffness(b.mass[d, p], b.damping[d, p], b.stiffness[d, p], b.frequency) * x
            for f, d in zip(force, self.free, strict=True)
        ]
        displacements = self.response(net_force, label)
        return [*displacements[:p], Phasor(x), *displacements[p:]]

    def torques(self, motion: Sequence[Phasor] | np.ndarray, mark: str, factor: sp.Expr | None = None) -> list[sp.Expr]:
        """The vibration torques V_i (n) of displacements z; of accelerations Z with the factor -1/2."""
        torques, factor = list[sp.Expr](), self.bodies.frequency**2 / 2 if factor is None else factor
        for e, c, name in zip(self.bodies.excitation, self.direction, self.bodies.names, strict=True):
            back = product([x.conj for x in e], motion)
            torques.append(self.lines.name(factor * (c.re * back.im - c.im * back.re), f"V{mark}[{name}]"))
        return torques

    def alternating(self, motion: Sequence[Phasor]) -> list[Phasor]:
        """The torques' amplitudes T_i (n) at twice the speed: Re[T_i exp(2 i theta)], 001 (26), (41), (54), (61)."""
        half = IMAGINARY_UNIT * (self.bodies.frequency**2 / 2)
        return [product(e, motion) * c * half for e, c in zip(self.bodies.excitation, self.direction, strict=True)]


def _is_round(bodies: RotatingBodies) -> bool:
    """True if no torque at twice the speed arises: two equal directions x and y that all bodies excite as (1, -i)."""
    if len(bodies.labels) != 2 or bodies.shaking is not None:
        return False
    alike = all(a[0, 0] == a[1, 1] and a[0, 1] == 0 and a[1, 0] == 0 for a in (bodies.mass, bodies.damping, bodies.stiffness))
    return alike and all(e[1] == e[0] * IMAGINARY_UNIT * -1 for e in bodies.excitation)


@dataclass(frozen=True)
class Ripple:
    """The bodies' fluctuation psi_i = Re[once_i exp(i theta) + twice_i exp(2 i theta)], and the torques that cause it."""

    once: list[Phasor]
    twice: list[Phasor]
    weight: list[Phasor]
    alternating: list[Phasor]


def ripple(bodies: RotatingBodies, coupling: Coupling, motion: Sequence[Phasor]) -> Ripple:
    """J psi'' + k psi' = Re[weight exp(i theta) + T exp(2 i theta)]: 001 (26), (41), (54), (61), and gravity.

    k holds the dampers and the slopes of the drives. T is zero where all directions are equal.
    """
    nothing = [ZERO] * len(bodies.names)
    alternating = nothing if _is_round(bodies) else coupling.alternating(motion)
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
    torque_slopes = sp.diag(*(absolute_torque_slope(bodies, i, bodies.speed(h)) for i, h in enumerate(bodies.heads)))
    inertia, damping = (sp.Matrix(a.extract(free, free)) for a in (bodies.inertia, bodies.relative - torque_slopes))
    if damping != damping.T:
        raise WuchtError("dampers that are not reciprocal: the fluctuation within a turn is not computed for them")
    # Solved for the velocities i times w P, whose matrix k + i times w J is regular at rest where the drives have a slope.
    massless = sp.zeros(len(free), len(free))
    response = HarmonicResponse(massless, inertia, damping, times * w, names, coupling.lines, f"Q{times}")
    velocities = response(coupling.lines.phasors([torque[i] for i in free], cause, names), f"{label}'")
    fluctuations = velocities * IMAGINARY_UNIT * (-1 / (times * w ** (2 - times)))
    amplitudes = dict(zip(free, coupling.lines.phasors(fluctuations, label, names), strict=True))
    return [amplitudes.get(i, ZERO) for i in range(n)]
