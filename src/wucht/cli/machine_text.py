"""The study file of a machine from a few amounts: what was given as it was written, what follows from it with its formula."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from wucht.machines.purpose import Purpose

_BALLS, _BALL_RADIUS, _RING_RADIUS = 6, 0.02, 0.26  # of the ring in a drum, m
_SURPLUS = 1.3  # unbalance of the balls, touching each other, over that of the drum
_BALL_RATE = 0.5  # 1/s: damping of a ball over its moment of inertia about the axis
_PENDULUM_MASS, _PENDULUM_SHARE, _PENDULUM_RATE = 0.1, 2.5, 300.0  # over the rotor's mass and unbalance; 1/s as of a ball
_GYRATION = 1.4  # m^2: moment of inertia of a screen over its mass, of a box of 3.9 m by 1.3 m
_POSITIONS = (("0.9 m", "0.45 m"), ("0.45 m", "0.9 m"))  # of two exciters that throw at 45 degrees through the centre of mass
_FAN_LOAD = 0.8  # power that the air takes at the rated speed, over that of the motor
_COMMENT = 34  # letters before a comment
_ABOUT = {
    Purpose.SCREEN: "Vibratory screen with two exciters",
    Purpose.DRUM: "Drum with a ring of balls",
    Purpose.FAN: "Fan on springs",
    Purpose.RIG: "Exciter with a pendulum",
}


@dataclass(frozen=True)
class Amount:
    """An amount as it is written in a file, and its value in SI."""

    text: str
    value: float


def machine_text(
    purpose: Purpose, support: Sequence[Amount], rotor: Sequence[Amount], motor: Sequence[Amount], question: Mapping[str, str]
) -> str:
    """Return the study file of a machine.

    Parameters
    ----------
    purpose : Purpose
    support : sequence of Amount
        Mass without rotors, natural frequency on its springs, damping ratio.
    rotor : sequence of Amount
        Mass, unbalance, moment of inertia: of each exciter of a screen.
    motor : sequence of Amount
        Rated power, speed, voltage and frequency; breakdown and starting torque over the rated torque.
    question : mapping
        The keys of the table ``[study]``.
    """
    names = ("e1", "e2") if purpose is Purpose.SCREEN else ("rotor",)
    places = _POSITIONS if purpose is Purpose.SCREEN else (None,)
    bodies = [_rotor(name, rotor, place) for name, place in zip(names, places, strict=True)]
    parts = {Purpose.DRUM: [_balls(rotor)], Purpose.RIG: [_pendulum(rotor)], Purpose.FAN: [_air(motor)]}.get(purpose, [])
    drives = [_drive(name, motor, sense=-1 if name == "e2" else 1) for name in names]
    study = "[study]\n" + "".join(f"{key} = {value}\n" for key, value in question.items())
    head = (
        "# Run it: wucht run THIS-FILE; all that a designer asks: wucht answer THIS-FILE.\n"
        "# Lines marked `estimate` were not given: replace them by your own.\n"
        f'title = "{_ABOUT[purpose]}"\n\n[machine]\npurpose = "{purpose}"\n'
    )
    return "\n".join([head, _carrier(purpose, support), *bodies, *parts, *drives, study])


def _carrier(purpose: Purpose, support: Sequence[Amount]) -> str:
    mass, frequency, damping_ratio = support
    lines = [f"mass = {mass.text} # without the rotors"]
    if purpose is Purpose.SCREEN:
        inertia = f'"{_GYRATION * mass.value:.4g} kg m^2"'
        lines += [
            f"directions = {_quotation('xyr')} # x, y and a small rotation",
            f"inertia = {inertia} # about the centre of mass: estimate, {_GYRATION} m^2 times the mass",
            f"rotation_frequency = {frequency.text} # estimate: as in x and y",
            f"rotation_damping_ratio = {damping_ratio.text}",
        ]
    else:
        lines += [f"directions = {_quotation('xy')} # of the axis of rotation, y points up"]
    lines += [
        f"frequency = {frequency.text} # natural frequency in x and y, with the rotors; or stiffness",
        f"damping_ratio = {damping_ratio.text} # or damping",
        f"gravity = {_quotation('9.81 m/s^2')} # the axis is horizontal; 0 where it stands upright",
    ]
    return _table("[machine.carrier]", lines)


def _rotor(name: str, rotor: Sequence[Amount], place: tuple[str, str] | None) -> str:
    mass, unbalance, inertia = rotor
    lines = [
        'kind = "rotor"',
        f'name = "{name}"',
        f"mass = {mass.text}",
        f"unbalance = {unbalance.text} # m r, half the working moment 2 m r of a data sheet",
        f"inertia = {inertia.text} # about its axis of rotation",
    ]
    at = [] if place is None else [f'position = ["{place[0]}", "{place[1]}"] # from the centre of mass: estimate']
    return _table("[[machine.bodies]]", [*lines, *at])


def _balls(rotor: Sequence[Amount]) -> str:
    """Balls that together, touching each other, have more unbalance than the drum."""
    unbalance, radius = rotor[1].value, _RING_RADIUS - _BALL_RADIUS
    half_angle = math.asin(_BALL_RADIUS / radius)
    side_by_side = math.sin(_BALLS * half_angle) / math.sin(half_angle)  # balls at their places count as so many at one
    mass = _SURPLUS * unbalance / (radius * side_by_side)
    lines = [
        'kind = "roller" # balls in a ring',
        'name = "b"',
        'about = "rotor"',
        f"count = {_BALLS}",
        f'mass = "{mass:.3g} kg" # estimate: side by side they have {_SURPLUS} times the unbalance of the drum',
        f'track_radius = "{_RING_RADIUS} m" # estimate',
        f'radius = "{1e3 * _BALL_RADIUS:g} mm" # estimate',
        "shape_factor = 0.4 # a ball; 0.5: a cylinder",
        f'damping = "{_BALL_RATE * mass * radius**2:.2g} N m s" # estimate: of the oil in the ring',
        'track = "ring" # balls of one track cannot pass each other',
    ]
    return _table("[[machine.bodies]]", lines)


def _pendulum(rotor: Sequence[Amount]) -> str:
    mass = _PENDULUM_MASS * rotor[0].value
    length = _PENDULUM_SHARE * rotor[1].value / mass
    lines = [
        'kind = "pendulum" # on the axis of the rotor',
        'name = "p"',
        'about = "rotor"',
        f'mass = "{mass:.3g} kg" # estimate: {_PENDULUM_MASS} of the rotor',
        f'length = "{1e3 * length:.3g} mm" # estimate: its unbalance is {_PENDULUM_SHARE} times that of the rotor',
        f'damping = "{_PENDULUM_RATE * mass * length**2:.2g} N m s" # estimate',
    ]
    return _table("[[machine.bodies]]", lines)


def _air(motor: Sequence[Amount]) -> str:
    power, speed = motor[0].value, motor[1].value
    lines = [
        'on = "rotor"',
        'kind = "quadratic" # torque = coefficient speed^2',
        f'coefficient = "{_FAN_LOAD * power / speed**3:.3g} N m s^2" # estimate: {_FAN_LOAD} of the rated power at that speed',
    ]
    return _table("[[machine.loads]]", lines)


def _drive(name: str, motor: Sequence[Amount], sense: int) -> str:
    power, speed, voltage, frequency, breakdown, starting = (one.text for one in motor)
    lines = [
        f'on = "{name}"',
        'kind = "induction"',
        *(["sense = -1 # turns clockwise"] if sense < 0 else []),
    ]
    plate = [
        f"power = {power}",
        f"speed = {speed} # rated, below the synchronous one",
        f"voltage = {voltage} # between two lines",
        f"frequency = {frequency}",
        f"breakdown_torque_ratio = {breakdown}",
        f"starting_torque_ratio = {starting}",
    ]
    return _table("[[machine.drives]]", lines) + _table("[machine.drives.nameplate]", plate)


def _table(head: str, lines: Sequence[str]) -> str:
    """A table of a file, its comments below each other."""
    parts = [line.partition(" # ") for line in lines]
    rows = [f"{key.rstrip():{_COMMENT}}# {comment}" if mark else key for key, mark, comment in parts]
    return "\n".join([head, *rows]) + "\n"


def _quotation(word: str) -> str:
    return f'"{word}"'
