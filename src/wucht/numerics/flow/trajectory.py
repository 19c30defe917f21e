"""What a run computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.numerics.flow.events import Hit


@dataclass(frozen=True)
class Trajectory:
    """What a run computed.

    time: (N,). states: (n, N), in the System's order. quadratures: an (N,) array a name, zero at the first sample.
    hits: events in order. ``end_time``, ``end_state`` (with the quadratures): where it stopped, to continue from.
    stopped_by: the name of the terminal event that ended it. failure: the sentence why it failed, with all samples before.
    interrupted: the user stopped it.
    """

    time: np.ndarray
    states: np.ndarray
    quadratures: Mapping[str, np.ndarray]
    parameters: np.ndarray
    end_time: float
    end_state: np.ndarray
    hits: tuple[Hit, ...] = ()
    stopped_by: str | None = None
    failure: str | None = None
    interrupted: bool = False

    @property
    def ended(self) -> bool:
        """Whether the run cannot or should not be continued: an event, a failure, or the user stopped it."""
        return self.stopped_by is not None or self.failure is not None or self.interrupted

    def tail(self, count: int) -> Trajectory:
        """The last ``count`` samples."""
        quadratures = {name: values[-count:] for name, values in self.quadratures.items()}
        return replace(self, time=self.time[-count:], states=self.states[:, -count:], quadratures=quadratures)

    def joined(self, later: Trajectory) -> Trajectory:
        """This trajectory followed by one that continued from its end."""
        skip = int(bool(len(self.time)) and bool(len(later.time)) and later.time[0] <= self.time[-1])
        return Trajectory(
            np.concatenate([self.time, later.time[skip:]]),
            np.concatenate([self.states, later.states[:, skip:]], axis=1),
            {k: np.concatenate([v, later.quadratures[k][skip:]]) for k, v in self.quadratures.items()},
            later.parameters,
            later.end_time,
            later.end_state,
            self.hits + later.hits,
            later.stopped_by,
            later.failure,
            later.interrupted,
        )
