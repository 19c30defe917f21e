"""The torques on the shafts of a machine over the speed, as JavaScript: 002 (3.51), figure 3.2b.

Drive and load are the expressions of the shaft, printed. The vibration torque is that of ``wucht.analysis.vibration``, whose
matrices and unbalances are printed; the page solves the equations of motion of the carrier, at most four, at each speed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp

from wucht.analysis.time_constants import highest_speed
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import is_driven, natural_frequencies, operating_speed, sense_of, shaft_torques
from wucht.machines.structure import SPEED
from wucht.numerics.flow.javascript import javascript_code, missing_functions
from wucht.numerics.flow.program import lower
from wucht.numerics.flow.segments import Segmentation, Segmentations, indices_in
from wucht.system import TIME, System

_RESONANCES = 3.0  # times the highest natural frequency: the range where the drive reaches no speed
_FALLBACK = 100.0  # rad/s, of a machine without natural frequencies


def torque_hills(machine: Machine) -> tuple[dict[str, Any], Mapping[str, str]]:
    """Return the torques of a machine over the speed, and their functions by name; where there are none, the data say why.

    The data: see ``src/wucht/web/drawing_data.ts``; the functions: as JavaScript.
    """
    if reason := unavailability_reason(machine):
        return {"available": False, "reason": reason}, {}
    torques = [torque for rotor in machine.rotors for torque in shaft_torques(machine, rotor)]
    carrier = machine.linear_carrier
    matrices = [x for matrix in (carrier.mass, carrier.damping, carrier.stiffness) for x in matrix]
    forces = [sp.sympify(x) for shape in carrier.excitation for x in shape]
    quantities = [*torques, *matrices, *(f(x) for f in (sp.re, sp.im) for x in forces)]
    natural = [f for f in natural_frequencies(machine).values() if np.isfinite(f) and f > 0]
    reach = highest_speed(machine)
    segmentations, code = _code(machine, [sp.sympify(x) for x in quantities])
    last = machine.at(machine.breakpoints[-1])
    driven = _driven_rotors(machine)
    data = {
        "available": True,
        "reason": "",
        "directions": len(machine.free_carrier),
        "output_count": len(quantities),
        "segmentations": segmentations,
        "reach": reach if np.isfinite(reach) else None,
        "largest_speed": _RESONANCES * max(natural, default=_FALLBACK),
        "units": {"speed": machine.units.speed, "torque": machine.units.torque},
        "bodies": [
            {
                "angle": machine.row(b.coordinate.position),
                "velocity": machine.row(b.coordinate.velocity) if b.coordinate.prescribed_velocity is None else -1,
                "rotor": [r.name for r in machine.rotors].index(machine.rotor_of(b).name),
                "is_rotor": b.about is None,
            }
            for b in machine.bodies
        ],
        "rotors": [{"name": r.name, "is_driven": r.name in driven, "sense": int(sense_of(last, r))} for r in machine.rotors],
    }
    return data, code


def hills_script(machine: Machine) -> str:
    """Return the torques of a machine over the speed with their functions, as an object of JavaScript."""
    data, code = torque_hills(machine)
    texts = {key: json.dumps(value, allow_nan=False).replace("<", "\\u003c") for key, value in data.items()}
    return "\n".join(["{", *(f"{name}: {text}," for name, text in (texts | dict(code)).items()), "}"])


def unavailability_reason(machine: Machine) -> str:
    """Return why a machine has no balance of torques over the speed; empty where it has one.

    The reasons are those of the study torque-balance.
    """
    if machine.nonlinear:
        return f"the vibration torque is known for a linear carrier only: {machine.nonlinear} is not linear"
    if all(r.coordinate.prescribed_velocity is not None for r in machine.rotors):
        return "the drive gives the rotor its speed, whatever torque that takes"
    if not _driven_rotors(machine):
        return "nothing drives a rotor"
    try:
        expressions = [x for shape in machine.linear_carrier.excitation for x in shape]
    except WuchtError as error:
        return str(error)
    torques = [torque for r in machine.rotors for torque in shaft_torques(machine, r)]
    missing = missing_functions([*torques, *(sp.sympify(f(x)) for x in expressions for f in (sp.re, sp.im))])
    return f"JavaScript has no function {missing[0]!r}" if missing else ""


def _driven_rotors(machine: Machine) -> set[str]:
    """Return the rotors that their drives turn, at the end of all schedules."""
    steady = machine.at(machine.breakpoints[-1])
    free = [r for r in steady.rotors if r.coordinate.prescribed_velocity is None]
    drives = {d.on for d in steady.drives}
    fastest = operating_speed(steady)
    return {
        r.name
        for r in free
        if (machine.dimensionless or drives & {b.name for b in steady.group(r)}) and is_driven(steady, r, fastest)
    }


def _code(machine: Machine, expressions: list[sp.Expr]) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the piecewise functions in expressions of the speed, the time and the parameters, and the code of all.

    The speed is the only state. Scheduled parameters are functions of the time.
    """
    schedules = {s.symbol: s.expression for s in machine.schedules}
    explicit = [e.xreplace(schedules) for e in expressions]
    segmentations = Segmentations.of(explicit)
    symbols = (s for x in segmentations.segmentations for s in x.polynomial_symbols)
    system = System((SPEED,), (sp.S.Zero,), (*machine.system.parameters, *symbols))
    arguments = [x.argument for x in segmentations.segmentations]
    groups = {"rates": system.derivatives, "places": arguments, "shown": [segmentations.smooth(e) for e in explicit]}
    tables = [segment_table(s, i) for s, i in zip(segmentations.segmentations, indices_in(arguments, system), strict=True)]
    return tables, {name: javascript_code(lower(system, group)) for name, group in groups.items()}


def segment_table(segmentation: Segmentation, indices: tuple[int, ...]) -> dict[str, Any]:
    """Return the piecewise functions of one argument as plain data. indices: of the states (the time last) in the argument."""
    return {
        "breakpoints": segmentation.breakpoints.tolist(),
        "scale": segmentation.scale,
        "rows": [segmentation.polynomial_values(k) for k in range(len(segmentation.breakpoints) + 1)],
        "indices": list(indices),
        "is_time": segmentation.argument == TIME,
    }
