"""Shares of starts from which the machine of Table 5.1 compensates, against numbers computed independently by SciPy and Numba.

A. Drozdetskaya, dissertation (2020), Table 5.1: from rest, psi in (0, 2 pi) and delta in (0, pi), cell-centred. The averaged
shares hold within 0.002 (64 x 64 cells), those of the full equations are given to three digits (32 x 32).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.ensembles.ensemble import compile_ensemble, tiles
from wucht.numerics.ensembles.members import Chunk, EnsembleResult, Members, Pace, Status
from wucht.system import System

PACE = Pace(250.0, 25, 5000.0)


@dataclass(frozen=True)
class Left:
    """What was left of the unbalance at most in the last chunk, as a share of it."""

    share: np.ndarray


@dataclass(frozen=True)
class Balanced:
    """Settled where less than 1 % is left: |s + exp(i theta_1) + exp(i theta_2)| / s. rows: of the phases."""

    rows: tuple[int, int]
    s: float

    def begin(self, members: Members) -> Left:
        return Left(np.full(len(members), np.inf))

    def update(self, record: Left, chunk: Chunk) -> tuple[Left, np.ndarray]:
        bodies = sum(np.exp(1j * chunk.samples[:, row]) for row in self.rows)
        share = (np.abs(self.s + bodies) / self.s).max(axis=0)
        return Left(share), share < 0.01

    def final_record(self, record: Left) -> Left:
        return record


def found(system: System, starts: np.ndarray, values: dict[str, float], size: int, threads: int) -> EnsembleResult[Left]:
    names = system.state_names
    watch = Balanced((names.index("p1.phase"), names.index("p2.phase")), values["s"])
    compiled = compile_ensemble(system, 1e-6)
    members = Members.of(starts, system.values(values))
    return EnsembleResult.join(list(tiles(compiled, members, watch, PACE, size, threads)))


def cells(count: int) -> list[tuple[float, float]]:
    return [(2 * np.pi * (i + 0.5) / count, np.pi * (j + 0.5) / count) for i, j in np.ndindex(count, count)]


@pytest.mark.slow
@pytest.mark.parametrize(("u", "share"), [(1.0, 0.0396), (3.0, 0.6326)])
def test_averaged_equations(u: float, share: float) -> None:
    averaged_equations = averaged_equations_of(load_machine("drozdetskaya-2020/table-5.1", {"u": u}), inertia=False)
    rest = dict.fromkeys(("rotor", "p1", "p2"), 0.0)
    angles = [{"rotor": 0.0, "p1": psi + delta / 2, "p2": psi - delta / 2} for psi, delta in cells(64)]
    starts = np.array([averaged_equations.state(a, rest) for a in angles])
    ends = found(
        averaged_equations.system,
        starts,
        dict(zip(averaged_equations.system.parameter_names, averaged_equations.values(), strict=True)),
        512,
        2,
    )
    assert ends.count(Status.FAILED) == 0
    assert ends.count(Status.SETTLED) / 64**2 == pytest.approx(share, abs=0.002)


@pytest.mark.slow
def test_full_equations_in_the_turning_frame() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1", {"u": 2.5})
    relative = RelativeEquilibria.of(machine)
    states = np.array([initial_state(machine, {"psi": psi, "delta": delta}) for psi, delta in cells(32)]).T
    ends = found(relative.system, relative.to_turning_frame(states).T, relative.values, 512, 2)
    assert ends.count(Status.SETTLED) / 32**2 == pytest.approx(0.255, abs=0.001)
