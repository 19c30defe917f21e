"""When a body that is locked at first is let go."""

from __future__ import annotations

from pydantic import model_validator

from wucht.schema import Described, si


class Release(Described):
    """Until a time, or until the body it turns about has reached a speed for the first time, a body turns with that body."""

    time: float | None = si("s", "time of release", "t_0", None, gt=0)
    speed: float | None = si("rad/s", "speed of release", "w_0", None, gt=0)

    @model_validator(mode="after")
    def _one_of_both(self) -> Release:
        if (self.time is None) == (self.speed is None):
            raise ValueError("must be { time = ... } or { speed = ... }, one of both")
        return self
