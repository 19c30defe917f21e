"""Between which values of a parameter the state depends on the direction in which it is moved."""

from __future__ import annotations

import pytest

from wucht.dynamics.sweeps.jumps import Jump, hysteresis


def jump(value: float, direction: str) -> Jump:
    return Jump(value, 1.0, 2.0, direction, 0.1, 0.2, True, False, (value, value))


@pytest.mark.parametrize(
    ("up", "down", "expected"),
    [
        ((140.0,), (120.0,), [120.0, 140.0]),
        ((100.0, 140.0), (120.0, 130.0), [120.0, 140.0]),
        ((100.0, 140.0), (90.0, 150.0), [90.0, 140.0]),
        ((110.0,), (120.0,), None),
        ((110.0,), (), None),
        ((), (110.0,), None),
        ((), (), None),
    ],
)
def test_from_the_first_jump_down_to_the_last_one_up(
    up: tuple[float, ...], down: tuple[float, ...], expected: list[float] | None
) -> None:
    jumps = [*(jump(v, "up") for v in up), *(jump(v, "down") for v in down)]
    assert hysteresis(jumps) == expected
