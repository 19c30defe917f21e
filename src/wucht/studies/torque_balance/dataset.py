"""Findings -> the Dataset of a torque balance: torques over the speed, the working points, and the summary."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.configurations.configuration import Configuration
from wucht.analysis.configurations.steady_branches import labels_of
from wucht.dynamics.run_ups.steady_phases import Piece
from wucht.machines.operation import free_speed, natural_frequencies, sense_of
from wucht.results.conventions import Variable, answered, assuming, variable
from wucht.studies.torque_balance.prepare import Plan
from wucht.studies.torque_balance.run import Findings

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a torque balance.

    Coordinates: speed (N), mode, point; of bodies in steady phases configuration, with its configuration_name. Variables:
    drive_torque, load_torque (speed); vibration_torque, surplus_torque, stable (speed, or configuration and speed: whether a
    working point there would be stable); overlapping (configuration); point_speed, point_torque, point_stable, with steady
    phases point_configuration, point_overlapping (point); free_speed, natural_frequency (mode).
    """
    import xarray as xr_

    points, base, machine = findings.points, plan.curves[0], plan.steady.machine
    units, natural, free = machine.units, natural_frequencies(machine), free_speed(machine, base.rotor)
    grid = plan.steady.grid(np.unique(np.concatenate([c.grid for c in plan.curves])))
    pieces = plan.steady.pieces(sense_of(machine, machine.rotor) * grid)
    drive, load, _ = base.torques(grid)[0]
    labels = [_label(plan, c) for c in findings.configurations]
    coordinates = {
        "speed": variable("speed", grid, "speed", units.speed),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
    }
    if plan.steady.branches:
        names = np.array([p.label for p in pieces], str)
        coordinates["configuration_name"] = variable("configuration", names, "steady phase configuration")
    data = {
        "drive_torque": variable("speed", drive, "torque of the drive", units.torque),
        "load_torque": variable("speed", load, "torque of loads and bearings", units.torque),
        **_of_curves(plan, pieces, grid),
        "point_speed": variable("point", [p.speed for p in points], "speed of a working point", units.speed),
        "point_torque": variable("point", [p.torque for p in points], "torque of the drive there", units.torque),
        "point_stable": variable("point", np.array([p.stable for p in points], np.int8), "stable"),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
    }
    if plan.steady.branches:
        overlapping = np.array([c.overlapping for c in findings.configurations], np.int8)
        data["point_configuration"] = variable("point", np.array(labels, str), "steady phase configuration there")
        data["point_overlapping"] = variable("point", overlapping, "bodies of a track are in each other's place")
    breakdown, runaway = base.breakdown, base.runaway
    sentence = _sentence(findings, labels, runaway)
    summary = {
        "sentence": sentence,
        "on": base.rotor.name,
        "range": list(base.range),
        "bodies": "steady" if plan.steady.branches else "held",
        "working_points": _points(findings, labels),
        "free_speed": free,
        "breakdown": None if breakdown is None else dict(zip(("slip", "speed", "torque"), breakdown, strict=True)),
        "runaway": runaway,
        "natural_frequencies": natural,
    }
    warnings = _warnings(plan, findings) + plan.steady.warnings
    return assuming(answered(xr_.Dataset(data, coords=coordinates), summary, sentence, warnings), plan.steady.assumed)


def _of_curves(plan: Plan, pieces: list[Piece], grid: np.ndarray) -> dict[str, Variable]:
    """The torques of the vibration and what is left, and whether a working point there would be stable."""
    unit = plan.steady.machine.units.torque
    vibration = np.array([c.torques(grid)[0][2] for c in plan.curves])
    surplus, slope = np.moveaxis(np.array([c.surplus(grid) for c in plan.curves]), 1, 0)
    stable, along = slope < 0, "configuration speed"
    if not plan.steady.branches:
        vibration, surplus, stable, along = vibration[0], surplus[0], stable[0], "speed"
    else:
        at, inside = [p.branch for p in pieces], np.array([p.inside for p in pieces])
        vibration, surplus = (np.where(inside, torque[at], np.nan) for torque in (vibration, surplus))
        stable = stable[at] & np.array([p.stable for p in pieces])
    variables = {
        "vibration_torque": variable(along, vibration, "torque of the vibration", unit),
        "surplus_torque": variable(along, surplus, "drive less load and vibration", unit),
        "stable": variable(along, stable.astype(np.int8), "stable, if it is a working point"),
    }
    if plan.steady.branches:
        overlapping = np.array([p.overlapping for p in pieces], np.int8)
        variables["overlapping"] = variable("configuration", overlapping, "bodies of a track are in each other's place")
    return variables


def _label(plan: Plan, c: Configuration) -> str:
    assert plan.steady.torques is not None
    return str(labels_of(plan.steady.torques, c.state.beside, c.state.phases[:, None])[0])


def _points(findings: Findings, labels: list[str]) -> list[dict[str, Any]]:
    """The working points; of bodies in steady phases with their configuration."""
    points = [asdict(p) for p in findings.points]
    for point, c, label in zip(points, findings.configurations, labels, strict=False):
        point |= {
            "configuration": label, "name": c.name, "phases": c.phases, "residual_share": c.share,
            "overlapping": c.overlapping, "indifferent": c.state.indifferent, "family_dimension": c.state.dimension,
        }  # fmt: skip
    return points


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    warnings, machine = list[str](), plan.steady.machine
    if any(p.tangential for p in findings.points):
        warnings.append("at a working point the curves only touch: the least change makes two of it or none")
    if len(machine.rotors) > 1:
        name = plan.curves[0].rotor.name
        warnings.append(f"all rotors are taken to turn as fast as {name!r}, in the phases of the start")
    return warnings


def _sentence(findings: Findings, labels: list[str], runaway: bool) -> str:
    overlapping = [c.overlapping for c in findings.configurations] or [False] * len(findings.points)
    points = [p for p, over in zip(findings.points, overlapping, strict=True) if not over]
    named = [name for name, p, over in zip(labels, findings.points, overlapping, strict=False) if p.stable and not over]
    stable = sum(p.stable for p in points)
    one, several = f"one working point, {'stable' if stable else 'not stable'}", f"{len(points)} working points"
    count = one if len(points) == 1 else f"{several}, {stable} of them stable"
    count += f": {', '.join(dict.fromkeys(named))}" if named else ""
    if impossible := sum(overlapping):
        count += f"; {impossible} more with bodies of a track in each other's place" if points else ""
    if runaway:
        away = "without vibration the drive's torque never meets the load: the rotor would run away"
        return f"{away}; with it {'are' if len(points) > 1 else 'is'} {count}" if points else away
    if points:
        return count
    where = " in any steady phases that the balancing bodies have" if findings.search is not None else ""
    return f"drive, load and vibration meet nowhere in the range{where}"
