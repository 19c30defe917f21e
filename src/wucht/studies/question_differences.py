"""In which keys two questions differ, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def untitled(question: Any) -> Any:
    """A question without the titles of its subjects, which no answer depends on."""
    if isinstance(question, Mapping):
        return {key: untitled(value) for key, value in question.items() if key != "title"}
    return [untitled(each) for each in question] if isinstance(question, list) else question


def differences(before: Any, now: Any, path: str = "") -> dict[str, str]:
    """In which keys two questions differ, and how. ``contents`` is the hash of a table's file."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        differing: dict[str, str] = {}
        for key in [*before, *(k for k in now if k not in before)]:
            if key == "contents" and before.get(key) != now.get(key):
                if _file_of(before) == _file_of(now):
                    differing[f"{path}file"] = f"the record {_file_of(now)} has changed"
                continue
            inner = path if key in ("machine", "parameters") else f"{path}{key}."
            differing |= differences(before.get(key), now.get(key), inner)
        return differing
    name = path.removesuffix(".")
    if name == "structure" and before != now:
        return {name: "the parts, curves, schedules or equations of the subject have changed"}
    return {} if before == now else {name: f"{name} was {_brief(before)}, now {_brief(now)}"}


def _file_of(table: Mapping[str, Any]) -> str | None:
    """The file that a table names, itself or a table in it."""
    named = [t.get("file") for t in (table, *table.values()) if isinstance(t, Mapping)]
    return next((str(n) for n in named if n is not None), None)


def _brief(value: Any) -> str:
    text = "not given" if value is None else repr(value)
    return text if len(text) <= 40 else f"{text[:36]} ..."
