"""Many motions of the same equations at once, and what is observed of them: machine code on the lanes of vectors.

Each lane has a separate state, constants, segments and step size: the numbers of a motion depend only on its start, to the last
bit. The stepper is the same for all systems and compiled once (``compiled.lanes_stepper``); of a system its rates, the observed
quantities and, of piecewise functions, the ends of segments are compiled.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.errors import RunError
from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.compiled import lane_peaks, lanes_stepper, leg_memory
from wucht.numerics.flow.compiled.dormand_prince import (
    ALL_STAGES,
    DENSE_ROWS,
    NODES,
    ROW_BEGINS,
    ROW_STAGES,
    ROW_WEIGHTS,
    SMALLEST_TOLERANCE,
)
from wucht.numerics.flow.compiled.lane_memory import LanesMemory
from wucht.numerics.flow.compiled.leg_memory import LegMemory
from wucht.numerics.flow.compiled.machine_code import MachineCode, compile_stepper, vectors
from wucht.numerics.flow.compiled.straight_line_code import module_text
from wucht.numerics.flow.events import NOT_FINITE, LegError, SlidingError
from wucht.numerics.flow.explicit_integrator import ExplicitIntegrator
from wucht.numerics.flow.program import Numbers, Program, lower
from wucht.numerics.flow.segment_locator import SegmentLocator
from wucht.numerics.flow.segments import Segmentations
from wucht.numerics.flow.step_sizes import step_limit_error
from wucht.numerics.flow.system_code import SystemCode
from wucht.system import System, needed_definitions

WIDTH = 16  # numbers of a vector: two registers of the widest processors, so that one is in use while the other waits
_ROUNDS = 4000  # steps of all lanes between two checks whether the work is to be stopped
_MOST_IDLE = 16  # idle integrators kept: more than threads that integrate the same equations at once
# Of the system, of quantities that are sampled, of those whose largest values are located, and of the ends of segments.
_CODES = ("rates", "samplers", "peak_quantities", "event_functions")
_CONSTANTS = ("rate_constants", "sampler_constants", "peak_constants", "event_constants", "instant_constants")
# Vectors of ``LanesMemory``: so many for each state, quantity with a largest value and event, and one of each.
_OF_STATES = ("state", "queue_states", "last_sample", "next_state", "point", "error_5", "error_3")
_OF_PEAKS = ("peak_value", "best", "highest", "lowest")
_OF_EVENTS = (
    "event_values", "first_event_values", "highest_event_values", "lowest_event_values", "cool_ends", "cool_signs",
)  # fmt: skip
_OF_A_LANE = (
    "clock", "size", "is_busy", "is_new", "is_shortened", "mark", "steps", "next_sample_time", "moment", "last_sample_time",
    "queue_time", "share", "trial_size", "next_time", "is_too_long", "is_first", "longest", "shortenings", "last_change",
)  # fmt: skip
_INTEGERS_OF_A_LANE = ("members", "rows", "queue_members", "queue_rows", "stops", "standstills")


@dataclass(frozen=True)
class Quantities:
    """What is observed of motions, as expressions in a System's symbols.

    Attributes
    ----------
    values : tuple of sympy.Expr, v
        Sampled at given times.
    peaks : tuple of sympy.Expr, p
        Their largest values are located while a motion is integrated.
    """

    values: tuple[sp.Expr, ...]
    peaks: tuple[sp.Expr, ...] = ()


@dataclass(frozen=True)
class LanesResult:
    """Result of motions on lanes.

    values: (K, v, L). states: (n, L), at the end; of a motion that fails at the last sample before. times, sample_times: (L,),
    reached, and of the last sample. progress: (1 + p, L), with which the motions are continued. failures: why a motion fails,
    by lane; values and progress are undefined for these.
    """

    values: np.ndarray
    states: np.ndarray
    times: np.ndarray
    sample_times: np.ndarray
    progress: np.ndarray
    failures: Mapping[int, LegError]

    @property
    def peaks(self) -> np.ndarray:
        """The largest values (p, L), of the beginning and all that follows."""
        return self.progress[1:]


@lru_cache(maxsize=64)
def compile_batch(system: System, tolerance: float, quantities: Quantities | None = None) -> CompiledBatch:
    """Compile a System's states, and quantities or the states themselves; the same arguments give the same batch back.

    Raises ``RunError`` for a function that the C library does not have.
    """
    return CompiledBatch(system, tolerance, quantities or Quantities(system.states))


class CompiledBatch:
    """Machine code of equations and quantities; each thread acquires an integrator of its own."""

    width = WIDTH

    def __init__(self, system: System, tolerance: float, quantities: Quantities) -> None:
        self.system, groups = system, (system.derivatives, quantities.values, quantities.peaks)
        expressions = [sp.sympify(e) for group in groups for e in group]
        segmentations = Segmentations.of([*expressions, *(e for _, e in needed_definitions(system.definitions, expressions))])
        smooth = segmentations.smooth_system(system) if segmentations else system
        programs = [lower(smooth, list(map(segmentations.smooth, map(sp.sympify, g))), segmentations.symbols) for g in groups]
        self.segment_count, self.segment_width = len(segmentations.segmentations), len(segmentations.symbols)
        self.locator: SegmentLocator | None = None
        if segmentations:
            self.locator = SegmentLocator.of(SystemCode.of(smooth, segmentations, (), ()), smooth)
            programs += [self.locator.code.event_values.program, self.locator.code.instant.program]
        self.programs, names = tuple(programs), _CODES[: len(programs)]
        self.code = MachineCode.of(module_text(list(zip(names, programs, strict=False)), WIDTH), names)
        self.advance = compile_stepper(lanes_stepper.advance_lanes, WIDTH)
        self.is_angle = np.array(system.is_angle, float)
        self.tolerance = max(tolerance, SMALLEST_TOLERANCE)
        self.value_count, self.peak_count = len(quantities.values), len(quantities.peaks)
        self.peak_states = _states_of(self.programs[2])
        self._idle: deque[BatchIntegrator] = deque(maxlen=_MOST_IDLE)

    @property
    def constant_count(self) -> int:
        """Number of constants of a motion."""
        return sum(len(program.constants) for program in self.programs)

    def constant_values(self, parameter_values: Numbers) -> np.ndarray:
        """Compute the constants (k,) of a motion. Raises ``RunError`` where they are not finite."""
        values = np.append(parameter_values, np.zeros(self.segment_width))  # of segments that are located as a motion begins
        return np.concatenate([program.constant_values(values) for program in self.programs])

    def lane_constants(self, parameter_values: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Compute the constants (k, L) of motions with parameters (L, p), once for equal ones; where this fails, the reason."""
        keys = [row.tobytes() for row in parameter_values]
        column_by_key = {key: k for k, key in enumerate(dict.fromkeys(keys))}
        columns, reasons = np.full((self.constant_count, len(column_by_key)), np.nan), dict[bytes, str]()
        for key, k in column_by_key.items():
            try:
                columns[:, k] = self.constant_values(np.frombuffer(key))
            except RunError as error:
                reasons[key] = str(error)
        failures = {lane: reasons[key] for lane, key in enumerate(keys) if key in reasons} if reasons else {}
        return np.take(columns, [column_by_key[key] for key in keys], axis=1), failures

    def begin(self, count: int) -> np.ndarray:
        """Return the progress (1 + p, L) of motions that begin: sizes of their next steps, 0 where not known, and peaks."""
        return np.append(np.zeros((1, count)), np.full((self.peak_count, count), -np.inf), axis=0)

    def acquire(self) -> BatchIntegrator:
        """Return an integrator for one user alone, until it is released."""
        try:
            return self._idle.pop()
        except IndexError:
            return BatchIntegrator(self)

    def release(self, integrator: BatchIntegrator) -> None:
        """Take an integrator back for the next user: nothing of its last motion remains."""
        self._idle.append(integrator)


class BatchIntegrator:
    """An integrator of one thread: the memory in which the stepper works."""

    def __init__(self, batch: CompiledBatch) -> None:
        self.batch = batch
        n, p = len(batch.is_angle), batch.peak_count
        counts = [len(program.constants) for program in batch.programs] + [0] * (len(_CONSTANTS) - len(batch.programs))
        rows = {
            "k": ALL_STAGES * n, "dense": (DENSE_ROWS + 3) * n, "values": batch.value_count, "queue_constants": counts[1],
            "places": (lane_peaks.PLACES + 1) * p, "event_parts": (leg_memory.PARTS - 1) * 2 * batch.segment_count,
        }  # fmt: skip
        rows |= dict(zip(_CONSTANTS, counts, strict=True)) | dict.fromkeys(_OF_STATES, n) | dict.fromkeys(_OF_PEAKS, p)
        rows |= dict.fromkeys(_OF_EVENTS, 2 * batch.segment_count) | dict.fromkeys(_OF_A_LANE, 1)
        self._counts = np.zeros(3, np.int64)
        self._memory = {name: vectors(count, WIDTH) for name, count in rows.items()} | {
            "peak_states": batch.peak_states, "is_angle": batch.is_angle, "nodes": NODES,
            "row_weights": ROW_WEIGHTS, "row_places": ROW_STAGES * n, "row_begins": ROW_BEGINS,
            "counts": self._counts,
            "segments": np.zeros(batch.segment_count * WIDTH, np.int64),
            **{name: np.zeros(WIDTH, np.int64) for name in _INTEGERS_OF_A_LANE},
        }  # fmt: skip
        self._fields: dict[str, float] = {name: array.ctypes.data for name, array in self._memory.items()}
        self._fields |= {"event_functions": 0} | batch.code.addresses
        self._fields |= {"event_count": 2 * batch.segment_count, "segment_width": batch.segment_width}
        self._leg = None if batch.locator is None else ExplicitIntegrator(batch.locator.code, batch.locator, batch.tolerance)
        self._leg_arguments: list[float] = [0] * len(LegMemory._fields) if self._leg is None else self._leg.arguments({})
        self._fields |= {f"{name.removesuffix('s')}_count": count for name, count in zip(_CONSTANTS, counts, strict=True)}
        self._fields |= {"width": WIDTH, "n": n, "value_count": batch.value_count, "peak_count": p, "rounds": _ROUNDS}
        self._fields["peak_state_count"] = len(batch.peak_states)
        self._fields["tolerance"] = batch.tolerance

    def advance(
        self,
        states: np.ndarray,
        constants: np.ndarray,
        times: np.ndarray,
        check: Callable[[], None] | None = None,
        progress: np.ndarray | None = None,
    ) -> LanesResult:
        """Advance any number L of motions together over the same span of time.

        Parameters
        ----------
        states : ndarray, (n, L)
            At ``times[0]``; finite.
        constants : ndarray, (k, L)
            As ``CompiledBatch.constant_values`` computes them.
        times : ndarray, (K + 1,)
            Increasing: the beginning, and where to sample; the last is the end.
        check : callable, optional
            Called now and then; an exception that it raises ends the work.
        progress : ndarray, (1 + p, L), optional
            Of motions that are continued: that of the ``LanesResult`` before. Of those that begin if not given.
        """
        batch, count = self.batch, states.shape[1]
        ends, grid = np.array(states, float, order="C"), np.ascontiguousarray(times, float)
        values = np.empty((len(grid) - 1, batch.value_count, count))
        progress = batch.begin(count) if progress is None else np.array(progress, float, order="C")
        (times_reached, sample_times), endings = np.empty((2, count)), np.empty(count, np.int64)
        arrays = {
            "constants": np.ascontiguousarray(constants), "grid": grid, "states": ends, "samples": values, "progress": progress,
            "times": times_reached, "sample_times": sample_times, "endings": endings,
        }  # fmt: skip
        fields = self._fields | {name: array.ctypes.data for name, array in arrays.items()}
        fields |= {"member_count": count, "grid_count": len(grid), "most_steps": step_sizes.MAX_STEPS}
        arguments = [fields[name] for name in LanesMemory._fields]
        self._counts[:] = lanes_stepper.NONE_BEGUN
        while True:
            if check is not None:
                check()
            if not batch.advance(*arguments, *self._leg_arguments):
                break
        failures = {
            lane: _error_of(int(endings[lane]), len(ends), float(grid[0]), float(times_reached[lane]))
            for lane in np.flatnonzero(endings != leg_memory.END).tolist()
        }
        return LanesResult(values, ends, times_reached, sample_times, progress, failures)


def _error_of(ending: int, n: int, begin: float, time: float) -> LegError:
    """Return the error of a motion of n states that has ended before its time."""
    no_states = np.empty((n, 0))
    if ending == leg_memory.NOT_FINITE:
        return LegError(*NOT_FINITE, no_states)
    if ending == leg_memory.STANDING_STILL:
        return SlidingError(no_states)
    return step_limit_error(no_states, begin, time)


def _states_of(program: Program) -> np.ndarray:
    """Return the indices of the states that a program uses."""
    symbols = set[sp.Basic]().union(*(e.free_symbols for e in (*(e for _, e in program.lines), *program.results)))
    return np.array([i for i, state in enumerate(program.states) if state in symbols], np.int64)
