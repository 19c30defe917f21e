"""How densely a motion is stored, and its limits in the window of the verdict where its samples are too few to show them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.observation import motion_of


@dataclass(frozen=True)
class MotionLimits:
    """Limits of the integrated motion, in the window of the verdict: the least and the greatest speed of the main rotor, and
    of the amplitude the mean, the least and the greatest."""

    speeds: tuple[float, float]
    amplitudes: tuple[float, float, float]

    @classmethod
    def of(cls, motion: Motion) -> MotionLimits:
        """Return those of a motion."""
        machine, verdict, spans = motion.case.machine, motion.verdict, motion.observation.main.last(1.0)
        turns = motion.observation.rotors[machine.rotor.name].whole
        begin, end = verdict.window
        inside, inside_turns = spans.time >= begin, (turns.time >= begin) & (turns.time <= end)
        inside[-1:] = True
        speeds = float(spans.least_speed[inside].min()), float(spans.greatest_speed[inside].max())
        if inside_turns.any():
            selection = slice(int(np.argmax(inside_turns)), None)
            return cls(speeds, turns.part(selection).amplitudes)
        distance = spans.greatest_distance[inside]
        return cls(speeds, (float(distance.mean()), float(distance.min()), float(distance.max())))


def stored_samples_per_turn(motion: Motion) -> float:
    """Return the least number of samples stored in a turn of any body, infinite if none turns."""
    time, record, machine = motion.machine_motion.time, motion.machine_motion, motion.case.machine
    speeds = np.abs([motion_of(machine, record, b)[1] for b in machine.bodies]).max(axis=0)
    largest_angle = float((np.diff(time) * np.maximum(speeds[1:], speeds[:-1])).max(initial=0.0))
    return 2 * math.pi / largest_angle if largest_angle else math.inf
