"""Attractors of equations by where runs from many starts end, and which start leads to which.

A few runs are followed until it is known what they tend to. All members then run together, until each has come near to one of
these sets and moves as it does: within its reach at all samples of a chunk of time; on a chaotic set or a torus, which are
known by samples only, in ten chunks in succession; or until it rests at an equilibrium, of which there may be any number. A
member that does neither is followed alone; what it tends to is added to the sets, and the others go on. One that fails, or ends
on a motion without a basin, has its reason and decides nothing about the others.

G. Datseris, A. Wagemakers, "Effortless estimation of basins of attraction", Chaos 32 (2022) 023104.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.limit_sets.conservation import CONSERVATIVE, preserves_volume
from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, StateMetric, whole_periods
from wucht.dynamics.limit_sets.long_run import long_run
from wucht.dynamics.limit_sets.resting_states import RestPoints, equilibrium_near, rests, state_extents
from wucht.errors import WuchtError
from wucht.machines.subject import Subject
from wucht.numerics.ensembles.ensemble import compile_ensemble, run_ensemble
from wucht.numerics.ensembles.members import Chunk, Members, Pace, Status
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE

NOT_SETTLED, DIVERGES, FAILED, NEUTRAL = -1, -2, -3, -4  # members that tend to no known set
_RESTS = -5  # a member at rest, before its equilibrium is known
_SURVEY = 6  # starts that are followed alone first
_SAMPLES = 64  # in a chunk
_PERIODS, _BLOCKS = 1.5, 40  # in a chunk: of an orbit; chunks in the time over which the exponent of a chaotic set is a mean
_EXPONENT_ACCURACY = 0.1  # relative
_PATIENCE = 10  # chunks in succession in which a member is near to a set that is known by samples only
_CHUNKS = 40  # of a pass, at least
_TIMES_OF_SURVEY = 2.0
_MOST_ALONE, _MOST_UNSETTLED = 40, 3  # members followed alone after the survey, and of all those of them without a result
_SAME_REST = 1e-4  # of the states' sizes: members at rest that are nearer rest at the same equilibrium
_LEADS = 0.5  # times the distance from an equilibrium: a step of Newton's method from near it ends nearer
_BEYOND = 1e6  # times the largest start, at least 1: a member that comes so far diverges
_LEFT = "it came near to no known set, and of the starts that were followed alone too many had no result"
_FAMILY = "it ends on one of a family of motions, which neither attract nor repel their neighbours"

Report = Callable[[float], None]  # the share that is done


@dataclass(frozen=True, eq=False)
class StartOutcomes:
    """Where runs from M starts end.

    Attributes
    ----------
    outcome : ndarray of int, (M,)
        The number of the attractor in ``attractors``, or NOT_SETTLED, DIVERGES, FAILED, NEUTRAL.
    attractors : tuple of LimitSet
        Also unstable equilibria at which a motion ends.
    failures : tuple of (int, str)
        The reasons of members NOT_SETTLED, FAILED or NEUTRAL, by their numbers.
    """

    outcome: np.ndarray
    attractors: tuple[LimitSet, ...]
    failures: tuple[tuple[int, str], ...] = ()


def start_outcomes(
    subject: Subject,
    starts: np.ndarray,
    until: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    report: Report | None = None,
    known_sets: tuple[LimitSet, ...] = (),
) -> StartOutcomes:
    """Return where the runs from starts (n, M) end.

    until, tolerance: see ``long_run``. known_sets: attractors of these equations, which keep their numbers.

    Raises ``WuchtError`` where the equations preserve volume, or all runs that are followed first end on families of motions.
    """
    if preserves_volume(subject):
        raise WuchtError(CONSERVATIVE, code="conservative")
    search = _Search(subject, starts, until, tolerance, report or (lambda _: None), known_sets)
    search.survey()
    while len(search.open_members):
        search.advance()
        search.follow_alone()
    return StartOutcomes(search.labels, tuple(search.sets), tuple(sorted(search.reasons.items())))


class _Search:
    """The members in progress: their present states (n, M), labels (M,), and those without a label."""

    def __init__(
        self,
        subject: Subject,
        starts: np.ndarray,
        until: float | None,
        tolerance: float,
        report: Report,
        known_sets: tuple[LimitSet, ...],
    ) -> None:
        self.subject, self.starts, self.states, self.report = subject, starts, starts.copy(), report
        self.until, self.tolerance = until, tolerance
        self.labels = np.full(starts.shape[1], NOT_SETTLED)
        self.open_members = np.arange(starts.shape[1])
        self.rest_points = None if subject.system.depends_on_time else RestPoints.of(subject, tolerance)
        self.sets, self.reasons, self.span, self.alone, self.unsettled = list(known_sets), dict[int, str](), 0.0, 0, 0

    def survey(self) -> None:
        """Follow a few starts alone. Raises ``WuchtError`` where all of them end on families of motions."""
        members = np.unique(np.linspace(0, self.starts.shape[1] - 1, _SURVEY).astype(int))
        for member in members.tolist():
            self._follow(member)
        if (self.labels[members] == NEUTRAL).all():
            raise WuchtError(
                f"the run from the start {self.starts[:, members[0]].tolist()} ends on a motion that neither attracts nor "
                "repels its neighbours, as of conservative equations, and so do those from all starts that were tried: there "
                "are no basins",
                code="neutral",
            )

    def follow_alone(self) -> None:
        """Follow members without a label alone, one after another, until one of them settles on a set with a basin."""
        has_settled = False
        while len(self.open_members) and not has_settled:
            if self.alone >= _MOST_ALONE or self.unsettled > _MOST_UNSETTLED:
                self.labels[self.open_members] = NOT_SETTLED
                self.reasons |= dict.fromkeys(self.open_members.tolist(), _LEFT)
                self.open_members = self.open_members[:0]
                return
            self.alone += 1
            has_settled = self._follow(int(self.open_members[0]))

    def _follow(self, member: int) -> bool:
        """Follow a member alone. Returns true if it settles on a set with a basin."""
        self.open_members = self.open_members[self.open_members != member]
        try:
            run = long_run(
                self.subject,
                self.states[:, member],
                until=self.until,
                tolerance=self.tolerance,
                exponent_accuracy=_EXPONENT_ACCURACY,
                report=lambda _time: self._tell(),
            )
        except WuchtError as error:
            self.labels[member], self.reasons[member] = FAILED, str(error)
            return False
        if run.limit_set is None:
            self.unsettled += run.kind is MotionKind.NOT_SETTLED
            self.labels[member] = {MotionKind.DIVERGES: DIVERGES, MotionKind.NOT_SETTLED: NOT_SETTLED}.get(run.kind, FAILED)
            if run.kind is not MotionKind.DIVERGES:
                self.reasons[member] = run.failure or f"{run.kind.sentence}, after {run.end_time:.4g}"
            return False
        self.span = max(self.span, _TIMES_OF_SURVEY * run.end_time)
        self._label_with(np.array([member]), run.limit_set)
        return run.limit_set.has_basin

    def _label_with(self, members: np.ndarray, limit_set: LimitSet) -> None:
        """Label members by what they tend to, a new set or a known one."""
        if limit_set.attracts is None and not limit_set.has_basin:
            self.labels[members] = NEUTRAL
            self.reasons |= dict.fromkeys(members.tolist(), _FAMILY)
            return
        number = next((k for k, candidate in enumerate(self.sets) if candidate.is_same(limit_set)), len(self.sets))
        if number == len(self.sets):
            self.sets.append(limit_set)
        self.labels[members] = number

    def _tell(self) -> None:
        self.report(1 - len(self.open_members) / max(len(self.labels), 1))

    def advance(self) -> None:
        """Run all members without a label together, until each is near to a known set or at rest, or the time is over."""
        ensemble = compile_ensemble(self.subject.system, self.tolerance)
        chunk, values = self._chunk(), self.subject.system.values(self.subject.values)
        pace = Pace(chunk, _SAMPLES, chunk * max(_CHUNKS, math.ceil(self.span / chunk)))
        members = Members.of(self.states[:, self.open_members].T, values)
        farthest = _BEYOND * max(1.0, float(np.abs(self.starts).max(initial=0.0)))
        turning = np.array([s in ensemble.system.angles for s in ensemble.system.states])
        observer = _SetObserver(tuple(self.sets), farthest, turning, chunk, self.rest_points)
        result = run_ensemble(ensemble, members, observer, pace, report=lambda _share: self._tell())
        ids, self.states[:, self.open_members] = self.open_members, result.states.T
        self.labels[ids] = result.record.label
        self.open_members = ids[result.status == Status.LIMIT]
        for k in np.flatnonzero(result.status == Status.FAILED).tolist():
            run = long_run(self.subject, result.states[k], until=2 * chunk, tolerance=self.tolerance)
            self.labels[ids[k]] = DIVERGES if run.kind is MotionKind.DIVERGES else FAILED
            if run.kind is not MotionKind.DIVERGES:
                self.reasons[int(ids[k])] = result.sentences[k]
        at_rest = np.flatnonzero(self.labels[ids] == _RESTS)
        self._label_resting(ids[at_rest], result.record.ranges[:, at_rest])

    def _label_resting(self, members: np.ndarray, ranges: np.ndarray) -> None:
        """Label members at rest by their equilibria, those at one of them together. ranges (n, R): of their states."""
        turning = np.array([s in self.subject.system.angles for s in self.subject.system.states])
        while len(members) and self.rest_points is not None:
            first, tolerance = self.states[:, members[0]], self.tolerance
            metric = StateMetric.of(self.subject, state_extents(ranges[:, 0], first, turning, tolerance))
            equilibrium = equilibrium_near(self.subject, first, metric.sizes, tolerance)
            if equilibrium is None:  # Newton's method leads elsewhere: it is followed alone
                self.open_members = np.union1d(self.open_members, members[:1])
                members, ranges = members[1:], ranges[:, 1:]
                continue
            limit_set = LimitSet.at(equilibrium, np.zeros(1), metric)
            ends = self.rest_points.newton_points(self.states[:, members])
            together = limit_set.distances(np.zeros(len(members)), ends) <= _SAME_REST
            together[0] = True
            self._label_with(members[together], limit_set)
            members, ranges = members[~together], ranges[:, ~together]

    def _chunk(self) -> float:
        """Return the length of a chunk: some oscillations of each set, a multiple of the period of the forcing."""
        lengths = [_PERIODS * s.period for s in self.sets]
        lengths += [s.exponent.duration / _BLOCKS for s in self.sets if s.exponent is not None]
        return whole_periods(self.subject, max([*lengths, self.span / 200]) or 1.0)


@dataclass(frozen=True)
class _Nearness:
    """Record of L members.

    label: the set near to which each is, or NOT_SETTLED, DIVERGES, _RESTS. streak: in how many chunks in succession. rest: how
    long it has rested. low, high (n, L): of its states.
    """

    label: np.ndarray
    streak: np.ndarray
    rest: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def ranges(self) -> np.ndarray:
        """Ranges (n, L) of the states."""
        return np.asarray(self.high - self.low)


@dataclass(frozen=True)
class _SetObserver:
    """Observer of members that come near to known sets, or to rest. rest_points: None where that is not observed."""

    sets: tuple[LimitSet, ...]
    farthest: float
    turning: np.ndarray
    chunk: float
    rest_points: RestPoints | None

    def begin(self, members: Members) -> _Nearness:
        """See ``Observer``."""
        count, starts = len(members), members.starts.T
        return _Nearness(np.full(count, NOT_SETTLED), np.zeros(count, int), np.zeros(count), starts, starts)

    def update(self, record: _Nearness, chunk: Chunk) -> tuple[_Nearness, np.ndarray]:
        """See ``Observer``."""
        states = np.moveaxis(chunk.samples, 1, 0)
        least, largest = states.min(axis=1), states.max(axis=1)
        low, high = np.minimum(record.low, least), np.maximum(record.high, largest)
        nearest = self._nearest_sets(chunk.times, states)
        streak = np.where((nearest == record.label) & (nearest >= 0), record.streak + 1, (nearest >= 0).astype(int))
        settles = np.zeros(len(nearest), bool)
        for number, limit_set in enumerate(self.sets):
            settles |= (nearest == number) & (streak >= (_PATIENCE if limit_set.exponent is not None else 1))
        rest, is_over = self._rest(record.rest, states[:, -1], largest - least, high - low)
        is_over &= ~settles
        far = (np.abs(chunk.samples[-1][~self.turning]) > self.farthest).any(axis=0)
        label = np.where(far, DIVERGES, np.where(is_over, _RESTS, nearest))
        return _Nearness(label, streak, rest, low, high), settles | is_over | far

    def _nearest_sets(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the set (L,) on which each member, with states (n, K, L), is; NOT_SETTLED without one."""
        nearest = np.full(states.shape[-1], NOT_SETTLED)
        for number, limit_set in sorted(enumerate(self.sets), key=lambda pair: pair[1].exponent is not None):
            if not limit_set.has_basin:
                continue
            candidates = np.flatnonzero(nearest == NOT_SETTLED)
            last = limit_set.distances(times[-1:], states[:, -1, candidates]) <= limit_set.reach
            candidates = candidates[last]
            if len(candidates):
                candidates = candidates[limit_set.holds(times, states[:, :, candidates])]
                nearest[candidates[self._leads_to(limit_set, states[:, -1, candidates])]] = number
        return nearest

    def _leads_to(self, limit_set: LimitSet, ends: np.ndarray) -> np.ndarray:
        """True (L,) for states (n, L) near a set that are not near another equilibrium, as far as the equations tell."""
        if self.rest_points is None or not limit_set.has_eigenvalues or not ends.shape[1]:
            return np.ones(ends.shape[1], bool)
        times = np.zeros(ends.shape[1])
        now, after = (
            limit_set.distances(times, x) for x in (ends, np.nan_to_num(self.rest_points.newton_points(ends), nan=np.inf))
        )
        return np.asarray(after <= np.maximum(_LEADS * now, _SAME_REST))

    def _rest(
        self, rest: np.ndarray, ends: np.ndarray, changes: np.ndarray, ranges: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return how long members (L,) have rested, and which of them have for so long that they end at their equilibrium."""
        if self.rest_points is None:
            return rest, np.zeros(len(rest), bool)
        tolerance = self.rest_points.tolerance
        is_at_rest = rests(changes, ranges, ends, self.turning, tolerance)
        rest, is_over = np.where(is_at_rest, rest + self.chunk, 0.0), is_at_rest.copy()
        if is_at_rest.any():
            extents = state_extents(ranges, ends, self.turning, tolerance)[:, is_at_rest]
            sizes = np.where(extents > 0, extents, np.maximum(extents.max(axis=0), np.finfo(float).tiny))
            needed = self.rest_points.times_of_rest(ends[:, is_at_rest], sizes)
            is_over[is_at_rest] = rest[is_at_rest] >= needed
        return rest, is_over

    def final_record(self, record: _Nearness) -> _Nearness:
        """See ``Observer``."""
        return record
