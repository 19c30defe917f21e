"""Findings -> the quantities of a voltage dip, and its lines in a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.settled_operation import NO_OPERATION, NOT_TURNING
from wucht.dynamics.run_ups.voltage_dips import Dip, LastingDip
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, StudyResult, table
from wucht.results.starting_text import add_starting_line
from wucht.studies.starting_variables import not_started_statement, starting_quantities
from wucht.studies.voltage_dip.computation import Findings, Plan

if TYPE_CHECKING:
    import xarray as xr

_LONGEST_RETURN, _SHORTEST_LOSS, _SINGLE = "longest dip with a return", "shortest dip without", "dip of the given duration"
_MOST_WARNINGS = 3


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a voltage dip."""
    draft = StudyResult(
        [
            *_operation_quantities(plan, findings),
            *_critical_quantities(plan, findings),
            *_dip_quantities(plan, findings),
            *_course_quantities(plan, findings),
            *starting_quantities(plan.machine.at(plan.machine.breakpoints[-1])),
        ],
        "",
    )
    failure = next((d.failure for d in findings.critical.dips if d.failure), None) or (
        None if findings.lasting is None else findings.lasting.failure
    )
    warnings = [*_warnings(plan, findings), *([failure] if failure else [])]
    return replace(
        draft, sentence=_sentence(plan, findings), warnings=warnings,
        assumptions=_assumptions(plan, findings), attributes={"outcome": str(draft.summary["outcome"])},
    ).to_dataset()  # fmt: skip


def _operation_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the operating state, and the voltages that dip."""
    machine, end = plan.machine, findings.operation.end
    share = {path.removesuffix(".voltage"): (1 - plan.spec.depth) * u for path, u in plan.voltages.items()}
    full = {path.removesuffix(".voltage"): u for path, u in plan.voltages.items()}
    return [
        Quantity("operating_outcome", end.outcome, "outcome in operation"),
        Quantity("operating_speed", end.speed, "mean speed of the main rotor in operation", machine.units.speed, headline=True),
        Quantity("operating_amplitude", end.amplitude, "amplitude of the axis in operation", machine.orbit_unit),
        Quantity("voltages", full, "voltage of each drive in operation", "V"),
        Quantity("dip_voltages", share, "voltage of each drive in the dip", "V"),
    ]


def _critical_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the critical duration and what lies beyond it, the single dip, and the motion at the low voltage."""
    units, critical = plan.machine.units, findings.critical
    last, loss, lasting = critical.longest_return, critical.shortest_loss, findings.lasting
    is_bracketed = findings.is_complete and loss is not None
    speed = units.speed
    parts = _dip_parts(plan)
    lasting_row = lasting and {
        "outcome": lasting.end.outcome, "speed": lasting.end.speed, "time": lasting.end.end, "settled": lasting.is_settled,
    }  # fmt: skip
    lasting_parts = {
        "outcome": ("outcome at the low voltage", ""), "speed": ("mean speed of the main rotor there", speed),
        "time": ("time at the low voltage until then", units.time), "settled": ("whether the machine has settled there", ""),
    }  # fmt: skip
    duration = last.duration if last is not None and is_bracketed else None
    again = [d.duration for d in critical.later_returns]
    fall = last.speed_at_recovery if last is not None and is_bracketed else None
    return [
        Quantity("outcome", _outcome(findings), "outcome after the dip", headline=True),
        Quantity(
            "critical_duration", duration, "longest dip after which the machine returns by itself", units.time, headline=True
        ),
        Quantity("critical_speed", fall, "speed of the main rotor at the end of that dip", speed, headline=True),
        Quantity("beyond", loss and _row(loss), "shortest dip after which it does not return", parts=parts),
        Quantity("dip", findings.single and _row(findings.single), "dip of the given duration", parts=parts),
        Quantity("lasting", lasting_row, "motion while the voltage stays low", parts=lasting_parts),
        Quantity("later_returns", again, "longer dips that were tried after which it returns again", units.time),
        Quantity("depth", plan.spec.depth, "share of the voltage that is lost"),
    ]


def _outcome(findings: Findings) -> str:
    """Return the outcome of the single dip, else of the shortest after which the machine does not return, else that of all."""
    loss = findings.critical.shortest_loss
    if findings.single is not None:
        return findings.single.end.outcome
    return findings.operation.end.outcome if loss is None else loss.end.outcome


def _row(dip: Dip) -> dict[str, Any]:
    return {
        "duration": dip.duration, "outcome": dip.end.outcome, "speed": dip.end.speed, "returns": dip.is_return,
        "speed_at_recovery": dip.speed_at_recovery, "recovery_time": dip.recovery_time,
        "peak_amplitude": dip.peak_amplitude,
    }  # fmt: skip


def _dip_parts(plan: Plan) -> dict[str, tuple[str, str]]:
    units = plan.machine.units
    return {
        "duration": ("duration of the dip", units.time), "outcome": ("outcome after the dip", ""),
        "speed": ("speed at the end", units.speed), "returns": ("whether the machine returns to operation", ""),
        "speed_at_recovery": ("speed when the voltage returns", units.speed),
        "recovery_time": ("time from then until speed and vibration have settled", units.time),
        "peak_amplitude": ("largest amplitude of the axis in the dip and after it", plan.machine.orbit_unit),
    }  # fmt: skip


def _dip_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return all dips that were tried."""
    columns = {
        "duration": float, "outcome": str, "speed": float, "returns": np.int8, "speed_at_recovery": float,
        "recovery_time": float, "peak_amplitude": float,
    }  # fmt: skip
    rows = [_row(d) for d in findings.critical.dips]
    return table("dips", rows, "dips that were tried", _dip_parts(plan), "dip", columns)


def _course_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the motion before, in and after the dips at the border, and the single one; nan where one ends early."""
    critical, units, before = findings.critical, plan.machine.units, findings.operation.course
    last, loss = critical.longest_return, critical.shortest_loss
    dips = [(_SINGLE, findings.single), (_LONGEST_RETURN, last), (_SHORTEST_LOSS, loss)]
    chosen = [(label, d) for label, d in dips if d is not None and (label == _SINGLE or d is not findings.single)]
    courses = [MotionCourse.join([before, d.course]) for _, d in chosen] or [before]
    longest, rotors = max(len(c.time) for c in courses), [r.name for r in plan.machine.rotors]

    def stack(arrays: Sequence[np.ndarray]) -> np.ndarray:
        widths = [[(0, 0)] * (a.ndim - 1) + [(0, longest - a.shape[-1])] for a in arrays]
        return np.array([np.pad(a, w, constant_values=np.nan) for a, w in zip(arrays, widths, strict=True)])

    amplitude, labels = stack([c.amplitude for c in courses]), [label for label, _ in chosen] or ["operation"]
    durations = np.array([d.duration for _, d in chosen] or [np.nan])
    return [
        Quantity("course", np.array(labels, str), "motion", "", "course", coordinate=True),
        Quantity("rotor", np.array(rotors, str), "rotor", "", "rotor", coordinate=True),
        Quantity("course_duration", durations, "duration of the dip", units.time, "course"),
        Quantity(
            "time", stack([c.time for c in courses]), "time since the dip begins", units.time, "course row", coordinate=True
        ),
        Quantity("speed", stack([np.abs(c.speeds) for c in courses]), "speed", units.speed, "course rotor row"),
        Quantity("amplitude", amplitude, "amplitude of the axis", plan.machine.orbit_unit, "course row"),
    ]  # fmt: skip


def _sentence(plan: Plan, findings: Findings) -> str:
    """Return the critical duration in words, or why there is none."""
    operation, critical, units = findings.operation.end, findings.critical, plan.machine.units
    if operation.outcome in NO_OPERATION:
        return f"the machine does not reach a state of operation: {next(o for o in Outcome if o == operation.outcome).sentence}"
    if findings.lasting is None or not critical.dips:
        return "not determined yet"
    last, loss = critical.longest_return, critical.shortest_loss
    loss_share = "all" if plan.spec.depth == 1 else f"{100 * plan.spec.depth:.4g} % of the"
    returns = f"with {loss_share} voltage lost, the machine returns by itself after"
    if loss is None:
        return f"{returns} {_all_dips(plan, findings.lasting, critical.dips[-1].duration)}"
    stops = loss.end.outcome in (Outcome.STOPPED, Outcome.NOT_STARTED)
    end = f"after {loss.duration:.4g} {units.time}: {loss.end.outcome}"
    end += "" if stops else f", at {loss.end.speed:.4g} {units.speed}"
    if last is None:
        return f"{returns} none of the dips that were tried; {end}"
    return f"{returns} {'dips of up to' if findings.is_complete else 'a dip of'} {last.duration:.4g} {units.time}; {end}"


def _all_dips(plan: Plan, lasting: LastingDip, longest: float) -> str:
    """Return the dips after all of which the machine returns, in words. longest: that was tried."""
    units, limits = plan.machine.units, plan.spec.limits
    if limits is not None:
        return f"every dip of {limits[0]:.4g} to {limits[1]:.4g} {units.time}"
    if not lasting.is_settled:
        return f"all dips that were tried, up to {longest:.4g} {units.time}"
    if lasting.end.outcome == Outcome.STOPPED:
        return "every dip, however long: it stops, and starts again"
    return f"every dip, however long: it settles at {lasting.end.speed:.4g} {units.speed}, and returns from there"


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    operation, critical, unit = findings.operation.end, findings.critical, plan.machine.units.time
    ends = [operation, *(d.end for d in critical.dips), *([] if findings.lasting is None else [findings.lasting.end])]
    is_stopped = findings.operation.working_point is None and any(end.outcome in NOT_TURNING for end in ends)
    statement = not_started_statement(plan.machine) if is_stopped else ""
    warnings = [statement] if statement else []
    if operation.outcome in NO_OPERATION:
        return [*warnings, *([operation.advice] if operation.advice else [])]
    if again := critical.later_returns:
        warnings.append(
            f"after longer dips the machine returns again: of those that were tried, after {len(again)} from "
            f"{again[0].duration:.4g} to {again[-1].duration:.4g} {unit}"
        )
    open_dips = [d for d in critical.dips if d.end.outcome == Outcome.UNIDENTIFIED]
    warnings += [
        f"no verdict after a dip of {d.duration:.4g} {unit}, taken as no return: {d.end.advice}"
        for d in open_dips[:_MOST_WARNINGS]
    ]
    return warnings


def _assumptions(plan: Plan, findings: Findings) -> list[str]:
    """Return the operating state, and what a dip is, as statements."""
    speed, units = findings.operation.working_point, plan.machine.units
    origin = "the machine has settled after a run-up from the start"
    if speed is not None:
        reason = not_started_statement(plan.machine)
        origin = f"the machine does not start by itself{reason and f' ({reason})'}, and has settled at its stable working point"
        origin += f", {speed:.5g} {units.speed}"
    return [origin, "motors keep their steady characteristics in the dip, at the voltage that is left"]


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a voltage dip."""
    s, lines = result.wucht.summary, ReportLines(result)
    amplitude = "" if not s["operating_amplitude"] else ", amplitude {operating_amplitude}"
    lines.add("operation", f"{s['operating_outcome']}, {{operating_speed}}{amplitude}")
    lines.add("voltage", "{depth:%} lost; left: {dip_voltages:.4g}")
    lines.add("critical", "{critical_duration:.4g}, to 1 %; the speed is then {critical_speed}")
    for heading, key in (("dip", "dip"), ("beyond", "beyond")):
        if (row := s[key]) is None:
            continue
        settled = "" if row["recovery_time"] is None else "; settled {recovery_time:.3g} after the voltage is back"
        peak = "" if not row["peak_amplitude"] else "; amplitude {peak_amplitude} at most"
        verdict = "returns" if row["returns"] else f"does not return: {row['outcome']}, {{speed}}"
        lines.add(heading, f"{{duration:.4g}}: {verdict}, from {{speed_at_recovery}}{settled}{peak}", row, key)
    if s["lasting"] is not None:
        after = "after {lasting.time:.4g}" if s["lasting"]["settled"] else "not settled after {lasting.time:.4g}"
        lines.add("low voltage", f"{s['lasting']['outcome']}, {{lasting.speed}}, {after}")
    add_starting_line(lines, s)
    lines.add("dips", f"{len(s['dips'])} tried, {sum(row['returns'] for row in s['dips'])} with a return")
    return lines.report(result.wucht.sentence)
