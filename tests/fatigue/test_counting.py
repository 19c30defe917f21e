"""Turning points, in one piece and in many."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.fatigue.counting import TurningPoints, turning_points

VALUES = st.lists(st.integers(-9, 9), max_size=60).map(lambda v: np.array(v, dtype=float))


def test_ends_and_extremes():
    assert turning_points(np.array([0, 1, 1, 3, 2, 2, 4, 4.0])).tolist() == [0, 3, 2, 4]


@pytest.mark.parametrize(("values", "points"), [([], []), ([2], [2]), ([2, 2], [2]), ([2, 5], [2, 5]), ([3, 3, 1, 1], [3, 1])])
def test_short_signals(values, points):
    assert turning_points(np.array(values, dtype=float)).tolist() == points


@settings(max_examples=60, deadline=None)
@given(VALUES, st.lists(st.integers(0, 60), max_size=5))
def test_pieces_give_what_the_whole_gives(values, cuts):
    time, whole = np.arange(len(values), dtype=float), turning_points(values)
    assert (np.sign(np.diff(whole))[1:] == -np.sign(np.diff(whole))[:-1]).all()
    found, kept, times = TurningPoints(), [], []
    for new in np.split(np.arange(len(values)), sorted(min(c, len(values)) for c in cuts)):
        part = np.concatenate([new[:1] - 1, new]) if len(new) and new[0] else new  # with the last sample of that before
        found = found.update(time[part], values[part])
        kept.append(found.values)
        times.append(found.time)
        found = found.without_points()
    end_time, end = found.points_to_end()
    assert np.concatenate([*kept, end]).tolist() == whole.tolist()
    assert (np.diff(np.concatenate([*times, end_time])) > 0).all()


def test_extremes_between_samples():
    """Of a vibration with 48 samples a period, not evenly spaced: right to h^4/32."""
    time = np.sort(np.random.default_rng(3).uniform(0.0, 60.0, int(60 * 48 / (2 * np.pi))))
    time = np.linspace(0, 60, len(time)) + 0.2 * (time - np.linspace(0, 60, len(time))).clip(-0.1, 0.1)
    found = TurningPoints().update(time, np.cos(time), interpolate=True)
    extremes = found.values[1:]
    step = np.diff(time).max()
    assert np.abs(np.abs(extremes) - 1).max() < step**4 / 32
    assert np.abs(found.time[1:] / np.pi - np.round(found.time[1:] / np.pi)).max() < step**2 / 10
    assert np.abs(np.abs(TurningPoints().update(time, np.cos(time)).values[1:]) - 1).max() > 20 * step**4 / 32
