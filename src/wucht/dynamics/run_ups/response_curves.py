"""The steady forced vibration over the speed, the unbalance fixed: its maxima, lags and losses. 002 (2.74)-(2.79)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.configurations.steady_branches import SteadyBranch
from wucht.analysis.vibration import ForcedVibration, WithSlope
from wucht.analysis.working_points import curves
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of, shaft_torques
from wucht.numerics.zeros_and_peaks import crossings

_NO_MOTION = 1e-9  # of the largest displacement: a smaller one has no phase


@dataclass(frozen=True)
class Maximum:
    """A value at a speed. label: of the configuration, empty for held bodies. stable: True if it is stable there."""

    speed: float
    value: float
    label: str = ""
    stable: bool = True


@dataclass(frozen=True)
class ResponseCurve:
    """The vibration over the speed in a branch of steady phases, or of held bodies, which have no branch.

    peaks, torque_peaks: speeds of local maxima of the amplitude and of the vibration torque. undamped_resonances: those in the
    range.
    """

    vibration: ForcedVibration
    branch: SteadyBranch | None
    peaks: np.ndarray
    torque_peaks: np.ndarray
    undamped_resonances: tuple[float, ...]

    def vibration_at(self, speeds: np.ndarray) -> ForcedVibration:
        """Return the vibration at speeds (N,) alone, whose phases are computed once."""
        phases = self.vibration.phases(speeds)
        return replace(self.vibration, phase_law=phases[0] if phases[1] is None else lambda _: phases)

    def amplitude(self, speeds: np.ndarray) -> np.ndarray:
        """Return the amplitude of the axis at speeds (N,), infinite at undamped resonances that move it."""
        return np.array([self._amplitude_at(w) for w in speeds.tolist()])

    def _amplitude_at(self, speed: float) -> float:
        amplitude = self.vibration.amplitude
        is_undamped = any(math.isclose(speed, w, rel_tol=1e-9) for w in self.undamped_resonances)
        if is_undamped and self.vibration.grows_unbounded(amplitude, speed):
            return math.inf
        return float(amplitude(np.array([speed]))[0][0])

    def maxima(self, speeds: np.ndarray, values: np.ndarray) -> list[Maximum]:
        """Return values (N,) at speeds with the configurations there; NaN is left out."""
        labels, stable = np.full(len(speeds), ""), np.ones(len(speeds), bool)
        if self.branch is not None:
            labels, stable = self.branch.labels(speeds), self.branch.stable(speeds) & (not self.branch.overlapping)
        rows = zip(speeds.tolist(), values.tolist(), labels.tolist(), stable.tolist(), strict=True)
        return [Maximum(*at) for at in rows if not math.isnan(at[1])]


def response_curves(
    steady: SteadyPhases, speed_range: tuple[float, float], points: int
) -> tuple[np.ndarray, tuple[ResponseCurve, ...]]:
    """Return the decisive speeds (N,), the maxima among them, without those at which the amplitude is infinite; and the curves.

    points: evenly spaced over the range.
    """
    grid = steady.grid(steady.forced_vibration.grid(*speed_range, points))
    response = tuple(
        ResponseCurve(
            vibration,
            branch,
            _maximum_speeds(vibration.amplitude, grid),
            _maximum_speeds(vibration.torque, grid),
            tuple(vibration.undamped_resonances(*speed_range)),
        )
        for vibration, branch in zip(steady.curves, steady.branches or (None,), strict=True)
    )
    speeds = np.unique(np.concatenate([grid, *(x for c in response for x in (c.peaks, c.torque_peaks))]))
    for infinite in {w for c in response for w in c.undamped_resonances}:
        speeds = speeds[np.abs(speeds - infinite) > 1e-9 * infinite]
    return speeds, response


def _maximum_speeds(curve: Callable[[np.ndarray], WithSlope], grid: np.ndarray) -> np.ndarray:
    speeds = crossings(lambda w: curve(w)[1], grid, -1)
    return speeds[np.isfinite(curve(speeds)[0])] if len(speeds) else speeds  # not beyond the end of a branch


def greatest_value(speeds: np.ndarray, values: np.ndarray, stable: np.ndarray) -> list[Maximum]:
    """Return the greatest value of (N,) where bodies are stable, if there is one."""
    stable_values = np.where(stable & np.isfinite(values), values, -np.inf)
    at = int(stable_values.argmax())
    return [Maximum(float(speeds[at]), float(values[at]))] if np.isfinite(stable_values[at]) else []


def largest_maximum(maxima: list[Maximum]) -> Maximum | None:
    """Return the maximum with the largest value, of equal ones the last; None of none."""
    return max(reversed(maxima), key=lambda m: m.value, default=None)


def phase_lags(machine: Machine, vibration: ForcedVibration, speeds: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the lag (m, N) at speeds (N,) of each displacement (m, N) behind the force of the unbalance in its direction.

    That of a foundation, on which no unbalance acts, is behind the force on the direction that it carries; anywhere else the
    reference is the main rotor's angle if the unbalances exert no force. NaN without motion.
    """
    at = machine.bodies.index(machine.rotor)
    main = np.exp(1j * np.broadcast_to(vibration.phases(speeds)[0][at], speeds.shape))
    force = dict(zip(machine.free_labels, vibration.force(speeds).T, strict=True))
    for label, above in (pair for p in machine.parts for pair in p.supported_directions().items()):
        force[label] = force.get(above, np.zeros_like(main))
    excitation = np.array([np.where(force[label] != 0, force[label], main) for label in machine.free_labels])
    lag: np.ndarray = np.mod(-np.angle(z / excitation), 2 * math.pi)
    lag[lag > 2 * math.pi - 1e-9] = 0.0
    size = np.nan_to_num(np.abs(z)).max(axis=1, initial=0.0)
    lag[size <= _NO_MOTION * size.max(initial=0.0)] = math.nan
    return lag


def eccentricity_of(machine: Machine) -> float:
    """Return the main rotor's eccentricity; NaN where the axis does not move in the rotor's plane, or no part states it."""
    arms = (p.arms().get(machine.rotor.name) for p in machine.parts if machine.labels != ("r",))
    return next((float(arm.xreplace(machine.numbers)) for arm in arms if arm is not None), math.nan)


def centre_distance(steady: SteadyPhases, vibration: ForcedVibration, eccentricity: float, speeds: np.ndarray) -> np.ndarray:
    """Return the distance (N,) of the main rotor's centre of mass from the axis' static position, NaN without one."""
    main = steady.machine.bodies.index(steady.machine.rotor)
    return vibration.centre_distance(speeds, eccentricity, float(steady.angles[main]))


def self_centring_speed(steady: SteadyPhases, eccentricity: float, speeds: np.ndarray) -> float | None:
    """Return the speed from which the centre of mass stays nearer to the static position than the axis does.

    002, below (2.78). None where it never does, where nothing is eccentric, and for bodies in steady phases: the answer
    depends on the branch.
    """
    if steady.branches:
        return None

    def outside(w: np.ndarray) -> np.ndarray:
        return np.asarray(
            centre_distance(steady, steady.forced_vibration, eccentricity, w) - steady.forced_vibration.amplitude(w)[0]
        )

    if not eccentricity > 0 or not outside(speeds[-1:])[0] < 0:
        return None
    return max(crossings(outside, speeds).tolist(), default=None)


def losses_of(machine: Machine, speeds: np.ndarray) -> np.ndarray:
    """Return the torque (N,) of loads and bearings on all shafts together, positive where it brakes."""
    losses = np.zeros(len(speeds))
    for rotor in machine.rotors:
        sense, brakes = sense_of(machine, rotor), curves(machine, shaft_torques(machine, rotor)[1:])
        losses += sense * brakes(sense * speeds)[0][0]
    return losses
