"""Ways of counting: where levels lie, and when ranges are put into classes."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.fatigue.load_counting import CountedLoad, LoadCounting


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
