"""Which steady phase configurations are stable in the slow equations, over speed and unbalance ratio."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.configurations.closed_form import patterns, signed
from wucht.analysis.configurations.force_balance import compensating
from wucht.analysis.configurations.slow_stability import NEUTRAL, transverse
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
        ratio = np.concatenate([t.ratio for t in tiles])
        stable, exists = (np.concatenate(rows, axis=1) for rows in ([t.stable for t in tiles], [t.exists for t in tiles]))
        return cls(tiles[0].speed, ratio, stable, exists)


def regions(torques: SteadyTorques, speeds: np.ndarray, ratios: np.ndarray) -> Regions:
    """The regions at speeds (N,) and ratios (M,), the main rotor held at each speed; the inertia of the bodies is kept."""
    cells = _Cells.of(torques, speeds, ratios)
    stable, exists = (np.zeros((len(REGIONS), len(ratios), len(speeds)), bool) for _ in range(2))
    for region, phases, there, dimension in cells.states():
        exists[region] |= there
        stable[region][there] |= cells.stable(phases, there, dimension)
    return Regions(speeds, ratios, stable, exists)


@dataclass(frozen=True)
class _Cells:
    """Speeds (N,), rotor's coefficients c_0 (M,) of the ratios, the others c (n - 1,), and a (N,): as in ``SteadyTorques``."""

    torques: SteadyTorques
    speeds: np.ndarray
    rotor: np.ndarray
    others: np.ndarray
    influence: np.ndarray

    @classmethod
    def of(cls, torques: SteadyTorques, w: np.ndarray, share: np.ndarray) -> _Cells:
        held, c = torques.held(float(w[0])), torques.coefficients
        assert c is not None
        return cls(held, w, np.abs(c[1:]).sum() / share, c[1:], held.axis_influence(w))

    def states(self) -> Iterator[tuple[int, np.ndarray, np.ndarray, int]]:
        """Region, phases (n - 1, M, N), where there is such a state (M, N), and the dimension of its family."""
        yield from self._compensating()
        eta, sine = np.angle(self.influence), self.influence.imag / np.abs(self.influence)
        for side, _, twice in patterns(self.torques):
            g = signed(self.torques, side)
            q = (g / self.rotor)[:, None] * sine
            there = np.abs(q) <= 1
            angle = np.arcsin(np.clip(q, -1, 1))
            for line in (eta + angle,) if twice else (eta + angle, eta + np.pi - angle):
                phases = (np.pi * side[1:] - np.angle(self.others))[:, None, None] + line
                if len(set(side[1:].tolist())) > 1:
                    yield 3, phases, there, 0
                    continue
                adding = np.abs(self.rotor[:, None] + g * np.exp(1j * line)) >= self.rotor[:, None]
                yield 1, phases, there & adding, 0
                yield 2, phases, there & ~adding, 0

    def _compensating(self) -> Iterator[tuple[int, np.ndarray, np.ndarray, int]]:
        phases = np.zeros((len(self.others), len(self.rotor), len(self.speeds)))
        there, dimension = np.zeros(phases.shape[1:], bool), 0
        for k, c_0 in enumerate(self.rotor):
            for at, dimension, _ in compensating(self._with_rotor(c_0), spread=False)[:1]:  # noqa: B007
                phases[:, k], there[k] = at[1:, None], True
        yield 0, phases, there, dimension

    def _with_rotor(self, c_0: float) -> SteadyTorques:
        """The same with another unbalance of the main rotor."""
        excitation = self.torques.vibration.excitation.copy()
        excitation[0] *= c_0 / np.linalg.norm(excitation[0])
        return replace(self.torques, vibration=replace(self.torques.vibration, excitation=excitation))

    def stable(self, phases: np.ndarray, there: np.ndarray, dimension: int) -> np.ndarray:
        """Whether the states of some cells are stable (k,): the linearised slow equations as in ``slow_matrices``."""
        row, column = np.nonzero(there)
        n, w = len(self.others), self.speeds[column]
        alpha = np.concatenate([np.zeros((1, len(row))), phases[:, row, column]])
        c = np.concatenate([self.rotor[None, row], np.repeat(self.others[:, None], len(row), axis=1)])
        turned = c * np.exp(1j * alpha)
        pull = (w**4 / 2 * self.influence[column]) * (turned[:, None].conj() * turned[None])
        change = pull.real
        index = np.arange(n + 1)
        change[index, index] = 0.0
        change[index, index] = -change.sum(axis=1)
        inverse = np.linalg.inv(self.torques.inertia[1:, 1:])
        brake = -self.torques.relative[1:, 1:, None] + np.zeros(len(row))
        brake[index[:n], index[:n]] += self.torques.alone(w)[1][1:]
        matrix = np.zeros((len(row), 2 * n, 2 * n))
        matrix[:, :n, n:] = np.eye(n)
        matrix[:, n:, :n] = np.einsum("ij,jkN->Nik", inverse, change[1:, 1:])
        matrix[:, n:, n:] = np.einsum("ij,jkN->Nik", inverse, brake)
        found = transverse(np.linalg.eigvals(matrix), dimension)
        grows: np.ndarray = found.real.max(axis=1) < -NEUTRAL * np.abs(found).max(axis=1)
        return grows
