"""The steady phases of bodies over the speed, branch by branch, and where they are stable.

Balancing bodies of one rotor: those of ``closed_form``, with the rotor fixed at each speed, independent of its drive. Stability
is that of the averaged equations with the inertia of the bodies. Several rotors: the phases of a synchronous configuration,
which depend on the drives, held over the speed as where the drives balance in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.configurations.averaged_stability import transverse_stability
from wucht.analysis.configurations.closed_form import PhaseBranch, branches, compensating_phases, pattern_count, zeros_of
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import WithSlope
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import machine_at_speed
from wucht.machines.tracks import arrange_contacts

MOST_PATTERNS = 64  # ways to be in line
_PROBES = np.geomspace(1e-3, 1e3, 50)
_BESIDE = 1e-9  # of a speed: distance from the end of a branch at which it is sampled
_FEW = 3  # bodies that are named one by one


@dataclass(frozen=True)
class SteadyBranch:
    """Steady phases over the speed of the main rotor, which is positive in its sense.

    torques: with the rotor at a fixed speed. solution: the branch of bodies in line, or the phases (n,) of those that
    compensate the unbalance at any speed, or of a configuration of several rotors that are held over the speed. dimension: of
    the family that these represent. configuration_label: of a configuration that is held over the speed, and stable where the
    drives balance in it; else empty.
    """

    torques: SteadyTorques
    solution: PhaseBranch | np.ndarray
    dimension: int = 0
    configuration_label: str = ""

    def phases(self, speeds: np.ndarray) -> np.ndarray:
        """alpha (n, N) in the order of the torques, NaN where there are no such states."""
        if isinstance(self.solution, PhaseBranch):
            return np.where(speeds > 0, self.solution.phases(speeds), np.nan)
        return np.where(speeds > 0, self.solution[:, None], np.nan)

    def machine_phases(self, speeds: np.ndarray) -> WithSlope:
        """The phases (n, N) in the order of the machine's bodies, and their derivatives by the speed.

        Bodies in line turn together: the torque on one of them stays zero.
        """
        phases, t = self.phases(speeds), self.torques
        phase_slopes = np.zeros_like(phases)
        if isinstance(self.solution, PhaseBranch):
            change, rate = t.slopes(speeds, phases)
            with np.errstate(divide="ignore", invalid="ignore"):
                phase_slopes[1:] = -(rate[1] + t.shaft_torque(speeds)[1][1]) / change[1, 1:].sum(axis=0)
        order = [t.names.index(b.name) for b in t.machine.bodies]
        return phases[order], phase_slopes[order]

    def stable(self, speeds: np.ndarray) -> np.ndarray:
        """True (N,) where such a state exists and is stable."""
        phases = self.phases(speeds)
        exists, stable = np.isfinite(phases[-1]), np.zeros(len(speeds), bool)
        if self.configuration_label:
            return exists
        stable[exists] = transverse_stability(self.torques, speeds[exists], phases[:, exists], self.dimension)
        return stable

    def ends(self, speeds: np.ndarray) -> np.ndarray:
        """Speeds beside the ends of the branch on a grid (N,): on both sides of each."""
        if not isinstance(self.solution, PhaseBranch):
            return np.empty(0)
        edges = zeros_of(self.solution.margin, speeds[speeds > 0])
        return np.concatenate([edges * (1 - _BESIDE), edges * (1 + _BESIDE)])

    def labels(self, speeds: np.ndarray) -> np.ndarray:
        """Labels of the states (N,), empty where there are none."""
        if self.configuration_label:
            return np.where(np.isfinite(self.phases(speeds)[-1]), self.configuration_label, "")
        beside = self.solution.sides if isinstance(self.solution, PhaseBranch) else ()
        return labels_of(self.torques, beside, self.phases(speeds))

    @cached_property
    def overlapping(self) -> bool:
        """True if bodies of a track are in each other's place: the angles between those in line do not change."""
        shift = self.solution.shift if isinstance(self.solution, PhaseBranch) else self.solution
        return overlapping(self.torques, shift)


def labels_of(torques: SteadyTorques, beside: tuple[int, ...], phases: np.ndarray) -> np.ndarray:
    """Labels (N,) of steady phases (n, N), empty where these are NaN.

    beside: the sides of the line on which bodies are, empty where they compensate the unbalance. The heavy side is that of
    the rotor's unbalance.
    """
    exists = np.isfinite(phases[-1])
    if not beside:
        return np.where(exists, "compensating", "")
    assert torques.coefficients is not None
    heavy = (torques.coefficients[1] * np.exp(1j * phases[1])).real > 0  # the first body
    return np.where(
        exists, np.where(heavy, _line_label(torques, beside, beside[0]), _line_label(torques, beside, 1 - beside[0])), ""
    )


def _line_label(torques: SteadyTorques, beside: tuple[int, ...], heavy: int) -> str:
    """Label of bodies in line. heavy: the heavy side of the line."""
    heavy_bodies = [name for name, side in zip(torques.names[1:], beside, strict=True) if side == heavy]
    if len(heavy_bodies) in (0, len(beside)):
        return f"{'together, ' if len(beside) > 1 else ''}{'heavy side' if heavy_bodies else 'light side'}"
    if len(torques.classes) > 1 and len(heavy_bodies) <= _FEW:
        return f"opposed, {', '.join(heavy_bodies)} heavy"
    return "opposed" if len(beside) == 2 else f"opposed, {len(heavy_bodies)} heavy, {len(beside) - len(heavy_bodies)} light"


def overlapping(torques: SteadyTorques, phases: np.ndarray) -> bool:
    """True if bodies of a track would be in each other's place at phases (n,)."""
    try:  # a machine without tracks is returned as it is
        arrange_contacts(torques.machine, dict(zip(torques.names, (torques.senses * phases).tolist(), strict=True)))
    except InputError:
        return True
    return False


def steady_branches(machine: Machine) -> tuple[SteadyTorques, tuple[SteadyBranch, ...]]:
    """The torques on a machine's bodies as its drive turns them, and all branches of their steady phases.

    Raises ``InputError`` where they are not known in closed form, with the reason.
    """
    torques = SteadyTorques.of(machine_at_speed(machine, None))
    if any(torques.heads):
        raise InputError(
            "machine.bodies",
            None,
            "several rotors turn, and the phases between them depend on their drives",
            code="several-rotors",
        )
    top = max((abs(w) for w in torques.vibration.poles.imag), default=1.0) or 1.0
    if torques.coefficients is None or not torques.has_idle_bodies(top * _PROBES):
        reason = "balancing bodies are not on the rotor's axis, or have drive, load or bearing torques"
        raise InputError("machine.bodies", None, f"{reason}: their steady phases are not known in closed form")
    if (patterns := pattern_count(torques)) > MOST_PATTERNS:
        raise InputError(
            "machine.bodies", None, f"the bodies can be in line in {patterns} ways; at most {MOST_PATTERNS} are examined"
        )
    fixed_speed_torques = torques.with_fixed_speed(top)
    solutions: list[SteadyBranch] = [
        SteadyBranch(fixed_speed_torques, phases, dimension)
        for phases, dimension, _ in compensating_phases(fixed_speed_torques)
    ]
    solutions += [SteadyBranch(fixed_speed_torques, branch) for branch in branches(fixed_speed_torques, top * _PROBES)]
    if not solutions:
        raise InputError(
            "machine.bodies",
            None,
            "the rotor has no unbalance, and the bodies cannot balance each other: there are no steady phases",
            code="no-unbalance",
        )
    return torques, tuple(solutions)
