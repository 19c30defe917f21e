"""Findings -> the quantities of a coast-down and how it ends, and its lines in a report."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from wucht.dynamics.run_ups.descent_record import Record
from wucht.dynamics.run_ups.initial_state import angles_in, listed
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.machines.machine import Machine
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, answer
from wucht.studies.coast_down.computation import CarrierStart, Findings, Plan
from wucht.studies.motion_variables import natural_vibrations, parameter_values

if TYPE_CHECKING:
    import xarray as xr


AT_REST = 1e-4  # of the speed at the start
_LAST = 0.1  # share of the run that the outcome is judged by


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a coast-down."""
    record, compiled = findings
    rows, units, end = dict(record.rows), plan.machine.units, record.end
    if plan.carrier is CarrierStart.STEADY:  # as large before the run as in its first turn
        first = rows["time"] <= 2 * math.pi / abs(plan.start_speed)
        rows["amplitude"] = np.append(rows["amplitude"][first].max(), rows["amplitude"][1:])
    ending, at_the_end = _ending(record, units.speed)
    quantities = [
        *at_the_end,
        *_of_course(plan, record, rows),
        *_of_rows(plan.machine, rows),
        Quantity("turn_time", record.turns[0], "time", units.time, "turn", coordinate=True),
        Quantity("mean_speed", record.turns[1], "mean speed over a turn", units.speed, "turn"),
        *(q for q in natural_vibrations(plan.machine) if q.dimensions),
        *parameter_values(plan.machine),
        Quantity("end_state", end.end_state, "state and accumulated works at the end", "", "state"),
    ]
    unit, reversal_time = f" {units.time}" if units.time else "", next(iter(record.reversals), None)
    half = "" if record.half_time is None else f"; the speed has halved after {record.half_time:.5g}{unit}"
    back = "" if reversal_time is None else f"; it turns back at {reversal_time:.5g}{unit}"
    assumed = [*_carrier_assumed(plan), *_rotors_assumed(plan), *plan.bodies.assumed(plan.phases)]
    more = {"outcome": at_the_end[0].value or "", "engine": compiled.engine.name, "tolerance": compiled.tolerance}
    return answer(quantities, f"{ending}{half}{back}", _warnings(plan, end.failure), assumed, end.failure, **more)


def _of_rows(machine: Machine, rows: Mapping[str, np.ndarray]) -> list[Quantity]:
    """What is recorded over the time."""
    units = machine.units
    words = {
        "time": ("time", units.time),
        "angle": ("angle of the rotor", "rad"),
        "speed": ("speed of the rotor", units.speed),
        "min_speed": ("least speed since the last sample", units.speed),
        "max_speed": ("largest speed since the last sample", units.speed),
        "amplitude": ("amplitude of the axis", machine.orbit_unit),
        "energy_residual": ("energy residual, relative", ""),
        "dissipated_work": ("energy dissipated", units.energy),
    }
    return [Quantity(name, rows[name], *both, "time") for name, both in words.items()]


def _of_course(plan: Plan, record: Record, rows: Mapping[str, np.ndarray]) -> list[Quantity]:
    """When it has slowed down, how far it turned, and how it vibrated meanwhile."""
    units, largest = plan.machine.units, int(rows["amplitude"].argmax())
    turns, amplitude = float(rows["angle"][-1] - rows["angle"][0]) / (2 * math.pi), float(rows["amplitude"][largest])
    there, residual = float(rows["speed"][largest]) if amplitude else None, float(rows["energy_residual"].max())
    back, length = next(iter(record.reversals), None), plan.machine.orbit_unit
    return [
        Quantity("start_speed", record.start_speed, "speed of the rotor at the start", units.speed, headline=True),
        Quantity("half_time", record.half_time, "time after which the speed has halved", units.time, headline=True),
        Quantity("reversal_time", back, "time at which the rotor turns back first", units.time, headline=True),
        Quantity("end_time", float(rows["time"][-1]), "time at the end", units.time, headline=True),
        Quantity("turns", turns, "number of turns"),
        Quantity("carrier_start", str(plan.carrier), "how the carrier starts"),
        Quantity("peak_amplitude", amplitude, "largest amplitude of the axis", length, headline=True),
        Quantity("peak_speed", there, "speed of the rotor there", units.speed),
        Quantity("energy_residual", residual, "largest relative error of the energy balance"),
    ]


def _warnings(plan: Plan, failure: str | None) -> list[str]:
    warnings = [failure] if failure else []
    if plan.carrier is CarrierStart.REST:
        steady = "vibration = 'steady' starts with the vibration of that speed"
        other = f"the machine {plan.why_at_rest}" if plan.why_at_rest else steady
        warnings.append(
            "the carrier starts at rest, although the rotor turns: its vibration at first, perhaps the largest, is a transient "
            f"of this start; {other}"
        )
    if plan.bodies.why_held:
        warnings.append(f"balancing bodies start as held, as their steady phases are not computed: {plan.bodies.why_held}")
    return warnings


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


def _ending(record: Record, unit: str) -> tuple[str, list[Quantity]]:
    """How it ends, in words and numbers, by the last tenth of the run, or by what follows the first reversal if that is less.

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
    ending = outcome.sentence if outcome else sentence
    return ending, [
        Quantity("outcome", outcome and str(outcome), "outcome"),
        Quantity("sentence", ending, "how it ends"),
        Quantity("final_speed", mean, "mean speed of the rotor at the end", unit),
        Quantity("min_speed", low, "least speed of the rotor at the end", unit),
        Quantity("max_speed", high, "greatest speed of the rotor at the end", unit),
    ]


_STARTS = {
    "steady": "it starts in the steady vibration of its speed",
    "rest": "the carrier starts at rest",
    "given": "the carrier starts as study.start says",
    "fixed": "the carrier moves as prescribed",
}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a coast-down."""
    s, lines = result.wucht.summary, ReportLines(result)
    lines.add("speed", "{start_speed} at the start, {final_speed} on average at the end")
    lines.add("halved", "not within this time" if s["half_time"] is None else "after {half_time:.5g}")
    lines.add("turns back", "at {reversal_time:.6g}")
    lines.add("turned", "{turns:.5g} times in {end_time:.5g}")
    lines.add("amplitude", f"{{peak_amplitude}} at most, at {{peak_speed}}; {_STARTS[s['carrier_start']]}")
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}" if s["outcome"] else s["sentence"])
