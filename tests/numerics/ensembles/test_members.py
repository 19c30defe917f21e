"""Members, their pace, and what comes of them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed, rejected

from wucht.numerics.ensembles import ensemble
from wucht.numerics.ensembles.members import (
    EnsembleResult,
    Members,
    Pace,
    Status,
    checked_record,
    select_members,
)


@dataclass(frozen=True)
class Top:
    top: np.ndarray  # (2, M)


def test_parameters_that_are_shared_are_not_copied() -> None:
    one = np.array([1.0, 2.0])
    members = Members.of(np.zeros((1000, 3)), one)
    assert np.shares_memory(members.parameter_values, one)
    assert members.part(10, 14).parameter_values.tolist() == [[1.0, 2.0]] * 4
    assert len(members.part(990, 2000)) == 10


@pytest.mark.parametrize(("starts", "parameters"), [((4,), (2,)), ((4, 3), (5, 2)), ((4, 3), (4, 2, 1)), ((4, 3), ())])
def test_shapes_that_make_no_members(starts: tuple[int, ...], parameters: tuple[int, ...]) -> None:
    with rejected("shape"):
        Members.of(np.zeros(starts), np.zeros(parameters))


def test_chunks_follow_each_other_without_a_gap_and_end_at_the_limit() -> None:
    pace = Pace(0.1, 4, 0.75)
    times = [pace.times(i) for i in range(pace.chunks)]
    assert len(times) == 8
    assert all(a[-1] == b[0] for a, b in pairwise(times))
    assert times[0] == pytest.approx([0, 0.025, 0.05, 0.075, 0.1])
    assert times[-1][-1] == 0.75
    assert Pace(0.1, 4, 0.3).chunks == 3  # 3 * 0.1 is a rounding more than 0.3
    assert Pace(5.0, 4, 0.3).times(0)[-1] == 0.3


@pytest.mark.parametrize(
    "numbers", [(0.0, 1, 1.0), (1.0, 1, 0.0), (1.0, 0, 1.0), (1.0, 1, -1.0), (1.0, 1, np.inf), (np.nan, 1, 1.0)]
)
def test_a_pace_that_is_none(numbers: tuple[float, int, float]) -> None:
    with rejected("pace"):
        Pace(*numbers)


def test_a_record_that_is_not_one_of_its_members() -> None:
    assert checked_record(Top(np.zeros((2, 5))), 5).top.shape == (2, 5)
    for wrong in (Top(np.zeros((5, 2))), np.zeros(5)):
        with failed("record", "5"):
            checked_record(wrong, 5)


def test_ends_of_several_parts() -> None:
    def part(count: int, status: Status, sentences: dict[int, str]) -> EnsembleResult[Top]:
        number = np.arange(count, dtype=float)
        return EnsembleResult(number, number[:, None], np.full(count, status), sentences, Top(np.tile(number, (2, 1))))

    ends = EnsembleResult.join([part(2, Status.SETTLED, {}), part(3, Status.FAILED, {1: "why"}), part(1, Status.LIMIT, {})])
    assert ends.sentences == {3: "why"}
    assert ends.times.tolist() == ends.states[:, 0].tolist() == ends.record.top[1].tolist() == [0, 1, 0, 1, 2, 0]
    assert [ends.count(s) for s in Status] == [2, 1, 3]


def test_a_rounding_makes_no_further_chunk() -> None:
    """2.1/0.3 is a rounding more than 7; a thousandth more is a chunk of its own."""
    assert 2.1 / 0.3 > 7 and Pace(0.3, 4, 2.1).chunks == 7 and Pace(0.3, 4, 2.1003).chunks == 8
    assert Pace(0.3, 4, 2.1).times(6)[-1] == 2.1 and Pace(0.3, 4, 2.1).times(5)[0] == 1.5


@dataclass(frozen=True)
class Pair:
    one: np.ndarray
    many: np.ndarray


def test_each_array_of_a_record_has_its_members() -> None:
    assert checked_record(Pair(np.zeros(5), np.zeros((2, 5))), 5).one.shape == (5,)
    for wrong in (Pair(np.zeros(5), np.zeros((5, 2))), Pair(np.zeros(4), np.zeros((2, 5))), Pair(np.zeros(()), np.zeros(5))):
        with failed("record", "5"):
            checked_record(wrong, 5)
    chosen = select_members(Pair(np.arange(5.0), np.arange(10.0).reshape(2, 5)), np.array([3, 0]))
    assert chosen.one.tolist() == [3.0, 0.0] and chosen.many.tolist() == [[3.0, 0.0], [8.0, 5.0]]


@pytest.mark.parametrize(
    ("count", "threads", "width", "states", "size"),
    [(100, 2, 4, 2, 28), (96, 2, 4, 2, 24), (97, 2, 4, 2, 28), (3, 2, 4, 2, 4), (100, 1, 4, 2, 52), (100, 0, 4, 2, 52),
     (100_000, 2, 4, 2, 2944), (100_000, 3, 4, 2, 2780), (100_000, 2, 8, 62, 96), (100_000, 2, 8, 9999, 8)],
)  # fmt: skip
def test_a_tile_has_whole_batches(count: int, threads: int, width: int, states: int, size: int) -> None:
    """At least two tiles for each thread, of no more than 5952 states unless a batch alone has more, and for each as many."""
    compiled: Any = SimpleNamespace(width=width, system=SimpleNamespace(states=range(states)))
    assert ensemble._members_per_tile(count, threads, compiled) == size
    assert states * size <= 5952 or size == width
    assert threads == 0 or count < 4 * threads * width or -(-count // size) % threads == 0


def test_the_processors_that_may_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ensemble.os, "sched_getaffinity", lambda _: {1, 4, 5}, raising=False)
    assert ensemble.processor_count() == 3
    monkeypatch.delattr(ensemble.os, "sched_getaffinity")
    for number, expected in ((7, 7), (None, 1)):
        monkeypatch.setattr(ensemble.os, "cpu_count", lambda number=number: number)
        assert ensemble.processor_count() == expected
