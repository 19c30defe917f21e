"""The variables of a run-up's Dataset: what was computed, with names and units."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import sympy as sp

from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import LOST, SUPPLIED, Machine
from wucht.machines.schedules import SCHEDULED
from wucht.machines.static import static_position
from wucht.machines.vibration import free_speed, group, unbalances
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.peaks import envelope, interval_peaks
from wucht.results.conventions import Variable, variable
from wucht.studies.locking import frequency_of, is_locking

Variables = dict[str, Variable]


def variables(machine: Machine, outputs: Mapping[str, np.ndarray], trajectory: Trajectory) -> tuple[Variables, Variables]:
    """Coordinates and data of a run. outputs: those of the machine's System, (N,) each.

    Coordinates: time (N), body, balancer (bodies that turn about another), direction. Variables: angle, speed (body, time);
    phase (balancer, time); displacement, velocity, bearing_force (direction, time); radius, amplitude, motor_torque,
    motor_power, stored_energy, supplied_work, dissipated_work, energy_residual, residual_unbalance (time); natural_frequency
    (mode); peak_amplitude, free_speed; slider_displacement, slider_velocity (slider, time).
    """
    row = dict(zip(machine.system.state_names, trajectory.states, strict=True)) | dict(outputs)
    balancers = [b.name for b in machine.bodies if b.about is not None]
    data = (
        _rotation(machine, row, trajectory.time)
        | _vibration(machine, row, trajectory.time)
        | _energy(machine, outputs, trajectory)
    )
    coordinates = {
        "time": variable("time", trajectory.time, "time", machine.units.time),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "direction": variable("direction", list(machine.labels) or np.empty(0, "U1"), "direction"),
        "mode": variable("mode", list(natural_frequencies(machine)) or np.empty(0, "U1"), "mode of vibration"),
        "balancer": variable("balancer", balancers or np.empty(0, "U1"), "balancing body"),
    }
    if "rotor_phase" in data:
        alone = machine.shaken is not None and frequency_of(machine) is not None
        names = [machine.rotor.name] if alone else [r.name for r in machine.rotors[1:]]
        coordinates["rotor"] = variable("rotor", names, "rotor")
        data["vibration_frequency"] = variable(
            "", (frequency_of(machine) or math.nan) if alone else math.nan, "frequency of the vibration", machine.units.speed
        )
    if machine.sliders:
        coordinates["slider"] = variable("slider", [x.name for x in machine.sliders], "slider")
    return coordinates, data


def _rotation(machine: Machine, row: Mapping[str, np.ndarray], time: np.ndarray) -> Variables:
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
        wrapped = [np.mod(phase, 2 * math.pi) for phase in locking.values()]
        found["rotor_phase"] = variable("rotor time", wrapped, "phase of a rotor to the first, or to the vibration", "rad")
    if machine.sliders:
        slid = [row[x.coordinate.position.name] for x in machine.sliders]
        found["slider_displacement"] = variable("slider time", slid, "displacement in the guide", units.length)
        slid = [row[x.coordinate.velocity.name] for x in machine.sliders]
        found["slider_velocity"] = variable("slider time", slid, "velocity in the guide", f"{units.length}/{units.time}")
    relative = [np.mod(angle[b.name] - angle[b.about], 2 * math.pi) for b in machine.bodies if b.about is not None]
    if relative:
        found["phase"] = variable("balancer time", relative, "phase to the body turned about", "rad")
    return found


def _rotor_phases(machine: Machine, angle: Mapping[str, np.ndarray], time: np.ndarray) -> dict[str, np.ndarray]:
    """sigma phi - Omega t of the main rotor on a shaken carrier, else sigma_i phi_i - sigma_1 phi_1 of the other rotors."""
    turned = {r.name: math.copysign(1.0, angle[r.name][-1] - angle[r.name][0]) * angle[r.name] for r in machine.rotors}
    main, frequency = machine.rotor.name, frequency_of(machine)
    if machine.shaken is not None and frequency is not None:
        return {main: turned[main] - frequency * time}
    return {name: a - turned[main] for name, a in turned.items() if name != main}


def _vibration(machine: Machine, row: Mapping[str, np.ndarray], time: np.ndarray) -> Variables:
    units = machine.units
    natural = natural_frequencies(machine.at(float(time[-1]) if len(time) else 0.0))
    names = [(c.position.name, c.velocity.name) for c in machine.carrier]
    displacement = np.array([row[q] for q, _ in names]).reshape(len(names), len(time))
    velocity = np.array([row[v] for _, v in names]).reshape(len(names), len(time))
    force = np.array([row[f"bearing_force_{d}"] for d in machine.labels]).reshape(len(names), len(time))
    at_rest = _static_orbit(machine)
    offset = np.array([row[f"orbit.{n}"] - at_rest[n] for n in machine.orbit]).reshape(-1, len(time))
    rate = np.array([row[f"orbit.v{n}"] for n in machine.orbit]).reshape(-1, len(time))
    distance = np.hypot.reduce(offset, axis=0) if len(offset) else np.zeros(len(time))
    amplitude, peak = _amplitude(time, offset, rate, row[machine.rotor.coordinate.velocity.name], natural)
    per_time = f"{units.length}/{units.time}" if units.time else ""
    return {
        "displacement": variable("direction time", displacement, "displacement of the carrier (r: rad)", units.length),
        "velocity": variable("direction time", velocity, "velocity of the carrier (r: rad/s)", per_time),
        "bearing_force": variable("direction time", force, "bearing force (r: moment)", units.force),
        "radius": variable("time", distance, "distance of the axis from its static position", machine.orbit_unit),
        "amplitude": variable("time", amplitude, "amplitude of the axis", machine.orbit_unit),
        "peak_amplitude": variable("", peak, "largest amplitude of the axis", machine.orbit_unit),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
    }


def _static_orbit(machine: Machine) -> dict[str, float]:
    """Where the axis rests under the load of the carrier."""
    at = dict(zip((c.position for c in machine.carrier), map(sp.Float, static_position(machine)), strict=True))
    numbers = {s: sp.Float(v) for s, v in machine.numbers.items()}
    return {n: float(x.xreplace(at | numbers)) for n, (x, _) in machine.orbit.items()}


def _amplitude(
    time: np.ndarray, offset: np.ndarray, velocity: np.ndarray, speed: np.ndarray, natural: Mapping[str, float]
) -> tuple[np.ndarray, float]:
    """The envelope of the axis' distance from its static position, and its peak.

    offset, velocity: (m, N). A valley counts as part of the orbit if it is shorter than half a turn, or half a free vibration
    while the rotor is slower than that.
    """
    if not len(offset):
        return np.zeros(len(time)), 0.0
    peaks = np.sqrt(np.maximum(interval_peaks(time, (offset**2).sum(axis=0), 2 * (offset * velocity).sum(axis=0)), 0.0))
    slowest = min((f for f in natural.values() if f > 0), default=0.0)
    rate = np.maximum(np.abs(speed), slowest)
    return envelope(time, peaks, np.divide(math.pi, rate, out=np.zeros_like(rate), where=rate > 0)), float(peaks.max())


def _residual(machine: Machine, angle: Mapping[str, np.ndarray], end: float) -> np.ndarray:
    bodies = group(machine, machine.rotor)
    own = unbalances(machine.at(end))
    vector = sum(own[machine.bodies.index(b)] * np.exp(1j * angle[b.name]) for b in bodies)
    scale = abs(own[machine.bodies.index(machine.rotor)]) or np.abs(own).max() or 1.0
    found: np.ndarray = np.abs(vector) / scale
    return found


def _energy(machine: Machine, outputs: Mapping[str, np.ndarray], trajectory: Trajectory) -> Variables:
    """The energy balance over time: |supplied - dissipated - change of stored| over the larger of work and stored energy."""
    stored, units = outputs["stored_energy"], machine.units
    supplied, lost = trajectory.quadratures[SUPPLIED], trajectory.quadratures[LOST]
    carried = trajectory.quadratures.get(SCHEDULED, np.zeros(len(stored)))
    gap = supplied + carried - lost - (stored - stored[:1])
    scale = (
        max(
            float(np.abs(carried).max(initial=0.0)),
            float(np.abs(supplied).max(initial=0.0)),
            float(np.abs(stored).max(initial=0.0)),
        )
        or 1.0
    )
    found = {
        "stored_energy": variable("time", stored, "stored energy", units.energy),
        "energy_residual": variable("time", np.abs(gap) / scale, "energy residual, relative"),
    }
    for quadrature in machine.system.quadratures:
        values = trajectory.quadratures[quadrature.name]
        found[quadrature.name] = variable("time", values, quadrature.long_name, quadrature.unit)
    return found
