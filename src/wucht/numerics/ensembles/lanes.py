"""Two ways to advance members over a chunk: many at once on the lanes of a register, or one by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wucht.errors import RunError
from wucht.numerics.ensembles.members import Status
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.heyoka_batch import BatchIntegrator
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Program

Check = Callable[[], None]  # raises where the work is to be given up


@dataclass(frozen=True)
class Stop:
    """Why a member goes no further. state: (n,), at the time; sentence: as in ``Ends``."""

    time: float
    state: np.ndarray
    status: Status
    sentence: str


@dataclass(frozen=True)
class Advanced:
    """Where L members are after a chunk.

    samples: (K, n, L). states: (n, L). numbers: (k, L), which actions of events may have changed. stops: by lane; of those the
    arrays say nothing.
    """

    samples: np.ndarray
    states: np.ndarray
    numbers: np.ndarray
    stops: Mapping[int, Stop]


class Lanes(Protocol):
    """What advances members, in one thread."""

    def numbers(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """What is computed with instead of parameters (L, p): (k, L), and by lane why there is none."""
        ...

    def advance(self, states: np.ndarray, numbers: np.ndarray, times: np.ndarray, check: Check) -> Advanced:
        """Advance states (n, L) from ``times[0]`` to ``times[-1]``, sampled at all but the first."""
        ...


@dataclass(frozen=True)
class Batched:
    """Many at once. names: of the states."""

    integrator: BatchIntegrator
    program: Program
    names: tuple[str, ...]

    def numbers(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """The program's constants, computed once for equal parameters."""
        known, refused = dict[bytes, np.ndarray](), dict[int, str]()
        values = np.empty((len(self.program.constants), len(parameters)))
        for lane, row in enumerate(parameters):
            key = row.tobytes()
            try:
                if key not in known:
                    known[key] = self.program.constant_values(row)
                values[:, lane] = known[key]
            except RunError as error:
                values[:, lane], refused[lane] = np.nan, str(error)
        return values, refused

    def advance(self, states: np.ndarray, numbers: np.ndarray, times: np.ndarray, check: Check) -> Advanced:
        """See ``Lanes``."""
        result = self.integrator.advance(states, numbers, times, check)
        stops = dict[int, Stop]()
        for lane, failure in result.failures.items():
            before = failure.error.samples
            last = before[:, -1] if before.shape[1] else states[:, lane]
            sentence = failure.error.sentence(failure.time, self.names, last)
            stops[lane] = Stop(float(times[before.shape[1]]), last, Status.FAILED, sentence)
        return Advanced(result.samples, result.states, numbers, stops)


@dataclass(frozen=True)
class OneByOne:
    """One after the other, with events and piecewise functions."""

    compiled: CompiledSystem

    def numbers(self, parameters: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """The parameters themselves."""
        return parameters.T.copy(), {}

    def advance(self, states: np.ndarray, numbers: np.ndarray, times: np.ndarray, check: Check) -> Advanced:
        """See ``Lanes``."""
        samples, reached = np.empty((len(times) - 1, *states.shape)), np.empty(states.shape)
        after, stops = numbers.copy(), dict[int, Stop]()
        for lane in range(states.shape[1]):
            check()
            try:
                run = integrate(self.compiled, states[:, lane], numbers[:, lane], times).uninterrupted()
            except RunError as error:  # its parameters cannot be computed with
                stops[lane] = Stop(float(times[0]), states[:, lane], Status.FAILED, str(error))
                continue
            after[:, lane], end = run.parameters, run.end_state[: len(states)]
            if run.failure is not None:
                stops[lane] = Stop(run.end_time, end, Status.FAILED, run.failure)
            elif run.stopped_by is not None:
                stops[lane] = Stop(run.end_time, end, Status.STOPPED, run.stopped_by)
            else:
                samples[:, :, lane], reached[:, lane] = run.states[:, 1:].T, end
        return Advanced(samples, reached, after, stops)
