"""A modulated speed, of known period and range."""

import numpy as np
import pytest

from wucht.numerics.observers.modulation import _is_resolved, _modulation_from_cycles, _upward_crossings, modulation
from wucht.numerics.observers.records import Blocks, TurnRecord
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


@pytest.mark.parametrize(("cycles", "groups"), [(3, 3), (5, 5), (6, 3), (10, 5), (11, 3), (12, 4), (13, 4)])
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


def test_what_was_in_the_first_half_does_not_matter():
    """Twice as fast until then."""
    found = modulation(recorded(lambda p, t: 5 * np.sin(np.where(t < 10 * PERIOD, 2 * p, p)), 20.4 * PERIOD), 0.01)
    assert found.regular
    assert found.cycles == 9
    assert np.diff(found.borders) == pytest.approx(2 * PERIOD, rel=1e-4)


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


def test_the_range_of_irregular_cycles_is_that_of_all():
    """Larger ones of long period before smaller ones."""

    def shape(p, t):
        early = t < 17 * PERIOD
        return np.where(early, 5, 4) * np.sin(np.where(early, p, 2 * p))

    found = modulation(recorded(shape, 20.3 * PERIOD), 0.01)
    assert found.regular
    assert found.high == pytest.approx(W + 4, abs=0.02)
    found = modulation(recorded(shape, 17.8 * PERIOD), 0.01)
    assert not found.regular
    assert found.high == pytest.approx(W + 5, abs=0.02)


def test_the_threshold_is_of_the_range_in_the_last_quarter():
    record = recorded(sine)
    assert modulation(record, 9.9) is not None
    assert modulation(record, 10.1) is None
    ending = recorded(lambda p, t: np.where(t < 10 * PERIOD, 5, 1e-3) * np.sin(p), 13.6 * PERIOD)
    assert modulation(ending, 0.1) is None
    assert modulation(ending, 1e-3) is not None


def test_no_modulation():
    """An approach without one, a constant, hardly any turns, none."""
    assert modulation(recorded(lambda p, t: 10 * np.exp(-t / 30)), 0.01) is None
    assert modulation(recorded(lambda p, t: 0 * t), 0.01) is None
    assert modulation(recorded(sine, 0.2), 0.0) is None
    assert modulation(recorded(sine, 0.01), 0.0) is None


@pytest.mark.parametrize("share", [0.05, 0.2])
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


@pytest.mark.parametrize(
    ("averages_a_cycle", "size"), [(16 * 100, 16), (16 * 8.7, 16), (16 * 7.3, 8), (8 * 8.7, 8), (8 * 7.3, 4), (20, 2)]
)
def test_fast_cycles_of_a_long_record_are_found_at_its_end_in_more_detail(averages_a_cycle, size):
    """The last half of nearly 2^17 averages is known in sixteens; a cycle should have eight blocks."""
    record, period = long_record(averages_a_cycle)
    found = modulation(record, 0.01)
    assert found.window.size == size
    assert found.period == pytest.approx(period, rel=2e-2 if averages_a_cycle < 100 else 2e-3)


@pytest.mark.parametrize("averages_a_cycle", [16.2, 15.8])
def test_cycles_as_long_as_a_block_are_no_slow_ones(averages_a_cycle):
    """Means over blocks beat: they seem to repeat after eighty blocks."""
    record, period = long_record(averages_a_cycle)
    assert modulation(record, 0.01).period == pytest.approx(period, rel=0.05)


def blocks(speed, width=0.0, size=1, time=None, sense=1):
    """Of a speed; the turns within a block are up to ``width`` slower and twice as much faster."""
    speed = np.asarray(speed, float)
    n, t = len(speed), np.arange(len(speed)) * 2.0 if time is None else time
    none, many = np.zeros(n), np.zeros((0, n))
    return Blocks(
        size, sense, t, sense * 10 * t, many, speed, speed - width, speed + 2 * width, many, many.astype(complex),
        none, none, none, none, none,
    )  # fmt: skip


def test_the_range_of_a_modulation_is_that_of_single_turns():
    """Of blocks of several turns their extremes count, in the last cycle and in each group."""
    speed = 10 + np.array([-1, 1, -1, 1, -1, 1, -1, 1, -2, 3, -1, 1])
    crossings = np.array([0.5, 2.5, 4.5, 6.5, 8.5])
    found = _modulation_from_cycles(blocks(speed, 0.25), crossings)
    assert found.regular and found.cycles == 4
    assert (found.low, found.high) == (7.75, 11.5) and found.period == 4.0 and found.period_angle == 40.0
    assert found.groups[:, 0].tolist() == [10.0, 8.75, 11.5] and found.groups[:, -1].tolist() == [10.0, 7.75, 11.5]
    assert found.borders.tolist() == [1.0, 5.0, 9.0, 13.0, 17.0]
    assert found.window.time.tolist() == [4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0]
    backwards = _modulation_from_cycles(blocks(speed, 0.25, sense=-1), crossings)
    assert backwards.period_angle == 40.0 and backwards.groups[0].tolist() == [10.0] * 4


def test_cycles_that_are_longer_or_shorter_by_a_twentieth_are_irregular():
    """Of the last three, against the last one; then all of them count."""
    speed = np.full(40, 10.0)
    for last, regular in ((4.2, True), (4.22, False), (3.82, True), (3.8, False)):
        crossings = np.cumsum([0.5, 6.0, 4.0, 4.0, last])
        found = _modulation_from_cycles(blocks(speed), crossings)
        assert found.regular is regular
        assert found.period == pytest.approx(2 * ((8 + last) / 3 if regular else (14 + last) / 4))
        assert len(found.window.time) == (int(crossings[-1]) - int(crossings[1 if regular else 0]) + 1)


def test_blocks_that_are_short_against_the_cycles():
    """Eight blocks a cycle at least, and their ranges below half of the whole range; single averages always."""
    speed = 10 + np.sin(np.arange(40.0))
    assert _is_resolved(blocks(speed, size=1), np.array([0.0, 2.0]))
    assert _is_resolved(blocks(speed, 0.1, size=2), np.array([0.0, 8.0, 17.0]))
    assert not _is_resolved(blocks(speed, 0.1, size=2), np.array([0.0, 7.9, 17.0]))
    level = np.where(np.arange(40) % 2, 1.0, 0.0)  # the whole range is 1 + 3 of the width
    assert _is_resolved(blocks(level, 0.32, size=2), np.array([0.0, 9.0]))
    assert not _is_resolved(blocks(level, 0.34, size=2), np.array([0.0, 9.0]))


def test_a_speed_that_rises_through_its_middle_from_far_below_to_far_above():
    """A quarter of the range below and above the middle of 5 to 15, at the last change of sign between; falls do not count."""
    speed = [5, 9.9, 10.5, 9.5, 10.5, 15, 9, 5, 12, 8, 13, 15, 5, 6, 11, 9, 5, 15]
    found = _upward_crossings(blocks(speed))
    assert found == pytest.approx([3.5, 9.4, 16.5])
    assert len(_upward_crossings(blocks([10.0, 10.0, 10.0]))) == 0 and len(_upward_crossings(blocks([15, 15, 10, 5, 5]))) == 0
