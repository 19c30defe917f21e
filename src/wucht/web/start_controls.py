"""Controls of a page for the start: angles relative to the body turned about, displacements from rest, as files have them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.operation import operating_speed
from wucht.results.formatting import engineering_unit, units_in_print

_REACH = 10.0  # times the eccentricity: largest displacement at the start that a slider offers
_USUAL_LENGTH = 0.01  # m, where no rotor has an eccentricity


@dataclass(frozen=True)
class StartControl:
    """A start value, shown as (state - offset - the state of the head) / size in a unit.

    index: of the state; head: of the state to which it is relative, None where there is none; keys: where a file has it in
    ``study.start``; bottom, top: of the slider, in SI.
    """

    name: str
    index: int
    head: int | None
    offset: float
    keys: tuple[str, str]
    unit: str
    size: float
    bottom: float
    top: float


def start_groups(machine: Machine, state: np.ndarray) -> list[dict[str, Any]]:
    """Return the controls of the start of a machine by body, those of the carrier last; without internal states."""
    groups: list[dict[str, Any]] = []
    for body in machine.bodies:
        if body.coordinate.prescribed_velocity is None:
            groups.append({"title": body.name, "controls": [asdict(c) for c in _body_controls(machine, body.name)]})
    carrier = [asdict(c) for c in _carrier_controls(machine)]
    return [*groups, {"title": "carrier", "controls": carrier}] if carrier else groups


def _body_controls(machine: Machine, name: str) -> Iterator[StartControl]:
    body = machine.body(name)
    head = None if body.about is None else machine.row(machine.body(body.about).coordinate.position)
    origin = machine.start_angles.get(name, 0.0)
    unit, size = ("", 1.0) if machine.dimensionless else engineering_unit(1.0, "rad")
    angle = f"angle from {body.about}" if body.about else "angle"
    row = machine.row(body.coordinate.position)
    yield StartControl(angle, row, head, origin, (name, "angle"), unit, size, -math.pi, math.pi)
    unit, size = engineering_unit(1.0, machine.units.speed)
    top, row = operating_speed(machine), machine.row(body.coordinate.velocity)
    yield StartControl("speed", row, None, 0.0, (name, "speed"), unit, size, -top, top)


def _carrier_controls(machine: Machine) -> Iterator[StartControl]:
    arms = [p.value for path, p in machine.parameters.items() if path.endswith(".eccentricity")]
    length = _REACH * max(arms, default=0.0) or (_USUAL_LENGTH if machine.units.length else 1.0)
    for label, coordinate, rest in zip(machine.labels, machine.carrier, machine.rest.tolist(), strict=True):
        if coordinate.prescribed_velocity is not None:
            continue
        si, reach = ("rad", 0.1) if label == "r" else (machine.units.length, length)
        unit, size = engineering_unit(reach, "" if machine.dimensionless else si)
        row, keys = machine.row(coordinate.position), ("carrier", label)
        name = _rotation(machine) if label == "r" else f"displacement in {label}" if label in ("x", "y") else label
        yield StartControl(name, row, None, rest, keys, units_in_print(unit), size, -reach, reach)
        row, keys, fastest = machine.row(coordinate.velocity), ("carrier", f"v{label}"), reach * operating_speed(machine)
        unit, size = engineering_unit(1.0, "" if machine.dimensionless else "rad/s" if label == "r" else "m/s")
        name = "angular velocity" if label == "r" else f"velocity in {label}"
        yield StartControl(name, row, None, 0.0, keys, units_in_print(unit), size, -fastest, fastest)


def _rotation(machine: Machine) -> str:
    """Return the name of the carrier's rotation: in the plane of the drawing, or about an axis in it."""
    return "rotation angle" if machine.frame.tilt == 0 else "tilt"
