"""Findings -> the Dataset of a coast-down, and how it ends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.descent_record import Record
from wucht.dynamics.run_ups.initial_state import angles_in, listed
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.machines.operation import natural_frequencies
from wucht.results.conventions import answered, assuming, variable
from wucht.studies.coast_down.prepare import CarrierStart, Plan
from wucht.studies.coast_down.run import Findings

if TYPE_CHECKING:
    import xarray as xr

AT_REST = 1e-4  # of the speed at the start
_LAST = 0.1  # share of the run that the outcome is judged by


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a coast-down.

    time (N): angle, speed, min_speed, max_speed and amplitude since the sample before, energy_residual, dissipated_work.
    turn (K): mean_speed over each turn until the first reversal, at the time in the middle of it. natural_frequency (mode).
    end_state (state): states and works at the end.
    """
    import xarray as xr_

    record, compiled = findings
    machine, failure, rows = plan.machine, record.end.failure, dict(record.rows)
    if plan.carrier is CarrierStart.STEADY:  # as large before the run as in its first turn
        first = rows["time"] <= 2 * math.pi / abs(plan.start_speed)
        rows["amplitude"] = np.append(rows["amplitude"][first].max(), rows["amplitude"][1:])
    largest = int(rows["amplitude"].argmax())
    units, natural = machine.units, natural_frequencies(machine)
    of_rows = {
        "angle": ("angle of the rotor", "rad"),
        "speed": ("speed of the rotor", units.speed),
        "min_speed": ("least speed since the last sample", units.speed),
        "max_speed": ("largest speed since the last sample", units.speed),
        "amplitude": ("amplitude of the axis", machine.orbit_unit),
        "energy_residual": ("energy residual, relative", ""),
        "dissipated_work": ("energy dissipated", units.energy),
    }
    data = {name: variable("time", rows[name], *described) for name, described in of_rows.items()} | {
        "mean_speed": variable("turn", record.turns[1], "mean speed over a turn", units.speed),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
        "parameters": variable("parameter", list(machine.values.values()), "parameter values"),
        "end_state": variable("state", record.end.end_state, "state and accumulated works at the end"),
    }
    coordinates = {
        "time": variable("time", rows["time"], "time", units.time),
        "turn_time": variable("turn", record.turns[0], "time", units.time),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
        "parameter": variable("parameter", list(machine.values), "parameter"),
    }
    reversal_time, unit = next(iter(record.reversals), None), f" {units.time}" if units.time else ""
    summary = _ending(record) | {
        "start_speed": record.start_speed,
        "half_time": record.half_time,
        "reversal_time": reversal_time,
        "end_time": float(rows["time"][-1]),
        "turns": float(rows["angle"][-1] - rows["angle"][0]) / (2 * math.pi),
        "carrier_start": str(plan.carrier),
        "peak_amplitude": float(rows["amplitude"][largest]),
        "peak_speed": float(rows["speed"][largest]) if rows["amplitude"][largest] else None,
        "energy_residual": float(rows["energy_residual"].max()),
    }
    half = "" if record.half_time is None else f"; the speed has halved after {record.half_time:.5g}{unit}"
    back = "" if reversal_time is None else f"; it turns back at {reversal_time:.5g}{unit}"
    sentence, warnings = f"{summary['sentence']}{half}{back}", [failure] if failure else []
    if plan.carrier is CarrierStart.REST:
        steady = "vibration = 'steady' starts with the vibration of that speed"
        other = f"the machine {plan.why_at_rest}" if plan.why_at_rest else steady
        warnings.append(
            "the carrier starts at rest, although the rotor turns: its vibration at first, perhaps the largest, is a transient "
            f"of this start; {other}"
        )
    if plan.bodies.why_held:
        warnings.append(f"balancing bodies start as held, as their steady phases are not computed: {plan.bodies.why_held}")
    more = {"outcome": summary["outcome"] or "", "engine": compiled.engine.name, "tolerance": compiled.tolerance}
    result = answered(xr_.Dataset(data, coords=coordinates), summary, sentence, warnings, failure, **more)
    return assuming(result, [*_carrier_assumed(plan), *_rotors_assumed(plan), *plan.bodies.assumed(plan.phases)])


def _rotors_assumed(plan: Plan) -> list[str]:
    """Where several rotors start, as a statement: on their phases to each other depends what vibrates."""
    rotors, angles = plan.machine.rotors, angles_in(plan.machine, plan.initial)
    return [f"rotors start at {listed({r.name: angles[r.name] for r in rotors})}"] if len(rotors) > 1 else []


def _carrier_assumed(plan: Plan) -> list[str]:
    """How the carrier starts, as a statement; none where it cannot move, or where the start says it."""
    if plan.carrier in (CarrierStart.FIXED, CarrierStart.GIVEN):
        return []
    at_first = "in the steady vibration of its speed" if plan.carrier is CarrierStart.STEADY else "at rest"
    return [f"the carrier starts {at_first}"]


def _ending(record: Record) -> dict[str, Any]:
    """How it ends, by the last tenth of the run, or by what follows the first reversal if that is shorter.

    ``failed``: it could not be integrated further. ``stopped``: below a ten-thousandth of the speed at the start.
    ``oscillating``: turned back at least twice, and less than a turn was made. Else no outcome: it still turns, or creeps on.
    """
    time, start = record.rows["time"], abs(record.start_speed)
    since = time[-1] - _LAST * (time[-1] - time[0])
    if record.reversals:
        since = min(max(since, record.reversals[0]), float(time[-2]))
    late = {name: column[time >= since] for name, column in record.rows.items()}
    low, high = float(late["min_speed"].min()), float(late["max_speed"].max())
    duration = float(late["time"][-1] - late["time"][0])
    mean = float((late["angle"][-1] - late["angle"][0]) / duration) if duration else float(late["speed"][-1])
    speed = mean if record.reversals or not record.turns.size else record.turns[1, -1]
    turning = "the rotor has turned back" if record.reversals else "the rotor still turns"
    outcome, sentence = None, f"{turning}, at {100 * abs(speed / start):.3g} % of its speed at the start"
    if record.end.failure:
        outcome = Outcome.FAILED
    elif max(abs(low), abs(high)) <= AT_REST * start:
        outcome = Outcome.STOPPED
    elif len(record.reversals) >= 2 and np.ptp(late["angle"]) < 2 * math.pi:
        outcome = Outcome.OSCILLATING
    return {
        "outcome": outcome and str(outcome),
        "sentence": outcome.sentence if outcome else sentence,
        "final_speed": mean,
        "min_speed": low,
        "max_speed": high,
    }
