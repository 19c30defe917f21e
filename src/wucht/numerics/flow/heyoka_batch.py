"""Many motions of the same equations at once: heyoka's Taylor method on the lanes of a SIMD register.

Each lane has a separate state, parameters and step size, independent of the others: the numbers of a motion depend only on its
start, to the last bit.
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.events import NOT_FINITE, LegError
from wucht.numerics.flow.heyoka_engine import (
    COMPACT_ABOVE,
    state_units,
    taylor_equations,
    translation,
)
from wucht.numerics.flow.program import lower
from wucht.numerics.flow.step_sizes import ignore_event, sentinels, step_limit_error
from wucht.system import System

_IDLE = 16  # idle integrators kept: more than threads that integrate the same equations at once


@dataclass(frozen=True)
class LaneFailure:
    """Failure of one motion. time: reached; error: the reason, with its samples (n, m) before."""

    time: float
    error: LegError


@dataclass(frozen=True)
class LanesResult:
    """Result of motions on lanes.

    samples: (K, n, L). states: (n, L), at the end. failures: by lane; the arrays are undefined for these.
    """

    samples: np.ndarray
    states: np.ndarray
    failures: Mapping[int, LaneFailure]


@lru_cache(maxsize=64)
def compile_batch(system: System, tolerance: float) -> HeyokaBatch:
    """Compile the batch of a System's states; the same System and tolerance give the same one back."""
    return HeyokaBatch(system, tolerance)


class HeyokaBatch:
    """Compiled equations on as many lanes as two of the processor's registers hold: an integrator that is copied for each
    thread, and idle copies for the next one. LLVM's result is cached on disk by heyoka.
    """

    def __init__(self, system: System, tolerance: float) -> None:
        import heyoka as hy

        hy.set_logger_level_critical()  # its log goes to stdout; failures are reported as outcomes
        program, units = lower(system, system.derivatives), state_units(system)
        variables, translate = translation(program, units=units)
        sentinel_events = [hy.nt_event_batch(f, callback=ignore_event) for f in sentinels(program, variables, translate)]
        # Two registers of each number: one is in use while the other waits, and half as many batches are started.
        self.width, self.program, self._units = 2 * int(hy.recommended_simd_size()), program, units
        self._idle: deque[BatchIntegrator] = deque(maxlen=_IDLE)
        self._original = hy.taylor_adaptive_batch(
            taylor_equations(program, variables, translate, units),
            np.zeros((len(variables), self.width)),
            tol=tolerance,
            compact_mode=len(program.lines) > COMPACT_ABOVE,
            **({"nt_events": sentinel_events} if sentinel_events else {}),
        )

    def lend(self) -> BatchIntegrator:
        """Lend an integrator to one user alone."""
        try:
            return self._idle.pop()
        except IndexError:
            return BatchIntegrator(copy.deepcopy(self._original), self._units, self.width)

    def give_back(self, integrator: BatchIntegrator) -> None:
        """Take an integrator back for the next user: nothing of its last motion remains."""
        self._idle.append(integrator)


class BatchIntegrator:
    """An integrator of one thread. adaptive: heyoka's, not shared. units: of its states (n,). width: number of lanes."""

    def __init__(self, adaptive: Any, units: np.ndarray, width: int) -> None:
        import heyoka as hy

        self.width, self._units, self._adaptive = width, units[:, None], adaptive
        # Views of its memory: to get them from heyoka each time costs as much as a step.
        self._state, self._pars, self._time = adaptive.state, adaptive.pars, adaptive.time
        self._bad_state = hy.taylor_outcome.err_nf_state

    def advance(
        self, states: np.ndarray, constants: np.ndarray, times: np.ndarray, check: Callable[[], None] | None = None
    ) -> LanesResult:
        """Advance any number L of motions together over the same span of time.

        Parameters
        ----------
        states : ndarray, (n, L)
            At ``times[0]``; finite.
        constants : ndarray, (k, L)
            The program's, finite.
        times : ndarray, (K + 1,)
            Increasing: the beginning, and where to sample; the last is the end.
        check : callable, optional
            Called every few lanes; an exception that it raises ends the work.
        """
        count, width = states.shape[1], self.width
        samples, end_states = np.empty((len(times) - 1, len(states), count)), np.empty(states.shape)
        grid = np.repeat(np.asarray(times, float)[:, None], width, axis=1)
        failures = dict[int, LaneFailure]()
        for first in range(0, count, width):
            if check is not None:
                check()
            lanes = slice(first, min(first + width, count))
            lane_count = lanes.stop - first
            start_states, lane_constants = states[:, lanes], constants[:, lanes]
            if lane_count < width:  # spare lanes repeat the last motion
                fill = np.minimum(np.arange(width), lane_count - 1)
                start_states, lane_constants = start_states[:, fill], lane_constants[:, fill]
            batch_samples = self._propagate(start_states, lane_constants, grid)
            if not (self._time == times[-1]).all():
                batch_samples, batch_failures = self._without_failures(batch_samples, start_states, lane_constants, grid)
                failures |= {first + lane: failure for lane, failure in batch_failures.items() if lane < lane_count}
            samples[:, :, lanes], end_states[:, lanes] = (
                batch_samples[1:, :, :lane_count],
                self._units * self._state[:, :lane_count],
            )
        return LanesResult(samples, end_states, failures)

    def _without_failures(
        self, batch_samples: np.ndarray, states: np.ndarray, constants: np.ndarray, grid: np.ndarray
    ) -> tuple[np.ndarray, dict[int, LaneFailure]]:
        """Repeat a batch that did not reach its end: samples (K + 1, n, w) of lanes that can, and the failures of the others.

        A lane that ceases to be finite stops all others. Then it is replaced by a copy of another lane,
        and all start again: so the others take the steps that they would have taken without it.
        """
        good, failures, end = np.ones(self.width, bool), dict[int, LaneFailure](), grid[-1, 0]
        while True:
            outcomes = [r[0] for r in self._adaptive.propagate_res]
            broken = [i for i, outcome in enumerate(outcomes) if outcome == self._bad_state]
            for lane in broken or np.flatnonzero(self._time != end).tolist():
                if good[lane]:
                    samples, time = _finite(batch_samples[1:, :, lane]).T.copy(), float(self._time[lane])
                    error = LegError(*NOT_FINITE, samples) if broken else step_limit_error(samples, grid[0, lane], time)
                    failures[lane] = LaneFailure(time, error)
            good[list(failures)] = False
            if not broken or not good.any():
                return batch_samples, failures
            source = np.where(good, np.arange(self.width), good.argmax())
            batch_samples = self._propagate(states[:, source], constants[:, source], grid)

    def _propagate(self, states: np.ndarray, constants: np.ndarray, grid: np.ndarray) -> np.ndarray:
        self._state[:], self._pars[:] = states / self._units, constants
        self._adaptive.set_time(float(grid[0, 0]))
        samples: np.ndarray = self._adaptive.propagate_grid(grid, max_steps=step_sizes.MAX_STEPS)[1]
        samples *= self._units
        return samples


def _finite(samples: np.ndarray) -> np.ndarray:
    """Return the samples (m, n) of (K, n) before the first that is not finite."""
    broken = ~np.isfinite(samples).all(axis=1)
    return samples[: int(broken.argmax())] if broken.any() else samples
