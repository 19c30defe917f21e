"""Branches of steady operation over a parameter, and the curves of their folds and Hopf points in two."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from pydantic import Field

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, follow_branches
from wucht.dynamics.branches.second_parameter import SecondParameter
from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.subject import Subject
from wucht.schema import Composite, Parameter, composite
from wucht.studies.answer import Answer
from wucht.studies.key_types import Inertia, Pair, Path, Values, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import Names, Ranges
from wucht.studies.speed_curve.answer import state_speeds
from wucht.studies.speed_curve.figure import speed_figure
from wucht.studies.study import AVERAGED_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_FEWEST, _MOST = 1, 200
Prepared = tuple[Parameter, Parameter | None, BranchCase]


class SpeedCurve(Study):
    """All branches of steady operation over a parameter, from the averaged equations, with their folds and stability limits.

    002 (3.51)-(3.52), (5.1)-(5.15), figures 3.2, 5.2, 5.3, A.1.
    """

    kind = "speed-curve"
    next_questions = (
        NextQuestion(
            "the oscillations over the same parameter, and how they end",
            {"study.kind": "orbit-branch", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves = AVERAGED_EQUATIONS
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    one_of = (("second_values", "second_range"),)
    meaning = (*Study.meaning, "second", "second_range", "second_values", "show", "ranges")
    curves = (("value", "speed"), ("value", "amplitude"))
    curves_of_equations = (("value", "state"),)

    along: Path = Field(description="path of the parameter over which branches are followed")
    range: Composite[Pair]
    points: Whole = Field(default=5, description=(
        "number of values in the range at which, besides those near both ends, all steady states are searched for; each on no "
        "known branch is followed in both directions"
    ))  # fmt: skip
    only: Composite[Names | None] = composite(default=None)
    second: Path | None = Field(default=None, description="path of another parameter; with `second_values` or `second_range`")
    second_values: Composite[Values | None] = composite(
        default=None, description="values of the second parameter, whose branches share one figure"
    )
    second_range: Composite[Pair | None] = composite(default=None, description=(
        "pair [low, high] of the second parameter, over which the curves of folds and Hopf points in both parameters are "
        "followed"
    ))  # fmt: skip
    show: str | None = Field(default=None, description="state that is drawn; by default the speed, of a system its first state")
    ranges: Composite[Ranges | None] = composite(default=None)
    inertia: Inertia | None = Field(default=None, description=(
        "whether averaged equations keep the inertia of balancing bodies; false: strongly damped, Drozdetskaya (4.60)-(4.62), "
        "the default of the dimensionless machines; of other machines the default is true"
    ))  # fmt: skip

    def check(self) -> None:
        """Check the number of points, and that the keys of the second parameter are complete."""
        if not _FEWEST <= self.points <= _MOST:
            raise InputError("study.points", self.points, f"must be a whole number from {_FEWEST} to {_MOST}")
        if self.second is not None and self.second == self.along:
            raise InputError("study.second", self.second, "must be another parameter than along")
        if self.second_values is not None and not self.second_values:
            raise InputError("study.second_values", [], "must hold at least one value")
        of_second = [key for key in ("second_values", "second_range") if getattr(self, key) is not None]
        if self.second is None and of_second:
            requirement = f"this key is missing; with {of_second[0]}, give the path of a parameter"
            raise InputError("study.second", None, requirement, code="missing")
        if self.second is not None and len(of_second) != 1:
            requirement = "give one of second_values = [...] and second_range = [low, high] with second"
            raise InputError("study.second", self.second, requirement)

    def prepare(self, subject: Subject) -> Prepared:
        """Return the parameters, and the states to search and follow.

        Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations.
        """
        along = parameter_of(subject, self.along)
        bounds = checked_range(subject, along, self.range)
        second = None if self.second is None else parameter_of(subject, self.second, "second")
        plane, values = None, None
        if second is not None and self.second_range is not None:
            limits = checked_range(subject, second, self.second_range, "second_range")
            plane = SecondParameter(second.path, limits, second.value)
            if not limits[0] <= second.value <= limits[1]:
                requirement = f"must contain the value {second.value:.6g} that {second.path} has: there the curves begin"
                raise InputError("study.second_range", list(self.second_range), requirement)
        elif second is not None and self.second_values is not None:
            values = second.path, values_of(subject, second, self.second_values, "second_values")
        case = BranchCase.of(
            subject, along.path, bounds, points=self.points, only=self.only, show=self.show, ranges=self.ranges,
            inertia=self.inertia, plane=plane, second=values,
        )  # fmt: skip
        return along, second, case

    def solve(self, subject: Subject, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Follow the branches one by one."""
        along, second, case = prepared
        for findings in follow_branches(case, work):
            yield Answer(fill=partial(state_speeds, along=along, second=second, case=case, findings=findings))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw speed and amplitude over the parameter, and the curves in the plane of both."""
        return speed_figure(result)
