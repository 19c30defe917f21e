"""Machine code of a system: its rates, the functions of its events, and what decides where these interrupt.

It is kept on disk for a later process.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.numerics.flow.compiled.machine_code import MachineCode
from wucht.numerics.flow.compiled.segment_changes import AHEAD, AHEAD_FROM_REST
from wucht.numerics.flow.compiled.straight_line_code import module_text
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.program import Numbers, Program, lower
from wucht.numerics.flow.segments import Segmentations
from wucht.system import TIME, System

_RATES, _EVENTS, _INSTANT = "rates", "event_values", "instant"


@dataclass(frozen=True, eq=False)
class PointCode:
    """A program in machine code: a function of a state (n,), a time and constants that returns a list."""

    program: Program
    code: MachineCode
    name: str

    @property
    def address(self) -> int:
        """Where the code lies."""
        return self.code.addresses[self.name]

    @cached_property
    def _function(self) -> Callable[..., None]:
        return ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 3)(self.address)

    def __call__(self, state: np.ndarray, time: float, constants: np.ndarray) -> list[float]:
        """Evaluate; not finite where that cannot be done."""
        values = np.empty(len(self.program.results))
        arrays = np.ascontiguousarray(state, float), np.ascontiguousarray(constants, float), values
        self._function(time, *(array.__array_interface__["data"][0] for array in arrays))
        return values.tolist()

    def at(self, time: float, state: np.ndarray, parameter_values: Numbers) -> np.ndarray:
        """Evaluate at given parameter values."""
        return np.array(self(state, time, self.program.constant_values(parameter_values)))


@dataclass(frozen=True, eq=False)
class SystemCode:
    """Machine code of a system and its events, shared by all runs.

    events: the requested ones, then the ends of segments. is_angle (n,): 1 for angles, else 0. event_values: of all events.
    instant: the functions of the requested events, the sizes of their rounding, the arguments of piecewise functions, and the
    gains of the quadratures, where these jump.
    """

    segmentations: Segmentations
    events: tuple[Event, ...]
    request_count: int
    is_angle: np.ndarray
    rates: PointCode
    event_values: PointCode
    instant: PointCode

    @classmethod
    def of(cls, smooth: System, segmentations: Segmentations, events: Sequence[Event], gains: Sequence[sp.Expr]) -> SystemCode:
        """Compile a smooth System. events: requested. gains: of the quadratures, none where they do not jump.

        Raises ``RunError`` for a function that the C library lacks.
        """
        functions = [segmentations.smooth(e.expression) for e in events]
        explicit = [smooth.explicit(f) for f in functions]
        sizes = [sp.Add(*(sp.Abs(sp.diff(f, s) * s) for s in (*smooth.states, TIME) if f.has(s))) for f in explicit]
        arguments, ends = [x.argument for x in segmentations.segmentations], segmentations.events()
        results = {
            _RATES: smooth.derivatives,
            _EVENTS: [*functions, *(e.expression for e in ends)],
            _INSTANT: [*functions, *sizes, *arguments, *gains],
        }
        programs = {name: lower(smooth, expressions, segmentations.symbols) for name, expressions in results.items()}
        code = MachineCode.of(module_text(list(programs.items())), tuple(programs))
        rates, event_values, instant = (PointCode(program, code, name) for name, program in programs.items())
        is_angle = np.array([float(s in smooth.angles) for s in smooth.states])
        return cls(segmentations, (*events, *ends), len(events), is_angle, rates, event_values, instant)

    @property
    def gain_count(self) -> int:
        """Number of the gains of quadratures."""
        return len(self.instant.program.results) - 2 * self.request_count - len(self.segmentations.segmentations)

    def arguments(self, instant_values: np.ndarray) -> np.ndarray:
        """Select the arguments of the piecewise functions among the values of an instant."""
        first = 2 * self.request_count
        return instant_values[first : first + len(self.segmentations.segmentations)]

    def lookahead(
        self, time: float, state: np.ndarray, parameter_values: Numbers, direction: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the values of an instant, and those a little later, where they change at all; direction -1: earlier."""
        rates, instant = self.rates, self.instant
        rate_constants, constants = (c.program.constant_values(parameter_values) for c in (rates, instant))
        values = np.array(instant(state, time, constants))
        ahead = values.copy()
        for step in (direction * s * max(1.0, abs(time)) for s in (AHEAD, AHEAD_FROM_REST)):
            half = state + step / 2 * np.array(rates(state, time, rate_constants))
            then = state + step * np.array(rates(half, time + step / 2, rate_constants))
            later = np.array(instant(then, time + step, constants))
            ahead = np.where(ahead == values, later, ahead)
        return values, ahead
