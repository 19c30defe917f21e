"""Parts -> machine: what concerns several parts is checked and put together here, whether they come from a file or from Python.

Faults lie where the parts are: at their paths (``p1.about``, ``drives.e1.on``), or where ``where`` says for a path.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeVar

import sympy as sp

from wucht.checking import read_quantity, refuse_unknown
from wucht.errors import InputError, WuchtError, nearest
from wucht.fields import Parameter
from wucht.machines.models import Model
from wucht.machines.operation import Operated, operating_speed
from wucht.machines.parts.base import Body, Drive, Load, OnShaft, Part
from wucht.machines.parts.support import Support
from wucht.machines.parts.track import Tracked
from wucht.machines.plausibility import doubts
from wucht.machines.schedules import Schedule, schedules_of
from wucht.machines.tracks import FREQUENCY_RATIO, Arrangeable, arranged, evenly, tracks_of
from wucht.machines.tree import RotatingBody, SlidingBody, Tree
from wucht.machines.unit_names import DIMENSIONLESS, Units
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.quantities import Unit

RESERVED = (
    "carrier", "drive", "drives", "load", "loads", "track", "tracks", "schedules", "study", "foundation", "machine", "psi",
    "delta",
)  # fmt: skip
BESIDE_A_MODEL = "not allowed beside model = {!r}, which brings its own parts"

ShaftT = TypeVar("ShaftT", bound=OnShaft)


def assembled(
    carrier: Any, bodies: Any, drives: Any, loads: Any, schedules: Any, tracks: Any, title: str, where: Mapping[str, str]
) -> dict[str, Any]:
    """The fields of a ``Machine`` without contacts, from its parts. See there. Raises ``InputError``."""
    if isinstance(carrier, Model):
        for key, given in {"bodies": bodies, "drives": drives, "loads": loads, "tracks": tracks}.items():
            if given:
                raise InputError(key, None, BESIDE_A_MODEL.format(carrier.kind))
        return _of_model(carrier, schedules, title)
    if not isinstance(carrier, Support):
        raise InputError("carrier", carrier, "allowed is a carrier, or a dimensionless model")
    found = _checked_bodies(_listed(Body, bodies, "bodies"), where)
    _check_carrier(carrier, found, where)
    of_drives = _on_shafts(_listed(Drive, drives, "drives"), found, where)
    for name, count in Counter(d.on for d in of_drives).items():
        if count > 1:
            raise InputError("drives", name, "two drives act on this body; allowed is one a body")
    of_loads = _on_shafts(_listed(Load, loads, "loads"), found, where)
    for (name, kind), count in Counter((x.on, x.kind) for x in of_loads).items():
        if count > 1:
            raise InputError("loads", name, f"two {kind} loads act on this body; allowed is one of each kind")
    return _of_parts(carrier.bearing(found), found, of_drives, of_loads, schedules, title, where)


def _listed(family: Any, given: Any, key: str) -> tuple[Any, ...]:
    """The parts of a list. Raises ``InputError`` for what is none, or none of this family."""
    if not isinstance(given, list | tuple):
        raise InputError(key, given, f"allowed is a list of {key}")
    for i, part in enumerate(given):
        if not isinstance(part, family):
            raise InputError(f"{key}[{i}]", part, f"allowed are {key}, each of a class of wucht.parts")
    return tuple(given)


def _checked_bodies(bodies: tuple[Body, ...], where: Mapping[str, str]) -> tuple[Body, ...]:
    """The bodies, each with a name of its own, and turning about one that is there. Raises ``InputError``."""
    if not bodies:
        raise InputError("bodies", None, "a machine needs at least one body: [[machine.bodies]]")
    for i, body in enumerate(bodies):
        if body.name in RESERVED:
            raise InputError(f"bodies[{i}].name", body.name, f"this name is taken; taken are {', '.join(RESERVED)}")
    repeated = [name for name, count in Counter(b.name for b in bodies).items() if count > 1]
    if repeated:
        raise InputError("bodies", repeated[0], "two bodies have this name; each needs its own")
    by_name, tree = {b.name: b for b in bodies}, Tree({b.name: b.reference for b in bodies})
    for body in bodies:
        at = f"{where.get(body.path, body.path)}.about"
        if body.reference is None:
            continue
        if body.reference not in by_name:
            raise InputError(at, body.reference, f"there is no such body; {nearest(body.reference, by_name)}")
        about = by_name[body.reference]
        if not about.turns():
            raise InputError(at, body.reference, "allowed is a body that turns; this one slides in a guide")
        if not about.on_axis():
            raise InputError(at, body.reference, f"allowed is a body on the axis; this {about.kind} has a suspension off it")
        try:
            tree.path(body.name)
        except WuchtError as error:
            raise InputError(at, body.reference, str(error)) from None
    if all(b.reference is not None for b in bodies):
        raise InputError("bodies", None, "a machine needs a body that turns on the carrier, such as a rotor")
    return bodies


def _check_carrier(carrier: Support, bodies: Iterable[Body], where: Mapping[str, str]) -> None:
    for body in bodies:
        try:
            carrier.check_body(body)
        except ValueError as error:
            key, sentence = error.args
            given = getattr(body, key, None)
            given = list(given) if isinstance(given, tuple) else given
            raise InputError(f"{where.get(body.path, body.path)}.{key}", given, sentence) from None


def shaft_labels(shafts: Sequence[tuple[str, str]]) -> list[str]:
    """What tells drives or loads apart in paths, each given as (body, kind).

    Nothing for the only one, the body, or body and kind where a body has two.
    """
    if len(shafts) == 1:
        return [""]
    count = Counter(on for on, _ in shafts)
    return [on if count[on] == 1 else f"{on}.{kind}" for on, kind in shafts]


def _on_shafts(shafts: tuple[ShaftT, ...], bodies: Sequence[Body], where: Mapping[str, str]) -> tuple[ShaftT, ...]:
    """Drives or loads, each with its body and its label. Raises ``InputError``."""
    names, rotors = [b.name for b in bodies if b.turns()], [b.name for b in bodies if b.turns() and b.reference is None]
    on = [rotors[0] if len(rotors) == 1 and "on" not in s.model_fields_set else s.on for s in shafts]
    found = []
    for i, label in enumerate(shaft_labels([(o, s.kind) for o, s in zip(on, shafts, strict=True)])):
        shaft = shafts[i].model_copy(update={"on": on[i], "label": label})
        path = shaft.path if on[i] or len(shafts) == 1 else f"{shaft.group}s[{i}]"
        at = f"{where.get(path, path)}.on"
        if not on[i] and "on" not in shafts[i].model_fields_set:
            raise InputError(at, None, "this key is missing; needed is the name of the body")
        if on[i] not in names:
            raise InputError(at, on[i], f"there is no such body; {nearest(on[i], names)}")
        found.append(shaft)
    return tuple(found)


def _of_model(model: Model, schedules: Any, title: str) -> dict[str, Any]:
    turning = model.turning()
    frame = model.placed(turning)
    parameters = {p.path: p for p in model.parameters()}
    return {
        "title": title or f"{model.kind}, {model.equations}",
        "carrier": model.coordinates(),
        "bodies": tuple(RotatingBody(n, kind, turning[n], about) for n, kind, about in model.bodies),
        "energies": (model.support(frame), model.energies(frame)),
        "parameters": parameters,
        "parts": (model,),
        "units": DIMENSIONLESS,
        "labels": tuple(model.directions),
        "frame": frame,
        "schedules": schedules_of(schedules, parameters, (model,), DIMENSIONLESS.time),
        "start_angles": {},
        "start_positions": {},
        "mismatch": model.mismatch(frame),
        "warnings": model.warnings(),
    }


def _of_parts(
    carrier: Support, bodies: Sequence[Body], drives: Sequence[Drive], loads: Sequence[Load], schedules: Any, title: str,
    where: Mapping[str, str],
) -> dict[str, Any]:  # fmt: skip
    prescribed = {d.on: speed for d in drives if (speed := d.prescribed()) is not None}
    _check_releases(bodies, prescribed, where)
    parts: tuple[Part, ...] = (carrier, *bodies, *drives, *loads)
    parameters = {p.path: p for part in parts for p in part.parameters()}
    parameters |= {p.path: p for b in bodies if b.release is not None for p in (_locked(b),)}
    over_time = schedules_of(schedules, parameters, parts, Units().time)
    _no_jump(over_time, prescribed)

    def scheduled(speed: sp.Expr | None) -> sp.Expr | None:
        return None if speed is None else speed.xreplace({s.symbol: s.expression for s in over_time})

    turning = {
        b.name: Coordinate(c.position, c.velocity, True, scheduled(prescribed.get(b.name)))
        for b in bodies
        for c in b.coordinates()
        if b.turns()
    }
    by_name, tree = {b.name: b for b in bodies}, Tree({b.name: b.reference for b in bodies})
    axes = {b.name: carrier.axis_at(by_name[tree.root(b.name)].place() or (sp.S.Zero, sp.S.Zero)) for b in bodies}
    frame = replace(carrier.placed(), bodies=turning, axes=axes)
    return {
        "title": title or "machine",
        "carrier": tuple(replace(c, prescribed=scheduled(c.prescribed)) for c in carrier.coordinates()),
        "bodies": tuple(RotatingBody(b.name, b.kind, turning[b.name], b.reference, b.release) for b in bodies if b.turns()),
        "energies": tuple(p.energies(frame) for p in parts),
        "parameters": parameters,
        "parts": parts,
        "units": Units(),
        "labels": carrier.labels,
        "sliders": tuple(SlidingBody(b.name, b.kind, b.coordinates()[0], b.reference or "") for b in bodies if not b.turns()),
        "frame": frame,
        "start_angles": {d.on: d.start_angle() for d in drives if d.on in prescribed},
        "start_positions": carrier.start_positions(),
        "schedules": over_time,
        "warnings": () if any(s.parameter.startswith(f"{b.name}.") for s in over_time for b in bodies) else doubts(bodies),
    }


def _check_releases(bodies: Sequence[Body], prescribed: Mapping[str, sp.Expr], where: Mapping[str, str]) -> None:
    for b in bodies:
        at = f"{where.get(b.path, b.path)}.release"
        if b.release is not None and b.name in prescribed:
            raise InputError(at, None, "not allowed: the drive prescribes this body's motion")
        alone = b.reference is None and not any(o.reference is None for o in bodies if o is not b)
        if b.release is not None and b.release.speed is not None and alone:
            raise InputError(at, None, "allowed is { time = ... }: no other body's speed can release it")


def _locked(body: Body) -> Parameter:
    return Parameter(f"{body.path}.locked", 1.0, "", "lambda", "1 while the body is locked")


def _no_jump(schedules: tuple[Schedule, ...], prescribed: Mapping[str, sp.Expr]) -> None:
    used = {s for e in prescribed.values() for s in e.free_symbols}
    for i, schedule in enumerate(schedules):
        if schedule.symbol in used and schedule.pieces.jumps():
            raise InputError(
                f"schedules[{i}].interpolation", "steps",
                f"allowed for {schedule.parameter} is 'linear' or 'smooth': a prescribed motion cannot jump",
            )  # fmt: skip


class _Assembled(Operated, Arrangeable, Protocol):
    """A machine whose parts are in place."""

    @property
    def parts(self) -> tuple[Part, ...]: ...


MachineT = TypeVar("MachineT", bound=_Assembled)


def with_tracks(machine: MachineT, given: Any, where: Mapping[str, str]) -> MachineT:
    """The machine with the contacts of its tracks, their bodies evenly spaced until a start arranges them.

    given: tables with the key ``contact_frequency`` by the name of the track. Raises ``InputError``.
    """
    bodies = [p for p in machine.parts if isinstance(p, Tracked)]
    names = sorted({b.track for b in bodies if b.track is not None})
    if not isinstance(given, Mapping):
        raise InputError("tracks", given, "allowed are tables: [machine.tracks.NAME]")
    refuse_unknown(given, names, "tracks")
    frequency = dict.fromkeys(names, FREQUENCY_RATIO * operating_speed(machine)) if names else {}
    for name, described in given.items():
        if not isinstance(described, Mapping):
            raise InputError(f"tracks.{name}", described, f"allowed is a table: [machine.tracks.{name}]")
        refuse_unknown(described, ("contact_frequency",), f"tracks.{name}")
        at = f"tracks.{name}.contact_frequency"
        asked = described.get("contact_frequency", frequency[name])
        frequency[name] = read_quantity(Unit("rad/s", "contact frequency"), asked, at)
        if frequency[name] <= 0:
            raise InputError(at, asked, "allowed is a contact frequency greater than 0")
    tracks = tracks_of(bodies, where, frequency, [n for n, t in given.items() if t])
    if not tracks:
        return machine
    blank = machine.changed(tracks=tracks, energies=(*machine.energies, *(Energies() for _ in tracks)))
    spread = {b.name: 0.0 for b in machine.bodies} | {n: a for t in tracks for n, a in evenly(t.bodies).items()}
    return arranged(blank, spread)
