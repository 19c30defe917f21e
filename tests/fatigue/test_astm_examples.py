"""The examples of ASTM E1049-85: figures 2, 3, 5, 6, 7 as data. The histories are read off the figures."""

import numpy as np
import pytest

from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import cycles_of_levels, cycles_of_peaks, level_crossings, peaks_and_valleys, rainflow, range_pairs

HISTORY = np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2], dtype=float)
FIGURE_2 = np.array([-0.8, 1.3, 0.7, 3.4, 0.7, 2.5, -1.4, -0.5, -2.3, -2.2, -2.6, -2.4, -3.3, 1.5, 0.6, 3.4, -0.5])
FIGURE_3 = np.array([0.0, 1.5, 0.5, 3.5, 0.5, 2.5, -1.5, -0.5, -2.5, -2.0, -2.7, -2.5, -3.5, 1.5, 0.5, 3.5, -0.5])


def table(cycles: LoadCycles) -> dict[float, float]:
    rows, _ = cycles.group_by_range()
    return dict(zip(np.round(rows.ranges, 9).tolist(), rows.counts.tolist(), strict=True))


def test_rainflow():
    found = rainflow(HISTORY)
    assert table(found) == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    full = found.counts == 1
    assert (found.ranges[full].tolist(), found.means[full].tolist()) == ([4.0], [1.0])


def test_rainflow_of_a_history_that_repeats():
    assert table(rainflow(HISTORY, "repeat")) == {3: 1, 4: 1, 7: 1, 9: 1}


def test_what_does_not_close_can_be_dropped():
    assert table(rainflow(HISTORY, "drop")) == {4: 1}


def test_range_pairs():
    assert table(range_pairs(HISTORY)) == {3: 1, 4: 1, 6: 1, 8: 1}
    assert table(range_pairs(HISTORY, "repeat")) == table(rainflow(HISTORY, "repeat"))


def test_level_crossings():
    levels = np.arange(-4.0, 5.0)
    counts = level_crossings(FIGURE_2, levels, reference=0.0)
    assert counts.tolist() == [0, 1, 1, 2, 2, 5, 3, 2, 0]
    assert table(cycles_of_levels(levels, counts)) == {7: 1, 5: 1, 2: 1, 1: 2}


@pytest.mark.parametrize(("signal", "counts"), [([-2.0, 2.0], [0, 1, 1]), ([2.0, -2.0], [1, 0, 0])])
def test_at_the_reference_itself_rising_slopes_count(signal, counts):
    """5.1.1: rising slopes at the reference and above, falling ones below it."""
    assert level_crossings(np.array(signal), np.array([-1.0, 0.0, 1.0]), reference=0.0).tolist() == counts


def test_peaks():
    peaks, valleys = peaks_and_valleys(FIGURE_3, reference=0.0)
    assert (peaks.tolist(), valleys.tolist()) == ([3.5, 3.5, 2.5, 1.5, 1.5], [-1.5, -2.5, -2.7, -3.5])
    assert table(cycles_of_peaks(peaks, valleys)) == {7.0: 1, 6.2: 1, 5.0: 1, 3.0: 1, 1.5: 0.5}


def test_all_peaks_without_a_reference():
    peaks, valleys = peaks_and_valleys(FIGURE_3)
    assert (len(peaks), len(valleys)) == (8, 7)
    closed = peaks_and_valleys(FIGURE_3, is_repeated=True)
    assert [len(part) for part in closed] == [8, 8]
    assert (closed[0][0], closed[1][-1]) == (3.5, -3.5)


@pytest.mark.parametrize("residue", ["half-cycles", "repeat", "drop"])
@pytest.mark.parametrize("values", [[], [1.0], [1.0, 1.0]])
def test_nothing_is_counted_of_what_does_not_move(values, residue):
    assert rainflow(np.array(values), residue).total == range_pairs(np.array(values), residue).total == 0
