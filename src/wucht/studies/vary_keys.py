"""The key ``vary`` of a search: what may be changed, and how far."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import refuse_unknown

_KEYS = ("of", "range")


def _vary(given: Any) -> Any:
    if not isinstance(given, Mapping) or not given:
        raise ValueError(
            "must be a table of ranges: vary = { damping = [lo, hi], mass = { of = [BODY, ...], range = [lo, hi] } }"
        )
    return {name: _group(f"study.vary.{name}", one) for name, one in _by_path(given)}


def _by_path(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """What is varied, with its name: TOML reads ``b1.damping = [...]`` as a table within a table."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        nested = isinstance(value, Mapping) and not set(value) & set(_KEYS)
        found += _by_path(value, f"{path}{key}.") if nested else [(f"{path}{key}", value)]
    return found


def _group(where: str, given: Any) -> dict[str, Any]:
    table = given if isinstance(given, Mapping) else {"range": given}
    refuse_unknown(table, _KEYS, where)
    names, ends = table.get("of"), table.get("range")
    if not isinstance(ends, list | tuple) or len(ends) != 2 or any(isinstance(e, bool) for e in ends):
        raise InputError(where, ends, "must be a pair [low, high]")
    if names is not None and (not isinstance(names, list | tuple) or not names or not all(isinstance(n, str) for n in names)):
        raise InputError(f"{where}.of", names, "must be a list of names of bodies")
    return {"of": None if names is None else list(names), "range": list(ends)}


Vary = Annotated[dict[str, dict[str, Any]], BeforeValidator(_vary), Field(title="what may be changed, and how far")]
