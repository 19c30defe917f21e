"""Attractors of equations by where runs from many starts end, and which start leads to which.

A few runs are followed until it is known what they tend to. All members then run together, until each has come near to one of
these sets and moves as it does: within its reach at all samples of a chunk of time; on a chaotic set or a torus, which are
known by samples only, in ten chunks in succession. A member that comes near to none is followed alone; what it tends to is
added to the sets, and the others go on.

G. Datseris, A. Wagemakers, "Effortless estimation of basins of attraction", Chaos 32 (2022) 023104.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.limit_sets.conservation import CONSERVATIVE, preserves_volume
from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, whole_periods
from wucht.dynamics.limit_sets.long_run import LongRunSettings, long_run
from wucht.errors import WuchtError
from wucht.files.user_system import UserSystem
from wucht.numerics.ensembles.ensemble import compile_ensemble, run_ensemble
from wucht.numerics.ensembles.members import Chunk, Members, Pace, Status

NOT_SETTLED, DIVERGES, FAILED = -1, -2, -3  # members that tend to no known set
_SURVEY = 6  # starts that are followed alone first
_SAMPLES = 64  # in a chunk
_PERIODS, _BLOCKS = 1.5, 40  # in a chunk: of an orbit; chunks in the time over which the exponent of a chaotic set is a mean
_PATIENCE = 10  # chunks in succession in which a member is near to a set that is known by samples only
_CHUNKS = 40  # of a pass, at least
_TIMES_OF_SURVEY = 2.0
_MOST_PASSES, _MOST_UNSETTLED = 40, 3
_BEYOND = 1e6  # times the largest start, at least 1: a member that comes so far diverges

Report = Callable[[float], None]  # the share that is done


@dataclass(frozen=True, eq=False)
class StartOutcomes:
    """Where runs from M starts end.

    Attributes
    ----------
    labels : ndarray of int, (M,)
        The number of the attractor in ``attractors``, or NOT_SETTLED, DIVERGES, FAILED.
    attractors : tuple of LimitSet
        Also unstable equilibria on which a start lies.
    """

    labels: np.ndarray
    attractors: tuple[LimitSet, ...]


def start_outcomes(
    subject: UserSystem,
    starts: np.ndarray,
    settings: LongRunSettings,
    report: Report | None = None,
    known_sets: tuple[LimitSet, ...] = (),
) -> StartOutcomes:
    """Return where the runs from starts (n, M) end. known_sets: attractors of these equations, which keep their numbers.

    Raises ``WuchtError`` where the equations preserve volume, or a run ends on one of a family of motions.
    """
    if preserves_volume(subject):
        raise WuchtError(CONSERVATIVE, code="conservative")
    search = _Search(subject, starts, settings, report or (lambda _: None), known_sets)
    search.survey()
    for _ in range(_MOST_PASSES):
        if not len(search.open_members):
            break
        search.advance()
        if len(search.open_members) and not search.follow_one():
            break
    return StartOutcomes(search.labels, tuple(search.sets))


class _Search:
    """The members in progress: their present states (n, M), labels (M,), and those without a label."""

    def __init__(
        self,
        subject: UserSystem,
        starts: np.ndarray,
        settings: LongRunSettings,
        report: Report,
        known_sets: tuple[LimitSet, ...],
    ) -> None:
        self.subject, self.starts, self.states, self.settings, self.report = subject, starts, starts.copy(), settings, report
        self.labels = np.full(starts.shape[1], NOT_SETTLED)
        self.open_members = np.arange(starts.shape[1])
        self.sets, self.span, self.unsettled = list(known_sets), 0.0, 0

    def survey(self) -> None:
        """Follow a few starts alone."""
        for member in np.unique(np.linspace(0, self.starts.shape[1] - 1, _SURVEY).astype(int)).tolist():
            self._follow(member)

    def follow_one(self) -> bool:
        """Follow the first member without a label alone. Returns false where too many could not be settled."""
        self._follow(int(self.open_members[0]))
        return self.unsettled <= _MOST_UNSETTLED

    def _follow(self, member: int) -> None:
        run = long_run(self.subject, self.states[:, member], self.settings, lambda _time: self._tell())
        self.span = max(self.span, _TIMES_OF_SURVEY * run.end_time)
        self.open_members = self.open_members[self.open_members != member]
        if run.limit_set is None:
            self.unsettled += run.kind is MotionKind.NOT_SETTLED
            self.labels[member] = {MotionKind.DIVERGES: DIVERGES, MotionKind.FAILED: FAILED}.get(run.kind, NOT_SETTLED)
            return
        if run.limit_set.attracts is None:
            raise WuchtError(
                f"the run from the start {self.starts[:, member].tolist()} ends on a motion that neither attracts nor repels "
                "its neighbours, as of conservative equations: there is no basin of it",
                code="neutral",
            )
        number = next((k for k, candidate in enumerate(self.sets) if candidate.is_same(run.limit_set)), len(self.sets))
        if number == len(self.sets):
            self.sets.append(run.limit_set)
        self.labels[member] = number

    def _tell(self) -> None:
        self.report(1 - len(self.open_members) / max(len(self.labels), 1))

    def advance(self) -> None:
        """Run all members without a label together, until each is near to a known set, or the time is over."""
        ensemble = compile_ensemble(self.subject.system, self.settings.tolerance, (), self.settings.engine)
        chunk = self._chunk()
        pace = Pace(chunk, _SAMPLES, chunk * max(_CHUNKS, math.ceil(self.span / chunk)))
        members = Members.of(self.states[:, self.open_members].T, self.subject.system.values(self.subject.values))
        farthest = _BEYOND * max(1.0, float(np.abs(self.starts).max(initial=0.0)))
        turning = np.array([s in ensemble.system.angles for s in ensemble.system.states])
        observer = _SetObserver(tuple(self.sets), farthest, turning)
        result = run_ensemble(ensemble, members, observer, pace, report=lambda _share: self._tell())
        self.states[:, self.open_members] = result.states.T
        self.labels[self.open_members] = result.record.label
        for k in np.flatnonzero(result.status == Status.FAILED).tolist():
            kind = long_run(self.subject, result.states[k], LongRunSettings(2 * chunk, self.settings.tolerance)).kind
            self.labels[self.open_members[k]] = DIVERGES if kind is MotionKind.DIVERGES else FAILED
        self.open_members = self.open_members[result.status == Status.LIMIT]

    def _chunk(self) -> float:
        """Return the length of a chunk: some oscillations of each set, a multiple of the period of the forcing."""
        lengths = [_PERIODS * s.period for s in self.sets]
        lengths += [s.exponent.duration / _BLOCKS for s in self.sets if s.exponent is not None]
        return whole_periods(self.subject, max([*lengths, self.span / 200]) or 1.0)


@dataclass(frozen=True)
class _Nearness:
    """Record of L members: the set near to which each is, or NOT_SETTLED; in how many chunks in succession."""

    label: np.ndarray
    streak: np.ndarray


@dataclass(frozen=True)
class _SetObserver:
    """Observer of members that come near to known sets."""

    sets: tuple[LimitSet, ...]
    farthest: float
    turning: np.ndarray

    def begin(self, members: Members) -> _Nearness:
        """See ``Observer``."""
        return _Nearness(np.full(len(members), NOT_SETTLED), np.zeros(len(members), int))

    def update(self, record: _Nearness, chunk: Chunk) -> tuple[_Nearness, np.ndarray]:
        """See ``Observer``."""
        times, samples = chunk.times, chunk.samples
        states = np.moveaxis(samples, 1, 0)
        nearest = np.full(samples.shape[-1], NOT_SETTLED)
        settles = np.zeros(samples.shape[-1], bool)
        for number, limit_set in sorted(enumerate(self.sets), key=lambda pair: pair[1].exponent is not None):
            if not limit_set.attracts:
                continue
            candidates = np.flatnonzero(nearest == NOT_SETTLED)
            last = limit_set.distances(times[-1:], states[:, -1, candidates]) <= limit_set.reach
            candidates = candidates[last]
            if len(candidates):
                nearest[candidates[limit_set.holds(times, states[:, :, candidates])]] = number
        streak = np.where((nearest == record.label) & (nearest >= 0), record.streak + 1, (nearest >= 0).astype(int))
        for number, limit_set in enumerate(self.sets):
            settles |= (nearest == number) & (streak >= (_PATIENCE if limit_set.exponent is not None else 1))
        far = (np.abs(samples[-1][~self.turning]) > self.farthest).any(axis=0)
        return _Nearness(np.where(far, DIVERGES, nearest), streak), settles | far

    def final_record(self, record: _Nearness) -> _Nearness:
        """See ``Observer``."""
        return record
