"""What is demanded of numbers."""

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.demands import require_at_least, require_decimals, require_finite, require_not_negative, require_positive


@pytest.mark.parametrize("value", [0.0, -1e-9, float("nan"), float("inf")])
def test_a_positive_number(value):
    with refused("tolerance", code="not-positive"):
        require_positive("tolerance", value)
    assert require_positive("tolerance", 1e-300) == 1e-300


@pytest.mark.parametrize("value", [-1e-300, float("nan"), float("inf")])
def test_a_number_that_is_not_negative(value):
    with refused("damping", code="negative"):
        require_not_negative("damping", value)
    assert require_not_negative("damping", 0.0) == 0.0


@pytest.mark.parametrize("value", [2, -3, 3.5, float("nan"), True])
def test_a_whole_number(value):
    with refused("count", code="whole-number"):
        require_at_least("count", value, 3)
    assert require_at_least("count", np.int64(3), 3) == 3


@pytest.mark.parametrize("value", [-1, 13, 2.5, float("nan"), True])
def test_decimals(value):
    with refused("decimals", "12", code="decimals"):
        require_decimals("decimals", value)
    assert [require_decimals("decimals", d) for d in (0, 12)] == [0, 12]


def test_values_that_are_no_numbers():
    with refused("curve", code="not-finite"):
        require_finite("curve", np.array([1.0, np.nan]))
    assert require_finite("curve", np.array([1.0])).tolist() == [1.0]
