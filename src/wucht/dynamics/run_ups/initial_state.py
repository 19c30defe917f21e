"""Initial states: from a study file to the state vector of a System, and the machine in that state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.machines.changes import leader_of
from wucht.machines.machine import Machine
from wucht.machines.parts.track import Tracked
from wucht.machines.tracks import arranged, starts
from wucht.mechanics.energies import Internal
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import Unit, article, read_quantity, refuse_unknown

_ROUNDING = 1e-9  # of the size


def owners(machine: Machine) -> list[str]:
    """The keys of a start that hold internal states of parts: names of attachments, ``drive`` or ``drives``."""
    return list(dict.fromkeys(x.path.split(".")[0] for x in machine.internal))


def own_starts(machine: Machine, start: Mapping[str, Any], where: str) -> dict[str, float]:
    """Return the values of all internal states by name; 0 where the start has none. Raises ``InputError``."""
    known = {tuple(x.state.name.split(".")): x for x in machine.internal}
    values = {x.state.name: 0.0 for x in known.values()}
    for name in owners(machine):
        if name in start:
            for x, given, at in _stated(known, (name,), start[name], where):
                values[x.state.name] = _value(machine, x, given, at)
    return values


def _stated(
    known: Mapping[tuple[str, ...], Internal], keys: tuple[str, ...], given: Any, where: str
) -> Iterator[tuple[Internal, Any, str]]:
    """Yield each entry in a table of a start and in its inner tables: the state, the value, and its location."""
    at = ".".join((where, *keys))
    if keys in known:
        yield known[keys], given, at
        return
    inner = list(dict.fromkeys(k[len(keys)] for k in known if k[: len(keys)] == keys))
    if not isinstance(given, Mapping):
        raise InputError(at, given, f"must be a table such as {{ {inner[0]} = {_example(known, keys, inner[0])} }}")
    refuse_unknown(given, inner, at)
    for key, value in given.items():
        yield from _stated(known, (*keys, key), value, where)


def _example(known: Mapping[tuple[str, ...], Internal], keys: tuple[str, ...], key: str) -> str:
    state = known.get((*keys, key))
    return "{ ... }" if state is None else f'"0 {state.own.unit}"'


def _value(machine: Machine, x: Internal, given: Any, where: str) -> float:
    """Return a value in SI, checked against the size that the state can have."""
    value, (size,) = read_quantity(Unit(x.own.unit, x.own.what), given, where), machine.evaluate(x.size)
    if abs(value) > size * (1 + _ROUNDING):
        limits = f"between -{size:g} and {size:g} {x.own.unit}"
        raise InputError(where, given, f"must be {article(x.own.what)} {limits}: it cannot become larger")
    return value


_MOST_LISTED = 6  # phases in a sentence
_NOT_ALLOWED = "not allowed: the drive prescribes this body's motion (its angle is the drive's key `angle`)"


def initial_state(machine: Machine, start: Mapping[str, Any], where: str = "study.start") -> np.ndarray:
    """Return the initial state (n,) of ``machine.system``.

    Angles are relative to the body turned about, speeds absolute. Bodies not named start at rest at the angle that the machine
    gives them, else at 0; those of a track of which none is named or has an angle evenly spaced; those about a body whose
    speed is prescribed start with that speed. The carrier
    starts at its static position, from which ``carrier = {x, y, vx, vy}`` is measured. ``psi`` and ``delta`` set two bodies
    about one rotor: angles psi +- delta/2. Internal states of parts that are not named start at 0. Raises ``InputError``.
    """
    values = _carrier(machine, start.get("carrier", {}), f"{where}.carrier")
    guided = {"displacement": Unit("m", "displacement"), "velocity": Unit("m/s", "velocity")}
    sliding, both = {x.name: x for x in machine.sliders}, dict[str, dict[str, float]]()
    given, angle, speed = _given(machine, start, where), _angle(machine), Unit(machine.units.speed, "speed")
    for body in machine.outward:
        at, c, table = f"{where}.{body.name}", body.coordinate, given.get(body.name, {})
        if c.prescribed is not None and table != {}:
            raise InputError(at, table, _NOT_ALLOWED)
        stated = _quantities(table, {"angle": angle, "speed": speed} | (guided if body.name in sliding else {}), at)
        both[body.name] = stated
        if body.release is not None and "speed" in stated:
            raise InputError(f"{at}.speed", stated["speed"], "not allowed: this body is locked until its release")
        head = machine.body(body.about).coordinate if body.about else None
        origin = machine.start_angles.get(body.name, values[head.position.name] if head else 0.0)
        led = any(machine.body(n).coordinate.prescribed is not None for n in machine.tree.path(body.name)[1:])
        leader = head or machine.turning
        own = values[leader.velocity.name] if leader and (led or body.release is not None) else 0.0
        values[c.position.name] = origin + stated.get("angle", 0.0)
        values[c.velocity.name] = stated.get("speed", own) if c.prescribed is None else _prescribed(machine, c)
    for x in sliding.values():
        stated = both[x.name] if x.name in both else _quantities(start.get(x.name, {}), guided, f"{where}.{x.name}")
        values[x.coordinate.position.name] = stated.get("displacement", 0.0)
        values[x.coordinate.velocity.name] = stated.get("velocity", 0.0)
    values |= own_starts(machine, start, where)
    return np.array([values[name] for name in machine.state_names])


def placed(machine: Machine, state: np.ndarray) -> Machine:
    """Return the machine as in an initial state (n,): the bodies of its tracks in order, those released there unlocked.

    A speed of release that is reached at t = 0 would never be crossed. Raises ``InputError`` where bodies of a track overlap.
    """
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed is None]
    machine = arranged(machine, angles_in(machine, state), float(np.abs(state[free]).max(initial=0.0)))
    speeds = speeds_in(machine, state)
    locked = [(b, b.release.speed) for b in machine.bodies if b.release is not None and b.release.speed is not None]
    released = {b.locked.name: 0.0 for b, limit in locked if abs(speeds[leader_of(machine, b).name]) >= limit}
    return machine.with_unchecked(released)


def angles_in(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The angles of the bodies in a state (n,), by name."""
    return {b.name: float(state[machine.row(b.coordinate.position)]) for b in machine.bodies}


def speeds_in(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The speeds of the bodies in an initial state (n,), by name, prescribed ones included."""
    pairs = [(b.name, b.coordinate) for b in machine.bodies]
    return {n: float(state[machine.row(c.velocity)]) if c.prescribed is None else _prescribed(machine, c) for n, c in pairs}


def listed(phases: Mapping[str, float]) -> str:
    """Format phases of bodies, given in rad, in degrees for a sentence; of many bodies the first ones."""
    said = [f"{name} {(np.degrees(phase) + 180) % 360 - 180:.4g}°" for name, phase in phases.items()]
    more = f" and {len(said) - _MOST_LISTED} more" if len(said) > _MOST_LISTED else ""
    return ", ".join(said[:_MOST_LISTED]) + more


def _prescribed(machine: Machine, coordinate: Coordinate) -> float:
    """The prescribed velocity of a coordinate at t = 0."""
    return float(machine.prescribed_speed(coordinate, 0.0)[0])


def _angle(machine: Machine) -> Unit:
    return Unit("rad" if machine.units.time else "", "angle")


def _quantities(given: Any, units: Mapping[str, Unit], where: str) -> dict[str, float]:
    """Read the quantities of a table by key; a bare value is the first of them."""
    table = given if isinstance(given, Mapping) else {next(iter(units)): given}
    refuse_unknown(table, units, where)
    return {key: read_quantity(units[key], value, f"{where}.{key}") for key, value in table.items()}


def _given(machine: Machine, start: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return the entry of each body: by its name, as one of a pair by psi and delta, or as one of a track."""
    names = [b.name for b in machine.bodies]
    pair = [b.name for b in machine.bodies if b.about == machine.rotor.name]
    guided = [x.name for x in machine.sliders]
    refuse_unknown(start, [*names, *guided, "carrier", *owners(machine), *(("psi", "delta") if len(pair) == 2 else ())], where)
    given: dict[str, Any] = {n: start[n] for n in names if n in start}
    if "psi" in start or "delta" in start:
        psi, delta = (read_quantity(_angle(machine), start.get(k, 0.0), f"{where}.{k}") for k in ("psi", "delta"))
        for name in (n for n in pair if n in given):
            raise InputError(f"{where}.{name}", None, "give either psi and delta, or the angles of the bodies")
        given |= {name: psi + sign * delta / 2 for name, sign in zip(pair, (1, -1), strict=True)}
    for track in machine.tracks:
        if not any(b.name in given for b in track.bodies):
            given |= starts(track.bodies)
    for body in (p for p in machine.parts if isinstance(p, Tracked) and p.start is not None):
        stated = given.get(body.name, {})
        given[body.name] = {"angle": body.start, **stated} if isinstance(stated, Mapping) else stated
    return given


def _carrier(machine: Machine, given: Any, where: str) -> dict[str, float]:
    """Return the carrier's positions and velocities by name, prescribed ones included."""
    if not isinstance(given, Mapping):
        raise InputError(where, given, 'must be a table such as { x = "1 mm" }')
    length, units = machine.units.length, dict[str, Unit]()
    for d in machine.free_labels:
        units[d] = Unit("rad" if d == "r" else length, "displacement")
        units[f"v{d}"] = Unit(("rad/s" if d == "r" else "m/s") if length else "", "velocity")
    stated, values = _quantities(given, units, where), dict[str, float]()
    for c, rest, d in zip(machine.carrier, machine.rest, machine.labels, strict=True):
        free = c.prescribed is None
        values[c.position.name] = float(rest) + stated.get(d, 0.0) if free else machine.start_positions.get(d, 0.0)
        values[c.velocity.name] = stated.get(f"v{d}", 0.0) if free else _prescribed(machine, c)
    return values
