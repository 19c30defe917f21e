"""Whether parts allow other values of their parameters: those of a schedule, a sweep, or one of many runs."""

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
    """Raises ``InputError`` if the parts to which the parameters belong do not allow these values together.

    where: the error's place, or the places by path; None: the path of the value. present: what other parameters are now, where
    not as in the parts.
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
            # A fault may be that of a value beside the one that is named: without its change there is none.
            causes = (p for p in changed if _fault(part, others[p], prefix) is None)
            path = next(chain(named, causes, changed))
            if where is None and path.startswith(f"{prefix}{key}"):
                raise InputError(path, changed[path], sentence, code=error.code) from None
            place = where[path] if isinstance(where, Mapping) else where
            raise InputError(place or path, changed[path], f"{prefix}{key}: {sentence}", code=error.code) from None


def _fault(part: Part, values: Mapping[str, float], prefix: str) -> InputError | None:
    """What is wrong with a part that has these values, None if nothing is."""
    described = part.model_dump(mode="json", by_alias=True)
    _changed(part, described, values, prefix)
    try:
        checked(type(part), described, "")
    except InputError as error:
        return error
    return None


def _changed(part: Part, described: Any, values: Mapping[str, float], prefix: str) -> dict[str, float]:
    """Set those values in a part's table that are its own, and return them."""
    keys = {path: path.removeprefix(prefix).split(".") for path in values if path.startswith(prefix)}
    own = fields_of(type(part))
    return {path: values[path] for path, k in keys.items() if k[0] in own and _set(described, k, values[path])}


def _set(described: Any, keys: Sequence[str], value: float) -> bool:
    """Set a value in a part's table by the rest of its path. Returns whether there is such a place."""
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
