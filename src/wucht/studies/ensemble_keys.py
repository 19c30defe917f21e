"""Keys that the questions of all studies of ensembles have, and how they fit each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from wucht.errors import InputError
from wucht.schema import si
from wucht.studies import spec as common

_TOLERANCE = 1e-6  # members are many, and the border of a basin is not known better


class EnsembleSpec(common.Spec):
    """A question about what becomes of many starts or variants of a machine."""

    horizon: ClassVar[tuple[str, ...]] = ("until",)
    tiled: ClassVar[bool] = True
    without_inertia: ClassVar[bool] = True

    start: common.Start = Field(default_factory=dict, description="initial state of all, but for what is varied of it")
    model: Literal["full", "slow"] = Field("full", description='the `"full"` equations or the averaged ones (`"slow"`)')
    inertia: common.Inertia | None = None
    order: common.Order = 1
    until: float | None = si("s", "time", default=None, gt=0, help="how long each run lasts, by default until it has settled")
    tolerance: common.Tolerance = _TOLERANCE

    @model_validator(mode="before")
    @classmethod
    def _until_settled(cls, given: Any) -> Any:
        """``until = "settled"`` is the default in words."""
        if isinstance(given, Mapping) and given.get("until") == "settled":
            return {k: v for k, v in given.items() if k != "until"}
        return given

    def check(self) -> None:
        """The keys of averaged equations only with them."""
        for key in ("inertia", "order") if self.model == "full" else ():
            if key in self.model_fields_set and getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with model = 'slow'")


def paths_of(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """What is given for each path: TOML reads ``drive.slope = [...]`` as a table within a table."""
    given: list[tuple[str, Any]] = []
    for key, value in table.items():
        given += paths_of(value, f"{path}{key}.") if isinstance(value, Mapping) else [(f"{path}{key}", value)]
    return given
