"""The keys of studies that start a machine once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.errors import InputError
from wucht.schema import SI, Composite, Conversion, composite, refuse_unknown, si
from wucht.studies import key_types as common
from wucht.studies.study import Study

_ENDS = ("until", "turns", "settled")


class SingleRun(Study):
    """The keys of a study that starts the machine once: duration of the run, initial state, and equations."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (_ENDS,)
    horizon: ClassVar[tuple[str, ...]] = _ENDS
    from_start: ClassVar[bool] = True

    until: Conversion[float | None, str | Mapping[str, Any]] = si(
        "s", "time", default=None, gt=0, help="end of the run; or `turns`, or `settled`, the default"
    )
    turns: SI[float | None] = si(
        "", "number of turns", default=None, gt=0, help="turns of the main rotor until the end of the run"
    )
    settled: common.TrueOrFalse | None = Field(
        default=None, description="whether the run ends when the machine has settled, the default without a time or turns"
    )
    start: Composite[common.Start] = composite(default_factory=dict)
    model: Literal["full", "slow", "both"] = Field(
        default="full", description='equations: `"full"`, averaged (`"slow"`), or `"both"`'
    )
    inertia: common.Inertia | None = None
    order: common.Order = 1
    tolerance: common.Tolerance = common.DEFAULT_TOLERANCE
    speed_limit: SI[float | None] = si(
        "rad/s", "speed", default=None, gt=0, help="speed beyond which the run ends as `runaway`"
    )
    engine: common.Engine | None = None

    @model_validator(mode="before")
    @classmethod
    def _expand_until(cls, raw: Any) -> Any:
        """Accept ``until = "settled"`` and ``until = { turns = 300 }``."""
        if not isinstance(raw, Mapping):
            return raw
        until = raw.get("until")
        until = {"settled": True} if until == "settled" else until
        if not isinstance(until, Mapping):
            return raw
        refuse_unknown(until, ("turns", "settled"), "study.until")
        if not until:
            raise InputError("study.until", {}, "must be a time, { turns = NUMBER } or { settled = true }")
        return {k: v for k, v in raw.items() if k != "until"} | dict(until)

    @property
    def settings(self) -> RunSettings:
        """Settings of the run-up."""
        keys = ("until", "turns", "model", "inertia", "order", "tolerance", "speed_limit", "engine")
        return RunSettings(**{key: getattr(self, key) for key in keys})

    def check(self) -> None:
        """Check that one end is given, and that keys of averaged equations are given only with them."""
        if sum(x is not None for x in (self.until, self.turns, self.settled or None)) > 1:
            raise InputError("study.until", None, "must be one of until, turns and settled")
        if self.settled is False and self.until is None and self.turns is None:
            raise InputError("study.settled", False, "must be true, unless until = a time or turns = a number is given")
        if self.model == "full":
            for key in ("inertia", "order"):
                if key in self.model_fields_set and getattr(self, key) is not None:
                    raise InputError(f"study.{key}", getattr(self, key), "allowed only with model = 'slow' or 'both'")
