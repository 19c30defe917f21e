"""What a run computed."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
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
        return Trajectory.of([self, later])

    @classmethod
    def of(cls, parts: Sequence[Trajectory]) -> Trajectory:
        """One trajectory of parts, at least one, each of which continued from the end of that before."""
        last = parts[-1]
        skips = [0] + [
            int(bool(len(a.time)) and bool(len(b.time)) and b.time[0] <= a.time[-1]) for a, b in itertools.pairwise(parts)
        ]
        return replace(
            last,
            time=np.concatenate([p.time[k:] for p, k in zip(parts, skips, strict=True)]),
            states=np.concatenate([p.states[:, k:] for p, k in zip(parts, skips, strict=True)], axis=1),
            quadratures={
                name: np.concatenate([p.quadratures[name][k:] for p, k in zip(parts, skips, strict=True)])
                for name in last.quadratures
            },
            hits=tuple(h for p in parts for h in p.hits),
        )
