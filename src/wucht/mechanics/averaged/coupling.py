"""Excitation of the carrier by the bodies, and the vibration torques on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.averaged.bodies import RotatingBodies
from wucht.mechanics.phasors import HarmonicResponse, Lines, Phasor, product


@dataclass(frozen=True)
class Coupling:
    """Excitation and response: exp(i alpha_i), the moments S = sum E_k exp(i alpha_k), and the response H(w)."""

    bodies: RotatingBodies
    lines: Lines
    direction: tuple[Phasor, ...]
    moments: tuple[Phasor, ...]
    response: HarmonicResponse
    free: tuple[int, ...]

    @classmethod
    def of(cls, bodies: RotatingBodies, lines: Lines) -> Coupling:
        """The coupling, with its definitions added to the lines."""
        angles = [bodies.total_phase(i) for i in range(len(bodies.names))]
        direction = tuple(
            Phasor(lines.name(sp.cos(a), f"cos[{n}]"), lines.name(sp.sin(a), f"sin[{n}]"))
            for a, n in zip(angles, bodies.names, strict=True)
        )
        free = tuple(d for d in range(len(bodies.labels)) if bodies.shaking is None or d != bodies.shaking.index)
        sums = [product([e[d] for e in bodies.excitation], direction) for d in free]
        moments = tuple(lines.phasors(sums, "S", [bodies.labels[d] for d in free]))
        at = [list(free), list(free)]
        names = [bodies.labels[d] for d in free]
        response = HarmonicResponse(
            bodies.mass.extract(*at), bodies.damping.extract(*at), bodies.stiffness.extract(*at), bodies.frequency, names, lines
        )
        return cls(bodies, lines, direction, moments, response, free)

    def motion(self, force: Sequence[Phasor], mark: str) -> list[Phasor]:
        """The displacement amplitudes z of all coordinates (m) for force amplitudes on the free ones."""
        b, w = self.bodies, self.bodies.frequency
        if b.shaking is None:
            return self.response(force, f"z{mark}")
        p, x = b.shaking.index, b.shaking.amplitude
        pushed = [
            f - Phasor(b.stiffness[d, p] - w**2 * b.mass[d, p], w * b.damping[d, p]).scaled(x)
            for f, d in zip(force, self.free, strict=True)
        ]
        displacements = self.response(pushed, f"z{mark}")
        return [*displacements[:p], Phasor(x), *displacements[p:]]

    def torques(self, motion: Sequence[Phasor], mark: str, acceleration: Sequence[Phasor] | None = None) -> list[sp.Expr]:
        """The vibration torques V_i (n) of displacements z, or of the acceleration amplitudes Z of all coordinates."""
        torques, w = list[sp.Expr](), self.bodies.frequency
        for i, (e, c) in enumerate(zip(self.bodies.excitation, self.direction, strict=True)):
            if acceleration is None:
                back, factor = product([x.conj for x in e], motion), w**2 / 2
            else:
                back, factor = product([x.conj for x in e], acceleration).scaled(-sp.S.One), sp.S.Half
            value = factor * (c.re * back.im - c.im * back.re)
            torques.append(self.lines.name(value, f"V{mark}[{self.bodies.names[i]}]") if value != 0 else sp.S.Zero)
        return torques

    def alternating(self, motion: Sequence[Phasor]) -> list[Phasor]:
        """The torques' amplitudes T_i (n) at twice the speed: Re[T_i exp(2 i theta)], 001 (26), (41), (54), (61)."""
        w = self.bodies.frequency
        return [
            (product(e, motion) * c).turned.scaled(w**2 / 2)
            for e, c in zip(self.bodies.excitation, self.direction, strict=True)
        ]


def is_round(bodies: RotatingBodies) -> bool:
    """Whether no torque at twice the speed arises: two equal directions x and y that all bodies excite as (1, -i)."""
    if len(bodies.labels) != 2 or bodies.shaking is not None:
        return False
    alike = all(a[0, 0] == a[1, 1] and a[0, 1] == 0 and a[1, 0] == 0 for a in (bodies.mass, bodies.damping, bodies.stiffness))
    return alike and all(e[1] == e[0].turned.scaled(-sp.S.One) for e in bodies.excitation)
