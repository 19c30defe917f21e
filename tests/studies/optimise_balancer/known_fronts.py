"""An engine of runs with known outcomes, in place of the integration: those that a test states, or Schaffer's two parabolas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from wucht import OptimiseBalancer
from wucht.dynamics.balancers import balancer_candidate, balancer_search, candidates
from wucht.dynamics.balancers.candidates import least_residual
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.machines.machine import Machine
from wucht.studies.runner import report, run
from wucht.studies.study_file import read_study

_OWN, END = 5e-5, 30.0  # damping of the machine as it is; how far each run is followed
MACHINE = read_study("drozdetskaya-2020/r1").subject.with_values({"p1.damping": _OWN, "p2.damping": _OWN})
RANGE = [1e-6, 1e-2]  # of the damping: x from -1 to 3
OWN = float(np.log10(_OWN) + 5)  # x of the machine as it is


def x_of(damping: np.ndarray) -> np.ndarray:
    """-1 to 3 over the range, by the logarithm."""
    return np.asarray(np.log10(damping) + 5)


class End(NamedTuple):
    """How a run ends. time: the settling time."""

    time: float = np.nan
    peak: float = 1e-3
    outcome: Outcome = Outcome.COMPENSATED


CAUGHT, OPEN = End(outcome=Outcome.CAPTURED), End(outcome=Outcome.UNIDENTIFIED)


class Candidate(NamedTuple):
    """What a run belongs to: x of the damping, the mass of a body in g; is_full: with the full equations."""

    x: float
    mass: float
    bodies: int
    is_full: bool


def parabolas(candidate: Candidate) -> End:
    """Schaffer's problem: settling time x^2, peak (x - 2)^2."""
    return End(candidate.x**2, (candidate.x - 2) ** 2)


class KnownRuns:
    """The runs of each candidate end as a test states: all alike, or the first ones in one way, and so on.

    ends: of a candidate, an ``End``, or pairs of a share of its runs and their end. questions, starts: those that were asked,
    and with which starts; members: how many were run.
    """

    def __init__(self, ends: Callable[[Candidate], End | list[tuple[float, End]]]) -> None:
        self.ends, self.questions, self.starts, self.members = ends, list[Any](), list[np.ndarray](), 0

    def __call__(
        self, question: Any, starts: np.ndarray, values: Mapping[str, np.ndarray], report: Any = None
    ) -> MemberOutcomes:
        (report or (lambda _: None))(0.5)
        machine, count, ended = question.machine, starts.shape[1], list[End]()
        self.questions.append(question)
        self.starts.append(starts)
        self.members += count
        damping, mass = (values.get(p, np.full(count, machine.values[p])) for p in ("p1.damping", "p1.mass"))
        first = np.flatnonzero((starts == starts[:, :1]).all(axis=0))  # all candidates start alike
        bodies, runs = len(machine.group(machine.rotor)) - 1, count // len(first)
        for k in first.tolist():
            ends = self.ends(Candidate(float(x_of(damping[k])), 1e3 * float(mass[k]), bodies, question.model == "full"))
            for share, end in [(1.0, ends)] if isinstance(ends, End) else ends:
                ended += [end] * round(share * runs)
        outcome = np.array([OUTCOMES.index(end.outcome) for end in ended], np.int8)
        time, peak = np.array([end.time for end in ended]), np.array([end.peak for end in ended])
        return MemberOutcomes(outcome, time, peak, np.full(count, END))


def ask_known(
    monkeypatch: pytest.MonkeyPatch,
    ends: Callable[[Candidate], End | list[tuple[float, End]]] | KnownRuns,
    machine: Machine = MACHINE,
    stands: Callable[[Machine], float | None] = least_residual,
    rates: Any = None,
    **asked: Any,
) -> xr.Dataset:
    """Ask about runs that end as is stated. stands: what stable states leave, by default the least that is possible; rates: of
    the dampings, by default none."""

    def state(machine: Machine, full: bool) -> SimpleNamespace | None:
        left = stands(machine)
        return None if left is None else SimpleNamespace(residual=left)

    def decay_rates(_trials: Any, dampings: np.ndarray, _report: Any = None) -> tuple[np.ndarray, float]:
        return (np.full(len(dampings), np.nan), np.nan) if rates is None else rates(dampings)

    monkeypatch.setattr(candidates, "outcomes_of", ends if isinstance(ends, KnownRuns) else KnownRuns(ends))
    monkeypatch.setattr(balancer_candidate, "compensated_state", state)
    monkeypatch.setattr(balancer_search, "decay_rates", decay_rates)
    how = {key: asked.pop(key) for key in ("folder", "progress") if key in asked}
    question: dict[str, Any] = {"vary": {"damping": RANGE}, "samples": 8, "population": 4, "evaluations": 4, "points": 4}
    return run(OptimiseBalancer(**question | {"damping_curve": False} | asked), machine, **how)


def told(result: xr.Dataset) -> dict[str, str]:
    """The lines of the report by their headings; lines below one without a heading are joined to it."""
    lines = dict[str, str]()
    for line in report(result)[2:]:
        heading = line[2:15].strip()
        last = heading or list(lines)[-1]
        lines[last] = line[15:] if heading else f"{lines[last]}\n{line[15:]}"
    return lines
