"""A coast-down: the machine without its drives, the state from which it starts, and its record, leg by leg.

A few rows of the run are recorded, the speed averaged over each turn, and the time at which it has halved.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

import numpy as np

from wucht.analysis.configurations.configuration import Configuration
from wucht.analysis.foundation_forces import SupportDirection
from wucht.analysis.vibration import ForcedVibration
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state, speeds_in, start_gives
from wucht.dynamics.verdicts.observation import AxisMotion, Observation, advance_balance, rows_of
from wucht.errors import InputError
from wucht.machines.machine import DISSIPATED_WORK, Machine
from wucht.machines.operation import free_speed, sense_of
from wucht.machines.parts.base import Drive
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.turns import MARKS_PER_TURN, Samples, TurnObserver

MOST_ROWS = 8000
REVERSAL = "reversal"  # the event at which the main rotor turns back
ROW = ("time", "angle", "speed", "min_speed", "max_speed", "amplitude", "energy_residual", "dissipated_work")
_MERGE_RULES = {"min_speed": np.minimum, "max_speed": np.maximum, "amplitude": np.maximum}  # rows; of others the second stays
_REACH = 2 * MARKS_PER_TURN  # averages before and after the speed has halved, from which that time is interpolated
_SAMPLES_REACH = 2  # likewise, samples
_RESONANT = 1e-6  # of an undamped resonance: so near it the steady vibration has no bound


class CarrierStart(StrEnum):
    """The start of the carrier in a coast-down."""

    FIXED = "fixed"  # it has no free coordinate
    STEADY = "steady"  # vibrating as at the speeds of the start
    REST = "rest"
    GIVEN = "given"  # as study.start states


def without_drives(machine: Machine, drives: Sequence[Drive] | None = None) -> Machine:
    """Return the machine with drives switched off, by default all: no torque, no prescribed speed. Other losses stay.

    So does the inertia of a motor behind a gear, which without a torque of the motor loses nothing.
    """
    # The energies of a machine of parts are in the order of these.
    drive_rows = range(len(machine.energies)) if drives is None else [machine.parts.index(d) for d in drives]
    bodies = {b.name for b in machine.bodies} if drives is None else {d.on for d in drives}
    drives = machine.drives if drives is None else drives
    undriven = [
        tuple(a for a in e.applied_forces if i not in drive_rows or (a.energy_side != "supplied" and not a.of_drive))
        for i, e in enumerate(machine.energies)
    ]
    internal_states = [
        e.internal_states if len(e.applied_forces) == len(rest) else ()
        for e, rest in zip(machine.energies, undriven, strict=True)
    ]
    return machine.with_fields(
        bodies=tuple(
            replace(b, coordinate=replace(b.coordinate, prescribed_velocity=None)) if b.name in bodies else b
            for b in machine.bodies
        ),
        energies=tuple(
            replace(e, applied_forces=a, internal_states=x)
            for e, a, x in zip(machine.energies, undriven, internal_states, strict=True)
        ),
        parts=tuple(p for p in machine.parts if p not in drives),
        start_angles={name: angle for name, angle in machine.start_angles.items() if name not in bodies},
        schedules=tuple(s for s in machine.schedules if not any(s.parameter.startswith(f"{d.path}.") for d in drives)),
    )


def state_at_start(machine: Machine, coasting: Machine, start: Mapping[str, Any]) -> np.ndarray:
    """Return the state (n,) from which the machine without drives starts. Raises ``InputError``."""
    state = initial_state(coasting, start)
    for rotor in machine.rotors:
        row = coasting.row(rotor.coordinate.velocity)
        if rotor.name in machine.start_angles and not start_gives(start, rotor.name, "angle"):
            state[coasting.row(rotor.coordinate.position)] += machine.start_angles[rotor.name]
        if not start_gives(start, rotor.name, "speed") and rotor.release is None:
            state[row] = _driven_speed(machine, rotor)
        for body in machine.group(rotor)[1:]:
            if body.release is not None or not start_gives(start, body.name, "speed"):
                state[coasting.row(body.coordinate.velocity)] = state[row]
    if not state[coasting.row(machine.rotor.coordinate.velocity)]:
        raise InputError(
            "study.start", dict(start) or None,
            f"nothing turns: the machine has no drive to give {machine.rotor.name} a speed; "
            f'give start = {{ {machine.rotor.name} = {{ speed = "100 rad/s" }} }}',
        )  # fmt: skip
    return state


def state_in_configuration(
    machine: Machine, state: np.ndarray, c: Configuration, senses: Mapping[str, float], start: Mapping[str, Any]
) -> np.ndarray:
    """Return a state (n,) of a machine without drives with its bodies in a configuration of its rotors.

    The main rotor keeps its angle. All turn at the speed of the configuration, or at that which the start gives to the main
    rotor, except for rotors whose speed the start gives. senses: +1 or -1 of each body, as the drives turn it.
    """
    placed_state, main = state.copy(), machine.rotor
    angle = senses[main.name] * state[machine.row(main.coordinate.position)]
    speed = abs(c.speed)
    if start_gives(start, main.name, "speed"):
        speed = abs(float(state[machine.row(main.coordinate.velocity)]))
    for rotor in machine.rotors:
        row = machine.row(rotor.coordinate.velocity)
        if not start_gives(start, rotor.name, "speed"):
            placed_state[row] = senses[rotor.name] * speed
        if rotor is not main:
            placed_state[machine.row(rotor.coordinate.position)] = senses[rotor.name] * (angle + c.phases[rotor.name])
        for body in machine.group(rotor)[1:]:
            if not start_gives(start, body.name, "speed"):
                placed_state[machine.row(body.coordinate.velocity)] = placed_state[row]
    return place_bodies(machine, placed_state, {b.name: c.phases[b.name] for b in machine.bodies if b.about is not None})


def driving_machine(machine: Machine) -> Machine:
    """Return the machine at the end of its schedules, or when they last drive its main rotor."""
    times = reversed(machine.breakpoints)
    driven = (at for t in times if free_speed(at := machine.at(t).with_fields(schedules=()), at.rotor))
    return next(driven, machine)


def place_bodies(machine: Machine, state: np.ndarray, to_rotor: Mapping[str, float]) -> np.ndarray:
    """Return a state (n,) with bodies at given angles to the rotors that they turn about, from the inside outwards."""
    shifted_state = state.copy()
    for body in machine.outward:
        if body.about is not None and body.name in to_rotor:
            head = shifted_state[machine.row(machine.body(body.about).coordinate.position)]
            shifted_state[machine.row(body.coordinate.position)] = head + to_rotor[body.name]
    return shifted_state


def phases_of_bodies(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The angles of the balancing bodies relative to their rotor in a state (n,), by name."""
    angles = angles_in(machine, state)
    return {b.name: angles[b.name] - angles[b.about] for b in machine.bodies if b.about is not None}


def carrier_start(machine: Machine, start: Mapping[str, Any], vibration: str | None) -> tuple[CarrierStart, str]:
    """Return how the carrier starts, and the reason if it starts at rest by default."""
    if not machine.free_carrier:
        return CarrierStart.FIXED, ""
    if "carrier" in start:
        return CarrierStart.GIVEN, ""
    if vibration is None:
        at = machine.at(0.0)
        try:
            ForcedVibration.of(at, np.zeros(len(at.bodies)))
        except InputError as error:
            return CarrierStart.REST, error.explanation
    return (CarrierStart.REST if vibration == "none" else CarrierStart.STEADY), ""


def vibrating_state(
    machine: Machine, state: np.ndarray, start: Mapping[str, Any], vibration: str | None
) -> tuple[np.ndarray, CarrierStart, str]:
    """Return a state (n,), given with the carrier at rest, with the carrier's start; how it starts, and why at rest.

    machine: with its bodies where the state has them. Raises ``InputError`` where the vibration is unbounded.
    """
    carrier, rest_reason = carrier_start(machine, start, vibration)
    return (with_steady_vibration(machine, state) if carrier is CarrierStart.STEADY else state), carrier, rest_reason


def with_steady_vibration(machine: Machine, state: np.ndarray) -> np.ndarray:
    """Add its steady vibration to a state (n,) in which the carrier rests. Raises ``InputError`` if it is unbounded."""
    at = machine.at(0.0)
    senses = np.array([sense_of(at, body) for body in at.bodies])
    angles, speeds = (senses * np.array(list(read_values(at, state).values())) for read_values in (angles_in, speeds_in))
    forced_vibration = ForcedVibration.of(at, senses * angles)
    if any(
        math.isclose(w, abs(w0), rel_tol=_RESONANT)
        for w in forced_vibration.undamped_resonances(0.0, math.inf)
        for w0 in speeds
    ):
        raise InputError(
            "study.vibration", None,
            "the machine starts at a resonance without damping, where its steady vibration has no bound; give another "
            "speed in study.start, damping, or vibration = 'none' to start with the carrier at rest",
        )  # fmt: skip
    displacements, velocities = forced_vibration.vibration.instant_motion(speeds, angles)
    shifted_state = state.copy()
    for c, x, v in zip(at.free_carrier, displacements, velocities, strict=True):
        shifted_state[at.row(c.position)] += x
        shifted_state[at.row(c.velocity)] = v
    return shifted_state


def _driven_speed(machine: Machine, rotor: RotatingBody) -> float:
    """The speed that a rotor's drive reaches, 0 without one; with schedules, at their end, or when they last drive it."""
    driven = (
        any(a.energy_side == "supplied" for e in machine.energies for a in e.applied_forces)
        or rotor.coordinate.prescribed_velocity is not None
    )
    times = reversed(machine.breakpoints) if driven else ()
    return next((speed for t in times if (speed := free_speed(machine.at(t), rotor))), 0.0)


@dataclass(frozen=True, kw_only=True)
class Record:
    """The record of the run so far, or of its next leg: a unit of work.

    start_speed: of the main rotor, with which the run began. stride: the time between rows. legs: how many there are.
    rows: columns (N,) by the names of ``ROW``, and the angles of further rotors (``further_angle``); extremes are those since
    the row before. turns: the time in the middle of each turn up to the first reversal, and the mean speed over it (2, K).
    reversals: when the rotor turns back. observer: averages over turns; averages: how many there were. halving: time and speed
    (2, k) of those around the moment at which the speed has fallen to half of that at the start, or of the last ones; samples
    around it before the first turn. end: the last sample, from which the run continues. observation: until there.
    foundation_forces: the largest until there, beyond those at rest.
    """

    start_speed: float
    stride: float
    end: Trajectory
    legs: int = 0
    rows: dict[str, np.ndarray] = field(default_factory=lambda: dict.fromkeys(ROW, np.empty(0)))
    turns: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    reversals: tuple[float, ...] = ()
    observer: TurnObserver = field(default_factory=TurnObserver)
    averages: int = 0
    halving: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    balance: EnergyBalance = field(default_factory=EnergyBalance)
    observation: Observation | None = None
    foundation_forces: Mapping[SupportDirection, float] = field(default_factory=dict)

    @property
    def half_time(self) -> float | None:
        """The time at which the speed averaged over a turn (without a turn, the speed itself) is half of that at the start."""
        return _halving_time(self.halving[0], self.halving[1], abs(self.start_speed) / 2)

    def update(self, leg: Record) -> Record:
        """Return the record with the next leg; if there are too many rows, each two become one."""
        rows = {name: np.append(self.rows.get(name, ()), column) for name, column in leg.rows.items()}
        stride = self.stride
        if len(rows["time"]) > MOST_ROWS:
            rows, stride = {name: _thin_rows(name, column) for name, column in rows.items()}, 2 * stride
        turns, reversals = np.append(self.turns, leg.turns, axis=1), self.reversals + leg.reversals
        return replace(leg, rows=rows, turns=turns, reversals=reversals, stride=stride, legs=self.legs + 1)


def further_angle(rotor: str) -> str:
    """The name of the column of the angle of a further rotor, beside the main one."""
    return f"angle[{rotor}]"


def _thin_rows(name: str, column: np.ndarray) -> np.ndarray:
    """Keep the first row, and merge each two after it into one, with the extremes of both."""
    even = len(column) - 1 + len(column) % 2
    first, second = column[1:even:2], column[2:even:2]
    return np.concatenate([column[:1], _MERGE_RULES[name](first, second) if name in _MERGE_RULES else second, column[even:]])


def reduce_leg(
    machine: Machine, at_rest: Mapping[str, float], compiled_system: CompiledSystem, before: Record, t: Trajectory
) -> Record:
    """Reduce a leg that begins with the last sample of the record. at_rest: the rest position of the carrier's axis."""
    outputs, rotor = rows_of(compiled_system, t), machine.rotor.coordinate
    time, angle, speed = t.time, outputs[rotor.position.name], outputs[rotor.velocity.name]
    balance, residual = advance_balance(before.balance, outputs["stored_energy"], t.quadratures)
    amplitude = AxisMotion.of(machine, time, outputs, at_rest).peaks
    # A row ends with one sample a stride, with the last one of the leg, and with the very first of the run.
    width, row_offset = max(1, round(before.stride / (time[1] - time[0]))) if len(time) > 1 else 1, int(before.legs > 0)
    last = np.unique([*range(width * row_offset, len(time), width), len(time) - 1])
    last = last[last >= row_offset]
    first = np.append(0, last)[: len(last)].astype(int)  # a row covers the samples from the end of the row before
    rows = {
        "time": time[last],
        "angle": angle[last],
        "speed": speed[last],
        "min_speed": np.minimum(np.minimum.reduceat(speed, first), speed[last]),
        "max_speed": np.maximum(np.maximum.reduceat(speed, first), speed[last]),
        "amplitude": np.maximum(np.maximum.reduceat(amplitude, first), amplitude[last]),
        "energy_residual": residual[last],
        "dissipated_work": t.quadratures[DISSIPATED_WORK][last],
    } | {further_angle(r.name): outputs[r.coordinate.position.name][last] for r in machine.rotors[1:]}
    reversals = tuple(h.time for h in t.hits if h.name == REVERSAL)
    at_end = replace(t.tail(1), hits=())
    leg = Record(
        start_speed=before.start_speed, stride=before.stride, end=at_end, rows=rows, reversals=reversals, balance=balance
    )
    if before.reversals:
        return replace(leg, averages=before.averages, halving=before.halving)
    observer, turn_means = before.observer.update(Samples.of(time, (angle, speed)))
    turn_means = turn_means.part(turn_means.passage == 0)
    number = before.averages + np.arange(len(turn_means.time))
    mean = np.array([turn_means.middle, turn_means.speed])
    turns, averages, half = mean[:, number % MARKS_PER_TURN == 0], before.averages + len(number), abs(before.start_speed) / 2
    # If it halves before the first whole turn, the speed itself is used.
    by_turns = bool(before.averages or (averages and abs(mean[1, 0]) > half))
    earlier_points = before.halving if before.averages or not by_turns else np.empty((2, 0))
    points = np.append(earlier_points, mean if by_turns else np.array([time, speed]), axis=1)
    halving = _points_around(points, half, _REACH if by_turns else _SAMPLES_REACH)
    return replace(leg, turns=turns, observer=observer, averages=averages, halving=halving)


def _points_around(points: np.ndarray, half: float, reach: int) -> np.ndarray:
    """Select those of times and speeds (2, k) around the moment at which the speed has halved, else the last ones."""
    i = _crossing(points[1], half)
    return points[:, -reach:] if i is None else points[:, max(0, i + 1 - reach) : i + 1 + reach]


def _crossing(speed: np.ndarray, half: float) -> int | None:
    """The index of the last point before the speed falls to half; None if it does not."""
    excess = np.abs(speed) - half
    below = np.flatnonzero((excess[:-1] > 0) & (excess[1:] <= 0))
    return int(below[0]) if len(below) else None


def _halving_time(time: np.ndarray, speed: np.ndarray, half: float) -> float | None:
    """The time at which the speed falls to half: a root of the cubic through the points around it. None if it does not."""
    i, excess = _crossing(speed, half), np.abs(speed) - half
    if i is None:
        return None
    straight = time[i] + excess[i] / (excess[i] - excess[i + 1]) * (time[i + 1] - time[i])
    if len(time) < 4:
        return float(straight)
    roots = np.polynomial.Polynomial.fit(time, excess, 3).roots()
    real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots).max()].real
    return float(min(real, key=lambda r: abs(r - straight), default=straight))
