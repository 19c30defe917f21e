"""A tile: contiguous members of an ensemble, advanced together by one thread; a deterministic unit of work.

After each chunk of time members that have ended are removed and the others move together, so that lanes stay full. A member's
numbers do not depend on its lane.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.errors import RunError
from wucht.numerics.ensembles.members import (
    Ends,
    Members,
    Observer,
    Pacing,
    Status,
    checked_record,
    joined_records,
    taken,
)
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.heyoka_batch import BatchIntegrator
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Program

Check = Callable[[], None]  # raises if the work is to be stopped
R = TypeVar("R")
Tick = Callable[[float], None]  # called with the completed share, 0 to 1; raises if the work is to be stopped


@dataclass(frozen=True)
class Stop:
    """Early end of a member. state: (n,), at the time; sentence: as in ``EnsembleResult``."""

    time: float
    state: np.ndarray
    status: Status
    sentence: str


@dataclass(frozen=True)
class Advanced:
    """State of L members after a chunk.

    samples: (K, n, L). states: (n, L). numbers: (k, L), which actions of events may have changed. stops: by lane; the arrays
    are undefined for these.
    """

    samples: np.ndarray
    states: np.ndarray
    numbers: np.ndarray
    stops: Mapping[int, Stop]


class Lanes(Protocol):
    """Lanes on which one thread advances members."""

    def numbers(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Convert parameters (L, p) to the numbers of the compiled code (k, L); where this fails, with a reason by lane."""
        ...

    def advance(self, states: np.ndarray, numbers: np.ndarray, times: np.ndarray, check: Check) -> Advanced:
        """Advance states (n, L) from ``times[0]`` to ``times[-1]``, sampled at all but the first."""
        ...


@dataclass(frozen=True)
class Batched:
    """Lanes that advance many members at once. names: of the states."""

    integrator: BatchIntegrator
    program: Program
    names: tuple[str, ...]

    def numbers(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Return the program's constants, computed once for equal parameters."""
        known, refused = dict[bytes, np.ndarray](), dict[int, str]()
        values = np.empty((len(self.program.constants), len(parameters)))
        for lane, row in enumerate(parameters):
            key = row.tobytes()
            try:
                if key not in known:
                    known[key] = self.program.constant_values(row)
                values[:, lane] = known[key]
            except RunError as error:
                values[:, lane], refused[lane] = np.nan, str(error)
        return values, refused

    def advance(self, states: np.ndarray, numbers: np.ndarray, times: np.ndarray, check: Check) -> Advanced:
        """Advance the states in batches: see ``Lanes``."""
        result = self.integrator.advance(states, numbers, times, check)
        stops = dict[int, Stop]()
        for lane, failure in result.failures.items():
            before = failure.error.samples
            last = before[:, -1] if before.shape[1] else states[:, lane]
            sentence = failure.error.sentence(failure.time, self.names, last)
            stops[lane] = Stop(float(times[before.shape[1]]), last, Status.FAILED, sentence)
        return Advanced(result.samples, result.states, numbers, stops)


@dataclass(frozen=True)
class OneByOne:
    """Lanes that advance one member after the other, with events and piecewise functions."""

    compiled: CompiledSystem

    def numbers(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Return the parameters unchanged."""
        return parameters.T.copy(), {}

    def advance(self, states: np.ndarray, numbers: np.ndarray, times: np.ndarray, check: Check) -> Advanced:
        """Advance the states one by one: see ``Lanes``."""
        samples, reached = np.empty((len(times) - 1, *states.shape)), np.empty(states.shape)
        after, stops = numbers.copy(), dict[int, Stop]()
        for lane in range(states.shape[1]):
            check()
            try:
                run = integrate(self.compiled, states[:, lane], numbers[:, lane], times).uninterrupted()
            except RunError as error:  # the equations cannot be evaluated at its parameters
                stops[lane] = Stop(float(times[0]), states[:, lane], Status.FAILED, str(error))
                continue
            after[:, lane], end = run.parameters, run.end_state[: len(states)]
            if run.failure is not None:
                stops[lane] = Stop(run.end_time, end, Status.FAILED, run.failure)
            elif run.stopped_by is not None:
                stops[lane] = Stop(run.end_time, end, Status.STOPPED, run.stopped_by)
            else:
                samples[:, :, lane], reached[:, lane] = run.states[:, 1:].T, end
        return Advanced(samples, reached, after, stops)


@dataclass(frozen=True)
class Tile(Generic[R]):
    """Result of the members from ``first`` on. number: of the tile."""

    number: int
    first: int
    ends: Ends[R]


def run_tile(lanes: Lanes, members: Members, observer: Observer[R], pace: Pacing, tick: Tick) -> Ends[R]:
    """Advance members until each has settled, failed or reached the limit of time."""
    course, limit = _Course(lanes, members, observer), pace.times(pace.chunks - 1)[-1]
    for chunk in range(pace.chunks):
        if not len(course.ids):
            break
        times = pace.times(chunk)
        share = 1 - len(course.ids) * (1 - float(times[0] / limit)) / len(members)
        course.advance(times, partial(tick, share))
    return course.ends()


class _Course(Generic[R]):
    """Members in progress. ids (L,): their numbers, rising; states (n, L), numbers (k, L) and record are theirs."""

    def __init__(self, lanes: Lanes, members: Members, observer: Observer[R]) -> None:
        count = len(members)
        self._lanes, self._observer = lanes, observer
        self._times, self._ends = np.zeros(count), members.starts.copy()
        self._status, self._sentences = np.full(count, Status.LIMIT, np.int8), dict[int, str]()
        self._records = list[tuple[np.ndarray, R]]()
        self.ids, self.states = np.arange(count), np.ascontiguousarray(members.starts.T)
        self.record = checked_record(observer.begin(members), count)
        self.numbers, refused = lanes.numbers(members.parameters)
        for i in np.flatnonzero(~np.isfinite(members.starts).all(axis=1)).tolist():
            refused[i] = f"the start {members.starts[i]} is not finite"
        self._stop({i: Stop(0.0, members.starts[i], Status.FAILED, why) for i, why in refused.items()})

    def advance(self, times: np.ndarray, check: Callable[[], None]) -> None:
        """Advance the members by a chunk, observe them, and remove those that have ended."""
        begun = len(self.ids)
        advanced = self._lanes.advance(self.states, self.numbers, times, check)
        self.states, self.numbers, samples = advanced.states, advanced.numbers, advanced.samples
        self._stop(advanced.stops)
        if advanced.stops:
            going = np.setdiff1d(np.arange(begun), list(advanced.stops))
            samples = np.take(samples, going, axis=-1)
        if not len(self.ids):
            return
        self.record, settled = self._seen(times[1:], samples)
        self._times[self.ids], self._ends[self.ids] = times[-1], self.states.T
        self._status[self.ids[settled]] = Status.SETTLED
        self._leave(settled)

    def _seen(self, times: np.ndarray, samples: np.ndarray) -> tuple[R, np.ndarray]:
        """Update the observer's record by a chunk, and return which members have settled."""
        count, record = len(self.ids), self.record
        if count == 1:
            twice = np.zeros(2, int)
            record, samples = taken(record, twice), np.take(samples, twice, axis=-1)
        record, settled = self._observer.after(record, times, samples)
        record, settled = checked_record(record, samples.shape[-1]), np.asarray(settled, bool)
        if settled.shape != samples.shape[-1:]:
            raise RunError(f"an observer must decide of each of {samples.shape[-1]} members whether it has settled")
        return (taken(record, np.zeros(1, int)), settled[:1]) if count == 1 else (record, settled)

    def _stop(self, stops: Mapping[int, Stop]) -> None:
        """Remove the members that end early."""
        out = np.zeros(len(self.ids), bool)
        for lane, stop in stops.items():
            out[lane], i = True, int(self.ids[lane])
            self._times[i], self._ends[i], self._status[i] = stop.time, stop.state, stop.status
            self._sentences[i] = stop.sentence
        self._leave(out)

    def _leave(self, out: np.ndarray) -> None:
        if not out.any():
            return
        left, kept = np.flatnonzero(out), np.flatnonzero(~out)
        self._records.append((self.ids[left], self._observer.kept(taken(self.record, left))))
        self.ids, self.record = self.ids[kept], taken(self.record, kept)
        self.states, self.numbers = np.take(self.states, kept, axis=1), np.take(self.numbers, kept, axis=1)

    def ends(self) -> Ends[R]:
        """Return the results of all members, in their order."""
        parts = [*self._records, (self.ids, self._observer.kept(self.record))]
        order = np.argsort(np.concatenate([ids for ids, _ in parts]))
        record = taken(joined_records([r for _, r in parts]), order)
        return Ends(self._times, self._ends, self._status, dict(sorted(self._sentences.items())), record)
