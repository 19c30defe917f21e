"""Bands of probabilities counted on scrambled Sobol' points: they hold as often as they say, of regions whose size is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import beta, binomtest

from wucht.dynamics.sampling.distributions import REPLICATES, points
from wucht.dynamics.sampling.probability_bands import band, clopper_pearson, interval

TIMES, EACH = 400, 16


def scrambled(dimensions: int) -> np.ndarray:
    """Points (TIMES, R, n, d) of as many seeds."""
    return np.array([points(REPLICATES * EACH, dimensions, seed) for seed in range(TIMES)])


def in_disc(at: np.ndarray, share: float) -> np.ndarray:
    """A disc in the square, or all but it."""
    small = min(share, 1 - share)
    inside = np.hypot(at[..., 0] - 0.5, at[..., 1] - 0.47) < math.sqrt(small / math.pi)
    return np.asarray(inside if share <= 0.5 else ~inside)


def below_plane(at: np.ndarray, share: float) -> np.ndarray:
    """Below a plane across the cube: the sum of d uniform numbers is distributed by J. O. Irwin and P. Hall."""
    d = at.shape[-1]

    def off(c: float) -> float:
        return sum((-1) ** k * math.comb(d, k) * max(c - k, 0.0) ** d for k in range(d + 1)) / math.factorial(d) - share

    return np.asarray(at.sum(axis=-1) < brentq(off, 0.0, d))


@pytest.mark.slow
@pytest.mark.parametrize(("region", "dimensions"), [(in_disc, 2), (below_plane, 4)])
def test_they_hold_as_often_as_they_say(region: object, dimensions: int) -> None:
    """In the middle they are far narrower than those of independent points; never are they much wider."""
    at = scrambled(dimensions)
    for share, narrower in ((0.02, 1.15), (0.5, 0.75), (0.98, 1.15)):
        counts = region(at, share).sum(axis=-1)  # type: ignore[operator]
        bands = np.array([interval(c, EACH, 0.95) for c in counts])
        held = ((bands[:, 0] <= share) & (share <= bands[:, 1])).mean()
        assert 0.93 <= held <= 1.0, share
        total = EACH * REPLICATES
        plain = np.array([clopper_pearson(float(k), total, 0.025) for k in counts.sum(axis=1)])
        assert np.ptp(bands, axis=1).mean() < narrower * np.ptp(plain, axis=1).mean(), share
        assert ((bands[:, 0] <= counts.mean(axis=1) / EACH) & (counts.mean(axis=1) / EACH <= bands[:, 1])).all()


@pytest.mark.parametrize("count", [8, 16, 32, 48, 64])
def test_they_hold_from_eight_points_on(count: int) -> None:
    """Of the square, and of what is left of it without a third: independent points, and few of each replicate.

    The least share of 400 bands that hold with 95 % each is 0.925 in 97 of 100 cases.
    """
    at = np.array([points(count, 2, seed) for seed in range(TIMES)])
    x, y = at[..., 0], at[..., 1]
    for left_out in (0.0, 1 / 3):
        possible, along = x >= left_out, (x - left_out) / (1 - left_out)
        sizes = possible.sum(axis=-1)
        for share in (0.1, 0.5, 0.9):
            counts = (possible & ((y + along / 2) % 1.0 < share)).sum(axis=-1)
            bands = np.array([interval(c, n, 0.95) for c, n in zip(counts, sizes, strict=True)])
            held = ((bands[:, 0] <= share) & (share <= bands[:, 1])).mean()
            assert held >= 0.925, (share, left_out)
            plain = np.array([clopper_pearson(float(c.sum()), n.sum(), 0.025) for c, n in zip(counts, sizes, strict=True)])
            assert np.ptp(bands, axis=1).mean() <= 1.3 * np.ptp(plain, axis=1).mean(), (share, left_out)


def test_independent_points_have_exact_bounds() -> None:
    """Five of eight inside, and of those left where two are left out: of 6."""
    inside = np.array([1, 0, 1, 1, 0, 1, 1, 0])
    exact = binomtest(5, 8).proportion_ci(0.95, method="exact")
    assert interval(inside, 1, 0.95) == pytest.approx((exact.low, exact.high))
    exact = binomtest(5, 6).proportion_ci(0.95, method="exact")
    assert interval(inside, np.array([1, 0, 1, 1, 0, 1, 1, 1]), 0.95) == pytest.approx((exact.low, exact.high))


def test_the_scatter_of_a_ratio_by_hand() -> None:
    """Of 4, 8, 6, 6 points are 2, 3, 3, 1 inside, a share of 9/24: residuals 0.5, 0, 0.75, -1.25, their squares 2.375 in all.

    The standard deviation of the share is sqrt(2.375/3/4)/6 = 0.074146, and 3.18245 of these, by Student's t, are 0.235967.
    """
    low, high = interval(np.array([2, 3, 3, 1]), np.array([4, 8, 6, 6]), 0.95)
    share, deviation = 9 / 24, math.sqrt(2.375 / 3 / 4) / 6
    number = share * (1 - share) / deviation**2 * (1.959964 / 3.182446) ** 2
    exact = clopper_pearson(share * number, number, 0.025)
    assert (low, high) == pytest.approx((min(share - 0.235967, exact[0]), max(share + 0.235967, exact[1])), abs=1e-5)


@pytest.mark.slow
def test_half_as_sure_is_not_idle() -> None:
    """Bands of 60 % are missed often: the test above can fail."""
    counts = below_plane(scrambled(2), 0.5).sum(axis=-1)
    bands = np.array([interval(c, EACH, 0.6) for c in counts])
    assert 0.55 < ((bands[:, 0] <= 0.5) & (bands[:, 1] >= 0.5)).mean() < 0.72


def test_all_or_none_is_as_of_independent_points() -> None:
    none, every = np.zeros(REPLICATES), np.full(REPLICATES, EACH)
    total = REPLICATES * EACH
    reach = 1 - 0.025 ** (1 / total)
    assert interval(none, EACH, 0.95) == pytest.approx((0.0, reach))
    assert interval(every, EACH, 0.95) == pytest.approx((1 - reach, 1.0))
    exact = binomtest(37, 100).proportion_ci(0.9, method="exact")
    assert clopper_pearson(37.0, 100.0, 0.05) == pytest.approx((exact.low, exact.high))
    assert clopper_pearson(2.5, 7.25, 0.05)[0] == pytest.approx(beta.ppf(0.05, 2.5, 5.75))


def test_that_all_replicates_agree_is_no_certainty() -> None:
    low, high = interval(np.full(REPLICATES, 8), EACH, 0.95)
    assert low < 0.495
    assert high > 0.505
    assert high - low < 0.06


def test_open_runs_could_be_either() -> None:
    """The band is that of both extremes, and reaches over all between."""
    inside, open_ = np.full(REPLICATES, 6) + np.arange(REPLICATES) % 2, np.full(REPLICATES, 4)
    low, high = band(inside, open_, EACH, 0.95)
    assert low == interval(inside, EACH, 0.95)[0]
    assert high == interval(inside + open_, EACH, 0.95)[1]
    assert high - low > 0.25 + 0.5 * np.ptp(interval(inside, EACH, 0.95))
    assert band(np.zeros(REPLICATES), np.full(REPLICATES, EACH), EACH, 0.95) == (0.0, 1.0)


def test_points_are_even_independent_and_the_same_again() -> None:
    drawn = points(512, 3, seed=3)
    assert drawn.shape == (REPLICATES, 32, 3)
    assert np.array_equal(drawn, points(512, 3, seed=3))
    assert not np.array_equal(drawn, points(512, 3, seed=4))
    for one in drawn:  # each 32nd of each axis has one point
        assert (np.sort((one * 32).astype(int), axis=0) == np.arange(32)[:, None]).all()
    assert len(np.unique(drawn[:, 0, 0])) == REPLICATES
    assert np.array_equal(points(16 * 24, 3, seed=3), drawn[:, :24])


def test_the_band_of_student_by_hand() -> None:
    """4 replicates of 32 points, of which 10, 12, 14, 16 are inside: 13 of 32 on average, variance of a count 20/3.

    t(0.975, 3) = 3.1824; of the mean the standard deviation is sqrt(20/3/4)/32 = 0.040344. They scatter as
    0.40625 0.59375/0.0016276 (1.95996/3.18245)^2 = 56.2 independent points, 22.8 of them inside. The band covers both.
    """
    low, high = interval(np.array([10, 12, 14, 16]), 32, 0.95)
    share, deviation, student = 13 / 32, math.sqrt(20 / 3 / 4) / 32, 3.182446
    number = share * (1 - share) / deviation**2 * (1.959964 / student) ** 2
    assert number == pytest.approx(56.21, abs=0.01)
    plain = share - student * deviation, share + student * deviation
    assert plain == pytest.approx((0.27786, 0.53464), abs=1e-5)
    assert low <= plain[0] + 1e-6
    assert high >= plain[1] - 1e-6
    exact = clopper_pearson(share * number, number, 0.025)
    assert (low, high) == pytest.approx((min(plain[0], exact[0]), max(plain[1], exact[1])), abs=1e-6)


def test_bounds_of_clopper_and_pearson_by_hand() -> None:
    """Of 2 with 1 inside: (1 - p)^2 = 0.975 below, p^2 = 0.975 above. Of 3 with none: (1 - p)^3 = 0.025."""
    assert clopper_pearson(1.0, 2.0, 0.025) == pytest.approx((1 - math.sqrt(0.975), math.sqrt(0.975)), rel=1e-12)
    assert clopper_pearson(0.0, 3.0, 0.025) == pytest.approx((0.0, 1 - 0.025 ** (1 / 3)), rel=1e-12)
    assert clopper_pearson(3.0, 3.0, 0.025) == pytest.approx((0.025 ** (1 / 3), 1.0), rel=1e-12)
