"""Spec of the study ``basin``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from wucht.errors import FieldError, InputError
from wucht.schema import Composite, composite
from wucht.studies import spec as common
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import EnsembleStudy, entries_by_path

MOST_CELLS = 2048 * 2048  # of the finest map: with four numbers per cell it takes 100 MB
_FEWEST, _MOST_HALVINGS = 2, 10


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


class Basin(EnsembleStudy, common.Spec):
    """Map the outcomes of a machine over two start states or parameters: their basins and shares.

    002, section 5.5, figure 5.10. Of equations of a table [system]: their attractors over two states.
    """

    kind: ClassVar[str] = "basin"
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    from_start: ClassVar[bool] = True
    meaning: ClassVar[tuple[str, ...]] = (*EnsembleStudy.meaning, "axes")

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
