"""Maps of the outcomes of a machine, or of the attractors of equations, over two start states or parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.dynamics.limit_sets.attractor_maps import AttractorMap, state_axis
from wucht.dynamics.limit_sets.conservation import CONSERVATIVE, preserves_volume
from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import check_given_once
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.outcome_maps import OutcomeMap, map_axis
from wucht.dynamics.system_states import refuse_machine_keys, state_range, state_row, states_from
from wucht.dynamics.work import Work
from wucht.errors import FieldError, InputError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.schema import Composite, composite
from wucht.studies import key_types as common
from wucht.studies.answer import Answer
from wucht.studies.basin.answer import state_outcomes
from wucht.studies.basin.attractor_answer import state_attractors
from wucht.studies.basin.attractor_figure import attractor_figure
from wucht.studies.basin.figure import figure
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import EnsembleStudy, entries_by_path

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_CELLS = 2048 * 2048  # of the finest map: with four numbers per cell it takes 100 MB
_FEWEST, _MOST_HALVINGS = 2, 10
_KEYS_OF_MACHINES = ("model", "inertia", "order")


def _axes(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise FieldError("must be a table of two axes: axes = { psi = [lo, hi, cells], delta = [lo, hi, cells] }", code="table")
    axes = entries_by_path(raw)
    if len(axes) != 2 or axes[0][0] == axes[1][0]:
        names = [name for name, _ in axes]
        raise InputError("study.axes", names, "there must be two axes, of two different start states or parameters")
    for name, axis in axes:
        location = f"study.axes.{name}"
        if not isinstance(axis, list | tuple) or len(axis) != 3:
            raise InputError(location, axis, "must be [lo, hi, cells]", code="shape")
        if not common.is_whole(axis[2]) or not _FEWEST <= axis[2] <= MOST_CELLS:
            raise InputError(location, axis, f"must be a whole number of cells, at least {_FEWEST}", code="whole-number")
    return {name: (low, high, int(cells)) for name, (low, high, cells) in axes}


Axes = Annotated[
    dict[str, tuple[common.Value, common.Value, int]], BeforeValidator(_axes), Field(description="two axes of the map")
]


def _ranges(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise ValueError("must be a table: ranges = { STATE = [low, high], ... }")
    for name, pair in raw.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise ValueError(f"must give a pair [low, high] for {name}")
    return {str(name): tuple(pair) for name, pair in raw.items()}


StateRanges = Annotated[dict[str, tuple[common.Value, common.Value]], BeforeValidator(_ranges)]


class Basin(EnsembleStudy):
    """Map the outcomes of a machine over two start states or parameters: their basins and shares.

    002, section 5.5, figure 5.10. Of equations of a table [system]: their attractors over two states.
    """

    kind = "basin"
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    from_start = True
    meaning = (*EnsembleStudy.meaning, "axes")

    axes: Composite[Axes] = composite(description=(
        "{name = [lo, hi, cells]}, two of them, cell-centred: each a start state as in `start` (`psi`, `delta`, a body's name "
        "or `BODY.angle`, `BODY.speed`, `carrier.x`) or the path of a parameter. An angle over a whole turn is periodic"
    ))  # fmt: skip
    refine: common.Whole = Field(default=0, description=(
        "number of halvings of the cells at the borders: 64 x 64 cells with refine = 4 give a map of 1024 x 1024. The "
        "borders are then known to within a cell of that map; a basin that is narrower than a cell of `axes` and does not "
        "reach another one's border can be missed"
    ))  # fmt: skip

    ranges: Composite[StateRanges] = composite(default_factory=dict, title="ranges of further states", description=(
        "ranges of further states of a system, {name = [lo, hi]}, from which each cell draws its start at random; states "
        "without a range have their values of `start`"
    ))  # fmt: skip
    seed: common.Whole = Field(default=0, ge=0, title="seed of the random starts", description="seed of the random starts")

    def check(self) -> None:
        """Check that the map fits into memory, and that keys of averaged equations are given only with them."""
        super().check()
        if not 0 <= self.refine <= _MOST_HALVINGS:
            raise InputError("study.refine", self.refine, f"must be a whole number from 0 to {_MOST_HALVINGS}")
        cells = [axis[2] for axis in self.axes.values()]
        if cells[0] * cells[1] * 4**self.refine > MOST_CELLS:
            finest = " x ".join(str(n * 2**self.refine) for n in cells)
            refinement = f", halved {self.refine} times" if self.refine else ""
            requirement = f"there must be at most {MOST_CELLS} cells in the map, not {finest}"
            raise InputError("study.axes", f"{cells[0]} x {cells[1]}{refinement}", requirement)

    def prepare(self, subject: Subject) -> tuple[OutcomeMap, tuple[str, ...]] | AttractorMap:
        """Return the map; of a machine with warnings of what averaged equations omit. Raises ``InputError``."""
        return self._outcome_map(subject) if isinstance(subject, Machine) else self._attractor_map(subject)

    def _outcome_map(self, machine: Machine) -> tuple[OutcomeMap, tuple[str, ...]]:
        if self.ranges:
            raise InputError("study.ranges", dict(self.ranges), "allowed for a table [system] only", code="system-only")
        x, y = (map_axis(machine, name, definition) for name, definition in self.axes.items())
        initial_state(machine, self.start)
        check_given_once((x, y), self.start, "axes", "the other axis")
        parameters = tuple(axis.name for axis in (x, y) if axis.state is None)
        question = EnsembleQuestion(
            machine, parameters, self.model, self.inertia, self.order, self.until, tolerance=self.tolerance
        )
        map_ = OutcomeMap(question, (x, y), self.start)
        return map_, map_.omissions()

    def _attractor_map(self, subject: Subject) -> AttractorMap:
        refuse_machine_keys(self, _KEYS_OF_MACHINES)
        if preserves_volume(subject):
            raise InputError("system", subject.title or None, f"has no basins: {CONSERVATIVE}", code="conservative")
        start = states_from(subject.system, self.start, "study.start")
        x, y = (state_axis(subject, name, definition) for name, definition in self.axes.items())
        for name in (*self.axes, *self.ranges):
            if name in self.start or (name in self.axes and name in self.ranges):
                raise InputError(
                    f"study.{'start' if name in self.start else 'ranges'}.{name}", name, "the state is given twice"
                )
        if self.ranges and self.refine:
            requirement = "not allowed with ranges: random starts mix the basins, and there is no border that could be refined"
            raise InputError("study.refine", self.refine, requirement)
        starts = np.repeat(start[:, None], x.cells * y.cells, axis=1)
        random = np.random.default_rng(self.seed)
        for name, pair in self.ranges.items():
            row = state_row(subject.system, name, f"study.ranges.{name}")
            starts[row] = random.uniform(*state_range(name, pair, f"study.ranges.{name}"), starts.shape[1])
        return AttractorMap(subject, (x, y), starts, LongRunSettings(self.until, self.tolerance))

    def solve(
        self, subject: Subject, prepared: tuple[OutcomeMap, tuple[str, ...]] | AttractorMap, work: Work
    ) -> Iterator[Answer]:
        """Compute the map tile by tile, or level by level."""
        if isinstance(prepared, AttractorMap):
            for labels in prepared.compute(self.refine, work):
                yield Answer(None, partial(state_attractors, prepared, bool(self.ranges), labels))
            return
        map_, omissions = prepared
        for level in map_.compute(self.refine, work):
            yield Answer(map_.question.machine.units, partial(state_outcomes, map_, omissions, self.refine, level))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the maps, the refined ones if the borders are refined."""
        return attractor_figure(result) if "attractor_states" in result else figure(result)
