"""How densely a motion is stored, and its limits in the window of the verdict where its samples are too few to show them."""

from __future__ import annotations

import math

import numpy as np

from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.observation import motion_of
from wucht.numerics.observers.records import Spans


def speed_limits(motion: Motion) -> tuple[float, float]:
    """Return the least and the greatest speed of the main rotor in the window of the verdict, of the integrated motion."""
    spans, inside = _last_spans(motion)
    return float(spans.least_speed[inside].min()), float(spans.greatest_speed[inside].max())


def amplitude_limits(motion: Motion) -> tuple[float, float, float]:
    """Return the mean, the least and the greatest amplitude in the window of the verdict, of the integrated motion."""
    turns, (begin, end) = motion.observation.rotors[motion.case.machine.rotor.name].whole, motion.verdict.window
    inside_turns = (turns.time >= begin) & (turns.time <= end)
    if inside_turns.any():
        return turns.part(slice(int(np.argmax(inside_turns)), None)).amplitudes
    spans, inside = _last_spans(motion)
    distance = spans.greatest_distance[inside]
    return float(distance.mean()), float(distance.min()), float(distance.max())


def _last_spans(motion: Motion) -> tuple[Spans, np.ndarray]:
    """Return the spans of a motion, and which of them (N,) are in the window of the verdict."""
    spans = motion.observation.main.last(1.0)
    inside = spans.time >= motion.verdict.window[0]
    inside[-1:] = True
    return spans, inside


def stored_samples_per_turn(motion: Motion) -> float:
    """Return the least number of samples stored in a turn of any body, infinite if none turns."""
    time, record, machine = motion.machine_motion.time, motion.machine_motion, motion.case.machine
    speeds = np.abs([motion_of(machine, record, b)[1] for b in machine.bodies]).max(axis=0)
    largest_angle = float((np.diff(time) * np.maximum(speeds[1:], speeds[:-1])).max(initial=0.0))
    return 2 * math.pi / largest_angle if largest_angle else math.inf
