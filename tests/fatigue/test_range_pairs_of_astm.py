"""Range pairs of all short histories, against the rules of ASTM E1049-85, 5.4.1, as they are written there."""

from __future__ import annotations

import itertools
from collections import Counter

from wucht.fatigue import range_pairs, turning_points

LEVELS, LONGEST = 4, 6


def count_forward(points: list[float], counts: Counter[float]) -> list[float]:
    """Rules 1 to 4: X is the range of the last two points, Y that before it; where X >= Y, Y is a cycle, and its points go."""
    kept = list[float]()
    for point in points:
        kept.append(point)
        while len(kept) >= 3 and abs(kept[-1] - kept[-2]) >= abs(kept[-2] - kept[-3]):
            counts[abs(kept[-2] - kept[-3])] += 1.0
            del kept[-3:-1]
    return kept


def test_short_histories_have_the_pairs_of_the_standard() -> None:
    """Rule 5: what remains is counted backwards, from its end on; ranges that are left are half cycles."""
    for length in range(2, LONGEST + 1):
        for values in itertools.product(range(LEVELS), repeat=length):
            expected, actual = Counter[float](), Counter[float]()
            forward = count_forward(turning_points(values).tolist(), expected)
            rest = count_forward(forward[::-1], expected)
            for a, b in itertools.pairwise(rest):
                expected[abs(b - a)] += 0.5
            pairs = range_pairs(values)
            for size, count in zip(pairs.ranges.tolist(), pairs.counts.tolist(), strict=True):
                actual[size] += count
            assert actual == expected, values
