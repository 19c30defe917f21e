"""A record of any length in bounded memory."""

from itertools import pairwise

import numpy as np
import pytest

from wucht.numerics.observers.pyramid import HIGH, KEPT, LAST, LOW, MEAN, Pyramid

ALL = Pyramid((LAST, LOW, HIGH, MEAN))


def drawn(count, seed=0):
    """The same integers in each row: sums of them are exact."""
    return np.tile(np.random.default_rng(seed).integers(-1000, 1000, count).astype(float), (4, 1))


def test_what_two_blocks_are_as_one():
    blocks = drawn(4 * KEPT)
    levels = ALL.after(blocks).levels
    assert len(levels) == 3
    for k, level in enumerate(levels):
        together = blocks[0].reshape(-1, 2**k)[-KEPT:]
        ways = together[:, -1], together.min(axis=1), together.max(axis=1), together.mean(axis=1)
        assert np.array_equal(level, np.array(ways))


def test_each_row_has_its_own_kind():
    level = Pyramid((HIGH, MEAN, HIGH)).after(np.tile(np.arange(2.0 * KEPT), (3, 1))).levels[1]
    assert level[:, 0].tolist() == [1.0, 0.5, 1.0]


def test_millions_of_blocks_are_kept_in_few():
    record, ahead = ALL, drawn(100_003)
    for _ in range(50):
        record = record.after(ahead)
    assert record.count == 5_000_150
    assert [level.shape[1] for level in record.levels[:-1]] == [KEPT] * 11
    assert record.levels[-1].shape == (4, 5_000_150 // 2**11)
    assert KEPT / 2 <= record.levels[-1].shape[1] <= KEPT


@pytest.mark.parametrize("count", [1, KEPT, KEPT + 1, 2 * KEPT + 1, 2 * KEPT + 2, 37_777])
def test_parts_do_not_matter(count):
    blocks, draw, record = np.random.default_rng(2).normal(size=(4, count)), np.random.default_rng(3), ALL
    borders = np.unique([0, *draw.integers(0, count + 1, 40), *range(min(count, 30)), count])
    for a, b in pairwise(borders):
        record = record.after(blocks[:, a:b])
    whole = ALL.after(blocks)
    assert record.count == whole.count == count
    assert len(record.levels) == len(whole.levels)
    assert all(map(np.array_equal, record.levels, whole.levels))
    assert record.after(blocks[:, :0]) is record


def test_a_share_is_in_the_finest_blocks_that_reach_back():
    """Of 2^16 blocks the last 2^12 are known one by one, twice as many in pairs, all of them by sixteens."""
    record = ALL.after(np.tile(np.arange(2.0**16), (4, 1)))
    for share, size in [(2**-4, 1), (2**-3.99, 2), (2**-3, 2), (2**-2.99, 4), (0.5, 8), (0.51, 16), (1.0, 16)]:
        values, found = record.last(share)
        assert found == size
        assert values.shape[1] == round(share * 2**16 / size)
        assert values[0, -1] == 2**16 - 1
        assert values[1, 0] == pytest.approx((1 - share) * 2**16, abs=size)
    assert record.last(0.0)[0].shape[1] == 1


def test_an_odd_number_of_blocks():
    """The one that has no neighbour yet is known by itself only."""
    record = ALL.after(np.tile(np.arange(KEPT + 1.0), (4, 1)))
    values, size = record.last(1.0)
    assert size == 2
    assert values[0].tolist() == list(range(1, KEPT, 2))
    assert record.levels[0][0, -1] == KEPT


def test_nothing_yet():
    values, size = ALL.last(0.5)
    assert values.shape == (4, 0)
    assert size == 1
