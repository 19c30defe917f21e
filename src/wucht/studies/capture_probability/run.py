"""Plan -> findings: the runs at each value of the parameter, those of the search, and those of the sensitivity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.member_outcomes import OUTCOMES, MemberOutcomes
from wucht.dynamics.sampling.placed_members import where_possible
from wucht.dynamics.sampling.smallest_value import Bounds, to_look_at
from wucht.dynamics.verdicts.outcomes import OPEN
from wucht.dynamics.work import Work
from wucht.studies.capture_probability.prepare import Plan
from wucht.studies.capture_probability.probability_bands import band
from wucht.studies.capture_probability.random_points import REPLICATES
from wucht.studies.capture_probability.sobol_indices import Indices, indices

_TILE = 1024  # runs: a unit of work
_SEARCH = 0.4  # the runs of the search, as a share of those before
_OPEN = [OUTCOMES.index(o) for o in OPEN]


@dataclass(frozen=True)
class Point:
    """What became of the runs at a value of the parameter. each: runs of a replicate. counted: outcomes that are inside.
    searched: whether the search asked for it."""

    value: float
    members: MemberOutcomes
    each: int
    counted: tuple[int, ...]
    confidence: float
    searched: bool = False

    @property
    def inside(self) -> np.ndarray:
        """How many runs of each replicate (R,) have an outcome that is counted."""
        return self._runs(self.counted)

    @property
    def open(self) -> np.ndarray:
        """Of how many runs of each replicate (R,) the outcome is not known."""
        return self._runs(_OPEN)

    @property
    def estimate(self) -> float:
        """The share of the runs inside among those whose outcome is known; nan where none is."""
        known = len(self.members.outcome) - int(self.open.sum())
        return float(self.inside.sum()) / known if known else float("nan")

    @cached_property
    def bounds(self) -> Bounds:
        """Between which the probability lies."""
        return Bounds(self.value, *band(self.inside, self.open, self.each, self.confidence))

    def _runs(self, of: Sequence[int]) -> np.ndarray:
        return np.asarray(np.isin(self.members.outcome, of).reshape(REPLICATES, self.each).sum(axis=1))


@dataclass(frozen=True)
class Findings:
    """points: in the order of their values. indices: of the sensitivity, with what became of its runs."""

    points: tuple[Point, ...] = ()
    indices: Indices | None = None
    cross: MemberOutcomes | None = None

    def with_point(self, point: Point) -> Findings:
        """With one more."""
        return replace(self, points=tuple(sorted((*self.points, point), key=lambda p: p.value)))

    @property
    def bounds(self) -> list[Bounds]:
        """Of the probability at each value."""
        return [p.bounds for p in self.points]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The probability after each value, and the sensitivity."""
    found, spec = Findings(), plan.spec
    first, search, last = _shares(plan)
    part = work.part("values", 0.0, first)
    for k, value in enumerate(plan.grid):
        found = found.with_point(_point(plan, value, part.part(f"{k}", k / len(plan.grid), (k + 1) / len(plan.grid))))
        yield found
    begin, number = first, 0
    while spec.probability is not None and (next_ := to_look_at(found.bounds, spec.probability)) is not None:
        end = (begin + search) / 2  # how often is not known before
        point = _point(plan, next_, work.part(f"search/{number}", begin, end))
        found, begin, number = found.with_point(replace(point, searched=True)), end, number + 1
        yield found
    if plan.at is not None and plan.cross is not None:
        members = _members(plan, plan.at, plan.cross, work.part("sensitivity", search, last))
        inside, open_ = (np.isin(members.outcome, of) for of in (_counted(plan), _OPEN))
        of = indices(inside, open_, len(plan.varied), spec.confidence, spec.seed)
        found = replace(found, indices=of, cross=members)
    work.report(1.0)
    yield found


def _shares(plan: Plan) -> tuple[float, float, float]:
    """Which share of the work is done after the values, the search and the sensitivity."""
    values = len(plan.grid) * plan.spec.samples
    search = 0.0 if plan.spec.probability is None else _SEARCH * values
    sizes = np.cumsum([values, search, 0 if plan.cross is None else plan.cross.shape[1]])
    first, second, third = (sizes / sizes[-1]).tolist()
    return first, second, third


def _counted(plan: Plan) -> tuple[int, ...]:
    return tuple(k for k, outcome in enumerate(OUTCOMES) if outcome in plan.spec.outcome)


def _point(plan: Plan, value: float, work: Work) -> Point:
    return Point(value, _members(plan, value, plan.samples, work), plan.each, _counted(plan), plan.spec.confidence)


def _members(plan: Plan, value: float, samples: np.ndarray, work: Work) -> MemberOutcomes:
    """What becomes of runs with random quantities (q, M) at a value of the parameter."""
    tiles = {f"tile {n}": samples[:, b : b + _TILE] for n, b in enumerate(range(0, samples.shape[1], _TILE))}
    tasks = {name: partial(run_samples, plan, value, places) for name, places in tiles.items()}
    found = dict(work.units(tasks, f"{plan.along.path} = {value:.4g}"))
    return MemberOutcomes.joined([found[name] for name in tiles])


def run_samples(plan: Plan, value: float, places: np.ndarray, report: Callable[[float], None]) -> MemberOutcomes:
    """What becomes of runs at a value of the parameter, with the random quantities at places (q, M) of their distributions."""
    question = plan.question(value)

    def run_(starts: np.ndarray, values: Mapping[str, np.ndarray]) -> MemberOutcomes:
        return outcomes_of(question, starts, values, report=report)

    return where_possible(run_, question.machine, *plan.members(value, places))
