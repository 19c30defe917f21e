"""A tile: contiguous members of an ensemble, advanced together by one thread; a deterministic unit of work.

After each chunk of time members that have ended are removed and the others move together, so that lanes stay full. A member's
numbers do not depend on its lane.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Generic, TypeVar

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
from wucht.numerics.flow.compiled_batch import BatchIntegrator

R = TypeVar("R")
Tick = Callable[[float], None]  # called with the completed share, 0 to 1; raises if the work is to be stopped


def run_tile(
    integrator: BatchIntegrator, members: Members, observer: Observer[R], pace: Pacing, tick: Tick
) -> EnsembleResult[R]:
    """Advance members until each has settled, failed or reached the limit of time."""
    active, limit = _ActiveMembers(integrator, members, observer), pace.times(pace.chunks - 1)[-1]
    for chunk in range(pace.chunks):
        if not len(active.ids):
            break
        times = pace.times(chunk)
        share = 1 - len(active.ids) * (1 - float(times[0] / limit)) / len(members)
        active.advance(times, partial(tick, share))
    return active.result()


class _ActiveMembers(Generic[R]):
    """Members in progress. ids (L,): their numbers, rising; states (n, L), constants (k, L), progress and record are theirs."""

    def __init__(self, integrator: BatchIntegrator, members: Members, observer: Observer[R]) -> None:
        count, batch = len(members), integrator.batch
        self._integrator, self._observer = integrator, observer
        self._times, self._ends = np.zeros(count), members.starts.copy()
        self._status, self._sentences = np.full(count, Status.LIMIT, np.int8), dict[int, str]()
        self._records = list[tuple[np.ndarray, R]]()
        self.ids, self.states = np.arange(count), np.ascontiguousarray(members.starts.T)
        self.record = checked_record(observer.begin(members), count)
        self.constants, failures = batch.lane_constants(members.parameter_values)
        self.progress = batch.begin(count)
        for i in np.flatnonzero(~np.isfinite(members.starts).all(axis=1)).tolist():
            failures[i] = f"the start {members.starts[i]} is not finite"
        self._fail(failures, self._times, self.states)

    def advance(self, times: np.ndarray, check: Callable[[], None]) -> None:
        """Advance the members by a chunk, observe them, and remove those that have ended."""
        lane_count, names = len(self.ids), self._integrator.batch.system.state_names
        result = self._integrator.advance(self.states, self.constants, times, check, self.progress)
        self.states, self.progress = result.states, result.progress
        chunk = Chunk(times[1:], result.values, result.peaks)
        if result.failures:
            failures = {
                lane: error.sentence(float(result.times[lane]), names, result.states[:, lane])
                for lane, error in result.failures.items()
            }
            self._fail(failures, result.sample_times, result.states)
            chunk = chunk.select(np.setdiff1d(np.arange(lane_count), list(failures)))
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

    def _fail(self, failures: Mapping[int, str], times: np.ndarray, states: np.ndarray) -> None:
        """Remove the members on some lanes, which fail for these reasons. times (L,), states (n, L): where they end."""
        has_failed = np.zeros(len(self.ids), bool)
        for lane, reason in failures.items():
            has_failed[lane], i = True, int(self.ids[lane])
            self._times[i], self._ends[i], self._status[i] = times[lane], states[:, lane], Status.FAILED
            self._sentences[i] = reason
        self._remove_lanes(has_failed)

    def _remove_lanes(self, has_ended: np.ndarray) -> None:
        if not has_ended.any():
            return
        ended_lanes, other_lanes = np.flatnonzero(has_ended), np.flatnonzero(~has_ended)
        self._records.append((self.ids[ended_lanes], self._observer.final_record(select_members(self.record, ended_lanes))))
        self.ids, self.record = self.ids[other_lanes], select_members(self.record, other_lanes)
        self.states = np.take(self.states, other_lanes, axis=1)
        self.constants = np.take(self.constants, other_lanes, axis=1)
        self.progress = np.take(self.progress, other_lanes, axis=1)

    def result(self) -> EnsembleResult[R]:
        """Return the results of all members, in their order."""
        parts = [*self._records, (self.ids, self._observer.final_record(self.record))]
        order = np.argsort(np.concatenate([ids for ids, _ in parts]))
        record = select_members(joined_records([r for _, r in parts]), order)
        return EnsembleResult(self._times, self._ends, self._status, dict(sorted(self._sentences.items())), record)
