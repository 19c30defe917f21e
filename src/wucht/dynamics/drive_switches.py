"""A machine whose drives can be switched off while it runs: each has a parameter ``switch`` that multiplies its torque."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.mechanics.energies import Energies
from wucht.schema import Parameter

_SWITCH = "switch"


def switch_path(drive: Drive) -> str:
    """Return the path of the parameter that is 1 while the drive is on, 0 while it is off."""
    return f"{drive.path}.{_SWITCH}"


def switchable_drives(machine: Machine) -> tuple[Drive, ...]:
    """Return the drives that can be switched off: those that give a torque. One that enforces a speed cannot."""
    return tuple(d for d in machine.drives if d.prescribed_body_speed() is None)


def with_switches(machine: Machine) -> Machine:
    """Return the machine with a parameter ``switch`` for each drive with a torque, at 1: the same motion.

    At 0 the drive gives no torque and does not brake, nor does its transmission lose power, as in
    ``wucht.dynamics.run_ups.coasting.without_drives``; currents in its circuit go on as its equations say.
    """
    energies, parameters = list(machine.energies), dict(machine.parameters)
    for drive in switchable_drives(machine):
        row, path = machine.parts.index(drive), switch_path(drive)  # energies are in the order of the parts
        energies[row] = _with_switch(energies[row], sp.Symbol(path, real=True))
        parameters[path] = Parameter(path, 1.0, "", _SWITCH, "switch of the motor, 1 on, 0 off")
    return machine.with_fields(energies=tuple(energies), parameters=parameters)


def _with_switch(energies: Energies, switch: sp.Symbol) -> Energies:
    forces = tuple(
        replace(a, force=switch * a.force) if a.energy_side == "supplied" or a.of_drive else a for a in energies.applied_forces
    )
    return replace(energies, applied_forces=forces)
