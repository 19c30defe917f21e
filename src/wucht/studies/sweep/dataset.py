"""Findings -> the Dataset of a sweep: what was read off the ramps, the jumps, and the answer in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.sweeps.jumps import Jump
from wucht.machines.operation import free_speed
from wucht.results.conventions import answered, variable
from wucht.studies.sweep.prepare import Plan
from wucht.studies.sweep.report import SENSE
from wucht.studies.sweep.run import Findings

if TYPE_CHECKING:
    import xarray as xr

_FREE_SPEEDS = 21
_OF_READINGS = {  # attribute, in words, unit
    "value": ("value", "{what}", "{unit}"),
    "speed": ("speed", "mean speed", "{speed}"),
    "min_speed": ("low", "least speed, mean over a turn", "{speed}"),
    "max_speed": ("high", "largest speed, mean over a turn", "{speed}"),
    "amplitude": ("amplitude", "amplitude of the axis", "{length}"),
    "energy_residual": ("energy_residual", "energy residual, relative", ""),
}
_OF_JUMPS = {
    "jump_value": ("value", "{what}", "{unit}"),
    "jump_from": ("from_speed", "speed before the jump", "{speed}"),
    "jump_to": ("to_speed", "speed after the jump", "{speed}"),
    "jump_from_amplitude": ("from_amplitude", "amplitude before the jump", "{length}"),
    "jump_to_amplitude": ("to_amplitude", "amplitude after the jump", "{length}"),
}


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a sweep.

    value, speed, min_speed, max_speed, amplitude, energy_residual (direction, sample), NaN where a ramp ended early;
    jump_value, jump_from, jump_to, jump_from_amplitude, jump_to_amplitude, jump_upward (jump); free_speed (grid), what the
    drive reaches without vibration; parameters (parameter).
    """
    import xarray as xr_

    machine, swept, jumps = plan.moved.machine, plan.swept, findings.jumps
    words = {"what": swept.words, "unit": swept.unit, "speed": machine.units.speed, "length": machine.orbit_unit}
    grid = np.linspace(plan.low, plan.high, _FREE_SPEEDS)
    free = [free_speed(machine.with_unchecked({swept.path: float(v)}), machine.rotor) for v in grid]
    data = {
        name: variable("direction sample", _table(plan, findings, key), text.format(**words), unit.format(**words))
        for name, (key, text, unit) in _OF_READINGS.items()
    } | {
        name: variable("jump", [getattr(j, key) for j in jumps], text.format(**words), unit.format(**words))
        for name, (key, text, unit) in _OF_JUMPS.items()
    } | {
        "free_speed": variable("grid", np.array(free, float), "speed reached without vibration", machine.units.speed),
        "jump_upward": variable("jump", [int(j.direction == "up") for j in jumps], "1 where the parameter rises"),
        "parameters": variable("parameter", list(machine.values.values()), "parameter values"),
    }  # fmt: skip
    coordinates = {
        "direction": variable("direction", list(findings.ramps) or np.empty(0, "U4"), "direction of the sweep"),
        "grid": variable("grid", grid, swept.words, swept.unit),
        "parameter": variable("parameter", list(machine.values), "parameter"),
    }
    summary = _summary(plan, findings)
    more = {"along": swept.path, "along_unit": swept.unit, "rate": plan.moved.pace.rate, "engine": findings.engine}
    made = xr_.Dataset(data, coords=coordinates)
    return answered(made, summary, summary["sentence"], _warnings(findings), findings.failure, **more)


def _table(plan: Plan, findings: Findings, key: str) -> np.ndarray:
    rows = [[getattr(leg, key) for leg in legs] for legs in findings.ramps.values()]
    samples = plan.moved.pace.samples
    return np.array([row + [math.nan] * (samples - len(row)) for row in rows]).reshape(len(rows), samples)


def hysteresis(jumps: Sequence[Jump]) -> list[float] | None:
    """Between which values the state depends on the direction in which the parameter is moved; None where it does not."""
    up, down = ([j.value for j in jumps if j.direction == way] for way in ("up", "down"))
    return [min(down), max(up)] if up and down and min(down) < max(up) else None


def _summary(plan: Plan, findings: Findings) -> dict[str, Any]:
    path, legs = plan.swept.path, findings.all_legs
    return {
        "jumps": [{path if key == "value" else key: x for key, x in asdict(j).items()} for j in findings.jumps],
        "sentence": _sentence(plan, findings),
        "along": path,
        "along_unit": plan.swept.unit,
        "range": [plan.low, plan.high],
        "rate": plan.moved.pace.rate,
        "rate_unit": plan.moved.pace.rate_unit,
        "rate_chosen": plan.spec.rate is None,
        "jump_tolerance": plan.spec.jump_tolerance,
        "hysteresis": hysteresis(findings.jumps),
        "peak_amplitude": max((leg.amplitude for leg in legs), default=None),
        "energy_residual": max((leg.energy_residual for leg in legs), default=None),
        "ends": {way: {"from_speed": r[0].speed, "to_speed": r[-1].speed} for way, r in findings.ramps.items() if r},
    }


def _warnings(findings: Findings) -> list[str]:
    only_seen = [
        f"the jump near {j.value:.5g} is only known to lie between {j.bracket[0]:.6g} and {j.bracket[1]:.6g}: where the "
        "parameter is held before it, the machine does not stay in the state of the sweep; a lower rate shows where it goes"
        for j in findings.jumps
        if j.only_seen
    ]
    end = findings.failure or ("" if findings.complete else "the sweep is not finished: jumps may be missing")
    return [*findings.warnings, *only_seen, *([end] if end else [])]


def _sentence(plan: Plan, findings: Findings) -> str:
    path = plan.swept.called
    if findings.failure:
        return "the sweep failed"
    if not findings.complete:
        return "the sweep was interrupted"
    if not findings.jumps:
        return f"no jump: the machine follows {path} between {plan.low:.5g} and {plan.high:.5g}"
    jumps = []
    for j in findings.jumps:
        what = f"speed jumps from {j.from_speed:.5g} to {j.to_speed:.5g}"
        if math.isclose(j.from_speed, j.to_speed, rel_tol=1e-4):
            what = f"amplitude jumps from {j.from_amplitude:.4g} to {j.to_amplitude:.4g}"
        jumps.append(f"at {plan.swept.at(j.value)} {SENSE[j.direction]} the {what}")
    return "; ".join(jumps)
