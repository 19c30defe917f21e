"""The course of a motion for a figure: speeds averaged over turns, and the largest amplitude in each of these spans."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.verdicts.observation import Observation
from wucht.machines.machine import Machine
from wucht.numerics.flow.trajectory import Trajectory

_MOST_SPANS = 2000


@dataclass(frozen=True, eq=False)
class MotionCourse:
    """A motion in N spans of time. time: in the middle of each; speeds (r, N): of the rotors, averaged over it; amplitude: the
    largest distance of the main rotor's axis from its rest position in it."""

    time: np.ndarray
    speeds: np.ndarray
    amplitude: np.ndarray

    @classmethod
    def of(cls, machine: Machine, trajectory: Trajectory, observation: Observation) -> MotionCourse:
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
