"""The variables of a motion in a Dataset: what was computed, with names and units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from wucht.analysis.vibration import moments_along_guides, unbalance_scale, unbalances
from wucht.dynamics.verdicts.locking import is_locking, rotor_phases
from wucht.dynamics.verdicts.observables import Orbit, Rows, balanced
from wucht.fields import in_words
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.span_record import Spans
from wucht.numerics.peaks import envelope
from wucht.results.conventions import Variable, variable

Variables = dict[str, Variable]
_TORQUES = {
    "motor_torque": "torque of the motor at the speed of the rotor, before the loss of a transmission",
    "drive_torque": "torque of the drive on the rotor, after the loss of a transmission",
}


def variables(machine: Machine, row: Rows, trajectory: Trajectory, largest: float) -> tuple[Variables, Variables]:
    """Coordinates and data of a run. row: the states and outputs of the machine's System, (N,) each. largest: amplitude.

    Coordinates: time (N), body, direction. Variables: angle, speed, phase (of bodies that turn about another), rotor_phase (of
    rotors that may be entrained) (body, time); displacement, velocity, bearing_force (of the bodies on the carrier, not of it
    on them) (direction, time); radius, amplitude,
    motor_torque (at the speed of the rotor, before the loss of a transmission), drive_torque (what of it acts on the rotor),
    motor_power, stored_energy, supplied_work, dissipated_work, energy_residual, residual_unbalance (time);
    peak_amplitude, free_speed; slider_displacement, slider_velocity (slider, time); the states of parts' own by their paths,
    such as ``left.lining`` (time); rotor_bearing_force (rotor, plane, time) of several rotors, each with the bodies about it,
    in the directions in which the carrier translates.
    """
    data = _rotation(machine, row, trajectory.time) | _of_parts(machine, row)
    data |= _vibration(machine, row, trajectory.time, largest) | _energy(machine, row, trajectory)
    coordinates = {
        "time": variable("time", trajectory.time, "time", machine.units.time),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "direction": variable("direction", list(machine.labels) or np.empty(0, "U1"), "direction"),
    }
    if machine.sliders:
        coordinates["slider"] = variable("slider", [x.name for x in machine.sliders], "slider")
    ways = [d for d in "xy" if d in machine.labels]
    if ways and len(machine.rotors) > 1:
        rotors = [r.name for r in machine.rotors]
        forces = np.array([[row[f"bearing_force[{name}]_{d}"] for d in ways] for name in rotors])
        long_name = "bearing force of a rotor on the carrier"
        data["rotor_bearing_force"] = variable("rotor plane time", forces, long_name, machine.units.force)
        coordinates["rotor"] = variable("rotor", rotors, "rotor")
        coordinates["plane"] = variable("plane", ways, "direction")
    return coordinates, data


def envelopes(machine: Machine, spans: Spans) -> Variables:
    """The limits of the main rotor's speed and of the axis' distance in spans of time that follow each other (span).

    They are those of the motion as it is integrated, however few of its samples are stored.
    """
    unit, static = machine.units.speed, "distance of the axis from its static position"
    rotor = f"speed of {machine.rotor.name}"
    return {
        "span_end": variable("span", spans.time, "time at the end of a span", machine.units.time),
        "least_speed": variable("span", spans.least_speed, f"least {rotor} in a span", unit),
        "greatest_speed": variable("span", spans.greatest_speed, f"greatest {rotor} in a span", unit),
        "least_radius": variable("span", spans.least_distance, f"least {static} in a span", machine.orbit_unit),
        "greatest_radius": variable("span", spans.greatest_distance, f"greatest {static} in a span", machine.orbit_unit),
    }


def _motion(coordinates: Sequence[Coordinate], row: Rows, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (n, N) of coordinates."""
    pairs = [(row[c.position.name], row[c.velocity.name]) for c in coordinates]
    motion: np.ndarray = np.array(pairs).reshape(len(pairs), 2, len(time))
    return motion[:, 0], motion[:, 1]


def _rotation(machine: Machine, row: Rows, time: np.ndarray) -> Variables:
    units, names, end = machine.units, [b.name for b in machine.bodies], float(time[-1])
    angles, speeds = _motion([b.coordinate for b in machine.bodies], row, time)
    angle, free = dict(zip(names, angles, strict=True)), free_speed(machine.at(end), machine.rotor, end)

    def phases(phase: Mapping[str, np.ndarray], long_name: str) -> Variable:
        """Phases of some bodies in [0, 2 pi), not a number for the others."""
        rows = [np.mod(phase[n], 2 * math.pi) if n in phase else np.full(len(time), np.nan) for n in names]
        return variable("body time", rows, long_name, "rad")

    data = {
        "angle": variable("body time", angles, "angle", "rad"),
        "speed": variable("body time", speeds, "speed", units.speed),
        "free_speed": variable("", free, "speed reached without vibration", units.speed),
        **{name: variable("time", row[name], long_name, units.torque) for name, long_name in _TORQUES.items()},
        "motor_power": variable("time", row["motor_power"], "motor power", units.power),
        "residual_unbalance": variable("time", _residual(machine, row, angle, end), "share of the unbalance that is left"),
    }
    if is_locking(machine):
        frequency, to = machine.shaking_frequency, rotor_phases(machine, time, {r.name: angle[r.name] for r in machine.rotors})
        if frequency is not None:
            to[machine.rotor.name] = to.pop("vibration")
        data["rotor_phase"] = phases(to, f"phase of a rotor to the {'first' if frequency is None else 'vibration'}")
        data["vibration_frequency"] = variable("", frequency, "frequency of the vibration", units.speed)
    if machine.sliders:
        displacement, velocity = _motion([x.coordinate for x in machine.sliders], row, time)
        data["slider_displacement"] = variable("slider time", displacement, "displacement in the guide", units.length)
        data["slider_velocity"] = variable("slider time", velocity, "velocity in the guide", f"{units.length}/{units.time}")
    relative = {b.name: angle[b.name] - angle[b.about] for b in machine.bodies if b.about is not None}
    if relative:
        data["phase"] = phases(relative, "phase to the body turned about")
    return data


def _vibration(machine: Machine, row: Rows, time: np.ndarray, largest: float) -> Variables:
    units, orbit = machine.units, Orbit.of(machine, time, row)
    displacement, velocity = _motion(machine.carrier, row, time)
    force, peaks = np.array([row[f"bearing_force_{d}"] for d in machine.labels]).reshape(displacement.shape), orbit.peaks
    natural = natural_frequencies(machine.at(float(time[-1])))
    before = 0.0 if orbit.begins_at_rest else None
    amplitude = _envelope(time, peaks, row[machine.rotor.coordinate.velocity.name], natural, machine.shaking_frequency, before)
    per_time = f"{units.length}/{units.time}" if units.time else ""
    return {
        "displacement": variable("direction time", displacement, "displacement of the carrier (r: rad)", units.length),
        "velocity": variable("direction time", velocity, "velocity of the carrier (r: rad/s)", per_time),
        "bearing_force": variable("direction time", force, "bearing force on the carrier (r: moment)", units.force),
        "radius": variable("time", orbit.distance, "distance of the axis from its static position", machine.orbit_unit),
        "amplitude": variable("time", amplitude, "amplitude of the axis", machine.orbit_unit),
        "peak_amplitude": variable("", largest, "largest amplitude of the axis", machine.orbit_unit),
    }


def _envelope(
    time: np.ndarray,
    peaks: np.ndarray,
    speed: np.ndarray,
    natural: Mapping[str, float],
    shaken: float | None,
    before: float | None,
) -> np.ndarray:
    """The amplitude (N,): the line through the peaks of the axis' distance from where it rests.

    A valley counts as part of the orbit if it is shorter than half a turn, or half a free vibration while the rotor is slower
    than that; or half a period of a prescribed vibration. before: what the distance was before the run, if that is known.
    """
    if not peaks.any():
        return peaks
    rate = np.maximum(np.abs(speed), min((f for f in natural.values() if f > 0), default=0.0))
    rate = rate if shaken is None else np.minimum(rate, abs(shaken))
    return envelope(time, peaks, np.divide(math.pi, rate, out=np.zeros_like(rate), where=rate > 0), before)


def _residual(machine: Machine, row: Rows, angle: Mapping[str, np.ndarray], end: float) -> np.ndarray:
    machine, rotor = machine.at(end), machine.rotor.name
    own, along = (dict(zip(angle, of(machine), strict=True)) for of in (unbalances, moments_along_guides))
    out = {x.name: along[x.name] * row[x.coordinate.position.name] for x in machine.sliders if x.name in along}
    vector = own[rotor] + np.zeros_like(angle[rotor])
    for name in (b.name for b in machine.group(machine.rotor) if b.name != rotor):
        vector = vector + (own[name] + out.get(name, 0.0)) * np.exp(1j * (angle[name] - angle[rotor]))
    return np.asarray(np.abs(vector) / unbalance_scale(machine, machine.rotor))


def _of_parts(machine: Machine, row: Rows) -> Variables:
    """The states of parts' own."""
    names = [(x.state.name, x.own) for x in machine.internal]
    return {name: variable("time", row[name], in_words(name, own.what), own.unit) for name, own in names}


def _energy(machine: Machine, row: Rows, trajectory: Trajectory) -> Variables:
    """Stored energy, the works, and the residual of their balance."""
    stored, works = row["stored_energy"], trajectory.quadratures
    _, residual = balanced(EnergyBalance(), stored, works)
    return {
        "stored_energy": variable("time", stored, "stored energy", machine.units.energy),
        "energy_residual": variable("time", residual, "energy residual, relative"),
    } | {q.name: variable("time", works[q.name], q.long_name, q.unit) for q in machine.system.quadratures}
