"""The parts in a machine file, each built from its table, and where in the file it stands."""

from __future__ import annotations

from typing import Any, TypeVar

from wucht.checking import checked, choice, table
from wucht.errors import InputError
from wucht.files.documents import Document
from wucht.files.settings import shaft_tables
from wucht.machines.assembly import shaft_labels
from wucht.machines.parts import bodies as body_kinds
from wucht.machines.parts import carriers
from wucht.machines.parts.base import Body, OnShaft
from wucht.machines.parts.support import Support

_LATER_BODIES = ("switchable-pendulum",)

ShaftT = TypeVar("ShaftT", bound=OnShaft)
Places = dict[str, str]


def read_carrier(document: Document) -> Support:
    """The carrier in ``[machine.carrier]``. Raises ``InputError``."""
    described, kinds = table(document, "carrier", "machine.carrier"), carriers()
    directions = choice({"directions": "xy"} | described, "directions", "machine.carrier", kinds)
    return checked(kinds[directions], described, "machine.carrier")


def read_bodies(document: Document) -> tuple[list[Body], Places]:
    """The bodies in ``[[machine.bodies]]``, and the places of all by path, seen from ``machine``. Raises ``InputError``."""
    listed = document.get("bodies", [])
    if not isinstance(listed, list) or not all(isinstance(b, dict) for b in listed):
        raise InputError("machine.bodies", listed, "allowed are tables: [[machine.bodies]]")
    bodies: list[Body] = []
    for i, described in enumerate(listed):
        name = str(described.get("name", ""))
        where = f"machine.bodies[{i}]" + (f" ({name})" if name.replace("-", "_").isidentifier() else "")
        bodies.append(_of_kind(body_kinds(), described, where, _LATER_BODIES))
    return bodies, {b.path: f"bodies[{i}] ({b.name})" for i, b in enumerate(bodies)}


def read_shafts(document: Document, group: str, kinds: dict[str, type[ShaftT]]) -> tuple[list[ShaftT], Places]:
    """Drives or loads, and the places of all by path, seen from ``machine``. Raises ``InputError``."""
    tables = shaft_tables(document, group)
    places = [group if group in document else f"{group}s[{i}]" for i in range(len(tables))]
    found = [_of_kind(kinds, t, f"machine.{place}") for t, place in zip(tables, places, strict=True)]
    labels = shaft_labels([(s.on, s.kind) for s in found])
    return found, {f"{group}s.{label}" if label else group: place for label, place in zip(labels, places, strict=True)}


def _of_kind(kinds: dict[str, type[Any]], described: Document, where: str, later: tuple[str, ...] = ()) -> Any:
    """A part from its table, which names its kind."""
    kind = choice(described, "kind", where, kinds, later)
    return checked(kinds[kind], {k: v for k, v in described.items() if k != "kind"}, where)
