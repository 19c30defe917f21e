"""Verdicts on random machines hold: those at T, 4 T and 16 T agree. ``python -m benchmarks.verdicts`` tries more of them."""

import pytest
from benchmarks.verdicts import Course, course

from wucht.dynamics.verdicts.outcomes import Outcome

COUNT = 120  # one of each structure
ONCE_CHANGED = (
    214, 749, 755, 1149, 1187, 1477, 1725, 1892, 2549, 2714, 3176, 3389, 10511, 11467, 20209, 21158, 21285, 21921, 22104, 40149,
    60009, 60282, 71236, 90129,
)  # fmt: skip
"""Verdicts that changed once: bodies that still moved (749, 755, 1187, 1725, 2549, 2714, 3389, 10511), caught up (214, 11467,
20209, 21158, 21921, 71236), left (1149, 21285, 60282) or tumbled (1892, 22104, 40149), a second rotor that turned while the
first swung (1477), a modulation or a swing that faded (3176, 60009, 90129)."""


@pytest.fixture(scope="module")
def courses() -> list[Course]:
    return [course(number) for number in range(COUNT)]


@pytest.mark.slow
def test_no_verdict_changes(courses: list[Course]) -> None:
    assert [c for c in courses if c.changed] == []


@pytest.mark.slow
@pytest.mark.parametrize("number", ONCE_CHANGED)
def test_no_verdict_changes_that_changed_once(number: int) -> None:
    seen = course(number)
    assert not seen.changed, seen.verdicts


@pytest.mark.slow
def test_following_the_advice_decides(courses: list[Course]) -> None:
    """It is never three times what is needed (``test_advice``), so that it may have to be followed again."""
    undecided = [c for c in courses if c.verdicts[0][1] == Outcome.UNIDENTIFIED]
    steps = [c.steps or 99 for c in undecided]
    assert sum(n == 1 for n in steps) >= 0.6 * len(undecided)
    assert sum(n <= 3 for n in steps) >= 0.9 * len(undecided)
    assert len({o for c in courses for _, o in c.verdicts}) >= 8  # outcomes of many kinds
