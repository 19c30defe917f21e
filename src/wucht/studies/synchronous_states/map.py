"""The stability map of constant phases: which of them are stable in the slow equations, over speed and unbalance ratio."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.synchronous.closed import patterns, signed
from wucht.machines.synchronous.polygon import compensating
from wucht.machines.synchronous.torques import SteadyTorques
from wucht.studies.synchronous_states.speeds import speed_limits
from wucht.studies.synchronous_states.stability import NEUTRAL, transverse

REGIONS = ("compensating", "together, adding", "together, reducing", "opposed")
_MOST_PATTERNS = 64

Axis = tuple[float, float, int]  # lowest, highest, cells


@dataclass(frozen=True)
class StabilityMap:
    """speed (N,) in the main rotor's own sense, ratio (M,), and whether a state of each region is stable (4, M, N).

    ``exists`` likewise: whether there is one.
    """

    speed: np.ndarray
    ratio: np.ndarray
    stable: np.ndarray
    exists: np.ndarray


def check_map(torques: SteadyTorques, machine: Machine, axes: Mapping[str, Axis]) -> None:
    """Raises ``InputError`` where there is no ratio of unbalances, or no closed form, or speeds are out of reach."""
    c = torques.coefficients
    if c is None or torques.size < 3 or any(h != 0 for h in torques.heads):
        raise InputError(
            "study.axes", None, "allowed for a rotor with at least two balancing bodies and nothing else that turns"
        )
    if not abs(c[0]):
        raise InputError("study.axes", None, "the rotor has no unbalance, so there is no ratio to it")
    patterns = int(np.prod([len(m) + 1 for m in torques.classes]))
    if patterns > _MOST_PATTERNS:
        raise InputError(
            "study.axes", None, f"allowed are bodies with up to {_MOST_PATTERNS} ways to be in line, not {patterns}"
        )
    highest = speed_limits(machine)[1]
    if axes["speed"][1] > highest:
        unit = machine.units.speed
        raise InputError("study.axes.speed", list(axes["speed"]), f"allowed are speeds up to {highest:.3g} {unit}".rstrip())
    if not torques.idle(_centres(*axes["speed"])):
        raise InputError("study.axes", None, "balancing bodies have torques of their own, so that none of these states stays")


def stability_map(torques: SteadyTorques, speed: Axis, ratio: Axis) -> StabilityMap:
    """The map, cell-centred, the main rotor held at each speed; the inertia of the bodies is kept."""
    w, share = _centres(*speed), _centres(*ratio)
    cells = _Cells.of(torques, w, share)
    stable, exists = (np.zeros((len(REGIONS), len(share), len(w)), bool) for _ in range(2))
    for region, phases, there, dimension in cells.states():
        exists[region] |= there
        stable[region][there] |= cells.stable(phases, there, dimension)
    return StabilityMap(w, share, stable, exists)


def _centres(low: float, high: float, cells: int) -> np.ndarray:
    edges = np.linspace(low, high, cells + 1)
    found: np.ndarray = (edges[1:] + edges[:-1]) / 2
    return found


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
