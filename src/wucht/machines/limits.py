"""Checks that parts allow other values of their parameters: those of a schedule, a sweep, or one of many runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np
from pydantic import ValidationError

from wucht.errors import InputError
from wucht.machines.parts.base import Part
from wucht.schema import fields_of, validate_table


def check_values(
    parts: Sequence[Part],
    values: Mapping[str, float],
    location: str | Mapping[str, str] | None = None,
    present: Mapping[str, float] | None = None,
) -> None:
    """Raise ``InputError`` if the parts to which the parameters belong do not allow these values together.

    location: of the error, or the locations by path; None: the path of the value. present: current values of other parameters,
    where not as in the parts.
    """
    for part in parts:
        prefix = f"{part.path}." if part.path else ""
        new_values = _set_values(part, part.model_dump(mode="json", by_alias=True), values, prefix)
        if not new_values:
            continue
        if (error := _fault(part, {**(present or {}), **new_values}, prefix)) is not None:
            key, sentence = error.location.removeprefix("."), error.explanation
            values_without = {p: {k: v for k, v in {**(present or {}), **new_values}.items() if k != p} for p in new_values}
            named_paths = (p for p in new_values if f"{p}.".startswith(f"{prefix}{key}."))
            # The cause may be another value than the one in the message: without its change there is no error.
            causes = (p for p in new_values if _fault(part, values_without[p], prefix) is None)
            path = next(chain(named_paths, causes, new_values))
            if location is None and path.startswith(f"{prefix}{key}"):
                raise InputError(path, new_values[path], sentence, code=error.code) from None
            place = location[path] if isinstance(location, Mapping) else location
            raise InputError(place or path, new_values[path], f"{prefix}{key}: {sentence}", code=error.code) from None


def first_fault(parts: Sequence[Part], values: Mapping[str, np.ndarray]) -> int | None:
    """Return the first of N sets of values that the parts do not allow, None if they allow all. values: (N,) by path."""
    faults = list[int]()
    for part in parts:
        prefix, table = f"{part.path}." if part.path else "", part.model_dump(mode="json", by_alias=True)
        paths = [path for path in values if _set_values(part, table, {path: 0.0}, prefix)]
        if not paths:
            continue
        rows, first = np.unique(np.stack([values[path] for path in paths], axis=1), axis=0, return_index=True)
        faults += [
            k
            for row, k in zip(rows.tolist(), first.tolist(), strict=True)
            if not _is_allowed(part, table, dict(zip(paths, row, strict=True)), prefix)
        ]
    return min(faults, default=None)


def _is_allowed(part: Part, table: Any, values: Mapping[str, float], prefix: str) -> bool:
    """Return True if a part allows values of its own, which are set in its table."""
    _set_values(part, table, values, prefix)
    try:
        type(part).model_validate(table)
    except (ValidationError, InputError):
        return False
    return True


def _fault(part: Part, values: Mapping[str, float], prefix: str) -> InputError | None:
    """Return the error of a part with these values, None if there is none."""
    table = part.model_dump(mode="json", by_alias=True)
    _set_values(part, table, values, prefix)
    try:
        validate_table(type(part), table, "")
    except InputError as error:
        return error
    return None


def _set_values(part: Part, table: Any, values: Mapping[str, float], prefix: str) -> dict[str, float]:
    """Set the values that belong to a part in its table, and return them."""
    keys = {path: path.removeprefix(prefix).split(".") for path in values if path.startswith(prefix)}
    field_names = fields_of(type(part))
    return {path: values[path] for path, k in keys.items() if k[0] in field_names and _set_value(table, k, values[path])}


def _set_value(table: Any, keys: Sequence[str], value: float) -> bool:
    """Set a value in a part's table by the rest of its path. Return True if there is such a place."""
    head, *rest = keys
    key: Any = head
    if isinstance(table, list):
        key = "xy".index(head) if head in ("x", "y") else int(head) - 1 if head.isdigit() else -1
        if not 0 <= key < len(table):
            return False
    elif not isinstance(table, dict) or (head not in table and rest):
        return False
    if rest:
        return _set_value(table[key], rest, value)
    table[key] = value
    return True
