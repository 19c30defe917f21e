"""The moving drawing of a machine as plain data: which state moves what, and lengths as expressions in its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from wucht.machine_shape import Arithmetic, AttachmentShape, Length, MachineShape, machine_shape
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body, Drive
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.javascript import javascript_code
from wucht.numerics.flow.program import lower
from wucht.system import System

NO_STATE = -1  # in place of the index of a velocity that is no state


@dataclass
class LengthTable:
    """Lengths of a drawing, each once; in the data stands the index."""

    expressions: dict[sp.Expr, int] = field(default_factory=dict)

    def index(self, length: Length) -> int:
        """Return the index of a length, which is added if it is new."""
        return self.expressions.setdefault(sp.sympify(length), len(self.expressions))


def live_drawing(machine: Machine) -> tuple[dict[str, Any], str]:
    """Return the moving drawing of a machine, and its lengths as JavaScript.

    The drawing: see ``src/wucht/web/drawing_data.ts``. The machine is in its initial state: parameters that schedules change
    have their values at the start.
    """
    table, rest, parts = LengthTable(), rest_position(machine), {part.path: part for part in machine.parts}
    start_values = {s.symbol: sp.Float(machine.values[s.parameter]) for s in machine.schedules}
    values = {path: sp.Symbol(path, real=True) for path in machine.values}
    values |= {symbol.name: value for symbol, value in start_values.items()}
    shape = _shape(machine, values)
    data = {
        "to_scale": shape.to_scale,
        "is_shaken": shape.is_shaken,
        "turning": _turning(machine),
        "box": [table.index(x) for x in shape.box],
        "carrier": [
            {
                "label": label,
                "position": machine.row(c.position),
                "velocity": _velocity_row(machine, c.velocity, c.prescribed_velocity),
                "rest": table.index(rest[c.position].xreplace(start_values)),
            }
            for label, c in zip(machine.labels, machine.carrier, strict=True)
        ],
        "mounts": [
            {"name": m.name, "x": table.index(m.x), "y": table.index(m.y), "dx": m.dx, "dy": m.dy}
            | {"has_damper": m.has_damper, "is_on_foundation": _is_on_foundation(machine, m.dx)}
            for m in shape.mounts
        ],
        "rotors": [
            {"name": r.name, "body": _row(machine, r.name), "sense": r.sense}
            | {key: table.index(getattr(r, key)) for key in ("x", "y", "radius")}
            for r in shape.rotors
        ],
        "bodies": _bodies(machine, shape, values, table, start_values),
        "sliders": _sliders(machine, shape, values, table),
        "attachments": [
            _attachment(a, values, table) | {"is_two_sided": getattr(parts[a.name], "sides", "one") == "both"}
            for a in shape.attachments
        ],
        "contacts": [
            {"bodies": [_row(machine, name), _row(machine, track.order[(k + 1) % len(track.order)])]}
            | {"offset": table.index(track.symbol(f"offset_{k + 1}"))}
            for track in machine.tracks
            for k, name in enumerate(track.order)
        ],
    }  # fmt: skip
    program = lower(System((), (), machine.system.parameters), list(table.expressions))
    return {**data, "length_count": len(table.expressions)}, javascript_code(program)


def rest_position(machine: Machine) -> dict[sp.Symbol, sp.Expr]:
    """Return the carrier's position at rest, in parameters: K x = load, which is zero where the motion is prescribed.

    Where K has no inverse, it is the position at the machine's values.
    """
    linear = machine.linear_carrier
    try:
        position = list(linear.stiffness.LUsolve(linear.load)) if any(linear.load) else [sp.S.Zero] * len(linear.load)
        free = iter(position)
        return {c.position: sp.S.Zero if c.prescribed_velocity is not None else next(free) for c in machine.carrier}
    except (sp.matrices.exceptions.NonInvertibleMatrixError, ZeroDivisionError):
        return {c.position: sp.Float(x) for c, x in zip(machine.carrier, machine.rest.tolist(), strict=True)}


def _shape(machine: Machine, values: Mapping[str, sp.Expr]) -> MachineShape:
    """Return the shape of a machine in expressions; choices are those of its values."""
    numbers = machine.numbers

    def number(length: Length) -> float:
        return float(sp.sympify(length).xreplace(numbers))

    arithmetic = Arithmetic(
        largest=lambda lengths: _extreme(sp.Max, max, lengths),
        smallest=lambda lengths: _extreme(sp.Min, min, lengths),
        root=sp.sqrt,
        number=number,
    )
    parts = [
        {"path": p.path, "kind": p.kind, "on": getattr(p, "about", None) or getattr(p, "on", None) or ""}
        | ({"sense": getattr(p, "sense", 1)} if isinstance(p, Drive) else {})
        | ({"directions": machine.labels} if p.path in ("carrier", "") else {})
        for p in machine.parts
    ]
    bodies = [(b.name, b.kind, b.about) for b in machine.bodies]
    return machine_shape(bodies, values, parts, dimensionless=machine.dimensionless, arithmetic=arithmetic)


def _extreme(function: Any, of_numbers: Any, lengths: Any) -> sp.Expr:
    """Return the largest or smallest of lengths. To compare the expressions with each other would take long."""
    terms = [sp.sympify(x) for x in lengths]
    numbers, expressions = [x for x in terms if x.is_number], list(dict.fromkeys(x for x in terms if not x.is_number))
    terms = [*expressions, *([of_numbers(numbers)] if numbers else [])]
    return terms[0] if len(terms) == 1 else function(*terms, evaluate=False)


def _turning(machine: Machine) -> str:
    """Return how the carrier turns: about the normal of the plane, about an axis in it, or not."""
    if "r" not in machine.labels:
        return "no"
    return "in plane" if machine.frame.tilt == 0 else "tilting"


def _velocity_row(machine: Machine, velocity: sp.Symbol, law: sp.Expr | None) -> int:
    return machine.row(velocity) if law is None else NO_STATE


def _is_on_foundation(machine: Machine, dx: float) -> bool:
    direction = next((d for p in machine.parts for d in p.supported_directions().values()), None)
    return direction is not None and direction == ("x" if dx else "y")


def _row(machine: Machine, name: str) -> int:
    return [b.name for b in machine.bodies].index(name)


def _attachment(shape: AttachmentShape, values: Mapping[str, sp.Expr], table: LengthTable) -> dict[str, Any]:
    keys = {key: values.get(f"{shape.name}.{key}") for key in ("angle", "gap", "rest")}
    lengths = {key: None if value is None else table.index(value) for key, value in keys.items()}
    return {
        "name": shape.name,
        "kind": shape.kind,
        "x": table.index(shape.x or 0.0),
        "y": table.index(shape.y or 0.0),
    } | lengths


def _bodies(
    machine: Machine,
    shape: MachineShape,
    values: Mapping[str, sp.Expr],
    table: LengthTable,
    start_values: Mapping[sp.Symbol, sp.Expr],
) -> list[dict[str, Any]]:
    """Return the bodies that turn, in the machine's order."""
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    shapes = {b.name: b for rotor in shape.rotors for b in rotor.bodies}
    guides = {s.about: s for s in machine.sliders if s.name == s.about}

    def description(body: RotatingBody) -> dict[str, Any]:
        form, part, guide = shapes.get(body.name), parts.get(body.name), guides.get(body.name)
        moment = sp.S.One if part is None else part.moment() if (couple := part.couple()) is None else couple
        pivot = [values.get(f"{body.name}.suspension.{d}", sp.S.Zero) for d in "xy"]
        return {
            "name": body.name,
            "kind": body.kind,
            "about": None if body.about is None else _row(machine, body.about),
            "rotor": next(k for k, r in enumerate(shape.rotors) if r.name == machine.rotor_of(body).name),
            "angle": machine.row(body.coordinate.position),
            "velocity": _velocity_row(machine, body.coordinate.velocity, body.coordinate.prescribed_velocity),
            "unbalance": table.index(sp.sympify(moment).xreplace(start_values)),
            "pivot": [table.index(x) for x in pivot],
            **{key: table.index(0.0 if form is None else getattr(form, key)) for key in ("arm", "size", "track")},
            "guide": None if guide is None else {
                "displacement": machine.row(guide.coordinate.position),
                **{key: table.index(values[f"{body.name}.{key}"]) for key in ("inner_stop", "outer_stop")},
            },
        }  # fmt: skip

    return [description(body) for body in machine.bodies]


def _sliders(machine: Machine, shape: MachineShape, values: Mapping[str, sp.Expr], table: LengthTable) -> list[dict[str, Any]]:
    """Return the masses in guides of bodies."""
    arms = {b.name: b.arm for rotor in shape.rotors for b in rotor.bodies}
    return [
        {"name": s.name, "about": _row(machine, s.about), "displacement": machine.row(s.coordinate.position)}
        | {"arm": table.index(arms[s.name]), "angle": table.index(values[f"{s.name}.angle"])}
        for s in machine.sliders
        if s.name != s.about
    ]
