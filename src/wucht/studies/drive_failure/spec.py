"""The question of a drive that fails."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Spec, Start, Tolerance


class DriveFailure(Spec):
    """Let each drive in turn lose its supply in operation, and see whether the rotors stay synchronised.

    The drive that fails gives no torque, and does not brake: its rotor turns on as the vibration carries it along, or stops.
    """

    kind: ClassVar[str] = "drive-failure"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("all steady phases, and which of them are stable", {"study.kind": "synchronous-states"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    horizon: ClassVar[tuple[str, ...]] = ("until",)
    solves: ClassVar[str] = FULL_EQUATIONS

    time: SI[float | None] = si("s", "time of the failure", default=None, gt=0, help=(
        "time at which a drive loses its supply, from the start on; by default as soon as the machine runs steadily"
    ))  # fmt: skip
    until: SI[float | None] = si("s", "time after the failure", default=None, gt=0, help=(
        "time after the failure at which the run ends; by default when the machine has settled"
    ))  # fmt: skip
    begin: Literal["operation", "rest"] | None = Field(default=None, description=(
        'state at t = 0: `"operation"`, each stable synchronous configuration of the rotors; or `"rest"`, from which the '
        "drives run the machine up at the phases of `start`. By default in operation if these configurations are known"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict, description=(
        "phases of rotors and bodies: in operation they select the nearest stable configuration, at rest they are the initial "
        "state"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    @property
    def operation_settings(self) -> RunSettings:
        """Settings of the run until the failure."""
        return RunSettings(until=self.time, tolerance=self.tolerance, engine=self.engine)

    @property
    def failure_settings(self) -> RunSettings:
        """Settings of each run after it."""
        return RunSettings(until=self.until, tolerance=self.tolerance, engine=self.engine)

    def turning(self) -> str:
        """See ``Spec``."""
        return "driven by their motors, of which one loses its supply"
