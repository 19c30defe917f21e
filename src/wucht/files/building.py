"""File -> Machine: the machine part of a study file, checked key by key."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from wucht.errors import InputError
from wucht.files.documents import Document, settings_in
from wucht.files.equal_bodies import with_equal_bodies
from wucht.files.settings import shaft_paths, shaft_tables, with_settings
from wucht.machines.assembly import BESIDE_A_MODEL
from wucht.machines.machine import Machine
from wucht.machines.models import models
from wucht.machines.parts import attachments, carriers, drives, loads
from wucht.machines.parts import bodies as body_kinds
from wucht.schema import checked, choice, refuse_unknown, table, text

_PARTS = ("carrier", "bodies", "drive", "drives", "load", "loads", "attachments", "tracks")
MACHINE_KEYS = ("title", "use", "set", "model", "parameters", *_PARTS, "schedules")


def machine_from(document: Document, title: str = "") -> Machine:
    """The machine described by a table ``[machine]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``machine`` on.
    """
    document = copy.deepcopy(document)
    settings = settings_in(document)
    refuse_unknown(document, MACHINE_KEYS, "machine")
    document = with_equal_bodies(with_settings(document, settings))
    title = text(document, "title", "machine") or title
    document.pop("title", None)
    return _from_model(document, title) if "model" in document else _from_parts(document, title)


def _from_model(document: Document, title: str) -> Machine:
    name = choice(document, "model", "machine", models())
    if beside := [key for key in _PARTS if key in document]:
        raise InputError(f"machine.{beside[0]}", None, BESIDE_A_MODEL.format(name))
    model = checked(models()[name], table(document, "parameters", "machine.parameters"), "machine.parameters")
    return _built(document, model, title=title, places={})


def _from_parts(document: Document, title: str) -> Machine:
    if "parameters" in document:
        raise InputError("machine.parameters", None, "allowed only with model = ...; SI machines carry values in their parts")
    described, kinds = table(document, "carrier", "machine.carrier"), carriers()
    directions = choice({"directions": "xy"} | described, "directions", "machine.carrier", kinds)
    carrier = checked(kinds[directions], described, "machine.carrier")
    bodies, places = _named(document, "bodies", body_kinds())
    attached, at_attached = _named(document, "attachments", attachments())
    of_drives, at_drives = _shafts(document, "drive", drives())
    of_loads, at_loads = _shafts(document, "load", loads())
    places |= at_drives | at_loads | at_attached
    return _built(
        document, carrier, bodies, of_drives, of_loads, attachments=attached, tracks=document.get("tracks"), title=title,
        places=places,
    )  # fmt: skip


def _named(document: Document, key: str, kinds: Mapping[str, type[Any]]) -> tuple[list[Any], dict[str, str]]:
    """The bodies or attachments in ``[[machine.KEY]]``, and the places of all by path, seen from ``machine``."""
    tables = document.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(described, dict) for described in tables):
        raise InputError(f"machine.{key}", tables, f"must be tables: [[machine.{key}]]")
    parts = []
    for i, described in enumerate(tables):
        name = str(described.get("name", ""))
        where = f"machine.{key}[{i}]" + (f" ({name})" if name.replace("-", "_").isidentifier() else "")
        parts.append(_of_kind(kinds, described, where))
    return parts, {part.path: f"{key}[{i}] ({part.name})" for i, part in enumerate(parts)}


def _shafts(document: Document, group: str, kinds: dict[str, type[Any]]) -> tuple[list[Any], dict[str, str]]:
    """Drives or loads, and the places of all by path, seen from ``machine``."""
    tables = shaft_tables(document, group)
    places = [group if group in document else f"{group}s[{i}]" for i in range(len(tables))]
    shafts = [_of_kind(kinds, t, f"machine.{place}") for t, place in zip(tables, places, strict=True)]
    return shafts, dict(zip(shaft_paths(group, [(s.on, s.kind) for s in shafts]), places, strict=True))


def _of_kind(kinds: Mapping[str, type[Any]], described: Document, where: str) -> Any:
    """A part from its table, which names its kind."""
    kind = choice(described, "kind", where, kinds)
    return checked(kinds[kind], {k: v for k, v in described.items() if k != "kind"}, where)


def _built(document: Document, *parts: Any, places: Mapping[str, str], **others: Any) -> Machine:
    """The machine of these parts. Raises ``InputError``, seen from the file: at the places of parts, not at their paths."""
    try:
        return Machine(*parts, schedules=document.get("schedules", ()), **others)
    except InputError as error:
        path = next((p for p in places if error.where.startswith(f"{p}.")), "")
        seen = f"{places.get(path, path)}{error.where.removeprefix(path)}"
        raise InputError(seen, error.given, error.allowed).within("machine") from None
