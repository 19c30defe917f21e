"""The Dataset of a sweep: what was read off the ramps, the jumps, and the answer in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.vibration import free_speed
from wucht.results.conventions import variable
from wucht.studies.attributes import attributes
from wucht.studies.sweep.flow import Mover, Reading, with_value
from wucht.studies.sweep.jumps import Jump
from wucht.studies.sweep.kept import attributes_of, places
from wucht.studies.sweep.plan import Plan, rate_unit

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.sweep.study import Record, Sweep

_FREE_SPEEDS = 21
_VARIABLES = {
    "value": ("value", "{what}", "{unit}"),
    "speed": ("speed", "mean speed", "{speed}"),
    "min_speed": ("low", "least speed, mean over a turn", "{speed}"),
    "max_speed": ("high", "largest speed, mean over a turn", "{speed}"),
    "amplitude": ("amplitude", "amplitude of the axis", "{length}"),
    "energy_residual": ("energy_residual", "energy residual, relative", ""),
}


def result(machine: Machine, question: Sweep, plan: Plan, mover: Mover, record: Record, begun: float) -> xr.Dataset:
    """Put a sweep into a Dataset.

    value, speed, min_speed, max_speed, amplitude, energy_residual (direction, sample), NaN where a ramp ended early;
    jump_value, jump_from, jump_to, jump_upward (jump); free_speed (grid), what the drive reaches without vibration; and the
    ``places`` that it is gone on with from.
    """
    import xarray as xr_

    along = machine.parameters[question.along]
    words = {"what": along.what, "unit": along.unit, "speed": machine.units.speed, "length": machine.orbit_unit}
    ways = list(record.readings)
    data = {
        name: variable("direction sample", _table(record, ways, plan.samples, key), text.format(**words), unit.format(**words))
        for name, (key, text, unit) in _VARIABLES.items()
    }
    grid = np.linspace(*question.range, _FREE_SPEEDS)
    free = [free_speed(with_value(machine, question.along, float(v)), machine.rotor) for v in grid]
    data["free_speed"] = variable(
        "grid", [math.nan if f is None else f for f in free], "speed reached without vibration", machine.units.speed
    )
    data["jump_value"] = variable("jump", [j.value for j in record.jumps], along.what, along.unit)
    data["jump_from"] = variable("jump", [j.speed for j in record.jumps], "speed before the jump", machine.units.speed)
    data["jump_to"] = variable("jump", [j.after.speed for j in record.jumps], "speed after the jump", machine.units.speed)
    data["jump_from_amplitude"] = variable(
        "jump", [j.amplitude for j in record.jumps], "amplitude before the jump", machine.orbit_unit
    )
    data["jump_to_amplitude"] = variable(
        "jump", [j.after.amplitude for j in record.jumps], "amplitude after the jump", machine.orbit_unit
    )
    data["jump_upward"] = variable("jump", [int(j.upward) for j in record.jumps], "1 where the parameter rises")
    data["parameters"] = variable("parameter", list(machine.values.values()), "parameter values")
    coordinates = {
        "direction": variable("direction", ways or np.empty(0, "U4"), "direction of the sweep"),
        "grid": variable("grid", grid, along.what, along.unit),
        "parameter": variable("parameter", list(machine.values), "parameter"),
    }
    found = xr_.Dataset(data | places(machine, mover, record, plan.samples), coords=coordinates)
    summary = _summary(machine, question, plan, record)
    found.attrs |= attributes(
        machine, question, summary, _sentence(question, record), _warnings(record), begun, record.failure, record.interrupted
    )
    found.attrs |= {"along": question.along, "along_unit": along.unit, "rate": plan.rate, "engine": mover.flow.engine.name}
    found.attrs |= attributes_of(machine, question, record)
    return found


def _table(record: Record, ways: list[str], samples: int, key: str) -> np.ndarray:
    found = np.full((len(ways), samples), math.nan)
    for i, way in enumerate(ways):
        values = [getattr(r, key) for r in record.readings[way]]
        found[i, : len(values)] = values
    return found


def _summary(machine: Machine, question: Sweep, plan: Plan, record: Record) -> dict[str, Any]:
    every = [r for readings in record.readings.values() for r in readings]
    return {
        "jumps": [described(question.along, j) for j in record.jumps],
        "sentence": _sentence(question, record),
        "along": question.along,
        "along_unit": machine.parameters[question.along].unit,
        "range": list(question.range),
        "rate": plan.rate,
        "rate_unit": rate_unit(machine, question.along),
        "rate_chosen": question.rate is None,
        "jump_tolerance": question.jump_tolerance,
        "hysteresis": hysteresis(record.jumps),
        "peak_amplitude": max((r.amplitude for r in every), default=None),
        "energy_residual": max((r.energy_residual for r in every), default=None),
        "ends": {way: _ends(readings) for way, readings in record.readings.items() if readings},
    }


def described(along: str, jump: Jump) -> dict[str, Any]:
    """A jump as the summary has it."""
    return {
        along: jump.value,
        "from_speed": jump.speed,
        "to_speed": jump.after.speed,
        "direction": "up" if jump.upward else "down",
        "from_amplitude": jump.amplitude,
        "to_amplitude": jump.after.amplitude,
        "fold": jump.fold,
        "only_seen": jump.only_seen,
        "bracket": list(jump.bracket),
    }


def hysteresis(jumps: list[Jump]) -> list[float] | None:
    """Between which values the state depends on the direction: from the last jump down to the first one up; None without."""
    up, down = ([j.value for j in jumps if j.upward is way] for way in (True, False))
    return [min(down), max(up)] if up and down and min(down) < max(up) else None


def _ends(readings: list[Reading]) -> dict[str, float]:
    return {"from_speed": readings[0].speed, "to_speed": readings[-1].speed}


def _warnings(record: Record) -> list[str]:
    said = list(record.warnings)
    said += [
        f"the jump near {j.value:.5g} is only known to lie between {j.bracket[0]:.6g} and {j.bracket[1]:.6g}: where the "
        "parameter is held before it, the machine does not stay in the state of the sweep; a lower rate shows where it goes"
        for j in record.jumps
        if j.only_seen
    ]
    if record.failure:
        said.append(record.failure)
    if record.interrupted:
        said.append("the sweep was interrupted: jumps may be missing; --resume goes on")
    return said


def _sentence(question: Sweep, record: Record) -> str:
    if record.failure:
        return "the sweep failed"
    if record.interrupted:
        return "the sweep was interrupted"
    if record.jumps:
        return "; ".join(_said(question.along, j) for j in record.jumps)
    low, high = (f"{v:.5g}" for v in question.range)
    return f"no jump: the machine follows {question.along} between {low} and {high}"


def _said(along: str, j: Jump) -> str:
    way = "rising" if j.upward else "falling"
    if math.isclose(j.speed, j.after.speed, rel_tol=1e-4):
        return f"at {along} = {j.value:.6g} {way} the amplitude jumps from {j.amplitude:.4g} to {j.after.amplitude:.4g}"
    return f"at {along} = {j.value:.6g} {way} the speed jumps from {j.speed:.5g} to {j.after.speed:.5g}"
