"""Kinds that a file names: the classes of a family, in modules that entry points name or in the user's code."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import Any

from wucht.errors import InputError, WuchtError


@cache
def _load(group: str) -> None:
    """Import what the entry points name: a module with kinds, or a package of such modules. Raises ``WuchtError``."""
    for entry in entry_points(group=group):
        try:
            for inner in iter_modules(getattr(import_module(entry.value), "__path__", ())):
                import_module(f"{entry.value}.{inner.name}")
        except ImportError as error:
            family_name = group.rpartition(".")[2]
            raise WuchtError(
                f"the {family_name} {entry.name!r} ({entry.value}) cannot be loaded: {error}", code="not-loaded"
            ) from error


def classes_of(family: Any, group: str) -> Iterator[type[Any]]:
    """Every class of a family that has a ``kind``, once the modules of a group of entry points are loaded."""
    _load(group)
    pending: list[Any] = [family]
    while pending:
        cls = pending.pop()
        pending += cls.__subclasses__()
        if "kind" in vars(cls) and cls.kind:
            yield cls


def kinds_of(family: Any, group: str) -> dict[str, type[Any]]:
    """The classes of a family by the name of their kind. Raises ``InputError`` where two have one name."""
    kinds: dict[str, type[Any]] = {}
    for cls in classes_of(family, group):
        existing_class = kinds.setdefault(cls.kind, cls)
        if (existing_class.__module__, existing_class.__qualname__) != (cls.__module__, cls.__qualname__):
            mine, theirs = sorted((cls, existing_class), key=lambda c: c.__module__.startswith("wucht."))
            explanation = f"not allowed: {theirs.__module__} has this kind; give yours another name"
            raise InputError(f"kind of {mine.__module__}.{mine.__name__}", cls.kind, explanation, code="taken")
    return dict(sorted(kinds.items()))
