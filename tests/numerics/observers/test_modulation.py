"""A modulated speed, of known period and range."""

import numpy as np
import pytest

from wucht.numerics.observers.modulation import modulation
from wucht.numerics.observers.records import TurnRecord
from wucht.numerics.observers.turns import MARKS_PER_TURN, Samples

PERIOD, W = 7.3, 50.0  # 58 turns a period: an average over a turn is 5e-4 from the speed in its middle, of its range


def recorded(shape, until=100.0, period=PERIOD, sense=1):
    """A speed around W with the modulation ``shape(2 pi t/period, t)``; the angle is its integral."""
    t = np.arange(0, until, 2 * np.pi / W / 15.3)
    speed = W + shape(2 * np.pi * t / period, t)
    angle = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(t))])
    return TurnRecord(0).update(Samples.of(t, (sense * angle, sense * speed)))


def sine(p, t):
    return 5 * np.sin(p)


def of_cycles(*periods):
    """One sine after the other, each of its own period; three quarters of one more at the end."""
    ends = np.cumsum([0.0, *periods, periods[-1]])
    until = ends[-1] - 0.25 * periods[-1]
    return recorded(lambda _, t: 5 * np.sin(2 * np.pi * np.interp(t, ends, np.arange(len(ends)))), until)


@pytest.mark.parametrize(
    "shape",
    [
        sine,
        lambda p, t: 5 * np.sin(p) + 2 * np.sin(2 * p + 1) + 0.5 * np.sin(9 * p),
        lambda p, t: 5 * np.exp(-4 * (1 - np.cos(p))),
    ],
    ids=["sine", "harmonics", "pulses"],
)
@pytest.mark.parametrize("sense", [1, -1])
def test_period_range_and_angle_of_a_modulation(shape, sense):
    found = modulation(recorded(shape, sense=sense), 0.01)
    phase = np.linspace(0, 2 * np.pi, 100_000)
    assert found.period == pytest.approx(PERIOD, rel=1e-4)
    assert found.period_angle == pytest.approx((W + shape(phase, 0)[:-1].mean()) * PERIOD, rel=1e-4)
    assert (found.low, found.high) == pytest.approx((W + shape(phase, 0).min(), W + shape(phase, 0).max()), abs=0.05)
    assert found.regular
    assert found.borders.shape == (found.groups.shape[1] + 1,)
    assert (found.window.time[-1] - found.window.time[0]) / PERIOD == pytest.approx(3, abs=0.05)
    assert found.groups == pytest.approx(
        np.tile([[found.period_angle / PERIOD], [found.low], [found.high]], found.groups.shape[1]), rel=1e-4
    )


@pytest.mark.parametrize(("cycles", "groups"), [(3, 3), (5, 5), (6, 3), (13, 4)])
def test_cycles_are_put_into_up_to_five_equal_groups(cycles, groups):
    """Of those in the last half of the record; of cycles left over the first ones are left out."""
    found = modulation(recorded(sine, (2 * cycles + 1.5) * PERIOD), 0.01)
    assert found.cycles == cycles
    assert found.groups.shape == (3, groups)
    each = -(-cycles // 5)
    assert np.diff(found.borders) == pytest.approx(each * PERIOD, rel=1e-4)
    assert found.span == pytest.approx(each * PERIOD, rel=1e-4)
    half_a_turn = np.pi / W  # averages have the time at the end of their turn, or of the last of two
    assert found.borders[-1] == pytest.approx((2 * cycles + 1) * PERIOD + half_a_turn, abs=0.01)


def test_groups_tell_whether_a_modulation_lasts():
    """Of amplitude 5 exp(-t/100): the extremes of a cycle lie a quarter and three quarters after its begin."""
    found = modulation(recorded(lambda p, t: 5 * np.exp(-t / 100) * np.sin(p), 21.5 * PERIOD), 0.01)
    assert found.cycles == 10
    assert np.diff(found.borders) == pytest.approx(2 * PERIOD, rel=2e-3)
    peaks = 5 * np.exp(-PERIOD * np.add.outer(np.arange(11, 21), [0.75, 0.25]) / 100)
    assert found.groups[1:] == pytest.approx(W + peaks.reshape(5, 2, 2).mean(axis=1).T * [[-1], [1]], abs=0.01)
    last = peaks[-1]
    assert (found.low, found.high) == pytest.approx((W - last[0], W + last[1]), abs=0.02)


def test_at_least_three_cycles_in_the_last_four_fifths():
    """Upward crossings at whole multiples of the period, of which four are needed."""
    assert modulation(recorded(sine, 3.4 * PERIOD), 0.01) is None
    found = modulation(recorded(sine, 4.4 * PERIOD), 0.01)
    assert found.cycles == 3
    assert found.period == pytest.approx(PERIOD, rel=1e-4)
    assert modulation(recorded(sine, 4.75 * PERIOD), 0.01) is None
    assert modulation(recorded(sine, 6.4 * PERIOD), 0.01).cycles == 4
    assert modulation(recorded(sine, 7.4 * PERIOD), 0.01).cycles == 3


@pytest.mark.parametrize("longer", [1.04, 1 / 1.04])
def test_hardly_different_cycles_are_regular(longer):
    found = modulation(of_cycles(*[PERIOD] * 8, longer * PERIOD), 0.01)
    assert found.regular
    assert found.period == pytest.approx((2 + longer) / 3 * PERIOD, rel=1e-3)


@pytest.mark.parametrize("longer", [1.07, 1 / 1.07])
def test_different_cycles_are_irregular_and_all_of_them_count(longer):
    found = modulation(of_cycles(*[PERIOD] * 8, longer * PERIOD), 0.01)
    assert not found.regular
    assert found.period == pytest.approx((found.cycles - 1 + longer) / found.cycles * PERIOD, rel=1e-3)
    assert (found.window.time[-1] - found.window.time[0]) / found.period == pytest.approx(found.cycles, abs=0.05)


def test_the_threshold_is_of_the_range_in_the_last_quarter():
    record = recorded(sine)
    assert modulation(record, 9.9) is not None
    assert modulation(record, 10.1) is None
    ending = recorded(lambda p, t: np.where(t < 10 * PERIOD, 5, 1e-3) * np.sin(p), 13.6 * PERIOD)
    assert modulation(ending, 0.1) is None
    assert modulation(ending, 1e-3) is not None


@pytest.mark.parametrize("share", [0.2])
def test_ripple_that_crosses_the_middle_does_not_break_the_count(share):
    """Hysteresis: the speed rises through the middle several times within each period."""
    found = modulation(recorded(lambda p, t: 5 * np.sin(p) + 5 * share * np.sin(17 * p)), 0.01)
    assert found.period == pytest.approx(PERIOD, rel=1e-3)
    assert found.regular


def long_record(averages_a_cycle, averages=2**17 - 200):
    """Samples at marks' distance; the angle is that of the sine integrated."""
    period = averages_a_cycle * 2 * np.pi / MARKS_PER_TURN  # of speed 1
    t = np.arange(averages + MARKS_PER_TURN + 1) * 2 * np.pi / MARKS_PER_TURN
    p = 2 * np.pi / period
    angle, speed = t - 0.1 / p * np.cos(p * t), 1 + 0.1 * np.sin(p * t)
    return TurnRecord(0).update(Samples.of(t, (angle, speed))), period


@pytest.mark.parametrize(("averages_a_cycle", "size"), [(16 * 8.7, 16), (16 * 7.3, 8), (20, 2)])
def test_fast_cycles_of_a_long_record_are_found_at_its_end_in_more_detail(averages_a_cycle, size):
    """The last half of nearly 2^17 averages is known in sixteens; a cycle should have eight blocks."""
    record, period = long_record(averages_a_cycle)
    found = modulation(record, 0.01)
    assert found.window.size == size
    assert found.period == pytest.approx(period, rel=2e-2 if averages_a_cycle < 100 else 2e-3)


@pytest.mark.parametrize("averages_a_cycle", [16.2])
def test_cycles_as_long_as_a_block_are_no_slow_ones(averages_a_cycle):
    """Means over blocks beat: they seem to repeat after eighty blocks."""
    record, period = long_record(averages_a_cycle)
    assert modulation(record, 0.01).period == pytest.approx(period, rel=0.05)
