"""A drive that loses its supply in operation: what becomes of the machine, and which torques the other drives give."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.analysis.throw import Throw
from wucht.dynamics.run_ups.coasting import without_drives
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.operating_state import transfer_state
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.mechanics.energies import AppliedForce
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.observers.records import smooth_weights

_FEWEST_SAMPLES = 8
# Verdicts on the main rotor, which may be the one without supply.
_AT_REST = {Outcome.NOT_STARTED: "does not start", Outcome.STOPPED: "stops", Outcome.OSCILLATING: "oscillates"}


def check_drives(machine: Machine) -> None:
    """Raise ``InputError`` unless there are drives of several rotors, each with a torque."""
    driven_rotors = {machine.rotor_of(machine.body(d.on)).name for d in machine.drives}
    if len(driven_rotors) < 2:
        requirement = "there must be at least two rotors with drives, which go on without one of them"
        alone = "a machine that loses its only drive is the study coast-down"
        raise InputError("machine.drives", len(machine.drives), f"{requirement}; {alone}", code="too-few")
    for drive in machine.drives:
        if drive.prescribed_body_speed() is not None:
            requirement = "must be a drive with a torque: this one enforces its speed whatever the other rotors do"
            raise InputError(f"machine.{drive.path}.kind", drive.kind, requirement, code="prescribed")


def machine_without_supply(machine: Machine, drive: Drive) -> Machine:
    """Return the machine with a drive that is cut off from its supply: it gives no torque, and does not brake.

    A motor that gives none without voltage keeps its equations, which are those of the machine before.
    """
    voltage = sp.Symbol(f"{drive.path}.voltage", real=True)
    motors = [a.force for a in _motor_forces(machine, drive)]
    if voltage.name in machine.values and all(sp.sympify(force).xreplace({voltage: sp.S.Zero}) == 0 for force in motors):
        return machine.with_unchecked_values({voltage.name: 0.0})
    return without_drives(machine, [drive])


def case_without_drive(operation: Motion, drive: Drive, settings: RunSettings) -> RunUpCase:
    """Return the run of a machine whose drive loses its supply at the end of its operation, in the state reached there."""
    machine, trajectory = operation.case.machine, operation.trajectory
    remaining = machine_without_supply(machine, drive)
    state = transfer_state(machine, trajectory.states[:, -1], remaining, trajectory.end_time)
    return RunUpCase.from_state(remaining, state, settings)


@dataclass(frozen=True)
class RunningState:
    """How a machine runs at the end of a motion, in the window of its verdict.

    outcome, sentence: for all rotors together. speeds: mean, by rotor, with their signs. phases: of the other rotors to the
    main one and of the bodies to their rotor, None unless synchronised. throw: of the carrier's centre of mass, None where
    it does not translate. amplitude: the largest of the main rotor's axis. torques: mean, by the rotor of the drive.
    """

    outcome: Outcome
    sentence: str
    speeds: dict[str, float]
    phases: dict[str, float] | None
    throw: Throw | None
    amplitude: float
    torques: dict[str, float]

    @classmethod
    def of(cls, motion: Motion, drives: tuple[Drive, ...]) -> RunningState:
        """The state at the end of a motion. drives: of the machine before, of which one may be switched off."""
        machine, verdict, trajectory = motion.case.machine, motion.verdict, motion.trajectory
        inside = (trajectory.time >= verdict.window[0]) & (trajectory.time <= verdict.window[1])
        if np.count_nonzero(inside) < _FEWEST_SAMPLES:
            inside = np.arange(len(trajectory.time)) >= len(trajectory.time) - _FEWEST_SAMPLES
        time, states = trajectory.time[inside], trajectory.states[:, inside]
        speeds = _mean_speeds(machine, time, states) if verdict.locking is None else verdict.locking.final_speeds
        outcome, sentence = _outcome(machine, verdict.outcome, verdict.sentence, time, speeds)
        phases = None
        if outcome is Outcome.SYNCHRONISED and verdict.locking is not None:
            phases = {**verdict.locking.phases, **verdict.phases}
        spans = motion.observation.main.last(1.0)
        # Locked rotors may still swing against each other: their mean torques are over the half of the run that is judged.
        begin = float(time[0]) if verdict.locking is None else verdict.locking.window[0]
        late = (trajectory.time >= min(begin, float(time[0]))) & (trajectory.time <= time[-1])
        torques = mean_torques(
            machine, drives, trajectory.time[late], trajectory.states[:, late], trajectory.final_parameter_values
        )
        throw = _throw(machine, time, states)
        noise = Noise.of(motion.compiled_system.tolerance).angle * motion.observation.largest
        return cls(
            outcome, sentence, speeds, phases, throw and throw.beyond(noise),
            float(spans.greatest_distance[spans.time >= time[0]].max(initial=0.0)),
            torques,
        )  # fmt: skip


def _mean_speeds(machine: Machine, time: np.ndarray, states: np.ndarray) -> dict[str, float]:
    duration = float(time[-1] - time[0]) if len(time) > 1 else 0.0
    angles = {r.name: states[machine.row(r.coordinate.position)] for r in machine.rotors}
    return {name: float(angle[-1] - angle[0]) / duration if duration else 0.0 for name, angle in angles.items()}


def _outcome(
    machine: Machine, outcome: Outcome, sentence: str, time: np.ndarray, speeds: dict[str, float]
) -> tuple[Outcome, str]:
    """Return the outcome for all rotors: they are not synchronised where the main one rests or swings and another one turns."""
    turns = {name: abs(speed) * float(time[-1] - time[0]) / (2 * math.pi) for name, speed in speeds.items()}
    turning = [name for name, count in turns.items() if count >= 1 and name != machine.rotor.name]
    if outcome in _AT_REST and turning:
        return (
            Outcome.NOT_SYNCHRONISED,
            f"{machine.rotor.name} {_AT_REST[outcome]}, {', '.join(turning)} {'turns' if len(turning) == 1 else 'turn'}",
        )
    return outcome, sentence


def _throw(machine: Machine, time: np.ndarray, states: np.ndarray) -> Throw | None:
    if machine.dimensionless or not {"x", "y"} & set(machine.free_labels) or len(time) < _FEWEST_SAMPLES:
        return None
    zero = np.zeros((2, len(time)))
    motions = {
        label: states[[machine.row(c.position), machine.row(c.velocity)]]
        for label, c in zip(machine.labels, machine.carrier, strict=True)
        if c.prescribed_velocity is None
    }
    place, velocity = np.array([motions.get(d, zero) for d in "xy"]).transpose(1, 0, 2)
    return Throw.from_samples(time, place, velocity)


def mean_torques(
    machine: Machine, drives: tuple[Drive, ...], time: np.ndarray, states: np.ndarray, values: np.ndarray
) -> dict[str, float]:
    """Return the mean torque of each drive on its body, by the body's name; zero of those that are switched off.

    It is that of the motor, reduced to the body, before the loss of a transmission. time: (N,), states: (n, N).
    """
    expressions = [drive_torque(machine, d) for d in drives]
    rows = Evaluator.of(machine.system, expressions, [d.on for d in drives])(time, states, values)
    weights = smooth_weights(len(time)) * np.gradient(time) if len(time) > 2 else np.ones(len(time))
    return {name: float(np.average(row, weights=weights)) for name, row in rows.items()}


def drive_torque(machine: Machine, drive: Drive) -> sp.Expr:
    """Return the torque of a drive on its body, as the machine's System has it; zero of one that is switched off."""
    velocity = machine.body(drive.on).coordinate.velocity
    return sp.Add(*(a.force * sp.diff(a.rate, velocity) for a in _motor_forces(machine, drive)))


def _motor_forces(machine: Machine, drive: Drive) -> list[AppliedForce]:
    return [a for e in machine.energies for a in e.applied_forces if a.energy_side == "supplied" and a.name == drive.path]
