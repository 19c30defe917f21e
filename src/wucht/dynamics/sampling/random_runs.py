"""Runs of a machine with random starts and parameters at values of another parameter: outcomes, and the probability of some."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.run_ups.run_variations import VariedQuantity
from wucht.dynamics.sampling.distributions import REPLICATES
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle
from wucht.dynamics.sampling.ensemble_run import member_advice, outcomes_at
from wucht.dynamics.sampling.ensembles import (
    EnsembleQuestion,
    MemberOutcomes,
    Start,
    initial_states,
    omissions_among,
)
from wucht.dynamics.sampling.probability_bands import band
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.dynamics.work import TaskReport, Work
from wucht.schema import Parameter

_PROBES = 64  # samples that are checked before the first run
_TILE = 1024  # runs in a unit of work


@dataclass(frozen=True)
class ProbabilityPoint:
    """Outcomes of the runs at a value of the parameter, and the confidence bounds of the probability of some outcomes.

    inside, open: number of runs of each replicate (R,) with one of these, and with an unknown outcome. advice, needed_time:
    where no run has a verdict.
    """

    value: float
    low: float
    high: float
    members: MemberOutcomes
    inside: np.ndarray
    open: np.ndarray
    advice: str | None = None
    needed_time: float | None = None

    @classmethod
    def of(cls, value: float, members: MemberOutcomes, outcomes: Sequence[str], confidence: float) -> ProbabilityPoint:
        """Count the runs of the replicates, one after the other, with some outcomes."""
        of_replicates = (members.has_outcome(labels).reshape(REPLICATES, -1) for labels in (outcomes, OPEN_OUTCOMES))
        inside, open_ = (np.asarray(runs.sum(axis=1)) for runs in of_replicates)
        return cls(value, *band(inside, open_, len(members.outcome) // REPLICATES, confidence), members, inside, open_)

    @property
    def open_share(self) -> float:
        """Share of the runs without a verdict."""
        return float(self.open.sum()) / len(self.members.outcome)

    @property
    def is_undecided(self) -> bool:
        """True if no run has a verdict: then the probability may be anything."""
        return int(self.open.sum()) == len(self.members.outcome)

    @property
    def estimate(self) -> float:
        """Share of the inside runs among those with a known outcome; NaN if there are none."""
        known_count = len(self.members.outcome) - int(self.open.sum())
        return float(self.inside.sum()) / known_count if known_count else float("nan")


@dataclass(frozen=True)
class RandomRuns:
    """Runs of a machine. question: of each, but for the value of the parameter ``along``. quantities: the random ones (q).

    start: the rest of the start. counted_outcomes: those whose probability is computed, with bounds of a confidence.
    """

    question: EnsembleQuestion
    along: Parameter
    quantities: tuple[VariedQuantity, ...]
    start: Start
    counted_outcomes: tuple[str, ...]
    confidence: float = 0.95

    def question_at(self, value: float) -> EnsembleQuestion:
        """The question for each run at a value of the parameter. Raises ``InputError`` for a value that is not allowed."""
        return replace(self.question, machine=self.question.machine.with_values({self.along.path: value}))

    def members(self, value: float, samples: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Initial states (n, M) of runs, and the values (M,) of random parameters, at samples (q, M)."""
        return initial_states(self.question_at(value).machine, self.start, self.quantities, samples, "study.random")

    def omissions(self, ends: tuple[float, float], samples: np.ndarray) -> tuple[str, ...]:
        """Warnings about the effects that the averaged equations omit; ends: of the values of the parameter.

        Raises ``InputError`` if there are no such equations, if nothing would turn, and for samples (q, M) that the machine
        does not allow: the least and the largest of each random quantity are checked, and some more.
        """
        extremes = np.unique([f(row) for row in samples for f in (np.argmin, np.argmax)])
        probes = np.unique([*extremes, *np.linspace(0, samples.shape[1] - 1, _PROBES).astype(int)])
        self.members(ends[0], samples[:, probes])
        return omissions_among(self.question_at(ends[-1]), self.start, self.quantities, samples[:, probes], "study.random")

    def point(self, value: float, samples: np.ndarray, work: Work) -> ProbabilityPoint:
        """Run all samples (q, M) at a value of the parameter; where no run has a verdict, with the advice of one of them.

        Where runs are made one by one, and those of the first sample of each replicate have no verdict, no more are made.
        """
        count = samples.shape[1]
        size = count // REPLICATES
        if batching_obstacle(self.question_at(value)) is None or size == 1:
            point = self._counted_point(value, self.outcomes(value, samples, work))
        else:
            first_members = self.outcomes(value, samples[:, ::size], work.part("first", 0.0, 1 / size))
            point = self._counted_point(value, first_members)
            if not point.is_undecided:
                numbers = np.arange(count).reshape(REPLICATES, size)
                first, rest = numbers[:, 0], numbers[:, 1:].ravel()
                rest_members = self.outcomes(value, samples[:, rest], work.part("rest", 1 / size, 1.0))
                point = self._counted_point(value, MemberOutcomes.join_in_order([first_members, rest_members], [first, rest]))
        if not point.is_undecided:
            return point
        advice, needed_time = work.unit("advice", partial(self._advice, value, samples[:, :1]))
        return replace(point, advice=advice, needed_time=needed_time)

    def _counted_point(self, value: float, members: MemberOutcomes) -> ProbabilityPoint:
        return ProbabilityPoint.of(value, members, self.counted_outcomes, self.confidence)

    def outcomes(self, value: float, samples: np.ndarray, work: Work) -> MemberOutcomes:
        """Outcomes of runs with random quantities (q, M) at a value of the parameter."""
        tiles = {f"tile {n}": samples[:, b : b + _TILE] for n, b in enumerate(range(0, samples.shape[1], _TILE))}
        tasks = {name: partial(self._outcomes_of_tile, value, of_tile) for name, of_tile in tiles.items()}
        outcomes = dict(work.units(tasks, f"{self.along.path} = {value:.4g}"))
        return MemberOutcomes.join([outcomes[name] for name in tiles])

    def _outcomes_of_tile(self, value: float, samples: np.ndarray, report: TaskReport) -> MemberOutcomes:
        return outcomes_at(self.question_at(value), self.start, self.quantities, samples, "study.random", report)

    def _advice(self, value: float, sample: np.ndarray) -> tuple[str | None, float | None]:
        starts, values = self.members(value, sample)
        return member_advice(self.question_at(value), starts[:, 0], {name: float(at[0]) for name, at in values.items()})
