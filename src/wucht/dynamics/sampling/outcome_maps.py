"""Maps of outcomes over two quantities: the axes, the starts in the cells, and the runs in them, finer at the borders.

Of a machine the label of a cell is an outcome, of equations the attractor that its run tends to: see ``CellRuns``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, ClassVar, Protocol, Self

import numpy as np

from wucht.dynamics.parameters import Value, range_of
from wucht.dynamics.run_ups.run_variations import VariedQuantity
from wucht.dynamics.sampling.label_maps import (
    border_cells_not_run,
    cells_to_halve,
    error_bound,
    halve_cells,
    random_error,
    share,
    uncertainty,
)
from wucht.dynamics.work import TaskReport, Work

_WHOLE_TURN = 1e-4  # of a period: tolerance within which an axis over whole turns is periodic
_PROBES = 64  # cells that are checked before the first run
MISSING = -1  # number of a cell that has not been run yet
_FIRST_ROUND = 0.9  # estimated share of the first round in the runs on one level


@dataclass(frozen=True)
class QuantityRange(VariedQuantity):
    """A quantity that differs from cell to cell, and its range. low, high: its ends, in SI."""

    low: float
    high: float

    @classmethod
    def of(cls, quantity: VariedQuantity, ends: Sequence[Value], key: str, **further: Any) -> Self:
        """Build it from a quantity and its ends. Raises ``InputError`` at ``study.<key>`` where low is not below high."""
        low, high = range_of(quantity.quantity, ends, key)
        return cls(quantity.name, quantity.state, quantity.description, quantity.unit, low, high, **further)


@dataclass(frozen=True)
class MapAxis(QuantityRange):
    """An axis of a map. cells: of the coarsest map. dimension: its name in the Dataset."""

    cells: int
    dimension: str

    @property
    def is_periodic(self) -> bool:
        """True if the last cell is adjacent to the first: an angle over whole turns."""
        if self.state is None or self.state.period is None:
            return False
        turns = (self.high - self.low) / self.state.period
        return round(turns) >= 1 and abs(turns - round(turns)) < _WHOLE_TURN

    @property
    def is_angle(self) -> bool:
        """True if the axis is an angle."""
        return self.unit == "rad" or (self.state is not None and self.state.period is not None)

    def centres(self, halvings: int = 0) -> np.ndarray:
        """The centres (cells 2^halvings,) of the cells."""
        count = self.cells * 2**halvings
        return np.asarray(self.low + (self.high - self.low) * (np.arange(count) + 0.5) / count)


class CellOutcomes(Protocol):
    """What becomes of the runs in M cells."""

    @property
    def outcome(self) -> np.ndarray:
        """The number (M,) of each label."""
        ...

    @property
    def failures(self) -> tuple[tuple[int, str], ...]:
        """A sentence for each run without a result, by its index."""
        ...


class CellRuns(Protocol):
    """Where the labels of cells come from: runs of a machine to their outcomes, or of equations to their attractors.

    number_type: of the numbers of labels. has_named_axes: true where the dimensions of the map have the names of its axes.
    """

    number_type: ClassVar[type]
    has_named_axes: ClassVar[bool]

    @property
    def readings(self) -> Mapping[str, tuple[str, str]]:
        """Further numbers of each run, attributes of its outcomes, by name: words and unit."""
        ...

    @property
    def runs_in_a_unit(self) -> int:
        """The most runs in a unit of work."""
        ...

    @property
    def unstable_labels(self) -> Sequence[int]:
        """Numbers of labels that only a set of starts without area has."""
        ...

    def labels(self, numbers: np.ndarray) -> dict[int, str]:
        """Return the labels of a map, by number. numbers: of its cells."""
        ...

    def quantity(self, name: str, key: str) -> VariedQuantity:
        """Return the quantity that a name denotes. Raises ``InputError`` at ``study.<key>``."""
        ...

    def doubts(self, quantities: Sequence[VariedQuantity], places: np.ndarray) -> tuple[str, ...]:
        """Return warnings of what the runs omit. places: values (q, M) of the quantities in some cells.

        Raises ``InputError`` where no runs can be made.
        """
        ...

    def outcomes(self, quantities: Sequence[VariedQuantity], places: np.ndarray, report: TaskReport) -> CellOutcomes:
        """Return the outcomes of the runs from places (q, M)."""
        ...

    def with_outcomes(self, outcomes: Sequence[CellOutcomes]) -> Self:
        """Return the runs that know what earlier ones have found."""
        ...


@dataclass(frozen=True)
class Level:
    """A map after ``halvings`` halvings of its cells, as far as it is computed.

    shape: (y, x). coarser: the preceding map, from which cells without a run inherit their values. requested_cells: the cells
    to be run, numbered row by row. tiles: cells (M,) that have been run, each with the outcomes of their runs.
    """

    halvings: int
    shape: tuple[int, int]
    coarser: Level | None
    requested_cells: np.ndarray
    tiles: tuple[tuple[np.ndarray, CellOutcomes], ...] = ()

    @property
    def runs(self) -> int:
        """Number of runs on this level."""
        return sum(len(cells) for cells, _ in self.tiles)

    @property
    def with_coarser_ones(self) -> tuple[Level, ...]:
        """All levels, the coarsest first."""
        return (*(self.coarser.with_coarser_ones if self.coarser is not None else ()), self)

    @property
    def total_runs(self) -> int:
        """Number of runs on this and all coarser levels."""
        return sum(level.runs for level in self.with_coarser_ones)

    @property
    def members(self) -> Sequence[CellOutcomes]:
        """The outcomes of all tiles, in the order in which they were run."""
        return [members for level in self.with_coarser_ones for _, members in level.tiles]

    @property
    def is_complete(self) -> bool:
        """True if all requested cells have been run."""
        return self.runs == len(self.requested_cells)

    @cached_property
    def outcome(self) -> np.ndarray:
        """Number of each cell's label (y, x), ``MISSING`` where it is not computed."""
        return self._cell_values(lambda _level, members: members.outcome, np.int16, MISSING)

    @cached_property
    def halvings_of(self) -> np.ndarray:
        """Level (y, x) on which each cell's run was made, ``MISSING`` where it is not computed."""
        return self._cell_values(lambda level, _members: level.halvings, np.int8, MISSING)

    @property
    def is_missing(self) -> np.ndarray:
        """Mask (y, x) of the cells that are not computed."""
        return np.asarray(self.halvings_of == MISSING)

    def reading(self, name: str) -> np.ndarray:
        """Return numbers of the runs (y, x), NaN where they are not computed."""
        return self._cell_values(lambda _level, members: getattr(members, name), float, np.nan)

    def _cell_values(self, value_of: Callable[[Level, CellOutcomes], Any], kind: type, nothing: float) -> np.ndarray:
        """Values (y, x) of the runs, and those inherited from the coarser level; blank in the cells that are to be run."""
        coarser = None if self.coarser is None else self.coarser._cell_values(value_of, kind, nothing)
        values = np.full(self.shape, nothing, kind) if coarser is None else halve_cells(coarser)
        values.flat[self.requested_cells] = nothing
        for cells, members in self.tiles:
            values.flat[cells] = value_of(self, members)
        return values


@dataclass(frozen=True)
class OutcomeMap:
    """A map. axes: over x and over y. ranges: of further quantities, drawn at random in each cell, by the seed."""

    runs: CellRuns
    axes: tuple[MapAxis, MapAxis]
    ranges: tuple[QuantityRange, ...] = ()
    seed: int = 0

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Periodicity of the map along y and x."""
        return self.axes[1].is_periodic, self.axes[0].is_periodic

    @property
    def quantities(self) -> tuple[VariedQuantity, ...]:
        """All that differs from cell to cell."""
        return (*self.axes, *self.ranges)

    def shape(self, halvings: int) -> tuple[int, int]:
        """Shape of the map (y, x)."""
        return self.axes[1].cells * 2**halvings, self.axes[0].cells * 2**halvings

    def places(self, halvings: int, cells: np.ndarray) -> np.ndarray:
        """The values (q, M) of the quantities in some cells (M,), numbered row by row; random ones of the coarsest map."""
        rows, columns = np.divmod(cells, self.shape(halvings)[1])
        places = [axis.centres(halvings)[of] for axis, of in zip(self.axes, (columns, rows), strict=True)]
        random = np.random.default_rng(self.seed)
        return np.array([*places, *(random.uniform(r.low, r.high, np.prod(self.shape(0)))[cells] for r in self.ranges)])

    def doubts(self) -> tuple[str, ...]:
        """Return warnings of what the runs omit. Raises ``InputError`` where they cannot be made, or a value is forbidden."""
        rows, columns = self.shape(0)
        corners = [0, columns - 1, (rows - 1) * columns, rows * columns - 1]  # a forbidden value occurs in a corner
        cells = np.unique([*corners, *np.linspace(0, rows * columns - 1, _PROBES).astype(int)])
        return self.runs.doubts(self.quantities, self.places(0, cells))

    def errors(self, level: Level, number: int) -> tuple[float, float | None]:
        """Return the uncertainty of the share of a label in 19 of 20 cases, and its bound; None of random starts.

        Cells that only a set without area leads to belong by their area to other labels: by as much their shares may be off.
        """
        inside, unstable_labels = level.outcome == number, self.runs.unstable_labels
        if number in unstable_labels:
            return share(inside), share(inside)
        off = share(np.isin(level.outcome, unstable_labels)) if number >= 0 else 0.0
        if self.ranges:
            return random_error(inside) + off, None
        return uncertainty(inside, self.periodic) + off, error_bound(inside, self.periodic) + off

    def compute(self, refine: int, work: Work) -> Iterator[Level]:
        """Compute the map, its borders after so many halvings of the cells; yield the last level after each tile."""
        shape, shares = self.shape(0), _shares_of_work(refine)
        level = Level(0, shape, None, np.arange(shape[0] * shape[1]))
        for halvings in range(refine + 1):
            part = work.part(f"level {halvings}", *shares[halvings])
            label = f"borders, level {halvings} of {refine}" if halvings else "all cells"
            if halvings:
                mask = halve_cells(cells_to_halve(level.outcome, self.periodic, halvings == 1))
                level = Level(halvings, self.shape(halvings), level, np.flatnonzero(mask))
            begin, rounds = 0.0, 0  # of this level: first the requested cells, then those that turn out to lie at a border
            while not level.is_complete:
                end = begin + _FIRST_ROUND * (1 - begin) if halvings else 1.0
                for further in self._compute_tiles(level, label, part.part(f"round {rounds}", begin, end)):
                    level = further
                    yield level
                begin, rounds = end, rounds + 1
                level = self._with_border_cells(level)
        work.report(1.0)
        yield level

    def _compute_tiles(self, level: Level, label: str, work: Work) -> Iterator[Level]:
        """Run the remaining requested cells; yield the level after each tile, in any order."""
        remaining, size = level.requested_cells[level.runs :], self.runs.runs_in_a_unit
        runs = replace(self, runs=self.runs.with_outcomes(level.members))
        # The size is in the name: another version may choose another one, and must not read these units as its own.
        cells = {f"tile {k} of {size}": remaining[k * size : (k + 1) * size] for k in range(-(-len(remaining) // size))}
        tasks = {name: partial(runs._outcomes_of_tile, level.halvings, tile_cells) for name, tile_cells in cells.items()}
        outcomes = dict[str, CellOutcomes]()
        for name, members in work.units(tasks, label):
            outcomes[name] = members
            yield replace(level, tiles=(*level.tiles, *((cells[n], outcomes[n]) for n in cells if n in outcomes)))

    def _outcomes_of_tile(self, halvings: int, cells: np.ndarray, report: TaskReport) -> CellOutcomes:
        """Outcomes of the runs in some cells (M,) of a map, given by their numbers."""
        return self.runs.outcomes(self.quantities, self.places(halvings, cells), report)

    def _with_border_cells(self, level: Level) -> Level:
        """Request in addition the cells of a complete level that lie at a border and only have inherited values."""
        is_run = level.halvings_of == level.halvings
        more = np.flatnonzero(border_cells_not_run(level.outcome, is_run, self.periodic))
        return replace(level, requested_cells=np.concatenate([level.requested_cells, more])) if len(more) else level


def _shares_of_work(refine: int) -> list[tuple[float, float]]:
    """Share of each level in the work: a border twice as finely resolved has twice as many cells."""
    sizes = np.array([1.0, *(2.0 ** (k - 2) for k in range(1, refine + 1))])
    ends = np.concatenate([[0.0], np.cumsum(sizes) / sizes.sum()]).tolist()
    return list(pairwise(ends))
