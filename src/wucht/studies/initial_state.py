"""Initial states: from the words of a study file to the state vector of a System, and the machine as it is in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wucht.analysis.static import static_position
from wucht.checking import read_quantity, refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.tracks import arranged, evenly
from wucht.machines.tree import SlidingBody
from wucht.quantities import Unit
from wucht.studies.release_events import released_at_start


def initial_state(machine: Machine, start: Mapping[str, Any], where: str = "study.start") -> np.ndarray:
    """The initial state (n,) of ``machine.system``.

    Angles are relative to the body turned about, speeds absolute. Bodies not named start at rest at angle 0, those of a track
    of which none is named evenly spaced; those about a body whose speed is prescribed start with that speed. The carrier
    starts at its static position, from which ``carrier = {x, y, vx, vy}`` is measured. ``psi`` and ``delta`` set two bodies
    about one rotor: angles psi +- delta/2. Raises ``InputError``.
    """
    units = machine.units
    angle_unit, speed_unit = Unit("rad" if units.time else "", "angle", ""), Unit(units.speed, "speed", "")
    given = _given(machine, start, where, angle_unit)
    angles: dict[str, float] = {}
    speeds: dict[str, float] = {}
    carrier = _carrier(machine, start.get("carrier", {}), f"{where}.carrier")
    for body in machine.outward:
        value = given.get(body.name, {})
        described = value if isinstance(value, Mapping) else {"angle": value}
        at = f"{where}.{body.name}"
        refuse_unknown(described, ("angle", "speed"), at)
        prescribed = body.coordinate.prescribed
        if prescribed is not None and described:
            raise InputError(
                at, value, "not allowed: the drive prescribes this body's motion (its angle is the drive's key `angle`)"
            )
        origin = angles[body.about] if body.about else 0.0
        if body.name in machine.start_angles:
            origin = machine.start_angles[body.name]
        angles[body.name] = origin + read_quantity(angle_unit, described.get("angle", 0.0), f"{at}.angle")
        if body.release is not None and "speed" in described:
            raise InputError(f"{at}.speed", described["speed"], "not allowed: this body is locked until its release")
        if prescribed is not None:
            speeds[body.name] = float(machine.prescribed_speed(body.coordinate, 0.0)[0])
        elif body.release is not None:
            speeds[body.name] = speeds[body.about] if body.about else _turning(machine, carrier)
        elif "speed" in described:
            speeds[body.name] = read_quantity(speed_unit, described["speed"], f"{at}.speed")
        else:
            above = map(machine.body, machine.tree.path(body.name)[1:])
            led = any(b.coordinate.prescribed is not None for b in above)
            speeds[body.name] = speeds[body.about] if led and body.about else 0.0
    values = {b.coordinate.position.name: angles[b.name] for b in machine.bodies}
    values |= {b.coordinate.velocity.name: speeds[b.name] for b in machine.bodies}
    values |= carrier
    for x in machine.sliders:
        values |= _slider(machine, x, start.get(x.name, {}), f"{where}.{x.name}")
    return np.array([values[name] for name in machine.state_names])


def placed(machine: Machine, state: np.ndarray) -> Machine:
    """The machine as it is in a start state (n,): the bodies of its tracks in order, those unlocked that are released already.

    Raises ``InputError`` where bodies of a track overlap.
    """
    return released_at_start(arranged(machine, angles_in(machine, state), fastest_in(machine, state)), state)


def _given(machine: Machine, start: Mapping[str, Any], where: str, angle_unit: Unit) -> dict[str, Any]:
    """What is said of each body: named, as one of a pair by psi and delta, or as one of a track."""
    names = [b.name for b in machine.bodies]
    pair = [b for b in machine.bodies if b.about == machine.rotor.name]
    guided = [x.name for x in machine.sliders]
    refuse_unknown(start, [*names, *guided, "carrier", *(("psi", "delta") if len(pair) == 2 else ())], where)
    given: dict[str, Any] = {n: start[n] for n in names if n in start}
    if "psi" in start or "delta" in start:
        psi, delta = (read_quantity(angle_unit, start.get(k, 0.0), f"{where}.{k}") for k in ("psi", "delta"))
        for body, sign in zip(pair, (1, -1), strict=True):
            if body.name in given:
                raise InputError(f"{where}.{body.name}", None, "allowed are either psi and delta, or the bodies' own angles")
            given[body.name] = psi + sign * delta / 2
    for track in machine.tracks:
        if not any(b.name in given for b in track.bodies):
            given |= evenly(track.bodies)
    return given


def angles_in(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The angles of the bodies in a state (n,), by name."""
    return {b.name: float(state[machine.row(b.coordinate.position)]) for b in machine.bodies}


def fastest_in(machine: Machine, state: np.ndarray) -> float:
    """The largest speed of a body in a state (n,), in magnitude."""
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed is None]
    return float(np.abs(state[free]).max(initial=0.0))


def _carrier(machine: Machine, given: Any, where: str) -> dict[str, float]:
    if not isinstance(given, Mapping):
        raise InputError(where, given, 'allowed is a table such as { x = "1 mm" }')
    free = machine.free_labels
    refuse_unknown(given, [*free, *(f"v{d}" for d in free)], where)
    found = {}
    for coordinate, rest, d in zip(machine.carrier, static_position(machine), machine.labels, strict=True):
        position, velocity = coordinate.position.name, coordinate.velocity.name
        if coordinate.prescribed is not None:
            found[position] = machine.start_positions.get(d, 0.0)
            continue
        length = Unit("rad" if d == "r" else machine.units.length, "displacement", "")
        speed = Unit(("rad/s" if d == "r" else "m/s") if machine.units.length else "", "velocity", "")
        found[position] = float(rest) + read_quantity(length, given.get(d, 0.0), f"{where}.{d}")
        found[velocity] = read_quantity(speed, given.get(f"v{d}", 0.0), f"{where}.v{d}")
    return found


def _turning(machine: Machine, carrier: Mapping[str, float]) -> float:
    """The angular velocity of the carrier, with which a locked rotor starts."""
    if machine.turning is None:
        return 0.0
    if machine.turning.prescribed is not None:
        return float(machine.prescribed_speed(machine.turning, 0.0)[0])
    return carrier[machine.turning.velocity.name]


def _slider(machine: Machine, slider: SlidingBody, given: Any, where: str) -> dict[str, float]:
    """The displacement and velocity of a slider; a bare value is the displacement."""
    described = given if isinstance(given, Mapping) else {"displacement": given}
    refuse_unknown(described, ("displacement", "velocity"), where)
    length, speed = Unit("m", "displacement", ""), Unit("m/s", "velocity", "")
    return {
        slider.coordinate.position.name: read_quantity(length, described.get("displacement", 0.0), f"{where}.displacement"),
        slider.coordinate.velocity.name: read_quantity(speed, described.get("velocity", 0.0), f"{where}.velocity"),
    }
