"""The state in which a machine runs, as a state to start from; and a machine that has lost its drives while it ran."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.dynamics.run_ups.coasting import (
    CarrierStart,
    carrier_start,
    driving_machine,
    state_at_start,
    state_in_configuration,
    with_steady_vibration,
    without_drives,
)
from wucht.dynamics.run_ups.initial_state import machine_in_state
from wucht.dynamics.run_ups.steady_phases import configuration_labels, stable_configurations
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import machine_at_speed, sense_of
from wucht.mechanics.lagrange import Coordinate

_SHAKEN = "not allowed: the drives are switched while the machine runs, and a prescribed motion of the carrier would start anew"


@dataclass(frozen=True)
class OperatingState:
    """A state (n,) of a machine in operation, whose bodies turn in a synchronous configuration.

    label: of the configuration. rest_reason: why the carrier rests in it, empty where it vibrates steadily.
    """

    machine: Machine
    state: np.ndarray
    label: str
    rest_reason: str = ""


def refuse_shaken(machine: Machine) -> None:
    """Raise ``InputError`` where the motion of the carrier is prescribed: it would start anew where drives are switched."""
    if machine.shaken_coordinate is not None:
        raise InputError("machine.carrier.motion", None, _SHAKEN, code="prescribed")


def machine_in_operation(machine: Machine) -> Machine:
    """Return the machine as its schedules last drive it, with all bodies released.

    Raises ``InputError`` where the motion of the carrier is prescribed.
    """
    refuse_shaken(machine)
    return machine_at_speed(driving_machine(machine), None)


def operating_states(machine: Machine, start: Mapping[str, Any]) -> tuple[OperatingState, ...]:
    """Return the states in which several rotors run: one for each stable synchronous configuration.

    start: selects one where it gives phases. None where no configuration is stable. Raises ``InputError`` where
    configurations are not known, or the start does not fit the machine.
    """
    driven = machine_in_operation(machine)
    coasting = without_drives(driven)
    initial = state_at_start(driven, coasting, start)
    senses = {b.name: sense_of(driven, b) for b in driven.bodies}
    configurations = stable_configurations(driven, start)[1]
    states = list[OperatingState]()
    for configuration, label in zip(configurations, configuration_labels(configurations), strict=True):
        state = state_in_configuration(coasting, initial, configuration, senses, start)
        arranged_machine = machine_in_state(coasting, state)
        carrier, reason = carrier_start(arranged_machine, start, None)
        if carrier is CarrierStart.STEADY:
            state = with_steady_vibration(arranged_machine, state)
        state = transfer_state(coasting, state, driven)
        states.append(OperatingState(machine_in_state(driven, state), state, label, reason))
    return tuple(states)


def transfer_state(machine: Machine, state: np.ndarray, successor: Machine, time: float = 0.0) -> np.ndarray:
    """Return a state of a machine, (n,), as that of another one with the same bodies.

    Speeds that only the first one prescribes are those at the time; internal states that only the second one has are zero.
    """
    values = {_velocity(c): float(machine.prescribed_speed(c, time)[0]) for c in machine.coordinates if _is_prescribed(c)}
    values |= dict(zip(machine.state_names, state.tolist(), strict=False))
    return np.array([values.get(name, 0.0) for name in successor.state_names])


def _velocity(coordinate: Coordinate) -> str:
    return str(coordinate.velocity.name)


def _is_prescribed(coordinate: Coordinate) -> bool:
    return coordinate.prescribed_velocity is not None
