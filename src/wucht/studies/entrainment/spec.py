"""Spec of the study of entrainment."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import AVERAGED_EQUATIONS, FULL_EQUATIONS, Pair, Path, Spec, Start, Value, Whole

DEFAULT_POINTS = 25
_FEWEST, _MOST = 5, 2000


class Entrainment(Spec):
    """Band of a parameter in which rotors are entrained by a vibration or by each other, and their phases."""

    kind: ClassVar[str] = "entrainment"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("all steady phases, and which of them are stable", {"study.kind": "synchronous-states"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves: ClassVar[str] = f"{FULL_EQUATIONS} for the runs, {AVERAGED_EQUATIONS} for the band of existence"
    from_start: ClassVar[bool] = True

    along: Path | None = Field(
        default=None,
        title="path of a parameter, or 'detuning': no-load speed of the second motor less the first",
        description='path of a parameter, or `"detuning"`, the no-load speed of the second rotor\'s motor less that of '
        "the first, each counted in its sense of rotation, at the same mean: positive where the second "
        "would be faster; by default the no-load speed of the main rotor's drive; for two exciters "
        '`"detuning"`; for a rotor without a drive the amplitude of the vibration',
    )
    range: Composite[Pair | None] = composite(
        default=None, description="pair [low, high] of it; by default the band of existence with a margin"
    )
    points: Whole = Field(default=DEFAULT_POINTS, description="number of runs from the start, evenly over the range")
    resolution: Value | None = Field(default=None, description="resolution of the edges, in the parameter's unit")
    start: Composite[Start] = composite(default_factory=dict)
    until: SI[float | None] = si(
        "s", "time", default=None, gt=0, help="least duration of a run; by default from the averaged equations"
    )

    def check(self) -> None:
        """Check the number of points."""
        if not _FEWEST <= self.points <= _MOST:
            raise InputError("study.points", self.points, f"must be a whole number from {_FEWEST} to {_MOST}")
