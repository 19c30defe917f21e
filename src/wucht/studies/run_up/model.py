"""What a run-up integrates: the full equations, or the slow ones with the full motion rebuilt from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
import sympy as sp

from wucht.analysis.averaged import SlowMachine, damped, slow_machine
from wucht.analysis.full_motion import FullMotion
from wucht.analysis.static import static_position
from wucht.errors import InputError
from wucht.machines.machine import LOST, SUPPLIED, Machine
from wucht.machines.operation import free_speed
from wucht.mechanics.averaged.outputs import ROTOR_ANGLE, SHAKEN
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory
from wucht.studies.initial_state import angles_in
from wucht.system import System

_AT_REST = 1e-12
_ANGLE = sp.Symbol(ROTOR_ANGLE, real=True)


class Model(Protocol):
    """What is integrated, and how its trajectory is seen as one of the machine."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def system(self) -> System: ...  # noqa: D102
    @property
    def initial(self) -> np.ndarray: ...  # noqa: D102
    @property
    def values(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def warnings(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def remedies(self) -> tuple[str, ...]: ...  # noqa: D102
    def events(self, events: tuple[Event, ...]) -> tuple[Event, ...]: ...  # noqa: D102
    def seen(self, trajectory: Trajectory) -> Trajectory: ...  # noqa: D102
    def outputs(self, trajectory: Trajectory, seen: Trajectory) -> Mapping[str, np.ndarray]: ...  # noqa: D102


@dataclass(frozen=True)
class FullModel:
    """The full equations."""

    machine: Machine
    initial: np.ndarray
    warnings: tuple[str, ...] = ()
    remedies: tuple[str, ...] = ()
    name: str = "full"

    @property
    def system(self) -> System:
        """The machine's."""
        return self.machine.system

    @property
    def values(self) -> tuple[float, ...]:
        """Parameter values in order."""
        return self.system.values(self.machine.values)

    def events(self, events: tuple[Event, ...]) -> tuple[Event, ...]:
        """As they are."""
        return events

    def seen(self, trajectory: Trajectory) -> Trajectory:
        """As it is."""
        return trajectory

    def outputs(self, trajectory: Trajectory, seen: Trajectory) -> Mapping[str, np.ndarray]:
        """The outputs of the machine's System (N,)."""
        return _outputs(self.machine, seen, trajectory.parameters)


@dataclass(frozen=True)
class SlowModel:
    """The slow equations. start: the state (n,) of the full machine at which the run starts."""

    machine: Machine
    start: np.ndarray
    slow: SlowMachine
    name: str = "slow"

    @cached_property
    def system(self) -> System:
        """The slow System with the main rotor's angle as a state."""
        s = self.slow.system
        turning = s.output(ROTOR_ANGLE).expression
        works = tuple(q for q in s.quadratures if q.name != ROTOR_ANGLE)
        return replace(s, states=(*s.states, _ANGLE), derivatives=(*s.derivatives, turning), quadratures=works)

    @cached_property
    def initial(self) -> np.ndarray:
        """The slow state from which the same motion follows."""
        angles = angles_in(self.machine, self.start)
        speeds = {b.name: self._speed_at_start(b.name) for b in self.machine.bodies}
        main = self.machine.rotor.name
        return np.append(self.slow.state(angles, speeds), self.slow.senses[main] * angles[main])

    def _speed_at_start(self, name: str) -> float:
        c = next(b.coordinate for b in self.machine.bodies if b.name == name)
        if c.prescribed is not None:
            return float(self.machine.prescribed_speed(c, 0.0)[0])
        return float(self.start[self.machine.row(c.velocity)])

    @property
    def values(self) -> tuple[float, ...]:
        """Parameter values in order."""
        return self.slow.values()

    @property
    def warnings(self) -> tuple[str, ...]:
        """What of the start the slow equations leave out."""
        m, names = self.machine, self.machine.state_names
        moved = False
        for c, rest in zip(m.carrier, static_position(m), strict=True):
            if c.prescribed is None:
                position, velocity = (self.start[names.index(s.name)] for s in (c.position, c.velocity))
                moved = moved or abs(position - rest) > _AT_REST or abs(velocity) > _AT_REST
        said = ["the slow equations have no free vibration of the carrier: its start is left out"] if moved else []
        return (*said, *self.slow.warnings)

    @property
    def remedies(self) -> tuple[str, ...]:
        """What to try where the run failed."""
        if self.slow.order == 1:
            return ()
        return ("the terms of the next order may have become as large as those of the first: try order = 1",)

    def events(self, events: tuple[Event, ...]) -> tuple[Event, ...]:
        """Those of the main rotor's angle and speed, in its own sense."""
        main, c = self.slow.senses[self.machine.rotor.name], self.machine.rotor.coordinate
        own = {c.position: main * _ANGLE, c.velocity: main * c.velocity}
        return tuple(replace(e, expression=e.expression.xreplace(own)) for e in events)

    def seen(self, trajectory: Trajectory) -> Trajectory:
        """The motion of the machine that belongs to it, with its fast parts; works are those of the slow motion."""
        time, angle = trajectory.time, trajectory.states[-1]
        works = dict(trajectory.quadratures)
        lost = works.pop(LOST) + works.pop(SHAKEN)
        return replace(
            trajectory,
            states=FullMotion(self.slow)(time, trajectory.states[:-1], angle),
            quadratures=works | {LOST: lost} | self._mismatch(len(time)),
        )

    def _mismatch(self, count: int) -> dict[str, np.ndarray]:
        """Works that the slow motion does not know: what dampers that are not reciprocal create."""
        known = {SUPPLIED, LOST, *(q.name for q in self.slow.system.quadratures)}
        return {q.name: np.full(count, np.nan) for q in self.machine.system.quadratures if q.name not in known}

    def outputs(self, trajectory: Trajectory, seen: Trajectory) -> Mapping[str, np.ndarray]:
        """The outputs of the machine's System (N,); motor and energy are those of the slow motion."""
        full = dict(_outputs(self.machine, seen, self.machine.system.values(self.machine.values)))
        s = self.system
        own = Evaluator.of(s, [s.output(n).expression for n in ("motor_torque", "stored_energy")], ["motor", "stored"])
        found = own(trajectory.time, trajectory.states, trajectory.parameters)
        full["stored_energy"] = found["stored"]
        if len(self.machine.rotors) == 1:
            rows = dict(zip(self.machine.state_names, seen.states, strict=True)) | full
            full["motor_torque"] = self.slow.senses[self.machine.rotor.name] * found["motor"]
            full["motor_power"] = full["motor_torque"] * rows[self.machine.rotor.coordinate.velocity.name]
        return full


def _outputs(machine: Machine, seen: Trajectory, parameters: np.ndarray | tuple[float, ...]) -> Mapping[str, np.ndarray]:
    s = machine.system
    found = Evaluator.of_outputs(s)
    return found(seen.time, seen.states, parameters)


def slow_model(machine: Machine, start: np.ndarray, inertia: bool | None, order: int) -> SlowModel:
    """The slow model; inertia None: without that of the balancing bodies where all of them are damped.

    Raises ``InputError`` for a machine that has no slow equations.
    """
    wanted = inertia_of(machine, inertia)
    return SlowModel(machine, start, slow_machine(machine, wanted, order, turning=_turning(machine, start)))


def inertia_of(machine: Machine, inertia: bool | None) -> bool:
    """Whether a slow model keeps the inertia of the balancing bodies. Raises ``InputError`` where it cannot be as asked."""
    released = [b.name for b in machine.bodies if b.release is not None]
    if released:
        raise InputError(
            "machine.bodies",
            None,
            f"the slow equations have no locks, and {released[0]!r} is locked until it is released; allowed are bodies that "
            "are free from the start, or model = 'full'",
        )
    wanted = not damped(machine) if inertia is None else inertia
    if not wanted and not damped(machine):
        raise InputError("study.inertia", inertia, "allowed is true: a balancing body is not damped against its rotor")
    return wanted


def _turning(machine: Machine, start: np.ndarray) -> dict[str, int]:
    """The senses of rotors without a drive of their own: as they turn at the start."""
    found = {}
    for rotor in (r for r in machine.rotors if not free_speed(machine, r)):
        c = rotor.coordinate
        speed = 0.0 if c.prescribed is not None else start[machine.row(c.velocity)]
        if speed:
            found[rotor.name] = 1 if speed > 0 else -1
    return found
