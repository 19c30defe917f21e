"""A tile on lanes that do no more than add: which members are advanced, observed, removed, and what is left of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from wucht.errors import RunError
from wucht.numerics.ensembles.members import Chunk, Members, Pace, Status
from wucht.numerics.ensembles.tile import ChunkResult, Stop, run_tile


@dataclass(frozen=True)
class Watched:
    """The number of each member, and in how many chunks it was observed."""

    number: np.ndarray
    chunks: np.ndarray


class Adding:
    """Each state grows by its rate; stops are given by the time of the chunk's end and the member's number, its rate."""

    def __init__(self, stops: Mapping[tuple[float, float], Stop], refused: Mapping[int, str]) -> None:
        self.stops, self.refused, self.lanes = stops, dict(refused), list[list[float]]()

    def lane_values(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        return parameters.T.copy(), self.refused

    def advance(self, states: np.ndarray, lane_values: np.ndarray, times: np.ndarray, check: Any) -> ChunkResult:
        check()
        self.lanes.append(lane_values[0].tolist())
        samples = states[None] + (times[1:] - times[0])[:, None, None] * lane_values
        ended = {
            i: self.stops[float(times[-1]), n] for i, n in enumerate(lane_values[0]) if (float(times[-1]), n) in self.stops
        }
        chunk = Chunk(times[1:], samples, -samples[-1])
        return ChunkResult(chunk, samples[-1], lane_values, ended)


class Observing:
    """A member settles when its state exceeds 10; it is never alone."""

    def __init__(self) -> None:
        self.counts = list[int]()

    def begin(self, members: Members) -> Watched:
        return Watched(members.parameter_values[:, 0].copy(), np.zeros(len(members)))

    def update(self, record: Watched, chunk: Chunk) -> tuple[Watched, np.ndarray]:
        times, samples = chunk.times, chunk.samples
        self.counts.append(samples.shape[-1])
        assert np.array_equal(chunk.peaks, -samples[-1])
        assert samples.shape[:2] == (3, 1) and len(times) == 3 and len(record.number) == samples.shape[-1]
        assert samples[0, 0] == pytest.approx(times[0] * record.number)
        return Watched(record.number, record.chunks + 1), samples[-1, 0] > 10

    def final_record(self, record: Watched) -> Watched:
        return Watched(record.number, -record.chunks)


def run(rates: list[float], stops: Any = None, refused: Any = None) -> tuple[Any, Adding, Observing, list[float]]:
    """Up to a time of 4 in chunks of 1."""
    lanes, observer, shares = Adding(stops or {}, refused or {}), Observing(), list[float]()
    members = Members.of(np.zeros((len(rates), 1)), np.array(rates)[:, None])
    return run_tile(lanes, members, observer, Pace(1.0, 3, 4.0), shares.append), lanes, observer, shares


def test_members_leave_when_they_have_settled() -> None:
    """12 after a chunk, 6 after two, 3 after four; 2 reaches the limit."""
    result, lanes, _, shares = run([3.0, 12.0, 2.0, 6.0])
    assert result.times.tolist() == [4.0, 1.0, 4.0, 2.0] and result.states.ravel().tolist() == [12.0, 12.0, 8.0, 12.0]
    assert result.status.tolist() == [Status.SETTLED, Status.SETTLED, Status.LIMIT, Status.SETTLED]
    assert result.record.number.tolist() == [3.0, 12.0, 2.0, 6.0] and result.record.chunks.tolist() == [-4, -1, -4, -2]
    assert lanes.lanes == [[3.0, 12.0, 2.0, 6.0], [3.0, 2.0, 6.0], [3.0, 2.0], [3.0, 2.0]]
    assert shares == pytest.approx([0.0, 1 - 3 * 0.75 / 4, 1 - 2 * 0.5 / 4, 1 - 2 * 0.25 / 4]) and result.sentences == {}


def test_a_member_that_is_left_alone_is_observed_twice() -> None:
    result, lanes, observer, _ = run([12.0, 6.0])
    assert lanes.lanes == [[12.0, 6.0], [6.0]] and observer.counts == [2, 2]
    assert result.times.tolist() == [1.0, 2.0] and result.record.chunks.tolist() == [-1, -2]
    alone, _, watched, _ = run([1.0])
    assert watched.counts == [2] * 4 and alone.record.chunks.tolist() == [-4] and alone.status.tolist() == [Status.LIMIT]


def test_members_that_end_early_keep_what_they_were() -> None:
    """One that fails within the second chunk, one that is stopped in it, one that cannot be computed with at all."""
    stops = {
        (2.0, 5.0): Stop(1.5, np.array([7.5]), Status.FAILED, "it overflows"),
        (2.0, 1.0): Stop(1.75, np.array([1.75]), Status.STOPPED, "at the stop"),
    }
    result, lanes, observer, _ = run([1.0, 9.0, 5.0, 2.0], stops, {1: "no such number"})
    assert lanes.lanes == [[1.0, 5.0, 2.0], [1.0, 5.0, 2.0], [2.0], [2.0]] and observer.counts == [3, 2, 2, 2]
    assert result.times.tolist() == [1.75, 0.0, 1.5, 4.0] and result.states.ravel().tolist() == [1.75, 0.0, 7.5, 8.0]
    assert result.status.tolist() == [Status.STOPPED, Status.FAILED, Status.FAILED, Status.LIMIT]
    assert result.sentences == {0: "at the stop", 1: "no such number", 2: "it overflows"}
    assert result.record.chunks.tolist() == [-1, 0, -1, -4]


def test_a_start_that_is_not_finite_fails_at_once() -> None:
    members = Members.of(np.array([[np.nan], [0.0]]), np.ones((2, 1)))
    result = run_tile(Adding({}, {}), members, Observing(), Pace(1.0, 3, 4.0), lambda _: None)
    assert result.status.tolist() == [Status.FAILED, Status.LIMIT] and "not finite" in result.sentences[0]


def test_an_observer_decides_for_each_member(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Observing, "update", lambda _, record, chunk: (record, np.zeros(3, bool)))
    with pytest.raises(RunError, match="for each of 2 members"):
        run([1.0, 2.0])
