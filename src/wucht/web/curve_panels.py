"""What a page draws over time: panels of curves, and the speeds that are marked in the first of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy as sp

from wucht.dynamics.drive_switches import switch_path
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, sense_of, shaft_torques
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.javascript import javascript_code
from wucht.numerics.flow.program import lower
from wucht.results.formatting import engineering_unit, units_in_print
from wucht.system import System

_TITLES = {"amplitude": "displacement of the axis", "unbalance_left": "residual unbalance", "motor_power": "motor power"}
_NAMES = {"amplitude": "amplitude", "motor_power": "power"}  # of the single curve: so a column of measured values may be named


def panels(machine: Machine, outputs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the panels: title, unit and its size, whether it is circular, and curves: name, and the outputs or states shown.

    A curve is an output, ``{"output": i}``, or the difference of two states, ``{"state": i, "head": j, "sense": s,
    "head_sense": t}``: s times state i less t times state j, as phases of rotors are in results.
    """
    names = [str(o["name"]) for o in outputs]
    unit, size = engineering_unit(1.0, machine.units.speed)
    speeds = [{"name": r.name, "output": names.index(f"speed[{r.name}]")} for r in machine.rotors]
    result = [_panel("speed", unit, size, speeds), *_phase_panels(machine)]
    for key, title in _TITLES.items():
        curves = [
            {"name": name.partition("[")[2].rstrip("]") or _NAMES[key], "output": i}
            for i, name in enumerate(names)
            if name.partition("[")[0] == key
        ]
        if curves:
            result.append(_panel(title, *_unit(machine, key, str(outputs[names.index(_first(names, key))]["unit"])), curves))
    order = ["speed", _TITLES["amplitude"]]
    return sorted(result, key=lambda p: order.index(p["title"]) if p["title"] in order else len(order))


def _first(names: Sequence[str], key: str) -> str:
    return next(name for name in names if name.partition("[")[0] == key)


def _unit(machine: Machine, key: str, unit: str) -> tuple[str, float]:
    if key == "unbalance_left":
        return "%", 0.01
    return engineering_unit(1e-3 if key == "amplitude" else 1.0, "" if machine.dimensionless else unit)


def _panel(title: str, unit: str, size: float, curves: list[dict[str, Any]], circular: bool = False) -> dict[str, Any]:
    return {"title": title, "unit": units_in_print(unit), "size": size, "circular": circular, "curves": curves}


def _phase_panels(machine: Machine) -> list[dict[str, Any]]:
    row = {b.name: machine.row(b.coordinate.position) for b in machine.bodies}
    unit, size = engineering_unit(1.0, "rad")
    bodies = [
        {"name": b.name, "state": row[b.name], "head": row[b.about], "sense": 1, "head_sense": 1}
        for b in machine.bodies
        if b.about
    ]
    main, *further = machine.rotors
    rotors = [
        {
            "name": r.name,
            "state": row[r.name],
            "head": row[main.name],
            "sense": sense_of(machine, r),
            "head_sense": sense_of(machine, main),
        }
        for r in further
    ]
    result = [_panel(_phases_title(machine), unit, size, bodies, circular=True)] if bodies else []
    return (
        [*result, _panel(f"phases of the rotors relative to {main.name}", unit, size, rotors, circular=True)]
        if rotors
        else result
    )


def _phases_title(machine: Machine) -> str:
    """Return the title of the phases of bodies, short enough for a line with the keys of six: each on what it turns about."""
    references = {b.about for b in machine.bodies if b.about}
    if len(references) > 1:
        return "phases on the rotors"
    return "phases on the rotor" if len(machine.rotors) == 1 else f"phases on {references.pop()}"


def levels(machine: Machine, names: Sequence[str]) -> dict[str, Any]:
    """Return what is known of the speeds that are marked, as plain data.

    names: of the parameters of the equations, in order. ``size``: of the carrier's matrices, 0 where it is not linear.
    ``rotors``: name, the speed without vibration at the file's values or None, and the indices of the parameters on which it
    depends. All at the end of schedules.
    """
    last = machine.at(machine.breakpoints[-1])
    rotors = [
        {
            "name": r.name, "speed": free_speed(last, r),
            "depends": sorted(names.index(s.name) for s in _symbols(machine, r) if s.name in names),
        }
        for r in machine.rotors
    ]  # fmt: skip
    return {"size": _matrix_size(machine), "rotors": rotors}


def matrices_code(machine: Machine, names: Sequence[str]) -> str:
    """Return code of the entries of the carrier's mass matrix, then of its stiffness matrix, at the end of schedules."""
    parameters, last = tuple(sp.Symbol(name, real=True) for name in names), machine.at(machine.breakpoints[-1])
    final = {s.symbol: sp.Float(last.values[s.parameter]) for s in machine.schedules}
    carrier = machine.linear_carrier if _matrix_size(machine) else None
    entries = [] if carrier is None else [e.xreplace(final) for e in (*carrier.mass, *carrier.stiffness)]
    return javascript_code(lower(System((), (), parameters), entries))


def _matrix_size(machine: Machine) -> int:
    try:
        return int(machine.linear_carrier.mass.rows)
    except WuchtError:
        return 0


def _symbols(machine: Machine, rotor: RotatingBody) -> set[sp.Symbol]:
    switches = {switch_path(d) for d in machine.drives}
    prescribed_speed = rotor.coordinate.prescribed_velocity
    of_speed = shaft_torques(machine, rotor) if prescribed_speed is None else (sp.sympify(prescribed_speed),)
    return {s for e in of_speed for s in e.free_symbols if s.name not in switches}
