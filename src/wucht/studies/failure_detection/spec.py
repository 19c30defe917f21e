"""Spec of the study of a specimen's failure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, TableModel, composite, si, validate_table
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import MachineSignalName, Woehler, woehler_validator
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Pair, Path, Spec, Start, Tolerance, Whole

STIFFNESS = "carrier.stiffness"
MOST_POINTS, MOST_READINGS = 200, 20_000
_FEWEST_BETWEEN_ALARMS = 10.0  # readings
T = TypeVar("T", bound=TableModel)


class Failure(TableModel):
    """Fall of the stiffness with the damage of a load."""

    parameter: Path = Field(default=STIFFNESS, description="path of the falling parameter, the specimen's stiffness")
    remaining: SI[float] = si(
        "", "remaining share of the stiffness", ge=0, lt=1, help="remaining share of the stiffness after the failure"
    )
    law: Literal["drop", "linear"] = Field(default="drop", description=(
        "how the stiffness falls with Miner's sum D, `\"drop\"`: nothing until D = 1, then at once; `\"linear\"`: by the share "
        "D of the total loss, until D = 1"
    ))  # fmt: skip
    signal: MachineSignalName = Field(default="displacement", description="load of the specimen")
    direction: Literal["x", "y", "r"] | None = Field(default=None, description="direction of the load")
    woehler: Composite[Annotated[Woehler, woehler_validator("study.failure.woehler")]] = composite(
        title="Woehler line", description="Woehler line of the specimen, a table"
    )
    interval: SI[float | None] = si("s", "time between two updates of the damage", default=None, gt=0, help=(
        "time between two updates of damage and stiffness; by default the interval of the sensor"
    ))  # fmt: skip


class Sensor(TableModel):
    """Slow counter of turns, and its control chart."""

    interval: SI[float] = si("s", "time between two readings", gt=0, help=(
        "time between two readings, over which each is the mean speed of the main rotor"
    ))  # fmt: skip
    noise: SI[float] = si("rad/s", "standard deviation of a reading", gt=0)
    false_alarm_every: SI[float] = si("s", "mean time between two false alarms", gt=0)
    change: SI[float | None] = si("rad/s", "change of speed to be detected soonest", default=None, gt=0, help=(
        "change of speed to be detected soonest; by default the standard deviation of the readings, beating included"
    ))  # fmt: skip
    seed: Whole = Field(default=0, ge=0, title="seed of the noise", description="seed of the noise in the stored readings")


def _table_validator(cls: type[T], key: str, example: str) -> BeforeValidator:
    def read_table(raw: Any) -> Any:
        if isinstance(raw, Mapping):
            return validate_table(cls, raw, key)
        if raw is not None and not isinstance(raw, cls):
            raise ValueError(f"must be a table: {example}")
        return raw

    return BeforeValidator(read_table)


_FAILURE = _table_validator(
    Failure, "study.failure", "failure = { remaining = SHARE, woehler = { k = ..., ND = ..., SD = ... } }"
)
_SENSOR = _table_validator(Sensor, "study.sensor", "sensor = { interval = TIME, noise = SPEED, false_alarm_every = TIME }")


class FailureDetection(Spec):
    """Failure of a specimen, and its detection by the speed of the exciter.

    The stiffness falls by a schedule of the machine, or with the damage that its load does (``failure``).
    """

    kind: ClassVar[str] = "failure-detection"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("reading_time", "speed"), ("alarm_time", "seen"))
    solves: ClassVar[str] = FULL_EQUATIONS
    from_start: ClassVar[bool] = True

    until: SI[float] = si("s", "time", gt=0, help="time at which the run ends")
    start: Composite[Start] = composite(default_factory=dict)
    failure: Composite[Annotated[Failure | None, _FAILURE]] = composite(
        default=None,
        description="failure by the damage of a load, a table `[study.failure]`; without it by a schedule of the machine",
    )
    sensor: Composite[Annotated[Sensor, _SENSOR]] = composite(
        title="sensor of the speed", description="sensor of the speed: `[study.sensor]`"
    )
    after: SI[float | None] = si("s", "time from which on the speed is measured", default=None, ge=0, help=(
        "time from which on the speed before the failure is measured; by default the second half of the time before it"
    ))  # fmt: skip
    learning: SI[float | None] = si("s", "time over which the speed before the failure is measured", default=None, gt=0, help=(
        "time over which the speed before the failure is measured; by default until the stiffness begins to fall"
    ))  # fmt: skip
    along: Path | None = Field(default=None, description=(
        "path of a parameter over which the signal at the failure (change of speed over the standard deviation of the "
        "readings) and its largest value are computed"
    ))  # fmt: skip
    range: Composite[Pair | None] = composite(default=None, description="pair [low, high] of the parameter `along`")
    points: Whole = Field(default=21, ge=2, le=MOST_POINTS, description="number of values of the parameter `along`")
    second: Path | None = Field(default=None, description="path of another parameter, beside `along`")
    second_range: Composite[Pair | None] = composite(default=None, description="pair [low, high] of the second parameter")
    second_points: Whole = Field(default=5, ge=2, le=MOST_POINTS, description="number of values of the second parameter")
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that keys which belong together are given, and that times fit each other."""
        sensor, failure = self.sensor, self.failure
        if sensor.false_alarm_every < _FEWEST_BETWEEN_ALARMS * sensor.interval:
            least = _FEWEST_BETWEEN_ALARMS * sensor.interval
            raise InputError(
                "study.sensor.false_alarm_every", sensor.false_alarm_every, f"must be at least ten readings, {least:g}"
            )
        if self.until / sensor.interval > MOST_READINGS:
            raise InputError("study.sensor.interval", sensor.interval, f"must be at least study.until/{MOST_READINGS}")
        if failure is not None:
            failure.woehler.check("study.failure.woehler")
            ratio = sensor.interval / (failure.interval or sensor.interval)
            if abs(max(ratio, 1 / ratio) - round(max(ratio, 1 / ratio))) > 1e-9 * max(ratio, 1 / ratio):
                requirement = f"must be a multiple of study.sensor.interval ({sensor.interval:g}), or an integer fraction of it"
                raise InputError("study.failure.interval", failure.interval, requirement)
            if failure.law == "linear" and (self.learning is None or self.after is None):
                missing = "learning" if self.after is not None else "after"
                reason = "the stiffness falls from the beginning: study.after and study.learning say when to measure the speed"
                raise InputError(f"study.{missing}", None, f"this key is missing: {reason}", code="missing")
        end = (self.after or 0.0) + (self.learning or 0.0)
        if end >= self.until:
            learning = "" if self.learning is None else f"with study.learning ({self.learning:g}) "
            raise InputError("study.after", self.after, f"must {learning}be before study.until, {self.until:g}")
        for path, range_key in (("along", "range"), ("second", "second_range")):
            if (getattr(self, path) is None) != (getattr(self, range_key) is None):
                missing = path if getattr(self, path) is None else range_key
                raise InputError(
                    f"study.{missing}", None, f"this key is missing; {path} and {range_key} belong together", code="missing"
                )
        if self.second is not None and self.along is None:
            raise InputError("study.along", None, "this key is missing; second is given", code="missing")
        if self.second is not None and self.second == self.along:
            raise InputError("study.second", self.second, "must be another parameter than along")
