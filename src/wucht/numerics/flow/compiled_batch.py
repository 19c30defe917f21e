"""Many motions of the same equations at once, and what is observed of them: machine code on the lanes of vectors.

Each lane has a separate state, constants and step size: the numbers of a motion depend only on its start, to the last bit. The
stepper is the same for all systems and compiled once (``compiled.lanes_stepper``); of a system its rates and the observed
quantities are compiled.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.compiled import lanes_stepper
from wucht.numerics.flow.compiled.dormand_prince import (
    ALL_STAGES,
    DENSE_ROWS,
    NODES,
    ROW_BEGINS,
    ROW_STAGES,
    ROW_WEIGHTS,
    SMALLEST_TOLERANCE,
)
from wucht.numerics.flow.compiled.lane_memory import vectors
from wucht.numerics.flow.compiled.lanes_stepper import LanesMemory
from wucht.numerics.flow.compiled.machine_code import MachineCode, compile_stepper
from wucht.numerics.flow.compiled.straight_line_code import module_text
from wucht.numerics.flow.events import NOT_FINITE, LegError
from wucht.numerics.flow.program import Numbers, Program, lower
from wucht.numerics.flow.step_sizes import step_limit_error
from wucht.system import System

WIDTH = 16  # numbers of a vector: two registers of the widest processors, so that one is in use while the other waits
_ROUNDS = 4000  # steps of all lanes between two checks whether the work is to be stopped
_MOST_IDLE = 16  # idle integrators kept: more than threads that integrate the same equations at once
# Of the system, of quantities that are sampled, and of those whose largest values are located.
_CODES = ("rates", "samplers", "peak_quantities")
_CONSTANTS = ("rate_constants", "sampler_constants", "peak_constants")


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
class LaneFailure:
    """Failure of one motion. time: reached; error: the reason; sample_time, state (n,): of the last sample before."""

    time: float
    sample_time: float
    state: np.ndarray
    error: LegError


@dataclass(frozen=True)
class LanesResult:
    """Result of motions on lanes.

    values: (K, v, L). states: (n, L), at the end. progress: (1 + p, L), with which the motions are continued. failures: by
    lane; the arrays are undefined for these.
    """

    values: np.ndarray
    states: np.ndarray
    progress: np.ndarray
    failures: Mapping[int, LaneFailure]

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
        expressions = (system.derivatives, quantities.values, quantities.peaks)
        self.programs = tuple(lower(system, group) for group in expressions)
        self.code = MachineCode.of(module_text(list(zip(_CODES, self.programs, strict=True)), WIDTH), _CODES)
        self.advance = compile_stepper(lanes_stepper.advance_lanes, WIDTH)
        self.is_angle = np.array([float(s in system.angles) for s in system.states])
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
        return np.concatenate([program.constant_values(parameter_values) for program in self.programs])

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
        self._batch = batch
        n, p = len(batch.is_angle), batch.peak_count
        rows = {
            "k": ALL_STAGES * n, "dense": (DENSE_ROWS + 3) * n, "values": batch.value_count, "peak_value": p, "best": p,
            "highest": p, "lowest": p, "places": (lanes_stepper.PLACES + 1) * p,
        }  # fmt: skip
        counts = [len(program.constants) for program in batch.programs]
        rows |= dict(zip(_CONSTANTS, counts, strict=True))
        rows |= {"queue_constants": counts[1]} | dict.fromkeys(
            ("state", "queue_states", "last_sample", "next_state", "point", "error_5", "error_3"), n
        )
        rows |= dict.fromkeys(
            (
                "clock",
                "size",
                "is_busy",
                "is_new",
                "is_shortened",
                "mark",
                "steps",
                "next_sample_time",
                "moment",
                "last_sample_time",
                "queue_time",
            ),
            1,
        )
        self._counts = np.zeros(3, np.int64)
        self._memory = {name: vectors(count, WIDTH) for name, count in rows.items()} | {
            "peak_states": batch.peak_states, "is_angle": batch.is_angle, "nodes": NODES,
            "row_weights": ROW_WEIGHTS, "row_places": ROW_STAGES * n, "row_begins": ROW_BEGINS,
            "counts": self._counts,
            **{name: np.zeros(WIDTH, np.int64) for name in ("members", "rows", "queue_members", "queue_rows")},
        }  # fmt: skip
        self._fields: dict[str, float] = {name: array.ctypes.data for name, array in self._memory.items()}
        self._fields |= batch.code.addresses
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
        batch, count = self._batch, states.shape[1]
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
            if not batch.advance(*arguments):
                break
        failures = dict[int, LaneFailure]()
        for lane in np.flatnonzero(endings != lanes_stepper.END).tolist():
            time, no_states = float(times_reached[lane]), np.empty((len(ends), 0))
            is_broken = endings[lane] == lanes_stepper.NOT_FINITE
            error = LegError(*NOT_FINITE, no_states) if is_broken else step_limit_error(no_states, float(grid[0]), time)
            failures[lane] = LaneFailure(time, float(sample_times[lane]), ends[:, lane].copy(), error)
        return LanesResult(values, ends, progress, failures)


def _states_of(program: Program) -> np.ndarray:
    """Return the indices of the states that a program uses."""
    symbols = set[sp.Basic]().union(*(e.free_symbols for e in (*(e for _, e in program.lines), *program.results)))
    return np.array([i for i, state in enumerate(program.states) if state in symbols], np.int64)
