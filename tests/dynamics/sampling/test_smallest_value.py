"""From which value on a probability is reached, and where it is sampled next."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.sampling.distributions import REPLICATES, points
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.sampling.probability_bands import interval
from wucht.dynamics.sampling.random_runs import ProbabilityPoint
from wucht.dynamics.sampling.smallest_value import certain_fall, next_sample_value, smallest_value


def point(value: float, low: float, high: float) -> ProbabilityPoint:
    """A point with these bounds, whatever its runs are."""
    nothing = np.zeros(0)
    return ProbabilityPoint(value, low, high, MemberOutcomes(nothing, nothing, nothing, nothing), nothing, nothing)


def seen(*lows: float, width: float = 0.1) -> list[ProbabilityPoint]:
    return [point(float(k), low, low + width) for k, low in enumerate(lows)]


@pytest.mark.parametrize(
    ("lows", "wanted", "found"),
    [
        ((0.1, 0.5, 0.7, 0.9), 0.6, 2.0),
        ((0.1, 0.5, 0.6, 0.9), 0.6, 2.0),
        ((0.7, 0.8, 0.8, 0.9), 0.6, 0.0),
        ((0.1, 0.2, 0.3, 0.4), 0.6, None),
        ((0.1, 0.65, 0.58, 0.9), 0.6, 3.0),  # falls within its confidence: from 3 on it stays
        ((0.1, 0.62, 0.65, 0.58), 0.6, None),
        ((0.9, 0.8, 0.7, 0.95), 0.6, None),  # falls beyond its confidence
    ],
)
def test_from_where_on_it_is_reached(lows: tuple[float, ...], wanted: float, found: float | None) -> None:
    assert smallest_value(seen(*lows), wanted) == found


def test_nothing_is_reached_by_nothing() -> None:
    assert smallest_value([], 0.5) is None
    assert next_sample_value([], 0.5) is None


def test_the_deepest_fall() -> None:
    fall = certain_fall(seen(0.2, 0.9, 0.75, 0.5, 0.95))
    assert fall is not None
    assert [x.value for x in fall] == [1.0, 3.0]
    assert certain_fall(seen(0.5, 0.45, 0.42)) is None


def found_by_search(of: np.ndarray, wanted: float) -> tuple[float, int]:
    """The smallest value x with wanted probability of points (R, n) below x, looked for from five values on; and its looks."""
    looks = [float(x) for x in np.linspace(0.3, 1.0, 5)]
    known: list[ProbabilityPoint] = []
    begun = len(looks)
    while looks:
        x = looks.pop(0)
        known = sorted([*known, point(x, *interval((of < x).sum(axis=1), of.shape[1], 0.95))], key=lambda b: b.value)
        if not looks and (more := next_sample_value(known, wanted)) is not None:
            looks.append(more)
    found = smallest_value(known, wanted)
    assert found is not None
    return found, len(known) - begun


@pytest.mark.slow
def test_it_errs_no_more_often_than_one_bound_does() -> None:
    """P(u1 + u2 < 2 x) is known; of 100 values found 2.5 may be too small, and they are near."""
    wanted = 0.8
    true = 1 - np.sqrt((1 - wanted) / 2)  # of P = 1 - 2 (1 - x)^2 for x > 1/2
    found, looks = zip(*(found_by_search(points(128, 2, seed=k).mean(axis=2), wanted) for k in range(100)), strict=True)
    early = (np.array(found) < true).sum()
    assert early <= 6
    assert np.median(found) == pytest.approx(true, abs=0.05)
    assert max(looks) <= 9  # 2^-9 of a step of 0.175
    assert points(128, 2, seed=0).shape[0] == REPLICATES


def test_the_search_ends_at_a_thousandth_of_the_range() -> None:
    known = [point(x, x, x + 0.01) for x in (0.0, 0.5, 1.0)]
    while (x := next_sample_value(known, 0.7)) is not None:
        known = sorted([*known, point(x, x, x + 0.01)], key=lambda b: b.value)
    found = smallest_value(known, 0.7)
    assert found is not None
    assert 0 <= found - 0.7 <= 1e-3
    assert len(known) == 3 + 9
    assert next_sample_value(seen(0.7, 0.8), 0.6) is None, "below the first value nothing is looked at"
