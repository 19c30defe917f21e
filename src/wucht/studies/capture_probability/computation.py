"""Question and machine -> plan -> findings: the random quantities, their samples, the runs at each value of the parameter.

Confidence of a probability that was counted on scrambled Sobol' points: points of one scrambled sequence are not independent,
but its replicates are, and the share of each is unbiased (A. B. Owen, "Error estimation for quasi-Monte Carlo", 2025,
arXiv:2501.00150). The scatter of their counts gives the variance of the mean, and thus an equivalent number of
independent points, mostly far more than were drawn. With this number the interval of C. J. Clopper and E. S. Pearson (1934) is
used, which holds also near 0 and 1, as E. L. Korn and B. I. Graubard do for counts in clusters (Survey Methodology 24
(1998) 193-201), Student's t in place of the normal quantile; and the plain interval of Student's t, which holds well according
to P. L'Ecuyer, M. K. Nakayama, A. B. Owen and B. Tuffin ("Confidence intervals for randomized quasi-Monte Carlo estimators",
Winter Simulation Conference 2023). The band covers both.

Counts are whole numbers. If all replicates have the same count, other counts are not excluded: after R equal ones a share of
at most 1 - (a/2)^(1/R) can differ, which gives the least variance of a count, but no more than independent points have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import VariedQuantity, check_given_once, varied_quantity
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle
from wucht.dynamics.sampling.ensemble_run import RunAdvice, integration_note, member_advice, outcomes_of
from wucht.dynamics.sampling.ensembles import (
    EnsembleQuestion,
    MemberOutcomes,
    initial_states,
    omission_warnings,
    run_possible,
    unrunnable_members,
)
from wucht.dynamics.sampling.searches import ProbabilityBounds, next_sample_value
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, OUTCOMES
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.schema import Parameter
from wucht.studies.capture_probability.distributions import (
    REPLICATES,
    Distribution,
    Indices,
    cross_samples,
    distribution_of,
    indices,
    library,
    points,
)
from wucht.studies.capture_probability.spec import CaptureProbability

_PROBES = 64  # samples that are checked before the first run
_RANDOM = "study.random"


def interval(counts: np.ndarray, replicate_size: int, confidence: float) -> tuple[float, float]:
    """Two-sided bounds of a probability, from the number of inside points of each replicate (R,) of ``replicate_size``."""
    from scipy.stats import norm, t

    replicates, tail = len(counts), (1 - confidence) / 2
    share, total = float(counts.mean()) / replicate_size, replicates * replicate_size
    if (
        counts.min() == replicate_size or counts.max() == 0
    ):  # independent points scatter at least as much: these bounds are wide enough
        return clopper_pearson(share * total, total, tail)
    otherwise = min(1 - tail ** (1 / replicates), 0.5)
    least = min(otherwise * (1 - otherwise), replicate_size * share * (1 - share))
    variance = max(float(counts.var(ddof=1)), least) / replicates / replicate_size**2
    student = float(t.ppf(1 - tail, replicates - 1))
    independent = share * (1 - share) / variance * (float(norm.ppf(1 - tail)) / student) ** 2
    low, high = clopper_pearson(share * independent, independent, tail)
    reach = student * variance**0.5
    return max(min(low, share - reach), 0.0), min(max(high, share + reach), 1.0)


def clopper_pearson(inside: float, total: float, tail: float) -> tuple[float, float]:
    """Bounds beyond which the counted number, or a more extreme one, would be less likely than ``tail``."""
    from scipy.stats import beta

    low = float(beta.ppf(tail, inside, total - inside + 1)) if inside > 0 else 0.0
    high = float(beta.ppf(1 - tail, inside + 1, total - inside)) if inside < total else 1.0
    return low, high


def band(inside: np.ndarray, open_: np.ndarray, replicate_size: int, confidence: float) -> tuple[float, float]:
    """Bounds if some points of each replicate (R,) are inside and others are undecided: these may count or not."""
    return interval(inside, replicate_size, confidence)[0], interval(inside + open_, replicate_size, confidence)[1]


@dataclass(frozen=True)
class Plan:
    """Plan of a probability. along: the parameter. grid: its first values. random_quantities, distributions: (q).

    samples: of the random quantities (q, M), one replicate after the other. at: the value for the sensitivity, whose samples
    are cross (q, K). way: method of integration, in words.
    """

    spec: CaptureProbability
    machine: Machine
    along: Parameter
    grid: tuple[float, ...]
    random_quantities: tuple[VariedQuantity, ...]
    distributions: tuple[Distribution, ...]
    samples: np.ndarray
    at: float | None = None
    cross: np.ndarray | None = None
    way: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def replicate_size(self) -> int:
        """Number of samples in a replicate."""
        return self.spec.samples // REPLICATES

    def question(self, value: float) -> EnsembleQuestion:
        """The question for each run at a value of the parameter. Raises ``InputError`` for a value that is not allowed."""
        machine, spec = self.machine.with_values({self.along.path: value}), self.spec
        names = tuple(v.name for v in self.random_quantities if v.state is None)
        return EnsembleQuestion(machine, names, spec.model, spec.inertia, spec.order, spec.until, tolerance=spec.tolerance)

    def members(self, value: float, places: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Initial states (n, M) of runs, and the values (M,) of random parameters, at places (q, M)."""
        machine = self.machine.with_values({self.along.path: value})
        return initial_states(machine, self.spec.start, self.random_quantities, places, _RANDOM)


def prepare(spec: CaptureProbability, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    along = parameter_of(machine, spec.along)
    low, high = checked_range(machine, along, spec.range)
    random_quantities = tuple(varied_quantity(machine, name, f"random.{name}") for name in spec.random)
    distributions = tuple(
        distribution_of(definition, v.quantity, f"{_RANDOM}.{v.name}")
        for v, definition in zip(random_quantities, spec.random.values(), strict=True)
    )
    initial_state(machine, spec.start)
    check_given_once(random_quantities, spec.start, "random", "another random quantity")
    unit_cube = points(spec.samples, len(random_quantities), spec.seed)
    samples = _sample_values(distributions, unit_cube.reshape(-1, len(random_quantities)))
    plan = Plan(
        spec, machine, along, tuple(np.linspace(low, high, spec.points).tolist()), random_quantities, distributions, samples
    )
    if spec.sensitivity and spec.at is not None:
        library()
        (at,) = values_of(machine, along, (spec.at,), "at")
        plan = replace(
            plan, at=at, cross=_sample_values(distributions, cross_samples(spec.base, len(random_quantities), spec.seed))
        )
    warnings = _omission_warnings(plan)
    return replace(plan, way=integration_note(plan.question(low)), warnings=(*warnings, *_evenness_warnings(spec)))


def _sample_values(distributions: Sequence[Distribution], shares: np.ndarray) -> np.ndarray:
    """Values (q, M) of random quantities at points (M, q) of the unit cube."""
    tiny = np.finfo(float).tiny
    inside = np.clip(shares, tiny, 1 - np.finfo(float).epsneg)  # at 0 and 1 the values of a normal distribution are infinite
    return np.array([one.quantiles(inside[:, k]) for k, one in enumerate(distributions)])


def _omission_warnings(plan: Plan) -> tuple[str, ...]:
    """Warnings about the effects that the averaged equations omit.

    Raises ``InputError`` if there are no such equations, if nothing would turn, and for samples that the machine does not
    allow: the least and the largest of each random quantity are checked, and some more.
    """
    sample_sets = [plan.samples] if plan.cross is None else [plan.samples, plan.cross]
    for samples in sample_sets:
        for v, values in zip(plan.random_quantities, samples, strict=True):
            if v.state is None:
                _refuse_forbidden_values(plan, v.name, values)
    ends = np.unique([f(row) for row in plan.samples for f in (np.argmin, np.argmax)])
    probes = np.unique([*ends, *np.linspace(0, plan.spec.samples - 1, _PROBES).astype(int)])
    for value in (plan.grid[0], plan.grid[-1]):
        members = plan.members(value, plan.samples[:, probes])
        impossible_members = unrunnable_members(plan.question(value).machine, *members)
    possible = next((p for m, p in enumerate(probes) if m not in impossible_members), probes[0])
    return omission_warnings(
        plan.question(plan.grid[-1]), plan.spec.start, plan.random_quantities, plan.samples[:, possible].tolist()
    )


def _refuse_forbidden_values(plan: Plan, name: str, values: np.ndarray) -> None:
    for value in (float(values.min()), float(values.max())):
        try:
            plan.machine.with_values({name: value})
        except InputError as error:
            problem = f"this distribution reaches {value:.6g}, which the machine does not allow ({error.explanation})"
            requirement = f"{problem}; limit it, as by between = [low, high]"
            raise InputError(f"{_RANDOM}.{name}", plan.spec.random[name], requirement) from None


def _evenness_warnings(spec: CaptureProbability) -> list[str]:
    if spec.samples & (spec.samples - 1) == 0:
        return []
    fewer = 2 ** int(np.log2(spec.samples))
    return [f"samples = {spec.samples} is not a power of two: Sobol' points fill the space evenly with {fewer} or {2 * fewer}"]


_TILE = 1024  # runs in a unit of work
_SEARCH = 0.4  # runs of the search, as a share of the preceding ones
_OPEN = [OUTCOMES.index(o) for o in OPEN_OUTCOMES]


@dataclass(frozen=True)
class ProbabilityPoint:
    """Outcomes of the runs at a value of the parameter. replicate_size: runs of a replicate. counted_outcomes: outcomes that
    count as inside. is_from_search: true if the search requested the value. advice: where no run has a verdict."""

    value: float
    members: MemberOutcomes
    replicate_size: int
    counted_outcomes: tuple[int, ...]
    confidence: float
    is_from_search: bool = False
    advice: RunAdvice | None = None

    @property
    def inside(self) -> np.ndarray:
        """Number of runs of each replicate (R,) with a counted outcome."""
        return self._runs(self.counted_outcomes)

    @property
    def open(self) -> np.ndarray:
        """Number of runs of each replicate (R,) with an unknown outcome."""
        return self._runs(_OPEN)

    @property
    def estimate(self) -> float:
        """Share of the inside runs among those with a known outcome; NaN if there are none."""
        known_count = len(self.members.outcome) - int(self.open.sum())
        return float(self.inside.sum()) / known_count if known_count else float("nan")

    @property
    def is_undecided(self) -> bool:
        """True if no run has a verdict: then the probability may be anything."""
        return int(self.open.sum()) == len(self.members.outcome)

    @cached_property
    def bounds(self) -> ProbabilityBounds:
        """Bounds of the probability."""
        return ProbabilityBounds(self.value, *band(self.inside, self.open, self.replicate_size, self.confidence))

    def _runs(self, of: Sequence[int]) -> np.ndarray:
        return np.asarray(np.isin(self.members.outcome, of).reshape(REPLICATES, self.replicate_size).sum(axis=1))


@dataclass(frozen=True)
class Findings:
    """Findings so far. points: in the order of their values. indices: of the sensitivity. cross: outcomes of its runs."""

    points: tuple[ProbabilityPoint, ...] = ()
    indices: Indices | None = None
    cross: MemberOutcomes | None = None

    def with_point(self, point: ProbabilityPoint) -> Findings:
        """Findings with another point."""
        return replace(self, points=tuple(sorted((*self.points, point), key=lambda p: p.value)))

    @property
    def is_undecided(self) -> bool:
        """True if there is no value at which a run has a verdict."""
        return all(p.is_undecided for p in self.points)

    @property
    def bounds(self) -> list[ProbabilityBounds]:
        """Bounds of the probability at each value."""
        return [p.bounds for p in self.points]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compute the probability at each value, and the sensitivity; yield the findings after each."""
    findings, spec = Findings(), plan.spec
    first, search, last = _shares(plan)
    part = work.part("values", 0.0, first)
    for k, value in enumerate(plan.grid):
        here = part.part(f"{k}", k / len(plan.grid), (k + 1) / len(plan.grid))
        findings = findings.with_point(_compute_point(plan, value, here))
        yield findings
    begin, number = first, 0
    while spec.probability is not None and (next_ := next_sample_value(findings.bounds, spec.probability)) is not None:
        end = (begin + search) / 2  # the number of steps is not known in advance
        point = _compute_point(plan, next_, work.part(f"search/{number}", begin, end).open_ended)
        findings, begin, number = findings.with_point(replace(point, is_from_search=True)), end, number + 1
        yield findings
    if plan.at is not None and plan.cross is not None and not findings.is_undecided:
        members = _compute_members(plan, plan.at, plan.cross, work.part("sensitivity", search, last))
        inside, open_ = (np.isin(members.outcome, of) for of in (_counted_outcomes(plan), _OPEN))
        of = indices(inside, open_, len(plan.random_quantities), spec.confidence, spec.seed)
        findings = replace(findings, indices=of, cross=members)
    work.report(1.0)
    yield findings


def _shares(plan: Plan) -> tuple[float, float, float]:
    """Completed share of the work after the values, the search and the sensitivity."""
    values = len(plan.grid) * plan.spec.samples
    search = 0.0 if plan.spec.probability is None else _SEARCH * values
    sizes = np.cumsum([values, search, 0 if plan.cross is None else plan.cross.shape[1]])
    first, second, third = (sizes / sizes[-1]).tolist()
    return first, second, third


def _counted_outcomes(plan: Plan) -> tuple[int, ...]:
    return tuple(k for k, outcome in enumerate(OUTCOMES) if outcome in plan.spec.outcome)


def _compute_point(plan: Plan, value: float, work: Work) -> ProbabilityPoint:
    """Compute the outcomes of the runs at a value; where no run has a verdict, with the advice of one of them.

    Where runs are made one by one, and those of the first sample of each replicate have no verdict, no more are made.
    """
    size = plan.replicate_size
    point_of = partial(ProbabilityPoint, value, counted_outcomes=_counted_outcomes(plan), confidence=plan.spec.confidence)
    if batching_obstacle(plan.question(value)) is None or size == 1:
        point = point_of(_compute_members(plan, value, plan.samples, work), size)
    else:
        first_members = _compute_members(plan, value, plan.samples[:, ::size], work.part("first", 0.0, 1 / size))
        point = point_of(first_members, 1)
        if not point.is_undecided:
            order = np.arange(plan.spec.samples).reshape(REPLICATES, size)
            rest = order[:, 1:].ravel()
            rest_members = _compute_members(plan, value, plan.samples[:, rest], work.part("rest", 1 / size, 1.0))
            places = np.argsort(np.concatenate([order[:, 0], rest]))
            point = point_of(MemberOutcomes.join([first_members, rest_members]).select(places), size)
    return replace(point, advice=work.unit("advice", partial(_advice, plan, value))) if point.is_undecided else point


def _advice(plan: Plan, value: float) -> RunAdvice:
    """Return the advice of the verdict on the first sample."""
    starts, values = plan.members(value, plan.samples[:, :1])
    return member_advice(plan.question(value), starts[:, 0], {name: float(at[0]) for name, at in values.items()})


def _compute_members(plan: Plan, value: float, samples: np.ndarray, work: Work) -> MemberOutcomes:
    """Compute the outcomes of runs with random quantities (q, M) at a value of the parameter."""
    tiles = {f"tile {n}": samples[:, b : b + _TILE] for n, b in enumerate(range(0, samples.shape[1], _TILE))}
    tasks = {name: partial(run_samples, plan, value, places) for name, places in tiles.items()}
    outcomes = dict(work.units(tasks, f"{plan.along.path} = {value:.4g}"))
    return MemberOutcomes.join([outcomes[name] for name in tiles])


def run_samples(plan: Plan, value: float, places: np.ndarray, report: Callable[[float], None]) -> MemberOutcomes:
    """Compute the outcomes of runs at a value of the parameter, with the random quantities at places (q, M)."""
    question = plan.question(value)

    def run_(starts: np.ndarray, values: Mapping[str, np.ndarray]) -> MemberOutcomes:
        return outcomes_of(question, starts, values, report=report)

    return run_possible(run_, question.machine, *plan.members(value, places))
