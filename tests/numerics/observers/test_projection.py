"""Where a signal goes, of signals whose future is known."""

import math

import numpy as np
import pytest

from wucht.numerics.observers.projection import (
    AHEAD,
    Course,
    project,
    project_signals,
    scatters,
    trend,
)

LIMIT = 7.0


def geometric(ratio, height=1.0, count=5):
    """An approach to the limit, or away from there, that is that many times nearer after each window."""
    return LIMIT + height * ratio ** np.arange(count)


def after(*changes):
    """Means that change so."""
    return np.cumsum([LIMIT, *changes])


@pytest.mark.parametrize("ratio", [0.01, 0.97])
@pytest.mark.parametrize("height", [1.0, -3.0])
def test_an_approach_half_as_far_again_as_its_limit(ratio, height):
    means = geometric(ratio, height)
    there = project(means)
    assert there.course is Course.APPROACHING
    assert there.windows == pytest.approx(-1 / math.log(ratio), rel=1e-9)
    assert there.last == means[-1]
    beyond = LIMIT - 0.5 * height * ratio**4
    assert (there.low, there.high) == pytest.approx(tuple(sorted([means[-1], beyond])), rel=1e-12)


@pytest.mark.parametrize(("first", "observed"), [(0.68, True), (0.72, False)])
def test_a_decay_is_observed_whose_rates_differ_by_no_more_than_twice(first, observed):
    """The slowest of them tells how long it takes; 0.7 is the root of 0.49."""
    there = project(after(1, first, first * 0.49, first * 0.49 * 0.49))
    assert there.course is Course.APPROACHING
    assert there.windows == (pytest.approx(-1 / math.log(first)) if observed else math.inf)


@pytest.mark.parametrize(("ratio", "course"), [(0.975, Course.APPROACHING), (0.985, Course.DRIFTING)])
def test_an_approach_that_hardly_contracts_is_a_drift(ratio, course):
    assert project(geometric(ratio)).course is course


@pytest.mark.parametrize("ratio", [-0.3, -0.8])
def test_an_approach_to_and_fro_stays_around_its_limit(ratio):
    future = geometric(ratio, count=40)
    there = project(future[:5])
    assert there.course is Course.APPROACHING
    assert there.low <= future[4:].min()
    assert there.high >= future[4:].max()


def test_a_fluctuation_stays_in_its_range_widened():
    means = after(1, -2, 2.5, -1)
    there = project(means)
    assert there.course is Course.STATIONARY
    assert (there.low, there.high) == (LIMIT - 1 - 0.25 * 2.5, LIMIT + 1.5 + 0.25 * 2.5)
    assert project(means, wider=2.0).width == 5 * 2.5
    assert project(means, wider=0.0).width == 2.5


def test_a_drift_goes_on_as_far_as_is_looked_ahead():
    there = project(after(2, 2, 2, 2), ahead=30)
    assert there.course is Course.DRIFTING
    assert (there.last, there.low, there.high) == (LIMIT + 8, LIMIT + 8, LIMIT + 8 + 60)
    assert there.windows == math.inf
    assert project(after(-2, -2, -2, -2), ahead=30).low == LIMIT - 8 - 60
    assert project(after(2, 2)).high == LIMIT + 4 + 2 * 150
    assert AHEAD == 150


@pytest.mark.parametrize(("share", "course"), [(0.96, Course.DRIFTING), (0.94, Course.STATIONARY)])
def test_a_drift_hardly_turns_back(share, course):
    """Three changes of 1 and one of -b: the whole change is that share of their sum."""
    back = 3 * (1 - share) / (1 + share)
    assert project(after(1, -back, 1, 1)).course is course
    assert project(after(-1, back, -1, -1)).course is course


@pytest.mark.parametrize("rate", [1e-3, 0.5])
def test_growth_goes_on(rate):
    ahead = 12
    there = project(np.exp(rate * np.arange(5)), ahead=ahead)
    assert there.course is Course.DRIFTING
    assert there.windows == pytest.approx(1 / rate, rel=1e-9)
    assert (there.low, there.high) == pytest.approx((math.exp(4 * rate), math.exp((4 + ahead) * rate)), rel=1e-9)


@pytest.mark.parametrize(("rounding", "course"), [(1.01e-6, Course.STATIONARY), (0.99e-6, Course.DRIFTING)])
def test_changes_by_rounding_are_none(rounding, course):
    """In all by 1e-6; each is less."""
    there = project(LIMIT + np.array([0.0, 1e-6]), rounding=rounding)
    assert there.course is course
    assert (there.width <= rounding) == (course is Course.STATIONARY)


@pytest.mark.parametrize(
    ("means", "way"),
    [
        ([1, 2, 3, 4, 5], 1),
        ([2, 1, 4, 3, 5], 1),  # 8 of 10 pairs rise
        ([2, 1, 3, 3, 5], 1),  # 8 of 10, and one is alike
        ([2, 3, 1, 5, 4], 0),  # 7 of 10
        ([2, 1, 3, 3, 3], 0),  # 6 of 10
        ([1, 2, 1, 2, 1], 0),
        ([1, 1, 1, 1, 1], 0),
        ([1, 2], 1),
    ],
)
def test_a_trend_is_a_rise_or_a_fall_in_four_fifths_of_all_pairs(means, way):
    assert trend(np.array(means, float)) == way
    assert trend(-np.array(means, float)) == -way
    assert trend(np.array(means[::-1], float)) == -way


@pytest.mark.parametrize("rounding", [0.0, 1e-3])
def test_many_at_once_are_as_each_alone(rounding):
    random = np.random.default_rng(4)
    steps = np.arange(6.0)[:, None]
    kinds = [
        3 + 0.1 * random.uniform(0.1, 0.97, 40) ** steps,  # approaches, one way and to and fro
        3 + 0.1 * (-random.uniform(0.1, 0.97, 40)) ** steps,
        1 + 1e-4 * random.uniform(1.0, 3.0, 40) ** steps,  # growth
        2 - 0.01 * steps + 1e-4 * random.normal(size=(6, 40)),  # drifts
        5 + 0.1 * random.normal(size=(6, 40)),
        np.full((6, 2), 7.0) + 1e-4 * random.normal(size=(6, 2)),
        np.full((6, 1), 7.0),
    ]
    means = np.concatenate(kinds, axis=1)
    alone = np.array([project(m, 20.0, rounding).bounds for m in means.T]).T
    np.testing.assert_allclose(project_signals(means, 20.0, rounding).bounds, alone, rtol=1e-14)
    assert {project(m, 20.0, rounding).course for m in means.T} == set(Course)


def test_what_fluctuates_by_chance_scatters_and_what_takes_a_course_does_not():
    """Random numbers; the same with a course of eight times their scatter; an oscillation that grows or decays."""
    time, half = np.arange(1600) / 1600, slice(800, None)
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(size=1600)
        of_blocks = noise[half].reshape(20, -1).max(axis=1).std()
        assert scatters(noise)
        assert not scatters(noise + 16 * of_blocks * time)
        assert not scatters(noise - 16 * of_blocks * time)
    for cycles in (3.0, 7.5, 20.0, 33.3, 80.0, 160.0):
        for growth in (-1.5, -0.3, 0.3, 1.5):
            assert not scatters(np.exp(growth * time) * (1 + 0.6 * np.sin(2 * np.pi * cycles * time)))


def test_a_few_samples_do_not_tell():
    assert not scatters(np.random.default_rng(0).normal(size=159))
