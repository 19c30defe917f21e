"""The vibration of the carrier in the answer of a run-up, and what foundation, motors and bearings bear."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.analysis.throw import NUMBERS, Throw, largest_kinetic_energy, largest_of
from wucht.dynamics.run_ups.bearing_loads import BearingLife, lives_at_end, loads_at_end
from wucht.dynamics.run_ups.foundation_loads import FoundationLoads
from wucht.dynamics.run_ups.motor_loads import motor_loads
from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.results.formatting import number_text
from wucht.studies.answer import Answer
from wucht.studies.bearing_variables import force_text, state_lives, state_loads
from wucht.studies.foundation_variables import state_foundation_loads, state_static_loads, tell_isolation
from wucht.studies.motor_variables import state_motor_loads

_FEWEST = 8  # samples
_CIRCLE = 0.98  # ratio of the stroke across to that along: above it, the motion is a circle
_GENTLE = 0.05  # machine number below which the vibration is negligible

Mark = Callable[..., str]  # of numbers by their keys: in a line, after them


@dataclass(frozen=True)
class CarrierVibration:
    """The motion of the carrier's centre of mass at the end, the largest force of all bodies on it there, and its energy.

    force: in N. energy: the largest kinetic one with the bodies on it, None where it is not free.
    """

    throw: Throw
    force: float
    energy: float | None

    def is_worth_telling(self, deck: float | None) -> bool:
        """True if there is a deck, or the vibration is not negligible."""
        return deck is not None or self.throw.machine_number >= _GENTLE


def verdict_window(time: np.ndarray, verdict: Verdict) -> np.ndarray:
    """True for the samples (N,) of the verdict."""
    inside: np.ndarray = (time >= verdict.window[0]) & (time <= verdict.window[1])
    inside[-1] |= not inside.any()
    return inside


def state_vibration(
    a: Answer, motion: Motion, row: Mapping[str, Any], noise: Noise, deck: float | None, mark: Mark
) -> CarrierVibration | None:
    """State the motion of the carrier's centre of mass in the last window; None without units, or if it only turns."""
    machine, time, inside = motion.case.machine, row["time"], verdict_window(row["time"], motion.verdict)
    if not {"x", "y"} & set(machine.labels) or machine.dimensionless or np.count_nonzero(inside) < _FEWEST:
        return None
    zero = np.zeros(len(time))
    place, velocity, forces = (  # (2, N), zero where the carrier cannot move
        np.array([dict(zip(machine.labels, row[name], strict=True)).get(way, zero) for way in "xy"])
        for name in ("displacement", "velocity", "bearing_force")
    )
    place, velocity, late_forces = (np.compress(inside, vector, axis=1) for vector in (place, velocity, forces))
    throw = Throw.from_samples(time[inside], place, velocity, deck).beyond(noise.angle * motion.observation.largest)
    force = noise.without(largest_of(late_forces), largest_of(forces))
    moving = {label: v for label, v in zip(machine.labels, row["velocity"], strict=True) if label in machine.free_labels}
    energy = largest_kinetic_energy(machine, np.array([v[inside] for v in moving.values()])) if moving else None
    a.number("bearing_force", force, "largest force of all bodies together on the carrier", "N")
    for name, value in throw.numbers.items():
        a.number(name, value, *NUMBERS[name], headline=name == "machine_number")
    a.number("stroke_energy", energy, "largest kinetic energy of the carrier with the bodies on it, at the end", "energy")
    if deck is not None:
        normal = "largest acceleration normal to the deck over that of gravity"
        a.number("deck", deck, "inclination of the deck", "rad")
        a.number("throw_number", throw.throw_number(deck), normal)
    vibration = CarrierVibration(throw, force, energy)
    if not vibration.is_worth_telling(deck):
        return vibration
    ratio, direction = throw.ratio or 0.0, throw.numbers["throw_direction"]
    way = "" if direction is None else f" at {math.degrees(direction):.1f}\u00b0"
    shape = f"{way}, {number_text(throw.stroke * ratio, 'm')} across" if ratio < _CIRCLE else " on a circle"
    a.line("stroke", f"{{stroke}} peak to peak{shape}{mark('stroke', 'throw_direction', 'throw_ratio')}")
    return vibration


def state_loads_of_run(
    a: Answer, motion: Motion, vibration: CarrierVibration | None, deck: float | None, noise: Noise, mark: Mark
) -> dict[str, BearingLife]:
    """State what foundation, motors and bearings bear, and return the lives of bearings. vibration: of the carrier."""
    machine, moving, verdict = motion.case.machine, motion.machine_motion, motion.verdict
    at_end = machine.at(motion.trajectory.end_time)
    static, on_foundation = state_static_loads(a, at_end), FoundationLoads.of(at_end, moving, verdict, noise)
    state_foundation_loads(a, static, on_foundation, mark("foundation_force_amplitudes", "peak_foundation_forces"))
    lives, loads = lives_at_end(machine, moving, verdict.window), loads_at_end(machine, moving, verdict.window)
    state_lives(a, lives, mark("bearing_life", "equivalent_bearing_loads"))
    start_end = verdict.settling_time if verdict.evidence.turning else None
    of_motors = motor_loads(machine, moving, verdict.window, start_end)
    state_motor_loads(a, of_motors, mark("motor_load", "starting_rms_share"))
    is_shown = bool(lives) or (len(loads) > 1 and vibration is not None and vibration.is_worth_telling(None))
    of_loads = mark("steady_bearing_forces", "bearing_forces", "peak_bearing_forces")
    state_loads(a, {name: load.beyond(noise) for name, load in loads.items()}, is_shown, of_loads)
    if vibration is not None and vibration.is_worth_telling(deck):
        throw = vibration.throw
        of_deck = "" if deck is None else f"; throw number {{throw_number:.3g}} of a deck at {math.degrees(deck):.3g}\u00b0"
        acceleration = f"{throw.acceleration:.4g} m/s\u00b2, machine number {{machine_number:.3g}}{of_deck}"
        energy = "" if vibration.energy is None else "; kinetic energy {stroke_energy} at most"
        a.line("acceleration", acceleration + energy + mark("acceleration", "machine_number", "throw_number"))
        of_bodies = f"{force_text(vibration.force)} at most, of the bodies on the carrier"
        a.line("force", of_bodies + mark("bearing_force"))
    tell_isolation(a, static, on_foundation)
    return lives
