"""The question of a speed curve."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.dynamics.branches.steady_states import BranchSettings
from wucht.errors import InputError
from wucht.schema import Composite, composite
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import Names, Ranges
from wucht.studies.spec import AVERAGED_EQUATIONS, Inertia, Pair, Path, Spec, Values, Whole

_FEWEST, _MOST = 1, 200


class SpeedCurve(Spec):
    """All branches of steady operation over a parameter, from the averaged equations, with their folds and stability limits.

    002 (3.51)-(3.52), (5.1)-(5.15), figures 3.2, 5.2, 5.3, A.1.
    """

    kind: ClassVar[str] = "speed-curve"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "the oscillations over the same parameter, and how they end",
            {"study.kind": "orbit-branch", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves: ClassVar[str] = AVERAGED_EQUATIONS
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("second_values", "second_range"),)
    meaning: ClassVar[tuple[str, ...]] = (*Spec.meaning, "second", "second_range", "second_values", "show", "ranges")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "speed"), ("value", "amplitude"))
    curves_of_equations: ClassVar[tuple[tuple[str, str], ...]] = (("value", "state"),)

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
        "whether the averaged equations keep the inertia of the balancing bodies; false: strongly damped, 002 (4.60)-(4.62), "
        "the default of the dimensionless machines; of other machines the default is true"
    ))  # fmt: skip

    @property
    def settings(self) -> BranchSettings:
        """Return the settings of the search for steady states and of their continuation."""
        return BranchSettings(self.points, self.only, self.show, self.ranges, self.inertia)

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
            raise InputError(
                "study.second",
                None,
                f"this key is missing; with {of_second[0]}, give the path of a parameter",
                code="missing",
            )
        if self.second is not None and len(of_second) != 1:
            requirement = "give one of second_values = [...] and second_range = [low, high] with second"
            raise InputError("study.second", self.second, requirement)
