"""Keys that the questions of all studies of ensembles have, and how they fit each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wucht.errors import InputError
from wucht.studies.spec import Spec

TOLERANCE = 1e-6  # members are many, and the border of a basin is not known better


def paths_of(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """What is given for each path: TOML reads ``drive.slope = [...]`` as a table within a table."""
    given: list[tuple[str, Any]] = []
    for key, value in table.items():
        given += paths_of(value, f"{path}{key}.") if isinstance(value, Mapping) else [(f"{path}{key}", value)]
    return given


def until_settled(given: Any) -> Any:
    """The keys of a question without ``until = "settled"``, which is the default in words."""
    if isinstance(given, Mapping) and given.get("until") == "settled":
        return {k: v for k, v in given.items() if k != "until"}
    return given


def check_model(spec: Spec, model: str) -> None:
    """Raises ``InputError`` where a key of averaged equations is given with the full ones."""
    for key in ("inertia", "order") if model == "full" else ():
        if key in spec.model_fields_set and getattr(spec, key) is not None:
            raise InputError(f"study.{key}", getattr(spec, key), "allowed only with model = 'slow'")
