"""Findings -> the state before the failure, the cases after it, their courses, and the lines of the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.drive_losses import RunningState
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.machines.machine import Machine
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.drive_failure.computation import Findings, OperationRun, Plan

if TYPE_CHECKING:
    import xarray as xr

_TOGETHER = str(Outcome.SYNCHRONISED)
_OPEN_OUTCOMES = (str(Outcome.UNIDENTIFIED), str(Outcome.FAILED))


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset: variables with the dimension ``case``, a failure each."""
    runs = [(o, _state_of(plan, o.motion)) for o in findings.operations]
    cases = [_Case.of(plan, o, k, s.torques) for o, s in runs for k in range(len(o.failures))]
    rows = [case.row for case in cases]
    quantities = [
        *table("cases", rows, "the machine after each failure", _parts(plan.machine), "case", {"drive": str, "outcome": str}),
        Quantity("operation", [_row(o, s) for o, s in runs], "the machine before a failure", parts=_parts(plan.machine)),
        Quantity(
            "failure_times",
            [o.motion.trajectory.end_time for o, _ in runs],
            "time of the failure in each operation",
            plan.machine.units.time,
        ),
        *(_course_quantities(plan.machine, cases) if cases else []),
    ]
    failures = [m.trajectory.failure for o in findings.operations for m in (o.motion, *(f.motion for f in o.failures))]
    failure = next((f for f in failures if f), None)
    warnings = _warnings(plan, findings, runs, rows)
    outcomes = {row["outcome"] for row in rows}
    outcome = next(iter(outcomes)) if len(outcomes) == 1 else "several" if outcomes else ""
    return result_dataset(quantities, _sentence(rows), warnings, _assumptions(plan), failure, outcome=outcome)


def _state_of(plan: Plan, motion: Motion) -> RunningState:
    return RunningState.of(motion, plan.drives)


@dataclass(frozen=True)
class _Case:
    """A failure: its row in the summary, the courses until and after it, and the state before it."""

    row: dict[str, Any]
    before: MotionCourse
    after: MotionCourse
    failure_time: float
    torques_before: dict[str, float]

    @classmethod
    def of(cls, plan: Plan, operation: OperationRun, index: int, torques_before: dict[str, float]) -> _Case:
        failure = operation.failures[index]
        before, after = operation.motion, failure.motion
        row = {"drive": failure.drive.on, **_row(operation, _state_of(plan, after), after)}
        first, second = (MotionCourse.from_turns(m.case.machine, m.trajectory, m.observation) for m in (before, after))
        return cls(row, first, second, before.trajectory.end_time, torques_before)


def _row(operation: OperationRun, state: RunningState, after: Motion | None = None) -> dict[str, Any]:
    """The entry of a state in the summary. after: the motion after a failure, None before it."""
    throw, main = state.throw, operation.motion.case.machine.rotor.name
    row: dict[str, Any] = {
        "configuration": operation.plan.label or None,
        "outcome": str(state.outcome),
        "phases": state.phases,
        "throw": None if throw is None else throw.stroke,
        "throw_direction": None if throw is None else throw.numbers["throw_direction"],
        "amplitude": state.amplitude,
        "torques": state.torques,
        "speed": abs(state.speeds[main]) if state.outcome is Outcome.SYNCHRONISED else None,
        "speeds": state.speeds,
    }
    if after is None:
        return row
    verdict = after.verdict
    return row | {
        "peak_amplitude": after.observation.largest, "sentence": state.sentence, "end_time": after.trajectory.end_time,
        "advice": verdict.advice, "advised_time": verdict.needed_time,
    }  # fmt: skip


def _parts(machine: Machine) -> dict[str, tuple[str, str]]:
    units, orbit = machine.units, machine.orbit_unit
    return {
        "drive": ("rotor whose drive fails", ""),
        "configuration": ("configuration in which the rotors run before", ""),
        "outcome": ("outcome", ""),
        "phases": ("mean phases of the other rotors to the main one, and of the bodies to their rotor", "rad"),
        "throw": ("peak to peak of the centre of mass in the direction of its largest motion", units.length),
        "throw_direction": ("direction of the largest motion, from +x", "rad"),
        "amplitude": ("largest amplitude of the axis at the end", orbit),
        "torques": ("mean torque of each drive at the end", units.torque),
        "speed": ("common speed of the rotors", units.speed),
        "speeds": ("mean speeds of the rotors", units.speed),
        "peak_amplitude": ("largest amplitude of the axis after the failure", orbit),
        "sentence": ("outcome in words", ""),
        "end_time": ("time after the failure at the end", units.time),
        "advice": ("advice", ""),
        "advised_time": ("sufficient time after the failure", units.time),
    }


def _course_quantities(machine: Machine, cases: Sequence[_Case]) -> list[Quantity]:
    """Variables (case, rotor, sample) over the time from the failure on; before it that is negative."""
    pairs = [(_before(case), case.after) for case in cases]
    count = max(len(before.time) + len(after.time) for before, after in pairs)

    def pad(values: np.ndarray) -> np.ndarray:
        return np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, count - values.shape[-1])], constant_values=np.nan)

    times = [
        pad(np.append(before.time - case.failure_time, after.time)) for case, (before, after) in zip(cases, pairs, strict=True)
    ]
    speeds = [pad(np.append(before.speeds, after.speeds, axis=1)) for before, after in pairs]
    amplitudes = [pad(np.append(before.amplitude, after.amplitude)) for before, after in pairs]
    units, drives = machine.units, list(cases[0].row["torques"])
    before_failure, after_failure = ([[torques[d] for d in drives] for torques in of] for of in zip(
        *((case.torques_before, case.row["torques"]) for case in cases), strict=True
    ))  # fmt: skip
    return [
        Quantity("drive", drives, "rotor with a drive", "", "drive"),
        Quantity("drive_torque", after_failure, "mean torque", units.torque, "case drive"),
        Quantity("operation_torque", before_failure, "mean torque before the failure", units.torque, "case drive"),
        Quantity("rotor", [r.name for r in machine.rotors], "rotor", "", "rotor"),
        Quantity("time", np.array(times), "time after the failure", units.time, "case sample", coordinate=True),
        Quantity("rotor_speed", np.array(speeds), "speed", units.speed, "case rotor sample"),
        Quantity("amplitude", np.array(amplitudes), "amplitude of the axis", machine.orbit_unit, "case sample"),
    ]


_SHARE_BEFORE = 0.25  # of the time after the failure: so much of that before it is drawn


def _before(case: _Case) -> MotionCourse:
    """The last part of the course until the failure."""
    return case.before.within(case.failure_time - _SHARE_BEFORE * float(case.after.time[-1]), case.failure_time)


def _sentence(rows: Sequence[Mapping[str, Any]]) -> str:
    if not rows:
        return "no drive has failed yet"
    open_rows = [row for row in rows if row["outcome"] in _OPEN_OUTCOMES]
    lost_rows = [row for row in rows if row["outcome"] != _TOGETHER and row not in open_rows]
    locked_rows = [row for row in rows if row["outcome"] == _TOGETHER]
    if len(locked_rows) == len(rows):
        return f"the rotors stay synchronised whichever {'drive' if len(rows) > 1 else 'of the drives'} fails"
    clauses = [f"the rotors stay synchronised without the drive of {_listing(locked_rows)}"] if locked_rows else []
    if lost_rows:
        loss = "not synchronised without that" if locked_rows else "the rotors are not synchronised any more without the drive"
        clauses.append(f"{loss} of {_listing(lost_rows)}")
    clauses += [f"undecided without that of {_listing(open_rows)}"] if open_rows else []
    return "; ".join(clauses)


def _listing(rows: Sequence[Mapping[str, Any]]) -> str:
    return " or ".join(dict.fromkeys(str(row["drive"]) for row in rows))


def _assumptions(plan: Plan) -> list[str]:
    labels = [o.label for o in plan.operations if o.label]
    if not labels:
        return ["the machine is run up from rest, at the phases of the start"]
    several = "each of the stable synchronous configurations" if len(labels) > 1 else "the stable synchronous configuration"
    return [f"the machine begins in {several} {' and '.join(labels)} (averaged equations)"]


def _warnings(
    plan: Plan, findings: Findings, runs: Sequence[tuple[OperationRun, RunningState]], rows: Sequence[Mapping[str, Any]]
) -> list[str]:
    motions = [m for o in findings.operations for m in (o.motion, *(f.motion for f in o.failures))]
    warnings = [m.trajectory.failure for m in motions if m.trajectory.failure]
    if plan.reason:
        warnings.append(f"the machine is run up from rest: {plan.reason}")
    warnings += [f"the carrier begins at rest: the machine {o.rest_reason}" for o in plan.operations if o.rest_reason]
    for operation, state in runs:
        if operation.failures and state.outcome is not Outcome.SYNCHRONISED:
            label = f" ({operation.plan.label})" if operation.plan.label else ""
            advice = f": {operation.motion.verdict.advice}" if operation.motion.verdict.advice else ""
            warnings.append(f"before the failure{label} the verdict on the machine is {state.outcome}{advice}")
    warnings += [f"without {row['drive']}: {row['advice']}" for row in rows if row["advice"]]
    total = len(plan.operations) * len(plan.drives)
    if findings.finished_count < total:
        warnings.append(f"{findings.finished_count} of {total} failures are computed")
    return list(dict.fromkeys(warnings))


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for the failure of drives."""
    s, lines = result.wucht.summary, ReportLines(result)
    labels = [o["configuration"] for o in s["operation"]]
    for state, time in zip(s["operation"], s["failure_times"], strict=True):
        lines.add("before", _text(state, "{amplitude}"), state, "operation", at=_at(state))
        failure_time = lines.format_value(time, "s", ".4g") or ""
        lines.add("motors", "{torques}; a drive fails at {time}", state, "operation", time=failure_time)
        for row in (r for r in s["cases"] if r["configuration"] == state["configuration"]):
            several = f" ({row['configuration']})" if len(labels) > 1 else ""
            lines.add(f"without {row['drive']}", f"{row['outcome'].upper()}{several}: {_text(row, '{peak_amplitude} at most')}",
                      row, "cases", at=_at(row))  # fmt: skip
            lines.add("motors", "{torques}", row, "cases")
    return lines.report(s["sentence"])


def _text(row: Mapping[str, Any], amplitude: str) -> str:
    throw = "" if row["throw"] is None else "throw {throw}{at}, "
    speed = "{speeds}; " if row["speed"] is None else "{speed}, "
    return f"{speed}{throw}amplitude {amplitude}"


def _at(row: Mapping[str, Any]) -> str:
    direction = "" if row["throw_direction"] is None else f" at {math.degrees(row['throw_direction']):.1f}°"
    if row["phases"] is None:
        return direction
    angles = (f"{name} {math.degrees(math.remainder(phase, 2 * math.pi)):.4g}°" for name, phase in row["phases"].items())
    return f"{direction}, phase {', '.join(angles)}"
