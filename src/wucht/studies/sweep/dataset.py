"""Findings -> the Dataset of a sweep: what was read off the ramps, the jumps, and the answer in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.operation import free_speed
from wucht.results.conventions import answered, variable
from wucht.studies.sweep.jumps import Jump
from wucht.studies.sweep.moving import Reading
from wucht.studies.sweep.pace import rate_unit
from wucht.studies.sweep.prepare import Plan
from wucht.studies.sweep.run import Findings, Ramp

if TYPE_CHECKING:
    import xarray as xr

_FREE_SPEEDS = 21
_VARIABLES = {
    "value": ("value", "{what}", "{unit}"),
    "speed": ("speed", "mean speed", "{speed}"),
    "min_speed": ("low", "least speed, mean over a turn", "{speed}"),
    "max_speed": ("high", "largest speed, mean over a turn", "{speed}"),
    "amplitude": ("amplitude", "amplitude of the axis", "{length}"),
    "energy_residual": ("energy_residual", "energy residual, relative", ""),
}


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a sweep.

    value, speed, min_speed, max_speed, amplitude, energy_residual (direction, sample), NaN where a ramp ended early;
    jump_value, jump_from, jump_to, jump_from_amplitude, jump_to_amplitude, jump_upward (jump); free_speed (grid), what the
    drive reaches without vibration; parameters (parameter).
    """
    import xarray as xr_

    machine, swept, jumps = plan.machine, plan.swept, findings.jumps
    speed, length = machine.units.speed, machine.orbit_unit
    words = {"what": swept.what, "unit": swept.unit, "speed": speed, "length": length}
    data = {
        name: variable("direction sample", _table(plan, findings.ramps, key), text.format(**words), unit.format(**words))
        for name, (key, text, unit) in _VARIABLES.items()
    }
    grid = np.linspace(plan.low, plan.high, _FREE_SPEEDS)
    free = [free_speed(machine.with_unchecked({swept.path: float(v)}), machine.rotor) for v in grid]
    data |= {
        "free_speed": variable("grid", [math.nan if f is None else f for f in free], "speed reached without vibration", speed),
        "jump_value": variable("jump", [j.value for j in jumps], swept.what, swept.unit),
        "jump_from": variable("jump", [j.speed for j in jumps], "speed before the jump", speed),
        "jump_to": variable("jump", [j.after.speed for j in jumps], "speed after the jump", speed),
        "jump_from_amplitude": variable("jump", [j.amplitude for j in jumps], "amplitude before the jump", length),
        "jump_to_amplitude": variable("jump", [j.after.amplitude for j in jumps], "amplitude after the jump", length),
        "jump_upward": variable("jump", [int(j.upward) for j in jumps], "1 where the parameter rises"),
        "parameters": variable("parameter", list(machine.values.values()), "parameter values"),
    }
    coordinates = {
        "direction": variable("direction", [r.way for r in findings.ramps] or np.empty(0, "U4"), "direction of the sweep"),
        "grid": variable("grid", grid, swept.what, swept.unit),
        "parameter": variable("parameter", list(machine.values), "parameter"),
    }
    sentence = _sentence(plan, findings)
    return answered(
        xr_.Dataset(data, coords=coordinates),
        _summary(plan, findings, sentence),
        sentence,
        _warnings(findings),
        findings.failure,
        along=swept.path,
        along_unit=swept.unit,
        rate=plan.pace.rate,
        engine=findings.engine,
    )


def _table(plan: Plan, ramps: Sequence[Ramp], key: str) -> np.ndarray:
    table = np.full((len(ramps), plan.pace.samples), math.nan)
    for row, ramp in zip(table, ramps, strict=True):
        row[: len(ramp.legs)] = [getattr(r, key) for r in ramp.readings]
    return table


def _summary(plan: Plan, findings: Findings, sentence: str) -> dict[str, Any]:
    path, readings = plan.swept.path, findings.readings
    return {
        "jumps": [_described(path, j) for j in findings.jumps],
        "sentence": sentence,
        "along": path,
        "along_unit": plan.swept.unit,
        "range": [plan.low, plan.high],
        "rate": plan.pace.rate,
        "rate_unit": rate_unit(plan.machine, path),
        "rate_chosen": plan.spec.rate is None,
        "jump_tolerance": plan.spec.jump_tolerance,
        "hysteresis": _hysteresis(findings.jumps),
        "peak_amplitude": max((r.amplitude for r in readings), default=None),
        "energy_residual": max((r.energy_residual for r in readings), default=None),
        "ends": {ramp.way: _ends(ramp.readings) for ramp in findings.ramps if ramp.legs},
    }


def _described(path: str, jump: Jump) -> dict[str, Any]:
    """A jump as the summary has it."""
    return {
        path: jump.value,
        "from_speed": jump.speed,
        "to_speed": jump.after.speed,
        "direction": "up" if jump.upward else "down",
        "from_amplitude": jump.amplitude,
        "to_amplitude": jump.after.amplitude,
        "fold": jump.fold,
        "only_seen": jump.only_seen,
        "bracket": list(jump.bracket),
    }


def _hysteresis(jumps: Sequence[Jump]) -> list[float] | None:
    """Between which values the state depends on the direction: from the last jump down to the first one up; None without."""
    up, down = ([j.value for j in jumps if j.upward is way] for way in (True, False))
    return [min(down), max(up)] if up and down and min(down) < max(up) else None


def _ends(readings: Sequence[Reading]) -> dict[str, float]:
    return {"from_speed": readings[0].speed, "to_speed": readings[-1].speed}


def _warnings(findings: Findings) -> list[str]:
    only_seen = [
        f"the jump near {j.value:.5g} is only known to lie between {j.bracket[0]:.6g} and {j.bracket[1]:.6g}: where the "
        "parameter is held before it, the machine does not stay in the state of the sweep; a lower rate shows where it goes"
        for j in findings.jumps
        if j.only_seen
    ]
    if findings.failure:
        end = [findings.failure]
    else:
        end = [] if findings.complete else ["the sweep is not finished: jumps may be missing"]
    return [*findings.warnings, *only_seen, *end]


def _sentence(plan: Plan, findings: Findings) -> str:
    if findings.failure:
        return "the sweep failed"
    if not findings.complete:
        return "the sweep was interrupted"
    path = plan.swept.path
    if findings.jumps:
        return "; ".join(_in_words(path, j) for j in findings.jumps)
    return f"no jump: the machine follows {path} between {plan.low:.5g} and {plan.high:.5g}"


def _in_words(path: str, j: Jump) -> str:
    way = "rising" if j.upward else "falling"
    if math.isclose(j.speed, j.after.speed, rel_tol=1e-4):
        return f"at {path} = {j.value:.6g} {way} the amplitude jumps from {j.amplitude:.4g} to {j.after.amplitude:.4g}"
    return f"at {path} = {j.value:.6g} {way} the speed jumps from {j.speed:.5g} to {j.after.speed:.5g}"
