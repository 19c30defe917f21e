"""The small part of Python that is translated means the same in machine code."""

from __future__ import annotations

import ctypes
import math

import pytest

pytest.importorskip("llvmlite")

from wucht.numerics.flow.compiled.kernel_translation import kernel_text
from wucht.numerics.flow.compiled.machine_code import MachineCode, compiled_object

SOURCE = '''
def collatz(n: int) -> int:
    """Steps to 1."""
    count = 0
    while n != 1:
        if n % 2 == 0:
            n = n - halves(n)
        else:
            n = 3 * n + 1
        count += 1
        if count > LIMIT:
            break
    return count

def halves(n: int) -> int:
    total = 0
    for i in range(n, 0, -2):
        total += 1
    return total

def mean_of_some(first: float, second: float, choice: int) -> float:
    low, high = min(first, second), max(first, second)
    if low < 0.0 < high and not (choice == 3 or choice == 4):
        return -math.sqrt(abs(low) * high)
    total, x = 0.0, low if choice > 0 else high
    for i in range(choice):
        if i == 2:
            continue
        total += x**2 / (i + 1)
    return total + math.copysign(1, first) * 2.0**-choice
'''


@pytest.fixture(scope="module")
def functions():
    """Each function as machine code and as Python runs it."""
    names, namespace = ("collatz", "halves", "mean_of_some"), {"math": math, "LIMIT": 200}
    exec(SOURCE, namespace)
    code = MachineCode.of_file(compiled_object(kernel_text(SOURCE, {"LIMIT": 200}), names), names)
    integer, real = ctypes.c_int64, ctypes.c_double
    kinds = {"collatz": (integer, integer), "halves": (integer, integer), "mean_of_some": (real, real, real, integer)}
    return {name: (ctypes.CFUNCTYPE(*kinds[name])(code.addresses[name]), namespace[name], code) for name in names}


@pytest.mark.parametrize("n", [1, 2, 7, 27, 97, 871])
def test_loops_and_branches(functions, n: int) -> None:
    for name in ("collatz", "halves"):
        compiled, python, _ = functions[name]
        assert compiled(n) == python(n)


@pytest.mark.parametrize("choice", [0, 1, 2, 3, 4, 5])
@pytest.mark.parametrize("pair", [(1.0, 2.0), (-1.0, 2.0), (3.0, -0.5), (-2.0, -1.0), (math.nan, 1.0)])
def test_numbers(functions, pair: tuple[float, float], choice: int) -> None:
    compiled, python, _ = functions["mean_of_some"]
    assert compiled(*pair, choice) == pytest.approx(python(*pair, choice), rel=1e-15, nan_ok=True)


@pytest.mark.parametrize("statement", ["with x: pass", "x = [1]", "return x @ x", "del x", "n = 1.5", "return unknown"])
def test_all_else_is_refused(statement: str) -> None:
    with pytest.raises((TypeError, KeyError)):
        kernel_text(f"def f(x: float, n: int) -> float:\n    {statement}\n", {})
