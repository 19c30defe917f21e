"""Machine code of a system: its rates and the functions of its events, kept on disk for a later process."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.numerics.flow.compiled.machine_code import MachineCode
from wucht.numerics.flow.compiled.straight_line_code import module_text
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.program import PointValues, Program
from wucht.system import System

RATES, EVENT_VALUES = "rates", "event_values"


@dataclass(frozen=True, eq=False)
class SystemCode:
    """Machine code of a system and its events, shared by all runs.

    rates, event_values: as functions of a state (n,), a time and constants. is_angle (n,): 1 for angles, else 0.
    """

    program: Program
    event_program: Program
    events: tuple[Event, ...]
    is_angle: np.ndarray
    machine_code: MachineCode
    rates: PointValues
    event_values: PointValues

    @classmethod
    def of(cls, system: System, program: Program, events: Sequence[Event], event_program: Program) -> SystemCode:
        """Compile a System's program and that of its events. Raises ``RunError`` for a function that the C library lacks."""
        code = MachineCode.of(module_text([(RATES, program), (EVENT_VALUES, event_program)]), (RATES, EVENT_VALUES))
        return cls(
            program,
            event_program,
            tuple(events),
            np.array([float(s in system.angles) for s in system.states]),
            code,
            _values_at_point(code.addresses[RATES], len(program.results)),
            _values_at_point(code.addresses[EVENT_VALUES], len(event_program.results)),
        )


def _values_at_point(address: int, count: int) -> PointValues:
    """Return machine code as a function of state, time and constants that returns a list."""
    code = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 3)(address)

    def function(state: np.ndarray, time: float, constants: np.ndarray) -> list[float]:
        values = np.empty(count)
        arrays = np.ascontiguousarray(state, float), np.ascontiguousarray(constants, float), values
        code(time, *(array.__array_interface__["data"][0] for array in arrays))
        return values.tolist()

    return function
