"""Start states: from the words of a study file to the state vector of a System."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine, Turning
from wucht.quantities import Unit


def start_state(machine: Machine, start: Mapping[str, Any], where: str = "study.start") -> np.ndarray:
    """The initial state (n,) of ``machine.system``.

    Angles are relative to the body turned about, speeds absolute. Bodies not named start at rest at angle 0; those about a body
    whose speed is prescribed start with that speed. The carrier starts at its static position, from which ``carrier = {x, y,
    vx, vy}`` is measured. ``psi`` and ``delta`` set two bodies about one rotor: angles psi +- delta/2. Raises ``InputError``.
    """
    units = machine.units
    angle_unit, speed_unit = Unit("rad" if units.time else "", "angle", ""), Unit(units.speed, "speed", "")
    names = [b.name for b in machine.bodies]
    pair = [b for b in machine.bodies if b.about == machine.rotor.name]
    known = [*names, "carrier", *(("psi", "delta") if len(pair) == 2 else ())]
    refuse_unknown(start, known, where)
    given: dict[str, Any] = {n: start[n] for n in names if n in start}
    if "psi" in start or "delta" in start:
        psi, delta = (_read(angle_unit, start.get(k, 0.0), f"{where}.{k}") for k in ("psi", "delta"))
        for body, sign in zip(pair, (1, -1), strict=True):
            if body.name in given:
                raise InputError(f"{where}.{body.name}", None, "allowed are either psi and delta, or the bodies' own angles")
            given[body.name] = psi + sign * delta / 2
    angles: dict[str, float] = {}
    speeds: dict[str, float] = {}
    for body in _from_the_axis_out(machine):
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
        angles[body.name] = origin + _read(angle_unit, described.get("angle", 0.0), f"{at}.angle")
        if prescribed is not None:
            speeds[body.name] = float(prescribed.xreplace(machine.numbers))
        elif "speed" in described:
            speeds[body.name] = _read(speed_unit, described["speed"], f"{at}.speed")
        else:
            led = body.about is not None and _prescribed_root(machine, body.name)
            speeds[body.name] = speeds[body.about] if led and body.about else 0.0
    values = {b.coordinate.position.name: angles[b.name] for b in machine.bodies}
    values |= {b.coordinate.velocity.name: speeds[b.name] for b in machine.bodies}
    values |= _carrier(machine, start.get("carrier", {}), f"{where}.carrier")
    return np.array([values[name] for name in machine.system.state_names])


def static_position(machine: Machine) -> np.ndarray:
    """Where the carrier rests under its load (m,): K x = load."""
    c, numbers = machine.linear_carrier, machine.numbers
    stiffness = np.array(c.stiffness.xreplace(numbers).tolist(), float)
    load = np.array(c.load.xreplace(numbers).tolist(), float).ravel()
    found: np.ndarray = np.linalg.lstsq(stiffness, load, rcond=None)[0]
    return found


def _carrier(machine: Machine, given: Any, where: str) -> dict[str, float]:
    if not isinstance(given, Mapping):
        raise InputError(where, given, 'allowed is a table such as { x = "1 mm" }')
    directions = [c.position.name[-1] for c in machine.carrier]
    refuse_unknown(given, [*directions, *(f"v{d}" for d in directions)], where)
    length = Unit(machine.units.length, "displacement", "")
    speed = Unit("m/s" if machine.units.length else "", "velocity", "")
    found = {}
    for coordinate, rest, d in zip(machine.carrier, static_position(machine), directions, strict=True):
        found[coordinate.position.name] = float(rest) + _read(length, given.get(d, 0.0), f"{where}.{d}")
        found[coordinate.velocity.name] = _read(speed, given.get(f"v{d}", 0.0), f"{where}.v{d}")
    return found


def _read(unit: Unit, given: Any, where: str) -> float:
    try:
        return unit.parse(given)
    except ValueError as error:
        raise InputError(where, given, str(error)) from None


def _from_the_axis_out(machine: Machine) -> list[Turning]:
    rest, done = list(machine.bodies), list[Turning]()
    while rest:
        ready = [b for b in rest if b.about is None or b.about in {d.name for d in done}]
        done += ready
        rest = [b for b in rest if b not in ready]
    return done


def _prescribed_root(machine: Machine, name: str) -> bool:
    by_name = {b.name: b for b in machine.bodies}
    body = by_name[name]
    while body.about is not None:
        body = by_name[body.about]
        if body.coordinate.prescribed is not None:
            return True
    return False
