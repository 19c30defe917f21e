"""When two numbers of results are alike."""

from __future__ import annotations

import math
from typing import Any

import pytest

from wucht.numerics.alike_numbers import are_alike, largest_number


@pytest.mark.parametrize(
    ("unit", "own", "near", "far"),
    [
        ("s", 10.0, 10.0009, 10.0011),
        ("s", None, None, 3.0),
        ("rad", {"b1": 0.0002}, {"b1": 2 * math.pi - 0.0002}, {"b1": 2 * math.pi - 0.001}),
        ("", 0.5, 0.50004, 0.50006),
        ("N", {"r": [1.0, 0.0]}, {"r": [1.0, 0.00009]}, {"r": [1.0, 0.0002]}),
        ("", "passed", "passed", "captured"),
        ("", {"a": 1.0}, {"a": 1.0}, {"b": 1.0}),
    ],
)
def test_a_ten_thousandth_decides(unit: str, own: Any, near: Any, far: Any) -> None:
    """Of a number, of a vector, or of a turn."""
    size = largest_number(own)
    assert are_alike(own, near, unit, size) and not are_alike(own, far, unit, size)


def test_beside_the_largest_number_of_its_unit_a_small_one_is_zero() -> None:
    assert largest_number({"a": [1.0, -5.0], "b": "text", "c": None}) == 5.0
    assert are_alike(0.0, 0.9e-6, "s", 1.0) and not are_alike(0.0, 1.1e-6, "s", 1.0)
