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
    Chunk,
    EnsembleResult,
    Members,
    Observer,
    Pacing,
    Status,
    checked_record,
    joined_records,
    select_members,
)
from wucht.numerics.flow.compiled_batch import BatchIntegrator, CompiledBatch
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.integration import integrate

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
class ChunkResult:
    """State of L members after a chunk, and what was observed in it.

    states: (n, L). lane_values: (k, L), which actions of events may have changed. stops: by lane; arrays are undefined for
    these.
    """

    chunk: Chunk
    states: np.ndarray
    lane_values: np.ndarray
    stops: Mapping[int, Stop]


class Lanes(Protocol):
    """Lanes on which one thread advances members."""

    def lane_values(self, parameter_values: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Convert parameters (L, p) to the values (k, L) with which lanes are advanced; where this fails, a reason by lane."""
        ...

    def advance(self, states: np.ndarray, lane_values: np.ndarray, times: np.ndarray, check: Check) -> ChunkResult:
        """Advance states (n, L) from ``times[0]`` to ``times[-1]``, sampled at all but the first."""
        ...


@dataclass(frozen=True)
class BatchLanes:
    """Lanes that advance many members at once. names: of the states."""

    batch: CompiledBatch
    integrator: BatchIntegrator
    names: tuple[str, ...]

    def lane_values(self, parameter_values: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Return the constants of the code, computed once for equal parameters, and the progress of motions that begin."""
        keys = [row.tobytes() for row in parameter_values]
        column_by_key = {key: k for k, key in enumerate(dict.fromkeys(keys))}
        columns, reasons = np.full((self.batch.constant_count, len(column_by_key)), np.nan), dict[bytes, str]()
        for key, k in column_by_key.items():
            try:
                columns[:, k] = self.batch.constant_values(np.frombuffer(key))
            except RunError as error:
                reasons[key] = str(error)
        refusals = {lane: reasons[key] for lane, key in enumerate(keys) if key in reasons} if reasons else {}
        columns = np.take(columns, [column_by_key[key] for key in keys], axis=1)
        return np.concatenate([columns, self.batch.begin(len(keys))]), refusals

    def advance(self, states: np.ndarray, lane_values: np.ndarray, times: np.ndarray, check: Check) -> ChunkResult:
        """Advance the states in batches: see ``Lanes``."""
        constants, progress = np.split(lane_values, [self.batch.constant_count])
        result = self.integrator.advance(states, constants, times, check, progress)
        stops = dict[int, Stop]()
        for lane, error in result.failures.items():
            state = result.states[:, lane].copy()
            sentence = error.sentence(float(result.times[lane]), self.names, state)
            stops[lane] = Stop(float(result.sample_times[lane]), state, Status.FAILED, sentence)
        chunk, next_values = Chunk(times[1:], result.values, result.peaks), np.concatenate([constants, result.progress])
        return ChunkResult(chunk, result.states, next_values, stops)


@dataclass(frozen=True)
class SequentialLanes:
    """Lanes that advance one member after the other, with events and piecewise functions; states are observed."""

    compiled_system: CompiledSystem

    def lane_values(self, parameter_values: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Return the parameters unchanged."""
        return parameter_values.T.copy(), {}

    def advance(self, states: np.ndarray, lane_values: np.ndarray, times: np.ndarray, check: Check) -> ChunkResult:
        """Advance the states one by one: see ``Lanes``."""
        samples, end_states = np.empty((len(times) - 1, *states.shape)), np.empty(states.shape)
        next_values, stops = lane_values.copy(), dict[int, Stop]()
        for lane in range(states.shape[1]):
            check()
            try:
                run = integrate(self.compiled_system, states[:, lane], lane_values[:, lane], times).reraise_interrupt()
            except RunError as error:  # the equations cannot be evaluated at its parameters
                stops[lane] = Stop(float(times[0]), states[:, lane], Status.FAILED, str(error))
                continue
            next_values[:, lane], end = run.final_parameter_values, run.end_state[: len(states)]
            if run.failure is not None:
                stops[lane] = Stop(run.end_time, end, Status.FAILED, run.failure)
            elif run.stopped_by is not None:
                stops[lane] = Stop(run.end_time, end, Status.STOPPED, run.stopped_by)
            else:
                samples[:, :, lane], end_states[:, lane] = run.states[:, 1:].T, end
        return ChunkResult(Chunk(times[1:], samples, np.empty((0, states.shape[1]))), end_states, next_values, stops)


def run_tile(lanes: Lanes, members: Members, observer: Observer[R], pace: Pacing, tick: Tick) -> EnsembleResult[R]:
    """Advance members until each has settled, failed or reached the limit of time."""
    active, limit = _ActiveMembers(lanes, members, observer), pace.times(pace.chunks - 1)[-1]
    for chunk in range(pace.chunks):
        if not len(active.ids):
            break
        times = pace.times(chunk)
        share = 1 - len(active.ids) * (1 - float(times[0] / limit)) / len(members)
        active.advance(times, partial(tick, share))
    return active.result()


class _ActiveMembers(Generic[R]):
    """Members in progress. ids (L,): their numbers, rising; states (n, L), lane_values (k, L) and record are theirs."""

    def __init__(self, lanes: Lanes, members: Members, observer: Observer[R]) -> None:
        count = len(members)
        self._lanes, self._observer = lanes, observer
        self._times, self._ends = np.zeros(count), members.starts.copy()
        self._status, self._sentences = np.full(count, Status.LIMIT, np.int8), dict[int, str]()
        self._records = list[tuple[np.ndarray, R]]()
        self.ids, self.states = np.arange(count), np.ascontiguousarray(members.starts.T)
        self.record = checked_record(observer.begin(members), count)
        self.lane_values, refusals = lanes.lane_values(members.parameter_values)
        for i in np.flatnonzero(~np.isfinite(members.starts).all(axis=1)).tolist():
            refusals[i] = f"the start {members.starts[i]} is not finite"
        self._stop({i: Stop(0.0, members.starts[i], Status.FAILED, reason) for i, reason in refusals.items()})

    def advance(self, times: np.ndarray, check: Callable[[], None]) -> None:
        """Advance the members by a chunk, observe them, and remove those that have ended."""
        lane_count = len(self.ids)
        result = self._lanes.advance(self.states, self.lane_values, times, check)
        self.states, self.lane_values, chunk = result.states, result.lane_values, result.chunk
        self._stop(result.stops)
        if result.stops:
            chunk = chunk.select(np.setdiff1d(np.arange(lane_count), list(result.stops)))
        if not len(self.ids):
            return
        self.record, has_settled = self._observe(chunk)
        self._times[self.ids], self._ends[self.ids] = times[-1], self.states.T
        self._status[self.ids[has_settled]] = Status.SETTLED
        self._remove_lanes(has_settled)

    def _observe(self, chunk: Chunk) -> tuple[R, np.ndarray]:
        """Update the observer's record by a chunk, and return which members have settled."""
        count, record = len(self.ids), self.record
        if count == 1:
            pair = np.zeros(2, int)
            record, chunk = select_members(record, pair), chunk.select(pair)
        record, has_settled = self._observer.update(record, chunk)
        observed_count = chunk.samples.shape[-1]
        record, has_settled = checked_record(record, observed_count), np.asarray(has_settled, bool)
        if has_settled.shape != (observed_count,):
            raise RunError(f"an observer must decide for each of {observed_count} members whether it has settled")
        return (select_members(record, np.zeros(1, int)), has_settled[:1]) if count == 1 else (record, has_settled)

    def _stop(self, stops: Mapping[int, Stop]) -> None:
        """Remove the members that end early."""
        has_ended = np.zeros(len(self.ids), bool)
        for lane, stop in stops.items():
            has_ended[lane], i = True, int(self.ids[lane])
            self._times[i], self._ends[i], self._status[i] = stop.time, stop.state, stop.status
            self._sentences[i] = stop.sentence
        self._remove_lanes(has_ended)

    def _remove_lanes(self, has_ended: np.ndarray) -> None:
        if not has_ended.any():
            return
        ended_lanes, other_lanes = np.flatnonzero(has_ended), np.flatnonzero(~has_ended)
        self._records.append((self.ids[ended_lanes], self._observer.final_record(select_members(self.record, ended_lanes))))
        self.ids, self.record = self.ids[other_lanes], select_members(self.record, other_lanes)
        self.states = np.take(self.states, other_lanes, axis=1)
        self.lane_values = np.take(self.lane_values, other_lanes, axis=1)

    def result(self) -> EnsembleResult[R]:
        """Return the results of all members, in their order."""
        parts = [*self._records, (self.ids, self._observer.final_record(self.record))]
        order = np.argsort(np.concatenate([ids for ids, _ in parts]))
        record = select_members(joined_records([r for _, r in parts]), order)
        return EnsembleResult(self._times, self._ends, self._status, dict(sorted(self._sentences.items())), record)
