"""Members, their pace, and what comes of them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from tests.refusals import failed, rejected

from wucht.numerics.ensembles.members import EnsembleResult, Members, Pace, Status, checked_record


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


@pytest.mark.parametrize("numbers", [(0.0, 1, 1.0), (1.0, 0, 1.0), (1.0, 1, -1.0), (1.0, 1, np.inf), (np.nan, 1, 1.0)])
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
    assert [ends.count(s) for s in Status] == [2, 1, 0, 3]
