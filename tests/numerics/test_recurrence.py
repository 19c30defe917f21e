"""Whether the end of a run repeats itself: known periods and turns, and motions that do not."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.numerics.recurrence import is_at_rest, recurrence

TIMES = np.linspace(0.0, 100.0, 20_001)
PLAIN = np.array([False, False])


def test_an_angle_that_winds_backwards_twice() -> None:
    """In one period of the second state the first falls by two turns."""
    states = np.array([-2 * TIMES + 0.3 * np.sin(TIMES), np.cos(TIMES)])
    found = recurrence(TIMES, states, np.array([True, False]))
    assert found is not None
    assert found.period == pytest.approx(2 * np.pi, rel=1e-4)
    assert found.turns.tolist() == [-2, 0]


@pytest.mark.parametrize(("decay", "settled"), [(3.0, True), (0.02, False)])
def test_only_once_it_has_settled(decay: float, settled: bool) -> None:
    states = np.array([np.sin(TIMES) * (1 + np.exp(-decay * TIMES)), np.cos(TIMES)])
    drifting = recurrence(TIMES, states, PLAIN)
    assert (drifting is not None and abs(drifting.period - 2 * np.pi) < 1e-4) == settled


def test_a_motion_that_never_returns() -> None:
    assert recurrence(TIMES, np.array([np.sin(TIMES), np.sin(np.sqrt(2) * TIMES)]), PLAIN) is None
    assert recurrence(TIMES, np.array([np.exp(-TIMES), TIMES]), PLAIN) is None
    assert recurrence(TIMES, np.ones((2, len(TIMES))), PLAIN) is None, "rest is no orbit"


@pytest.mark.parametrize("size", [1e-3, 1.0, 2.5])
def test_the_period_of_a_swing_of_an_angle(size: float) -> None:
    """One that goes through less than half a turn, or more; beside a state that repeats half as often."""
    states = np.array([size * np.sin(2 * TIMES), 0.01 * np.cos(TIMES)])
    found = recurrence(TIMES, states, np.array([True, False]))
    assert found is not None
    assert found.period == pytest.approx(2 * np.pi, rel=1e-4) and found.turns.tolist() == [0, 0]


def test_a_return_between_samples_of_unlike_lengths() -> None:
    """A parabola through three of them with even steps before and after: the last return is two periods back."""
    times = np.concatenate([np.linspace(0.0, 40.0, 401)[:-1], np.linspace(40.0, 100.0, 6001)])
    wave = np.array([np.sin(times), np.cos(times)])
    found = recurrence(times, wave, PLAIN)
    assert found is not None and found.period == pytest.approx(2 * np.pi, rel=1e-5)


def test_at_rest_is_a_millionth_of_a_state_or_of_one() -> None:
    """Of each state by its own size."""
    for state, rest in (
        ([0.0, 0.99e-6], True), ([0.0, 1.01e-6], False), ([0.5, 0.5 - 0.99e-6], True), ([-1e3, -1e3 + 0.99e-3], True),
        ([-1e3, -1e3 + 1.01e-3], False), ([2.0, 2.0 + 1.9e-6], True), ([2.0, 2.0 + 2.1e-6], False),
    ):  # fmt: skip
        assert is_at_rest(np.array([state])) is rest
        assert is_at_rest(np.array([state, [1e6, 1e6]])) is rest
