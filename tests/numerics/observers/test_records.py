"""A record of any length in bounded memory."""

from dataclasses import replace

import numpy as np
import pytest

from wucht.numerics.observers.records import HIGH, LAST, LEVEL_BLOCKS, LOW, MEAN, Pyramid, SpanRecord, TurnRecord
from wucht.numerics.observers.turns import MARKS_PER_TURN, Samples

ALL = Pyramid((LAST, LOW, HIGH, MEAN))


def drawn(count, seed=0):
    """The same integers in each row: sums of them are exact."""
    return np.tile(np.random.default_rng(seed).integers(-1000, 1000, count).astype(float), (4, 1))


def test_millions_of_blocks_are_kept_in_few():
    record, ahead = ALL, drawn(100_003)
    for _ in range(50):
        record = record.update(ahead)
    assert record.count == 5_000_150
    assert [level.shape[1] for level in record.levels[:-1]] == [LEVEL_BLOCKS] * 11
    assert record.levels[-1].shape == (4, 5_000_150 // 2**11)
    assert LEVEL_BLOCKS / 2 <= record.levels[-1].shape[1] <= LEVEL_BLOCKS


def test_a_share_is_in_the_finest_blocks_that_reach_back():
    """Of 2^16 blocks the last 2^12 are known one by one, twice as many in pairs, all of them by sixteens."""
    record = ALL.update(np.tile(np.arange(2.0**16), (4, 1)))
    for share, size in [(2**-4, 1), (2**-3.99, 2), (2**-3, 2), (2**-2.99, 4), (0.5, 8), (0.51, 16), (1.0, 16)]:
        values, found = record.last(share)
        assert found == size
        assert values.shape[1] == round(share * 2**16 / size)
        assert values[0, -1] == 2**16 - 1
        assert values[1, 0] == pytest.approx((1 - share) * 2**16, abs=size)
    assert record.last(0.0)[0].shape[1] == 1


def swinging(t):
    """phi = cos t, and a follower that is of no interest."""
    return Samples.of(t, (np.cos(t), -np.sin(t)), (5 * t, np.full_like(t, 5.0)))


def test_what_a_span_has():
    """Spans (0, 1], (1, 2], (2, 2.5]: the angle's cubic reaches 2, between samples, at s = 1/2 of the interval to 2."""
    samples = Samples.of(
        np.array([0.0, 0.5, 1.0, 2.0, 2.5]),
        (np.array([0.0, 3.0, 1.0, 1.0, -1.0]), np.array([0.0, 0.0, 4.0, -4.0, 0.0])),
    )
    spans = SpanRecord(1.0).update(samples).last(1.0)
    assert spans.time.tolist() == [1.0, 2.0, 2.5]
    assert spans.angle.tolist() == [1.0, 1.0, -1.0]
    assert spans.greatest_angle[[0, 1]] == pytest.approx([3.0, 2.0], rel=1e-15)
    assert spans.least_angle.tolist()[1:] == [1.0, -1.0]
    assert spans.least_speed.tolist() == [0.0, -4.0, -4.0]
    assert spans.greatest_speed.tolist() == [4.0, 4.0, 0.0]


def greatest_cosine(begin, end):
    """The greatest value of cos between."""
    peaks = np.floor(end / (2 * np.pi)) > np.floor(begin / (2 * np.pi))
    return np.where(peaks, 1.0, np.maximum(np.cos(begin), np.cos(end)))


@pytest.mark.parametrize("k", [3, 4])
def test_extremes_of_the_angle_are_of_fourth_order(k):
    """Six samples a span, on its borders; of the speed only samples are seen."""
    step = 2.0**-k
    spans = SpanRecord(6 * step).update(swinging(np.arange(0, 300, step))).last(1.0)
    begin, end = np.append(0, spans.time[:-1]), spans.time
    for found, exact in (
        (spans.greatest_angle, greatest_cosine(begin, end)),
        (-spans.least_angle, greatest_cosine(begin + np.pi, end + np.pi)),
    ):
        assert np.abs(found - exact).max() == pytest.approx(step**4 / 384, rel=0.05)
    for found, exact in (
        (spans.greatest_speed, greatest_cosine(begin + np.pi / 2, end + np.pi / 2)),
        (-spans.least_speed, greatest_cosine(begin - np.pi / 2, end - np.pi / 2)),
    ):
        assert 0.9 < np.abs(found - exact).max() / (step**2 / 8) < 1.0


def test_a_long_motion_is_bounded():
    record = SpanRecord(0.01)
    for begin in range(20):
        record = record.update(swinging(np.linspace(10 * begin, 10 * (begin + 1), 4001)))
    assert [level.shape[1] for level in record.pyramid.levels] == [
        LEVEL_BLOCKS,
        LEVEL_BLOCKS,
        LEVEL_BLOCKS,
        record.pyramid.count // 8,
    ]
    spans = record.last(1.0)
    assert len(spans.time) <= LEVEL_BLOCKS + 1
    assert spans.time[-1] == 200
    assert spans.time[0] == pytest.approx(0.08, abs=0.005)
    assert record.last(0.5).time[0] == pytest.approx(100, abs=0.1)


W, TURN = 3.0, 2 * np.pi / 3.0


def rippled(count, samples_a_turn=200.3, sense=1):
    """A leader with strong ripple at its own frequency, one that keeps to it at a distance that varies, one that is slower."""
    t = np.arange(int(count * samples_a_turn) + 2) * TURN / samples_a_turn
    leader = W * t + 0.4 * np.sin(W * t), W + 0.4 * W * np.cos(W * t)
    locked = W * t + 1 + 0.3 * np.cos(2 * W * t), W - 0.6 * W * np.sin(2 * W * t)
    slower = 2 / 3 * W * t + 0.3 * np.sin(W * t / 3), 2 / 3 * W + 0.1 * W * np.cos(W * t / 3)
    return Samples.of(t, *((sense * angle, sense * speed) for angle, speed in (leader, locked, slower)))


def recorded(samples, others=2, weights=()):
    return TurnRecord(others, weights).update(samples)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("share", [0.31, 1.0])
def test_mean_speeds_over_whole_turns_are_exact(share, sense):
    """Positive in the sense of turning. The slowest body repeats its motion after three turns."""
    blocks = recorded(rippled(120, sense=sense)).whole_turns(share)
    assert blocks.sense == sense
    assert blocks.mean_speeds[:2] == pytest.approx([W, W], rel=1e-9)
    turns = (blocks.time[-1] - blocks.time[0]) / TURN
    assert turns == pytest.approx(round(turns), abs=1e-8)
    assert turns == pytest.approx(share * 120, abs=2.0)


@pytest.mark.parametrize("averages", [1, MARKS_PER_TURN, 2 * MARKS_PER_TURN + 1])
def test_short_records_are_in_whole_turns_too(averages):
    """Of less than two turns there is one."""
    samples = rippled(5)
    record = recorded(samples.part(samples.angles[0] < (averages + MARKS_PER_TURN + 0.5) * 2 * np.pi / MARKS_PER_TURN))
    assert record.pyramid.count == averages
    assert record.whole_turns(1.0).mean_speeds[:2] == pytest.approx([W, W], rel=1e-4)
    assert record.turns == averages / MARKS_PER_TURN


def test_a_modulation_that_is_cut_does_not_count_in_smooth_means():
    """A modulation by a fifth whose period is a tenth of the record's length and a bit."""
    until, p = 2000.0, 2 * np.pi / 187.0
    t = np.linspace(0, until, 40_001)
    leader = W * t - 0.2 * W / p * np.cos(p * t), W + 0.2 * W * np.sin(p * t)
    follower = 2 * t + 0.3 / p * np.sin(p * t), 2 + 0.3 * np.cos(p * t)
    blocks = recorded(Samples.of(t, leader, follower), 1).last(1.0)
    assert blocks.smooth_mean_speeds == pytest.approx([W, 2.0], rel=2e-4)
    assert np.abs(blocks.mean_speeds / [W, 2.0] - 1).max() > 3e-3


def test_the_weighted_sum_of_phases_and_the_distance():
    """|1 + 0.5 exp(i a) + 0.3i|, where a follower is ahead by a, slowly changing; r^2 = 4 + 2 cos(t/50)."""
    t = np.linspace(0, 2000, 60_001)
    ahead, slope = 1 + np.sin(t / 200), np.cos(t / 200) / 200
    samples = Samples.of(t, (t, np.ones_like(t)), (t + ahead, 1 + slope), (t + np.pi / 2, np.ones_like(t)))
    samples = replace(samples, square=4 + 2 * np.cos(t / 50), rate=-np.sin(t / 50) / 25)
    blocks = recorded(samples, weights=(1.0, 0.5, 0.3)).last(1.0)
    total = np.abs(1 + 0.5 * np.exp(1j * ahead) + 0.3j)
    assert (blocks.least_sum.min(), blocks.greatest_sum.max()) == pytest.approx((total.min(), total.max()), rel=1e-3)
    assert np.abs(blocks.phases[0]) == pytest.approx(1.0, abs=1e-3)
    assert blocks.phases[1] == pytest.approx(1j, abs=1e-12)
    least, greatest = blocks.least_amplitude.min(), blocks.greatest_amplitude.max()
    assert (least, greatest) == pytest.approx((np.sqrt(2.0), np.sqrt(6.0)), rel=1e-2)
    assert (blocks.least_amplitude <= blocks.amplitude).all()
    assert (blocks.amplitude <= blocks.greatest_amplitude).all()
    assert recorded(samples).last(1.0).greatest_sum.max() == 0.0


@pytest.mark.parametrize(
    ("turns", "cycle", "expected"),
    [
        (120, 1.0, 6),
        (400, 1.0, 20),
        (20, 1.0, 2),
        (120, 2.5, 7),
        (120, 6.0, 6),
        (120, 7.0, 7),
        (120, 50.0, 50),
        (120, 70.0, 60),
    ],
)
def test_the_final_window(turns, cycle, expected):
    """A twentieth of the turns, at least two, in whole cycles; at most half of the record. 7.5 turns are 7 whole ones."""
    blocks = recorded(rippled(turns)).final_turns(cycle)
    assert (blocks.time[-1] - blocks.time[0]) / TURN == pytest.approx(expected, abs=1e-6)


def test_no_turn_yet():
    record = recorded(rippled(0.9))
    for blocks in (record.last(0.5), record.whole, record.whole_turns(0.5), TurnRecord(1).last(1.0)):
        assert len(blocks) == 0
        assert blocks.turns == 0
    assert TurnRecord(2).last(1.0).phases.shape == (2, 0)


@pytest.mark.parametrize("body", [0, 1, 2])
def test_moments_follow_their_bodies(body):
    moments = np.arange(3.0)[:, None] * np.ones(5)
    t = np.arange(5.0)
    samples = replace(Samples.of(t, *((k * t, np.full(5, float(k))) for k in range(3))), moments=moments)
    led = samples.relative_to(body)
    assert led.moments[:, 0].tolist() == led.speeds[:, 0].tolist() == [body, *(k for k in range(3) if k != body)]
    assert samples.only_body(body).moments.tolist() == [[body] * 5]
    assert samples.with_reference(t, np.ones(5)).moments[:, 0].tolist() == [0, 0, 1, 2]
    assert samples.part(slice(2, None)).with_previous(samples.part(slice(0, 3))).moments.shape == (3, 5)
