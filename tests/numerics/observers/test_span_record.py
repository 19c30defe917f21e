"""The motion of one body in equal spans of time."""

from dataclasses import replace

import numpy as np
import pytest

from wucht.numerics.observers.pyramid import KEPT
from wucht.numerics.observers.span_record import SpanRecord
from wucht.numerics.observers.turns import Samples


def swinging(t):
    """phi = cos t, and a follower that is of no interest."""
    return Samples.of(t, (np.cos(t), -np.sin(t)), (5 * t, np.full_like(t, 5.0)))


def test_what_a_span_has():
    """Spans (0, 1], (1, 2], (2, 2.5]: the angle's cubic reaches 2, between samples, at s = 1/2 of the interval to 2."""
    samples = Samples.of(
        np.array([0.0, 0.5, 1.0, 2.0, 2.5]),
        (np.array([0.0, 3.0, 1.0, 1.0, -1.0]), np.array([0.0, 0.0, 4.0, -4.0, 0.0])),
    )
    spans = SpanRecord(1.0).after(samples).last(1.0)
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


@pytest.mark.parametrize("k", [2, 3, 4])
def test_extremes_of_the_angle_are_of_fourth_order(k):
    """Six samples a span, on its borders; of the speed only samples are seen."""
    step = 2.0**-k
    spans = SpanRecord(6 * step).after(swinging(np.arange(0, 300, step))).last(1.0)
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


def test_each_span_knows_its_own_extremes_only():
    """phi = t^2: spans of one second each."""
    t = np.linspace(0, 10, 101)
    spans = SpanRecord(1.0).after(Samples.of(t, (t**2, 2 * t))).last(1.0)
    ends = np.arange(1.0, 11.0)
    assert spans.time == pytest.approx(ends, rel=1e-15)
    assert spans.greatest_angle == pytest.approx(ends**2, rel=1e-14)
    assert spans.least_angle == pytest.approx((ends - 1) ** 2, rel=1e-14, abs=1e-14)
    assert spans.greatest_speed == pytest.approx(2 * ends, rel=1e-14)
    assert spans.least_speed == pytest.approx(2 * (ends - 1), rel=1e-14, abs=1e-14)


def test_the_distance_has_limits_of_its_own():
    """r^2 = 4 + cos t: its largest value at t = 2 pi lies between samples."""
    t = np.arange(0, 9, 0.3)
    samples = replace(Samples.of(t, (t, np.ones_like(t))), square=4 + np.cos(t), rate=-np.sin(t))
    spans = SpanRecord(3.0).after(samples).last(1.0)
    begin, end = np.append(0, spans.time[:-1]), spans.time
    assert spans.greatest_distance == pytest.approx(np.sqrt(4 + greatest_cosine(begin, end)), abs=1e-5)
    assert spans.least_distance == pytest.approx(np.sqrt(4 - greatest_cosine(begin + np.pi, end + np.pi)), abs=1e-5)


def test_twelve_samples_of_a_span_are_enough():
    """Of more the first one in each twelfth is taken."""
    fine = SpanRecord(1.2).after(swinging(np.arange(0, 300, 0.0007))).last(1.0)
    assert len(fine.time) == 250
    missed = 1 - fine.greatest_angle[fine.greatest_angle > 1 - 3e-7].min()
    assert 0.8 < missed / (0.1**4 / 384) < 1.1
    assert fine.time[:-1] == pytest.approx(1.2 * np.arange(1, 250), abs=0.1001)


def test_a_long_motion_is_bounded():
    record = SpanRecord(0.01)
    for begin in range(20):
        record = record.after(swinging(np.linspace(10 * begin, 10 * (begin + 1), 4001)))
    assert [level.shape[1] for level in record.kept.levels] == [KEPT, KEPT, KEPT, record.kept.count // 8]
    spans = record.last(1.0)
    assert len(spans.time) <= KEPT + 1
    assert spans.time[-1] == 200
    assert spans.time[0] == pytest.approx(0.08, abs=0.005)
    assert record.last(0.5).time[0] == pytest.approx(100, abs=0.1)


def test_hardly_anything():
    record = SpanRecord(1.0)
    assert len(record.last(1.0).time) == 0
    record = record.after(swinging(np.array([0.0])))
    assert len(record.last(1.0).time) == 0
    record = record.after(swinging(np.array([0.0, 0.5])))
    assert record.last(1.0).time.tolist() == [0.5]
