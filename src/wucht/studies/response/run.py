"""The steady vibration over the speed, in closed form: 002 (2.74)-(2.79)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from wucht.analysis.forced import Forced, WithSlope
from wucht.analysis.shaft import Shaft
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, sense_of
from wucht.numerics.zeros import crossings
from wucht.studies.response.prepare import Plan
from wucht.studies.steady_phases import SteadyPhases
from wucht.studies.work import Work

_NO_MOTION = 1e-9  # of the largest displacement: what moves less has no phase


@dataclass(frozen=True)
class Findings:
    """The vibration over speeds (N,) that have the maxima among them, without those at which the amplitude is infinite.

    displacement: z (m, N) of the free directions, complex, q = Re[z exp(i w t)]; lag: by which angle (m, N) each comes after
    its excitation; amplitude, minor_axis: the semi-axes of the orbit (N,); centre_distance: of the main rotor's centre of mass
    from the axis' static position (N,), NaN where it has none; torques that brake all bodies together (N,), and torque_on_body
    (n, N). peak_speeds, torque_peak_speeds: of local maxima; an amplitude is infinite there, and at the free speed, if that
    resonance is one of the undamped. excited: whether the unbalances do not cancel.
    """

    speeds: np.ndarray
    displacement: np.ndarray
    lag: np.ndarray
    amplitude: np.ndarray
    minor_axis: np.ndarray
    centre_distance: np.ndarray
    vibration_torque: np.ndarray
    loss_torque: np.ndarray
    torque_on_body: np.ndarray
    peak_speeds: np.ndarray
    peak_amplitudes: np.ndarray
    torque_peak_speeds: np.ndarray
    torque_peaks: np.ndarray
    undamped: tuple[float, ...]
    excited: bool
    free_speed: float | None
    amplitude_at_free_speed: float | None
    eccentricity: float | None
    self_centring_speed: float | None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The vibration; it takes milliseconds, and comes at once."""
    work.report(0.0, "steady vibration")
    machine, forced = plan.steady.machine, plan.steady.forced
    coarse, excited = forced.grid(*plan.range, plan.points), bool(forced.force.any())
    undamped = tuple(forced.undamped(*plan.range))
    peaks, torque_peaks = (_maxima(curve, coarse) if excited else coarse[:0] for curve in (forced.amplitude, forced.torque))
    speeds = np.unique(np.concatenate([coarse, peaks, torque_peaks]))
    for infinite in undamped:
        speeds = speeds[np.abs(speeds - infinite) > 1e-9 * infinite]
    z, free, eccentricity = forced.displacement(speeds)[0].T, free_speed(machine, machine.rotor), _eccentricity(machine)
    yield Findings(
        speeds=speeds,
        displacement=z,
        lag=_lag(machine, forced, z),
        amplitude=forced.amplitude(speeds)[0],
        minor_axis=forced.minor(speeds),
        centre_distance=_centre_distance(plan.steady, eccentricity, speeds),
        vibration_torque=forced.torque(speeds)[0],
        loss_torque=_losses(machine, speeds),
        torque_on_body=np.array([forced.torque_on(speeds, [i])[0] for i in range(len(machine.bodies))]),
        peak_speeds=peaks,
        peak_amplitudes=np.array([_amplitude(forced, undamped, w) for w in peaks.tolist()]),
        torque_peak_speeds=torque_peaks,
        torque_peaks=forced.torque(torque_peaks)[0],
        undamped=undamped,
        excited=excited,
        free_speed=free,
        amplitude_at_free_speed=None if free is None else _amplitude(forced, undamped, abs(free)),
        eccentricity=eccentricity,
        self_centring_speed=_self_centring_speed(plan.steady, eccentricity, speeds) if excited else None,
    )


def _maxima(curve: Callable[[np.ndarray], WithSlope], speeds: np.ndarray) -> np.ndarray:
    """The speeds at which a curve has a local maximum."""
    return crossings(lambda w: curve(w)[1], speeds, -1)


def _amplitude(forced: Forced, undamped: tuple[float, ...], speed: float) -> float:
    """The amplitude of the axis at a speed, infinite at a resonance without damping that moves it."""
    if any(math.isclose(speed, u, rel_tol=1e-9) for u in undamped):
        near, far = (float(forced.amplitude(np.array([speed * (1 + d)]))[0][0]) for d in (1e-7, 1e-4))
        if near > 100 * far:
            return math.inf
    return float(forced.amplitude(np.array([speed]))[0][0])


def _lag(machine: Machine, forced: Forced, z: np.ndarray) -> np.ndarray:
    """By which angle (m, N) each displacement comes after the force of the unbalance in its direction.

    A foundation, on which no unbalance acts, after that of the direction which it carries; anything else on which the
    unbalances exert no force after the main rotor's angle. NaN for what does not move.
    """
    main = np.exp(1j * forced.phases[machine.bodies.index(machine.rotor)])
    by_label = dict(zip(machine.free_labels, forced.force, strict=True))
    for label, above in (pair for p in machine.parts for pair in p.standing().items()):
        by_label[label] = by_label.get(above, 0.0)
    behind = np.array([by_label[label] or main for label in machine.free_labels])
    lag: np.ndarray = np.mod(-np.angle(z / behind[:, None]), 2 * math.pi)
    lag[lag > 2 * math.pi - 1e-9] = 0.0
    size = np.abs(z).max(axis=1)
    lag[size <= _NO_MOTION * size.max(initial=0.0)] = math.nan
    return lag


def _eccentricity(machine: Machine) -> float | None:
    """Of the main rotor's centre of mass; None where the axis has no motion in the plane of the rotor, or no part says."""
    if machine.labels == ("r",):
        return None
    arm = next((a for p in machine.parts if (a := p.arms().get(machine.rotor.name)) is not None), None)
    return None if arm is None else float(arm.xreplace(machine.numbers))


def _centre_distance(steady: SteadyPhases, eccentricity: float | None, speeds: np.ndarray) -> np.ndarray:
    if eccentricity is None:
        return np.full(len(speeds), math.nan)
    main = steady.machine.bodies.index(steady.machine.rotor)
    return steady.forced.centre(speeds, eccentricity, float(steady.angles[main]))


def _self_centring_speed(steady: SteadyPhases, eccentricity: float | None, speeds: np.ndarray) -> float | None:
    """From where to the end of the speeds the centre of mass stays nearer to the static position than the axis does.

    002, below (2.78). None where it never does, or where nothing is eccentric.
    """
    if not eccentricity:
        return None

    def outside(w: np.ndarray) -> np.ndarray:
        difference: np.ndarray = _centre_distance(steady, eccentricity, w) - steady.forced.amplitude(w)[0]
        return difference

    entered = crossings(outside, speeds)
    return float(entered[-1]) if len(entered) and (outside(speeds[-1:]) < 0).all() else None


def _losses(machine: Machine, speeds: np.ndarray) -> np.ndarray:
    """The torque (N,) of loads and bearings on all shafts together, positive where it brakes."""
    losses = np.zeros(len(speeds))
    for rotor in machine.rotors:
        sense = sense_of(machine, rotor)
        losses += sense * Shaft.of(machine, rotor).losses(sense * speeds)[0]
    return losses
