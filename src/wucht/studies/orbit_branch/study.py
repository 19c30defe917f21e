"""Modulated motions over a parameter: first orbits, their branches both ways, and how these end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.dynamics.branches.orbit_diagram import OrbitCase, follow_orbits
from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.subject import Subject
from wucht.schema import SI, Composite, Conversion, Parameter, composite, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Inertia, Pair, Path, Start, TrueOrFalse, Values
from wucht.studies.next_question import NextQuestion
from wucht.studies.orbit_branch.answer import state_orbit_branches
from wucht.studies.orbit_branch.figure import orbit_figure
from wucht.studies.shared_keys import Ranges
from wucht.studies.study import AVERAGED_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


_SETTINGS = ("start", "until", "longest", "switch", "together", "show", "ranges", "inertia")  # of the orbits


def _ensure_list(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else [value]


_SeveralValues = Annotated[Values | None, BeforeValidator(_ensure_list)]
_OneOrSeveral = float | str | Sequence[Any] | np.ndarray


class OrbitBranch(Study):
    """Modulated motions over a parameter: branches of periodic orbits of the averaged equations, and their ends.

    Of forced equations, with the phase of the forcing as a state, this is the nonlinear frequency response: the amplitude over
    the frequency, with folds where it jumps.

    002, sections 5.2 and 6.2, figures 5.6, 5.7, A.3.
    """

    kind = "orbit-branch"
    next_questions = (
        NextQuestion(
            "all branches of steady operation over the same parameter",
            {"study.kind": "speed-curve", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves = AVERAGED_EQUATIONS
    from_start = True
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    meaning = (*Study.meaning, "at", "show", "ranges", "together", "until", "longest", "switch")
    curves = (("value", "period"), ("value", "mean_speed"))
    curves_of_equations = (("value", "period"),)

    along: Path = Field(description="path of the parameter over which branches are followed")
    range: Composite[Pair]
    at: Conversion[_SeveralValues, _OneOrSeveral] = composite(default=None, description=(
        "values at which a run searches for a first orbit, from `start`; by default several, until there is one, and then the "
        "Hopf points of the steady states"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict)
    until: SI[float | None] = si("s", "time", default=None, gt=0, help="longest time of such a run")
    values: Composite[Values | None] = composite(
        default=None, description="values with orbits and exact exponents; by default ten along each branch"
    )
    longest: SI[float | None] = si("s", "period", default=None, gt=0, help=(
        "period up to which a branch is followed, by default twenty times that of the first orbit; raise it where the "
        "branch ends at this period"
    ))  # fmt: skip
    switch: TrueOrFalse = Field(
        default=False, description="whether branches from branch points and period doublings are followed"
    )
    together: TrueOrFalse = Field(default=False, description="whether equal balancing bodies keep equal phases")
    show: str | None = Field(default=None, description="state of a system that is drawn")
    ranges: Composite[Ranges | None] = composite(default=None)
    inertia: Inertia | None = Field(default=None, description=(
        "whether averaged equations keep the inertia of balancing bodies; false: strongly damped, Drozdetskaya (4.60)-(4.62), "
        "the default of the dimensionless machines where all are damped"
    ))  # fmt: skip

    def check(self) -> None:
        """Check that given lists are not empty."""
        for key in ("at", "values"):
            values = getattr(self, key)
            if values is not None and not values:
                raise InputError(f"study.{key}", [], "must have at least one value")

    def prepare(self, subject: Subject) -> tuple[Parameter, OrbitCase]:
        """Return the parameter and the orbits to search and follow.

        Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations.
        """
        along = parameter_of(subject, self.along)
        bounds = checked_range(subject, along, self.range)
        at, values = (self._values_in_range(subject, along, bounds, key) for key in ("at", "values"))
        settings = {key: getattr(self, key) for key in _SETTINGS}
        return along, OrbitCase.of(subject, along.path, bounds, run_values=at, values=values, **settings)

    def _values_in_range(
        self, subject: Subject, along: Parameter, bounds: tuple[float, float], key: str
    ) -> tuple[float, ...] | None:
        """Return the values of a key, each once, all in the range. Raises ``InputError``."""
        given_values = getattr(self, key)
        if given_values is None:
            return None
        values = values_of(subject, along, given_values, key)
        for i, value in enumerate(values):
            if not bounds[0] <= value <= bounds[1]:
                requirement = f"must lie in the range, {bounds[0]:g} to {bounds[1]:g}"
                raise InputError(f"study.{key}[{i}]", given_values[i], requirement)
        return tuple(dict.fromkeys(values))

    def solve(self, subject: Subject, prepared: tuple[Parameter, OrbitCase], work: Work) -> Iterator[Answer]:
        """Follow the branches of steady states, then those of orbits."""
        along, case = prepared
        for findings in follow_orbits(case, work):
            yield Answer(fill=partial(state_orbit_branches, along=along, case=case, findings=findings))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw extremes and period over the parameter, and some orbits."""
        return orbit_figure(result)
