"""Findings -> the Dataset of a torque balance: torques over the speed, the working points, and the summary."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wucht.analysis.configurations.configuration import Configuration
from wucht.analysis.configurations.steady_branches import labels_of
from wucht.machines.operation import free_speed, natural_frequencies, sense_of
from wucht.results.quantities import Quantity, answer, table
from wucht.studies.torque_balance.prepare import Plan
from wucht.studies.torque_balance.run import Findings

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a torque balance."""
    labels = [_label(plan, c) for c in findings.configurations]
    sentence = _sentence(findings, labels, plan.curves[0].runaway)
    quantities = [*_of_curves(plan), *_of_points(plan, findings, labels), *_of_machine(plan)]
    return answer(quantities, sentence, _warnings(plan, findings) + plan.steady.warnings, plan.steady.assumed)


def _of_curves(plan: Plan) -> list[Quantity]:
    """The torques over the speed, and whether a working point there would be stable; of each configuration its own."""
    machine, base = plan.steady.machine, plan.curves[0]
    grid = plan.steady.grid(np.unique(np.concatenate([c.grid for c in plan.curves])))
    drive, load, _ = base.torques(grid)[0]
    vibration = np.array([c.torques(grid)[0][2] for c in plan.curves])
    surplus, slope = np.moveaxis(np.array([c.surplus(grid) for c in plan.curves]), 1, 0)
    stable, along, of_pieces = slope < 0, "configuration speed", list[Quantity]()
    if not plan.steady.branches:
        vibration, surplus, stable, along = vibration[0], surplus[0], stable[0], "speed"
    else:
        pieces = plan.steady.pieces(sense_of(machine, machine.rotor) * grid)
        at, inside = [p.branch for p in pieces], np.array([p.inside for p in pieces])
        vibration, surplus = (np.where(inside, torque[at], np.nan) for torque in (vibration, surplus))
        stable = stable[at] & np.array([p.stable for p in pieces])
        names, overlapping = np.array([p.label for p in pieces], str), np.array([p.overlapping for p in pieces], np.int8)
        of_pieces = [
            Quantity("configuration_name", names, "steady phase configuration", "", "configuration", coordinate=True),
            Quantity("overlapping", overlapping, "bodies of a track are in each other's place", "", "configuration"),
        ]
    speed, torque = machine.units.speed, machine.units.torque
    return [
        Quantity("speed", grid, "speed", speed, "speed"),
        Quantity("drive_torque", drive, "torque of the drive", torque, "speed"),
        Quantity("load_torque", load, "torque of loads and bearings", torque, "speed"),
        Quantity("vibration_torque", vibration, "torque of the vibration", torque, along),
        Quantity("surplus_torque", surplus, "drive less load and vibration", torque, along),
        Quantity("stable", stable.astype(np.int8), "stable, if it is a working point", "", along),
        *of_pieces,
    ]


def _of_points(plan: Plan, findings: Findings, labels: list[str]) -> list[Quantity]:
    """The working points; of bodies in steady phases with their configuration."""
    units, rows = plan.steady.machine.units, [asdict(p) for p in findings.points]
    for row, c, label in zip(rows, findings.configurations, labels, strict=False):
        row |= {
            "configuration": label, "name": c.name, "phases": c.phases, "residual_share": c.share,
            "overlapping": c.overlapping, "indifferent": c.state.indifferent, "family_dimension": c.state.dimension,
        }  # fmt: skip
    parts = {
        "speed": ("speed of a working point", units.speed),
        "torque": ("torque of the drive there", units.torque),
        "stable": ("whether it is stable", ""),
        "tangential": ("whether the curves touch there, and do not cross", ""),
        "slope": ("slope of the drive's characteristic there", f"{units.torque} {units.time}".strip()),
        "no_load_speed": ("no-load speed of the straight line that replaces it", units.speed),
        "slip": ("slip of an induction motor", ""),
        "configuration": ("steady phase configuration there", ""),
        "name": ("kind of configuration", ""),
        "phases": ("phases of the bodies to the rotor", "rad"),
        "residual_share": ("unbalance that is left, as a share of the rotor's", ""),
        "overlapping": ("whether bodies of a track are in each other's place", ""),
        "indifferent": ("whether phases can be chosen freely", ""),
        "family_dimension": ("number of phases that can be chosen freely", ""),
    }
    columns = ["speed", "torque", "stable", *(("configuration", "overlapping") if plan.steady.branches else ())]
    return table("working_points", rows, "steady speeds at which the torques balance", parts, "point", columns)


def _of_machine(plan: Plan) -> list[Quantity]:
    """What the machine has without vibration, and what was asked."""
    machine, base = plan.steady.machine, plan.curves[0]
    units, natural = machine.units, natural_frequencies(machine)
    breakdown = None if base.breakdown is None else dict(zip(("slip", "speed", "torque"), base.breakdown, strict=True))
    parts = {"slip": ("slip", ""), "speed": ("speed", units.speed), "torque": ("torque of the drive", units.torque)}
    return [
        Quantity("on", base.rotor.name, "rotor on whose shaft the torques act"),
        Quantity("range", list(base.range), "lowest and highest speed", units.speed),
        Quantity("bodies", "steady" if plan.steady.branches else "held", "where balancing bodies are"),
        Quantity(
            "free_speed", free_speed(machine, base.rotor), "speed reached without vibration", units.speed, "",
            in_summary=True, headline=True,
        ),
        Quantity("breakdown", breakdown, "largest torque of an induction motor", parts=parts),
        Quantity("runaway", base.runaway, "whether the drive's torque, without vibration, never meets the load"),
        Quantity("mode", list(natural) or np.empty(0, "U1"), "mode of vibration", "", "mode"),
        Quantity("natural_frequency", list(natural.values()), "natural frequency", units.speed, "mode"),
        Quantity("natural_frequencies", natural, "natural frequencies by mode", units.speed),
    ]  # fmt: skip


def _label(plan: Plan, c: Configuration) -> str:
    assert plan.steady.torques is not None
    return str(labels_of(plan.steady.torques, c.state.beside, c.state.phases[:, None])[0])


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
