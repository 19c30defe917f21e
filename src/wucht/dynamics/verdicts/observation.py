"""Observation of a machine's motion while it runs: a pure function of the motion, however little of it is stored."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from wucht.analysis.vibration import moments_along_guides, unbalance_scale, unbalances
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import AMPLITUDE_TOLERANCE
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK, Machine
from wucht.machines.operation import axis_at_rest, rotor_inertia, sense_of
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.records import SpanRecord, TurnRecord
from wucht.numerics.observers.turns import Samples
from wucht.numerics.zeros_and_peaks import interval_peaks

_AT_REST = 1e-9  # of the largest: rounding
Rows = Mapping[str, np.ndarray]


def rows_of(compiled_system: CompiledSystem, t: Trajectory) -> dict[str, np.ndarray]:
    """Return the states and outputs (N,) of a trajectory, by name."""
    return dict(zip(compiled_system.system.state_names, t.states, strict=True)) | compiled_system.outputs(
        t.time, t.states, t.final_parameter_values
    )


@dataclass(frozen=True)
class AxisMotion:
    """Motion of the main rotor's axis about its rest position: offset and velocity (m, N), in the directions it has."""

    time: np.ndarray
    offset: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of(cls, machine: Machine, time: np.ndarray, rows: Rows, at_rest: Mapping[str, float] | None = None) -> AxisMotion:
        """Compute it from the outputs of the machine's System. at_rest: the rest position, if that is known already."""
        rest, shape = at_rest or axis_at_rest(machine), (len(machine.orbit), len(time))
        offset = np.array([rows[f"orbit.{n}"] - rest[n] for n in machine.orbit]).reshape(shape)
        return cls(time, offset, np.array([rows[f"orbit.v{n}"] for n in machine.orbit]).reshape(shape))

    @property
    def distance(self) -> np.ndarray:
        """The distance from the rest position (N,)."""
        return np.asarray(np.hypot.reduce(self.offset, axis=0))

    @property
    def square(self) -> np.ndarray:
        """The square of the distance (N,)."""
        return np.asarray((self.offset * self.offset).sum(axis=0))

    @property
    def square_rate(self) -> np.ndarray:
        """The derivative of the square (N,)."""
        return np.asarray(2 * (self.offset * self.velocity).sum(axis=0))

    @property
    def begins_at_rest(self) -> bool:
        """True if the axis rests in the first sample."""
        signals = (self.offset, self.velocity)
        return all(bool((np.abs(x[:, 0]) <= _AT_REST * np.abs(x).max(initial=0.0)).all()) for x in signals)

    @property
    def peaks(self) -> np.ndarray:
        """The largest distance (N,) between each sample and its neighbours."""
        return np.asarray(np.sqrt(np.maximum(interval_peaks(self.time, self.square, self.square_rate), 0.0)))


def advance_balance(before: EnergyBalance, stored_energy: np.ndarray, works: Rows) -> tuple[EnergyBalance, np.ndarray]:
    """Return the energy balance of the contract after a part of the motion, and the residual (N,) over it.

    stored_energy: (N,). works: since the start of the run, by quadrature; that of a schedule may be missing.
    """
    scheduled_work = works.get(SCHEDULE_WORK, np.zeros(len(stored_energy)))
    return before.update(stored_energy, np.array([works[SUPPLIED_WORK], scheduled_work]), works[DISSIPATED_WORK])


@dataclass(frozen=True)
class Observation:
    """A motion so far.

    rotors: turn by turn of each rotor, by name; its followers are all other bodies in the machine's order. vibration:
    by periods of a prescribed vibration, followed by all bodies. Their distance is that of the main rotor's axis from its
    rest position; largest: of it. main: the main rotor over time. noise: of the integration. end_time: of the motion so far.
    common: if several rotors are free to turn, the main rotor at the mean of their angles, turn by turn.
    further_rotors: over time, the free rotors beside the main one, by name.
    """

    rotors: Mapping[str, TurnRecord]
    vibration: TurnRecord | None
    main: SpanRecord
    noise: Noise
    largest: float = 0.0
    end_time: float = 0.0
    common: TurnRecord | None = None
    further_rotors: Mapping[str, SpanRecord] = field(default_factory=dict)


@dataclass(frozen=True)
class MotionObserver:
    """Observer of a machine. span: of time, in which the fastest motion is sampled several times. noise: of the integration."""

    machine: Machine
    span: float
    noise: Noise

    @cached_property
    def _orbit(self) -> Evaluator:
        system = self.machine.system
        names = [f"orbit.{v}{n}" for n in self.machine.orbit for v in ("", "v")]
        return Evaluator.of(system, [system.output(n).expression for n in names], names)

    @cached_property
    def _sliding(self) -> list[tuple[int, int, float]]:
        """For each body in which a mass slides: its number, the row of the displacement, and its moment in the unbalance."""
        machine, along = self.machine, moments_along_guides(self.machine).tolist()
        rows = {x.name: machine.row(x.coordinate.position) for x in machine.sliders}
        return [(i, rows[b.name], m) for i, (b, m) in enumerate(zip(machine.bodies, along, strict=True)) if m]

    @cached_property
    def _shares(self) -> dict[str, np.ndarray]:
        """By rotor, the factors (n, 1) that make bodies' unbalances shares of its unbalance; zero for other rotors' bodies."""
        machine = self.machine
        return {
            r.name: np.array([[float(b in machine.group(r)) / unbalance_scale(machine, r)] for b in machine.bodies])
            for r in machine.rotors
        }

    @cached_property
    def _common_shares(self) -> np.ndarray:
        """The shares of the bodies' angles (n,) in the common motion of several free rotors; empty without such.

        They are those of the rotors' inertias, with the senses in which they turn: the torques between the rotors, equal and
        opposite, do not change the mean.
        """
        machine = self.machine.at(self.machine.breakpoints[-1])
        inertias = {r: rotor_inertia(machine, r) for r in machine.rotors if r.coordinate.prescribed_velocity is None}
        if len(inertias) < 2:
            return np.empty(0)
        total = sum(inertias.values())
        return np.array([sense_of(machine, b) * inertias[b] / total if b in inertias else 0.0 for b in machine.bodies])

    @cached_property
    def _rest_position(self) -> dict[str, float]:
        return axis_at_rest(self.machine)

    def begin(self) -> Observation:
        """Return the empty observation."""
        other_count = len(self.machine.bodies) - 1
        shaken = self.machine.shaking_frequency is not None
        machine = self.machine.at(self.machine.breakpoints[-1])
        rotors = {r.name: TurnRecord(other_count, weights_of(machine, r)) for r in self.machine.rotors}
        common, vibration = (
            TurnRecord(other_count) if len(self._common_shares) else None,
            TurnRecord(other_count + 1) if shaken else None,
        )
        free = [r.name for r in self.machine.rotors if r.coordinate.prescribed_velocity is None]
        further_rotors = {name: SpanRecord(self.span) for name in free if name != self.machine.rotor.name}
        return Observation(rotors, vibration, SpanRecord(self.span), self.noise, common=common, further_rotors=further_rotors)

    def samples(self, motion: Trajectory) -> Samples:
        """Return the observed samples of the machine's motion: all bodies in their order."""
        samples = Samples.of(motion.time, *(motion_of(self.machine, motion, b) for b in self.machine.bodies))
        rows = self._orbit(motion.time, motion.states, motion.final_parameter_values)
        orbit = AxisMotion.of(self.machine, motion.time, rows, self._rest_position)
        moments = np.zeros_like(samples.angles) if self._sliding else samples.moments
        for body, row, moment in self._sliding:
            moments[body] = moment * motion.states[row]
        return replace(samples, square=orbit.square, rate=orbit.square_rate, moments=moments)

    def update(self, previous: Observation, motion: Trajectory) -> Observation:
        """Return the observation after a part of the motion: see ``update_from_samples``."""
        return self.update_from_samples(previous, self.samples(motion))

    def update_from_samples(self, previous: Observation, samples: Samples) -> Observation:
        """Return the observation after a part of the motion, which may begin with the last sample of the part before."""
        machine, names = self.machine, [b.name for b in self.machine.bodies]
        rotors, vibration, frequency = {}, previous.vibration, machine.shaking_frequency
        for name, record in previous.rotors.items():
            shares = replace(samples, moments=samples.moments * self._shares[name]) if self._sliding else samples
            rotors[name] = record.update(shares.relative_to(names.index(name)))
        lead = names.index(machine.rotor.name)
        main, common = previous.main.update(samples.only_body(lead)), previous.common
        if common is not None:
            mean = (self._common_shares @ of_bodies for of_bodies in (samples.angles, samples.speeds))
            common = common.update(samples.relative_to(lead).with_leading(*mean))
        if vibration is not None and frequency is not None:
            vibration = vibration.update(
                samples.with_reference(frequency * samples.time, np.full(len(samples.time), frequency))
            )
        square = float(interval_peaks(samples.time, samples.square, samples.rate).max())
        largest = max(previous.largest, math.sqrt(max(square, 0.0)))
        further_rotors = {
            name: record.update(samples.only_body(names.index(name))) for name, record in previous.further_rotors.items()
        }
        return Observation(rotors, vibration, main, previous.noise, largest, float(samples.time[-1]), common, further_rotors)


def speed_at_largest(machine: Machine, observation: Observation) -> float | None:
    """Return the main rotor's mean speed over the turn about the largest distance of a motion, with its sign.

    None where the axis does not move, or its largest distance lies in no whole turn: a rotor that swings has no such speed.
    """
    turn = observation.rotors[machine.rotor.name].largest_turn
    least = (1 - AMPLITUDE_TOLERANCE) * observation.largest
    return turn.speed if turn.distance >= least and turn.distance > 0 else None


def weights_of(machine: Machine, rotor: RotatingBody) -> tuple[complex, ...]:
    """Return the unbalances of a rotor and of all other bodies, zero for other rotors' bodies, as shares of the rotor's."""
    body_unbalances, bodies = unbalances(machine), machine.bodies
    group = [bodies.index(b) for b in machine.group(rotor)]
    scale = unbalance_scale(machine, rotor)
    weights = [body_unbalances[i] / scale if i in group else 0.0 for i in range(len(bodies))]
    return tuple(map(complex, [weights.pop(group[0]), *weights]))


def motion_of(machine: Machine, trajectory: Trajectory, body: RotatingBody) -> tuple[np.ndarray, np.ndarray]:
    """Return angle and speed of a body over a run, (N,) each."""
    angle = trajectory.states[machine.row(body.coordinate.position)]
    if body.coordinate.prescribed_velocity is not None:
        return angle, machine.prescribed_speed(body.coordinate, trajectory.time)
    return angle, trajectory.states[machine.row(body.coordinate.velocity)]


def fastest_speed(machine: Machine, motion: Trajectory) -> float:
    """The largest speed (rad per time) of a body of the machine in a motion, prescribed speeds included."""
    prescribed_coordinates = [b.coordinate for b in machine.bodies if b.coordinate.prescribed_velocity is not None]
    largest = [np.abs(machine.prescribed_speed(c, motion.time)).max(initial=0.0) for c in prescribed_coordinates]
    return float(max([fastest_speeds(machine, motion.states).max(initial=0.0), *largest]))


def fastest_speeds(machine: Machine, states: np.ndarray) -> np.ndarray:
    """The largest speed (N,) of a body that is free to turn, in each of states (n, N)."""
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed_velocity is None]
    return np.asarray(np.abs(states[free]).max(axis=0, initial=0.0))
