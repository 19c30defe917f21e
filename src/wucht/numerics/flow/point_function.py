"""A Program as a function of many points at once: machine code on the lanes of vectors."""

from __future__ import annotations

import math
from collections import deque
from functools import lru_cache

import numpy as np

from wucht.numerics.flow.compiled.machine_code import MachineCode, compile_stepper, vectors
from wucht.numerics.flow.compiled.points_kernel import PointsMemory, evaluate_points
from wucht.numerics.flow.compiled.straight_line_code import module_text
from wucht.numerics.flow.program import Program

_WIDTH = 8  # numbers of a vector
_IDLE = 16  # idle memory kept: for more threads than evaluate the same function at once
_CODE = "values"
_POINT_COUNT, _TIME, _STATES, _CONSTANTS, _RESULTS = (
    PointsMemory._fields.index(name) for name in ("point_count", "time", "states", "constants", "results")
)

_Memory = tuple[list[float], tuple[np.ndarray, ...]]  # the kernel's arguments, and the arrays whose addresses are among them


@lru_cache(maxsize=256)
def point_function(program: Program) -> PointFunction:
    """Compile a program without piecewise functions; the same program gives the same function back.

    Raises ``RunError`` for a function that the C library does not have.
    """
    return PointFunction(program)


class PointFunction:
    """Results (r,) or (r, N) of a program, of states (n,) or (n, N), constants (k,) and a time; safe in any thread."""

    def __init__(self, program: Program) -> None:
        self._code = MachineCode.of(module_text([(_CODE, program)], _WIDTH), (_CODE,))
        self._evaluate = compile_stepper(evaluate_points, _WIDTH)
        self._counts = {
            "n": len(program.states), "constant_count": len(program.constants), "result_count": len(program.results)
        }  # fmt: skip
        self._idle: deque[_Memory] = deque(maxlen=_IDLE)

    def __call__(self, states: np.ndarray, constants: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Evaluate; not finite where the results cannot be evaluated."""
        points, numbers = np.ascontiguousarray(states, float), np.ascontiguousarray(constants, float)
        results = np.empty((self._counts["result_count"], *points.shape[1:]))
        try:
            memory = self._idle.pop()
        except IndexError:
            memory = self._memory()
        arguments, _ = memory
        arguments[_POINT_COUNT], arguments[_TIME] = math.prod(points.shape[1:]), time
        arguments[_STATES], arguments[_CONSTANTS], arguments[_RESULTS] = map(_address, (points, numbers, results))
        self._evaluate(*arguments)
        self._idle.append(memory)
        return results

    def _memory(self) -> _Memory:
        counts = {"moment": 1} | dict(zip(("state", "constant", "values"), self._counts.values(), strict=True))
        arrays = {name: vectors(count, _WIDTH) for name, count in counts.items()}
        fields = {name: _address(array) for name, array in arrays.items()} | self._counts
        fields |= {"function": self._code.addresses[_CODE], "width": _WIDTH}
        return [fields.get(name, 0) for name in PointsMemory._fields], tuple(arrays.values())


def _address(array: np.ndarray) -> int:
    address: int = array.__array_interface__["data"][0]  # in half of the time of ``array.ctypes.data``
    return address
