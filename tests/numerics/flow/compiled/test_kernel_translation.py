"""The small part of Python that is translated means the same in machine code."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from wucht.numerics.flow.compiled.kernel_translation import kernel_text
from wucht.numerics.flow.compiled.machine_code import MachineCode, compiled_object


@pytest.mark.parametrize("statement", ["with x: pass", "x = [1]", "return x @ x", "del x", "n = 1.5", "return unknown"])
def test_all_else_is_refused(statement: str) -> None:
    with pytest.raises((TypeError, KeyError)):
        kernel_text(f"def f(x: float, n: int) -> float:\n    {statement}\n", {})


LANES = '''
def work(values: LaneArray, sums: LaneArray, count: int) -> int:
    """Sums of roots of positive numbers, bounded; how many rounds until all lanes are above 3."""
    rounds = 0
    total = 0.0 * values[0]
    while any_lane(total < 3.0) and rounds < 10:
        for i in range(count):
            is_positive = (values[i] > 0.0) & ~(values[i] > 100.0) | (values[i] == -1.0)
            total += select(is_positive, smaller(root(abs(values[i])), 2.5), larger(values[i] / 1000, 0.5))
        total = total * 1.0 + rounds
        rounds += 1
    sums[0] = -total
    sums[1][2] = values[1][3]
    return rounds
'''


@pytest.mark.parametrize("width", [4, 8, 16])
def test_lanes_are_computed_each_for_itself(width: int) -> None:
    """Arithmetic, choices by marks, bounds, roots, and a number of a vector, as NumPy computes them."""
    code = MachineCode.of_file(compiled_object(kernel_text(LANES, {}, width), ("work",)), ("work",))
    draw = np.random.default_rng(5)
    numbers = draw.uniform(-5.0, 9.0, (3, width))
    numbers[0, :2] = [-1.0, 2000.0]
    names = {"any_lane": np.any, "select": np.where, "larger": np.maximum, "smaller": np.minimum, "root": np.sqrt}
    exec(LANES, namespace := names | {"LaneArray": None})
    expected, room = np.zeros((2, width)), np.zeros(6 * width)
    first = -(room.ctypes.data // room.itemsize) % width  # aligned as the processor reads vectors
    values, sums = room[first : first + 3 * width], room[first + 3 * width : first + 5 * width]
    values[:] = numbers.ravel()
    function = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)(code.addresses["work"])
    assert function(values.ctypes.data, sums.ctypes.data, 3) == namespace["work"](numbers, expected, 3)
    assert sums[:width] == pytest.approx(expected[0], rel=1e-15) and sums[width + 2] == numbers[1, 3]
