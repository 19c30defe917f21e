"""Verdicts on random machines hold: those at T, 4 T and 16 T agree. ``python -m benchmarks.verdicts`` tries more of them."""

import pytest
from benchmarks.verdicts import Course, course

COUNT = 100


@pytest.fixture(scope="module")
def courses() -> list[Course]:
    return [course(number) for number in range(COUNT)]


@pytest.mark.slow
def test_no_verdict_changes(courses: list[Course]) -> None:
    assert [c for c in courses if c.changed] == []


@pytest.mark.slow
def test_following_the_advice_once_decides(courses: list[Course]) -> None:
    undecided = [c for c in courses if c.advised is not None]
    assert sum(c.decided for c in undecided) >= 0.85 * len(undecided)
    assert len({o for c in courses for _, o in c.verdicts}) >= 8  # outcomes of many kinds
