"""Runs that slide along a jump of the equations, where they switch to and fro and time stands still."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wucht.errors import RunError

_STILL, _MOST_SWITCHES = 1e-9, 200  # of a leg: a shorter advance; as many in succession


class SlidingError(RunError):
    """The motion slides along a jump of the equations from a time on."""

    def __init__(self, time: float) -> None:
        super().__init__(
            f"at t = {time:.6g} the motion slides along a jump of the equations, which have no solution beyond; replace "
            "sign(v) by a steep tanh(v/0.001)"
        )
        self.time = time

    def __reduce__(self) -> tuple[type[SlidingError], tuple[float]]:
        """Support pickling, so that the error can be raised in another process."""
        return SlidingError, (self.time,)


class SlidingGuard:
    """Report of the time reached that ends a run in which time stands still: one that switches to and fro at a jump.

    length: of the run. report: called with the time reached.
    """

    def __init__(self, length: float, report: Callable[[float], None] | None = None) -> None:
        self._least, self._report, self._count, self._last = _STILL * length, report, 0, -np.inf

    def __call__(self, time: float) -> None:
        """Count advances that are too short. Raises ``SlidingError`` after too many in succession."""
        self._count = self._count + 1 if time - self._last < self._least else 0
        self._last = time
        if self._count > _MOST_SWITCHES:
            raise SlidingError(time)
        if self._report is not None:
            self._report(time)
