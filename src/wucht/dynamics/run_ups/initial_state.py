"""Initial states: from a study file to the state vector of a System, and the machine in that state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.machines.changes import leader_of
from wucht.machines.machine import Machine
from wucht.machines.parts.track import TrackBody
from wucht.machines.tracks import arrange_contacts, starts
from wucht.mechanics.energies import InternalState
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import Unit, article, read_quantity, refuse_unknown

_ROUNDING = 1e-9  # of the size


def owners(machine: Machine) -> list[str]:
    """The keys of a start that hold internal states of parts: names of attachments, ``drive`` or ``drives``."""
    return list(dict.fromkeys(x.path.split(".")[0] for x in machine.internal))


def internal_starts(machine: Machine, start: Mapping[str, Any], location: str) -> dict[str, float]:
    """Return the values of all internal states by name; 0 where the start has none. Raises ``InputError``."""
    internal_states = {tuple(x.state.name.split(".")): x for x in machine.internal}
    values = {x.state.name: 0.0 for x in internal_states.values()}
    for name in owners(machine):
        if name in start:
            for x, entry, at in _state_entries(internal_states, (name,), start[name], location):
                values[x.state.name] = _value(machine, x, entry, at)
    return values


def _state_entries(
    internal_states: Mapping[tuple[str, ...], InternalState], keys: tuple[str, ...], entry: Any, location: str
) -> Iterator[tuple[InternalState, Any, str]]:
    """Yield each entry in a table of a start and in its inner tables: the state, the value, and its location."""
    at = ".".join((location, *keys))
    if keys in internal_states:
        yield internal_states[keys], entry, at
        return
    inner = list(dict.fromkeys(k[len(keys)] for k in internal_states if k[: len(keys)] == keys))
    if not isinstance(entry, Mapping):
        raise InputError(at, entry, f"must be a table such as {{ {inner[0]} = {_example(internal_states, keys, inner[0])} }}")
    refuse_unknown(entry, inner, at)
    for key, value in entry.items():
        yield from _state_entries(internal_states, (*keys, key), value, location)


def _example(internal_states: Mapping[tuple[str, ...], InternalState], keys: tuple[str, ...], key: str) -> str:
    state = internal_states.get((*keys, key))
    return "{ ... }" if state is None else f'"0 {state.description.unit}"'


def _value(machine: Machine, x: InternalState, entry: Any, location: str) -> float:
    """Return a value in SI, checked against the size that the state can have."""
    value, (size,) = read_quantity(Unit(x.description.unit, x.description.what), entry, location), machine.evaluate(x.size)
    if abs(value) > size * (1 + _ROUNDING):
        limits = f"between -{size:g} and {size:g} {x.description.unit}"
        raise InputError(location, entry, f"must be {article(x.description.what)} {limits}: it cannot become larger")
    return value


_MOST_LISTED = 6  # phases in a sentence
_NOT_ALLOWED = "not allowed: the drive prescribes this body's motion (its angle is the drive's key `angle`)"


def initial_state(machine: Machine, start: Mapping[str, Any], location: str = "study.start") -> np.ndarray:
    """Return the initial state of a machine's System in which some of its quantities are given.

    A study that starts from rest gives those of ``hanging_start`` where its file gives none. Bodies not named start at rest at
    the angle that the machine gives them, else at 0; several of a track on which none has an angle from the machine at their
    places in an evenly spaced ring; those about a body whose speed is prescribed start with that speed. Internal states of
    parts that are not named start at 0.

    Parameters
    ----------
    machine : Machine
    start : mapping
        By body an angle in rad, or ``{"angle": ..., "speed": ...}``: angles relative to the body turned about, speeds absolute.
        ``psi`` and ``delta`` set two bodies about one rotor: angles psi +- delta/2. ``carrier = {x, y, vx, vy}`` is measured
        from its static position, where it starts.
    location : str, optional
        The table of a file, for messages.

    Returns
    -------
    numpy.ndarray, (n,)
        In the order of ``machine.state_names``.

    Raises
    ------
    InputError
        Where the start does not fit the machine.
    """
    values = _carrier(machine, start.get("carrier", {}), f"{location}.carrier")
    slider_units = {"displacement": Unit("m", "displacement"), "velocity": Unit("m/s", "velocity")}
    sliding, quantities_by_body = {x.name: x for x in machine.sliders}, dict[str, dict[str, float]]()
    entries, angle, speed = _body_entries(machine, start, location), _angle(machine), Unit(machine.units.speed, "speed")
    for body in machine.outward:
        at, c, table = f"{location}.{body.name}", body.coordinate, entries.get(body.name, {})
        if c.prescribed_velocity is not None and table != {}:
            raise InputError(at, table, _NOT_ALLOWED)
        quantities = _quantities(table, {"angle": angle, "speed": speed} | (slider_units if body.name in sliding else {}), at)
        quantities_by_body[body.name] = quantities
        if body.release is not None and "speed" in quantities:
            raise InputError(f"{at}.speed", quantities["speed"], "not allowed: this body is locked until its release")
        head = machine.body(body.about).coordinate if body.about else None
        origin = machine.start_angles.get(body.name, values[head.position.name] if head else 0.0)
        is_driven = any(machine.body(n).coordinate.prescribed_velocity is not None for n in machine.tree.path(body.name)[1:])
        leader = head or machine.rotation_coordinate
        start_speed = values[leader.velocity.name] if leader and (is_driven or body.release is not None) else 0.0
        values[c.position.name] = origin + quantities.get("angle", 0.0)
        values[c.velocity.name] = (
            quantities.get("speed", start_speed) if c.prescribed_velocity is None else _prescribed_velocity(machine, c)
        )
    for x in sliding.values():
        quantities = (
            quantities_by_body[x.name]
            if x.name in quantities_by_body
            else _quantities(start.get(x.name, {}), slider_units, f"{location}.{x.name}")
        )
        values[x.coordinate.position.name] = quantities.get("displacement", 0.0)
        values[x.coordinate.velocity.name] = quantities.get("velocity", 0.0)
    values |= internal_starts(machine, start, location)
    return np.array([values[name] for name in machine.state_names])


def machine_in_state(machine: Machine, state: np.ndarray, location: str = "study.start") -> Machine:
    """Return the machine as in an initial state (n,): the bodies of its tracks in order, those released there unlocked.

    A speed of release that is reached at t = 0 would never be crossed. location: of the start, for messages. Raises
    ``InputError`` where bodies of a track overlap.
    """
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed_velocity is None]
    machine = arrange_contacts(machine, angles_in(machine, state), float(np.abs(state[free]).max(initial=0.0)), location)
    speeds = speeds_in(machine, state)
    locked_bodies = [(b, b.release.speed) for b in machine.bodies if b.release is not None and b.release.speed is not None]
    release_times = {b.lock_symbol.name: 0.0 for b, limit in locked_bodies if abs(speeds[leader_of(machine, b).name]) >= limit}
    return machine.with_unchecked_values(release_times)


def angles_in(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The angles of the bodies in a state (n,), by name."""
    return {b.name: float(state[machine.row(b.coordinate.position)]) for b in machine.bodies}


def speeds_in(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The speeds of the bodies in an initial state (n,), by name, prescribed ones included."""
    pairs = [(b.name, b.coordinate) for b in machine.bodies]
    return {
        n: float(state[machine.row(c.velocity)]) if c.prescribed_velocity is None else _prescribed_velocity(machine, c)
        for n, c in pairs
    }


def start_gives(start: Mapping[str, Any], body: str, key: str) -> bool:
    """True if a start states the ``angle`` or the ``speed`` of a body."""
    entry = start.get(body)
    return key in entry if isinstance(entry, Mapping) else entry is not None and key == "angle"


def format_phases(phases: Mapping[str, float]) -> str:
    """Format phases of bodies, given in rad, in degrees from 0 to 360 for a sentence; of many bodies the first ones."""
    texts = [f"{name} {float(f'{np.degrees(phase) % 360:.4g}') % 360:.4g}°" for name, phase in phases.items()]
    more = f" and {len(texts) - _MOST_LISTED} more" if len(texts) > _MOST_LISTED else ""
    return ", ".join(texts[:_MOST_LISTED]) + more


def _prescribed_velocity(machine: Machine, coordinate: Coordinate) -> float:
    """The prescribed velocity of a coordinate at t = 0."""
    return float(machine.prescribed_speed(coordinate, 0.0)[0])


def _angle(machine: Machine) -> Unit:
    return Unit("rad" if machine.units.time else "", "angle")


def _quantities(entry: Any, units: Mapping[str, Unit], location: str) -> dict[str, float]:
    """Read the quantities of a table by key; a bare value is the first of them."""
    table = entry if isinstance(entry, Mapping) else {next(iter(units)): entry}
    refuse_unknown(table, units, location)
    return {key: read_quantity(units[key], value, f"{location}.{key}") for key, value in table.items()}


def _body_entries(machine: Machine, start: Mapping[str, Any], location: str) -> dict[str, Any]:
    """Return the entry of each body: by its name, as one of a pair by psi and delta, or as one of a track."""
    names = [b.name for b in machine.bodies]
    pair = [b.name for b in machine.bodies if b.about == machine.rotor.name]
    slider_names = [x.name for x in machine.sliders]
    refuse_unknown(
        start, [*names, *slider_names, "carrier", *owners(machine), *(("psi", "delta") if len(pair) == 2 else ())], location
    )
    entries: dict[str, Any] = {n: start[n] for n in names if n in start}
    if "psi" in start or "delta" in start:
        psi, delta = (read_quantity(_angle(machine), start.get(k, 0.0), f"{location}.{k}") for k in ("psi", "delta"))
        for name in (n for n in pair if n in entries):
            raise InputError(f"{location}.{name}", None, "give either psi and delta, or the angles of the bodies")
        entries |= {name: psi + sign * delta / 2 for name, sign in zip(pair, (1, -1), strict=True)}
    angles = {p.name: p.start for p in machine.parts if isinstance(p, TrackBody) and p.start is not None}
    for track in machine.tracks:
        without_angle = [b for b in track.bodies if "angle" not in _entry_table(entries.get(b.name, {}))]
        if len(without_angle) > 1:  # at one place they would overlap
            angles = starts(track.bodies) | angles
    for name, angle in angles.items():
        entries[name] = {"angle": angle, **_entry_table(entries.get(name, {}))}
    return entries


def _entry_table(entry: Any) -> Mapping[str, Any]:
    return entry if isinstance(entry, Mapping) else {"angle": entry}


def _carrier(machine: Machine, entry: Any, location: str) -> dict[str, float]:
    """Return the carrier's positions and velocities by name, prescribed ones included."""
    if not isinstance(entry, Mapping):
        raise InputError(location, entry, 'must be a table such as { x = "1 mm" }')
    length, units = machine.units.length, dict[str, Unit]()
    for d in machine.free_labels:
        units[d] = Unit("rad" if d == "r" else length, "displacement")
        units[f"v{d}"] = Unit(("rad/s" if d == "r" else "m/s") if length else "", "velocity")
    quantities, values = _quantities(entry, units, location), dict[str, float]()
    for c, rest, d in zip(machine.carrier, machine.rest, machine.labels, strict=True):
        free = c.prescribed_velocity is None
        values[c.position.name] = float(rest) + quantities.get(d, 0.0) if free else machine.start_positions.get(d, 0.0)
        values[c.velocity.name] = quantities.get(f"v{d}", 0.0) if free else _prescribed_velocity(machine, c)
    return values
