"""The variables of a motion, and of branches of steady states, in a Dataset, with names and units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.vibration import moments_along_guides, unbalance_scale, unbalances_over_time
from wucht.dynamics.verdicts.locking import is_locking, rotor_phases
from wucht.dynamics.verdicts.observation import AxisMotion, Rows, advance_balance
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed_from, natural_frequencies
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.angles import wrap_angle
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.records import Spans
from wucht.numerics.zeros_and_peaks import envelope
from wucht.results.quantities import Quantity
from wucht.schema import Parameter, full_name

if TYPE_CHECKING:
    from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
    from wucht.dynamics.branches.steady_states import Labels, SteadyStates
    from wucht.studies.answer import Answer, Column

VALUES = ("value", "second_value")  # columns with the values of parameters, whatever these are called
_TORQUES = {
    "motor_torque": "torque of the motor at the speed of the rotor, before the loss of a transmission",
    "drive_torque": "torque of the drive on the rotor, after the loss of a transmission",
}


def motion_quantities(machine: Machine, row: Rows, trajectory: Trajectory, largest: float) -> list[Quantity]:
    """Return the quantities of a run, the variables of its Dataset.

    row: states and outputs of the machine's System, (N,) each. largest: largest amplitude.
    """
    of_sliders = [Quantity("slider", [x.name for x in machine.sliders], "slider", "", "slider")] if machine.sliders else []
    return [
        Quantity("time", trajectory.time, "time", machine.units.time, "time"),
        Quantity("body", [b.name for b in machine.bodies], "body", "", "body"),
        Quantity("direction", list(machine.labels) or np.empty(0, "U1"), "direction", "", "direction"),
        *of_sliders,
        *_rotation(machine, row, trajectory.time),
        *_internal_state_quantities(machine, row),
        *_vibration(machine, row, trajectory.time, largest),
        *_energy(machine, row, trajectory),
        *_rotors(machine, row),
        *_mounts(machine),
    ]


def _rotors(machine: Machine, row: Rows) -> list[Quantity]:
    """Power and bearing force of each of several rotors."""
    ways, rotors = [d for d in "xy" if d in machine.labels], [r.name for r in machine.rotors]
    if len(rotors) < 2:
        return []
    powers = np.array([row[f"motor_power[{name}]"] for name in rotors])
    quantities = [
        Quantity("rotor", rotors, "rotor", "", "rotor"),
        Quantity("rotor_power", powers, "motor power of a rotor", machine.units.power, "rotor time"),
    ]
    if not ways:
        return quantities
    forces = np.array([[row[f"bearing_force[{name}]_{d}"] for d in ways] for name in rotors])
    what = "bearing force of a rotor, with the bodies about it, on the carrier"
    return [
        *quantities,
        Quantity("plane", ways, "direction", "", "plane"),
        Quantity("rotor_bearing_force", forces, what, machine.units.force, "rotor plane time"),
    ]


def _mounts(machine: Machine) -> list[Quantity]:
    """Places of the mounts on a planar carrier, from its centre of mass."""
    places: list[list[float]] = []
    while f"carrier.mounts.{len(places) + 1}.at.x" in machine.values:
        places.append([machine.values[f"carrier.mounts.{len(places) + 1}.at.{d}"] for d in "xy"])
    if not places:
        return []
    what = "place of a mount, from the carrier's centre of mass"
    return [Quantity(f"mount_{d}", [p[k] for p in places], what, machine.units.length, "mount") for k, d in enumerate("xy")]


def state_natural_vibrations(a: Answer, machine: Machine, in_summary: bool = True) -> None:
    """State the natural frequencies, as variables and in the summary."""
    natural = natural_frequencies(machine)
    a.curve("mode", list(natural) or np.empty(0, "U1"), "mode of vibration")
    a.curve("natural_frequency", list(natural.values()), "natural frequency", "speed", "mode")
    if in_summary:
        a.number("natural_frequencies", natural, "natural frequencies by mode", "speed")


def state_parameters(a: Answer, machine: Machine) -> None:
    """State the parameters of the machine, SI."""
    a.curve("parameter", list(machine.values), "parameter")
    a.curve("parameters", list(machine.values.values()), "parameter values", "", "parameter")


def envelopes(machine: Machine, spans: Spans) -> list[Quantity]:
    """Limits of the main rotor's speed and of the axis' distance in consecutive spans of time (span).

    They include all integrated samples, however few of them are stored.
    """
    unit, length, static = machine.units.speed, machine.orbit_unit, "distance of the axis from its static position"
    rotor = f"speed of {machine.rotor.name}"
    return [
        Quantity("span_end", spans.time, "time at the end of a span", machine.units.time, "span"),
        Quantity("least_speed", spans.least_speed, f"least {rotor} in a span", unit, "span"),
        Quantity("greatest_speed", spans.greatest_speed, f"greatest {rotor} in a span", unit, "span"),
        Quantity("least_radius", spans.least_distance, f"least {static} in a span", length, "span"),
        Quantity("greatest_radius", spans.greatest_distance, f"greatest {static} in a span", length, "span"),
    ]


def _motion(coordinates: Sequence[Coordinate], row: Rows, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (n, N) of coordinates."""
    pairs = [(row[c.position.name], row[c.velocity.name]) for c in coordinates]
    motion: np.ndarray = np.array(pairs).reshape(len(pairs), 2, len(time))
    return motion[:, 0], motion[:, 1]


def _rotation(machine: Machine, row: Rows, time: np.ndarray) -> list[Quantity]:
    units, names, end = machine.units, [b.name for b in machine.bodies], float(time[-1])
    angles, speeds = _motion([b.coordinate for b in machine.bodies], row, time)
    angle, final_speeds = (dict(zip(names, rows, strict=True)) for rows in (angles, speeds[:, -1].tolist()))
    free = free_speed_from(machine.at(end), machine.rotor, final_speeds[machine.rotor.name], end)

    def phases(name: str, phase: Mapping[str, np.ndarray], long_name: str) -> Quantity:
        """Phases of some bodies in [0, 2 pi), NaN for the others."""
        rows = [wrap_angle(phase[n]) if n in phase else np.full(len(time), np.nan) for n in names]
        return Quantity(name, rows, long_name, "rad", "body time")

    quantities = [
        Quantity("angle", angles, "angle", "rad", "body time"),
        Quantity("speed", speeds, "speed", units.speed, "body time"),
        Quantity("free_speed", free, "speed reached without vibration", units.speed, ""),
        *(Quantity(name, row[name], long_name, units.torque, "time") for name, long_name in _TORQUES.items()),
        Quantity("motor_power", row["motor_power"], "motor power", units.power, "time"),
        Quantity("residual_unbalance", _residual(machine, row, angle, time), "residual share of the unbalance", "", "time"),
    ]
    if is_locking(machine):
        frequency, to = machine.shaking_frequency, rotor_phases(machine, time, {r.name: angle[r.name] for r in machine.rotors})
        if frequency is not None:
            to[machine.rotor.name] = to.pop("vibration")
        quantities += [
            phases("rotor_phase", to, f"phase of a rotor to the {'first' if frequency is None else 'vibration'}"),
            Quantity("vibration_frequency", frequency, "frequency of the vibration", units.speed, ""),
        ]
    if machine.sliders:
        displacement, velocity = _motion([x.coordinate for x in machine.sliders], row, time)
        per_time = f"{units.length}/{units.time}"
        quantities += [
            Quantity("slider_displacement", displacement, "displacement in the guide", units.length, "slider time"),
            Quantity("slider_velocity", velocity, "velocity in the guide", per_time, "slider time"),
        ]
    relative = {b.name: angle[b.name] - angle[b.about] for b in machine.bodies if b.about is not None}
    return [*quantities, *([phases("phase", relative, "phase to the body turned about")] if relative else [])]


def _vibration(machine: Machine, row: Rows, time: np.ndarray, largest: float) -> list[Quantity]:
    units, orbit = machine.units, AxisMotion.of(machine, time, row)
    displacement, velocity = _motion(machine.carrier, row, time)
    force, peaks = np.array([row[f"bearing_force_{d}"] for d in machine.labels]).reshape(displacement.shape), orbit.peaks
    natural = natural_frequencies(machine.at(float(time[-1])))
    before = 0.0 if orbit.begins_at_rest else None
    amplitude = _envelope(time, peaks, row[machine.rotor.coordinate.velocity.name], natural, machine.shaking_frequency, before)
    per_time = f"{units.length}/{units.time}" if units.time else ""
    return [
        Quantity("displacement", displacement, "displacement of the carrier (r: rad)", units.length, "direction time"),
        Quantity("velocity", velocity, "velocity of the carrier (r: rad/s)", per_time, "direction time"),
        Quantity("bearing_force", force, "bearing force on the carrier (r: moment)", units.force, "direction time"),
        Quantity("radius", orbit.distance, "distance of the axis from its static position", machine.orbit_unit, "time"),
        Quantity("amplitude", amplitude, "amplitude of the axis", machine.orbit_unit, "time"),
        Quantity("peak_amplitude", largest, "largest amplitude of the axis", machine.orbit_unit, ""),
    ]


def _envelope(
    time: np.ndarray,
    peaks: np.ndarray,
    speed: np.ndarray,
    natural: Mapping[str, float],
    shaken: float | None,
    before: float | None,
) -> np.ndarray:
    """The amplitude (N,), the largest distance of the axis from its rest position within a turn: the line through its peaks.

    A valley counts as part of the orbit if it is shorter than a turn, or than a free vibration while the rotor is slower, or
    than a period of a prescribed vibration. before: the distance before the run, if it is known.
    """
    if not peaks.any():
        return peaks
    rate = np.maximum(np.abs(speed), min((f for f in natural.values() if f > 0), default=0.0))
    rate = rate if shaken is None else np.minimum(rate, abs(shaken))
    return envelope(time, peaks, np.divide(2 * math.pi, rate, out=np.zeros_like(rate), where=rate > 0), before)


def _residual(machine: Machine, row: Rows, angle: Mapping[str, np.ndarray], time: np.ndarray) -> np.ndarray:
    rotor, end = machine.rotor.name, machine.at(float(time[-1]))
    unbalance = dict(zip(angle, unbalances_over_time(machine, time), strict=True))
    along = dict(zip(angle, moments_along_guides(end), strict=True))
    out = {x.name: along[x.name] * row[x.coordinate.position.name] for x in machine.sliders if x.name in along}
    vector = unbalance[rotor] + np.zeros_like(angle[rotor])
    for name in (b.name for b in machine.group(machine.rotor) if b.name != rotor):
        vector = vector + (unbalance[name] + out.get(name, 0.0)) * np.exp(1j * (angle[name] - angle[rotor]))
    of_rotor = np.abs(unbalance[rotor])
    return np.asarray(np.abs(vector) / np.where(of_rotor > 0, of_rotor, unbalance_scale(end, end.rotor)))


def _internal_state_quantities(machine: Machine, row: Rows) -> list[Quantity]:
    """Internal states of parts."""
    names = [(x.state.name, x.description) for x in machine.internal]
    return [Quantity(name, row[name], full_name(name, facts.what), facts.unit, "time") for name, facts in names]


def _energy(machine: Machine, row: Rows, trajectory: Trajectory) -> list[Quantity]:
    """Stored energy, the works, and the residual of their balance."""
    stored_energy, works = row["stored_energy"], trajectory.quadratures
    _, residual = advance_balance(EnergyBalance(), stored_energy, works)
    return [
        Quantity("stored_energy", stored_energy, "stored energy", machine.units.energy, "time"),
        Quantity("energy_residual", residual, "energy residual, relative", "", "time"),
        *(Quantity(q.name, works[q.name], q.long_name, q.unit, "time") for q in machine.system.quadratures),
    ]


def join_arrays(parts: Sequence[Any], rows: int | None = None) -> np.ndarray:
    """Join the arrays (N,) or (rows, N) of all branches, one after another."""
    empty = np.empty(0) if rows is None else np.empty((rows, 0))
    return np.concatenate([empty, *parts], axis=-1)


def parameter_columns(*parameters: tuple[Parameter, Sequence[float | None]]) -> dict[str, Column]:
    """Return the columns of parameters with their values, each under its path, and as ``value`` and ``second_value``.

    One whose path is such a name has that meaning alone.
    """
    columns = [(values, along.full_name, along.unit) for along, values in parameters]
    paths = [along.path for along, _ in parameters]
    by_path = {path: column for path, column in zip(paths, columns, strict=True) if path not in VALUES}
    return by_path | dict(zip(VALUES, columns, strict=False))


def state_steady_points(
    a: Answer, dimension: str, before: str, branches: Sequence[EquilibriumBranch], steady_states: Sequence[SteadyStates],
    along: Parameter, labels: Labels,
) -> None:  # fmt: skip
    """State the points on branches of steady states.

    before: prefix of the names of variables. steady_states: of each branch. labels: names and units of the ordinates; user
    equations have neither speed nor amplitude.
    """
    numbers = np.repeat(np.arange(len(branches)), [b.unknowns.shape[1] for b in branches])
    a.curve(f"{before}value", join_arrays([b.parameter_values for b in branches]), along.full_name, along.unit, dimension)
    if not labels.of_equations:
        speeds = join_arrays([s.ordinate(b.unknowns) for s, b in zip(steady_states, branches, strict=True)])
        amplitudes = join_arrays([s.amplitude(b.unknowns) for s, b in zip(steady_states, branches, strict=True)])
        a.curve(f"{before}speed", speeds, labels.ordinate, labels.unit, dimension)
        a.curve(f"{before}amplitude", amplitudes, "amplitude of the axis", labels.length, dimension)
    stable = join_arrays([b.stable for b in branches])
    a.curve(f"{before}stable", stable.astype(np.int8), "stable", "", dimension)
    a.curve(f"{before}branch", numbers.astype(int), "branch", "", dimension)
