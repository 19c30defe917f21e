"""What the vibration does to the rotation at a steady speed: harmonic influence coefficients, in numbers.

With z = H(w) sum_k U_k e_k w^2 exp(i alpha_k), H(w) = (K - w^2 M + i w C)^-1, the carrier takes the power
w^2 z^H C z / 2 out of the rotation: the vibration torque is w z^H C z / 2. For one rotor on an isotropic carrier this is
the second term of 002 (3.67).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine, Turning
from wucht.machines.parts.base import Body
from wucht.machines.parts.rotor import Rotor
from wucht.numerics.flow.program import python_function


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
        c, numbers, size = machine.linear_carrier, machine.numbers, len(machine.free_carrier)
        m, b, k = (np.array(a.xreplace(numbers).tolist(), float).reshape(size, size) for a in (c.mass, c.damping, c.stiffness))
        e = [np.array(a.xreplace(numbers).tolist(), complex).ravel() for a in c.excitation]
        clockwise = [sense_of(machine, body) < 0 for body in machine.bodies]
        return cls(m, b, k, np.array([v.conj() if turned else v for v, turned in zip(e, clockwise, strict=True)]))

    def only(self, index: Sequence[int]) -> Vibration:
        """The vibration that some of the bodies excite."""
        return replace(self, excitation=self.excitation[list(index)])

    def dynamic(self, w: np.ndarray) -> np.ndarray:
        """K - w^2 M + i w C (N, m, m) at speeds (N, 1, 1)."""
        # A trace of damping keeps the matrix regular at the natural frequency of an undamped direction.
        trace = 1e-14j * (np.abs(self.stiffness).max(initial=0.0) or 1.0) * np.eye(len(self.mass))
        found: np.ndarray = self.stiffness - w**2 * self.mass + 1j * w * self.damping + trace
        return found

    def response(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """The complex displacements z (N, m) at speeds (N,) with the bodies at phases (n,): q = Re[z exp(i w t)]."""
        w = np.atleast_1d(np.asarray(speeds, float))[:, None, None]
        force = (self.excitation * np.exp(1j * phases)[:, None]).sum(axis=0)
        found: np.ndarray = np.linalg.solve(self.dynamic(w), w**2 * force[None, :, None])[..., 0]
        return found

    def torque(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """The vibration torque on all bodies together at speeds (N,), positive where it brakes: w z^H C z/2."""
        w, z = np.atleast_1d(np.asarray(speeds, float)), self.response(speeds, phases)
        found: np.ndarray = w * np.einsum("ni,ij,nj->n", z.conj(), self.damping, z).real / 2
        return found

    def last_maximum(self, below: float, phases: np.ndarray) -> float | None:
        """The speed of the last maximum of the vibration torque below a speed, None if it has none there."""
        below = abs(below)
        if not len(self.mass) or not below:
            return None
        squares = np.abs(np.linalg.eigvals(np.linalg.solve(self.mass, self.stiffness)))
        near = 1 + np.concatenate([-np.geomspace(1e-6, 0.5, 60), [0.0], np.geomspace(1e-6, 0.5, 60)])
        grid = np.concatenate([np.linspace(below * 1e-3, below, 800), *(math.sqrt(s) * near for s in squares)])
        grid = np.unique(grid[(grid > 0) & (grid <= below)])
        torque = self.torque(grid, phases)
        if not torque.max() > 0:
            return None
        inside = np.flatnonzero((torque[1:-1] > torque[:-2]) & (torque[1:-1] >= torque[2:])) + 1
        if not len(inside):
            return None
        low, high = grid[inside[-1] - 1], grid[inside[-1] + 1]
        while high - low > 1e-10 * high:  # SciPy's minimiser takes longer to import than this takes to run
            fine = np.linspace(low, high, 41)
            best = min(max(int(self.torque(fine, phases).argmax()), 1), 39)
            low, high = fine[best - 1], fine[best + 1]
        return float((low + high) / 2)


_FASTEST = 1e9  # rad/s: a drive that still drives there meets nothing that could hold it


def sense_of(machine: Machine, body: Turning) -> float:
    """+1 for a body that turns counter-clockwise in operation, -1 for one that turns clockwise with its drive."""
    by_name = {b.name: b for b in machine.bodies}
    while body.about is not None:
        body = by_name[body.about]
    return -1.0 if (free_speed(machine, body) or 0.0) < 0 else 1.0


def unbalances(machine: Machine) -> np.ndarray:
    """The unbalance of each turning body (n,), complex in its own frame, in kg m; of a couple unbalance in kg m^2.

    A body's own unbalance is real; pivots off the axis and sliders add to that of the body they turn with.
    """
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    if not parts:  # a dimensionless machine
        alone: np.ndarray = np.abs(Vibration.of(machine).excitation).max(axis=1).astype(complex)
        return alone
    found = {b.name: complex(parts[b.name].moment().xreplace(machine.numbers)) for b in machine.bodies}
    for part in parts.values():
        if isinstance(part, Rotor) and part.couple_unbalance is not None:
            found[part.name] = complex(machine.values[f"{part.name}.couple_unbalance"])
        if part.reference is not None:
            found[part.reference] += complex(part.moment_on_reference().xreplace(machine.numbers))
    return np.array(list(found.values()))


def operating_speed(machine: Machine) -> float:
    """The fastest of the speeds that the drives reach without vibration and of the natural frequencies, in magnitude."""
    from wucht.machines.dimensionless import natural_frequencies

    free = [free_speed(machine, rotor) for rotor in machine.rotors]
    return max([*(abs(w) for w in free if w is not None), *natural_frequencies(machine).values(), 1.0])


def energy_scale(machine: Machine) -> float:
    """The kinetic energy of the bodies at operating speed, the size of the works in a run."""
    speed = dict.fromkeys((b.coordinate.velocity for b in machine.bodies), sp.Float(operating_speed(machine)))
    rest = dict.fromkeys((s for c in machine.coordinates for s in (c.position, c.velocity)), sp.S.Zero) | speed
    numbers = {s: sp.Float(v) for s, v in machine.numbers.items()}
    found = float(sp.Add(*(e.kinetic for e in machine.energies)).xreplace(rest | numbers))
    return found if found > 0 and math.isfinite(found) else 1.0


def group(machine: Machine, rotor: Turning) -> list[Turning]:
    """A rotor and all bodies that turn about it, directly or through others."""
    members, names = [rotor], {rotor.name}
    rest = [b for b in machine.bodies if b.about is not None]
    while found := [b for b in rest if b.about in names and b.name not in names]:
        members += found
        names |= {b.name for b in found}
    return members


SPEED = sp.Symbol("speed", real=True)


def shaft_torques(machine: Machine, rotor: Turning) -> tuple[sp.Expr, sp.Expr]:
    """What drives a rotor whose bodies turn with it, and what brakes it, the carrier at rest.

    Expressions in ``SPEED`` with all numbers put in: of all drives, in the direction of positive speeds; of loads and bearings,
    against it.
    """
    drive, losses = list[sp.Expr](), list[sp.Expr]()
    for v in (b.coordinate.velocity for b in group(machine, rotor)):
        for e in machine.energies:
            losses.append(sp.diff(e.dissipation, v))
            for a in e.applied:
                torque = a.force * sp.diff(a.rate, v)
                drive.append(torque if a.booked == "supplied" else sp.S.Zero)
                losses.append(-torque if a.booked != "supplied" else sp.S.Zero)
    still = {s: sp.S.Zero for c in machine.carrier for s in (c.position, c.velocity)}
    still |= {s: sp.S.Zero for x in machine.sliders for s in (x.coordinate.position, x.coordinate.velocity)}
    still |= {b.coordinate.velocity: SPEED for b in machine.bodies}
    together = (sp.sympify(sp.Add(*f).xreplace(still).xreplace(machine.numbers)) for f in (drive, losses))
    first, second = together
    return first, second


def _net(machine: Machine, rotor: Turning) -> sp.Expr:
    drive, losses = shaft_torques(machine, rotor)
    return drive - losses


def _function(torque: sp.Expr) -> Callable[[float], float]:
    function = python_function((SPEED,), (), (torque,), "math")
    return lambda w: float(function(w)[0])


def net_torque(machine: Machine, rotor: Turning) -> Callable[[float], float]:
    """Drive torque less bearing losses on a rotor whose bodies turn with it, the carrier at rest and weightless."""
    return _function(_net(machine, rotor))


def free_speed(machine: Machine, rotor: Turning, time: float = 0.0) -> float | None:
    """The speed that the drive reaches without vibration, None where it is not determined (no drive and no losses).

    Prescribed speeds are returned as they are at a time; a motor without load reaches its no-load speed, less what bearings
    cost. Where schedules change the drive, give the machine ``at`` that time.
    """
    prescribed = rotor.coordinate.prescribed
    if prescribed is not None:
        return float(machine.prescribed_speed(rotor.coordinate, time)[0])
    expression = _net(machine, rotor)
    torque = _function(expression)
    start = torque(0.0)
    if start == 0.0:
        return 0.0 if torque(1.0) < 0 else None
    if sp.diff(expression, SPEED, 2) == 0:
        slope = float(sp.diff(expression, SPEED))
        rough = -start / slope if slope else None
        return None if rough is None else rough - torque(rough) / slope  # the second step removes the rounding of the first
    previous, here = 0.0, math.copysign(1e-3, start)
    while abs(here) < _FASTEST:
        if torque(here) * start <= 0:
            return _first_without(torque, start, previous, here)
        previous, here = here, 1.5 * here
    return None


def _first_without(torque: Callable[[float], float], start: float, low: float, high: float) -> float:
    """The lowest speed between two at which the torque no longer has the sign of ``start``, to the last bit."""
    while True:
        middle = (low + high) / 2
        if middle in (low, high):
            return high
        low, high = (middle, high) if torque(middle) * start > 0 else (low, middle)
