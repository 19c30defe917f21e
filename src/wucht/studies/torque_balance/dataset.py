"""Findings -> the Dataset of a torque balance: torques over the speed, the working points, and the summary."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wucht.machines.operation import free_speed, natural_frequencies
from wucht.results.conventions import answered, variable
from wucht.studies.torque_balance.prepare import Plan
from wucht.studies.torque_balance.run import Findings

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a torque balance.

    Coordinates: speed (N), mode, point. Variables: drive_torque, load_torque, vibration_torque, surplus_torque, stable (speed:
    whether the slope of a working point there would be that of a stable one); point_speed, point_torque, point_stable (point);
    free_speed, natural_frequency (mode).
    """
    import xarray as xr_

    points, curves, machine = findings, plan.curves, plan.steady.machine
    units, natural, free = machine.units, natural_frequencies(machine), free_speed(machine, curves.rotor)
    (drive, load, vibration), (surplus, slope) = curves.torques(curves.grid)[0], curves.surplus(curves.grid)
    coordinates = {
        "speed": variable("speed", curves.grid, "speed", units.speed),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
    }
    data = {
        "drive_torque": variable("speed", drive, "torque of the drive", units.torque),
        "load_torque": variable("speed", load, "torque of loads and bearings", units.torque),
        "vibration_torque": variable("speed", vibration, "torque of the vibration", units.torque),
        "surplus_torque": variable("speed", surplus, "drive less load and vibration", units.torque),
        "stable": variable("speed", (slope < 0).astype(np.int8), "slope of a stable working point"),
        "point_speed": variable("point", [p.speed for p in points], "speed of a working point", units.speed),
        "point_torque": variable("point", [p.torque for p in points], "torque of the drive there", units.torque),
        "point_stable": variable("point", np.array([p.stable for p in points], np.int8), "stable"),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
    }
    breakdown, runaway = curves.breakdown, curves.runaway
    sentence = _sentence(points, runaway)
    summary = {
        "sentence": sentence,
        "on": curves.rotor.name,
        "range": list(curves.range),
        "working_points": [asdict(p) for p in points],
        "free_speed": free,
        "breakdown": None if breakdown is None else dict(zip(("slip", "speed", "torque"), breakdown, strict=True)),
        "runaway": runaway,
        "natural_frequencies": natural,
    }
    warnings = []
    if any(p.tangential for p in points):
        warnings.append("at a working point the curves only touch: the least change makes two of it or none")
    if len(machine.rotors) > 1:
        warnings.append(f"all rotors are taken to turn as fast as {curves.rotor.name!r}, in the phases of the start")
    return answered(xr_.Dataset(dict(data), coords=coordinates), summary, sentence, warnings + plan.steady.warnings)


def _sentence(points: Findings, runaway: bool) -> str:
    stable = sum(p.stable for p in points)
    one, several = f"one working point, {'stable' if stable else 'not stable'}", f"{len(points)} working points"
    count = one if len(points) == 1 else f"{several}, {stable} of them stable"
    if runaway:
        away = "without vibration the drive's torque never meets the load: the rotor would run away"
        return f"{away}; with it {'are' if len(points) > 1 else 'is'} {count}" if points else away
    return count if points else "drive, load and vibration meet nowhere in the range"
