"""The question of a stability map."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.dynamics.branches.orbit_problem import OrbitSettings
from wucht.dynamics.branches.steady_states import BranchSettings
from wucht.errors import InputError
from wucht.schema import Composite, composite
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import Names, Ranges
from wucht.studies.spec import AVERAGED_EQUATIONS, Inertia, Pair, Path, Spec, TrueOrFalse, Whole

_FEWEST, _MOST = 2, 64
_SEARCHED_VALUES = 2  # values of the first parameter at which all steady states are searched, besides those near its ends


class StabilityMap(Spec):
    """Map the steady states and modulated motions in the plane of two parameters, with their stability.

    Sought are all steady states, the modulated motions that begin where one of them is lost, and those that six runs from
    different starts reach at each place. "Nothing else" says that of the places examined, and `detection_limit` in the summary
    below which share of the plane a motion may have been missed by all of them. Places that differ though no boundary separates
    them are examined more closely; what remains between them is `not-decided`. 002, sections 5.1 to 5.3, figure 5.9a.
    """

    kind: ClassVar[str] = "stability-map"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves: ClassVar[str] = AVERAGED_EQUATIONS
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    meaning: ClassVar[tuple[str, ...]] = (
        *Spec.meaning, "second", "second_range", "cells", "ranges", "together", "eliminate", "eliminate_range",
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
        "whether the averaged equations keep the inertia of the balancing bodies; false: strongly damped, 002 (4.60)-(4.62), "
        "the default of the dimensionless machines; of other machines the default is true"
    ))  # fmt: skip
    eliminate: Path | None = Field(default=None, description=(
        "path of a third parameter. The map then shows the end of the modulated motion that begins where a stable steady "
        "state is lost, as this parameter changes further: the question that 002, section 5.2, leaves open"
    ))  # fmt: skip
    eliminate_range: Composite[Pair | None] = composite(
        default=None, description="pair [low, high] of the third parameter, `eliminate`"
    )

    @property
    def settings(self) -> BranchSettings:
        """Return the settings of the steady states."""
        return BranchSettings(_SEARCHED_VALUES, self.only, None, self.ranges, self.inertia)

    @property
    def orbit_settings(self) -> OrbitSettings:
        """Return the settings of the modulated motions."""
        return OrbitSettings(together=self.together, ranges=self.ranges, inertia=self.inertia)

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
