"""Whether parts allow other values of their parameters: those of a schedule, a sweep, or one of many runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from wucht.documents import checked
from wucht.errors import InputError
from wucht.machines.parts.base import Part


def check_values(parts: Sequence[Part], values: Mapping[str, float], where: str) -> None:
    """Raises ``InputError`` at ``where`` if the parts to which the parameters belong do not allow these values together."""
    for part in parts:
        prefix = f"{part.path}." if part.path else ""
        mine = {path.removeprefix(prefix): value for path, value in values.items() if path.startswith(prefix)}
        described = part.model_dump(mode="json", by_alias=True, exclude_unset=True)
        fields = {f.alias or name for name, f in type(part).model_fields.items()}
        own = {key: value for key, value in mine.items() if key.split(".")[0] in fields}
        changed = {key: value for key, value in own.items() if _set(described, key.split("."), value)}
        if not changed:
            continue
        try:
            checked(type(part), described, "").check()
        except InputError as error:
            raise InputError(
                where, next(iter(changed.values())), f"{prefix}{error.where.removeprefix('.')}: {error.allowed}"
            ) from None
        except ValueError as error:
            key, sentence = error.args if len(error.args) == 2 else ("", str(error))
            raise InputError(where, next(iter(changed.values())), f"{prefix}{key}: {sentence}") from None


def _set(described: Any, keys: Sequence[str], value: float) -> bool:
    """Set a value in a part's table by the rest of its path. Returns whether there is such a place."""
    head, *rest = keys
    if isinstance(described, list):
        place = "xy".index(head) if head in ("x", "y") else int(head) - 1 if head.isdigit() else -1
        if not 0 <= place < len(described):
            return False
        if rest:
            return _set(described[place], rest, value)
        described[place] = value
        return True
    if not isinstance(described, dict) or (head not in described and rest):
        return False
    if rest:
        return _set(described[head], rest, value)
    described[head] = value
    return True
