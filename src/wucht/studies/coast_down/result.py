"""The Dataset of a coast-down, and the answer in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.results.conventions import variable
from wucht.results.outcomes import Outcome
from wucht.studies.attributes import attributes
from wucht.studies.coast_down.kept import attributes_of, ends
from wucht.studies.coast_down.record import Record

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.coast_down.study import CoastDown

AT_REST = 1e-4  # of the speed at the start
_LAST = 0.1  # share of the run that the outcome is judged by


@dataclass(frozen=True)
class Ending:
    """How it ends: an outcome of the contract or None while it turns, in words, the mean speed and its range at the end."""

    outcome: Outcome | None
    sentence: str
    speed: float
    low: float
    high: float


def ending(record: Record) -> Ending:
    """Judged by the last tenth of the run, or by what follows the first reversal if that is shorter.

    ``stopped``: below a ten-thousandth of the speed at the start. ``oscillating``: turned back at least twice, and less than a
    turn was made. Else None: it still turns, or creeps on.
    """
    time, angle, speed = (record.column(n) for n in ("time", "angle", "speed"))
    since = time[-1] - _LAST * (time[-1] - time[0])
    if record.reversal_time is not None:
        since = min(max(since, record.reversal_time), float(time[-2]))
    late = time >= since
    low, high = float(record.column("min_speed")[late].min()), float(record.column("max_speed")[late].max())
    duration = float(time[late][-1] - time[late][0])
    mean = float((angle[late][-1] - angle[late][0]) / duration) if duration else float(speed[-1])
    if max(abs(low), abs(high)) <= AT_REST * abs(record.start_speed):
        return Ending(Outcome.STOPPED, Outcome.STOPPED.sentence, mean, low, high)
    if record.swings >= 2 and np.ptp(angle[late]) < 2 * math.pi:
        return Ending(Outcome.OSCILLATING, Outcome.OSCILLATING.sentence, mean, low, high)
    last = record.turn_speed[-1] if record.reversal_time is None and record.turn_speed else mean
    share = abs(last / record.start_speed)
    turns = "the rotor still turns" if record.reversal_time is None else "the rotor has turned back"
    return Ending(None, f"{turns}, at {100 * share:.3g} % of its speed at the start", mean, low, high)


def result(
    machine: Machine,
    question: CoastDown,
    flow: CompiledSystem,
    record: Record,
    trajectory: Trajectory,
    begun: float,
) -> xr.Dataset:
    """Put a coast-down into a Dataset.

    time (N): angle, speed, min_speed, max_speed and amplitude since the sample before, energy_residual, dissipated_work.
    turn (K): mean_speed over each turn until the first reversal, at the time in the middle of it. natural_frequency (mode).
    """
    import xarray as xr_

    units, words = machine.units, dict[str, Any]()
    for name, long_name, unit in (
        ("angle", "angle of the rotor", "rad"), ("speed", "speed of the rotor", units.speed),
        ("min_speed", "least speed since the last sample", units.speed),
        ("max_speed", "largest speed since the last sample", units.speed),
        ("amplitude", "amplitude of the axis", machine.orbit_unit), ("energy_residual", "energy residual, relative", ""),
    ):  # fmt: skip
        words[name] = variable("time", record.column(name), long_name, unit)
    words["dissipated_work"] = variable("time", record.column("dissipated_work"), "energy dissipated", units.energy)
    words["mean_speed"] = variable("turn", record.turn_speed, "mean speed over a turn", units.speed)
    natural = natural_frequencies(machine)
    words["natural_frequency"] = variable("mode", list(natural.values()), "natural frequency", units.speed)
    words["parameters"] = variable("parameter", list(machine.values.values()), "parameter values")
    coordinates = {
        "time": variable("time", record.column("time"), "time", units.time),
        "turn_time": variable("turn", record.turn_time, "time", units.time),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
        "parameter": variable("parameter", list(machine.values), "parameter"),
    }
    found = xr_.Dataset(words | ends(record, trajectory), coords=coordinates)
    failure, interrupted = trajectory.failure, trajectory.interrupted
    end = ending(record)
    if failure:
        end = Ending(Outcome.FAILED, Outcome.FAILED.sentence, end.speed, end.low, end.high)
    warnings = [failure] if failure else []
    if interrupted:
        warnings.append(f"interrupted at t = {record.rows['time'][-1]:.6g}; --resume goes on")
    found.attrs |= attributes(
        machine, question, _summary(record, end), _sentence(machine, record, end), warnings, begun, failure, interrupted
    )
    found.attrs |= {"outcome": str(end.outcome or ""), "engine": flow.engine.name, "tolerance": flow.tolerance}
    found.attrs |= attributes_of(machine, question, record, trajectory)
    return found


def _summary(record: Record, end: Ending) -> dict[str, Any]:
    residual, amplitude = record.column("energy_residual"), record.column("amplitude")
    return {
        "outcome": None if end.outcome is None else str(end.outcome),
        "sentence": end.sentence,
        "start_speed": record.start_speed,
        "final_speed": end.speed,
        "min_speed": end.low,
        "max_speed": end.high,
        "half_time": record.half_time,
        "reversal_time": record.reversal_time,
        "end_time": record.rows["time"][-1],
        "turns": (record.rows["angle"][-1] - record.rows["angle"][0]) / (2 * math.pi),
        "peak_amplitude": float(amplitude.max()),
        "energy_residual": float(residual.max()),
    }


def _sentence(machine: Machine, record: Record, end: Ending) -> str:
    unit = f" {machine.units.time}" if machine.units.time else ""
    half = "" if record.half_time is None else f"; the speed has halved after {record.half_time:.5g}{unit}"
    back = "" if record.reversal_time is None else f"; it turns back at {record.reversal_time:.5g}{unit}"
    return f"{end.sentence}{half}{back}"
