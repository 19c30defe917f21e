"""Plan -> findings: the runs of all cells, then of those at the borders, halved again and again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from wucht.dynamics.sampling.ensemble_equations import why_one_by_one
from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.label_maps import cells_to_halve, halved, left_at_border
from wucht.dynamics.sampling.member_outcomes import MemberOutcomes
from wucht.dynamics.sampling.placed_members import where_possible
from wucht.dynamics.work import Work
from wucht.studies.basin.prepare import Plan

MISSING = -1  # the label of a cell that was not run yet
_TILE, _ALONE = 3968, 256  # runs: a unit of work, where they are integrated in batches and one by one
_FIRST_ROUND = 0.9  # of the runs on one level, so far as can be told before


@dataclass(frozen=True)
class Tile:
    """Runs: of cells (M,), numbered row by row, what became of each."""

    cells: np.ndarray
    members: MemberOutcomes


@dataclass(frozen=True)
class Level:
    """A map whose cells were halved so often, as far as it is computed.

    shape: (y, x). coarser: the map before, whose cells hand down what they have where none was run. asked: the cells that are
    run, numbered row by row. tiles: those that were.
    """

    halvings: int
    shape: tuple[int, int]
    coarser: Level | None
    asked: np.ndarray
    tiles: tuple[Tile, ...] = ()

    @property
    def runs(self) -> int:
        """How many."""
        return sum(len(t.cells) for t in self.tiles)

    @property
    def total_runs(self) -> int:
        """Of this map and of all before."""
        return self.runs + (self.coarser.total_runs if self.coarser is not None else 0)

    @property
    def finished(self) -> bool:
        """Whether all cells asked for were run."""
        return self.runs == len(self.asked)

    @cached_property
    def outcome(self) -> np.ndarray:
        """The place of each cell's outcome in ``OUTCOMES`` (y, x), ``MISSING`` where it is not computed."""
        return self._of("outcome", np.int8, MISSING)

    @cached_property
    def settling_time(self) -> np.ndarray:
        """(y, x), nan where it has not settled or is not computed."""
        return self._of("settling_time", float, np.nan)

    @cached_property
    def peak_amplitude(self) -> np.ndarray:
        """(y, x), nan where it is not computed."""
        return self._of("peak_amplitude", float, np.nan)

    @cached_property
    def end_time(self) -> np.ndarray:
        """How far the run was followed (y, x), nan where it is not computed."""
        return self._of("end_time", float, np.nan)

    @cached_property
    def halvings_of(self) -> np.ndarray:
        """On which level (y, x) each cell's run was made, ``MISSING`` where it is not computed."""
        own = self._blank("halvings_of", np.int8, MISSING)
        for tile in self.tiles:
            own[tile.cells] = self.halvings
        return own.reshape(self.shape)

    def _blank(self, name: str, kind: type, nothing: float) -> np.ndarray:
        """What is handed down, without the cells that are run."""
        own = np.full(self.shape, nothing, kind) if self.coarser is None else halved(getattr(self.coarser, name))
        flat: np.ndarray = own.ravel()
        flat[self.asked] = nothing
        return flat

    def _of(self, name: str, kind: type, nothing: float) -> np.ndarray:
        own = self._blank(name, kind, nothing)
        for tile in self.tiles:
            own[tile.cells] = getattr(tile.members, name)
        return own.reshape(self.shape)


@dataclass(frozen=True)
class Findings:
    """The map of the level that was reached; those before are in it."""

    last: Level

    @property
    def levels(self) -> tuple[Level, ...]:
        """All, the coarsest first."""
        level, levels = self.last, [self.last]
        while level.coarser is not None:
            level = level.coarser
            levels.insert(0, level)
        return tuple(levels)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The map after each tile."""
    shape, share = plan.shape(0), _shares(plan.spec.refine)
    level = Level(0, shape, None, np.arange(shape[0] * shape[1]))
    for halvings in range(plan.spec.refine + 1):
        part = work.part(f"level {halvings}", *share[halvings])
        if halvings:
            asked = halved(cells_to_halve(level.outcome, plan.periodic, halvings == 1))
            level = Level(halvings, plan.shape(halvings), level, np.flatnonzero(asked))
        begin, rounds = 0.0, 0  # of this level: the cells asked for at first, then those that turn out to lie at a border
        while not level.finished:
            end = begin + _FIRST_ROUND * (1 - begin) if halvings else 1.0
            for further in _completed(plan, level, part.part(f"round {rounds}", begin, end)):
                level = further
                yield Findings(level)
            begin, rounds = end, rounds + 1
            level = _followed(plan, level)
    work.report(1.0)
    yield Findings(level)


def _shares(refine: int) -> list[tuple[float, float]]:
    """Which share of the work each level is: a border twice as finely resolved has twice as many cells."""
    sizes = np.array([1.0, *(2.0 ** (k - 2) for k in range(1, refine + 1))])
    ends = np.concatenate([[0.0], np.cumsum(sizes) / sizes.sum()]).tolist()
    return list(pairwise(ends))


def _completed(plan: Plan, level: Level, work: Work) -> Iterator[Level]:
    """The level after each tile of the cells that were asked and not run yet, in whatever order they come."""
    left = level.asked[level.runs :]
    what = f"borders, level {level.halvings} of {plan.spec.refine}" if level.halvings else "all cells"
    size = _TILE if why_one_by_one(plan.question) is None else _ALONE
    cells = {f"tile {number}": left[begin : begin + size] for number, begin in enumerate(range(0, len(left), size))}
    tasks = {name: partial(run_cells, plan, level.halvings, own) for name, own in cells.items()}
    found: dict[str, Tile] = {}
    for name, members in work.units(tasks, what):
        found[name] = Tile(cells[name], members)
        yield replace(level, tiles=(*level.tiles, *(found[n] for n in cells if n in found)))


def run_cells(plan: Plan, halvings: int, cells: np.ndarray, report: Callable[[float], None]) -> MemberOutcomes:
    """What becomes of the runs of some cells (M,) of a map, by their numbers."""
    starts, values = plan.starts(halvings, cells)

    def run_(starts: np.ndarray, values: Mapping[str, np.ndarray]) -> MemberOutcomes:
        return outcomes_of(plan.question, starts, values, report=report)

    return where_possible(run_, plan.machine, starts, values)


def _followed(plan: Plan, level: Level) -> Level:
    """A level whose cells asked for were all run, with those asked for besides that lie at a border and were handed down."""
    run_ = level.halvings_of == level.halvings
    more = np.flatnonzero(left_at_border(level.outcome, run_, plan.periodic))
    return replace(level, asked=np.concatenate([level.asked, more])) if len(more) else level
