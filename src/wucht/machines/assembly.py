"""Assembly of a machine from its parts, with the checks that concern several parts, from a file or from Python.

Errors are located at the paths of the parts (``p1.about``, ``drives.e1.on``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

import sympy as sp

from wucht.errors import InputError, WuchtError, code_of, nearest
from wucht.machines.attaching import check_attachments, place_of
from wucht.machines.models import DimensionlessMachine
from wucht.machines.operation import fastest_operating_speed
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load, Part, ShaftPart
from wucht.machines.parts.support import Support
from wucht.machines.parts.track import TrackBody, check_frequency
from wucht.machines.schedules import Schedule, schedules_of
from wucht.machines.structure import DIMENSIONLESS, Units
from wucht.machines.tracks import FREQUENCY_RATIO, MechanismT, arrange_contacts, balancing_capacity, starts, tracks_of
from wucht.machines.tree import RotatingBody, SlidingBody, Tree
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import Parameter, Unit, read_quantity, refuse_unknown

RESERVED_NAMES = (
    "attachments", "carrier", "drive", "drives", "load", "loads", "track", "tracks", "schedules", "study", "foundation",
    "machine", "psi", "delta",
)  # fmt: skip
MODEL_CONFLICT = "not allowed beside model = {!r}, which defines all parts itself"

ShaftT = TypeVar("ShaftT", bound=ShaftPart)


def assemble_parts(
    carrier: Any, bodies: Any, drives: Any, loads: Any, attachments: Any, schedules: Any, tracks: Any, title: str
) -> dict[str, Any]:
    """Return the fields of a ``Machine`` without contacts, from its parts. See there. Raises ``InputError``."""
    if isinstance(carrier, DimensionlessMachine):
        conflicting_parts = {"bodies": bodies, "drives": drives, "loads": loads, "attachments": attachments, "tracks": tracks}
        for key, value in conflicting_parts.items():
            if value:
                raise InputError(key, None, MODEL_CONFLICT.format(carrier.kind))
        return _fields_of_model(carrier, schedules, title)
    if not isinstance(carrier, Support):
        raise InputError("carrier", carrier, "must be a carrier, or a dimensionless model")
    bodies = _parts_of(Body, bodies, "bodies")
    _check_bodies(bodies)
    _check_carrier(carrier, bodies)
    drives = _attach_to_shafts(_parts_of(Drive, drives, "drives"), bodies)
    if name := _first_duplicate(d.on for d in drives):
        raise InputError("drives", name, "two drives act on this body; there must be at most one per body")
    loads = _attach_to_shafts(_parts_of(Load, loads, "loads"), bodies)
    if load := _first_duplicate((x.on, x.kind) for x in loads):
        raise InputError("loads", load[0], f"two {load[1]} loads act on this body; there must be at most one of each kind")
    attachments, bearing = _parts_of(Attachment, attachments, "attachments"), carrier.with_bodies(bodies)
    check_attachments(attachments, bearing, (*RESERVED_NAMES, *(b.name for b in bodies)))
    return _fields_of_parts(bearing, bodies, drives, loads, attachments, schedules, title)


def _first_duplicate(names: Iterable[Any]) -> Any:
    """Return the first item that occurs twice, None without one."""
    return next((name for name, count in Counter(names).items() if count > 1), None)


def _parts_of(family: Any, value: Any, key: str) -> tuple[Any, ...]:
    """Return the parts of a list. Raises ``InputError`` for anything else than a part of this family."""
    if not isinstance(value, list | tuple):
        raise InputError(key, value, f"must be a list of {key}")
    for i, part in enumerate(value):
        if not isinstance(part, family):
            raise InputError(f"{key}[{i}]", part, f"must be {key}, each an instance of a class of wucht.parts")
    return tuple(value)


def _check_bodies(bodies: Sequence[Body]) -> None:
    """Check that each body has a unique name, and turns about an existing body. Raises ``InputError``."""
    if not bodies:
        raise InputError("bodies", None, "a machine needs at least one body: [[machine.bodies]]")
    for i, body in enumerate(bodies):
        if body.name in RESERVED_NAMES:
            raise InputError(f"bodies[{i}].name", body.name, f"this name is reserved, as are {', '.join(RESERVED_NAMES)}")
    if name := _first_duplicate(b.name for b in bodies):
        raise InputError("bodies", name, "two bodies have this name; the names of bodies must differ")
    for body in (b for b in bodies if b.reference is not None):
        if fault := _fault_of_reference(body, bodies):
            raise InputError(f"{body.path}.about", body.reference, fault)
    if all(b.reference is not None for b in bodies):
        raise InputError("bodies", None, "a machine needs a body that turns on the carrier, such as a rotor")


def _fault_of_reference(body: Body, bodies: Sequence[Body]) -> str:
    about = next((b for b in bodies if b.name == body.reference), None)
    if about is None:
        return f"there is no such body; {nearest(body.reference or '', [b.name for b in bodies])}"
    if not about.turns():
        return "must be a body that turns; this one slides in a guide"
    if not about.is_on_axis():
        return f"must be a body on the axis; this {about.kind} has a suspension off it"
    try:
        Tree({b.name: b.reference for b in bodies}).path(body.name)
    except WuchtError as error:
        return str(error)
    return ""


def _check_carrier(carrier: Support, bodies: Iterable[Body]) -> None:
    for body in bodies:
        try:
            carrier.check_body(body)
        except ValueError as error:
            key, sentence = error.args
            value = getattr(body, key, None)
            plain_value = list(value) if isinstance(value, tuple) else value
            raise InputError(f"{body.path}.{key}", plain_value, sentence, code=code_of(error)) from None


def shaft_labels(shafts: Sequence[tuple[str, str]]) -> list[str]:
    """Return the labels that distinguish drives or loads in paths, each given as (body, kind).

    Empty for the only one, else the body, or body and kind where a body has two.
    """
    if len(shafts) == 1:
        return [""]
    count = Counter(on for on, _ in shafts)
    return [on if count[on] == 1 else f"{on}.{kind}" for on, kind in shafts]


def _attach_to_shafts(shafts: tuple[ShaftT, ...], bodies: Sequence[Body]) -> tuple[ShaftT, ...]:
    """Return drives or loads, each with its body and its label. Raises ``InputError``."""
    names, rotors = [b.name for b in bodies if b.turns()], [b.name for b in bodies if b.turns() and b.reference is None]
    on = [rotors[0] if len(rotors) == 1 and "on" not in s.model_fields_set else s.on for s in shafts]
    labels = shaft_labels([(body, s.kind) for body, s in zip(on, shafts, strict=True)])
    labelled_shafts = tuple(s.model_copy(update={"on": o, "label": x}) for s, o, x in zip(shafts, on, labels, strict=True))
    for i, shaft in enumerate(labelled_shafts):
        place = shaft.path if shaft.on or len(shafts) == 1 else f"{shaft.group}s[{i}]"
        if not shaft.on and "on" not in shafts[i].model_fields_set:
            raise InputError(f"{place}.on", None, "this key is missing; give the name of the body", code="missing")
        if shaft.on not in names:
            raise InputError(f"{place}.on", shaft.on, f"there is no such body; {nearest(shaft.on, names)}")
    return labelled_shafts


def _fields_of_model(model: DimensionlessMachine, schedules: Any, title: str) -> dict[str, Any]:
    frame = model.reference_frame()
    parameters, units = {p.path: p for p in model.parameters()}, DIMENSIONLESS
    return {
        "title": title or f"{model.kind}, {model.equations}",
        "carrier": model.coordinates(),
        "bodies": tuple(RotatingBody(n, kind, frame.bodies[n], about) for n, kind, about in model.bodies),
        "energies": (model.support(frame), model.energies(frame)),
        "parameters": parameters,
        "parts": (model,),
        "units": units,
        "labels": tuple(model.directions),
        "frame": frame,
        "schedules": schedules_of(schedules, parameters, (model,), units.time),
        "start_angles": {},
        "start_positions": {},
        "sliders": (),
        "mismatch": model.mismatch(frame),
        "warnings": model.warnings(),
    }


def _fields_of_parts(
    carrier: Support, bodies: Sequence[Body], drives: Sequence[Drive], loads: Sequence[Load],
    attachments: Sequence[Attachment], schedules: Any, title: str,
) -> dict[str, Any]:  # fmt: skip
    carrier, tuning = carrier.tune_springs(partial(_moving_inertia, carrier, bodies))
    prescribed_speeds = {d.on: speed for d in drives if (speed := d.prescribed_body_speed()) is not None}
    _check_releases(bodies, prescribed_speeds)
    parts: tuple[Part, ...] = (carrier, *bodies, *drives, *loads, *attachments)
    parameters = {p.path: p for part in parts for p in part.parameters()}
    for b in (b for b in bodies if b.release is not None):
        parameters[f"{b.path}.locked"] = Parameter(f"{b.path}.locked", 1.0, "", "lambda", "1 while the body is locked")
    over_time = schedules_of(schedules, parameters, parts, Units().time)
    _check_jumps(over_time, prescribed_speeds)
    values = {s.symbol: s.expression for s in over_time}

    def with_schedule(coordinate: Coordinate, speed: sp.Expr | None) -> Coordinate:
        return replace(coordinate, prescribed_velocity=None if speed is None else speed.xreplace(values))

    turning = {b.name: with_schedule(b.coordinates()[0], prescribed_speeds.get(b.name)) for b in bodies if b.turns()}
    by_name, tree = {b.name: b for b in bodies}, Tree({b.name: b.reference for b in bodies})
    axes = {b.name: carrier.axis_at(by_name[tree.root(b.name)].place() or (sp.S.Zero, sp.S.Zero)) for b in bodies}
    axes |= {a.name: place_of(a, carrier) for a in attachments}
    frame = replace(carrier.reference_frame(), bodies=turning, axes=axes)
    has_body_schedules = any(s.parameter.startswith(f"{b.name}.") for s in over_time for b in bodies)
    return {
        "title": title or "machine",
        "carrier": tuple(with_schedule(c, c.prescribed_velocity) for c in carrier.coordinates()),
        "bodies": tuple(RotatingBody(b.name, b.kind, turning[b.name], b.reference, b.release) for b in bodies if b.turns()),
        "energies": tuple(p.energies(frame) for p in parts),
        "parameters": parameters,
        "parts": parts,
        "units": Units(),
        "labels": carrier.labels,
        "sliders": tuple(x for b in bodies for x in _sliding(b)),
        "frame": frame,
        "start_angles": {d.on: d.start_angle() for d in drives if d.on in prescribed_speeds},
        "start_positions": carrier.start_positions(),
        "schedules": over_time,
        "warnings": (*(doubt for d in drives for doubt in d.doubts()), *(() if has_body_schedules else _doubts(bodies))),
        "notes": _once((*([tuning] if tuning else []), *(n for part in parts for n in part.derivation_notes()))),
    }


def _once(notes: Sequence[str]) -> tuple[str, ...]:
    """Return notes, ``path: text`` each; equal parts share one, ``drives.e1, drives.e2: text``."""
    paths: dict[str, dict[str, None]] = {}
    for path, _, text in (note.partition(": ") for note in notes):
        paths.setdefault(text, {})[path] = None
    return tuple(f"{', '.join(of_text)}: {text}" for text, of_text in paths.items())


def _moving_inertia(carrier: Support, bodies: Sequence[Body], label: str) -> float:
    """Return the mass in kg, or moment of inertia in kg m^2, that moves with a coordinate of the carrier, bodies in place.

    It is the second derivative of the kinetic energy of all by the coordinate's velocity.
    """
    by_name, tree = {b.name: b for b in bodies}, Tree({b.name: b.reference for b in bodies})
    roots = {b.name: by_name[tree.root(b.name)] for b in bodies}
    places = {name: tuple(map(sp.Float, map(root.number, root.place() or (0, 0)))) for name, root in roots.items()}
    body_coordinates = {b.name: c for b in bodies for c in b.coordinates() if c.angle}
    frame = replace(
        carrier.reference_frame(),
        bodies=body_coordinates,
        axes={name: carrier.axis_at(place) for name, place in places.items()},
    )
    velocity = dict(zip(carrier.labels, carrier.coordinates(), strict=True))[label].velocity
    return sum(p.number(sp.diff(p.energies(frame).kinetic, velocity, 2)) for p in (carrier, *bodies))


def _sliding(body: Body) -> list[SlidingBody]:
    """Return the sliding bodies: the body itself in a guide, or a mass in one that turns."""
    guide = body.name if body.turns() else body.reference or ""
    return [SlidingBody(body.name, body.kind, c, guide) for c in body.coordinates() if not c.angle]


def _check_releases(bodies: Sequence[Body], prescribed_speeds: Mapping[str, sp.Expr]) -> None:
    on_carrier = [b.name for b in bodies if b.reference is None]
    for b in bodies:
        if b.release and b.name in prescribed_speeds:
            refusal = "not allowed: the drive prescribes this body's motion"
            raise InputError(f"{b.path}.release", None, refusal, code="prescribed")
        if b.release and b.release.speed is not None and on_carrier == [b.name]:
            requirement = "must be { time = ... }: no other body's speed can release it"
            raise InputError(f"{b.path}.release", None, requirement, code="out-of-reach")


def _check_jumps(schedules: tuple[Schedule, ...], prescribed_speeds: Mapping[str, sp.Expr]) -> None:
    symbols = {s for e in prescribed_speeds.values() for s in e.free_symbols}
    for i, schedule in enumerate(schedules):
        if schedule.symbol in symbols and schedule.pieces.jumps():
            sentence = f"allowed for {schedule.parameter} is 'linear' or 'smooth': a prescribed motion cannot jump"
            raise InputError(f"schedules[{i}].interpolation", "steps", sentence)


_ROUNDING = 1e-9  # of an unbalance
_EXCITING = 1.5  # times the rotor's unbalance: a single body with more is part of an exciter, and not to balance the rotor


def _doubts(bodies: Sequence[Body]) -> tuple[str, ...]:
    """Return warnings about rotors that their balancers cannot balance, and the warnings of the bodies."""
    warnings = []
    turning = [b for b in bodies if b.turns()]
    for rotor in (b for b in turning if b.reference is None):
        rotor_moment = rotor.number(rotor.moment())
        moments = {b.name: b.number(b.largest_moment()) for b in turning if b.reference == rotor.name}
        balancers = list(moments.values())
        capacity = balancing_capacity(moments, [b for b in turning if b.name in moments and isinstance(b, TrackBody)])
        if balancers and rotor_moment > capacity * (1 + _ROUNDING):
            side_by_side = ", side by side on their track" if capacity < sum(balancers) * (1 - _ROUNDING) else ""
            together = (
                f"the {capacity:.4g} kg m that its balancers can compensate together{side_by_side}; they can only reduce it"
            )
            warnings.append(f"the unbalance of {rotor.name!r} is {rotor_moment:.4g} kg m, more than {together}")
        largest = max(balancers, default=0.0)
        if len(balancers) > 1 and largest > rotor_moment + sum(balancers) - largest:
            rest = "the rotor and all other balancers together: they cannot compensate each other"
            warnings.append(f"one balancer of {rotor.name!r} has {largest:.4g} kg m, more than {rest}")
        if len(balancers) == 1 and 1.01 * rotor_moment < largest <= _EXCITING * rotor_moment:
            only = f"one body compensates only an equal unbalance, and the rotor's is {rotor_moment:.4g} kg m"
            warnings.append(f"{rotor.name!r} has one balancer, of {largest:.4g} kg m: {only}")
    return (*warnings, *(doubt for b in bodies for doubt in b.doubts()))


def with_tracks(machine: MechanismT, tables: Any) -> MechanismT:
    """Return the machine with the contacts of its tracks, their bodies evenly spaced until a start arranges them.

    tables: with the key ``contact_frequency`` by the name of the track. Raises ``InputError``.
    """
    bodies = [p for p in machine.parts if isinstance(p, TrackBody)]
    names = sorted({b.track for b in bodies if b.track is not None})
    if not isinstance(tables, Mapping):
        raise InputError("tracks", tables, "must be tables: [machine.tracks.NAME]")
    refuse_unknown(tables, names, "tracks")
    frequency = dict.fromkeys(names, FREQUENCY_RATIO * fastest_operating_speed(machine)) if names else {}
    for name, table in tables.items():
        if not isinstance(table, Mapping):
            raise InputError(f"tracks.{name}", table, f"must be a table: [machine.tracks.{name}]")
        refuse_unknown(table, ("contact_frequency",), f"tracks.{name}")
        at = f"tracks.{name}.contact_frequency"
        value = table.get("contact_frequency", frequency[name])
        frequency[name] = read_quantity(Unit("rad/s", "contact frequency"), value, at)
        check_frequency(frequency[name], value, at)
    tracks = tracks_of(bodies, frequency, [n for n, t in tables.items() if t])
    if not tracks:
        return machine
    blank = machine.with_fields(tracks=tracks, energies=(*machine.energies, *(Energies() for _ in tracks)))
    angles = {b.name: 0.0 for b in machine.bodies} | {n: a for t in tracks for n, a in starts(t.bodies).items()}
    return arrange_contacts(blank, angles, location="bodies")
