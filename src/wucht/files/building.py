"""File -> Machine: the machine part of a study file, checked key by key, with values set by path.

A path is such as ``drive.slope``, ``carrier.mounts.1.stiffness.x``, ``u``.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel

from wucht.errors import InputError, nearest
from wucht.files.documents import Document, flatten, settings_in
from wucht.files.equal_bodies import addresses_one_body, group_settings_first, with_equal_bodies
from wucht.machines.assembly import MODEL_CONFLICT, shaft_labels
from wucht.machines.machine import Machine
from wucht.machines.models import models
from wucht.machines.parts import attachments, bodies, carriers, drives, loads
from wucht.machines.parts import bodies as body_kinds
from wucht.machines.purpose import Purpose
from wucht.schema import choice, fields_of, models_in, refuse_unknown, require_table, text, validate_table

_PARTS = ("carrier", "bodies", "drive", "drives", "load", "loads", "attachments", "tracks")
MACHINE_KEYS = ("title", "purpose", "use", "set", "model", "parameters", *_PARTS, "mounts", "schedules")


def with_settings(document: Document, settings: Mapping[str, Any]) -> Document:
    """A copy of the machine's table with parameters set by path. Raises ``InputError`` for a path that leads nowhere.

    The name of several equal bodies sets all of them, and their ``count``; that of one sets it alone, in a separate table.
    """
    document = _with_mounts_on_carrier(copy.deepcopy(document))
    for path, value in group_settings_first(document, flatten(settings)).items():
        document = with_equal_bodies(document) if addresses_one_body(document, path) else document
        _set_value(document, path, value)
    return document


def _with_mounts_on_carrier(document: Document) -> Document:
    """The machine's table with ``[machine.mounts]`` as the carrier's, where they belong. Raises ``InputError``."""
    if "mounts" not in document:
        return document
    mounts, carrier = document.pop("mounts"), document.get("carrier")
    if not isinstance(carrier, dict) or "mounts" in carrier:
        raise InputError("machine.mounts", mounts, "give the mounts once, beside a table [machine.carrier]", code="either-or")
    return document | {"carrier": carrier | {"mounts": mounts}}


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
        for description in tables:
            description.setdefault("on", rotors[0])
    return tables


def shaft_paths(group: str, shafts: Sequence[tuple[str, str]]) -> list[str]:
    """The paths of drives or loads, each given as (body, kind)."""
    return [f"{group}s.{label}" if label else group for label in shaft_labels(shafts)]


def _tables(document: Document, key: str) -> list[Document]:
    """The tables of bodies or attachments, as far as they are tables: other faults are reported when they are read."""
    tables = document.get(key)
    return [t for t in tables if isinstance(t, dict)] if isinstance(tables, list) else []


def _set_value(document: Document, path: str, value: Any) -> None:
    head, *rest = path.split(".")
    location = f"machine.set.{path}"
    if head == "study":
        raise InputError(location, value, "a key of [study] is set from the command line as study.KEY=VALUE", code="study-key")
    if "model" in document:
        known_names = fields_of(models()[choice(document, "model", "machine", models())])
        if rest or head not in known_names:
            raise InputError(location, value, f"unknown parameter; {nearest(path, known_names)}", code="unknown-parameter")
        document.setdefault("parameters", {})
        require_table(document, "parameters", "machine.parameters")[head] = value
        return
    parts = _addressable_parts(document)
    key = max((k for k in parts if path.startswith(f"{k}.")), key=len, default=None)
    if path in parts:
        inside = ", ".join(sorted(_keys_in(*parts[path]))) or "none"
        raise InputError(location, value, f"this is a part; set one of its keys as {path}.KEY: {inside}", code="part")
    if key is None:
        raise InputError(
            location, value, f"unknown parameter; {nearest(head, parts)}, each followed by '.key'", code="unknown-parameter"
        )
    description, cls = parts[key]
    _set_nested_value(description, path[len(key) + 1 :].split("."), value, location, key, cls)


_UNBALANCE = ("working_moment", "centrifugal_force", "setting")
_INSTEAD = {
    "file": ("points",), "table": ("points",), "points": ("file", "table"),
    "frequency": ("stiffness",), "stiffness": ("frequency", "static_deflection"), "static_deflection": ("stiffness",),
    "damping_ratio": ("damping",), "damping": ("damping_ratio", "oil"), "oil": ("damping",),
    "rotation_frequency": ("rotation_stiffness",), "rotation_stiffness": ("rotation_frequency",),
    "rotation_damping_ratio": ("rotation_damping",), "rotation_damping": ("rotation_damping_ratio",),
    "eccentricity": _UNBALANCE, "unbalance": _UNBALANCE,
    "working_moment": ("unbalance", "eccentricity", "centrifugal_force"),
}  # fmt: skip


def _set_nested_value(target: Any, inner: list[str], value: Any, location: str, key: str, cls: type[BaseModel] | None) -> None:
    """Walk down tables, numbered lists of tables and pairs, and set the last key. cls: of the part, if its kind is known.

    A missing optional table is created: keys that it requires are checked when it is read.
    """
    while len(inner) > 1 and isinstance(target, dict):
        inside = None if cls is None else _optional_table(cls, inner[0])
        name, below = inner[0], target.setdefault(inner[0], {}) if inside is not None else target.get(inner[0])
        if isinstance(below, dict):
            target, inner, cls = below, inner[1:], inside
        elif isinstance(below, list) and inner[1].isdigit() and 1 <= int(inner[1]) <= len(below):
            target, inner, cls = below[int(inner[1]) - 1], inner[2:], None
        elif len(inner) == 2 and inner[1] in ("x", "y") and isinstance(below, list) and len(below) == 2:
            below["xy".index(inner[1])] = value
            return
        elif len(inner) == 2 and inner[1] in ("x", "y") and name in target:
            pair_key = location.removeprefix("machine.set.").rpartition(".")[0]
            raise InputError(
                location, value, f"{pair_key} is one number here; set both at once: {pair_key} = [X, Y]", code="pair"
            )
        else:
            break
    known_fields = {} if cls is None else fields_of(cls, settable_only=True)
    if len(inner) != 1 or not isinstance(target, dict) or (not target and cls is not None and inner[0] not in known_fields):
        beside = dict.fromkeys([*(target if isinstance(target, dict | list) else ()), *known_fields])
        raise InputError(
            location,
            value,
            f"unknown parameter; {nearest(inner[0] if inner else '', beside)} in {key}",
            code="unknown-parameter",
        )
    for alternative in _INSTEAD.get(inner[0], ()):
        target.pop(alternative, None)  # two ways to give one quantity: the one that is set replaces the other
    target[inner[0]] = value


def _keys_in(description: Document, cls: type[BaseModel] | None) -> Iterable[str]:
    """The keys that a part's table has, and those that it may have."""
    return {*description, *(() if cls is None else fields_of(cls, settable_only=True))} - {"kind", "name"}


def _optional_table(cls: type[BaseModel], key: str) -> type[BaseModel] | None:
    """The table that may be given under a key of another one, None where the key is not a table."""
    field = fields_of(cls, settable_only=True).get(key)
    forms = () if field is None else get_args(field.annotation) or (field.annotation,)
    return next((form for form in forms if [form] == models_in(form)), None)


def _addressable_parts(document: Document) -> dict[str, tuple[Document, type[BaseModel] | None]]:
    """The tables of all parts by their paths, and the class of each, if its kind is known."""
    parts: dict[str, tuple[Document, type[BaseModel] | None]] = {}
    if isinstance(carrier := document.get("carrier"), dict):
        parts["carrier"] = carrier, carriers().get(str(carrier.get("directions", "xy")))
    for key, kinds in (("bodies", bodies()), ("attachments", attachments())):
        parts |= {str(t["name"]): (t, kinds.get(str(t.get("kind")))) for t in _tables(document, key) if "name" in t}
    for group, on_shafts in (("drive", drives()), ("load", loads())):
        shafts = shaft_tables(document, group)
        paths = shaft_paths(group, [(str(t.get("on", "")), str(t.get("kind", ""))) for t in shafts])
        parts |= {path: (t, on_shafts.get(str(t.get("kind")))) for path, t in zip(paths, shafts, strict=True)}
    names = {str(b["track"]) for b in _tables(document, "bodies") if "track" in b}
    tracks = document.setdefault("tracks", {}) if names else None
    return parts | ({f"tracks.{n}": (tracks.setdefault(n, {}), None) for n in names} if isinstance(tracks, dict) else {})


def given_keys(document: Document) -> frozenset[str]:
    """Return the keys that a table ``[machine]`` gives, with the path of their part: ``p1.length``; the rest follows from them.

    A working moment gives the unbalance.

    Raises ``InputError``.
    """
    single_bodies = with_equal_bodies(copy.deepcopy(document))
    of_parts = _addressable_parts(single_bodies).items()
    return frozenset(f"{path}.{'unbalance' if key in _UNBALANCE else key}" for path, (table, _) in of_parts for key in table)


def machine_from(document: Document, title: str = "") -> Machine:
    """The machine described by a table ``[machine]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``machine`` on.
    """
    document = copy.deepcopy(document)
    settings = settings_in(document)
    refuse_unknown(document, MACHINE_KEYS, "machine")
    document = with_equal_bodies(with_settings(document, settings))
    title = text(document, "title", "machine") or title
    purpose_in(document)
    for key in ("title", "purpose"):
        document.pop(key, None)
    return _from_model(document, title) if "model" in document else _from_parts(document, title)


def purpose_in(document: Document) -> Purpose | None:
    """What a table ``[machine]`` says that the machine is built for, None where it says nothing. Raises ``InputError``."""
    return Purpose(choice(document, "purpose", "machine", [str(one) for one in Purpose])) if "purpose" in document else None


def _from_model(document: Document, title: str) -> Machine:
    name = choice(document, "model", "machine", models())
    if beside := [key for key in _PARTS if key in document]:
        raise InputError(f"machine.{beside[0]}", None, MODEL_CONFLICT.format(name))
    model = validate_table(models()[name], require_table(document, "parameters", "machine.parameters"), "machine.parameters")
    return _build_machine(document, model, title=title, places={})


def _from_parts(document: Document, title: str) -> Machine:
    if "parameters" in document:
        raise InputError(
            "machine.parameters", None, "allowed only with model = ...; machines in SI units have their values in their parts"
        )
    description, kinds = require_table(document, "carrier", "machine.carrier"), carriers()
    directions = choice({"directions": "xy"} | description, "directions", "machine.carrier", kinds)
    carrier = validate_table(kinds[directions], description, "machine.carrier")
    bodies, places = _read_parts(document, "bodies", body_kinds())
    attached_parts, at_attached = _read_parts(document, "attachments", attachments())
    drive_parts, at_drives = _shafts(document, "drive", drives())
    load_parts, at_loads = _shafts(document, "load", loads())
    places |= at_drives | at_loads | at_attached
    return _build_machine(
        document, carrier, bodies, drive_parts, load_parts, attachments=attached_parts, tracks=document.get("tracks"),
        title=title,
        places=places,
    )  # fmt: skip


def _read_parts(document: Document, key: str, kinds: Mapping[str, type[Any]]) -> tuple[list[Any], dict[str, str]]:
    """The bodies or attachments in ``[[machine.KEY]]``, and their places in the file by path, relative to ``machine``."""
    tables = document.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(description, dict) for description in tables):
        raise InputError(f"machine.{key}", tables, f"must be tables: [[machine.{key}]]")
    parts = []
    for i, description in enumerate(tables):
        name = str(description.get("name", ""))
        location = f"machine.{key}[{i}]" + (f" ({name})" if name.replace("-", "_").isidentifier() else "")
        parts.append(_read_part(kinds, description, location))
    return parts, {part.path: f"{key}[{i}] ({part.name})" for i, part in enumerate(parts)}


def _shafts(document: Document, group: str, kinds: dict[str, type[Any]]) -> tuple[list[Any], dict[str, str]]:
    """Drives or loads, and their places in the file by path, relative to ``machine``."""
    tables = shaft_tables(document, group)
    places = [group if group in document else f"{group}s[{i}]" for i in range(len(tables))]
    shafts = [_read_part(kinds, t, f"machine.{place}") for t, place in zip(tables, places, strict=True)]
    return shafts, dict(zip(shaft_paths(group, [(s.on, s.kind) for s in shafts]), places, strict=True))


def _read_part(kinds: Mapping[str, type[Any]], description: Document, location: str) -> Any:
    """A part from its table, which names its kind."""
    kind = choice(description, "kind", location, kinds)
    return validate_table(kinds[kind], {k: v for k, v in description.items() if k != "kind"}, location)


def _build_machine(document: Document, *parts: Any, places: Mapping[str, str], **options: Any) -> Machine:
    """The machine of these parts. Raises ``InputError`` located in the file: at the places of parts, not at their paths."""
    try:
        return Machine(*parts, schedules=document.get("schedules", ()), **options)
    except InputError as error:
        path = next((p for p in places if error.location.startswith(f"{p}.")), "")
        location = f"{places.get(path, path)}{error.location.removeprefix(path)}"
        raise InputError(location, error.value, error.explanation, code=error.code).with_prefix("machine") from None
