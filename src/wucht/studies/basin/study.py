"""Maps of the outcomes of a machine, or of the attractors of equations, over two start states or parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field

from wucht.dynamics.limit_sets.attractor_runs import AttractorRuns
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import check_given_once
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.outcome_maps import CellRuns, MapAxis, OutcomeMap, QuantityRange
from wucht.dynamics.sampling.outcome_runs import OutcomeRuns
from wucht.dynamics.system_states import refuse_machine_keys
from wucht.dynamics.work import Work
from wucht.errors import FieldError, InputError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.schema import Composite, composite
from wucht.studies import key_types as common
from wucht.studies.answer import Answer
from wucht.studies.basin.answer import Details, state_outcome_map, state_times
from wucht.studies.basin.attractor_answer import state_attractors
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
        raise ValueError("must be a table: ranges = { NAME = [low, high], ... }")
    for name, pair in entries_by_path(raw):
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise ValueError(f"must give a pair [low, high] for {name}")
    return {name: tuple(pair) for name, pair in entries_by_path(raw)}


Ranges = Annotated[dict[str, tuple[common.Value, common.Value]], BeforeValidator(_ranges)]
Prepared = tuple[OutcomeMap, tuple[str, ...], Details]  # with warnings, and what is stated further


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

    ranges: Composite[Ranges] = composite(default_factory=dict, title="ranges of further quantities", description=(
        "{name = [lo, hi]}: start states (of a machine parameters, too) that each cell draws at random; what is neither here "
        "nor in `axes` is as in `start`"
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

    def prepare(self, subject: Subject) -> Prepared:
        """Return the map, with warnings of what averaged equations omit. Raises ``InputError``."""
        runs, details = self._runs(subject)
        if self.ranges and self.refine:
            requirement = "not allowed with ranges: random starts mix the basins, and there is no border that could be refined"
            raise InputError("study.refine", self.refine, requirement)
        x, y = (self._axis(runs, letter, name) for letter, name in zip("xy", self.axes, strict=True))
        ranges = tuple(
            QuantityRange.of(runs.quantity(name, f"ranges.{name}"), pair, f"ranges.{name}")
            for name, pair in self.ranges.items()
        )
        check_given_once((x, y), self.start, "axes", "the other axis")
        check_given_once((x, y, *ranges), self.start, "ranges", "an axis or another range")
        map_ = OutcomeMap(runs, (x, y), ranges, self.seed)
        return map_, map_.doubts(), details

    def _axis(self, runs: CellRuns, letter: str, name: str) -> MapAxis:
        *ends, cells = self.axes[name]
        if runs.has_named_axes and name.removeprefix("refined_") in {"outcome", "level", *runs.readings}:
            requirement = "not allowed: a variable of the result has this name; rename the body"
            raise InputError(f"study.axes.{name}", name, requirement)
        dimension = name if runs.has_named_axes else letter
        return MapAxis.of(runs.quantity(name, f"axes.{name}"), ends, f"axes.{name}", cells=cells, dimension=dimension)

    def _runs(self, subject: Subject) -> tuple[CellRuns, Details]:
        """The runs in the cells, of a machine or of equations, and what is stated of them alone."""
        if not isinstance(subject, Machine):
            refuse_machine_keys(self, _KEYS_OF_MACHINES)
            return AttractorRuns.of(subject, self.start, self.until, self.tolerance), state_attractors
        initial_state(subject, self.start)
        parameters = tuple(name for name in (*self.axes, *self.ranges) if name in subject.parameters)
        settings = (self.model, self.inertia, self.order, self.until)
        question = EnsembleQuestion(subject, parameters, *settings, tolerance=self.tolerance)
        return OutcomeRuns(question, self.start), state_times

    def solve(self, subject: Subject, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Compute the map tile by tile, level by level."""
        map_, doubts, details = prepared
        for level in map_.compute(self.refine, work):
            yield Answer(subject.units, partial(state_outcome_map, map_, doubts, details, self.refine, level))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the maps, the refined ones if the borders are refined."""
        return figure(result)
