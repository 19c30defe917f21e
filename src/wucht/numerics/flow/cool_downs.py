"""Cool-downs: just after an event its function is rounding noise around zero, which must not count as another event."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wucht.numerics.flow.events import Event
from wucht.numerics.flow.program import PointValues

_COOL_DOWN = 1e-9  # relative to the time
_AT_BREAKPOINT = 1e-12  # for arguments, and relative to the time


class CoolDowns:
    """The cool-downs of a run that has stopped at events: until when, and the sign that the event's function then takes.

    by_event: (end, sign) by the index of the event.
    """

    def __init__(self, rates: PointValues, event_values: PointValues, events: Sequence[Event]) -> None:
        self._rates, self._event_values, self._events = rates, event_values, events
        self._constants, self._event_constants = np.empty(0), np.empty(0)
        self.by_event: dict[int, tuple[float, float]] = {}

    def clear(self) -> None:
        """Forget all: another part of the run begins."""
        self.by_event.clear()

    def start(self, time: float, state: np.ndarray, constants: np.ndarray, event_constants: np.ndarray) -> None:
        """Begin a leg at a place (n,). constants: of the programs.

        Only those that have just happened: an earlier one may be about to happen again at this place. But the end of a segment
        that has just begun lies within rounding of zero: its argument counts as inside until the cool-down is over. It may then
        be outside, as where the motion slides along a jump, which drives it back from either side.
        """
        self._constants, self._event_constants = constants, event_constants
        if self.by_event:
            values = self._event_values(state, time, self._event_constants)
            recent = [i for i, (end, _) in self.by_event.items() if end >= time and self._events[i].switch is None]
            near = [i for i, e in enumerate(self._events) if e.switch is not None and abs(values[i]) <= _AT_BREAKPOINT]
            self.by_event = {i: self._cool_down(i, time, state) for i in recent}
            self.by_event |= {i: (_end(time, _AT_BREAKPOINT), -float(self._events[i].direction)) for i in near}

    def add(self, index: int, time: float, state: np.ndarray) -> None:
        """Begin the cool-down of an event that has just stopped the run."""
        self.by_event[index] = self._cool_down(index, time, state)

    def _cool_down(self, index: int, time: float, state: np.ndarray) -> tuple[float, float]:
        end = _end(time)
        later = state + (end - time) * np.asarray(self._rates(state, time, self._constants))
        value = float(self._event_values(later, end, self._event_constants)[index])
        return end, float(np.sign(value))


def _end(time: float, relative: float = _COOL_DOWN) -> float:
    return time + relative * max(1.0, abs(time))
