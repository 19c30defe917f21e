"""A Program as a function of many points at once: each is computed alone, to the last bit the same whatever is beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from wucht.numerics.flow.compiled import available_engine
from wucht.numerics.flow.program import Program
from wucht.piecewise import PiecewiseCubic

_POINTS = 8192  # at once: they stay in the processor's cache
_REGISTERS = 64  # numbers: a whole number of vector registers of any processor


@lru_cache(maxsize=256)
def heyoka_function(program: Program) -> Any | None:
    """heyoka's function of states, constants and time; None where there is no heyoka, or no such function in it."""
    expressions = [*(e for _, e in program.lines), *program.results]
    if available_engine() != "heyoka" or any(e.has(PiecewiseCubic) for e in expressions):
        return None
    from wucht.numerics.flow.heyoka_engine import compiled_function

    return compiled_function(program)


@dataclass(frozen=True)
class ArrayFunction:
    """The results of a program that does not depend on time, at many points."""

    program: Program

    def __call__(self, states: Sequence[np.ndarray] | np.ndarray, constants: np.ndarray) -> np.ndarray:
        """Evaluate.

        Parameters
        ----------
        states : sequence of ndarray, (K, M)
            An array a state; without states an ndarray (0, K, M).
        constants : ndarray, (c, M) or (c, 1)
            The program's, of each column.

        Returns
        -------
        values : ndarray, (r, K, M)
            Not finite where the results cannot be evaluated.
        """
        if self._states is not None:  # nothing is to be computed
            return np.array([states[i] for i in self._states])
        shape = states.shape[1:] if isinstance(states, np.ndarray) else states[0].shape
        if self._compiled is None:
            with np.errstate(all="ignore"):
                values = self._interpreted(tuple(states), 0.0, constants)
            return np.array([np.broadcast_to(np.asarray(v, float), shape) for v in values])
        (count, members), results = shape, len(self.program.results)
        values, rows, known = np.empty((results, count, members)), max(1, _POINTS // members), 0
        for first in range(0, count, rows):
            part = slice(first, min(first + rows, count))
            block = (part.stop - part.start, members)
            points = block[0] * members
            if points != known:
                known, width = points, -(-points // _REGISTERS) * _REGISTERS
                x, fixed, found = (np.empty((n, width)) for n in (len(states), len(constants), results))
                x[:, points:] = fixed[:, points:] = 1.0
                fixed[:, :points].reshape(-1, *block)[:] = constants[:, None]
            for row, state in zip(x, states, strict=True):
                row[:points].reshape(block)[:] = state[part]
            # By one thread: blocks are small, and threads that ask, each for its members, are as many as processors.
            self._compiled(x, pars=fixed, outputs=found, batch_parallel=False)
            values[:, part] = found[:, :points].reshape(results, *block)
        return values

    @cached_property
    def _states(self) -> list[int] | None:
        """Which states the results are; None where one is something else."""
        places = {s: i for i, s in enumerate(self.program.states)}
        return [places[r] for r in self.program.results] if set(self.program.results) <= places.keys() else None

    @cached_property
    def _compiled(self) -> Any | None:
        return heyoka_function(self.program) if self.program.states else None

    @cached_property
    def _interpreted(self) -> Callable[..., Any]:
        return self.program.function()
