"""A cycle of a machine: run up with its drives, and, from the state reached, down without them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from wucht.dynamics.run_ups.coasting import without_drives
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.operating_state import machine_after_schedules, refuse_shaken, transfer_state
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.machines.machine import SUPPLIED_WORK, Machine
from wucht.machines.parts.base import Drive
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.trajectory import Trajectory
from wucht.system import Output, System

SLOW = 0.01  # of the speeds at the switch-off: the coast-down ends where the rotors are slower in the mean square
SLOW_EVENT = "the rotors are slow"
_CIRCUIT_HEAT = "circuit_heat"
_STILL = 1e-9  # of the largest natural frequency


def with_circuit_heat(machine: Machine) -> System:
    """Return the full equations with the heat in the circuits of the motors as a further work."""
    heat = sp.Add(*(_circuit_heat(machine, d) for d in machine.drives))
    works = (*machine.system.quadratures, Output(_CIRCUIT_HEAT, heat, machine.units.energy, "heat"))
    return replace(machine.system, quadratures=works)


def _circuit_heat(machine: Machine, drive: Drive) -> sp.Expr:
    base = machine.frame.rotation if drive.stator == "carrier" else sp.S.Zero
    heat = drive.circuit_loss(drive.ratio * (machine.frame.speed(drive.on) - base))
    return sp.S.Zero if heat is None else heat


def drives_without_circuit(machine: Machine) -> list[Drive]:
    """Return the drives that are known by their torque alone: the heat in them is not counted."""
    return [d for d in machine.drives if d.circuit_loss(sp.Symbol("speed", real=True)) is None]


def supplied_energy(trajectory: Trajectory) -> np.ndarray:
    """Return the energy (N,) that the drives have taken from the supply: their work and the heat in their circuits."""
    return np.asarray(trajectory.quadratures[SUPPLIED_WORK] + trajectory.quadratures[_CIRCUIT_HEAT])


def start_case(machine: Machine, start: Mapping[str, Any], settings: RunSettings) -> RunUpCase:
    """Return the run-up of a cycle. Raises ``InputError`` where the start does not fit, or nothing would turn."""
    refuse_shaken(machine)
    case = RunUpCase.of(machine, start, settings)
    return replace(case, models=(replace(case.models[0], extension=with_circuit_heat(case.machine)),))


def stop_case(machine: Machine, end: Trajectory, settings: RunSettings) -> RunUpCase | None:
    """Return the coast-down from the end of a run-up, with schedules as they are then; None where no rotor turns any more."""
    time = end.end_time
    values = dict(zip(machine.system.parameter_names, end.final_parameter_values.tolist(), strict=False))
    running = machine_after_schedules(machine, values, time)
    coasting = without_drives(running)
    state = transfer_state(running, end.states[:, -1], coasting, time)
    speeds = {r: float(state[coasting.row(r.coordinate.velocity)]) for r in coasting.rotors}
    turning = {r: w for r, w in speeds.items() if abs(w) > _STILL * max(map(abs, speeds.values())) and w}
    if not turning:
        return None
    case = RunUpCase.from_state(coasting, state, settings)
    # The event needs the speeds at the switch-off: as parameters they do not make other equations.
    symbols = tuple(sp.Symbol(f"{r.name}.switch_off_speed", real=True) for r in turning)
    system = replace(coasting.system, parameters=(*coasting.system.parameters, *symbols))
    model = replace(case.models[0], extension=system, further_values=tuple(turning.values()))
    squares = ((r.coordinate.velocity / symbol) ** 2 for r, symbol in zip(turning, symbols, strict=True))
    slow = Event(SLOW_EVENT, sp.Add(*squares) / len(turning) - SLOW**2, -1, terminal=True)
    return replace(case, models=(model,), horizon=replace(case.horizon, events=(*case.horizon.events, slow)))
