"""Runs of a machine with random starts and parameters at values of another parameter: outcomes, and the probability of some."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from wucht.dynamics.run_ups.run_variations import VariedQuantity
from wucht.dynamics.sampling.distributions import replicate_count
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle, is_screened
from wucht.dynamics.sampling.ensemble_run import member_advice, outcomes_at
from wucht.dynamics.sampling.ensembles import (
    EnsembleQuestion,
    MemberOutcomes,
    Start,
    initial_states,
    omissions_among,
    refused_members,
)
from wucht.dynamics.sampling.probability_bands import band
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.dynamics.work import TaskReport, Work
from wucht.schema import Parameter

_PROBES = 64  # samples that are checked before the first run
_TILE = 1024  # runs in a unit of work
_MOST_AT_ONCE = 4  # runs of each replicate between two estimates


@dataclass(frozen=True)
class ProbabilityPoint:
    """Outcomes of the runs at a value of the parameter, and the confidence bounds of the probability of some outcomes.

    inside, open: number of runs of each replicate (R,) with one of these, and with an unknown outcome; those that cannot be run
    are neither. advice, needed_time: where no run has a verdict.
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
        possible = ~members.is_impossible
        runs = members.has_outcome(outcomes), members.has_outcome(OPEN_OUTCOMES) & possible, possible
        replicates = replicate_count(len(members.outcome))
        inside, open_, sizes = (np.asarray(mask.reshape(replicates, -1).sum(axis=1)) for mask in runs)
        return cls(value, *band(inside, open_, sizes, confidence), members, inside, open_)

    @property
    def possible_count(self) -> int:
        """Number of the runs that can be made."""
        return len(self.members.outcome) - int(self.members.is_impossible.sum())

    @property
    def impossible_share(self) -> float:
        """Share of the runs that cannot be made."""
        return 1 - self.possible_count / len(self.members.outcome)

    @property
    def open_share(self) -> float:
        """Share of the possible runs that has no verdict; 1 if there are none."""
        return float(self.open.sum()) / self.possible_count if self.possible_count else 1.0

    @property
    def is_undecided(self) -> bool:
        """True if no run has a verdict: then the probability may be anything."""
        return int(self.open.sum()) == self.possible_count

    @property
    def estimate(self) -> float:
        """Share of the inside runs among those with a known outcome; NaN if there are none."""
        known_count = self.possible_count - int(self.open.sum())
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

        Raises ``InputError`` if there are no such equations, if nothing would turn, and if the machine allows none of the
        samples (q, M): the least and the largest of each random quantity are checked, and some more.
        """
        extremes = np.unique([f(row) for row in samples for f in (np.argmin, np.argmax)])
        probes = samples[:, np.unique([*extremes, *np.linspace(0, samples.shape[1] - 1, _PROBES).astype(int)])]
        for end in ends:
            machine = self.question_at(end).machine
            refusals = refused_members(machine, self.start, self.quantities, probes, "study.random")
            allowed = np.delete(probes, list(refusals), axis=1)
            if not allowed.size:
                self.members(end, probes)
        return omissions_among(self.question_at(ends[-1]), self.start, self.quantities, allowed, "study.random")

    def point(self, value: float, samples: np.ndarray, work: Work) -> ProbabilityPoint:
        """Run all samples (q, M) at a value of the parameter: see ``points``."""
        *_, (point,) = self.points([value], samples, work)
        return point

    def points(self, values: Sequence[float], samples: np.ndarray, work: Work) -> Iterator[tuple[ProbabilityPoint, ...]]:
        """Run all samples (q, M) at each value of the parameter; yield the points so far, in the order of the values.

        Runs that are each followed until their end take long: first the first samples of all replicates are run at all values,
        then the next ones. Where runs are made one by one, and those of the first sample of each replicate have no verdict, no
        more are made. A point without a verdict has the advice of one of its runs.
        """
        replicates = replicate_count(samples.shape[1])
        size, done = samples.shape[1] // replicates, dict[float, ProbabilityPoint]()
        numbers = np.arange(samples.shape[1]).reshape(replicates, size)
        for first, end in pairwise(self._ends_of_batches(values, size)):
            for k, value in enumerate(values):
                one_by_one = batching_obstacle(self.question_at(value)) is not None
                if value in done and done[value].is_undecided and one_by_one:
                    continue
                shares = ((first + (end - first) * (k + more) / len(values)) / size for more in (0, 1))
                part, label = work.part(f"{k}/{first}", *shares), self._label(value, done.get(value))
                members = self.outcomes(value, samples[:, numbers[:, first:end].ravel()], part, label)
                if value in done:
                    orders = [numbers[:, :first].ravel(), numbers[:, first:end].ravel()]
                    members = MemberOutcomes.join_in_order([done[value].members, members], orders)
                point = self._counted_point(value, members)
                if point.is_undecided and (end == size or one_by_one):
                    point = self._advised_point(point, samples[:, numbers[:, :end].ravel()], part)
                done[value] = point
                yield tuple(done.values())

    def _ends_of_batches(self, values: Sequence[float], size: int) -> list[int]:
        """Return how many samples of each replicate, of ``size``, are run after each batch, from 0 on."""
        ends, questions = [0], [self.question_at(value) for value in values]
        if all(is_screened(q.machine) and batching_obstacle(q) is None for q in questions):
            return [0, size]
        while ends[-1] < size:
            ends.append(min(ends[-1] + min(max(ends[-1], 1), _MOST_AT_ONCE), size))
        return ends

    def _label(self, value: float, point: ProbabilityPoint | None) -> str:
        """Return the name of a value for the progress, with the bounds so far."""
        bounds = "" if point is None else f" ({100 * point.low:.3g} to {100 * point.high:.3g} % so far)"
        return f"{self.along.path} = {value:.4g}{bounds}"

    def _advised_point(self, point: ProbabilityPoint, samples: np.ndarray, work: Work) -> ProbabilityPoint:
        """Return a point without a verdict with the advice of the first of its runs, at samples (q, M), that can be made."""
        possible = np.flatnonzero(~point.members.is_impossible)
        if not len(possible):
            return replace(point, advice=point.members.failures[0][1])
        advice, needed_time = work.unit("advice", partial(self._advice, point.value, samples[:, possible[:1]]))
        return replace(point, advice=advice, needed_time=needed_time)

    def _counted_point(self, value: float, members: MemberOutcomes) -> ProbabilityPoint:
        return ProbabilityPoint.of(value, members, self.counted_outcomes, self.confidence)

    def outcomes(self, value: float, samples: np.ndarray, work: Work, label: str | None = None) -> MemberOutcomes:
        """Outcomes of runs with random quantities (q, M) at a value of the parameter. label: for the progress."""
        tiles = {f"tile {n}": samples[:, b : b + _TILE] for n, b in enumerate(range(0, samples.shape[1], _TILE))}
        tasks = {name: partial(self._outcomes_of_tile, value, of_tile) for name, of_tile in tiles.items()}
        outcomes = dict(work.units(tasks, label or self._label(value, None)))
        return MemberOutcomes.join([outcomes[name] for name in tiles])

    def _outcomes_of_tile(self, value: float, samples: np.ndarray, report: TaskReport) -> MemberOutcomes:
        return outcomes_at(self.question_at(value), self.start, self.quantities, samples, "study.random", report)

    def _advice(self, value: float, sample: np.ndarray) -> tuple[str | None, float | None]:
        starts, values = self.members(value, sample)
        return member_advice(self.question_at(value), starts[:, 0], {name: float(at[0]) for name, at in values.items()})
