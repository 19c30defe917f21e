"""File -> Machine: the machine part of a study file, checked key by key."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from wucht.documents import Document, checked, choice, no_nan, refuse_unknown, table, text
from wucht.errors import InputError
from wucht.machines.contact import FREQUENCY_RATIO, arranged, evenly, tracks_of
from wucht.machines.doubts import doubts
from wucht.machines.machine import DIMENSIONLESS, Machine, Sliding, Turning, Units
from wucht.machines.models import MODELS
from wucht.machines.parts.base import Body, Drive, Part
from wucht.machines.parts.fields import Parameter
from wucht.machines.parts.rotor import Rotor
from wucht.machines.parts.track import Tracked
from wucht.machines.reading import read_bodies, read_carrier, read_shafts, root_of
from wucht.machines.schedules import Schedule, check_schedules, read_schedules
from wucht.machines.settings import with_settings
from wucht.machines.vibration import operating_speed
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.quantities import Unit

KEYS = (
    "title", "use", "set", "model", "parameters", "carrier", "bodies", "drive", "drives", "load", "loads", "tracks", "schedules"
)  # fmt: skip


def machine_from(document: Document, title: str = "") -> Machine:
    """The machine described by a table ``[machine]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``machine`` on.
    """
    document = copy.deepcopy(document)
    settings = document.pop("set", {})
    if not isinstance(settings, dict):
        raise InputError("machine.set", settings, "allowed is a table: set = { PATH = VALUE }")
    no_nan(document, "machine")
    refuse_unknown(document, KEYS, "machine")
    document = with_settings(document, settings)
    title = text(document, "title", "machine") or title
    document.pop("title", None)
    if "model" in document:
        return _from_model(document, title)
    return _from_parts(document, title)


def _from_model(document: Document, title: str) -> Machine:
    name = choice(document, "model", "machine", MODELS)
    for key in ("carrier", "bodies", "drive", "drives", "load", "loads", "tracks"):
        if key in document:
            raise InputError(f"machine.{key}", None, f"not allowed beside model = {name!r}, which brings its own parts")
    model = checked(MODELS[name], table(document, "parameters", "machine.parameters"), "machine.parameters")
    turning = model.turning()
    frame = model.placed(turning)
    parameters = {p.path: p for p in model.parameters()}
    schedules = read_schedules(document.get("schedules", []), parameters, DIMENSIONLESS.time)
    check_schedules(schedules, (model,))
    return Machine(
        title=title or f"{name}, {model.equations}",
        carrier=model.coordinates(),
        bodies=tuple(Turning(n, kind, turning[n], about) for n, kind, about in model.bodies),
        energies=(model.support(frame), model.energies(frame)),
        parameters=parameters,
        parts=(model,),
        units=DIMENSIONLESS,
        labels=tuple(model.directions),
        axes=frame.axes,
        schedules=schedules,
        mismatch=model.mismatch(frame),
        warnings=model.warnings(),
    ).at(0.0)


def _from_parts(document: Document, title: str) -> Machine:
    if "parameters" in document:
        raise InputError("machine.parameters", None, "allowed only with model = ...; SI machines carry values in their parts")
    table(document, "carrier", "machine.carrier")
    bodies, where = read_bodies(document)
    carrier = read_carrier(document, bodies, where)
    shafts = read_shafts(document, bodies)
    given = {d.on: d.prescribed() for d in shafts if isinstance(d, Drive)}
    prescribed = {name: speed for name, speed in given.items() if speed is not None}
    for b in bodies:
        if b.release is not None and b.name in prescribed:
            raise InputError(f"{where[b.name]}.release", None, "not allowed: the drive prescribes this body's motion")
        alone = b.reference is None and not any(o.reference is None for o in bodies if o is not b)
        if b.release is not None and b.release.speed is not None and alone:
            raise InputError(
                f"{where[b.name]}.release", None, "allowed is { time = ... }: no other body's speed can release it"
            )
    parts: tuple[Part, ...] = (carrier, *bodies, *shafts)
    parameters = {p.path: p for part in parts for p in part.parameters()}
    parameters |= {p.path: p for b in bodies if b.release is not None for p in (_locked(b),)}
    schedules = read_schedules(document.get("schedules", []), parameters, "s")
    check_schedules(schedules, parts)
    over_time = {s.symbol: s.expression for s in schedules}
    _no_jump(schedules, prescribed)
    turning = {
        b.name: Coordinate(
            c.position, c.velocity, True, prescribed[b.name].xreplace(over_time) if b.name in prescribed else None
        )
        for b in bodies
        for c in b.coordinates()
        if b.turns()
    }
    held = tuple(
        replace(c, prescribed=c.prescribed.xreplace(over_time)) if c.prescribed is not None else c
        for c in carrier.coordinates()
    )
    axes = {b.name: carrier.axis_at(_place(root_of(b, bodies))) for b in bodies}
    frame = replace(carrier.placed(), bodies=turning, axes=axes)
    machine = Machine(
        title=title or "machine",
        carrier=held,
        bodies=tuple(Turning(b.name, b.kind, turning[b.name], b.reference, b.release) for b in bodies if b.turns()),
        energies=tuple(p.energies(frame) for p in parts),
        parameters=parameters,
        parts=parts,
        units=Units(),
        labels=carrier.labels,
        sliders=tuple(Sliding(b.name, b.kind, b.coordinates()[0], b.reference or "") for b in bodies if not b.turns()),
        axes=axes,
        start_angles={d.on: d.start_angle() for d in shafts if isinstance(d, Drive) and d.on in prescribed},
        start_positions=carrier.start_positions(),
        schedules=schedules,
        warnings=() if any(s.parameter.startswith(f"{b.name}.") for s in schedules for b in bodies) else doubts(bodies),
    ).at(0.0)
    return _with_tracks(machine, document, [b for b in bodies if isinstance(b, Tracked)], where)


def _locked(body: Body) -> Parameter:
    return Parameter(f"{body.path}.locked", 1.0, "", "lambda", "1 while the body is locked")


def _place(rotor: Body) -> tuple[sp.Expr, sp.Expr]:
    given = isinstance(rotor, Rotor) and rotor.position is not None
    return (rotor.symbol("position.x"), rotor.symbol("position.y")) if given else (sp.S.Zero, sp.S.Zero)


def _no_jump(schedules: tuple[Schedule, ...], prescribed: Mapping[str, sp.Expr]) -> None:
    used = {s for e in prescribed.values() for s in e.free_symbols}
    for i, schedule in enumerate(schedules):
        if schedule.symbol in used and schedule.pieces.jumps():
            raise InputError(
                f"machine.schedules[{i}].interpolation", "steps",
                f"allowed for {schedule.parameter} is 'linear' or 'smooth': a prescribed motion cannot jump",
            )  # fmt: skip


def _with_tracks(machine: Machine, document: Document, bodies: list[Tracked], where: Mapping[str, str]) -> Machine:
    """The machine with its tracks, their bodies evenly spaced until a start arranges them."""
    given = document.get("tracks", {})
    names = sorted({b.track for b in bodies if b.track is not None})
    if not isinstance(given, dict):
        raise InputError("machine.tracks", given, "allowed are tables: [machine.tracks.NAME]")
    refuse_unknown(given, names, "machine.tracks")
    frequency = dict.fromkeys(names, FREQUENCY_RATIO * operating_speed(machine)) if names else {}
    for name, described in given.items():
        refuse_unknown(table(given, name, f"machine.tracks.{name}"), ("contact_frequency",), f"machine.tracks.{name}")
        at = f"machine.tracks.{name}.contact_frequency"
        try:
            frequency[name] = Unit("rad/s", "contact frequency").parse(described.get("contact_frequency", frequency[name]))
        except ValueError as error:
            raise InputError(at, described["contact_frequency"], str(error)) from None
        if frequency[name] <= 0:
            raise InputError(at, described["contact_frequency"], "allowed is a contact frequency greater than 0")
    tracks = tracks_of(bodies, where, frequency, [n for n, t in given.items() if t])
    if not tracks:
        return machine
    blank = replace(machine, tracks=tracks, energies=(*machine.energies, *(Energies() for _ in tracks)))
    spread = {b.name: 0.0 for b in machine.bodies} | {n: a for t in tracks for n, a in evenly(t.bodies).items()}
    return arranged(blank, spread)
