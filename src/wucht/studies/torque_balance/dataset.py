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

    f, machine, rotor, units = findings, plan.steady.machine, plan.curves.rotor, plan.steady.machine.units
    natural, free, points = natural_frequencies(machine), free_speed(machine, rotor), f.working_points
    coordinates = {
        "speed": variable("speed", f.speeds, "speed", units.speed),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
    }
    data = {
        "drive_torque": variable("speed", f.drive, "torque of the drive", units.torque),
        "load_torque": variable("speed", f.load, "torque of loads and bearings", units.torque),
        "vibration_torque": variable("speed", f.vibration, "torque of the vibration", units.torque),
        "surplus_torque": variable("speed", f.drive - f.load - f.vibration, "drive less load and vibration", units.torque),
        "stable": variable("speed", (f.slope < 0).astype(np.int8), "slope of a stable working point"),
        "point_speed": variable("point", [p.speed for p in points], "speed of a working point", units.speed),
        "point_torque": variable("point", [p.torque for p in points], "torque of the drive there", units.torque),
        "point_stable": variable("point", np.array([p.stable for p in points], np.int8), "stable"),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
    }
    sentence = _sentence(f)
    summary = {
        "sentence": sentence,
        "on": rotor.name,
        "range": list(plan.curves.range),
        "working_points": [asdict(p) for p in points],
        "free_speed": free,
        "breakdown": None if f.breakdown is None else dict(zip(("slip", "speed", "torque"), f.breakdown, strict=True)),
        "runaway": f.runaway,
        "natural_frequencies": natural,
    }
    return answered(xr_.Dataset(dict(data.items()), coords=coordinates), summary, sentence, _warnings(plan, f))


def _sentence(f: Findings) -> str:
    points, stable = f.working_points, sum(p.stable for p in f.working_points)
    count = f"{len(points)} working points, {stable} of them stable"
    if len(points) == 1:
        count = f"one working point, {'stable' if stable else 'not stable'}"
    if f.runaway:
        away = "without vibration the drive's torque never meets the load: the rotor would run away"
        return f"{away}; with it {'are' if len(points) > 1 else 'is'} {count}" if points else away
    return count if points else "drive, load and vibration meet nowhere in the range"


def _warnings(plan: Plan, f: Findings) -> list[str]:
    warnings = []
    if any(p.tangential for p in f.working_points):
        warnings.append("at a working point the curves only touch: the least change makes two of it or none")
    if len(plan.steady.machine.rotors) > 1:
        warnings.append(f"all rotors are taken to turn as fast as {plan.curves.rotor.name!r}, in the phases of the start")
    return warnings + plan.steady.warnings
