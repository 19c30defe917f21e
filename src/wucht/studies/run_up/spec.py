"""The question of a run-up."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, Literal

from pydantic import Field

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies import spec as common
from wucht.studies.next_question import NextQuestion
from wucht.studies.single_run import SingleRun

MOST_RUNS = 500


class RunUp(SingleRun, common.Spec):
    """Start the machine and follow its motion to the end.

    It runs ``until`` a time, for ``turns`` of the main rotor, or, without either, until it has ``settled``. Of equations of a
    table [system]: integrate them, and tell what the motion tends to.
    """

    kind: ClassVar[str] = "run-up"
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "the same run, as long as its verdict needs", {"study.until": "{advised_time:.6g}"}, ("unidentified", "unsettled")
        ),
        NextQuestion(
            "the speeds at which the motor, its load and the vibration are in balance",
            {"study.kind": "torque-balance"},
            ("captured", "captured-modulated", "not-started", "stopped"),
        ),
        NextQuestion(
            "all steady phases, and which of them are stable",
            {"study.kind": "synchronous-states"},
            ("synchronised", "not-synchronised", "balancer-captured"),
        ),
        NextQuestion("what happens when it is switched off", {"study.kind": "coast-down"}, ("compensated",)),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}, ("passed",)),
        NextQuestion("what happens when it is switched off", {"study.kind": "coast-down"}),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("time", "speed"), ("time", "amplitude"))
    curves_of_equations: ClassVar[tuple[tuple[str, str], ...]] = (("time", "states"),)
    without_inertia: ClassVar[bool] = True

    starts: Composite[common.Starts] = composite(default=(), description="several initial states: a run each, in one result")
    along: common.Path | None = Field(default=None, description="path of a parameter with several `values`")
    values: Composite[common.Values] = composite(
        default=(), description="values of the parameter `along`: a run each, in one result"
    )
    stored_samples: int | None = Field(
        default=None,
        gt=1,
        title="largest number of stored samples, of all runs together",
        description="largest number of stored samples, of all runs together; by default a million, or as many as take 240 MB",
    )
    over: Literal["time", "phi", "psi"] = Field(default="time", description=(
        "abscissa of the figure: `\"time\"`, `\"phi\"` (the rotor's angle) or `\"psi\"` (mean phase of its bodies)"
    ))  # fmt: skip
    deck: SI[float | None] = si("rad", "inclination of the deck", default=None, gt=-1.5, lt=1.5, help=(
        "inclination of a screen's deck, counter-clockwise from +x, for its throw number"
    ))  # fmt: skip

    @property
    def settings(self) -> RunSettings:
        """Return the settings of each run."""
        runs = len(self.starts or [0]) * len(self.values or [0])
        return replace(super().settings, stored_samples=self.stored_samples, runs=runs)

    def check(self) -> None:
        """Check that start and starts exclude each other, and that along comes with values."""
        if self.starts and self.start:
            raise InputError("study.starts", None, "give either start or starts")
        if bool(self.values) != (self.along is not None):
            missing = "values" if self.along is not None else "along"
            raise InputError(
                f"study.{missing}", None, "this key is missing; along = PATH and values = [...] belong together", code="missing"
            )
        if len(self.starts or [0]) * len(self.values or [0]) > MOST_RUNS:
            raise InputError("study.values", len(self.values), f"there must be at most {MOST_RUNS} runs, starts times values")
        super().check()
