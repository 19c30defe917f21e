"""Events that coincide with an interruption, or with the end of a leg: one rule for all of them.

Rounding decides whether a function passes zero just before or just after a breakpoint at the same instant, and an integrator
may report both events, one, or none. So events within rounding of an interruption are decided there: an event happens if the
signs of its function just before, by the equations until then, and just after, by those from then on, are opposite. A function
that only touches zero does not pass it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.numerics.flow.compiled.segment_changes import AHEAD, ROUNDING
from wucht.numerics.flow.program import Numbers
from wucht.numerics.flow.system_code import SystemCode

_SAME_PASSAGE = 4e-12  # relative to the time: so long a passage of zero is the one that was decided; integrators rest for 1e-12


def same_instant_until(time: float) -> float:
    """Return the time until which rounding does not separate an instant from this one."""
    return time + _SAME_PASSAGE * max(1.0, abs(time))


@dataclass(frozen=True)
class Coincidence:
    """The events within rounding of an instant.

    ends: by the index of the event, the time until which its passage of zero is this one. before, after: the signs of its
    function.
    """

    time: float
    ends: dict[int, float]
    before: dict[int, float]
    after: dict[int, float]

    @classmethod
    def at(cls, code: SystemCode, time: float, state: np.ndarray, before: Numbers, after: Numbers) -> Coincidence:
        """Return the events at an instant. before, after: the parameters of the equations until then, and from then on.

        None where the equations cannot be evaluated around it: then the integrator alone has located what happens.
        """
        m = code.request_count
        values, earlier = code.lookahead(time, state, before, -1)
        with np.errstate(all="ignore"):
            changes = np.abs(values - earlier)[:m] / AHEAD  # in a time of 1, or in as long as it is until now
            noise = ROUNDING * np.maximum(values[m : 2 * m], changes)
            # A function that was zero before has not come to this instant: it passes zero when it leaves it.
            near = (np.abs(values[:m]) <= noise) & (changes > 0)
            if not near.any():
                return cls(time, {}, {}, {})
            _, later = code.lookahead(time, state, after)
            ends = time + max(1.0, abs(time)) * np.maximum(_SAME_PASSAGE, 4 * noise / changes)
        columns = ({i: float(x[i]) for i in np.flatnonzero(near).tolist()} for x in (ends, np.sign(earlier), np.sign(later)))
        return cls(time, *columns)

    def includes(self, index: int, time: float) -> bool:
        """True if a passage of zero at a time is the one of this instant."""
        return index in self.ends and abs(time - self.time) <= self.ends[index] - self.time

    def happens(self, index: int, direction: int) -> bool:
        """True if the function of an event passes zero in a direction; 0: in either."""
        return self.before[index] * self.after[index] < 0 and direction * self.after[index] >= 0

    def is_touched(self, index: int) -> bool:
        """True if the function of an event comes to zero and goes back."""
        return index in self.ends and self.before[index] * self.after[index] > 0
