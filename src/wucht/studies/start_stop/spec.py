"""The question of a cycle up and down."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import MachineSignalName, Woehler, woehler_validator
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Spec, Start, Tolerance


class StartStop(Spec):
    """Run the machine up, switch its drives off, and let it run down: vibration, loads, energy and damage of a cycle."""

    kind: ClassVar[str] = "start-stop"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("what happens when it is switched off", {"study.kind": "coast-down"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    horizon: ClassVar[tuple[str, ...]] = ("until",)
    meaning: ClassVar[tuple[str, ...]] = (*Spec.meaning, "signal")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("time", "amplitude"), ("energy_time", "supplied_energy"))
    solves: ClassVar[str] = FULL_EQUATIONS
    from_start: ClassVar[bool] = True

    until: SI[float | None] = si("s", "time", default=None, gt=0, help=(
        "time at which the drives are switched off; by default when the machine has settled"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict)
    signal: MachineSignalName = Field(default="displacement", title="signal", description=(
        'load of the part, for `woehler`: `"displacement"` of the carrier, `"spring-force"`, `"bearing-force"` (of the bodies '
        'on it) or `"acceleration"`'
    ))  # fmt: skip
    direction: Literal["x", "y", "r"] | None = Field(
        default=None, description="direction of the signal, by default the first that the machine has"
    )
    woehler: Composite[Annotated[Woehler | None, woehler_validator("study.woehler")]] = composite(
        default=None, description="Woehler line for the damage, a table"
    )
    target_life: SI[float | None] = si("s", "target life", default=None, gt=0, help=(
        "time of operation that the part has to endure, between whose starts and stops the machine runs steadily"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    @property
    def start_settings(self) -> RunSettings:
        """Settings of the run-up."""
        return RunSettings(until=self.until, tolerance=self.tolerance, engine=self.engine)

    @property
    def stop_settings(self) -> RunSettings:
        """Settings of the coast-down."""
        return RunSettings(tolerance=self.tolerance, engine=self.engine)

    def check(self) -> None:
        """See ``Spec``."""
        if self.woehler is not None:
            self.woehler.check("study.woehler")
        for key in ("target_life", "direction", "signal") if self.woehler is None else ():
            if key in self.model_fields_set and getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with study.woehler", code="not-allowed")

    def turning(self) -> str:
        """See ``Spec``."""
        return "driven by its motors, then without them"
