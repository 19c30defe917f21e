"""Basins with known borders in the place of the engine that runs the members: outcomes as a function of the start."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

MACHINE = load_machine("drozdetskaya-2020/table-5.1")
TURN = {"psi": [0.0, 2 * math.pi, 32], "delta": [0.0, math.pi, 16]}
Region = Callable[[np.ndarray, np.ndarray], np.ndarray]


def spiral(psi: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """Arms that are thinner than a coarse cell where they end; it lies over the seam at psi = 0."""
    x, y = np.remainder(psi + math.pi - 0.5, 2 * math.pi) - math.pi, delta - 1.5
    r = np.hypot(x / 1.2, y)
    return np.sin(2 * np.arctan2(y, x / 1.2) + 5 * r) > 0.2 + r**2


def phases(starts: np.ndarray, machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """psi and delta of states (n, M)."""
    a, b = (starts[machine.row(machine.body(name).coordinate.position)] for name in ("p1", "p2"))
    return (a + b) / 2, a - b


def engine(inside: Region, fail: Region | None = None, read: Callable[..., Any] = phases) -> Callable[..., MemberOutcomes]:
    """``outcomes_of`` with compensation inside and capture outside; settling times are 100 + psi + delta. read: these."""

    def outcomes_of(
        question: EnsembleQuestion,
        starts: np.ndarray,
        values: Mapping[str, np.ndarray],
        report: Callable[[float], None] | None = None,
    ) -> MemberOutcomes:
        psi, delta = read(starts, question.machine)
        if report is not None:
            report(0.5)
        names = np.where(inside(psi, delta), OUTCOMES.index(Outcome.COMPENSATED), OUTCOMES.index(Outcome.CAPTURED))
        failed = np.zeros(len(psi), bool) if fail is None else fail(psi, delta)
        names = np.where(failed, OUTCOMES.index(Outcome.FAILED), names).astype(np.int8)
        why = tuple((int(m), "it is a test") for m in np.flatnonzero(failed))
        return MemberOutcomes(names, np.where(failed, np.nan, 100 + psi + delta), psi, np.full(len(psi), 500.0), why)

    return outcomes_of


def counted(
    monkeypatch: pytest.MonkeyPatch,
    running: ModuleType,
    known: Callable[..., MemberOutcomes],
    tile: int,
    parameter: str | None = None,
) -> list[bytes]:
    """The starts that a study runs, with the machine's value of a parameter, each as often as it is; tiles of this size."""
    run: list[bytes] = []

    def outcomes_of(question: EnsembleQuestion, states: np.ndarray, values: Any, report: Any = None) -> MemberOutcomes:
        made = known(question, states, values, report)
        value = b"" if parameter is None else np.float64(question.machine.values[parameter]).tobytes()
        run.extend(column.tobytes() + value for column in states.T)
        return made

    monkeypatch.setattr(running, "_TILE", dict.fromkeys(running._TILE, tile) if isinstance(running._TILE, dict) else tile)
    monkeypatch.setattr(running, "outcomes_of", outcomes_of)
    return run


def share_of(summary: Mapping[str, Any], outcome: str = "compensated") -> float:
    """Of an outcome in the map."""
    return float(summary["fractions"].get(outcome, 0.0))
