"""The parts of a machine: one class a file, each with its formulas. A new part is a new file here and nothing else.

``wucht.parts`` in Python: every class of a part, and of the tables inside parts, is an attribute by its name.

>>> from wucht import parts
>>> parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2").eccentricity
0.001
"""

from __future__ import annotations

from typing import Any, get_args

from wucht.errors import nearest
from wucht.kinds import classes_of, kinds_of
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.support import Support
from wucht.schema import models_in

GROUP = "wucht.parts"


def part_kinds(family: Any) -> dict[str, type[Any]]:
    """Return all kinds of a family by name, also of the user's packages. Raises ``InputError`` where two have one name."""
    return kinds_of(family, GROUP)


def carriers() -> dict[str, type[Support]]:
    """Return the carriers by the values of ``directions`` that select them in a file: those of the field's Literal."""
    every = part_kinds(Support).values()
    return {name: cls for cls in every for name in get_args(cls.model_fields["directions"].annotation)}


def bodies() -> dict[str, type[Body]]:
    """Return the kinds of bodies by name."""
    return part_kinds(Body)


def drives() -> dict[str, type[Drive]]:
    """Return the kinds of drives by name."""
    return part_kinds(Drive)


def loads() -> dict[str, type[Load]]:
    """Return the kinds of loads by name."""
    return part_kinds(Load)


def attachments() -> dict[str, type[Attachment]]:
    """Return the kinds of attachments by name."""
    return part_kinds(Attachment)


def _classes() -> dict[str, type[Any]]:
    """Parts of every kind, and the tables inside them (``Mount``, ``Release``), by the name of their class."""
    parts = list(classes_of(Part, GROUP))
    tables = [table for cls in parts for field in cls.model_fields.values() for table in models_in(field.annotation)]
    return {cls.__name__: cls for cls in (*tables, *parts)}


def __getattr__(name: str) -> type[Any]:
    if not name[:1].isupper():  # no class; Python requests private names while the package is imported
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    classes = _classes()
    if name not in classes:
        raise AttributeError(f"there is no part {name!r}; {nearest(name, classes)}")
    return classes[name]


def __dir__() -> list[str]:
    return sorted({*_classes(), "attachments", "bodies", "carriers", "drives", "loads", "part_kinds"})
