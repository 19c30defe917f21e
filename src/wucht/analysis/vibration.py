"""What the vibration does to the rotation at a steady speed: harmonic influence coefficients, in numbers.

With D(w) = K - w^2 M + i w C and the force F = sum_k U_k e_k exp(i alpha_k) the carrier moves by q = Re[z exp(i w t)],
D z = w^2 F; then D z' = 2 w F - D' z. It takes the power w^2 z^H C z / 2 out of the rotation: the vibration torque is
w z^H C z / 2. For one rotor on an isotropic carrier this is the second term of 002 (3.67).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.parts.base import Body
from wucht.machines.tree import RotatingBody
from wucht.numerics.zeros import crossings

CANCELLED = 1e-12  # share of the bodies' unbalances that is left where they cancel
_BEYOND = 10.0  # times the highest natural frequency there are no maxima any more
WithSlope = tuple[np.ndarray, np.ndarray]  # a function of the speed, and its derivative


@dataclass(frozen=True)
class Vibration:
    """M, C, K (m x m) of the free carrier and ``excitation`` U_i e_i (n x m, complex), in the machine's units.

    A body of sense sigma turns by phi_i = sigma (w t + alpha_i): those that turn clockwise excite with conj(U_i e_i).
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    excitation: np.ndarray

    @classmethod
    def of(cls, machine: Machine) -> Vibration:
        """The vibration of a machine at its parameter values."""
        shapes = machine.linear_carrier.excitation
        e = np.array(machine.evaluate(*(x for a in shapes for x in a)), complex).reshape(len(shapes), -1)
        clockwise = np.array([[sense_of(machine, body) < 0] for body in machine.bodies])
        return cls(*machine.matrices, np.where(clockwise, e.conj(), e))

    def only(self, index: Sequence[int]) -> Vibration:
        """The vibration that some of the bodies excite."""
        return replace(self, excitation=self.excitation[list(index)])

    def dynamic(self, w: np.ndarray) -> np.ndarray:
        """K - w^2 M + i w C (N, m, m) at speeds (N, 1, 1)."""
        # A trace of damping keeps the matrix regular at the natural frequency of an undamped direction.
        trace = 1e-14j * (np.abs(self.stiffness).max(initial=0.0) or 1.0) * np.eye(len(self.mass))
        return np.asarray(self.stiffness - w**2 * self.mass + 1j * w * self.damping + trace)

    @cached_property
    def poles(self) -> np.ndarray:
        """The poles (2m,) of the free vibration: lambda^2 M + lambda C + K is singular."""
        size = len(self.mass)
        if not size:
            return np.empty(0, complex)
        below = -np.linalg.solve(self.mass, np.hstack([self.stiffness, self.damping]))
        return np.linalg.eigvals(np.vstack([np.eye(size, 2 * size, size), below]))

    def solved(self, w: np.ndarray, right: np.ndarray, rise: np.ndarray | float = 0.0) -> WithSlope:
        """z (N, m, k) with D(w) z = right at speeds (N, 1, 1), and dz/dw. rise: d right/dw."""
        dynamic = self.dynamic(w)
        z = np.linalg.solve(dynamic, right)
        return z, np.linalg.solve(dynamic, rise - (1j * self.damping - 2 * w * self.mass) @ z)

    def force(self, phases: np.ndarray) -> np.ndarray:
        """F (m,) or (N, m) with the bodies at phases (n,) or (n, N), zero where their unbalances cancel."""
        each = np.moveaxis(self._pushing(phases), 0, -2)
        total = each.sum(axis=-2)
        return np.asarray(np.where(np.abs(total) > CANCELLED * np.abs(each).sum(axis=-2), total, 0.0))

    def _pushing(self, phases: np.ndarray) -> np.ndarray:
        """The force of each body (n, m) or (n, N, m)."""
        shapes = self.excitation if phases.ndim == 1 else self.excitation[:, None]
        return np.asarray(shapes * np.exp(1j * phases)[..., None])

    def turned(self, phases: np.ndarray, turning: np.ndarray) -> np.ndarray:
        """The derivative of F (N, m) where phases (n, N) change by ``turning`` (n, N)."""
        return np.asarray((1j * turning[..., None] * self._pushing(phases)).sum(axis=0))

    def response(self, speeds: np.ndarray, phases: np.ndarray, turning: np.ndarray | None = None) -> WithSlope:
        """The complex displacements z (N, m) at speeds (N,) with the bodies at phases (n,) or (n, N): q = Re[z exp(i w t)].

        turning: the derivatives (n, N) of the phases by the speed, if they change with it.
        """
        w, force = np.reshape(np.asarray(speeds, float), (-1, 1, 1)), self.force(phases)[..., None]
        rise = 2 * w * force
        if turning is not None:
            rise = rise + w**2 * self.turned(phases, turning)[..., None]
        z, slope = self.solved(w, w**2 * force, rise)
        return z[..., 0], slope[..., 0]

    def at_once(self, speeds: np.ndarray, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements and velocities (m,) of the steady vibration at one moment.

        speeds, phases: of the bodies (n,) then, counted in their senses; each keeps a speed of its own.
        """
        each = np.array([self.only([k]).response(speeds[[k]], phases[[k]])[0][0] for k in range(len(phases))])
        return each.sum(axis=0).real, (1j * speeds @ each).real

    def torque(self, speeds: np.ndarray, phases: np.ndarray, turning: np.ndarray | None = None) -> WithSlope:
        """The vibration torque on all bodies together, positive where it brakes, w z^H C z/2: 002 (2.79) with its factor M."""
        w, (z, dz) = np.asarray(speeds, float), self.response(speeds, phases, turning)
        square, cross = (np.einsum("ni,ij,nj->n", z.conj(), self.damping, other).real for other in (z, dz))
        return w * square / 2, square / 2 + w * cross

    def last_maximum(self, below: float | None, phases: np.ndarray) -> float | None:
        """The speed of the last maximum of the vibration torque below a speed (None: of all), None if it has none there."""
        if not len(self.mass):
            return None
        natural = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(self.mass, self.stiffness))))
        below = _BEYOND * float(natural.max()) if below is None else abs(below)
        near = 1 + np.concatenate([-np.geomspace(1e-6, 0.5, 60), [0.0], np.geomspace(1e-6, 0.5, 60)])
        grid = np.concatenate([np.linspace(below * 1e-3, below, 400), *(w * near for w in natural)])
        grid = np.unique(grid[(grid > 0) & (grid <= below)])
        maxima = crossings(lambda w: self.torque(w, phases)[1], grid, -1) if len(grid) else grid
        return float(maxima[-1]) if len(maxima) else None


def unbalances(machine: Machine) -> np.ndarray:
    """The unbalance of each turning body (n,), complex in its own frame, in kg m; of a couple unbalance in kg m^2.

    A body's own unbalance is real; pivots off the axis and sliders add to that of the body they turn with.
    """
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    if not parts:  # a dimensionless machine
        return np.asarray(np.abs(Vibration.of(machine).excitation).max(axis=1).astype(complex))
    moments = {b.name: parts[b.name].moment() for b in machine.bodies}
    for part in parts.values():
        if (couple := part.couple()) is not None:
            moments[part.name] = couple
        if part.reference is not None:
            moments[part.reference] += part.moment_on_reference()
    return np.array(machine.evaluate(*moments.values()), complex)


def moments_along_guides(machine: Machine) -> np.ndarray:
    """By how much the unbalance of each turning body (n,) grows with the displacement of the mass that slides in it, in kg."""
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    moments = [parts[b.name].moment_along_guide() if parts else sp.S.Zero for b in machine.bodies]
    return np.array(machine.evaluate(*moments), float)


def unbalance_scale(machine: Machine, rotor: RotatingBody) -> float:
    """What shares of an unbalance refer to: the rotor's own; without it the largest that a body about it has, or can have."""
    own, group = dict(zip(machine.bodies, unbalances(machine), strict=True)), machine.group(rotor)
    if own[rotor]:
        return float(abs(own[rotor]))
    names = [b.name for b in group]
    reachable = [p.largest_moment() for p in machine.parts if isinstance(p, Body) and p.name in names]
    return max([float(abs(own[b])) for b in group] + [abs(complex(x)) for x in machine.evaluate(*reachable)]) or 1.0
