"""The start of a machine for which none is given: under gravity it hangs at rest."""

from __future__ import annotations

import cmath
import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from wucht.analysis.starting import gravity_of, is_locked, static_moment
from wucht.machines.machine import Machine
from wucht.machines.parts.track import TrackBody
from wucht.machines.tracks import side_by_side_angles
from wucht.machines.tree import RotatingBody
from wucht.numerics.angles import wrap_to_pi

HANGING = "at rest, hanging"
_APART = 1e-3  # rad: between equal bodies that hang: at one place they would move as one for ever
_SAME = 1e-9  # relative: parameters of equal bodies
_LOW = 1e-6  # rad: a rotor nearer to its lowest place hangs


def with_default_start(machine: Machine, start: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a start as it is if it names anything; else that of the machine at rest, whose bodies hang."""
    return start or hanging_start(machine)


def is_hanging_start(machine: Machine, start: Mapping[str, Any]) -> bool:
    """True if no start is given and bodies of the machine hang."""
    return not start and bool(hanging_start(machine))


def hanging_start(machine: Machine) -> dict[str, float]:
    """Return the start of a machine at rest under gravity, of the bodies that hang; empty without gravity.

    Rotors and the bodies about them have their centre of mass below their axis; those of a track lie side by side about the
    lowest point, in the order of the file, their common centre of mass below the axis; equal bodies that can pass each other
    are a thousandth of a radian apart. Bodies stay as they are that a drive or a lock holds, that turn about a body with a
    prescribed speed, that are balanced, and whose place the machine states.

    Returns
    -------
    dict of str to float
        Angles in rad, relative to the body turned about, as ``initial_state`` takes them.
    """
    gravity = gravity_of(machine)
    if not gravity:
        return {}
    start = _lowest_places(machine, gravity)
    for track in machine.tracks:
        if all(b.name in start for b in track.bodies):
            start |= {n: start[n] + offset for n, offset in _side_by_side(machine, track.bodies).items()}
    return start | {n: start[n] + offset for n, offset in _equal_bodies_apart(machine, start).items()}


def hanging_words(machine: Machine) -> str:
    """Return in words the start of a machine whose bodies hang."""
    apart = _equal_bodies_apart(machine, hanging_start(machine))
    return f"{HANGING}, equal bodies {_APART:g} rad apart" if apart else HANGING


def _lowest_places(machine: Machine, gravity: float) -> dict[str, float]:
    """The angles of the bodies that hang, each with its centre of mass below its axis."""
    down, given_angles, turning = -math.copysign(math.pi / 2, gravity), _given_angles(machine), _turning_rotors(machine)
    absolute, start = dict[str, float](), dict[str, float]()
    for body in machine.outward:
        head = 0.0 if body.about is None else absolute[body.about]
        moment = static_moment(machine, body)
        is_held = body.coordinate.prescribed_velocity is not None or is_locked(machine, body) or body.name in given_angles
        if is_held or machine.rotor_of(body).name in turning or not moment:
            absolute[body.name] = head + machine.start_angles.get(body.name, 0.0) + given_angles.get(body.name, 0.0)
            continue
        absolute[body.name] = down - cmath.phase(moment)
        start[body.name] = absolute[body.name] - head
    return start


def _equal_bodies_apart(machine: Machine, names: Collection[str]) -> dict[str, float]:
    """The angles by which equal bodies about a rotor that hang at one place are turned, to both sides of it."""
    hanging = [b for b in machine.bodies if b.name in names and b.about is not None]
    pairs = [(a.name, b.name) for a, b in combinations(hanging, 2) if _are_equal(machine, a, b)]
    ahead, behind = Counter(b for _, b in pairs), Counter(a for a, _ in pairs)
    return {n: (ahead[n] - behind[n]) / 2 * _APART for n in dict.fromkeys(n for pair in pairs for n in pair)}


def _are_equal(machine: Machine, a: RotatingBody, b: RotatingBody) -> bool:
    """True if two bodies about the same one have equal parameters and can pass each other."""
    if (a.kind, a.about) != (b.kind, b.about) or any({a.name, b.name} <= {x.name for x in t.bodies} for t in machine.tracks):
        return False
    first, second = (
        {p.removeprefix(f"{n}."): x for p, x in machine.values.items() if p.startswith(f"{n}.")} for n in (a.name, b.name)
    )
    return first.keys() == second.keys() and all(math.isclose(x, second[key], rel_tol=_SAME) for key, x in first.items())


def is_resting_state(machine: Machine, state: np.ndarray) -> bool:
    """True if the free rotors neither turn nor are lifted in a state (n,)."""
    hanging = hanging_start(machine)
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None]
    lifts = [wrap_to_pi(state[machine.row(r.coordinate.position)] - hanging[r.name]) for r in free if r.name in hanging]
    speeds = [state[machine.row(r.coordinate.velocity)] for r in free]
    return not np.any(speeds) and bool((np.abs(lifts) < _LOW).all())


def _turning_rotors(machine: Machine) -> set[str]:
    """The rotors that a drive gives a speed at t = 0."""
    driven = [r for r in machine.rotors if r.coordinate.prescribed_velocity is not None]
    return {r.name for r in driven if machine.prescribed_speed(r.coordinate, 0.0)[0]}


def _given_angles(machine: Machine) -> dict[str, float]:
    """The angles that the machine gives its bodies, from the body turned about; all of a track of which one has an angle."""
    angles = {p.name: p.start for p in machine.parts if isinstance(p, TrackBody) and p.start is not None}
    tracks = [t for t in machine.tracks if any(b.name in angles for b in t.bodies)]
    return angles | {b.name: b.start or 0.0 for t in tracks for b in t.bodies}


def _side_by_side(machine: Machine, bodies: Sequence[TrackBody]) -> dict[str, float]:
    """The angles of bodies that touch on a track, from the direction of their common centre of mass."""
    angles = side_by_side_angles(bodies)
    common = sum(abs(static_moment(machine, machine.body(n))) * cmath.exp(1j * a) for n, a in angles.items())
    # A closed ring of equal bodies has no lowest place.
    middle = cmath.phase(common) % (2 * math.pi) if abs(common) > 0 else 0.0
    return {name: angle - middle for name, angle in angles.items()}
