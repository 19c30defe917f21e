"""The band reached from the start: both edges by bisection, and a look around them for gaps and islands."""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wucht.studies.entrainment.runs import RunFromStart

_PROBES = 8  # runs to each side of an edge, over the distance of two values of the scan


@dataclass(frozen=True)
class CaptureBand:
    """The values between which runs from the start end taken along; an edge is None where it lies beyond what was looked at.

    islands: other such bands that were met, (low, high) of values that were run.
    """

    low: float | None
    high: float | None
    islands: tuple[tuple[float, float], ...] = ()


class CaptureSearch:
    """The search for the band around the machine's own value, else for the widest one.

    ``runs``: all so far, in increasing order of their value. ``values`` says what to run next; each run is to be added before
    the next value is asked for. Around the edges it is looked once more: the boundary of a basin often has gaps and islands.
    """

    def __init__(self, own: float, resolution: float) -> None:
        self.runs: list[RunFromStart] = []
        self._own, self._resolution = own, resolution

    def add(self, run: RunFromStart) -> None:
        """Take a run into account."""
        insort(self.runs, run, key=lambda r: r.value)

    def values(self) -> Iterator[float]:
        """The values to run after a scan of the range, until both edges are known to the resolution."""
        first, last = self.runs[0].value, self.runs[-1].value
        apart = (last - first) / max(len(self.runs) - 1, 1)
        for side in (-1, 1):
            yield from self._bisection(side)
            edge = self._edge(side)
            if edge is None:
                continue
            for share in (np.arange(_PROBES) + 0.5) / _PROBES:
                yield from (float(v) for v in (edge - share * apart, edge + share * apart) if first < v < last)
        for side in (-1, 1):
            yield from self._bisection(side)

    @property
    def band(self) -> CaptureBand | None:
        """The band as far as it is known; None where none of the runs is taken along."""
        chosen = self._chosen
        if chosen is None:
            return None
        islands = tuple((self.runs[g[0]].value, self.runs[g[-1]].value) for g in self._groups if g != chosen)
        return CaptureBand(self._edge(-1), self._edge(1), islands)

    def _bisection(self, side: int) -> Iterator[float]:
        """The values that narrow an edge below (-1) or above (+1) down to the resolution."""
        while (bracket := self._bracket(side)) is not None:
            middle = sum(bracket) / 2
            if abs(bracket[0] - bracket[1]) <= self._resolution or middle in bracket:
                return
            yield middle

    def _edge(self, side: int) -> float | None:
        bracket = self._bracket(side)
        return None if bracket is None else sum(bracket) / 2

    def _bracket(self, side: int) -> tuple[float, float] | None:
        """The last value of the band below or above and its neighbour beyond; None where there is none."""
        chosen = self._chosen
        if chosen is None:
            return None
        inside = chosen[0] if side < 0 else chosen[-1]
        if not 0 <= inside + side < len(self.runs):
            return None
        return self.runs[inside].value, self.runs[inside + side].value

    @property
    def _groups(self) -> list[list[int]]:
        """Indices of neighbours that are taken along."""
        groups: list[list[int]] = []
        for k, run in enumerate(self.runs):
            if run.entrained and groups and groups[-1][-1] == k - 1:
                groups[-1].append(k)
            elif run.entrained:
                groups.append([k])
        return groups

    @property
    def _chosen(self) -> list[int] | None:
        groups, values = self._groups, [r.value for r in self.runs]
        mine = next((g for g in groups if values[g[0]] <= self._own <= values[g[-1]]), None)
        return mine or max(groups, key=lambda g: values[g[-1]] - values[g[0]], default=None)
