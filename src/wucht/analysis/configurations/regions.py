"""Which steady phase configurations are stable in the averaged equations, over speed and unbalance ratio."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.configurations.closed_form import branches
from wucht.analysis.configurations.force_balance import compensating
from wucht.analysis.configurations.slow_stability import NEUTRAL, slow_matrices, transverse
from wucht.analysis.configurations.torques import SteadyTorques

REGIONS = ("compensating", "together, adding", "together, reducing", "opposed")


@dataclass(frozen=True)
class Regions:
    """speed (N,) in the main rotor's own sense, ratio (M,), and whether a state of each region is stable (4, M, N).

    ratio: of the unbalance of all balancing bodies together to the rotor's. ``exists`` likewise: whether there is one.
    """

    speed: np.ndarray
    ratio: np.ndarray
    stable: np.ndarray
    exists: np.ndarray

    @classmethod
    def joined(cls, tiles: Sequence[Regions]) -> Regions:
        """Tiles of the same speeds, in the order of their ratios."""
        stable, exists = (np.concatenate(rows, axis=1) for rows in ([t.stable for t in tiles], [t.exists for t in tiles]))
        return cls(tiles[0].speed, np.concatenate([t.ratio for t in tiles]), stable, exists)


def regions(torques: SteadyTorques, speeds: np.ndarray, ratios: np.ndarray) -> Regions:
    """The regions at speeds (N,) and ratios (M,), the main rotor held at each speed; the inertia of the bodies is kept."""
    stable, exists = np.zeros((2, len(REGIONS), len(ratios), len(speeds)), bool)
    for row, ratio in enumerate(ratios):
        held = _with_ratio(torques.held(float(speeds[0])), ratio)
        for region, phases, valid, dimension in _states(held, speeds):
            exists[region, row] |= valid
            stable[region, row, valid] |= _stable(held, speeds[valid], phases[:, valid], dimension)
    return Regions(speeds, ratios, stable, exists)


def _with_ratio(torques: SteadyTorques, ratio: float) -> SteadyTorques:
    """The same with another unbalance of the main rotor."""
    assert torques.coefficients is not None
    excitation = torques.vibration.excitation.copy()
    excitation[0] *= np.abs(torques.coefficients[1:]).sum() / ratio / np.linalg.norm(excitation[0])
    return replace(torques, vibration=replace(torques.vibration, excitation=excitation), felt=excitation)


def _states(torques: SteadyTorques, speeds: np.ndarray) -> Iterator[tuple[int, np.ndarray, np.ndarray, int]]:
    """Region, phases (n, N), where there is such a state (N,), and the dimension of its family."""
    for phases, dimension, _ in compensating(torques, spread=False)[:1]:
        yield 0, np.repeat(phases[:, None], len(speeds), axis=1), np.ones(len(speeds), bool), dimension
    c = torques.coefficients
    assert c is not None
    for branch in branches(torques, speeds):
        phases = branch.phases(speeds)
        exists, adding = np.isfinite(phases[0]), np.abs(c @ np.exp(1j * phases)) >= abs(c[0])
        for region, valid in ((3, exists),) if len(set(branch.beside)) > 1 else ((1, exists & adding), (2, exists & ~adding)):
            yield region, phases, valid, 0


def _stable(torques: SteadyTorques, speeds: np.ndarray, phases: np.ndarray, dimension: int) -> np.ndarray:
    exponents = transverse(np.linalg.eigvals(slow_matrices(torques, speeds, phases)), dimension)
    return np.asarray(exponents.real.max(axis=1) < -NEUTRAL * np.abs(exponents).max(axis=1))
