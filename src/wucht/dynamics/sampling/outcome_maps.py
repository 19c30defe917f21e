"""Maps of outcomes over two quantities: the axes, the starts in the cells, and the runs in them, finer at the borders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from wucht.dynamics.parameters import Value, range_of
from wucht.dynamics.run_ups.run_variations import VariedQuantity, varied_quantity
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle, is_screened
from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.ensembles import (
    EnsembleQuestion,
    MemberOutcomes,
    Report,
    Start,
    initial_states,
    omission_warnings,
    run_possible,
    unrunnable_members,
)
from wucht.dynamics.sampling.label_maps import border_cells_not_run, cells_to_halve, halve_cells
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine

VARIABLES = ("outcome", "settling_time", "peak_amplitude", "end_time", "level")  # of a map; axes must have other names
_WHOLE_TURN = 1e-4  # of a period: tolerance within which an axis over whole turns is periodic
_PROBES = 64  # cells that are checked before the first run
MISSING = -1  # label of a cell that has not been run yet
# Runs in a unit of work: those that are screened in batches; those that are each followed until the end, which take far longer.
_TILE, _SMALL_TILE = {"full": 8192, "slow": 32_768}, 256
_FIRST_ROUND = 0.9  # estimated share of the first round in the runs on one level


@dataclass(frozen=True)
class MapAxis(VariedQuantity):
    """An axis of a map. low, high: its ends, in SI. cells: of the coarsest map."""

    low: float
    high: float
    cells: int

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


def map_axis(machine: Machine, name: str, definition: tuple[Value, Value, int]) -> MapAxis:
    """Build an axis from its name, which is that of a dimension of the map. Raises ``InputError`` at ``study.axes.<name>``."""
    key = f"axes.{name}"
    if name.removeprefix("refined_") in VARIABLES:
        raise InputError(f"study.{key}", name, "not allowed: a variable of the result has this name; rename the body")
    variable = varied_quantity(machine, name, key)
    low, high = range_of(variable.quantity, definition[:2], key)
    return MapAxis(variable.name, variable.state, variable.description, variable.unit, low, high, definition[2])


@dataclass(frozen=True)
class TileOutcomes:
    """Outcomes of the runs in some cells (M,), numbered row by row."""

    cells: np.ndarray
    members: MemberOutcomes


@dataclass(frozen=True)
class Level:
    """A map after ``halvings`` halvings of its cells, as far as it is computed.

    shape: (y, x). coarser: the preceding map, from which cells without a run inherit their values. requested_cells: the cells
    to be run, numbered row by row. tiles: those that have been run.
    """

    halvings: int
    shape: tuple[int, int]
    coarser: Level | None
    requested_cells: np.ndarray
    tiles: tuple[TileOutcomes, ...] = ()

    @property
    def runs(self) -> int:
        """Number of runs on this level."""
        return sum(len(t.cells) for t in self.tiles)

    @property
    def with_coarser_ones(self) -> tuple[Level, ...]:
        """All levels, the coarsest first."""
        return (*(self.coarser.with_coarser_ones if self.coarser is not None else ()), self)

    @property
    def total_runs(self) -> int:
        """Number of runs on this and all coarser levels."""
        return self.runs + (self.coarser.total_runs if self.coarser is not None else 0)

    @property
    def is_complete(self) -> bool:
        """True if all requested cells have been run."""
        return self.runs == len(self.requested_cells)

    @cached_property
    def outcome(self) -> np.ndarray:
        """Index of each cell's outcome in ``OUTCOMES`` (y, x), ``MISSING`` where it is not computed."""
        return self._cell_values("outcome", np.int8, MISSING)

    @cached_property
    def settling_time(self) -> np.ndarray:
        """Settling times (y, x), NaN where the run has not settled or is not computed."""
        return self._cell_values("settling_time", float, np.nan)

    @cached_property
    def peak_amplitude(self) -> np.ndarray:
        """Peak amplitudes (y, x), NaN where they are not computed."""
        return self._cell_values("peak_amplitude", float, np.nan)

    @cached_property
    def end_time(self) -> np.ndarray:
        """Times until which the runs were integrated (y, x), NaN where they are not computed."""
        return self._cell_values("end_time", float, np.nan)

    @cached_property
    def halvings_of(self) -> np.ndarray:
        """Level (y, x) on which each cell's run was made, ``MISSING`` where it is not computed."""
        levels = self._inherited_values("halvings_of", np.int8, MISSING)
        for tile in self.tiles:
            levels[tile.cells] = self.halvings
        return levels.reshape(self.shape)

    def _inherited_values(self, name: str, kind: type, nothing: float) -> np.ndarray:
        """Values inherited from the coarser level, blank in the cells that are run."""
        values = np.full(self.shape, nothing, kind) if self.coarser is None else halve_cells(getattr(self.coarser, name))
        flat: np.ndarray = values.ravel()
        flat[self.requested_cells] = nothing
        return flat

    def _cell_values(self, name: str, kind: type, nothing: float) -> np.ndarray:
        values = self._inherited_values(name, kind, nothing)
        for tile in self.tiles:
            values[tile.cells] = getattr(tile.members, name)
        return values.reshape(self.shape)


@dataclass(frozen=True)
class OutcomeMap:
    """A map. question: for the run in each cell. axes: over x and over y. start: the rest of the start."""

    question: EnsembleQuestion
    axes: tuple[MapAxis, MapAxis]
    start: Start

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Periodicity of the map along y and x."""
        return self.axes[1].is_periodic, self.axes[0].is_periodic

    def shape(self, halvings: int) -> tuple[int, int]:
        """Shape of the map (y, x)."""
        return self.axes[1].cells * 2**halvings, self.axes[0].cells * 2**halvings

    def starts(self, halvings: int, cells: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Initial states (n, M) of the runs in some cells (M,) of a map, and the values (M,) of each parameter.

        cells: numbered row by row. Raises ``InputError`` for a value that the machine does not allow.
        """
        rows, columns = np.divmod(cells, self.shape(halvings)[1])
        places = np.array([axis.centres(halvings)[of] for axis, of in zip(self.axes, (columns, rows), strict=True)])
        return initial_states(self.question.machine, self.start, self.axes, places, "study.axes")

    def place(self, cell: int, halvings: int = 0) -> tuple[float, float]:
        """The centre (x, y) of a cell."""
        row, column = divmod(cell, self.shape(halvings)[1])
        return float(self.axes[0].centres(halvings)[column]), float(self.axes[1].centres(halvings)[row])

    def omissions(self) -> tuple[str, ...]:
        """Warnings about the effects that the averaged equations omit.

        Raises ``InputError`` if there are no such equations, if nothing would turn, and if a cell has a forbidden value.
        """
        rows, columns = self.shape(0)
        corners = [0, columns - 1, (rows - 1) * columns, rows * columns - 1]  # a forbidden value occurs in a corner
        cells = np.unique([*corners, *np.linspace(0, rows * columns - 1, _PROBES).astype(int)])
        impossible_members = unrunnable_members(self.question.machine, *self.starts(0, cells))
        place = self.place(int(next((c for m, c in enumerate(cells) if m not in impossible_members), 0)))
        return omission_warnings(self.question, self.start, self.axes, place)

    def compute(self, refine: int, work: Work) -> Iterator[Level]:
        """Compute the map, its borders after so many halvings of the cells; yield the last level after each tile."""
        shape, share = self.shape(0), _shares_of_work(refine)
        level = Level(0, shape, None, np.arange(shape[0] * shape[1]))
        for halvings in range(refine + 1):
            part = work.part(f"level {halvings}", *share[halvings])
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
        remaining = level.requested_cells[level.runs :]
        is_fast = batching_obstacle(self.question) is None and is_screened(self.question.machine)
        size = _TILE[self.question.model] if is_fast else _SMALL_TILE
        # The size is in the name: another version may choose another one, and must not read these units as its own.
        cells = {f"tile {k} of {size}": remaining[k * size : (k + 1) * size] for k in range(-(-len(remaining) // size))}
        tasks = {name: partial(self._outcomes_of_tile, level.halvings, tile_cells) for name, tile_cells in cells.items()}
        tiles: dict[str, TileOutcomes] = {}
        for name, members in work.units(tasks, label):
            tiles[name] = TileOutcomes(cells[name], members)
            yield replace(level, tiles=(*level.tiles, *(tiles[n] for n in cells if n in tiles)))

    def _outcomes_of_tile(self, halvings: int, cells: np.ndarray, report: Report) -> MemberOutcomes:
        """Outcomes of the runs in some cells (M,) of a map, given by their numbers."""
        starts, values = self.starts(halvings, cells)

        def run(starts: np.ndarray, values: Mapping[str, np.ndarray]) -> MemberOutcomes:
            return outcomes_of(self.question, starts, values, report=report)

        return run_possible(run, self.question.machine, starts, values)

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
