"""The course of a motion for a figure: speeds and the largest amplitude, sample by sample or in spans of time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.verdicts.observation import AxisMotion, Observation, motion_of, rows_of
from wucht.machines.machine import Machine
from wucht.machines.operation import axis_at_rest
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory

_MOST_SPANS = 2000


@dataclass(frozen=True, eq=False)
class MotionCourse:
    """A motion at N times, or in N spans of time.

    time: (N,), or the middle of each span. speeds: (r, N) of the rotors, with their signs, averaged over each span.
    amplitude: (N,), the largest distance of the main rotor's axis from its rest position in it.
    """

    time: np.ndarray
    speeds: np.ndarray
    amplitude: np.ndarray

    @classmethod
    def from_samples(cls, machine: Machine, flow: CompiledSystem, trajectory: Trajectory) -> MotionCourse:
        """The course of a trajectory, sample by sample. flow: the machine's compiled equations."""
        speeds = np.array([motion_of(machine, trajectory, rotor)[1] for rotor in machine.rotors])
        axis = AxisMotion.of(machine, trajectory.time, rows_of(flow, trajectory), axis_at_rest(machine))
        return cls(trajectory.time, speeds, axis.peaks if len(trajectory.time) > 1 else axis.distance)

    @classmethod
    def from_turns(cls, machine: Machine, trajectory: Trajectory, observation: Observation) -> MotionCourse:
        """The course of a trajectory, from its stored angles and the record of its amplitude.

        A span lasts for a turn at the highest speed, or longer if there would be too many.
        """
        time = trajectory.time
        angles = np.array([trajectory.states[machine.row(r.coordinate.position)] for r in machine.rotors])
        duration = float(time[-1] - time[0])
        turns = float(np.abs(np.diff(angles)).sum(axis=1).max()) / (2 * math.pi) if len(time) > 1 else 0.0
        if not duration or not turns:
            return cls(time[-1:], np.zeros((len(angles), 1)), np.zeros(1))
        fastest = float((np.abs(np.diff(angles)) / np.diff(time)).max())
        count = int(min(max(1.0, duration * fastest / (2 * math.pi)), _MOST_SPANS))
        edges = np.linspace(time[0], time[-1], count + 1)
        angles_at_edges = np.array([np.interp(edges, time, angle) for angle in angles])
        spans = observation.main.last(1.0)
        first = np.searchsorted(spans.time, edges[:-1], side="right")
        last = np.minimum(np.searchsorted(spans.time, edges[1:], side="left"), len(spans.time) - 1)
        pairs = zip(np.minimum(first, last).tolist(), last.tolist(), strict=True)
        amplitude = np.array([spans.greatest_distance[i : k + 1].max() for i, k in pairs])
        return cls((edges[1:] + edges[:-1]) / 2, np.diff(angles_at_edges) / np.diff(edges), amplitude)

    @classmethod
    def join(cls, parts: Sequence[MotionCourse]) -> MotionCourse:
        """Join courses that follow each other."""
        time, amplitude = (np.concatenate(arrays) for arrays in ([p.time for p in parts], [p.amplitude for p in parts]))
        return cls(time, np.concatenate([p.speeds for p in parts], axis=1), amplitude)

    def thin(self, most: int) -> MotionCourse:
        """Return at most so many spans: mean times and speeds of samples that follow each other, and largest amplitudes."""
        count = len(self.time)
        if count <= most:
            return self
        first = np.unique(np.linspace(0, count, most, endpoint=False).astype(int))
        size = np.diff(np.append(first, count))
        time, speeds = (np.add.reduceat(x, first, axis=-1) / size for x in (self.time, self.speeds))
        return MotionCourse(time, speeds, np.maximum.reduceat(self.amplitude, first))

    def within(self, begin: float, end: float) -> MotionCourse:
        """Return the part between two times."""
        inside = (self.time >= begin) & (self.time <= end)
        return MotionCourse(self.time[inside], self.speeds[:, inside], self.amplitude[inside])

    def shift(self, time: float) -> MotionCourse:
        """Return the course with all times later by this much."""
        return replace(self, time=self.time + time)
