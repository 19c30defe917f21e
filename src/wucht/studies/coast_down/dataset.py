"""Findings -> the Dataset of a coast-down."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.operation import natural_frequencies
from wucht.results.conventions import answered, variable
from wucht.studies.coast_down.ending import Ending, ending
from wucht.studies.coast_down.prepare import Plan
from wucht.studies.coast_down.record import Record
from wucht.studies.coast_down.run import Findings

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a coast-down.

    time (N): angle, speed, min_speed, max_speed and amplitude since the sample before, energy_residual, dissipated_work.
    turn (K): mean_speed over each turn until the first reversal, at the time in the middle of it. natural_frequency (mode).
    end_state (state): states and works at the end.
    """
    import xarray as xr_

    machine, record = plan.machine, findings.record
    units, natural, failure = machine.units, natural_frequencies(machine), record.end.failure
    described = (
        ("angle", "angle of the rotor", "rad"), ("speed", "speed of the rotor", units.speed),
        ("min_speed", "least speed since the last sample", units.speed),
        ("max_speed", "largest speed since the last sample", units.speed),
        ("amplitude", "amplitude of the axis", machine.orbit_unit), ("energy_residual", "energy residual, relative", ""),
        ("dissipated_work", "energy dissipated", units.energy),
    )  # fmt: skip
    data = {name: variable("time", record.rows[name], long_name, unit) for name, long_name, unit in described} | {
        "mean_speed": variable("turn", record.turns[1], "mean speed over a turn", units.speed),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
        "parameters": variable("parameter", list(machine.values.values()), "parameter values"),
        "end_state": variable("state", record.end.end_state, "state and accumulated works at the end"),
    }
    coordinates = {
        "time": variable("time", record.rows["time"], "time", units.time),
        "turn_time": variable("turn", record.turns[0], "time", units.time),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
        "parameter": variable("parameter", list(machine.values), "parameter"),
    }
    end = ending(record)
    return answered(
        xr_.Dataset(data, coords=coordinates),
        _summary(record, end),
        _sentence(record, end, f" {units.time}" if units.time else ""),
        [failure] if failure else [],
        failure,
        outcome=str(end.outcome or ""),
        engine=findings.compiled.engine.name,
        tolerance=findings.compiled.tolerance,
    )


def _summary(record: Record, end: Ending) -> dict[str, Any]:
    rows = record.rows
    return {
        "outcome": None if end.outcome is None else str(end.outcome),
        "sentence": end.sentence,
        "start_speed": record.start_speed,
        "final_speed": end.speed,
        "min_speed": end.low,
        "max_speed": end.high,
        "half_time": record.half_time,
        "reversal_time": record.reversal_time,
        "end_time": float(rows["time"][-1]),
        "turns": float(rows["angle"][-1] - rows["angle"][0]) / (2 * math.pi),
        "peak_amplitude": float(rows["amplitude"].max()),
        "energy_residual": float(rows["energy_residual"].max()),
    }


def _sentence(record: Record, end: Ending, unit: str) -> str:
    half = "" if record.half_time is None else f"; the speed has halved after {record.half_time:.5g}{unit}"
    back = "" if record.reversal_time is None else f"; it turns back at {record.reversal_time:.5g}{unit}"
    return f"{end.sentence}{half}{back}"
