"""File -> Machine: the machine part of a study file, checked key by key."""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Mapping
from typing import Any

import sympy as sp

from wucht.documents import Document, checked, choice, flatten, no_nan, refuse_unknown, table, text
from wucht.errors import InputError, nearest
from wucht.machines.doubts import doubts
from wucht.machines.machine import DIMENSIONLESS, Machine, Turning, Units
from wucht.machines.models import MODELS
from wucht.machines.parts import bodies as body_kinds
from wucht.machines.parts import drives as drive_kinds
from wucht.machines.parts.base import Body, Drive, Frame, Part
from wucht.machines.parts.carrier import Carrier
from wucht.mechanics.lagrange import Coordinate

KEYS = ("title", "use", "set", "model", "parameters", "carrier", "bodies", "drive", "drives")
NOT_YET = ("loads", "schedules")
_LATER_BODIES = ("slider", "switchable-pendulum")
_LATER_DRIVES = ("constant-torque", "dc-separate", "dc-shunt", "dc-series", "induction", "table", "synchronous")
_RESERVED = ("carrier", "drive", "drives", "study", "foundation", "machine", "psi", "delta")


def machine_from(document: Document, title: str = "") -> Machine:
    """The machine described by a table ``[machine]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``machine`` on.
    """
    document = copy.deepcopy(document)
    settings = document.pop("set", {})
    if not isinstance(settings, dict):
        raise InputError("machine.set", settings, "allowed is a table: set = { PATH = VALUE }")
    no_nan(document, "machine")
    refuse_unknown(document, KEYS, "machine", NOT_YET)
    document = with_settings(document, settings)
    title = text(document, "title", "machine") or title
    document.pop("title", None)
    if "model" in document:
        return _from_model(document, title)
    return _from_parts(document, title)


def with_settings(document: Document, settings: Mapping[str, Any]) -> Document:
    """A copy of the machine's table with parameters set by path. Raises ``InputError`` for a path that leads nowhere."""
    document = copy.deepcopy(document)
    for path, value in flatten(settings).items():
        if isinstance(value, float):
            no_nan(value, f"machine.set.{path}")
        _set(document, path, value)
    return document


def _set(document: Document, path: str, value: Any) -> None:
    head, *rest = path.split(".")
    where = f"machine.set.{path}"
    if head == "study":
        raise InputError(where, value, "a key of [study] is set from the command line as study.KEY=VALUE")
    if "model" in document:
        known = [f.alias or n for n, f in MODELS[choice(document, "model", "machine", MODELS)].model_fields.items()]
        if rest or head not in known:
            raise InputError(where, value, f"unknown parameter; {nearest(path, known)}")
        table(document | {"parameters": document.setdefault("parameters", {})}, "parameters", "machine.parameters")[head] = (
            value
        )
        return
    parts = _addressable(document)
    key = next((k for k in (f"{head}.{rest[0]}" if rest else "", head) if k in parts), None)
    if key is None or not path[len(key) + 1 :]:
        raise InputError(where, value, f"unknown parameter; {nearest(head, parts)}, each followed by '.key'")
    inner = path[len(key) + 1 :].split(".")
    target: Any = parts[key]
    if len(inner) == 2 and inner[1] in ("x", "y") and isinstance(target.get(inner[0]), list):
        target[inner[0]]["xy".index(inner[1])] = value
    elif len(inner) == 1:
        target[inner[0]] = value
    elif len(inner) == 2 and inner[1] in ("x", "y") and inner[0] in target:
        raise InputError(where, value, f"{key}.{inner[0]} is one number here; set both at once: {key}.{inner[0]} = [X, Y]")
    else:
        raise InputError(where, value, f"unknown parameter; {nearest(inner[0], target)} in {key}")


def _addressable(document: Document) -> dict[str, Document]:
    found: dict[str, Document] = {}
    if isinstance(document.get("carrier"), dict):
        found["carrier"] = document["carrier"]
    for body in document.get("bodies", []):
        if isinstance(body, dict) and "name" in body:
            found[str(body["name"])] = body
    drives = _drive_tables(document)
    for drive in drives:
        found["drive" if len(drives) == 1 else f"drives.{drive.get('on', '')}"] = drive
    return found


def _drive_tables(document: Document) -> list[Document]:
    single, several = document.get("drive"), document.get("drives", [])
    if single is not None and several:
        raise InputError("machine.drives", None, "allowed is either [machine.drive] or [[machine.drives]]")
    if single is not None and not isinstance(single, dict):
        raise InputError("machine.drive", single, "allowed is a table: [machine.drive]")
    if not isinstance(several, list) or not all(isinstance(d, dict) for d in several):
        raise InputError("machine.drives", several, "allowed are tables: [[machine.drives]]")
    return [single] if single is not None else several


def _from_model(document: Document, title: str) -> Machine:
    name = choice(document, "model", "machine", MODELS)
    for key in ("carrier", "bodies", "drive", "drives"):
        if key in document:
            raise InputError(f"machine.{key}", None, f"not allowed beside model = {name!r}, which brings its own parts")
    model = checked(MODELS[name], table(document, "parameters", "machine.parameters"), "machine.parameters")
    turning = model.turning()
    carrier = model.coordinates()
    frame = _frame(carrier, sp.S.Zero, turning)
    return Machine(
        title=title or f"{name}, {model.equations}",
        carrier=carrier,
        bodies=tuple(Turning(n, kind, turning[n], about) for n, kind, about in model.bodies),
        energies=(model.support(frame), model.energies(frame)),
        parameters={p.path: p for p in model.parameters()},
        parts=(model,),
        units=DIMENSIONLESS,
        mismatch=model.mismatch(frame),
        warnings=model.warnings(),
    )


def _from_parts(document: Document, title: str) -> Machine:
    if "parameters" in document:
        raise InputError("machine.parameters", None, "allowed only with model = ...; SI machines carry values in their parts")
    described = table(document, "carrier", "machine.carrier")
    if described.get("directions") in ("xyr", "r"):
        raise InputError("machine.carrier.directions", described["directions"], "not yet; allowed is 'x', 'y' or 'xy'")
    carrier = _part(Carrier, described, "machine.carrier")
    bodies = _bodies(document)
    drives = _drives(document, bodies)
    prescribed = {d.on: d for d in drives if d.prescribed() is not None}
    turning = {
        b.name: Coordinate(c.position, c.velocity, True, prescribed[b.name].prescribed() if b.name in prescribed else None)
        for b in bodies
        for c in b.coordinates()
    }
    parts: tuple[Part, ...] = (carrier, *bodies, *drives)
    frame = _frame(carrier.coordinates(), carrier.symbol("gravity"), turning)
    parameters = {p.path: p for part in parts for p in part.parameters()}
    return Machine(
        title=title or "machine",
        carrier=carrier.coordinates(),
        bodies=tuple(Turning(b.name, b.kind, turning[b.name], b.reference) for b in bodies),
        energies=tuple(p.energies(frame) for p in parts),
        parameters=parameters,
        parts=parts,
        units=Units(),
        start_angles={name: d.start_angle() for name, d in prescribed.items()},
        warnings=doubts(bodies),
    )


def _frame(carrier: tuple[Coordinate, ...], gravity: sp.Expr, turning: Mapping[str, Coordinate]) -> Frame:
    axes = {c.position.name[-1]: c for c in carrier}
    position = {d: c.position for d, c in axes.items()}
    velocity = {f"v{d}": c.velocity for d, c in axes.items()}
    return Frame(**position, **velocity, gravity=gravity, bodies=turning)


def _part(cls: type[Any], document: Document, where: str) -> Any:
    part = checked(cls, document, where, cls.not_yet)
    try:
        part.check()
    except ValueError as error:
        key, sentence = error.args
        raise InputError(f"{where}.{key}", document.get(key), sentence) from None
    return part


def _bodies(document: Document) -> list[Body]:
    listed = document.get("bodies", [])
    if not isinstance(listed, list) or not all(isinstance(b, dict) for b in listed):
        raise InputError("machine.bodies", listed, "allowed are tables: [[machine.bodies]]")
    if not listed:
        raise InputError("machine.bodies", None, "a machine needs at least one body: [[machine.bodies]]")
    bodies: list[Body] = []
    for i, table_ in enumerate(listed):
        name = str(table_.get("name", ""))
        where = f"machine.bodies[{i}]" + (f" ({name})" if name.replace("-", "_").isidentifier() else "")
        cls = body_kinds()[choice(table_, "kind", where, body_kinds(), _LATER_BODIES)]
        bodies.append(_part(cls, {k: v for k, v in table_.items() if k != "kind"}, where))
    for i, body in enumerate(bodies):
        if body.name in _RESERVED:
            raise InputError(f"machine.bodies[{i}].name", body.name, f"this name is taken; taken are {', '.join(_RESERVED)}")
    repeated = [name for name, count in Counter(b.name for b in bodies).items() if count > 1]
    if repeated:
        raise InputError("machine.bodies", repeated[0], "two bodies have this name; each needs its own")
    _check_references(bodies)
    return bodies


def _check_references(bodies: list[Body]) -> None:
    about = {b.name: b.reference for b in bodies}
    for i, body in enumerate(bodies):
        where = f"machine.bodies[{i}] ({body.name}).about"
        if body.reference is not None and body.reference not in about:
            raise InputError(where, body.reference, f"there is no such body; {nearest(body.reference, about)}")
        seen, here = {body.name}, body.reference
        while here is not None:
            if here in seen:
                raise InputError(
                    where,
                    body.reference,
                    "bodies turn about each other in a circle; one must turn about the carrier's axis",
                )
            seen.add(here)
            here = about[here]


def _drives(document: Document, bodies: list[Body]) -> list[Drive]:
    tables = _drive_tables(document)
    names = [b.name for b in bodies]
    rotors = [b.name for b in bodies if b.reference is None]
    drives: list[Drive] = []
    for i, given in enumerate(tables):
        where = "machine.drive" if "drive" in document else f"machine.drives[{i}]"
        cls = drive_kinds()[choice(given, "kind", where, drive_kinds(), _LATER_DRIVES)]
        content = {k: v for k, v in given.items() if k != "kind"}
        if "on" not in content and len(rotors) == 1:
            content["on"] = rotors[0]
        drive = _part(cls, content, where).model_copy(update={"several": len(tables) > 1})
        if drive.on not in names:
            raise InputError(f"{where}.on", drive.on, f"there is no such body; {nearest(drive.on, names)}")
        drives.append(drive)
    for name, count in Counter(d.on for d in drives).items():
        if count > 1:
            raise InputError("machine.drives", name, "two drives act on this body; allowed is one a body")
    return drives
