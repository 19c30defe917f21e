"""The parts in a machine file, each checked on its own and against the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from wucht.documents import Document, checked, choice, table
from wucht.errors import InputError, nearest
from wucht.machines.parts import bodies as body_kinds
from wucht.machines.parts import drives as drive_kinds
from wucht.machines.parts import loads as load_kinds
from wucht.machines.parts.base import Body, OnShaft
from wucht.machines.parts.carrier import Carrier
from wucht.machines.parts.pendulum import Pendulum
from wucht.machines.parts.planar_carrier import PlanarCarrier
from wucht.machines.parts.rocking_carrier import RockingCarrier
from wucht.machines.parts.rotor import Rotor
from wucht.machines.parts.support import Support
from wucht.machines.settings import shaft_labels, shaft_tables

CARRIERS: dict[str, type[Support]] = {
    "x": Carrier, "y": Carrier, "xy": Carrier, "fixed": Carrier, "xyr": PlanarCarrier, "r": RockingCarrier
}  # fmt: skip
_LATER_BODIES = ("switchable-pendulum",)
_RESERVED = (
    "carrier", "drive", "drives", "load", "loads", "track", "tracks", "schedules", "study", "foundation", "machine", "psi",
    "delta",
)  # fmt: skip


def part(cls: type[Any], document: Document, where: str) -> Any:
    """A part from its table. Raises ``InputError``."""
    found = checked(cls, document, where)
    try:
        found.check()
    except ValueError as error:
        if len(error.args) != 2:
            raise
        key, sentence = error.args
        raise InputError(f"{where}.{key}", document.get(key), sentence) from None
    return found


def read_carrier(document: Document, bodies: Sequence[Body], where: Mapping[str, str]) -> Support:
    """The carrier, and whether the bodies fit on it. where: of each body, for errors. Raises ``InputError``."""
    described = table(document, "carrier", "machine.carrier")
    directions = choice({"directions": "xy"} | described, "directions", "machine.carrier", CARRIERS)
    couples = [b for b in bodies if isinstance(b, Rotor) and b.couple_unbalance is not None]
    found: Support = part(CARRIERS[directions], described, "machine.carrier")
    for b in bodies:
        if isinstance(b, Rotor) and b.position is not None and directions not in ("xyr", "r"):
            raise InputError(
                f"{where[b.name]}.position", list(b.position), f"allowed on a carrier 'xyr'; this one is {directions!r}"
            )
    if couples and directions != "r":
        at = f"{where[couples[0].name]}.couple_unbalance"
        raise InputError(at, couples[0].couple_unbalance, f"allowed on a carrier 'r'; this one is {directions!r}")
    return found.model_copy(update={"tilting": True}) if couples else found


def read_bodies(document: Document) -> tuple[list[Body], dict[str, str]]:
    """The bodies in ``[[machine.bodies]]``, and where each of them stands. Raises ``InputError``."""
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
        bodies.append(part(cls, {k: v for k, v in table_.items() if k != "kind"}, where))
    for i, body in enumerate(bodies):
        if body.name in _RESERVED:
            raise InputError(f"machine.bodies[{i}].name", body.name, f"this name is taken; taken are {', '.join(_RESERVED)}")
    repeated = [name for name, count in Counter(b.name for b in bodies).items() if count > 1]
    if repeated:
        raise InputError("machine.bodies", repeated[0], "two bodies have this name; each needs its own")
    where_of = {b.name: f"machine.bodies[{i}] ({b.name})" for i, b in enumerate(bodies)}
    _check_references(bodies, where_of)
    return bodies, where_of


def _check_references(bodies: list[Body], where: Mapping[str, str]) -> None:
    by_name = {b.name: b for b in bodies}
    for body in bodies:
        at = f"{where[body.name]}.about"
        if body.reference is None:
            continue
        if body.reference not in by_name:
            raise InputError(at, body.reference, f"there is no such body; {nearest(body.reference, by_name)}")
        about = by_name[body.reference]
        if not about.turns():
            raise InputError(at, body.reference, "allowed is a body that turns; this one slides in a guide")
        if isinstance(about, Pendulum) and about.suspension not in (None, (0.0, 0.0)):
            raise InputError(at, body.reference, "allowed is a body on the axis; this pendulum has a suspension off it")
        seen, here = {body.name}, body.reference
        while here is not None:
            if here in seen:
                circle = "bodies turn about each other in a circle; one must turn about the carrier's axis"
                raise InputError(at, body.reference, circle)
            seen.add(here)
            here = by_name[here].reference if here in by_name else None  # type: ignore[assignment]
    if all(b.reference is not None for b in bodies):
        raise InputError("machine.bodies", None, "a machine needs a body that turns on the carrier, such as a rotor")


def root_of(body: Body, bodies: Iterable[Body]) -> Body:
    """The body on the carrier that a body turns about, directly or through others; itself if it is one."""
    by_name = {b.name: b for b in bodies}
    while body.reference is not None:
        body = by_name[body.reference]
    return body


def read_shafts(document: Document, bodies: Sequence[Body]) -> list[OnShaft]:
    """Drives and loads. Raises ``InputError``."""
    drives = _on_shafts(document, bodies, "drive", drive_kinds())
    for name, count in Counter(d.on for d in drives).items():
        if count > 1:
            raise InputError("machine.drives", name, "two drives act on this body; allowed is one a body")
    loads = _on_shafts(document, bodies, "load", load_kinds())
    for (name, kind), count in Counter((x.on, x.kind) for x in loads).items():
        if count > 1:
            raise InputError("machine.loads", name, f"two {kind} loads act on this body; allowed is one of each kind")
    return [*drives, *loads]


def _on_shafts(document: Document, bodies: Sequence[Body], group: str, kinds: Mapping[str, type[Any]]) -> list[OnShaft]:
    tables = shaft_tables(document, group)
    names = [b.name for b in bodies if b.turns()]
    found: list[OnShaft] = []
    for i, (given, label) in enumerate(zip(tables, shaft_labels(tables), strict=True)):
        where = f"machine.{group}" if group in document else f"machine.{group}s[{i}]"
        cls = kinds[choice(given, "kind", where, kinds)]
        content = {k: v for k, v in given.items() if k != "kind"}
        shaft = part(cls, content, where).model_copy(update={"label": label})
        if shaft.on not in names:
            raise InputError(f"{where}.on", shaft.on, f"there is no such body; {nearest(shaft.on, names)}")
        found.append(shaft)
    return found
