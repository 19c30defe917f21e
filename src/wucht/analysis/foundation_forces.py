"""Forces into the foundation: of the springs and dampers under a carrier, mount by mount, and of what else supports it.

A support pushes the foundation along a direction d by dV/dq_d + dR/dq_d', of its own potential energy and dissipation, less
the forces on the carrier that it applies besides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import sympy as sp

from wucht.analysis.vibration import ForcedVibration
from wucht.machines.machine import Machine
from wucht.machines.parts.attachment import LineAttachment
from wucht.machines.parts.carrier import Carrier
from wucht.machines.parts.planar_carrier import PlanarCarrier
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

_ROUNDING = 1e-12  # of the largest force at rest


class SupportDirection(NamedTuple):
    """A support and a direction, x or y."""

    support: str
    direction: str

    def __str__(self) -> str:
        """The name of the force."""
        return f"{self.support}.{self.direction}"


def _ways(machine: Machine) -> dict[str, Coordinate]:
    """The coordinates of the carrier along x and y that are free."""
    return {label: q for label, q in zip(machine.free_labels, machine.free_carrier, strict=True) if label in ("x", "y")}


def support_forces(machine: Machine) -> dict[str, dict[str, sp.Expr]]:
    """The force of each support on the foundation along x and y, by its name, as expressions of the machine's System.

    ``carrier`` is the spring and damper of a carrier without mounts, below a foundation of its own if it has one. Empty for a
    carrier that does not translate freely on a foundation at rest, and for a machine without units.
    """
    ways = _ways(machine)
    if machine.dimensionless or machine.shaken_coordinate is not None or not ways:
        return {}
    carrier, gravity = machine.parts[0], sp.sympify(machine.frame.gravity)
    energies = machine.energies[0]
    weightless = energies.potential.xreplace({gravity: sp.S.Zero}) if gravity.is_Symbol else energies.potential
    carrier_energies = Energies(potential=weightless, dissipation=energies.dissipation)
    if isinstance(carrier, PlanarCarrier) and carrier.mounts:
        mounts = range(1, len(carrier.single_mounts) + 1)
        supports = {f"mount {i}": _only(carrier_energies, [f"carrier.mounts.{k}." for k in mounts if k != i]) for i in mounts}
        forces = {name: {d: _force(e, q) for d, q in ways.items()} for name, e in supports.items()}
    else:
        forces = {"carrier": {d: _force(carrier_energies, q) for d, q in ways.items()}}
        if isinstance(carrier, Carrier) and carrier.foundation is not None:
            below = dict(zip(machine.free_labels, machine.free_carrier, strict=True))["foundation"]
            ground_energies = _only(carrier_energies, ["carrier.stiffness", "carrier.damping"])
            forces["carrier"][carrier.foundation.direction] = _force(ground_energies, below)
    for part, of_part in zip(machine.parts, machine.energies, strict=False):
        if isinstance(part, LineAttachment):
            forces[part.name] = {d: _force(of_part, q) for d, q in ways.items()}
    return forces


def _only(energies: Energies, paths: list[str]) -> Energies:
    """Energies without the springs and dampers whose parameters begin with these paths."""
    zero = {x: sp.S.Zero for x in energies.symbols if x.name.startswith(tuple(paths)) and ".at." not in x.name}
    return Energies(potential=energies.potential.xreplace(zero), dissipation=energies.dissipation.xreplace(zero))


def _force(e: Energies, q: Coordinate) -> sp.Expr:
    applied_force = sp.Add(*(a.force * sp.diff(a.rate, q.velocity) for a in e.applied_forces))
    return sp.diff(e.potential, q.position) + sp.diff(e.dissipation, q.velocity) - applied_force


@dataclass(frozen=True)
class FoundationForces:
    """The forces of a machine's supports on the foundation beyond those at rest, as a function of its motion.

    evaluator: of the forces, by ``keys``: support and direction. at_rest: them at rest, zero where the weight is not part of
    the model.
    """

    evaluator: Evaluator
    keys: tuple[SupportDirection, ...]
    at_rest: Mapping[SupportDirection, float]

    @classmethod
    def of(cls, machine: Machine) -> FoundationForces | None:
        """The forces of a machine; None of one without supports. See ``support_forces``."""
        forces = support_forces(machine)
        if not forces:
            return None
        keys = tuple(SupportDirection(name, d) for name, of_support in forces.items() for d in of_support)
        expressions = [forces[key.support][key.direction] for key in keys]
        evaluator = Evaluator.of(machine.system, expressions, [str(key) for key in keys])
        state = np.zeros((len(machine.state_names), 1))
        for q, rest in zip(machine.carrier, machine.rest.tolist(), strict=True):
            if q.prescribed_velocity is None:
                state[machine.row(q.position)] = rest
        at_rest = evaluator(np.zeros(1), state, machine.system.values(machine.values))
        forces_at_rest = {key: float(np.ravel(at_rest[str(key)])[0]) for key in keys}
        rounding = _ROUNDING * max(map(abs, forces_at_rest.values()))
        return cls(evaluator, keys, {key: f if abs(f) > rounding else 0.0 for key, f in forces_at_rest.items()})

    def __call__(self, motion: Trajectory) -> dict[SupportDirection, np.ndarray]:
        """The forces (N,) beyond those at rest."""
        rows = self.evaluator(motion.time, motion.states, motion.final_parameter_values)
        return {key: np.broadcast_to(rows[str(key)], motion.time.shape) - self.at_rest[key] for key in self.keys}


@dataclass(frozen=True)
class SteadyFoundation:
    """The foundation in the steady vibration of a linear carrier.

    amplitudes: of the forces. transmissibility: largest force of all supports together over that of the unbalances; None where
    these cancel.
    """

    amplitudes: Mapping[SupportDirection, float]
    transmissibility: float | None

    @classmethod
    def of(cls, machine: Machine, vibration: ForcedVibration, speed: float) -> SteadyFoundation | None:
        """The foundation at a speed; None of a machine without supports, and at an undamped resonance."""
        supports, w = support_forces(machine), np.array([abs(speed)])
        with np.errstate(all="ignore"):
            z = vibration.displacement(w)[0][0]
        if not supports or machine.nonlinear or not np.isfinite(z).all():
            return None
        forces = dict[SupportDirection, complex]()
        for name, of_support in supports.items():
            for d, force in of_support.items():
                by_place = machine.evaluate(*(sp.diff(force, q.position) for q in machine.free_carrier))
                by_speed = machine.evaluate(*(sp.diff(force, q.velocity) for q in machine.free_carrier))
                forces[SupportDirection(name, d)] = complex((np.array(by_place) + 1j * abs(speed) * np.array(by_speed)) @ z)
        exciting = dict(zip(machine.free_labels, w[0] ** 2 * vibration.force(w)[0], strict=True))
        total, unbalance = (
            _semi_major([sum((f for key, f in of.items() if key[-1] == d), 0j) for d in "xy"]) for of in (forces, exciting)
        )
        amplitudes = {key: abs(f) for key, f in forces.items()}
        return cls(amplitudes, total / unbalance if unbalance else None)


def _semi_major(vector: Sequence[complex]) -> float:
    """The largest magnitude of the vector Re[(x, y) exp(i w t)]."""
    x, y = vector
    return (abs(x + 1j * y) + abs(x - 1j * y)) / 2
