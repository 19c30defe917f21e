"""Findings -> vibration, loads, energy and damage of the cycle, its course, and the lines of the report."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.observed_loads import LoadedRun
from wucht.dynamics.run_ups.start_stop_cases import SLOW_EVENT, drives_without_circuit, supplied_energy
from wucht.dynamics.verdicts.observation import speed_at_largest
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.fatigue.counting import rainflow
from wucht.fatigue.damage import AccumulatedDamage
from wucht.machines.machine import SUPPLIED_WORK
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.motion_variables import natural_vibrations
from wucht.studies.start_stop.computation import Findings, Plan

if TYPE_CHECKING:
    import xarray as xr

_STEPS = 300  # of the damage over time


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of a cycle."""
    up, down = findings.up, findings.down
    runs = [up] if down is None else [up, down]
    courses = [MotionCourse.from_turns(r.case.machine, r.trajectory, r.loads.observation) for r in runs]
    machine = plan.case.machine
    quantities = [
        *_phase_quantities(plan, findings),
        *_load_quantities(plan, runs),
        *_energy_quantities(plan, up, 0.0 if down is None else down.trajectory.end_time),
        *_damage_quantities(plan, findings),
        *_course_quantities(plan, runs, courses),
        *(q for q in natural_vibrations(machine) if q.dimensions),
    ]
    failure = next((r.trajectory.failure for r in runs if r.trajectory.failure), None)
    attributes = {"outcome": str(up.verdict.outcome)}
    warnings = _warnings(plan, findings, failure)
    return result_dataset(quantities, _sentence(plan, findings), warnings, _assumptions(plan), failure, **attributes)


def _phase_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Outcome, times, and the largest amplitude of both phases with the speed there."""
    up, down, units, orbit = findings.up, findings.down, plan.machine.units, plan.machine.orbit_unit
    verdict, rotor = up.verdict, up.case.machine.rotor.name
    amplitude = verdict.amplitudes[0] if verdict.amplitudes else None
    peak_up = up.loads.observation.largest
    peak_down = None if down is None else down.loads.observation.largest
    runs = [up] if down is None else [up, down]
    speeds = [speed_at_largest(run.case.machine, run.loads.observation) for run in runs] + [None]
    return [
        Quantity("outcome", str(verdict.outcome), "outcome of the run-up"),
        Quantity("peak_amplitude_up", peak_up, "largest amplitude of the axis on the way up", orbit, headline=True),
        Quantity("peak_speed_up", speeds[0] and abs(speeds[0]), f"mean speed of {rotor} over the turn there", units.speed),
        Quantity("peak_amplitude_down", peak_down, "largest amplitude of the axis on the way down", orbit, headline=True),
        Quantity("peak_speed_down", speeds[1] and abs(speeds[1]), f"mean speed of {rotor} over the turn there", units.speed),
        Quantity("operating_amplitude", amplitude, "mean amplitude of the axis before the switch-off", orbit),
        Quantity("operating_speed", verdict.speed, f"speed of {rotor} before the switch-off", units.speed),
        Quantity("settling_time", verdict.settling_time, "time until the speed has settled", units.time),
        Quantity("switch_off_time", up.trajectory.end_time, "time at which the drives are switched off", units.time),
        Quantity("down_time", None if down is None else down.trajectory.end_time, "time of the coast-down", units.time),
    ]  # fmt: skip


def _load_quantities(plan: Plan, runs: list[LoadedRun]) -> list[Quantity]:
    units = plan.machine.units
    forces, travels = (
        {name: max(values[name] for values in maxima) for name in maxima[0]}
        for maxima in ([dict(r.loads.bearing_forces) for r in runs], [dict(r.loads.travels) for r in runs])
    )
    return [
        Quantity(
            "bearing_forces", forces, "largest force of each rotor, with the bodies about it, on the carrier", units.force
        ),
        Quantity("mount_travel", travels, "largest distance of each mount from its position at rest", units.length),
    ]


def _energy_quantities(plan: Plan, up: LoadedRun, down_time: float) -> list[Quantity]:
    """Energy and work of the drives, also over the time of the cycle: after the switch-off they stay."""
    trajectory, units = up.trajectory, plan.machine.units
    energy, work = supplied_energy(trajectory), trajectory.quadratures[SUPPLIED_WORK]
    times = trajectory.time
    if down_time:
        times, energy, work = (np.append(x, x[-1]) for x in (times, energy, work))
        times[-1] += down_time
    return [
        Quantity("energy", float(energy[-1]), "energy that the drives take from the supply", units.energy, headline=True),
        Quantity("shaft_work", float(work[-1]), "work of the drives on their shafts", units.energy),
        Quantity("energy_time", times, "time", units.time, "energy_time", coordinate=True),
        Quantity("supplied_energy", energy, "energy from the supply", units.energy, "energy_time"),
        Quantity("shaft_work_course", work, "work on the shafts", units.energy, "energy_time"),
    ]


def _damage_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Miner's sum of the cycle and of a time of operation, the cycles until failure, and those that the target life allows."""
    units, time, line = plan.machine.units, plan.machine.units.time, plan.line
    if line is None or plan.signal is None:
        return [Quantity("damage", None, "Miner's sum of a cycle")]
    up, down = findings.up, findings.down
    times, values = _history(findings)
    damage = float(line.damages(rainflow(values, "repeat")).sum())
    rate = operation_damage(plan, up)
    life = plan.spec.target_life
    allowed = None if life is None or rate is None else allowed_cycles(damage, rate, up.trajectory.end_time, life)
    cycles = 1 / damage if damage and down is not None else None
    quantities = [
        Quantity("damage", damage if down is not None else None, "Miner's sum of a cycle", headline=True),
        Quantity("operation_damage", rate, "Miner's sum of a time of steady operation", f"1/{time}" if time else ""),
        Quantity("cycles", cycles, "cycles until the part fails, without operation between them"),
        Quantity("allowed_cycles", allowed if down is not None else None, "cycles that the target life allows"),
        Quantity("target_life", life, "target life", units.time),
        Quantity("signal", plan.signal.name, "signal whose cycles are counted"),
        Quantity("largest_range", float(np.ptp(values)), "largest range of the signal", plan.signal.unit),
    ]  # fmt: skip
    ends = np.unique(np.linspace(0, len(values), min(_STEPS, len(values)) + 1).round().astype(int))[1:]
    damage_so_far, course, begin = AccumulatedDamage(line), list[float](), 0
    for end in ends.tolist():
        damage_so_far, begin = damage_so_far.update(values[begin:end]), end
        course.append(damage_so_far.total)
    return [
        *quantities,
        Quantity("damage_time", times[ends - 1], "time", time, "damage_time", coordinate=True),
        Quantity("damage_course", np.array(course), "damage so far", "", "damage_time"),
    ]


def _history(findings: Findings) -> tuple[np.ndarray, np.ndarray]:
    """Time and values (m,) of the turning points of the cycle."""
    parts = [r.loads.points.points_to_end() for r in (findings.up, findings.down) if r is not None]
    times, values = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return times, values


def operation_damage(plan: Plan, up: LoadedRun) -> float | None:
    """Miner's sum of a unit of time in the state before the switch-off, None where that has not settled."""
    verdict, line = up.verdict, plan.line
    begin, end = verdict.window
    if line is None or verdict.outcome in (Outcome.UNIDENTIFIED, Outcome.FAILED) or not end > begin:
        return None
    times, values = up.loads.points.points_to_end()
    inside = values[(times >= begin) & (times <= end)]
    return float(line.damages(rainflow(inside, "repeat")).sum()) / (end - begin)


def allowed_cycles(damage: float, rate: float, up_time: float, life: float) -> float | None:
    """Number of cycles until the part fails just at the end of its target life, in which the run-ups are counted.

    n (damage - rate up_time) + rate life = 1: what a cycle damages more than operation of the same time. None where that is
    nothing, so that any number is allowed; 0 where operation alone is too much.
    """
    left, extra = 1 - rate * life, damage - rate * up_time
    if left <= 0:
        return 0.0
    return left / extra if extra > 0 else None


def _course_quantities(plan: Plan, runs: list[LoadedRun], courses: list[MotionCourse]) -> list[Quantity]:
    units, offsets = plan.machine.units, [0.0, runs[0].trajectory.end_time]
    amplitude = np.concatenate([c.amplitude for c in courses])
    times = np.concatenate([course.time + offset for course, offset in zip(courses, offsets, strict=False)])
    return [
        Quantity("time", times, "time", units.time, "time"),
        Quantity("rotor", [r.name for r in plan.machine.rotors], "rotor", "", "rotor"),
        Quantity("rotor_speed", np.concatenate([c.speeds for c in courses], axis=1), "speed", units.speed, "rotor time"),
        Quantity("amplitude", amplitude, "amplitude of the axis", plan.machine.orbit_unit, "time"),
    ]  # fmt: skip


def _sentence(plan: Plan, findings: Findings) -> str:
    up, down = findings.up, findings.down
    unit = f" {plan.machine.units.time}" if plan.machine.units.time else ""
    beginning = f"up: {up.verdict.sentence}"
    if down is None:
        return beginning
    duration = f"{down.trajectory.end_time:.4g}{unit}"
    if down.trajectory.stopped_by == SLOW_EVENT:
        return f"{beginning}; down in {duration}"
    return f"{beginning}; down: {down.verdict.outcome.sentence} after {duration}"


def _assumptions(plan: Plan) -> list[str]:
    bare = [d.on for d in drives_without_circuit(plan.case.machine)]
    if not bare:
        return []
    return [f"the energy from the supply is the work on the shaft of {' and '.join(bare)}, whose torque alone is known"]


def _warnings(plan: Plan, findings: Findings, failure: str | None) -> list[str]:
    up, verdict = findings.up, findings.up.verdict
    warnings = [*([failure] if failure else []), *up.case.horizon.warnings, *up.case.models[0].warnings]
    if verdict.advice:
        warnings.append(f"at the switch-off the machine does not run steadily yet: {verdict.advice}")
    if any(s for s in plan.machine.schedules if SCHEDULE_WORK in up.trajectory.quadratures):
        warnings.append("schedules end at the switch-off: on its way down the machine keeps the values that they have then")
    if plan.line is not None and plan.spec.target_life is not None and operation_damage(plan, up) is None:
        warnings.append("the damage of operation is not known, nor how many cycles the target life allows: run longer")
    return warnings


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a cycle."""
    s, lines = result.wucht.summary, ReportLines(result)
    there = {key: f", at {{{key}}}" if s[key] is not None else "" for key in ("peak_speed_up", "peak_speed_down")}
    if s["peak_amplitude_up"]:
        lines.add("up", "{peak_amplitude_up} at most" + there["peak_speed_up"])
    lines.add("operation", "{operating_amplitude} at {operating_speed}; switched off at {switch_off_time:.4g}")
    if s["peak_amplitude_down"]:
        lines.add("down", "{peak_amplitude_down} at most" + there["peak_speed_down"])
    lines.add("bearings", "{forces} at most, of each rotor on the carrier", forces=_largest(s["bearing_forces"], lines, "N"))
    if s["mount_travel"]:
        lines.add("travel", "{travels} at most from rest", travels=_largest(s["mount_travel"], lines, "m"))
    lines.add("energy", "{energy} from the supply, {shaft_work} of it as work on the shafts")
    if s["damage"] is not None:
        lines.add("damage", "{damage:.4g} a cycle" + ("" if s["cycles"] is None else "; the part endures {cycles:.4g} cycles"))
        lines.add("in operation", "damage {operation_damage:.4g}")
    if s.get("target_life") is not None and s["operation_damage"] is not None and s["damage"] is not None:
        number = "any number of" if s["allowed_cycles"] is None else f"{math.floor(s['allowed_cycles']):.6g}"
        lines.add("target life", f"{{life}} of operation allow {number} cycles", life=_life(s["target_life"]))
    return lines.report(s["sentence"])


def _largest(values: Mapping[str, float], lines: ReportLines, unit: str) -> str:
    entries: list[Any] = [f"{name} {lines.format_value(value, unit)}" for name, value in values.items()]
    return ", ".join(entries)


def _life(seconds: float) -> str:
    return f"{seconds / 3600:.5g} h" if seconds >= 3600 else f"{seconds:.4g} s"
