"""What a machine puts on its foundation: at rest, in operation, and at most in a run; and the energy of its stroke."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.analysis.foundation_forces import FoundationForces, SupportDirection
from wucht.analysis.starting import gravity_of
from wucht.analysis.throw import largest_of
from wucht.analysis.vibration import Vibration
from wucht.dynamics.run_ups.observed_loads import mount_places
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import motion_of
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.zeros_and_peaks import extremes

_FEWEST = 8  # samples in the window
_CANCELLATION = 1e-6  # of the bodies' forces: what remains of forces that cancel
Forces = Mapping[SupportDirection, float]


@dataclass(frozen=True)
class StaticLoads:
    """The machine at rest under its weight. forces: on the foundation, along x and y. deflections: downwards, by support."""

    forces: Forces
    deflections: Mapping[str, float]

    @classmethod
    def of(cls, machine: Machine) -> StaticLoads | None:
        """The static loads; None where the weight is not part of the model, or nothing is free to move up and down."""
        forces = FoundationForces.of(machine) if gravity_of(machine) and "y" in machine.free_labels else None
        if forces is None:
            return None
        rest = dict(zip(machine.labels, machine.rest.tolist(), strict=True))
        places = mount_places(machine)
        return cls(forces.at_rest, {n: -(rest["y"] + x * rest.get("r", 0.0)) for n, (x, _) in places.items()})


@dataclass(frozen=True)
class FoundationLoads:
    """What a run puts on the foundation beyond the weight.

    amplitudes: half the range in the last window. peaks: the largest magnitude in the whole run. transmissibility: largest
    force of all supports together over that of the unbalances, in the last window; None where these cancel.
    """

    amplitudes: Forces
    peaks: Forces
    transmissibility: float | None

    @classmethod
    def of(cls, machine: Machine, motion: Trajectory, window: tuple[float, float], noise: Noise) -> FoundationLoads | None:
        """The loads of a motion. None for a machine without supports, and for a window of few samples."""
        inside, forces = (motion.time >= window[0]) & (motion.time <= window[1]), FoundationForces.of(machine)
        if forces is None or np.count_nonzero(inside) < _FEWEST:
            return None
        values = forces(motion)
        peaks = {key: float(np.abs(extremes(f)).max()) for key, f in values.items()}
        most = max(peaks.values())
        amplitudes = {key: noise.without(float(np.ptp(extremes(f[inside]))) / 2, most) for key, f in values.items()}
        zero = np.zeros(np.count_nonzero(inside))
        total = np.array([sum((f[inside] for key, f in values.items() if key.direction == d), zero) for d in "xy"])
        exciting = exciting_force(machine, motion)
        transmissibility = None
        if exciting is not None:
            transmissibility = largest_of(total - total.mean(axis=1, keepdims=True)) / largest_of(exciting[:, inside])
        return cls(amplitudes, peaks, transmissibility)


def exciting_force(machine: Machine, motion: Trajectory) -> np.ndarray | None:
    """The force of the unbalances on the carrier along x and y (2, N), zero where it is not free: U phi'^2, at constant speed.

    None where it cancels, and of a machine in which a mass slides on a turning body.
    """
    if machine.sliders:
        return None
    senses = np.array([[sense_of(machine, b)] for b in machine.bodies])
    angles, speeds = np.moveaxis(np.array([motion_of(machine, motion, b) for b in machine.bodies]), 1, 0)
    turning = speeds**2 * np.exp(1j * senses * angles)
    of_bodies = Vibration.of(machine).excitation.T[:, :, None] * turning
    ways = {label: f for label, f in zip(machine.free_labels, of_bodies, strict=True) if label in ("x", "y")}
    zero = np.zeros_like(turning)
    forces = np.array([ways.get(d, zero).real for d in "xy"])
    total = forces.sum(axis=1)
    is_cancelled = np.abs(total).max() <= _CANCELLATION * np.abs(forces).max(axis=(0, 2)).sum()
    return None if is_cancelled else np.asarray(total)
