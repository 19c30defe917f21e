"""The life of a bearing by hand: a steady load, a load of two levels, and a rotation that reverses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.fatigue import BearingDuty, BearingRating
from wucht.fatigue.bearing_life import mean_over_time


@pytest.mark.parametrize(("p", "expected"), [(3.0, 1000.0), (10 / 3, 10 ** (10 / 3))])
def test_a_steady_load_by_hand(p: float, expected: float) -> None:
    """C/P = 10: 10^p million revolutions; at 1000 rpm a million takes 16.67 h."""
    rating = BearingRating(45e3, p)
    assert rating.revolutions(4.5e3) == pytest.approx(expected * 1e6, rel=1e-12)
    assert rating.hours(4.5e3, 1000.0) == pytest.approx(expected * 1e6 / 6e4, rel=1e-12) == rating.hours(4.5e3, -1000.0)
    assert rating.revolutions(45e3) == 1e6
    assert rating.revolutions(0.0) == rating.hours(0.0, 100.0) == rating.hours(1.0, 0.0) == math.inf


def steps(duty: BearingDuty, *levels: tuple[float, float, float]) -> BearingDuty:
    """Add spans of constant load: duration in s, force in N, speed in rad/s."""
    begin = duty.time
    for duration, force, speed in levels:
        time = begin + np.linspace(0.0, duration, 7)
        duty = duty.update(time, np.full(7, force), np.full(7, speed))
        begin += duration
    return duty


@pytest.mark.parametrize("p", [3.0, 10 / 3])
def test_two_levels_by_hand(p: float) -> None:
    """12 kN for 20 s at 50 rad/s and 3 kN for 30 s at 100 rad/s: revolutions are as 1 to 3, and the time is not what counts."""
    duty = steps(BearingDuty(p), (20.0, 12e3, 50.0), (30.0, 3e3, 100.0))
    load = (0.25 * 12e3**p + 0.75 * 3e3**p) ** (1 / p)
    assert duty.equivalent_load == pytest.approx(load, rel=1e-12)
    turns = 4000 / (2 * math.pi)
    assert duty.speed == pytest.approx(turns / 50 * 60, rel=1e-12)
    # Palmgren and Miner: of the revolutions of each level, the share that is endured at it.
    rating = BearingRating(60e3, p)
    damage = 0.25 * turns / rating.revolutions(12e3) + 0.75 * turns / rating.revolutions(3e3)
    assert duty.life(rating) == pytest.approx(50 / damage / 3600, rel=1e-12)


def test_what_does_not_turn_or_bears_nothing_has_no_life() -> None:
    still = steps(BearingDuty(3.0), (4.0, 100.0, 0.0))
    assert (still.equivalent_load, still.life(BearingRating(1e3)), still.speed) == (None, None, 0.0)
    assert (BearingDuty(3.0).equivalent_load, BearingDuty(3.0).speed) == (None, 0.0)
    idle = steps(BearingDuty(3.0), (4.0, 0.0, 10.0))
    assert (idle.equivalent_load, idle.life(BearingRating(1e3))) == (0.0, None)


def test_parts_of_a_motion_give_the_whole() -> None:
    """Cut anywhere, and counted between two times that are no samples."""
    time = np.linspace(0.0, 3.0, 3001)
    force, speed = 100 * (2 + np.sin(7 * time)), 20 * np.cos(1.1 * time)
    whole = BearingDuty(3.0, 0.7003, 2.3456).update(time, force, speed)
    split = BearingDuty(3.0, 0.7003, 2.3456)
    for a, b in ((0, 400), (400, 701), (701, 1800), (1800, 3000)):
        split = split.update(time[a : b + 1], force[a : b + 1], speed[a : b + 1])
    for key in ("time", "angle", "power"):
        assert getattr(split, key) == pytest.approx(getattr(whole, key), rel=1e-12)
    fine = np.linspace(0.7003, 2.3456, 200_001)
    turned, done = np.abs(20 * np.cos(1.1 * fine)), (100 * (2 + np.sin(7 * fine))) ** 3
    assert whole.time == pytest.approx(1.6453, rel=1e-12)
    assert whole.angle == pytest.approx(turned.mean() * 1.6453, rel=1e-4)
    assert whole.equivalent_load == pytest.approx(((turned * done).sum() / turned.sum()) ** (1 / 3), rel=1e-4)


def test_means_over_time() -> None:
    """Of uneven samples of a straight line, between times inside, and beyond the samples."""
    time = np.array([0.0, 1.0, 1.5, 4.0])
    assert mean_over_time(time, 2 * time, 0.5, 2.5) == pytest.approx(3.0)
    assert mean_over_time(time, 2 * time, -9.0, 9.0) == pytest.approx(4.0)
    assert mean_over_time(time, 2 * time, 2.0, 2.0) == 8.0
