"""Where in a plane of parameters steady states and modulated motions exist and are stable, or how modulated motions end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from pydantic import Field

from wucht.dynamics.branches.ending_map import map_endings
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.labelled_maps import (
    LabelledMap,
    map_of_endings,
    map_of_states,
)
from wucht.dynamics.branches.state_map import StateMapCase, map_states
from wucht.dynamics.parameters import checked_range, parameter_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.subject import Subject
from wucht.schema import Composite, Parameter, composite
from wucht.studies.answer import Answer
from wucht.studies.key_types import Inertia, Pair, Path, TrueOrFalse, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import Names, Ranges
from wucht.studies.stability_map.answer import state_map
from wucht.studies.stability_map.figure import map_figure
from wucht.studies.study import AVERAGED_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_FEWEST, _MOST = 2, 64
_CELLS_OF_STATES, _CELLS_OF_ENDINGS = 12, 6  # a side, by default
_SEARCHED_VALUES = 2  # values of the first parameter at which all steady states are searched, besides those near its ends

Prepared = tuple[tuple[Parameter, ...], StateMapCase | EndingMapCase]  # parameters of the plane, and that which is eliminated


class StabilityMap(Study):
    """Map the steady states and modulated motions in the plane of two parameters, with their stability.

    Sought are all steady states, the modulated motions that begin where one of them is lost, and those that six runs from
    different starts reach at each place. "Nothing else" says that of the places examined, and `detection_limit` in the summary
    below which share of the plane a motion may have been missed by all of them. Places that differ though no boundary separates
    them are examined more closely; what remains between them is `not-decided`. 002, sections 5.1 to 5.3, figure 5.9a.
    """

    kind = "stability-map"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    solves = AVERAGED_EQUATIONS
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    meaning = (
        *Study.meaning, "second", "second_range", "cells", "ranges", "together", "eliminate", "eliminate_range",
    )  # fmt: skip

    along: Path = Field(description="path of the first parameter of the plane")
    range: Composite[Pair] = composite(description="pair [low, high] of the first parameter")
    second: Path = Field(description="path of the second parameter of the plane")
    second_range: Composite[Pair] = composite(description="pair [low, high] of the second parameter")
    cells: Whole | None = Field(default=None, description=(
        "number of cells a side, in whose centres the motions are determined; by default 12, with `eliminate` 6"
    ))  # fmt: skip
    orbits: TrueOrFalse = Field(default=True, description="whether modulated motions are searched for, too")
    together: TrueOrFalse = Field(
        default=False, description="whether equal balancing bodies keep equal phases in modulated motion"
    )
    only: Composite[Names | None] = composite(default=None)
    ranges: Composite[Ranges | None] = composite(default=None)
    inertia: Inertia | None = Field(default=None, description=(
        "whether averaged equations keep the inertia of balancing bodies; false: strongly damped, Drozdetskaya (4.60)-(4.62), "
        "the default of the dimensionless machines; of other machines the default is true"
    ))  # fmt: skip
    eliminate: Path | None = Field(default=None, description=(
        "path of a third parameter. The map then shows the end of the modulated motion that begins where a stable steady "
        "state is lost, as this parameter changes further: the question that 002, section 5.2, leaves open"
    ))  # fmt: skip
    eliminate_range: Composite[Pair | None] = composite(
        default=None, description="pair [low, high] of the third parameter, `eliminate`"
    )

    def check(self) -> None:
        """Check that the parameters differ, and that keys that belong together are complete."""
        if self.cells is not None and not _FEWEST <= self.cells <= _MOST:
            raise InputError("study.cells", self.cells, f"must be a whole number from {_FEWEST} to {_MOST}")
        if self.second == self.along:
            raise InputError("study.second", self.second, "must be another parameter than along")
        if (self.eliminate is None) != (self.eliminate_range is None):
            missing = "eliminate" if self.eliminate is None else "eliminate_range"
            raise InputError(
                f"study.{missing}", None, "this key is missing; eliminate and eliminate_range belong together", code="missing"
            )
        if self.eliminate in (self.along, self.second):
            raise InputError("study.eliminate", self.eliminate, "must be another parameter than along and second")
        if self.eliminate is not None:
            if not self.orbits:
                raise InputError("study.orbits", False, "must be true with eliminate: this map shows modulated motions")
            if self.only is not None:
                raise InputError("study.only", list(self.only), "not allowed with eliminate, which uses all steady states")

    def prepare(self, subject: Subject) -> Prepared:
        """Return the parameters, and the plane to examine.

        Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations.
        """
        along, second = parameter_of(subject, self.along), parameter_of(subject, self.second, "second")
        bounds = checked_range(subject, along, self.range), checked_range(subject, second, self.second_range, "second_range")
        if self.eliminate is None or self.eliminate_range is None:
            cells = self.cells or _CELLS_OF_STATES
            return (along, second), StateMapCase.of(
                subject, (along.path, second.path), bounds, cells, points=_SEARCHED_VALUES, only=self.only, ranges=self.ranges,
                inertia=self.inertia, orbits=self.orbits, together=self.together,
            )  # fmt: skip
        third = parameter_of(subject, self.eliminate, "eliminate")
        ends = checked_range(subject, third, self.eliminate_range, "eliminate_range")
        paths, cells = (third.path, along.path, second.path), self.cells or _CELLS_OF_ENDINGS
        return (along, second, third), EndingMapCase.of(
            subject, paths, (ends, *bounds), cells, together=self.together, ranges_of_states=self.ranges, inertia=self.inertia
        )

    def solve(self, subject: Subject, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Examine place by place, then the curves between them."""
        parameters, case = prepared
        for labelled_map in _maps(case, work):
            yield Answer(fill=partial(state_map, parameters=parameters, case=case, labelled_map=labelled_map))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the regions of the plane, the boundaries between them, and the places examined."""
        return map_figure(result)


def _maps(case: StateMapCase | EndingMapCase, work: Work) -> Iterator[Callable[[], LabelledMap]]:
    """Yield the map, to be made where it is needed, whenever it has become more complete."""
    if isinstance(case, StateMapCase):
        yield from (partial(map_of_states, case, findings) for findings in map_states(case, work))
    else:
        yield from (partial(map_of_endings, case, endings) for endings in map_endings(case, work))
