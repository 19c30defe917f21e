"""Parameters set by path, before the machine is built: ``drive.slope``, ``carrier.mounts.1.stiffness.x``, ``u``."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

from wucht.checking import choice, fields_of, table
from wucht.errors import InputError, nearest
from wucht.files.documents import Document, flatten
from wucht.files.equal_bodies import is_of_one, of_all_first, with_equal_bodies
from wucht.machines.assembly import shaft_labels
from wucht.machines.models import models


def with_settings(document: Document, settings: Mapping[str, Any]) -> Document:
    """A copy of the machine's table with parameters set by path. Raises ``InputError`` for a path that leads nowhere.

    The name of several equal bodies sets all of them, and their ``count``; that of one sets it alone, in a table of its own.
    """
    document = copy.deepcopy(document)
    for path, value in of_all_first(document, flatten(settings)).items():
        document = with_equal_bodies(document) if is_of_one(document, path) else document
        _set(document, path, value)
    return document


def shaft_tables(document: Document, group: str) -> list[Document]:
    """The tables of ``drive`` or ``drives`` (``load``, ``loads``), on the only rotor by default. Raises ``InputError``."""
    single, several = document.get(group), document.get(f"{group}s", [])
    if single is not None and several:
        raise InputError(f"machine.{group}s", None, f"give either [machine.{group}] or [[machine.{group}s]]")
    if single is not None and not isinstance(single, dict):
        raise InputError(f"machine.{group}", single, f"must be a table: [machine.{group}]")
    if not isinstance(several, list) or not all(isinstance(d, dict) for d in several):
        raise InputError(f"machine.{group}s", several, f"must be tables: [[machine.{group}s]]")
    tables = [single] if single is not None else several
    rotors = [b["name"] for b in _tables(document, "bodies") if "about" not in b and "name" in b]
    if len(rotors) == 1:
        for described in tables:
            described.setdefault("on", rotors[0])
    return tables


def shaft_paths(group: str, shafts: Sequence[tuple[str, str]]) -> list[str]:
    """The paths of drives or loads, each given as (body, kind)."""
    return [f"{group}s.{label}" if label else group for label in shaft_labels(shafts)]


def _tables(document: Document, key: str) -> list[Document]:
    """The tables of bodies or attachments, as far as they are tables: what is wrong in them is reported when they are read."""
    tables = document.get(key)
    return [t for t in tables if isinstance(t, dict)] if isinstance(tables, list) else []


def _set(document: Document, path: str, value: Any) -> None:
    head, *rest = path.split(".")
    where = f"machine.set.{path}"
    if head == "study":
        raise InputError(where, value, "a key of [study] is set from the command line as study.KEY=VALUE")
    if "model" in document:
        known = fields_of(models()[choice(document, "model", "machine", models())])
        if rest or head not in known:
            raise InputError(where, value, f"unknown parameter; {nearest(path, known)}")
        document.setdefault("parameters", {})
        table(document, "parameters", "machine.parameters")[head] = value
        return
    parts = _addressable(document)
    key = max((k for k in parts if path.startswith(f"{k}.")), key=len, default=None)
    if key is None:
        raise InputError(where, value, f"unknown parameter; {nearest(head, parts)}, each followed by '.key'")
    _set_inside(parts[key], path[len(key) + 1 :].split("."), value, where, key)


_INSTEAD = {
    "file": ("points",), "table": ("points",), "points": ("file", "table"), "frequency": ("stiffness",),
    "stiffness": ("frequency",), "damping_ratio": ("damping",), "damping": ("damping_ratio",),
    "rotation_frequency": ("rotation_stiffness",), "rotation_stiffness": ("rotation_frequency",),
    "rotation_damping_ratio": ("rotation_damping",), "rotation_damping": ("rotation_damping_ratio",),
}  # fmt: skip


def _set_inside(target: Any, inner: list[str], value: Any, where: str, key: str) -> None:
    """Walk down tables, numbered lists of tables and pairs, and set the last key."""
    while len(inner) > 1 and isinstance(target, dict):
        name, below = inner[0], target.get(inner[0])
        if isinstance(below, dict):
            target, inner = below, inner[1:]
        elif isinstance(below, list) and inner[1].isdigit() and 1 <= int(inner[1]) <= len(below):
            target, inner = below[int(inner[1]) - 1], inner[2:]
        elif len(inner) == 2 and inner[1] in ("x", "y") and isinstance(below, list) and len(below) == 2:
            below["xy".index(inner[1])] = value
            return
        elif len(inner) == 2 and inner[1] in ("x", "y") and name in target:
            both = where.removeprefix("machine.set.").rpartition(".")[0]
            raise InputError(where, value, f"{both} is one number here; set both at once: {both} = [X, Y]")
        else:
            break
    if len(inner) != 1 or not isinstance(target, dict):
        raise InputError(where, value, f"unknown parameter; {nearest(inner[0] if inner else '', target)} in {key}")
    for other in _INSTEAD.get(inner[0], ()):
        target.pop(other, None)  # two ways to give one thing: the one that is set replaces the other
    target[inner[0]] = value


def _addressable(document: Document) -> dict[str, Document]:
    """The tables of all parts by their paths."""
    bodies = _tables(document, "bodies")
    parts = {"carrier": document["carrier"]} if isinstance(document.get("carrier"), dict) else {}
    parts |= {str(b["name"]): b for b in (*bodies, *_tables(document, "attachments")) if "name" in b}
    for group in ("drive", "load"):
        shafts = shaft_tables(document, group)
        paths = shaft_paths(group, [(str(t.get("on", "")), str(t.get("kind", ""))) for t in shafts])
        parts |= dict(zip(paths, shafts, strict=True))
    names = {str(b["track"]) for b in bodies if "track" in b}
    tracks = document.setdefault("tracks", {}) if names else None
    return parts | ({f"tracks.{n}": tracks.setdefault(n, {}) for n in names} if isinstance(tracks, dict) else {})
