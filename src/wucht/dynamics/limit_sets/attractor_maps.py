"""Maps of the attractors of equations of a table ``[system]`` over two states, finer at the borders of the basins."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.basins import start_outcomes
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.sampling.label_maps import border_cells_not_run, cells_to_halve, halve_cells
from wucht.dynamics.system_states import state_range, state_row
from wucht.dynamics.work import Work
from wucht.machines.subject import Subject
from wucht.numerics.angles import TURN

_WHOLE_TURN = 1e-4  # of a turn


@dataclass(frozen=True)
class StateAxis:
    """An axis of a map. row: of the state in the equations."""

    name: str
    row: int
    low: float
    high: float
    cells: int
    is_angle: bool

    @property
    def is_periodic(self) -> bool:
        """True if the last cell is adjacent to the first: an angle over whole turns."""
        turns = (self.high - self.low) / TURN
        return self.is_angle and round(turns) >= 1 and abs(turns - round(turns)) < _WHOLE_TURN

    def centres(self, halvings: int = 0) -> np.ndarray:
        """The centres (cells 2^halvings,) of the cells."""
        count = self.cells * 2**halvings
        return np.asarray(self.low + (self.high - self.low) * (np.arange(count) + 0.5) / count)


def state_axis(subject: Subject, name: str, definition: tuple[object, object, int]) -> StateAxis:
    """Build an axis from the name of a state. Raises ``InputError`` at ``study.axes.<name>``."""
    location = f"study.axes.{name}"
    row = state_row(subject.system, name, location)
    low, high = state_range(name, definition, location, "must be [lo, hi, cells] with lo below hi")
    return StateAxis(name, row, low, high, definition[2], subject.system.states[row] in subject.system.angles)


@dataclass(frozen=True, eq=False)
class AttractorLabels:
    """A map after some halvings of its cells. labels: (y, x) numbers in ``attractors``, as those of ``StartOutcomes``.

    coarsest: the map before any halving. runs: of all maps together. failures: starts (n,) without a result, with the reason.
    """

    labels: np.ndarray
    attractors: tuple[LimitSet, ...]
    coarsest: np.ndarray
    runs: int
    halvings: int = 0
    failures: tuple[tuple[np.ndarray, str], ...] = ()


@dataclass(frozen=True, eq=False)
class AttractorMap:
    """A map. axes: over x and over y. base: (n, M), the start in each cell, row by row, but for the states of the axes."""

    subject: Subject
    axes: tuple[StateAxis, StateAxis]
    base: np.ndarray
    settings: LongRunSettings

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Periodicity of the map along y and x."""
        return self.axes[1].is_periodic, self.axes[0].is_periodic

    def shape(self, halvings: int = 0) -> tuple[int, int]:
        """Shape of the map (y, x)."""
        return self.axes[1].cells * 2**halvings, self.axes[0].cells * 2**halvings

    def starts(self, halvings: int, cells: np.ndarray) -> np.ndarray:
        """Initial states (n, M) of the runs in some cells (M,) of a map, numbered row by row."""
        rows, columns = np.divmod(cells, self.shape(halvings)[1])
        of_coarsest = (rows >> halvings) * self.shape()[1] + (columns >> halvings)
        starts = self.base[:, of_coarsest]
        for axis, places in zip(self.axes, (columns, rows), strict=True):
            starts[axis.row] = axis.centres(halvings)[places]
        return starts

    def compute(self, refine: int, work: Work) -> Iterator[AttractorLabels]:
        """Yield the map after each halving of the cells at the borders."""
        labels = np.empty(self.shape(), int)
        attractors, runs, coarsest, failures = tuple[LimitSet, ...](), 0, labels, list[tuple[np.ndarray, str]]()
        for halvings in range(refine + 1):
            part = work.part(f"level {halvings}", halvings / (refine + 1), (halvings + 1) / (refine + 1))
            cells, rounds = np.arange(labels.size), 0
            if halvings:
                mask = halve_cells(cells_to_halve(labels, self.periodic, halvings == 1))
                labels, cells = halve_cells(labels), np.flatnonzero(mask)
            is_run = np.zeros(labels.shape, bool)
            while len(cells):
                report = partial(_report_share, part, "borders" if halvings else "all cells")
                starts = self.starts(halvings, cells)
                unit = partial(start_outcomes, self.subject, starts, self.settings, report, attractors)
                outcomes = part.unit(f"round {rounds}", unit)
                labels.flat[cells], is_run.flat[cells] = outcomes.labels, True
                attractors, runs, rounds = outcomes.attractors, runs + len(cells), rounds + 1
                failures += [(starts[:, member], reason) for member, reason in outcomes.reasons]
                cells = np.flatnonzero(border_cells_not_run(labels, is_run, self.periodic)) if halvings else cells[:0]
            coarsest = coarsest if halvings else labels.copy()
            yield AttractorLabels(labels, attractors, coarsest, runs, halvings, tuple(failures))


def _report_share(work: Work, activity: str, share: float) -> None:
    work.open_ended.report(share, activity)
