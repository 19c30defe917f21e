"""Stability of steady phase configurations in the averaged equations, of one state and over speed and unbalance ratio.

J theta'' + B theta' = tau(theta') + V(theta_0', alpha), linearised about equal speeds and steady phases; or the equations
without the inertia of the balancing bodies. Perturbations along a family of states, or along an interval of speeds without
torque, neither grow nor decay: they are omitted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.averaged_equations import AveragedEquations
from wucht.analysis.configurations.closed_form import State, branches, compensating_phases
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.numerics.flow.jacobian import Jacobian

NEUTRAL = 1e-9  # of the fastest rate: an exponent whose real part is smaller neither grows nor decays
REGIONS = ("compensating", "together, adding", "together, reducing", "opposed")


@dataclass(frozen=True)
class Stability:
    """Stability of a state. stable: None where it is undecided. exponents: (k,), complex, the fastest growing first.

    reason: why it is undecided, or a remark.
    """

    stable: bool | None
    exponents: np.ndarray
    reason: str = ""

    @classmethod
    def without_verdict(cls, reason: str) -> Stability:
        """An undecided stability without exponents."""
        return cls(None, np.empty(0, complex), reason)

    @classmethod
    def from_exponents(cls, exponents: np.ndarray, neutral: float, reason: str) -> Stability:
        """Stability by the largest real part. neutral: below it an exponent counts as zero, and ``reason`` is reported."""
        if not np.isfinite(exponents).all():
            return cls(None, exponents, "the exponents cannot be computed here")
        if len(exponents) and abs(exponents[0].real) <= neutral:
            return cls(None, exponents, reason)
        return cls(bool((exponents[:1].real < 0).all()), exponents)

    def family_stability(self, members: Sequence[Stability]) -> Stability:
        """Return the stability of a family with other members: undecided where those that are decided do not agree."""
        decisions = [one.stable for one in (self, *members) if one.stable is not None]
        if self.stable is None or len(set(decisions)) < 2:
            return self
        state_verdict = "stable" if self.stable else "not stable"
        reason = f"stable at {sum(decisions)} of {len(decisions)} examined members of the family, {state_verdict} at this one"
        return Stability(None, self.exponents, reason)

    @property
    def leading(self) -> complex | None:
        """The exponent that grows fastest."""
        return complex(self.exponents[0]) if len(self.exponents) else None


@dataclass(frozen=True)
class AveragedStability:
    """The averaged equations of a machine, linearised about its steady phase configurations."""

    torques: SteadyTorques
    averaged_equations: AveragedEquations

    @cached_property
    def _linear(self) -> Jacobian:
        return Jacobian.of(self.averaged_equations.system)

    def stability(self, state: State) -> Stability:
        """Stability of a state, transverse to its family."""
        exponents = self.exponents(state, state.phases[:, None])[0]
        neutral = NEUTRAL * float(np.abs(exponents).max(initial=0.0))
        return Stability.from_exponents(exponents, neutral, "neither grows nor decays")

    def exponents(self, state: State, phases: np.ndarray) -> np.ndarray:
        """The exponents (N, k) of members (n, N) of a state's family, transverse to it, the fastest growing first.

        NaN where the equations are singular.
        """
        speed, averaged_equations = state.interior_state.speed, self.averaged_equations
        if averaged_equations.inertia and averaged_equations.order == 1:
            matrices = averaged_matrices(self.torques, np.full(phases.shape[1], speed), phases)
        else:
            states = np.array([averaged_equations.steady_state(speed, at) for at in phases.T]).T
            matrices = np.moveaxis(self._linear(states, averaged_equations.values())[1], -1, 0)
        regular = np.isfinite(matrices).all(axis=(1, 2))
        exponents = np.full(matrices.shape[:2], np.nan, complex)
        exponents[regular] = np.linalg.eigvals(matrices[regular])
        return transverse_exponents(exponents, state.neutral)


def averaged_matrices(torques: SteadyTorques, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """The linearised averaged equations (N, k, k) at speeds (N,) and phases (n, N).

    Unknowns: the phases of all bodies to the main rotor, then the speeds of those whose speed is not given.
    """
    n, free = torques.size, list(torques.free)
    change, rate = torques.slopes(speeds, phases)
    by_speed = np.repeat(-torques.relative[:, :, None], len(speeds), axis=2)
    by_speed[np.arange(n), np.arange(n)] += torques.shaft_torque(speeds)[1]
    by_speed[:, 0] += rate
    inverse = np.linalg.inv(torques.inertia[np.ix_(free, free)])
    matrices = np.zeros((len(speeds), n - 1 + len(free), n - 1 + len(free)))
    matrices[:, : n - 1, n - 1 :] = (np.eye(n) - np.eye(n)[0])[1:, free]
    matrices[:, n - 1 :, : n - 1] = np.einsum("ij,jkN->Nik", inverse, change[free][:, 1:])
    matrices[:, n - 1 :, n - 1 :] = np.einsum("ij,jkN->Nik", inverse, by_speed[np.ix_(free, free)])
    return matrices


def transverse_stability(torques: SteadyTorques, speeds: np.ndarray, phases: np.ndarray, dimension: int) -> np.ndarray:
    """True (N,) where steady phases (n, N) at fixed speeds (N,) of the main rotor are stable across their family."""
    exponents = transverse_exponents(np.linalg.eigvals(averaged_matrices(torques, speeds, phases)), dimension)
    return np.asarray(exponents.real.max(axis=1) < -NEUTRAL * np.abs(exponents).max(axis=1))


def transverse_exponents(eigenvalues: np.ndarray, dimension: int) -> np.ndarray:
    """Eigenvalues (N, k) without the ``dimension`` smallest, the fastest growing first."""
    remaining = np.take_along_axis(eigenvalues, np.argsort(np.abs(eigenvalues), axis=-1)[..., dimension:], -1)
    return np.asarray(np.take_along_axis(remaining, np.argsort(-remaining.real, axis=-1, kind="stable"), -1))


@dataclass(frozen=True)
class Regions:
    """Stability (4, M, N) of a state of each region over speed (N,), in the main rotor's sense, and ratio (M,).

    ratio: of the unbalance of all balancing bodies together to the rotor's. ``exists`` likewise: True where there is a state.
    """

    speed: np.ndarray
    ratio: np.ndarray
    stable: np.ndarray
    exists: np.ndarray

    @classmethod
    def from_tiles(cls, tiles: Sequence[Regions]) -> Regions:
        """Join tiles of the same speeds, in the order of their ratios."""
        stable, exists = (np.concatenate([getattr(t, name) for t in tiles], axis=1) for name in ("stable", "exists"))
        return cls(tiles[0].speed, np.concatenate([t.ratio for t in tiles]), stable, exists)


def regions(torques: SteadyTorques, speeds: np.ndarray, ratios: np.ndarray) -> Regions:
    """The regions at speeds (N,) and ratios (M,), the main rotor fixed at each speed; the inertia of the bodies is kept."""
    stable, exists = np.zeros((2, len(REGIONS), len(ratios), len(speeds)), bool)
    for row, ratio in enumerate(ratios):
        fixed_speed_torques = torques.with_fixed_speed(float(speeds[0])).with_ratio(ratio)
        for region, phases, valid, dimension in _states(fixed_speed_torques, speeds):
            exists[region, row] |= valid
            stable[region, row, valid] |= transverse_stability(fixed_speed_torques, speeds[valid], phases[:, valid], dimension)
    return Regions(speeds, ratios, stable, exists)


def _states(torques: SteadyTorques, speeds: np.ndarray) -> Iterator[tuple[int, np.ndarray, np.ndarray, int]]:
    """Region, phases (n, N), existence of such a state (N,), and the dimension of its family."""
    for phases, dimension, _ in compensating_phases(torques, spread=False)[:1]:
        yield 0, np.repeat(phases[:, None], len(speeds), axis=1), np.ones(len(speeds), bool), dimension
    c = torques.coefficients
    assert c is not None
    for branch in branches(torques, speeds):
        phases = branch.phases(speeds)
        exists, adding = np.isfinite(phases[0]), np.abs(c @ np.exp(1j * phases)) >= abs(c[0])
        for region, valid in ((3, exists),) if len(set(branch.sides)) > 1 else ((1, exists & adding), (2, exists & ~adding)):
            yield region, phases, valid, 0
