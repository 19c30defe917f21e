"""Release of a body that is locked at first."""

from __future__ import annotations

from pydantic import model_validator

from wucht.schema import SI, TableModel, si


class Release(TableModel):
    """Release of a body from the one it turns about: at a time, or when that body reaches a speed for the first time."""

    time: SI[float | None] = si("s", "time of release", "t_0", default=None, gt=0)
    speed: SI[float | None] = si("rad/s", "speed of release", "w_0", default=None, gt=0)

    @model_validator(mode="after")
    def _check_alternatives(self) -> Release:
        if (self.time is None) == (self.speed is None):
            raise ValueError("must be either { time = ... } or { speed = ... }")
        return self
