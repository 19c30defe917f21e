"""The steady vibration over the speed, in closed form: 002 (2.74)-(2.79)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from wucht.analysis.forced import Forced
from wucht.analysis.shaft import curves
from wucht.analysis.vibration import WithSlope
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of, shaft_torques
from wucht.numerics.zeros import crossings
from wucht.studies.response.prepare import Plan
from wucht.studies.steady_phases import SteadyPhases
from wucht.studies.work import Work

_NO_MOTION = 1e-9  # of the largest displacement: what moves less has no phase


@dataclass(frozen=True)
class Findings:
    """speeds: (N,), the maxima among them, without those at which the amplitude is infinite.

    peaks, torque_peaks: speeds of local maxima of the amplitude and of the vibration torque. undamped: resonances in the range
    that nothing damps.
    """

    speeds: np.ndarray
    peaks: np.ndarray
    torque_peaks: np.ndarray
    undamped: tuple[float, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The speeds that matter; the vibration at them takes milliseconds, and comes at once."""
    work.report(0.0, "steady vibration")
    forced = plan.steady.forced
    grid, undamped = forced.grid(*plan.range, plan.points), forced.undamped(*plan.range)
    peaks, torque_peaks = (_maxima(curve, grid) for curve in (forced.amplitude, forced.torque))
    speeds = np.unique(np.concatenate([grid, peaks, torque_peaks]))
    for infinite in undamped:
        speeds = speeds[np.abs(speeds - infinite) > 1e-9 * infinite]
    yield Findings(speeds, peaks, torque_peaks, tuple(undamped))


def _maxima(curve: Callable[[np.ndarray], WithSlope], grid: np.ndarray) -> np.ndarray:
    return crossings(lambda w: curve(w)[1], grid, -1)


def amplitude_at(forced: Forced, undamped: tuple[float, ...], speed: float) -> float:
    """The amplitude of the axis at a speed, infinite at a resonance without damping that moves it."""
    if any(math.isclose(speed, w, rel_tol=1e-9) for w in undamped) and forced.grows(forced.amplitude, speed):
        return math.inf
    return float(forced.amplitude(np.array([speed]))[0][0])


def lag_of(machine: Machine, forced: Forced, z: np.ndarray) -> np.ndarray:
    """By which angle (m, N) each displacement (m, N) comes after the force of the unbalance in its direction.

    A foundation, on which no unbalance acts, after that of the direction which it carries; anything else on which the
    unbalances exert no force after the main rotor's angle. NaN for what does not move.
    """
    main = np.exp(1j * forced.phases[machine.bodies.index(machine.rotor)])
    force = dict(zip(machine.free_labels, forced.force, strict=True))
    for label, above in (pair for p in machine.parts for pair in p.standing().items()):
        force[label] = force.get(above, 0.0)
    excitation = np.array([force[label] or main for label in machine.free_labels])
    lag: np.ndarray = np.mod(-np.angle(z / excitation[:, None]), 2 * math.pi)
    lag[lag > 2 * math.pi - 1e-9] = 0.0
    size = np.abs(z).max(axis=1)
    lag[size <= _NO_MOTION * size.max(initial=0.0)] = math.nan
    return lag


def eccentricity_of(machine: Machine) -> float:
    """Of the main rotor's centre of mass; NaN where the axis has no motion in the plane of the rotor, or no part states it."""
    arms = (p.arms().get(machine.rotor.name) for p in machine.parts if machine.labels != ("r",))
    return next((float(arm.xreplace(machine.numbers)) for arm in arms if arm is not None), math.nan)


def centre_distance(steady: SteadyPhases, eccentricity: float, speeds: np.ndarray) -> np.ndarray:
    """Of the main rotor's centre of mass from the axis' static position (N,), NaN where it has none."""
    main = steady.machine.bodies.index(steady.machine.rotor)
    return steady.forced.centre(speeds, eccentricity, float(steady.angles[main]))


def self_centring_speed(steady: SteadyPhases, eccentricity: float, speeds: np.ndarray) -> float | None:
    """From where to the end of the speeds the centre of mass stays nearer to the static position than the axis does.

    002, below (2.78). None where it never does, or where nothing is eccentric.
    """

    def outside(w: np.ndarray) -> np.ndarray:
        return np.asarray(centre_distance(steady, eccentricity, w) - steady.forced.amplitude(w)[0])

    if not eccentricity > 0 or not outside(speeds[-1:])[0] < 0:
        return None
    return max(crossings(outside, speeds).tolist(), default=None)


def losses_of(machine: Machine, speeds: np.ndarray) -> np.ndarray:
    """The torque (N,) of loads and bearings on all shafts together, positive where it brakes."""
    losses = np.zeros(len(speeds))
    for rotor in machine.rotors:
        sense, brakes = sense_of(machine, rotor), curves(machine, shaft_torques(machine, rotor)[1:])
        losses += sense * brakes(sense * speeds)[0][0]
    return losses
