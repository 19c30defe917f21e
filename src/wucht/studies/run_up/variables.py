"""The variables of a run-up's Dataset: what was computed, with names and units."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from wucht.analysis.vibration import unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.peaks import envelope
from wucht.results.conventions import Variable, variable
from wucht.studies.locking import frequency_of, is_locking
from wucht.studies.observables import EnergyBalance, Orbit, Rows

Variables = dict[str, Variable]


def variables(machine: Machine, row: Rows, trajectory: Trajectory) -> tuple[Variables, Variables]:
    """Coordinates and data of a run. row: the states and outputs of the machine's System, (N,) each.

    Coordinates: time (N), body, direction. Variables: angle, speed, phase (of bodies that turn about another), rotor_phase (of
    rotors that may be entrained) (body, time); displacement, velocity, bearing_force (direction, time); radius, amplitude,
    motor_torque, motor_power, stored_energy, supplied_work, dissipated_work, energy_residual, residual_unbalance (time);
    peak_amplitude, free_speed; slider_displacement, slider_velocity (slider, time).
    """
    data = (
        _rotation(machine, row, trajectory.time) | _vibration(machine, row, trajectory.time) | _energy(machine, row, trajectory)
    )
    coordinates = {
        "time": variable("time", trajectory.time, "time", machine.units.time),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "direction": variable("direction", list(machine.labels) or np.empty(0, "U1"), "direction"),
    }
    if machine.sliders:
        coordinates["slider"] = variable("slider", [x.name for x in machine.sliders], "slider")
    return coordinates, data


def _rotation(machine: Machine, row: Rows, time: np.ndarray) -> Variables:
    units = machine.units
    angle = {b.name: row[b.coordinate.position.name] for b in machine.bodies}
    speed = [row[b.coordinate.velocity.name] for b in machine.bodies]
    end = float(time[-1]) if len(time) else 0.0
    free = free_speed(machine.at(end), machine.rotor, end)
    found = {
        "angle": variable("body time", list(angle.values()), "angle", "rad"),
        "speed": variable("body time", speed, "speed", units.speed),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "motor_torque": variable("time", row["motor_torque"], "motor torque", units.torque),
        "motor_power": variable("time", row["motor_power"], "motor power", units.power),
        "residual_unbalance": variable("time", _residual(machine, angle, end), "share of the unbalance that is left"),
    }
    locking = _rotor_phases(machine, angle, time) if is_locking(machine) else {}
    if locking:
        frequency = frequency_of(machine) if machine.shaken is not None else None
        long_name = "phase of a rotor to the first" if frequency is None else "phase of a rotor to the vibration"
        found["rotor_phase"] = _phases(machine, locking, len(time), long_name)
        driven = math.nan if frequency is None else frequency
        found["vibration_frequency"] = variable("", driven, "frequency of the vibration", units.speed)
    if machine.sliders:
        slid = [row[x.coordinate.position.name] for x in machine.sliders]
        found["slider_displacement"] = variable("slider time", slid, "displacement in the guide", units.length)
        slid = [row[x.coordinate.velocity.name] for x in machine.sliders]
        found["slider_velocity"] = variable("slider time", slid, "velocity in the guide", f"{units.length}/{units.time}")
    relative = {b.name: angle[b.name] - angle[b.about] for b in machine.bodies if b.about is not None}
    if relative:
        found["phase"] = _phases(machine, relative, len(time), "phase to the body turned about")
    return found


def _phases(machine: Machine, phases: Mapping[str, np.ndarray], count: int, long_name: str) -> Variable:
    """Phases of some bodies in [0, 2 pi), not a number for the others."""
    rows = [np.mod(phases[b.name], 2 * math.pi) if b.name in phases else np.full(count, np.nan) for b in machine.bodies]
    return variable("body time", rows, long_name, "rad")


def _rotor_phases(machine: Machine, angle: Mapping[str, np.ndarray], time: np.ndarray) -> dict[str, np.ndarray]:
    """sigma phi - Omega t of the main rotor on a shaken carrier, else sigma_i phi_i - sigma_1 phi_1 of the other rotors."""
    turned = {r.name: math.copysign(1.0, angle[r.name][-1] - angle[r.name][0]) * angle[r.name] for r in machine.rotors}
    main, frequency = machine.rotor.name, frequency_of(machine)
    if machine.shaken is not None and frequency is not None:
        return {main: turned[main] - frequency * time}
    return {name: a - turned[main] for name, a in turned.items() if name != main}


def _vibration(machine: Machine, row: Rows, time: np.ndarray) -> Variables:
    units = machine.units
    natural = natural_frequencies(machine.at(float(time[-1]) if len(time) else 0.0))
    names = [(c.position.name, c.velocity.name) for c in machine.carrier]
    displacement = np.array([row[q] for q, _ in names]).reshape(len(names), len(time))
    velocity = np.array([row[v] for _, v in names]).reshape(len(names), len(time))
    force = np.array([row[f"bearing_force_{d}"] for d in machine.labels]).reshape(len(names), len(time))
    orbit = Orbit.of(machine, time, row)
    peaks = orbit.peaks
    amplitude = _envelope(time, peaks, row[machine.rotor.coordinate.velocity.name], natural)
    per_time = f"{units.length}/{units.time}" if units.time else ""
    return {
        "displacement": variable("direction time", displacement, "displacement of the carrier (r: rad)", units.length),
        "velocity": variable("direction time", velocity, "velocity of the carrier (r: rad/s)", per_time),
        "bearing_force": variable("direction time", force, "bearing force (r: moment)", units.force),
        "radius": variable("time", orbit.distance, "distance of the axis from its static position", machine.orbit_unit),
        "amplitude": variable("time", amplitude, "amplitude of the axis", machine.orbit_unit),
        "peak_amplitude": variable("", float(peaks.max(initial=0.0)), "largest amplitude of the axis", machine.orbit_unit),
    }


def _envelope(time: np.ndarray, peaks: np.ndarray, speed: np.ndarray, natural: Mapping[str, float]) -> np.ndarray:
    """The amplitude (N,): the line through the peaks of the axis' distance from where it rests.

    A valley counts as part of the orbit if it is shorter than half a turn, or half a free vibration while the rotor is slower
    than that.
    """
    if not peaks.any():
        return peaks
    slowest = min((f for f in natural.values() if f > 0), default=0.0)
    rate = np.maximum(np.abs(speed), slowest)
    return envelope(time, peaks, np.divide(math.pi, rate, out=np.zeros_like(rate), where=rate > 0))


def _residual(machine: Machine, angle: Mapping[str, np.ndarray], end: float) -> np.ndarray:
    bodies = machine.group(machine.rotor)
    own = unbalances(machine.at(end))
    vector = sum(own[machine.bodies.index(b)] * np.exp(1j * angle[b.name]) for b in bodies)
    scale = abs(own[machine.bodies.index(machine.rotor)]) or np.abs(own).max() or 1.0
    found: np.ndarray = np.abs(vector) / scale
    return found


def _energy(machine: Machine, row: Rows, trajectory: Trajectory) -> Variables:
    """Stored energy, the works, and the residual of their balance."""
    stored, units = row["stored_energy"], machine.units
    _, residual = EnergyBalance().after(stored, trajectory.quadratures)
    found = {
        "stored_energy": variable("time", stored, "stored energy", units.energy),
        "energy_residual": variable("time", residual, "energy residual, relative"),
    }
    for quadrature in machine.system.quadratures:
        values = trajectory.quadratures[quadrature.name]
        found[quadrature.name] = variable("time", values, quadrature.long_name, quadrature.unit)
    return found
