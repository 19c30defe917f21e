"""The state in which a machine runs, as a state to start from: synchronous rotors, or the main rotor at a working point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.analysis.configurations.configuration import Configuration
from wucht.analysis.time_constants import highest_speed
from wucht.analysis.working_points import TorqueCurves, creep_speed
from wucht.dynamics.run_ups.coasting import (
    driving_machine,
    state_at_start,
    state_in_configuration,
    vibrating_state,
    with_steady_vibration,
    without_drives,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.run_ups.operating_points import OperatingPoints
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.steady_phases import SteadyPhases, configuration_labels, stable_configurations
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import LOWEST, machine_at_speed, sense_of
from wucht.mechanics.lagrange import Coordinate

_POINTS = 1200  # speeds in the search for working points

_SHAKEN = "not allowed: the drives are switched while the machine runs, and a prescribed motion of the carrier would start anew"


@dataclass(frozen=True)
class OperationCase:
    """A run of a machine in operation. label: of the configuration in which it begins, empty at rest. rest_reason: why the
    carrier begins at rest."""

    case: RunUpCase
    label: str = ""
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


def machine_after_schedules(machine: Machine, locks: Mapping[str, float] | None = None, time: float | None = None) -> Machine:
    """Return the machine as its schedules drive it at a time, by default at their end, without these.

    locks: values of the locks of bodies, as a run has left them; bodies whose lock is not named are released.
    """
    steady = machine.at(machine.breakpoints[-1] if time is None else time).with_fields(schedules=())
    values = {b.lock_symbol.name: (locks or {}).get(b.lock_symbol.name, 0.0) for b in steady.bodies if b.release is not None}
    if not values:
        return steady
    open_bodies = {name.removesuffix(".locked") for name, value in values.items() if not value}
    bodies = tuple(replace(b, release=None) if b.name in open_bodies else b for b in steady.bodies)
    return steady.with_unchecked_values(values).with_fields(bodies=bodies)


def states_in_configurations(
    driven: Machine, machine: Machine, initial: np.ndarray, start: Mapping[str, Any], **search: Any
) -> list[tuple[Configuration, str, np.ndarray]]:
    """Return the stable synchronous configurations of several rotors, their labels, and the state (n,) in each.

    Parameters
    ----------
    driven : Machine
        With its drives.
    machine : Machine
        Of the states: with its drives or without.
    initial : numpy.ndarray, (n,)
        State of this machine, with the carrier at rest.
    start : mapping
        Selects one configuration where it gives phases.
    **search
        Keywords of ``stable_configurations``.

    Raises
    ------
    InputError
        Where configurations are not known.
    """
    senses = {b.name: sense_of(driven, b) for b in driven.bodies}
    configurations = stable_configurations(driven, start, **search)[1]
    states = [state_in_configuration(machine, initial, c, senses, start) for c in configurations]
    return list(zip(configurations, configuration_labels(configurations), states, strict=True))


def cases_in_operation(
    machine: Machine, start: Mapping[str, Any], settings: RunSettings, watch: Callable[[], None] | None = None
) -> tuple[OperationCase, ...]:
    """Return runs from the states in which several rotors run: one for each stable synchronous configuration.

    start: selects one where it gives phases. watch: called often. None where no configuration is stable. Raises
    ``InputError`` where configurations are not known, or the start does not fit the machine.
    """
    driven = machine_in_operation(machine)
    coasting = without_drives(driven)
    cases = list[OperationCase]()
    initial = state_at_start(driven, coasting, start)
    for _, label, resting in states_in_configurations(driven, coasting, initial, start, watch=watch):
        vibrating, _, reason = vibrating_state(machine_in_state(coasting, resting), resting, start, None)
        state = transfer_state(coasting, vibrating, driven)
        case = RunUpCase.from_state(machine_in_state(driven, state), state, settings)
        cases.append(OperationCase(case, label, reason))
    return tuple(cases)


def state_at_working_point(
    machine: Machine, start: Mapping[str, Any], watch: Callable[[], None]
) -> tuple[np.ndarray, float] | None:
    """Return a state (n,) at the fastest stable working point, and its speed in magnitude; None without one.

    It has the steady vibration of that speed where this is bounded. machine: without schedules. start: selects one of several
    configurations of rotors where it gives phases.
    """
    reach, initial = highest_speed(machine), initial_state(machine, start)
    if len(machine.rotors) > 1:
        search = {"speeds": (LOWEST * reach, reach), "watch": watch}
        in_configurations = states_in_configurations(machine, machine, initial, start, **search)
        points = [(abs(c.speed), state) for c, _, state in in_configurations]
    else:
        points = _states_at_working_points(machine, start, initial, reach, watch)
    speed, state = max(points, key=lambda point: point[0], default=(0.0, initial))
    if speed <= creep_speed(machine):
        return None
    with suppress(InputError):  # at an undamped resonance, or of a carrier that is not linear: the machine settles by itself
        state = with_steady_vibration(machine, state)
    return state, speed


def _states_at_working_points(
    machine: Machine, start: Mapping[str, Any], initial: np.ndarray, reach: float, watch: Callable[[], None]
) -> list[tuple[float, np.ndarray]]:
    """Return the speed, in magnitude, and the state (n,) at each stable working point of a single rotor."""
    senses, steady = {b.name: sense_of(machine, b) for b in machine.bodies}, SteadyPhases.of(machine, start, None)
    sense = senses[machine.rotor.name]
    shaft_range = (min(sense * reach, 0.0), max(sense * reach, 0.0))
    curves = [TorqueCurves(machine, machine.rotor, vibration, shaft_range, _POINTS) for vibration in steady.curves]
    operating = OperatingPoints.of(steady, curves, shaft_range if steady.torques is None else (LOWEST * reach, reach), watch)
    states = list[tuple[float, np.ndarray]]()
    for i, point in enumerate(operating.points):
        if point.stable and operating.configurations:
            state = state_in_configuration(machine, initial, operating.configurations[i], senses, start)
            states.append((abs(point.speed), state))
        elif point.stable:
            state = initial.copy()
            state[[machine.row(b.coordinate.velocity) for b in machine.bodies]] = sense * abs(point.speed)
            states.append((abs(point.speed), state))
    return states


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
