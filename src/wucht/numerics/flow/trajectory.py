"""The computed motion of a run."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.earlier_names import with_earlier_names
from wucht.numerics.flow.events import Hit


@with_earlier_names
@dataclass(frozen=True)
class Trajectory:
    """The computed motion of a run.

    Attributes
    ----------
    time : ndarray, (N,)
        In the unit of the System's time, as of the grid.
    states : ndarray, (n, N)
        In the System's order.
    quadratures : mapping of str to ndarray, (N,)
        By name, zero at the first sample of the run.
    final_parameter_values : ndarray
        At the end, in the order of the System's parameters: actions of events may have changed them.
    end_time : float
    end_state : ndarray, (n + m,)
        At the end, to continue from: the states, then the m quadratures.
    hits : tuple of Hit
        In order of time.
    stopped_by : str or None
        The name of the terminal event that ended it.
    failure : str or None
        Why it failed; the samples are those before.
    is_interrupted : bool
        True if the user stopped it.
    lowest_arguments : ndarray, (k,), optional
        The lowest value below its last breakpoint of each argument of piecewise functions, in the order of the segmentations:
        how far a contact was compressed, for one. None where the integrator does not observe it.
    is_sliding : bool
        True if it failed because it slides along a jump of the equations.
    """

    time: np.ndarray
    states: np.ndarray
    quadratures: Mapping[str, np.ndarray]
    final_parameter_values: np.ndarray
    end_time: float
    end_state: np.ndarray
    hits: tuple[Hit, ...] = ()
    stopped_by: str | None = None
    failure: str | None = None
    is_interrupted: bool = False
    lowest_arguments: np.ndarray | None = None
    is_sliding: bool = False

    @property
    def has_ended(self) -> bool:
        """True if the run cannot or should not be continued: an event, a failure, or the user stopped it."""
        return self.stopped_by is not None or self.failure is not None or self.is_interrupted

    def reraise_interrupt(self) -> Trajectory:
        """Return the trajectory. Raises ``KeyboardInterrupt`` again if the user stopped it: for a run within a larger task."""
        if self.is_interrupted:
            raise KeyboardInterrupt
        return self

    def tail(self, count: int) -> Trajectory:
        """Return the last ``count`` samples."""
        first = max(len(self.time) - count, 0)
        quadratures = {name: values[first:] for name, values in self.quadratures.items()}
        return replace(self, time=self.time[first:], states=self.states[:, first:], quadratures=quadratures)

    def subsample(self, count: int, with_last: bool = False) -> Trajectory:
        """Return every ``count``-th sample, from the first on; with_last: and the last one."""
        selection: slice | np.ndarray = slice(None, None, count)
        if with_last and (len(self.time) - 1) % count:
            selection = np.append(np.arange(0, len(self.time), count), len(self.time) - 1)
        quadratures = {name: values[selection] for name, values in self.quadratures.items()}
        return replace(self, time=self.time[selection], states=self.states[:, selection], quadratures=quadratures)

    def join(self, later: Trajectory) -> Trajectory:
        """Append a trajectory that continued from the end of this one."""
        return Trajectory.of([self, later])

    @classmethod
    def of(cls, parts: Sequence[Trajectory]) -> Trajectory:
        """Join parts, at least one, each of which continued from the end of the previous one."""
        if len(parts) == 1:
            return parts[0]
        skips = [int(len(a.time) > 0 and len(b.time) > 0 and b.time[0] <= a.time[-1]) for a, b in itertools.pairwise(parts)]
        lows = [p.lowest_arguments for p in parts if p.lowest_arguments is not None]
        new = [parts[0], *(p.tail(len(p.time) - k) if k else p for p, k in zip(parts[1:], skips, strict=True))]
        return replace(
            parts[-1],
            time=np.concatenate([p.time for p in new]),
            states=np.concatenate([p.states for p in new], axis=1),
            quadratures={name: np.concatenate([p.quadratures[name] for p in new]) for name in parts[-1].quadratures},
            hits=tuple(h for p in parts for h in p.hits),
            lowest_arguments=np.min(lows, axis=0) if lows else None,
        )
