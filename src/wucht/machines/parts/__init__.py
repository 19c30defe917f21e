"""The parts of a machine: one class a file, each with its formulas. A new part is a new file here and nothing else.

``wucht.parts`` in Python: every class of a part, and of the tables inside parts, is an attribute by its name.

>>> from wucht import parts
>>> parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2").eccentricity
0.001
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import Any, get_args

from wucht.checking import models_in
from wucht.errors import InputError, WuchtError, nearest
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.support import Support

GROUP = "wucht.parts"


@cache
def _load() -> None:
    """Import what the entry points name: a module with parts, or a package of such modules. Raises ``WuchtError``."""
    for entry in entry_points(group=GROUP):
        try:
            for inner in iter_modules(getattr(import_module(entry.value), "__path__", ())):
                import_module(f"{entry.value}.{inner.name}")
        except ImportError as error:
            raise WuchtError(f"the parts {entry.name!r} ({entry.value}) cannot be loaded: {error}") from error


def _kinds(family: Any) -> Iterator[type[Any]]:
    """Every class of a family that has a ``kind``, here or in the user's own code."""
    _load()
    pending: list[Any] = [family]
    while pending:
        cls = pending.pop()
        pending += cls.__subclasses__()
        if "kind" in vars(cls) and cls.kind:
            yield cls


def known(family: Any) -> dict[str, type[Any]]:
    """All kinds of a family by name. Raises ``InputError`` where two classes have the same."""
    kinds: dict[str, type[Any]] = {}
    for cls in _kinds(family):
        other = kinds.setdefault(cls.kind, cls)
        if (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
            mine, theirs = sorted((cls, other), key=lambda c: c.__module__.startswith("wucht."))
            taken = f"not allowed: {theirs.__module__} has a part of this kind; give yours another one"
            raise InputError(f"kind of {mine.__module__}.{mine.__name__}", cls.kind, taken)
    return dict(sorted(kinds.items()))


def carriers() -> dict[str, type[Support]]:
    """The carriers by the values of ``directions`` for which a file means them: those of the field's Literal."""
    every = known(Support).values()
    return {name: cls for cls in every for name in get_args(cls.model_fields["directions"].annotation)}


def bodies() -> dict[str, type[Body]]:
    """The kinds of bodies by name."""
    return known(Body)


def drives() -> dict[str, type[Drive]]:
    """The kinds of drives by name."""
    return known(Drive)


def loads() -> dict[str, type[Load]]:
    """The kinds of loads by name."""
    return known(Load)


def attachments() -> dict[str, type[Attachment]]:
    """The kinds of attachments by name."""
    return known(Attachment)


def _classes() -> dict[str, type[Any]]:
    """Parts of every kind, and the tables inside them (``Mount``, ``Release``), by the name of their class."""
    parts = list(_kinds(Part))
    tables = [table for cls in parts for field in cls.model_fields.values() for table in models_in(field.annotation)]
    return {cls.__name__: cls for cls in (*tables, *parts)}


def __getattr__(name: str) -> type[Any]:
    if not name[:1].isupper():  # no class; Python asks for names of its own while the package is imported
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    classes = _classes()
    if name not in classes:
        raise AttributeError(f"there is no part {name!r}; {nearest(name, classes)}")
    return classes[name]


def __dir__() -> list[str]:
    return sorted({*_classes(), "attachments", "bodies", "carriers", "drives", "known", "loads"})
