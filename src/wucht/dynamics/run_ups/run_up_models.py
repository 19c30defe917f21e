"""Equations of a run-up: the full ones, or the averaged ones with the full motion rebuilt from them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, states_with_fast_parts
from wucht.dynamics.run_ups.initial_state import angles_in, speeds_in
from wucht.errors import InputError
from wucht.machines.machine import DISSIPATED_WORK, Machine
from wucht.machines.operation import free_speed, has_damped_balancers
from wucht.mechanics.rotating_bodies.solution import ROTOR_ANGLE, VIBRATION_WORK
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory
from wucht.system import System

_AT_REST = 1e-12
_ANGLE = sp.Symbol(ROTOR_ANGLE, real=True)


@dataclass(frozen=True)
class FullModel:
    """The full equations, and the map from their trajectory to the machine's motion.

    initial: the state (k,) of their System to start from. warnings: what of the start they omit. remedies: what to try
    if the run fails. extension: their System where it has further works or, as its last ones, further parameters, with the
    further_values of these.
    """

    machine: Machine
    initial: np.ndarray
    warnings: tuple[str, ...] = ()
    remedies: tuple[str, ...] = ()
    extension: System | None = None
    further_values: tuple[float, ...] = ()
    name: ClassVar[str] = "full"

    @property
    def system(self) -> System:
        """The integrated System."""
        return self.extension or self.machine.system

    @property
    def parameter_values(self) -> tuple[float, ...]:
        """Parameter values in order."""
        return (*self.machine.system.values(self.machine.values), *self.further_values)

    def events(self, events: tuple[Event, ...]) -> tuple[Event, ...]:
        """Express events of the machine in these equations."""
        return events

    def machine_motion(self, trajectory: Trajectory) -> Trajectory:
        """Return the motion of the machine, without the further parameters."""
        if not self.further_values:
            return trajectory
        values = trajectory.final_parameter_values[: -len(self.further_values)]
        return replace(trajectory, final_parameter_values=values)

    def rows(self, trajectory: Trajectory, machine_motion: Trajectory) -> dict[str, np.ndarray]:
        """Return the states and outputs (N,) of the machine's System, by name."""
        states = dict(zip(self.machine.state_names, machine_motion.states, strict=True))
        return states | Evaluator.of_outputs(self.machine.system)(
            machine_motion.time, machine_motion.states, machine_motion.final_parameter_values
        )


@dataclass(frozen=True)
class SlowModel(FullModel):
    """The averaged equations."""

    averaged_equations: AveragedEquations = field(kw_only=True)
    name: ClassVar[str] = "slow"

    @cached_property
    def system(self) -> System:
        """The averaged System with the main rotor's angle as a state."""
        s = self.averaged_equations.system
        turning = s.output(ROTOR_ANGLE).expression
        works = tuple(q for q in s.quadratures if q.name != ROTOR_ANGLE)
        return replace(
            s, states=(*s.states, _ANGLE), derivatives=(*s.derivatives, turning), quadratures=works, angles=s.angles | {_ANGLE}
        )

    @property
    def parameter_values(self) -> tuple[float, ...]:
        """Parameter values in order."""
        return self.system.values(self.machine.values)

    def events(self, events: tuple[Event, ...]) -> tuple[Event, ...]:
        """Express events of the main rotor's angle and speed in its sense of rotation."""
        return tuple(replace(e, expression=e.expression.xreplace(self._rotor_in_its_sense)) for e in events)

    def machine_motion(self, trajectory: Trajectory) -> Trajectory:
        """Return the motion of the machine with its fast parts; works are those of the averaged motion.

        The work that dampers create which are not reciprocal is not known: it is not a number.
        """
        time, works, machine = trajectory.time, dict(trajectory.quadratures), self.machine
        works[DISSIPATED_WORK] = works[DISSIPATED_WORK] + works.pop(VIBRATION_WORK)
        unknown = {q.name: np.full(len(time), np.nan) for q in machine.system.quadratures if q.name not in works}
        return replace(
            trajectory,
            states=states_with_fast_parts(self.averaged_equations, time, trajectory.states[:-1], trajectory.states[-1]),
            quadratures=works | unknown,
            final_parameter_values=np.array(machine.system.values(machine.values)),
        )

    def rows(self, trajectory: Trajectory, machine_motion: Trajectory) -> dict[str, np.ndarray]:
        """Return the states and outputs (N,) of the machine's System; motor and energy are those of the averaged motion."""
        s, rotor, rows = self.system, self.machine.rotor, super().rows(trajectory, machine_motion)
        expressions = [*(s.output(n).expression for n in ("motor_torque", "stored_energy")), self._transmission_loss]
        averaged_outputs = Evaluator.of(s, expressions, ["motor", "stored", "loss"])(
            trajectory.time, trajectory.states, trajectory.final_parameter_values
        )
        rows["stored_energy"] = averaged_outputs["stored"]
        if len(self.machine.rotors) == 1:
            rows["motor_torque"] = self.averaged_equations.senses[rotor.name] * averaged_outputs["motor"]
            rows["drive_torque"] = rows["motor_torque"] - averaged_outputs["loss"]
            rows["motor_power"] = rows["motor_torque"] * rows[rotor.coordinate.velocity.name]
        return rows

    @property
    def _transmission_loss(self) -> sp.Expr:
        """The torque that transmissions take at the averaged speed, the carrier at rest."""
        still = {s: sp.S.Zero for c in self.machine.carrier for s in (c.position, c.velocity)}
        return self.machine.structure.transmission_loss.xreplace(still | self._rotor_in_its_sense)

    @property
    def _rotor_in_its_sense(self) -> dict[sp.Symbol, sp.Expr]:
        """Angle and speed of the main rotor by the states of the averaged equations, positive in its sense of rotation."""
        main, c = self.averaged_equations.senses[self.machine.rotor.name], self.machine.rotor.coordinate
        return {c.position: main * _ANGLE, c.velocity: main * c.velocity}


def slow_model(machine: Machine, start: np.ndarray, inertia: bool | None, order: int) -> SlowModel:
    """Return the averaged model; inertia None: without that of the balancing bodies where all of them are damped.

    Rotors without a drive turn as they do at the start. Raises ``InputError`` for a machine that has no such
    equations.
    """
    locked_body = next((b.name for b in machine.bodies if b.release is not None), None)
    if locked_body is not None:
        reason = f"the averaged equations have no locks, and {locked_body!r} is locked until it is released"
        requirement = "must be bodies that are free from the start, or model = 'full'"
        raise InputError("machine.bodies", None, f"{reason}; {requirement}")
    with_inertia = not has_damped_balancers(machine) if inertia is None else inertia
    if not with_inertia and not has_damped_balancers(machine):
        raise InputError("study.inertia", inertia, "must be true: a balancing body is not damped against its rotor")
    angles, speeds, main = angles_in(machine, start), speeds_in(machine, start), machine.rotor.name
    undriven = [r.name for r in machine.rotors if r.coordinate.prescribed_velocity is None and not free_speed(machine, r)]
    senses = {name: int(np.sign(speeds[name])) for name in undriven if speeds[name]}
    averaged_equations = averaged_equations_of(machine, with_inertia, order, turning=senses)
    initial = np.append(averaged_equations.state(angles, speeds), averaged_equations.senses[main] * angles[main])
    if order > 1 and not speeds[main] and not averaged_equations.is_defined_at(initial[:-1]):
        remedy = f"give a speed of {main!r} in study.start, however small, or order = 1"
        raise InputError("study.order", order, f"the averaged equations of second order are not defined at rest; {remedy}")
    positions = zip(machine.carrier, machine.rest, strict=True)
    at_rest = {
        s: x for c, rest in positions if c.prescribed_velocity is None for s, x in ((c.position, rest), (c.velocity, 0.0))
    }
    has_moved = any(abs(start[machine.row(s)] - x) > _AT_REST for s, x in at_rest.items())
    left_out = ("the averaged equations have no free vibration of the carrier: its start is left out",) if has_moved else ()
    advice = "the terms of the next order may have become as large as those of the first: try order = 1"
    return SlowModel(
        machine,
        initial,
        (*left_out, *averaged_equations.warnings),
        (advice,) if order > 1 else (),
        averaged_equations=averaged_equations,
    )
