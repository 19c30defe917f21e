"""A machine for another program that integrates it: a description as plain data, and its equations as JavaScript."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp

from wucht.dynamics.live_drawing import live_drawing, rest_position
from wucht.dynamics.torque_hills import hills_script, segment_table
from wucht.dynamics.unbalance_left import unbalances_left
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.structure import torques_on
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.flow.javascript import javascript_code, missing_functions
from wucht.numerics.flow.program import lower
from wucht.numerics.flow.segments import Segmentation, Segmentations, indices_in
from wucht.system import Output, System

_POWER = ("motor_torque", "drive_torque", "motor_power")


def export_obstacles(machine: Machine) -> tuple[str, ...]:
    """Return a sentence for each reason why a machine cannot be exported; none where it can.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    tuple of str
    """
    with_release = ", ".join(b.name for b in machine.bodies if b.release is not None)
    release = f"bodies of a live machine are free from the start, and these have a release: {with_release}"
    obstacles = [release] if with_release else []
    obstacles += [f"JavaScript has no function {name!r}" for name in missing_functions(_expressions(machine))]
    return tuple(obstacles)


def machine_script(machine: Machine, state: np.ndarray) -> str:
    """Return a module of JavaScript that exports ``machine``: its description, and its equations as functions.

    Parameters
    ----------
    machine : Machine
        In its initial state: with the contacts between those bodies that are neighbours there.
    state : ndarray, (n,)
        The initial state.

    Returns
    -------
    str
        For a file, or for an element ``script``: names and titles cannot end it. Beside the description it has the ``drawing``
        with its ``lengths``, and the torque ``hills``: see ``live_drawing`` and ``torque_hills``.

    Raises
    ------
    WuchtError
        For a machine that cannot be exported; see ``export_obstacles``.
    """
    description, (drawing, lengths) = machine_description(machine, state), live_drawing(machine)
    data = {**description, "drawing": drawing}
    texts = {key: json.dumps(value, allow_nan=False).replace("<", "\\u003c") for key, value in data.items()}
    code = _equations(machine) | {"lengths": lengths, "hills": hills_script(machine)}
    entries = [f"{name}: {text}," for name, text in (texts | code).items()]
    return "\n".join(["export const machine = {", *entries, "};", ""])


def machine_description(machine: Machine, state: np.ndarray) -> dict[str, Any]:
    """Return what is to be known of a machine beside its equations, as plain data: text, numbers, lists, tables.

    Parameters
    ----------
    machine : Machine
        In its initial state.
    state : ndarray, (n,)
        The initial state.

    Returns
    -------
    dict
        ``title``, ``time_unit``; ``states``: name, unit, long name, start; ``angles``: their indices; ``parameters``: path,
        unit, symbol, long name, value; ``outputs``: name, unit, long name; ``segmentations``, one for all piecewise functions
        of one argument: breakpoints, the origins and coefficients on each segment, the indices of the states (the time last)
        in the argument, and whether the argument is the time itself; ``contacts``: track, two neighbours, and the index of the
        segmentation whose argument is their gap. Quantities in SI.

    Raises
    ------
    WuchtError
        For a machine that cannot be exported.
    """
    if obstacles := export_obstacles(machine):
        raise WuchtError(f"this machine cannot be exported: {'; '.join(obstacles)}", code="not-exported")
    system, segmentations = machine.system, _segmentations(machine)
    descriptions = _state_descriptions(machine)
    parameters = [machine.parameters[name] for name in system.parameter_names]
    indices = indices_in([s.argument for s in segmentations.segmentations], segmentations.smooth_system(system))
    return {
        "title": machine.title,
        "time_unit": machine.units.time,
        "states": [
            {"name": name, "unit": descriptions[name][0], "long_name": descriptions[name][1], "start": start}
            for name, start in zip(system.state_names, state.tolist(), strict=True)
        ],
        "angles": [i for i, s in enumerate(system.states) if s in system.angles],
        "parameters": [
            {"path": p.path, "unit": p.unit, "symbol": p.symbol, "long_name": p.full_name, "value": p.value} for p in parameters
        ],
        "outputs": [{"name": o.name, "unit": o.unit, "long_name": o.long_name} for o in _outputs(machine)],
        "segmentations": [segment_table(s, i) for s, i in zip(segmentations.segmentations, indices, strict=True)],
        "contacts": _contacts(machine, segmentations.segmentations),
    }


def _contacts(machine: Machine, segmentations: Sequence[Segmentation]) -> list[dict[str, Any]]:
    """Return the contacts of tracks. The gap of a contact is the only argument that has its offset."""
    contacts = []
    for track in machine.tracks:
        for k, name in enumerate(track.order):
            offset = track.symbol(f"offset_{k + 1}")
            index = next(i for i, s in enumerate(segmentations) if offset in s.argument.free_symbols)
            pair = [name, track.order[(k + 1) % len(track.order)]]
            contacts.append({"track": track.name, "bodies": pair, "segmentation": index})
    return contacts


def _state_descriptions(machine: Machine) -> dict[str, tuple[str, str]]:
    """Return unit and long name of each state, by name."""
    units, descriptions = machine.units, dict[str, tuple[str, str]]()

    def describe(c: Coordinate, angular: bool, subject: str) -> None:
        unit, speed_unit = ("rad", units.speed) if angular else (units.length, "m/s" if units.length else "")
        descriptions[c.position.name] = (
            "" if machine.dimensionless else unit,
            f"{'angle' if angular else 'displacement'} of {subject}",
        )
        descriptions[c.velocity.name] = (speed_unit, f"{'speed' if angular else 'velocity'} of {subject}")

    for label, c in zip(machine.labels, machine.carrier, strict=True):
        describe(c, label == "r", f"the carrier in {label}")
    for body in machine.bodies:
        describe(body.coordinate, True, body.name)
    for slider in machine.sliders:
        describe(slider.coordinate, False, slider.words)
    for x in machine.internal:
        descriptions[x.state.name] = (x.description.unit, f"{x.description.what} of {x.path}")
    return descriptions


def _outputs(machine: Machine) -> list[Output]:
    """Return the quantities of a page: speeds, the orbit, displacement, residual unbalance, torque and power of the motors."""
    u, system = machine.units, machine.system
    speeds = [
        Output(f"speed[{b.name}]", b.coordinate.velocity if p is None else p, u.speed, f"speed of {b.name}")
        for b in machine.bodies
        for p in (b.coordinate.prescribed_velocity,)
    ]
    rest = rest_position(machine)
    distances = [position - position.xreplace(rest) for position, _ in machine.orbit.values()]
    orbit = [
        Output(f"orbit.{n}", position, machine.orbit_unit, f"{n} of the axis") for n, (position, _) in machine.orbit.items()
    ]
    amplitude = Output(
        "amplitude",
        sp.sqrt(sp.Add(*(d**2 for d in distances))),
        machine.orbit_unit,
        "displacement of the axis from its position at rest",
    )
    power = (o for o in system.outputs if o.name in _POWER)
    return [*speeds, *orbit, amplitude, *unbalances_left(machine), *power, *_torques_of_rotors(machine)]


def _torques_of_rotors(machine: Machine) -> list[Output]:
    """Return the torque of the drives on each of several rotors, whose sum is ``drive_torque``."""
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None] if len(machine.rotors) > 1 else []
    outputs = []
    for rotor in free:
        velocities = [b.coordinate.velocity for b in machine.group(rotor)]
        torque = sp.Add(*(torques_on(machine.energies, v, arriving=True)[0] for v in velocities))
        outputs.append(
            Output(f"drive_torque[{rotor.name}]", torque, machine.units.torque, f"torque of the drive on {rotor.name}")
        )
    return outputs


def _expressions(machine: Machine) -> list[sp.Expr]:
    system = machine.system
    expressions = [*system.derivatives, *(e for _, e in system.definitions), *(o.expression for o in _outputs(machine))]
    return [sp.sympify(e) for e in expressions]


def _segmentations(machine: Machine) -> Segmentations:
    return Segmentations.of(_expressions(machine))


def _equations(machine: Machine) -> dict[str, str]:
    """Return the code of the rates of the states, of the arguments of piecewise functions, and of the outputs.

    Its parameters are those of the machine, then origins and coefficients of the segments in use.
    """
    segmentations = _segmentations(machine)
    smooth = segmentations.smooth_system(machine.system)
    symbols = (s for x in segmentations.segmentations for s in x.polynomial_symbols)
    system = System(
        smooth.states, smooth.derivatives, (*machine.system.parameters, *symbols), smooth.definitions, angles=smooth.angles
    )
    groups = {
        "rates": system.derivatives,
        "places": tuple(x.argument for x in segmentations.segmentations),
        "shown": tuple(segmentations.smooth(sp.sympify(o.expression)) for o in _outputs(machine)),
    }
    return {name: javascript_code(lower(system, expressions)) for name, expressions in groups.items()}
