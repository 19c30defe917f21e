"""What is seen of a machine's motion while it runs: a pure function of the motion, whatever of it is stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.analysis.vibration import unbalances
from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.span_record import SpanRecord
from wucht.numerics.observers.turn_record import TurnRecord
from wucht.numerics.observers.turns import Samples


@dataclass(frozen=True)
class Observation:
    """A motion so far.

    rotors: turn by turn of each rotor, by name; the others beside it are all other bodies in the machine's order. vibration:
    by periods of a prescribed vibration, beside it all bodies. main: the main rotor over time. end_time: how far.
    """

    rotors: Mapping[str, TurnRecord]
    vibration: TurnRecord | None
    main: SpanRecord
    end_time: float = 0.0


@dataclass(frozen=True)
class Watch:
    """Watches a machine. span: of time, in which the fastest motion is sampled several times."""

    machine: Machine
    span: float

    def begin(self) -> Observation:
        """Before anything has been seen."""
        others = len(self.machine.bodies) - 1
        shaken = self.machine.shaking_frequency is not None
        machine = self.machine.at(self.machine.breakpoints[-1])
        rotors = {r.name: TurnRecord(others, weights_of(machine, r)) for r in self.machine.rotors}
        return Observation(rotors, TurnRecord(others + 1) if shaken else None, SpanRecord(self.span))

    def samples(self, motion: Trajectory) -> Samples:
        """Of the machine's motion what is watched: all bodies in their order."""
        return Samples.of(motion.time, *(motion_of(self.machine, motion, b) for b in self.machine.bodies))

    def after(self, seen: Observation, samples: Samples) -> Observation:
        """After a part of the motion, which may begin with the last sample of the part before."""
        machine, names = self.machine, [b.name for b in self.machine.bodies]
        rotors, vibration, frequency = {}, seen.vibration, machine.shaking_frequency
        for name, record in seen.rotors.items():
            rotors[name] = record.after(samples.led_by(names.index(name)))
        main = seen.main.after(samples.only(names.index(machine.rotor.name)))
        if vibration is not None and frequency is not None:
            vibration = vibration.after(samples.beside(frequency * samples.time, np.full(len(samples.time), frequency)))
        return Observation(rotors, vibration, main, float(samples.time[-1]))


def weights_of(machine: Machine, rotor: RotatingBody) -> tuple[complex, ...]:
    """The unbalances of a rotor and of all other bodies, zero of those of other rotors, as shares of its own."""
    own, bodies = unbalances(machine), machine.bodies
    group = [bodies.index(b) for b in machine.group(rotor)]
    scale = abs(own[group[0]]) or float(np.abs(own[group]).max()) or 1.0
    each = [own[i] / scale if i in group else 0.0 for i in range(len(bodies))]
    return tuple(map(complex, [each.pop(group[0]), *each]))


def motion_of(machine: Machine, trajectory: Trajectory, body: RotatingBody) -> tuple[np.ndarray, np.ndarray]:
    """Angle and speed of a body over a run, (N,) each."""
    angle = trajectory.states[machine.row(body.coordinate.position)]
    if body.coordinate.prescribed is not None:
        return angle, machine.prescribed_speed(body.coordinate, trajectory.time)
    return angle, trajectory.states[machine.row(body.coordinate.velocity)]


def fastest_of(machine: Machine, states: np.ndarray) -> float:
    """The largest speed (rad per time) at which a body of the machine turns in states (n, N)."""
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed is None]
    return float(np.abs(states[free]).max(initial=0.0)) if free else 0.0
