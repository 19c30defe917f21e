"""The full equations: periodic motions in which rotors are taken along, their phases and stability, and where they end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.orbits import Orbit, periodic_orbit
from wucht.studies.entrainment.along import Along
from wucht.studies.locking import frequency_of

_SAMPLES = 256  # of a period: the mean of a periodic function over even samples is exact but for the orders above
_FEW_STEPS = 8  # of Newton's method, from a neighbour's motion
_JUMP = 0.5  # rad: a neighbour's phase is not so far away


@dataclass(frozen=True)
class OrbitAt:
    """A periodic motion. phases: of each body of ``Orbits.names``, mean over a period, rad. speed: common, in magnitude.

    multiplier: the largest modulus of a multiplier that is not 1 for reasons of form.
    """

    value: float
    phases: np.ndarray
    speed: float
    multiplier: float
    orbit: Orbit

    @property
    def stable(self) -> bool:
        """Whether all disturbances decay."""
        return self.multiplier < 1


class Orbits:
    """Synchronous motions of a machine along a parameter. senses: +-1 a body, in which they turn. time: at which they begin.

    names: the bodies that have a phase: all but the main rotor, and that one too where the carrier is shaken. The phase of a
    body that turns about a rotor is that to this rotor, of another rotor that to the main one, of the main rotor that to the
    vibration.
    """

    def __init__(self, machine: Machine, along: Along, senses: dict[str, float], time: float, tolerance: float) -> None:
        released = machine.with_values({b.locked.name: 0.0 for b in machine.bodies if b.release is not None})
        self.machine, self.along, self.senses, self.time = replace(released, schedules=()), along, senses, time
        self.frequency = frequency_of(machine)
        self.states = machine.state_names
        bare = replace(self.machine.system, quadratures=(), outputs=())
        self.flow = compile_system(bare, tolerance)
        self.angles = {b.name: self.states.index(b.coordinate.position.name) for b in machine.bodies}
        main = machine.rotor.name
        self.names = [b.name for b in machine.bodies if self.frequency is not None or b.name != main]
        self._references = {b.name: self._root(b.name) if b.about else main for b in machine.bodies}
        self.advance = np.zeros(len(self.states))
        for name, index in self.angles.items():
            self.advance[index] = 2 * math.pi * senses[name]
        self.trivial = sum(c.prescribed is not None for c in machine.coordinates) + (self.frequency is None)

    def _root(self, name: str) -> str:
        by_name = {b.name: b for b in self.machine.bodies}
        body = by_name[name]
        while body.about is not None:
            body = by_name[body.about]
        return body.name

    def __call__(self, value: float, guess: np.ndarray, speed: float, most_steps: int = 25) -> OrbitAt:
        """The motion at a value near a state (n,). Raises ``WuchtError`` where there is none."""
        machine, period = self.along.at(self.machine, value), 2 * math.pi / (self.frequency or speed)
        orbit = periodic_orbit(
            self.flow, machine.values, guess, period, self.advance, free_period=self.frequency is None,
            phase_state=None if self.frequency else self.angles[machine.rotor.name], time=self.time, most_steps=most_steps,
        )  # fmt: skip
        grid = self.time + np.linspace(0.0, orbit.period, _SAMPLES + 1)
        run = integrate(self.flow, orbit.state, machine.values, grid)
        if run.interrupted:
            raise KeyboardInterrupt
        turned = {n: self.senses[n] * run.states[i, :-1] for n, i in self.angles.items()}
        phases = []
        for name in self.names:
            reference = self._references[name]
            origin = run.time[:-1] * (self.frequency or 0.0) if reference == name else turned[reference]
            phases.append(float((turned[name] - origin).mean()))
        largest = float(np.abs(orbit.rest(self.trivial)).max(initial=0.0))
        return OrbitAt(value, np.array(phases), 2 * math.pi / orbit.period, largest, orbit)

    def near(self, known: OrbitAt, value: float, before: OrbitAt | None = None) -> OrbitAt | None:
        """The motion at another value that goes on from a known one; None where none that is stable does.

        before: one on the other side of the known one, to aim better.
        """
        guess = known.orbit.state
        if before is not None and before.value != known.value:
            change = known.orbit.state - before.orbit.state
            share = (value - known.value) / (known.value - before.value)
            turning = self.advance != 0
            change = np.where(turning, np.remainder(change + math.pi, 2 * math.pi) - math.pi, change)
            guess = guess + np.clip(share, -1.0, 1.0) * change
        try:
            found = self(value, guess, known.speed, _FEW_STEPS)
        except WuchtError:
            return None
        moved = np.remainder(found.phases - known.phases + math.pi, 2 * math.pi) - math.pi
        return found if found.stable and np.abs(moved).max(initial=0.0) < _JUMP else None

    def followed(self, seed: OrbitAt, goals: list[float], resolution: float, note: Callable[[OrbitAt], None]) -> float | None:
        """Follow a motion through values (all on one side); returns where it ends, to the resolution, None if it does not.

        note: told of the motion at each goal.
        """
        known, before = seed, None
        for goal in goals:
            found = self._reached(known, before, goal, resolution)
            if isinstance(found, float):
                return found
            known, before = found
            note(known)
        return None

    def _reached(
        self, known: OrbitAt, before: OrbitAt | None, goal: float, resolution: float
    ) -> tuple[OrbitAt, OrbitAt | None] | float:
        """The motion at a goal and the one before it, or where it ends on the way: the step is halved until it goes on."""
        step = goal - known.value
        while known.value != goal:
            value = goal if abs(goal - known.value) <= abs(step) * (1 + 1e-9) else known.value + step
            found = self.near(known, value, before)
            if found is None:
                step = (value - known.value) / 2
                if abs(step) < resolution / 2:
                    return (known.value + value) / 2
            else:
                known, before = found, known
        return known, before
