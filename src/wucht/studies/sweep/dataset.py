"""Findings -> the quantities of a sweep, its sentence and its warnings, and its lines in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wucht.dynamics.sweeps.jumps import Jump
from wucht.machines.operation import free_speed
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.motion_variables import parameter_values
from wucht.studies.sweep.computation import SENSE, Findings, Plan
from wucht.studies.sweep.system_sweep import SystemSweepFindings, SystemSweepPlan
from wucht.studies.sweep.system_sweep_result import system_sweep_dataset, system_sweep_report

if TYPE_CHECKING:
    import xarray as xr

_FREE_SPEEDS = 21


def dataset(plan: Plan | SystemSweepPlan, findings: Findings | SystemSweepFindings) -> xr.Dataset:
    """Build the Dataset of a sweep."""
    if isinstance(findings, SystemSweepFindings):
        return system_sweep_dataset(findings)
    assert isinstance(plan, Plan)
    pace, parameter = plan.moved_machine.pace, plan.parameter
    quantities = [*_jump_quantities(plan, findings), *_question_quantities(plan), *_ramp_quantities(plan, findings)]
    more = {"along": parameter.path, "along_unit": parameter.unit, "rate": pace.rate, "engine": findings.engine}
    return result_dataset(quantities, _sentence(plan, findings), _warnings(findings), (), findings.failure, **more)


def _jump_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """The jumps, in the summary with the value of the parameter under its path."""
    parameter, jumps, speed, length = (
        plan.parameter,
        findings.jumps,
        plan.moved_machine.machine.units.speed,
        plan.moved_machine.machine.orbit_unit,
    )
    parts = {
        parameter.path: (parameter.full_name, parameter.unit),
        "from_speed": ("speed before the jump", speed),
        "to_speed": ("speed after the jump", speed),
        "direction": ("direction in which the parameter moves", ""),
        "from_amplitude": ("amplitude before the jump", length),
        "to_amplitude": ("amplitude after the jump", length),
        "fold": ("whether the branch ends in a fold there", ""),
        "only_seen": ("whether it is known from the ramp only", ""),
        "bracket": ("values between which the branch ends", parameter.unit),
    }
    rows = [{parameter.path if key == "value" else key: x for key, x in asdict(j).items()} for j in jumps]
    columns = {"value": parameter.path, "from": "from_speed", "to": "to_speed"} | {
        n: n for n in ("from_amplitude", "to_amplitude")
    }
    return [
        *table("jumps", rows, "jumps, in the order in which they occur", parts),
        *(Quantity(f"jump_{n}", [row[part] for row in rows], *parts[part], "jump") for n, part in columns.items()),
        Quantity("jump_upward", [int(j.direction == "up") for j in jumps], "1 where the parameter rises", "", "jump"),
    ]


def _question_quantities(plan: Plan) -> list[Quantity]:
    """The swept parameter, its rate, and the speed of the drive without vibration."""
    machine, parameter, pace = plan.moved_machine.machine, plan.parameter, plan.moved_machine.pace
    grid = np.linspace(plan.low, plan.high, _FREE_SPEEDS)
    free = [free_speed(machine.with_unchecked_values({parameter.path: float(v)}), machine.rotor) for v in grid]
    return [
        Quantity("along", parameter.path, "swept parameter"),
        Quantity("along_unit", parameter.unit, "unit of the swept parameter"),
        Quantity("range", [plan.low, plan.high], "lowest and highest value of the parameter", parameter.unit),
        Quantity("rate", pace.rate, "rate of the parameter", pace.rate_unit),
        Quantity("rate_unit", pace.rate_unit, "unit of the rate"),
        Quantity("rate_chosen", plan.spec.rate is None, "whether the rate is the program's choice"),
        Quantity("jump_tolerance", plan.spec.jump_tolerance, "relative tolerance of the values of jumps"),
        Quantity("grid", grid, parameter.full_name, parameter.unit, "grid"),
        Quantity("free_speed", np.array(free, float), "speed reached without vibration", machine.units.speed, "grid"),
        *parameter_values(machine),
    ]


def _ramp_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Readings of the ramps, NaN where one ended early."""
    parameter, speed, length, legs = (
        plan.parameter,
        plan.moved_machine.machine.units.speed,
        plan.moved_machine.machine.orbit_unit,
        findings.all_legs,
    )
    peak, residual = (max((getattr(leg, n) for leg in legs), default=None) for n in ("amplitude", "energy_residual"))
    ends = {way: {"from_speed": r[0].speed, "to_speed": r[-1].speed} for way, r in findings.ramps.items() if r}
    parts = {"from_speed": ("speed at its start", speed), "to_speed": ("speed at its end", speed)}
    readings = {
        "value": ("value", parameter.full_name, parameter.unit),
        "speed": ("speed", "mean speed", speed),
        "min_speed": ("low", "least speed, mean over a turn", speed),
        "max_speed": ("high", "largest speed, mean over a turn", speed),
        "amplitude": ("amplitude", "amplitude of the axis", length),
        "energy_residual": ("energy_residual", "energy residual, relative", ""),
    }
    return [
        Quantity("direction", list(findings.ramps) or np.empty(0, "U4"), "direction of the sweep", "", "direction"),
        *(
            Quantity(n, _table(plan, findings, of), long_name, u, "direction sample", coordinate=n == "value")
            for n, (of, long_name, u) in readings.items()
        ),
        Quantity("hysteresis", hysteresis(findings.jumps), "range in which the state depends on the direction", parameter.unit),
        Quantity("peak_amplitude", peak, "largest amplitude of the axis", length, headline=True),
        Quantity("energy_residual", residual, "largest relative error of the energy balance"),
        Quantity("ends", ends, "speeds at the ends of each ramp", parts=parts),
    ]


def _table(plan: Plan, findings: Findings, key: str) -> np.ndarray:
    rows = [[getattr(leg, key) for leg in legs] for legs in findings.ramps.values()]
    samples = plan.moved_machine.pace.samples
    return np.array([row + [math.nan] * (samples - len(row)) for row in rows]).reshape(len(rows), samples)


def hysteresis(jumps: Sequence[Jump]) -> list[float] | None:
    """Range of values in which the state depends on the direction of the sweep; None if there is none."""
    up, down = ([j.value for j in jumps if j.direction == way] for way in ("up", "down"))
    return [min(down), max(up)] if up and down and min(down) < max(up) else None


def _warnings(findings: Findings) -> list[str]:
    doubtful_jumps = [
        f"the jump near {j.value:.5g} is only known to lie between {j.bracket[0]:.6g} and {j.bracket[1]:.6g}: with the "
        "parameter held before it, the machine does not remain in the state of the sweep; a lower rate shows where it settles"
        for j in findings.jumps
        if j.only_seen
    ]
    end = findings.failure or ("" if findings.complete else "the sweep is not finished: jumps may be missing")
    return [*findings.warnings, *doubtful_jumps, *([end] if end else [])]


def _sentence(plan: Plan, findings: Findings) -> str:
    path = plan.parameter.sentence_name
    if findings.failure:
        return "the sweep failed"
    if not findings.complete:
        return "the sweep was interrupted"
    if not findings.jumps:
        return f"no jump: the machine follows {path} between {plan.low:.5g} and {plan.high:.5g}"
    jumps = []
    for j in findings.jumps:
        change = f"speed jumps from {j.from_speed:.5g} to {j.to_speed:.5g}"
        if math.isclose(j.from_speed, j.to_speed, rel_tol=1e-4):
            change = f"amplitude jumps from {j.from_amplitude:.4g} to {j.to_amplitude:.4g}"
        jumps.append(f"at {plan.parameter.value_text(j.value)} {SENSE[j.direction]} the {change}")
    return "; ".join(jumps)


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a sweep."""
    if "maxima" in result:
        return system_sweep_report(result)
    s, lines = result.wucht.summary, ReportLines(result)
    jumps, (low, high), unit = s["jumps"], s["range"], f" {s['along_unit']}" if s["along_unit"] else ""
    chosen = " (chosen so that the machine follows)" if s["rate_chosen"] else ""
    lines.add("sweep", f"{{along}} from {low:.5g} to {high:.5g}{unit} at {{rate:.3g}}{chosen}")
    for way, ends in s["ends"].items():
        lines.add(way, "{from_speed} to {to_speed}", ends, "ends")
    for jump in jumps:
        lines.add("jump", f"{SENSE[jump['direction']]}, at {s['along']} = {jump[s['along']]:.6g}{unit}:")
        lines.add("", "speed {from_speed} to {to_speed}", jump, "jumps")
        lines.add("", "amplitude {from_amplitude} to {to_amplitude}", jump, "jumps")
    if s["hysteresis"]:
        between = "{:.6g} and {:.6g}".format(*s["hysteresis"])
        lines.add("hysteresis", f"between {between}{unit} the state depends on the direction of the sweep")
    if jumps:
        lines.add("accuracy", "{jump_tolerance:.0e} of these values, obtained with {along} held: independent of the rate")
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    count = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(jumps), f"{len(jumps)} JUMPS")
    return lines.report(s["sentence"].upper() if s["sentence"].startswith("the sweep") else count)
