"""Checks that parts allow other values of their parameters: those of a schedule, a sweep, or one of many runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from wucht.errors import InputError
from wucht.machines.parts.base import Part
from wucht.schema import checked, fields_of


def check_values(
    parts: Sequence[Part],
    values: Mapping[str, float],
    where: str | Mapping[str, str] | None = None,
    present: Mapping[str, float] | None = None,
) -> None:
    """Raise ``InputError`` if the parts to which the parameters belong do not allow these values together.

    location: of the error, or the locations by path; None: the path of the value. present: current values of other parameters,
    where not as in the parts.
    """
    for part in parts:
        prefix = f"{part.path}." if part.path else ""
        changed = _changed(part, part.model_dump(mode="json", by_alias=True), values, prefix)
        if not changed:
            continue
        if (error := _fault(part, {**(present or {}), **changed}, prefix)) is not None:
            key, sentence = error.where.removeprefix("."), error.allowed
            others = {p: {k: v for k, v in {**(present or {}), **changed}.items() if k != p} for p in changed}
            named = (p for p in changed if f"{p}.".startswith(f"{prefix}{key}."))
            # The cause may be another value than the one in the message: without its change there is no error.
            causes = (p for p in changed if _fault(part, others[p], prefix) is None)
            path = next(chain(named, causes, changed))
            if where is None and path.startswith(f"{prefix}{key}"):
                raise InputError(path, changed[path], sentence, code=error.code) from None
            place = where[path] if isinstance(where, Mapping) else where
            raise InputError(place or path, changed[path], f"{prefix}{key}: {sentence}", code=error.code) from None


def _fault(part: Part, values: Mapping[str, float], prefix: str) -> InputError | None:
    """Return the error of a part with these values, None if there is none."""
    described = part.model_dump(mode="json", by_alias=True)
    _changed(part, described, values, prefix)
    try:
        checked(type(part), described, "")
    except InputError as error:
        return error
    return None


def _changed(part: Part, described: Any, values: Mapping[str, float], prefix: str) -> dict[str, float]:
    """Set the values that belong to a part in its table, and return them."""
    keys = {path: path.removeprefix(prefix).split(".") for path in values if path.startswith(prefix)}
    own = fields_of(type(part))
    return {path: values[path] for path, k in keys.items() if k[0] in own and _set(described, k, values[path])}


def _set(described: Any, keys: Sequence[str], value: float) -> bool:
    """Set a value in a part's table by the rest of its path. Return True if there is such a place."""
    head, *rest = keys
    key: Any = head
    if isinstance(described, list):
        key = "xy".index(head) if head in ("x", "y") else int(head) - 1 if head.isdigit() else -1
        if not 0 <= key < len(described):
            return False
    elif not isinstance(described, dict) or (head not in described and rest):
        return False
    if rest:
        return _set(described[key], rest, value)
    described[key] = value
    return True
