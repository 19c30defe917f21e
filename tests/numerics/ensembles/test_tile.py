"""A tile on lanes that do no more than add: which members are advanced, observed, removed, and what is left of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.errors import RunError
from wucht.numerics.ensembles.members import Chunk, Members, Pace, Status
from wucht.numerics.ensembles.tile import run_tile
from wucht.numerics.flow.compiled_batch import LanesResult


@dataclass(frozen=True)
class Watched:
    """The number of each member, and in how many chunks it was observed."""

    number: np.ndarray
    chunks: np.ndarray


@dataclass(frozen=True)
class Failure:
    """Why a member fails, and after what time and in which state it was sampled last."""

    reason: str
    sample_time: float
    state: float

    def sentence(self, time: float, names: tuple[str, ...], state: np.ndarray) -> str:
        return f"at {time} {self.reason}: {names[0]} = {state[0]}"


class Adding:
    """An integrator, and its batch, by which each state grows by its rate.

    failures: by the time of the chunk's end and the member's number, its rate; they happen half way to that end.
    """

    def __init__(self, failures: Mapping[tuple[float, float], Failure], refused: Mapping[int, str]) -> None:
        self.failures, self.refused, self.lanes = failures, dict(refused), list[list[float]]()
        self.batch, self.system = self, SimpleNamespace(state_names=("x",))

    def lane_constants(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        return parameters.T.copy(), self.refused

    def begin(self, count: int) -> np.ndarray:
        return np.zeros((2, count))

    def advance(self, states: Any, constants: Any, times: Any, check: Any, progress: Any) -> LanesResult:
        check()
        self.lanes.append(constants[0].tolist())
        samples = states[None] + (times[1:] - times[0])[:, None, None] * constants
        assert progress[1:] == pytest.approx(-states)
        ends, reached, sampled, failures = samples[-1].copy(), *np.full((2, len(constants[0])), times[-1]), {}
        for lane, number in enumerate(constants[0]):
            if failure := self.failures.get((float(times[-1]), number)):
                ends[0, lane], reached[lane], sampled[lane] = failure.state, times[[0, -1]].mean(), failure.sample_time
                failures[lane] = failure
        return LanesResult(samples, ends, reached, sampled, np.concatenate([progress[:1], -samples[-1]]), failures)


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


def run(rates: list[float], failures: Any = None, refused: Any = None) -> tuple[Any, Adding, Observing, list[float]]:
    """Up to a time of 4 in chunks of 1."""
    lanes, observer, shares = Adding(failures or {}, refused or {}), Observing(), list[float]()
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
    """Two that fail within the second chunk, one that cannot be computed with at all."""
    failures = {(2.0, 5.0): Failure("it overflows", 1.25, 6.25), (2.0, 1.0): Failure("it stalls", 1.0, 1.0)}
    result, lanes, observer, _ = run([1.0, 9.0, 5.0, 2.0], failures, {1: "no such number"})
    assert lanes.lanes == [[1.0, 5.0, 2.0], [1.0, 5.0, 2.0], [2.0], [2.0]] and observer.counts == [3, 2, 2, 2]
    assert result.times.tolist() == [1.0, 0.0, 1.25, 4.0] and result.states.ravel().tolist() == [1.0, 0.0, 6.25, 8.0]
    assert result.status.tolist() == [Status.FAILED, Status.FAILED, Status.FAILED, Status.LIMIT]
    assert result.sentences == {0: "at 1.5 it stalls: x = 1.0", 1: "no such number", 2: "at 1.5 it overflows: x = 6.25"}
    assert result.record.chunks.tolist() == [-1, 0, -1, -4]


def test_a_start_that_is_not_finite_fails_at_once() -> None:
    members = Members.of(np.array([[np.nan], [0.0]]), np.ones((2, 1)))
    result = run_tile(Adding({}, {}), members, Observing(), Pace(1.0, 3, 4.0), lambda _: None)
    assert result.status.tolist() == [Status.FAILED, Status.LIMIT] and "not finite" in result.sentences[0]


def test_an_observer_decides_for_each_member(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Observing, "update", lambda _, record, chunk: (record, np.zeros(3, bool)))
    with pytest.raises(RunError, match="for each of 2 members"):
        run([1.0, 2.0])
