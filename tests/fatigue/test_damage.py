"""Damage by hand, and by pyLife."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pylife.strength import Fatigue
from pylife.stress.collective import LoadCollective

from wucht.fatigue import BearingDuty, BearingRating
from wucht.fatigue.bearing_life import mean_over_time
from wucht.fatigue.counting import rainflow
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine, slope_below
from wucht.fatigue.load_counting import CountedLoad, LoadCounting

K, ND, SD = 5.0, 2e6, 100.0
RULES = ("original", "elementary", "haibach")


@pytest.mark.parametrize("miner", RULES)
def test_constant_amplitude_is_the_share_of_its_life(miner):
    line = WoehlerLine(K, ND, SD, slope_below(K, miner))
    history = np.array([150, -150] * 1000 + [150.0])
    damage = line.damages(rainflow(history)).sum()
    assert damage == pytest.approx(1000 / (ND * 1.5**-5), rel=1e-12)
    assert line.life(np.array([SD, 2 * SD])).tolist() == pytest.approx([ND, ND / 32])


def test_below_the_knee_the_rules_differ():
    at = np.array([50.0])
    lives = [float(WoehlerLine(K, ND, SD, slope_below(K, miner)).life(at)[0]) for miner in RULES]
    assert lives == pytest.approx([np.inf, ND * 2**5, ND * 2**9])


@pytest.mark.parametrize("miner", RULES)
def test_against_pylife(miner):
    assert issubclass(Fatigue, object) and LoadCollective.__name__ == "LoadCollective"  # they register the accessors
    cycles = rainflow(120 * np.random.default_rng(5).standard_normal(2000))
    collective = pd.DataFrame({"range": cycles.ranges, "mean": cycles.means, "cycles": cycles.counts})
    curve = pd.Series({"k_1": K, "ND": ND, "SD": SD}).fatigue
    expected = getattr(curve, f"miner_{miner}")().damage(collective.load_collective).to_numpy()
    found = WoehlerLine(K, ND, SD, slope_below(K, miner)).damages(cycles)
    assert found == pytest.approx(expected, rel=1e-12)
    assert found.sum() > 0 and (found == 0).any() == (miner == "original")


LINE = WoehlerLine(k=5, ND=1e3, SD=2.0, k2=9)
VALUES = st.lists(st.integers(-5, 5).map(float), max_size=60)


@settings(max_examples=60, deadline=None)
@given(pieces=st.lists(VALUES, max_size=5))
def test_in_pieces_and_at_once(pieces):
    damage = AccumulatedDamage(LINE)
    for i, piece in enumerate(pieces):
        damage = damage.update(np.array(piece))
        history = np.array([x for one in pieces[: i + 1] for x in one])
        assert damage.total == pytest.approx(LINE.damages(rainflow(history)).sum(), rel=1e-12)
        assert len(damage.open_points) <= 2 * 11  # of eleven values: ranges that grow, then ranges that shrink


def levels(values: list[float], width: float | None, reference: float | None = None) -> np.ndarray:
    return LoadCounting("level-crossing", reference=reference, class_width=width).count(np.array(values)).levels


def test_levels_are_at_multiples_of_the_width_from_the_reference_or_in_the_middle_of_a_hundred_classes() -> None:
    assert levels([-1.1, 2.4, 0.4], 0.5) == pytest.approx([-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0])
    assert levels([-1.1, 2.4, 0.4], 1.0, 0.3) == pytest.approx([-0.7, 0.3, 1.3, 2.3])
    classes = levels([2.0, 12.0, 5.0], None)
    assert len(classes) == 100 and classes[[0, 1, -1]] == pytest.approx([2.05, 2.15, 11.95])
    assert levels([2.0, 12.0, 5.0], 4.0).tolist() == [4.0, 8.0, 12.0], "an end that is a multiple belongs to them"
    assert levels([2.0, 12.0, 5.0], 4.0, 1.0).tolist() == [5.0, 9.0]
    assert levels([2.0, 12.0, 5.0], 5.0, 2.0).tolist() == [2.0, 7.0, 12.0]


def test_no_level_is_lost_by_rounding() -> None:
    """0.3/0.1 is a little less than 3, and 3 times 0.1 a little more than 0.3: the level at the end is crossed all the same."""
    counted = LoadCounting("level-crossing", class_width=0.1).count(np.array([0.0, 0.3, 0.0]))
    assert counted.levels == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert counted.crossings.tolist() == [0, 1, 1, 1]
    assert levels([0.0, -0.3, 0.0], 0.1) == pytest.approx([-0.3, -0.2, -0.1, 0.0])


def test_more_than_a_thousand_ranges_get_a_hundred_classes() -> None:
    def counted(number: int, width: float | None = None) -> CountedLoad:
        values = np.arange(1, number + 2) * np.resize([1.0, -1.0], number + 1)
        return LoadCounting(class_width=width).count(values)

    few, many = counted(1000), counted(1001)
    assert few.class_width is None and len(few.rows.ranges) == 1000
    assert many.class_width == pytest.approx(2003 / 100) and len(many.rows.ranges) <= 101
    assert counted(1001, 400.0).class_width == 400.0 and len(counted(1001, 400.0).rows.ranges) == 6


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
