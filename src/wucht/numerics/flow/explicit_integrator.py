"""The explicit integrator: Dormand-Prince 8(5,3) in machine code.

The stepper is the same for all systems and compiled once (``compiled.leg_stepper``). It is kept on disk, and a later process
needs no compiler.
E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, section II.10.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.compiled import leg_stepper
from wucht.numerics.flow.compiled.dormand_prince import (
    ALL_STAGES,
    DENSE_ROWS,
    NODES,
    ROW_BEGINS,
    ROW_STAGES,
    ROW_WEIGHTS,
    SMALLEST_TOLERANCE,
)
from wucht.numerics.flow.compiled.leg_stepper import LegMemory
from wucht.numerics.flow.compiled.machine_code import compile_stepper
from wucht.numerics.flow.cool_downs import CoolDowns
from wucht.numerics.flow.events import NOT_FINITE, Hit, LegError, LegResult
from wucht.numerics.flow.program import Numbers
from wucht.numerics.flow.step_sizes import step_limit_error
from wucht.numerics.flow.system_code import EVENT_VALUES, RATES, SystemCode

_ROOM = 64  # for the hits of a leg, to begin with


class Ending(IntEnum):
    """How a leg of the stepper ended."""

    END, EVENT, NO_STEPS_LEFT, NOT_FINITE, NO_ROOM = (
        leg_stepper.END, leg_stepper.EVENT, leg_stepper.NO_STEPS_LEFT, leg_stepper.NOT_FINITE, leg_stepper.NO_ROOM
    )  # fmt: skip


class ExplicitIntegrator:
    """An integrator of one run: the memory in which the stepper works."""

    def __init__(self, code: SystemCode, tolerance: float) -> None:
        n, m = len(code.program.states), len(code.events)
        width = -(-n // leg_stepper.BLOCK) * leg_stepper.BLOCK
        self._code, self._cool_downs = code, CoolDowns(code.rates, code.event_values, code.events)
        self._advance_leg = compile_stepper(leg_stepper.advance)
        self._parameters, self._constants, self._event_constants = np.empty(0), np.empty(0), np.empty(0)
        self._state, self._clock, self._counts = np.zeros(width), np.zeros(1), np.zeros(4, np.int64)
        self._cool_ends, self._cool_signs, self._lowest = np.empty(m), np.empty(m), np.empty(m)
        rows = {"k": ALL_STAGES, "dense": DENSE_ROWS + 3, "point": 1, "next_state": 1, "errors": 1, "zero": 1}
        self._memory: dict[str, np.ndarray] = {name: np.zeros(count * width) for name, count in rows.items()}
        self._memory |= {
            "state": self._state, "clock": self._clock, "counts": self._counts, "values": np.zeros(leg_stepper.VALUE_ROWS * m),
            "cool_ends": self._cool_ends, "cool_signs": self._cool_signs, "lowest": self._lowest, "nodes": NODES,
            "row_weights": ROW_WEIGHTS, "row_places": ROW_STAGES * width, "row_begins": ROW_BEGINS, "is_angle": code.is_angle,
            "event_kinds": np.array([[e.direction for e in code.events], [e.interrupts for e in code.events]], np.int64),
        }  # fmt: skip
        self._fields: dict[str, float] = {name: array.ctypes.data for name, array in self._memory.items()} | {
            "n": n, "width": width, "m": m, "tolerance": max(tolerance, SMALLEST_TOLERANCE),
            "rates": code.machine_code.addresses[RATES], "functions": code.machine_code.addresses[EVENT_VALUES],
        }  # fmt: skip

    @property
    def time(self) -> float:
        """Time reached."""
        return float(self._clock[0])

    @property
    def state(self) -> np.ndarray:
        """State reached, (n,)."""
        return self._state[: len(self._code.program.states)].copy()

    def start(self, time: float, state: np.ndarray, parameter_values: Numbers) -> None:
        """Place the integrator."""
        self._place(time, state)
        if not np.array_equal(parameter_values, self._parameters):
            self._constants = self._code.program.constant_values(parameter_values)
            self._event_constants = self._code.event_program.constant_values(parameter_values)
            self._parameters = np.array(parameter_values, float)
        self._cool_downs.start(time, np.asarray(state), self._constants, self._event_constants)

    def forget_events(self) -> None:
        """Clear the cool-downs: another part of the run begins."""
        self._cool_downs.clear()

    def _place(self, time: float, state: np.ndarray) -> None:
        self._clock[0], self._state[: len(state)] = time, state

    def leg(self, grid: np.ndarray) -> LegResult:
        """Advance over the grid (m,). Raises ``LegError`` when the state ceases to be finite or steps run out."""
        begin, state, room, ending = self.time, self.state, _ROOM, Ending.NO_ROOM
        samples, times = np.empty((len(grid), len(state))), np.ascontiguousarray(grid)
        while ending is Ending.NO_ROOM:  # for the hits: so many are seldom in one leg, which is repeated
            self._place(begin, state)
            hit_events, hits, room = np.empty(room, np.int64), np.empty((room, 1 + len(state))), 16 * room
            ending = self._advance(times, samples, hit_events, hits)
        sample_count, hit_count, _, stopped_by = self._counts.tolist()
        result = samples[:sample_count].T
        if ending is Ending.NOT_FINITE:
            raise LegError(*NOT_FINITE, result)
        if ending is Ending.NO_STEPS_LEFT:
            raise step_limit_error(result, begin, self.time)
        events, time, state, lowest = self._code.events, self.time, self.state, self._lowest.copy()
        records = zip(hit_events[:hit_count].tolist(), hits[:hit_count], strict=True)
        in_order = sorted((Hit(events[i].name, float(h[0]), h[1:].copy()) for i, h in records), key=lambda hit: hit.time)
        if ending is Ending.END:
            return LegResult(result, time, state, tuple(in_order), None, lowest)
        self._cool_downs.add(stopped_by, time, state)
        return LegResult(result, time, state, (*in_order, Hit(events[stopped_by].name, time, state)), stopped_by, lowest)

    def _advance(self, grid: np.ndarray, samples: np.ndarray, hit_events: np.ndarray, hits: np.ndarray) -> Ending:
        self._cool_ends[:], self._lowest[:] = -np.inf, np.inf
        for i, (end, sign) in self._cool_downs.by_event.items():
            self._cool_ends[i], self._cool_signs[i] = end, sign
        arrays = {
            "constants": self._constants, "event_constants": self._event_constants, "grid": grid, "samples": samples,
            "hit_events": hit_events, "hits": hits,
        }  # fmt: skip
        addresses = {name: array.ctypes.data for name, array in arrays.items()}
        fields = (
            self._fields | addresses | {"grid_count": len(grid), "room": len(hit_events), "most_steps": step_sizes.MAX_STEPS}
        )
        return Ending(self._advance_leg(*(fields[name] for name in LegMemory._fields)))
