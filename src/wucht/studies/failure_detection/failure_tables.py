"""The tables of keys of a failure: the fall of the stiffness with its damage, and the sensor of the speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BeforeValidator, Field

from wucht.schema import SI, Composite, TableModel, composite, si, validate_table
from wucht.studies.key_types import Path, Whole
from wucht.studies.shared_keys import MachineSignalName, Woehler, woehler_validator

T = TypeVar("T", bound=TableModel)


class Failure(TableModel):
    """Fall of the stiffness with the damage of a load."""

    parameter: Path = Field(default="carrier.stiffness", description="path of the falling parameter, the specimen's stiffness")
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


FAILURE = _table_validator(
    Failure, "study.failure", "failure = { remaining = SHARE, woehler = { k = ..., ND = ..., SD = ... } }"
)
SENSOR = _table_validator(Sensor, "study.sensor", "sensor = { interval = TIME, noise = SPEED, false_alarm_every = TIME }")
