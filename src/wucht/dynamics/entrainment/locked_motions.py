"""Periodic motions of the full equations in which rotors are entrained, their phases and stability, and where they end."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase
from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.orbits import PeriodicOrbit, periodic_orbit

_SAMPLES = 256  # of a period: the mean of a periodic function over even samples is exact but for the orders above
_MOST_STEPS, _FEW_STEPS = 25, 8  # of Newton's method: from the end of a run; from a neighbouring motion
_MOTIONS = 8  # to each side of the seed
_JUMP = 0.5  # rad: phases of neighbouring motions are nearer than this


@dataclass(frozen=True)
class LockedMotion:
    """Periodic motion. phases: of each body of ``bodies_with_phase``, mean over a period, rad. speed: common, in magnitude.

    multiplier: the largest modulus of a nontrivial multiplier.
    """

    value: float
    phases: np.ndarray
    speed: float
    multiplier: float
    orbit: PeriodicOrbit

    @property
    def stable(self) -> bool:
        """True if all disturbances decay."""
        return self.multiplier < 1


def bodies_with_phase(machine: Machine) -> list[str]:
    """Return the bodies that have a phase: all but the main rotor, and that one too where the carrier is shaken.

    The phase of a body that turns about a rotor is relative to this rotor, of another rotor to the main one, of the main
    rotor to the vibration.
    """
    return [b.name for b in machine.bodies if machine.shaking_frequency is not None or b is not machine.rotor]


class LockedMotions:
    """Locked motions of a machine along a parameter, as its schedules and releases leave it at a time.

    senses: +-1 per body, in which they turn. time: at which they begin. Immutable after its construction.
    """

    def __init__(self, case: EntrainmentCase, senses: Mapping[str, float], time: float) -> None:
        machine = case.machine
        released_values = {b.lock_symbol.name: 0.0 for b in machine.bodies if b.release is not None}
        self.machine = machine.at(time).with_unchecked_values(released_values).with_fields(schedules=())
        self.parameter, self.senses, self.time = case.parameter, senses, time
        self.flow = compile_system(replace(self.machine.system, quadratures=(), outputs=()))
        self.angles = {b.name: machine.row(b.coordinate.position) for b in machine.bodies}
        self.advance = np.zeros(len(machine.state_names))
        self.advance[list(self.angles.values())] = [2 * math.pi * senses[name] for name in self.angles]

    def motion(self, value: float, guess: np.ndarray, speed: float, most_steps: int = _MOST_STEPS) -> LockedMotion:
        """Compute the motion at a value near a state (n,). Raises ``WuchtError`` where there is none."""
        machine, frequency = self.machine, self.machine.shaking_frequency
        values = self.parameter.machine_at(machine, value).values
        orbit = periodic_orbit(
            self.flow, values, guess, 2 * math.pi / (frequency or speed), self.advance, free_period=frequency is None,
            phase_state=None if frequency else self.angles[machine.rotor.name], time=self.time, most_steps=most_steps,
        )  # fmt: skip
        grid = self.time + np.linspace(0.0, orbit.period, _SAMPLES + 1)
        run = integrate(self.flow, orbit.state, values, grid).reraise_interrupt()
        rotations = {n: self.senses[n] * run.states[i, :-1] for n, i in self.angles.items()}
        phases = []
        for body in map(machine.body, bodies_with_phase(machine)):
            reference = (machine.rotor_of(body) if body.about else machine.rotor).name
            origin = run.time[:-1] * (frequency or 0.0) if reference == body.name else rotations[reference]
            phases.append(float((rotations[body.name] - origin).mean()))
        trivial = sum(c.prescribed_velocity is not None for c in machine.coordinates) + (frequency is None)
        multiplier = float(np.abs(orbit.nontrivial(trivial)).max(initial=0.0))
        return LockedMotion(value, np.array(phases), 2 * math.pi / orbit.period, multiplier, orbit)

    def follow_both_ways(
        self, seed: LockedMotion, limits: tuple[float, float], edges: tuple[float, float], resolution: float, work: Work
    ) -> Iterator[tuple[tuple[LockedMotion, ...], tuple[float | None, float | None]]]:
        """Follow a motion down and up to limits, in small steps within edges.

        Yields the motions so far, in increasing order of their value, and where they end below and above, None where beyond
        the limits.
        """
        motions: tuple[LockedMotion, ...] = (seed,)
        ends: tuple[float | None, float | None] = (None, None)
        for side, (limit, edge) in enumerate(zip(limits, edges, strict=True)):
            inside = np.linspace(seed.value, edge, _MOTIONS + 1)[1:-1].tolist()
            goals = [v for v in (*inside, limit) if v != seed.value]
            earlier_motions, part = motions, work.part("locked motion", (0.8, 0.875)[side], (0.875, 0.95)[side])
            for further_motions, end in self.follow(seed, goals, resolution, part):
                ends = (end, None) if side == 0 else (ends[0], end)
                motions = tuple(sorted([*earlier_motions, *further_motions], key=lambda m: m.value))
                yield motions, ends

    def follow(
        self, seed: LockedMotion, goals: Sequence[float], resolution: float, work: Work
    ) -> Iterator[tuple[tuple[LockedMotion, ...], float | None]]:
        """Follow a motion through values (all on one side); yield the motions so far, and where they end, or None.

        The step is halved where there is no motion, until the end is known to the resolution.
        """
        motions: tuple[LockedMotion, ...] = ()
        at, before = seed, None
        for k, goal in enumerate(goals):
            work.report(k / len(goals), "locked motions")
            step = goal - at.value
            while at.value != goal:
                value = goal if abs(goal - at.value) <= abs(step) * (1 + 1e-9) else at.value + step
                motion = work.unit(f"from {at.value!r} to {value!r}", partial(self._continue_motion, at, value, before))
                if motion is not None:
                    at, before = motion, at
                    continue
                step = (value - at.value) / 2
                if abs(step) < resolution / 2:
                    yield motions, (at.value + value) / 2
                    return
            motions = (*motions, at)
            yield motions, None

    def _continue_motion(self, at: LockedMotion, value: float, before: LockedMotion | None) -> LockedMotion | None:
        """Return the stable motion at another value that continues a known one; None where there is none.

        before: a motion on the other side of the known one, to extrapolate from.
        """
        guess = at.orbit.state
        if before is not None and before.value != at.value:
            change = at.orbit.state - before.orbit.state
            share = (value - at.value) / (at.value - before.value)
            change = np.where(self.advance != 0, wrap_to_pi(change), change)
            guess = guess + np.clip(share, -1.0, 1.0) * change
        try:
            motion = self.motion(value, guess, at.speed, _FEW_STEPS)
        except WuchtError:
            return None
        phase_change = wrap_to_pi(motion.phases - at.phases)
        return motion if motion.stable and np.abs(phase_change).max(initial=0.0) < _JUMP else None
