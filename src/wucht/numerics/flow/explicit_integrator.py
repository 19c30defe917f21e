"""The explicit integrator: Dormand-Prince 8(5,3) in machine code.

The stepper is the same for all systems and compiled once (``compiled.leg_stepper``). It is kept on disk, and a later process
needs no compiler.
E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, section II.10.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

import numpy as np

from wucht.function_call import begin_calls, call_failed, reason_of_failure
from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.compiled import leg_memory, leg_stepper
from wucht.numerics.flow.compiled.dormand_prince import (
    ALL_STAGES,
    NODES,
    ROW_BEGINS,
    ROW_STAGES,
    ROW_WEIGHTS,
    SMALLEST_TOLERANCE,
)
from wucht.numerics.flow.compiled.leg_memory import LegMemory
from wucht.numerics.flow.compiled.machine_code import compile_stepper
from wucht.numerics.flow.cool_downs import CoolDowns
from wucht.numerics.flow.events import NOT_FINITE, Hit, LegError, LegResult, SlidingError
from wucht.numerics.flow.program import Numbers
from wucht.numerics.flow.segment_locator import SegmentLocator
from wucht.numerics.flow.step_sizes import step_limit_error
from wucht.numerics.flow.system_code import SystemCode

_ROOM = 64  # for the hits of a leg, to begin with
_CONSTANTS = ("constants", "event_constants", "instant_constants")  # of rates, event functions, values of an instant


class Ending(IntEnum):
    """How a leg of the stepper ended."""

    END = leg_memory.END
    EVENT = leg_memory.EVENT
    NO_STEPS_LEFT = leg_memory.NO_STEPS_LEFT
    NOT_FINITE = leg_memory.NOT_FINITE
    NO_ROOM = leg_memory.NO_ROOM
    STANDING_STILL = leg_memory.STANDING_STILL


class ExplicitIntegrator:
    """An integrator of one run: the memory in which the stepper works. locator: where there are piecewise functions."""

    def __init__(self, code: SystemCode, locator: SegmentLocator | None, tolerance: float) -> None:
        n, m, s = len(code.is_angle), len(code.events), len(code.segmentations.segmentations)
        width = -(-n // leg_memory.BLOCK) * leg_memory.BLOCK
        self._code, self._locator = code, locator
        self._cool_downs = CoolDowns(code.rates, code.event_values, code.events)
        self._advance_leg = compile_stepper(leg_stepper.advance)
        self._parameters, codes = np.empty(0), (code.rates, code.event_values, code.instant)
        self._constants = {name: np.zeros(len(c.program.constants)) for name, c in zip(_CONSTANTS, codes, strict=True)}
        rows = {"k": ALL_STAGES, "dense": leg_memory.ROWS, "point": 1, "next_state": 1, "errors": 1, "zero": 1, "state": 1}
        self._memory: dict[str, np.ndarray] = {name: np.zeros(count * width) for name, count in rows.items()}
        self._memory |= {name: np.empty(m) for name in ("cool_ends", "cool_signs", "lowest")}
        self._memory |= {} if locator is None else locator.tables
        instant_count = len(code.instant.program.results)
        self._memory |= {
            "clock": np.zeros(1), "counts": np.zeros(4, np.int64), "values": np.zeros(leg_memory.VALUE_ROWS * m),
            "nodes": NODES, "row_weights": ROW_WEIGHTS,
            "row_places": ROW_STAGES * width, "row_begins": ROW_BEGINS, "is_angle": code.is_angle,
            "event_kinds": np.array([[e.direction for e in code.events], [e.interrupts for e in code.events]], np.int64),
            "event_segments": np.array([-1 if e.switch is None else e.switch[0] for e in code.events], np.int64),
            "segment": np.zeros(s, np.int64), "lowest_arguments": np.empty(s), "instants": np.empty(4 * instant_count),
        }  # fmt: skip
        self._fields: dict[str, float] = dict.fromkeys(LegMemory._fields, 0)
        self._fields |= {name: array.ctypes.data for name, array in self._memory.items()} | {
            "n": n, "width": width, "m": m, "tolerance": max(tolerance, SMALLEST_TOLERANCE),
            "request_count": code.request_count, "rates": code.rates.address, "functions": code.event_values.address,
            "instant": code.instant.address,
            "segmentation_count": s, "instant_count": instant_count, "gain_count": code.gain_count,
        }  # fmt: skip

    @property
    def time(self) -> float:
        """Time reached."""
        return float(self._memory["clock"][0])

    @property
    def state(self) -> np.ndarray:
        """State reached, (n,)."""
        return self._memory["state"][: len(self._code.is_angle)].copy()

    def start(self, time: float, state: np.ndarray, parameter_values: Numbers) -> None:
        """Place the integrator."""
        self._place(time, state)
        if self._locator is not None or not np.array_equal(parameter_values, self._parameters):
            self._parameters = np.array(parameter_values, float)
            codes = (self._code.rates, self._code.event_values, self._code.instant)
            constants = (code.program.constant_values(parameter_values) for code in codes)
            self._constants = {name: values.copy() for name, values in zip(_CONSTANTS, constants, strict=True)}
        if self._locator is not None:
            self._memory["segment"][:] = self._locator.numbers(self._parameters[-self._segment_width :])
        self._cool_downs.start(time, np.asarray(state), self._constants["constants"], self._constants["event_constants"])

    @property
    def _segment_width(self) -> int:
        """Numbers of the segments in use: the last of the parameters, and of each code's constants."""
        return len(self._code.segmentations.symbols)

    def forget_events(self) -> None:
        """Clear the cool-downs: another part of the run begins."""
        self._cool_downs.clear()

    def _place(self, time: float, state: np.ndarray) -> None:
        self._memory["clock"][0], self._memory["state"][: len(state)] = time, state

    def leg(self, grid: np.ndarray) -> LegResult:
        """Advance over the grid (m,). Raises ``LegError`` when the state or time stops, or steps run out."""
        begin, state, room, ending = self.time, self.state, _ROOM, Ending.NO_ROOM
        samples, times = np.empty((len(grid), len(state))), np.ascontiguousarray(grid)
        constants = {name: values.copy() for name, values in self._constants.items()}
        segment = self._memory["segment"].copy()
        begin_calls()
        while ending is Ending.NO_ROOM:  # for the hits: so many are seldom in one leg, which is repeated
            self._place(begin, state)
            self._memory["segment"][:] = segment
            for name, values in constants.items():
                self._constants[name][:] = values
            hit_events, hits, room = np.empty(room, np.int64), np.empty((room, 1 + len(state))), 16 * room
            ending = self._advance({"grid": times, "samples": samples, "hit_events": hit_events, "hits": hits})
        sample_count, hit_count, _, stopped_by = self._memory["counts"].tolist()
        result = samples[:sample_count].T
        if ending is Ending.NOT_FINITE or call_failed():
            raise LegError(*(reason_of_failure() or NOT_FINITE), result[:, np.isfinite(result).all(axis=0)])
        if ending is Ending.STANDING_STILL:
            raise SlidingError(result)
        if ending is Ending.NO_STEPS_LEFT:
            raise step_limit_error(result, begin, self.time)
        events, time, state = self._code.events, self.time, self.state
        records = zip(hit_events[:hit_count].tolist(), hits[:hit_count], strict=True)
        hits_in_order = sorted((Hit(events[i].name, float(h[0]), h[1:].copy()) for i, h in records), key=lambda hit: hit.time)
        self._keep_cool_downs()
        if ending is Ending.EVENT:
            self._cool_downs.add(stopped_by, time, state)
            hits_in_order.append(Hit(events[stopped_by].name, time, state))
        stopping = stopped_by if ending is Ending.EVENT else None
        if self._locator is None:
            return LegResult(result, time, state, tuple(hits_in_order), stopping)
        in_use = self._constants["event_constants"][-self._segment_width :].copy()
        return LegResult(result, time, state, tuple(hits_in_order), stopping, in_use, self._memory["lowest_arguments"].copy())

    def _keep_cool_downs(self) -> None:
        """Keep the cool-downs that are not over: those of the last change of segments, where there was one."""
        ends, signs = self._memory["cool_ends"], self._memory["cool_signs"]
        self._cool_downs.by_event = {int(i): (float(ends[i]), float(signs[i])) for i in np.flatnonzero(ends >= self.time)}

    def _advance(self, arrays: dict[str, np.ndarray]) -> Ending:
        self._memory["cool_ends"][:], self._memory["lowest"][:] = -np.inf, np.inf
        self._memory["lowest_arguments"][:] = np.inf
        for i, (end, sign) in self._cool_downs.by_event.items():
            self._memory["cool_ends"][i], self._memory["cool_signs"][i] = end, sign
        return Ending(self._advance_leg(*self.arguments(arrays)))

    def arguments(self, arrays: Mapping[str, np.ndarray]) -> list[float]:
        """Return the fields of its ``LegMemory``. arrays: of a leg, by name; none where machine code of lanes borrows it."""
        fields = self._fields | {name: array.ctypes.data for name, array in (*arrays.items(), *self._constants.items())}
        fields |= {"most_steps": step_sizes.MAX_STEPS}
        fields |= {
            count: len(arrays[name]) for count, name in (("grid_count", "grid"), ("room", "hit_events")) if name in arrays
        }
        tails = (len(values) - self._segment_width for values in self._constants.values())
        fields |= dict(zip(("rates_tail", "event_tail", "instant_tail"), tails, strict=True))
        return [fields[name] for name in LegMemory._fields]
