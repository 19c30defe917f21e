"""Signals of a machine's motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.analysis.bearing_forces import bearing_force
from wucht.dynamics.run_ups.bearing_loads import has_bearing_forces
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

_VALUE = "value"


@dataclass(frozen=True)
class MachineSignal:
    """A signal of a machine's motion: its name, and the unit of its values."""

    name: str
    unit: str
    evaluator: Evaluator

    def __call__(self, motion: Trajectory) -> np.ndarray:
        """Return its values (N,) over the machine's motion."""
        values = self.evaluator(motion.time, motion.states, motion.final_parameter_values)[_VALUE]
        return np.broadcast_to(values, motion.time.shape)


def rotor_signal(machine: Machine, rotor: str, direction: str | None, location: str = "study") -> MachineSignal:
    """Return the force of one rotor, with the bodies about it, on its bearing.

    direction: x by default, or y, whether the carrier moves there or not. Raises ``InputError`` for an unknown rotor, and
    where the machine's rotors have no forces in the plane.
    """
    names = [r.name for r in machine.rotors]
    if rotor not in names:
        raise InputError(f"{location}.rotor", rotor, f"must be a rotor of the machine; {nearest(rotor, names)}")
    if not has_bearing_forces(machine):
        raise InputError(f"{location}.rotor", rotor, "this machine's rotors have no bearing forces in newtons")
    if direction not in (None, "x", "y"):
        raise InputError(f"{location}.direction", direction, "must be one of x, y")
    label = direction or "x"
    evaluator = Evaluator.of(machine.system, [bearing_force(machine, rotor, label)], [_VALUE])
    return MachineSignal(f"bearing force of {rotor} in {label}", machine.units.force, evaluator)


def machine_signal(machine: Machine, name: str, direction: str | None, location: str = "study") -> MachineSignal:
    """Return a signal of the carrier's motion.

    name: ``"displacement"``, ``"spring-force"``, ``"bearing-force"`` (of the bodies on it) or ``"acceleration"``. direction: by
    default the first that the machine has. location: the table of the study file that requests it. Raises ``InputError`` for a
    machine without a carrier, or without that direction.
    """
    units, system = machine.units, machine.system
    directions = machine.free_labels if name in ("acceleration", "spring-force") else machine.labels
    if not directions:
        raise InputError(f"{location}.signal", name, "this machine's carrier does not move")
    if direction is not None and direction not in directions:
        raise InputError(f"{location}.direction", direction, f"must be one of {', '.join(directions)}")
    label = direction or directions[0]
    coordinate = dict(zip(machine.labels, machine.carrier, strict=True))[label]
    turns = label == "r"
    force = units.torque if turns else units.force
    expressions: Mapping[str, tuple[object, str]] = {
        "displacement": (coordinate.position, "rad" if turns and units.time else units.length),
        "spring-force": (_spring_force(machine, label), force),
        "bearing-force": (system.output(f"bearing_force_{label}").expression, force),
    }
    if name == "acceleration":
        rate = system.derivatives[machine.row(coordinate.velocity)]
        unit = f"{'rad' if turns else units.length}/{units.time}^2" if units.time else ""
    else:
        rate, unit = expressions[name]
    evaluator = Evaluator.of(system, [rate], [_VALUE])
    kind = "moment" if turns else "force"
    descriptions = {"bearing-force": f"bearing {kind}", "spring-force": f"{kind} of the springs"}
    description = descriptions.get(name, f"{name} of the carrier")
    return MachineSignal(f"{description} in {label}", unit, evaluator)


def _spring_force(machine: Machine, label: str) -> sp.Expr:
    """The force of the carrier's springs that answers its displacement, along a free direction: K q."""
    if label not in machine.free_labels:
        return sp.S.Zero
    row = machine.linear_carrier.stiffness.row(machine.free_labels.index(label))
    return sp.Add(*(c * q.position for c, q in zip(row, machine.free_carrier, strict=True)))
