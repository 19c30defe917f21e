"""Each drive in turn loses its supply in operation; are the rotors still synchronised?"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from wucht.analysis.synchronising_torque import SynchronisationMargin, has_exciters
from wucht.dynamics.run_ups.drive_losses import RunningState, check_drives
from wucht.dynamics.run_ups.horizon import RunSettings, numbers_per_sample
from wucht.dynamics.run_ups.operating_state import OperationCase, cases_in_operation, machine_in_operation
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.scenarios.drive_failures import DrivenRun, OperationRun, failures_in_turn
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.several_runs import draw_runs
from wucht.plots.sheet import draw_panels, legend_beside
from wucht.plots.style import BAR_STYLES, COLOURS, line_style
from wucht.results.formatting import abscissa_label, label
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer, Column
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Start, Tolerance
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import FULL_EQUATIONS, Study
from wucht.studies.synchronisation_variables import margin_in_words, synchronisation_columns

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHARE_BEFORE = 0.25  # of the time after the failure: so much of that before it is drawn
_MOST_CASES = 6  # with a panel of their own
_TOLERANCE, _LONGER, _LEAST, _BEFORE = (
    0.01,
    2.0,
    0.05,
    0.15,
)  # of final values; times that time; shares of the whole, and before
_FAILURE: dict[str, Any] = {"color": "black", "linestyle": "--", "linewidth": 0.9}

Prepared = tuple[
    tuple[OperationCase, ...], str
]  # and why the machine is run up from rest, empty where it is not or as requested
Case = tuple[OperationRun, str, DrivenRun]  # the operation before, the body of the drive that fails, and the run without it


class DriveFailure(Study):
    """Let each drive in turn lose its supply in operation, and see whether the rotors stay synchronised.

    The drive that fails gives no torque, and does not brake: its rotor turns on as the vibration carries it along, or stops.
    """

    kind = "drive-failure"
    next_questions = (
        NextQuestion("all steady phases, and which of them are stable", {"study.kind": "synchronous-states"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    horizon = ("until",)
    solves = FULL_EQUATIONS

    time: SI[float | None] = si("s", "time of the failure", default=None, gt=0, help=(
        "time at which a drive loses its supply, from the start on; by default as soon as the machine runs steadily"
    ))  # fmt: skip
    until: SI[float | None] = si("s", "time after the failure", default=None, gt=0, help=(
        "time after the failure at which the run ends; by default when the machine has settled"
    ))  # fmt: skip
    begin: Literal["operation", "rest"] | None = Field(default=None, description=(
        'state at t = 0: `"operation"`, each stable synchronous configuration of the rotors; or `"rest"`, from which the '
        "drives run the machine up at the phases of `start`. By default in operation if these configurations are known"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict, description=(
        "phases of rotors and bodies: in operation they select the nearest stable configuration, at rest they are the initial "
        "state"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def turning(self) -> str:
        """See ``Study``."""
        return "driven by their motors, of which one loses its supply"

    def prepare(self, machine: Machine, watch: Callable[[], None] | None = None) -> Prepared:
        """Return the runs until the failure, one for each configuration, or one from rest and the reason.

        watch: called often. Raises ``InputError`` where fewer than two rotors are driven, and where the start does not fit the
        machine.
        """
        check_drives(machine)
        driven, settings, reason = machine_in_operation(machine), self._settings(self.time), ""
        if self.begin != "rest":
            reason = "no synchronous configuration of the rotors is stable"
            try:
                cases = cases_in_operation(machine, self.start, settings, watch)
            except InputError as error:
                if error.key.startswith("study.start"):
                    raise
                cases, reason = (), error.explanation
            if cases:
                return cases, ""
            if self.begin == "operation":
                remedy = "study.begin = 'rest' runs the machine up at the phases of study.start"
                explanation = f"not possible here: {reason}; {remedy}"
                raise InputError("study.begin", self.begin, explanation, code="no-stable-phases")
        return (OperationCase(RunUpCase.of(driven, self.start, settings)),), reason

    def _settings(self, until: float | None) -> RunSettings:
        return RunSettings(until=until, tolerance=self.tolerance, engine=self.engine)

    def stored_numbers(self, prepared: Prepared) -> float:
        """Bound the count of stored numbers: two runs at a time, and the state after each."""
        first = prepared[0][0].case
        return 2 * first.horizon.samples * numbers_per_sample(first.machine)

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Integrate the runs, and answer after each leg."""
        for runs in failures_in_turn(prepared[0], self._settings(self.until), work):
            yield Answer(machine.units, partial(_fill, machine, prepared, runs))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw a panel of speeds for each case, the amplitudes, and the mean torques."""
        if not result.sizes.get("case"):
            return draw_panels(result, [_nothing])[0]
        count = min(result.sizes["case"], _MOST_CASES)
        panels: list[Callable[[Axes, Any], None]] = [partial(_speeds, k) for k in range(count)]
        fig, axes = draw_panels(
            result, [*panels, _amplitudes, _torques], legend_beside,
            columns=1, heights=1.5,
        )  # fmt: skip
        for axis in axes[1:-1]:
            axis.sharex(axes[0])
        axes[0].set_xlim(*_limits(result))
        for axis in axes[:-2]:
            axis.tick_params(labelbottom=False)
        axes[-2].set_xlabel(abscissa_label(result, "time"))
        return fig


def _fill(machine: Machine, prepared: Prepared, runs: Sequence[OperationRun], a: Answer) -> None:
    operations, reason = prepared
    cases = [(before, drive, run) for before in runs for drive, run in before.failures.items()]
    _state_operations(a, machine, runs, cases)
    if cases:
        _state_courses(a, machine, cases)
    outcomes = {str(run.state.outcome) for _, _, run in cases}
    a.attribute(outcome=next(iter(outcomes)) if len(outcomes) == 1 else "several" if outcomes else "")
    a.sentence = _sentence(cases)
    failures = [m.trajectory.failure for one in runs for m in one.motions if m.trajectory.failure]
    a.failure = next(iter(failures), None)
    warnings = [*failures, *([f"the machine is run up from rest: {reason}"] if reason else [])]
    warnings += [f"the carrier begins at rest: the machine {o.rest_reason}" for o in operations if o.rest_reason]
    for one in runs:
        advice, outcome = one.before.motion.verdict.advice, one.before.state.outcome
        if one.failures and outcome is not Outcome.SYNCHRONISED:
            configuration = f" ({one.operation.label})" if one.operation.label else ""
            before = f"before the failure{configuration} the verdict on the machine is {outcome}"
            warnings.append(f"{before}: {advice}" if advice else before)
    warnings += [f"without {drive}: {v.advice}" for _, drive, run in cases if (v := run.motion.verdict).advice]
    finished_count, total = sum(one.finished_count for one in runs), sum(len(o.case.machine.drives) for o in operations)
    if finished_count < total:
        warnings.append(f"{finished_count} of {total} failures are computed")
    a.warn(*dict.fromkeys(warnings))
    labels = [o.label for o in operations if o.label]
    several = "each of the stable synchronous configurations" if len(labels) > 1 else "the stable synchronous configuration"
    begin = f"the machine begins in {several} {' and '.join(labels)} (averaged equations)"
    a.assume(begin if labels else "the machine is run up from rest, at the phases of the start")


def _state_operations(a: Answer, machine: Machine, runs: Sequence[OperationRun], cases: Sequence[Case]) -> None:
    """State how the machine runs before the failures and after each, with a line for each."""
    orbit, after, margins = machine.orbit_unit, [run for _, _, run in cases], [_margin(*case) for case in cases]
    columns = {
        "drive": ([drive for _, drive, _ in cases], "rotor whose drive fails"),
        **_state_columns(machine, [one for one, _, _ in cases], after),
        "peak_amplitude": (
            [run.motion.observation.largest for run in after], "largest amplitude of the axis after the failure", orbit
        ),
        "sentence": ([run.state.sentence for run in after], "outcome in words"),
        "end_time": ([run.motion.trajectory.end_time for run in after], "time after the failure at the end", "time"),
        "advice": ([run.motion.verdict.advice for run in after], "advice"),
        "advised_time": ([run.motion.verdict.needed_time for run in after], "sufficient time after the failure", "time"),
        **(synchronisation_columns(margins) if has_exciters(machine) else {}),
    }  # fmt: skip
    a.table("cases", "the machine after each failure", "case", {"drive": str, "outcome": str}, **columns)
    parts = {name: (words, a.unit(*unit)) for name, (_, words, *unit) in columns.items()}
    before = _state_columns(machine, runs, [one.before for one in runs])
    rows = [{name: values[i] for name, (values, *_) in before.items()} for i in range(len(runs))]
    a.number("operation", rows, "the machine before a failure", parts=parts)
    times = [one.before.motion.trajectory.end_time for one in runs]
    a.number("failure_times", times, "time of the failure in each operation", "time")
    for i, one in enumerate(runs):
        a.line("before", _state_text(one.before.state, "{amplitude}"), at=f"operation[{i}]")
        a.line("motors", f"{{operation[{i}].torques}}; a drive fails at {{failure_times[{i}]:.4g}}")
        several = f" ({one.operation.label})" if len(runs) > 1 else ""
        for k, (case_operation, drive, run) in enumerate(cases):
            if case_operation is one:
                text = f"{str(run.state.outcome).upper()}{several}: {_state_text(run.state, '{peak_amplitude} at most')}"
                a.line(f"without {drive}", text, at=f"cases[{k}]")
                a.line("motors", "{torques}", at=f"cases[{k}]")
                if (margin := margins[k]) is not None:
                    a.line("dragged", margin_in_words(margin), at=f"cases[{k}]")


def _margin(one: OperationRun, drive: str, _: DrivenRun) -> SynchronisationMargin | None:
    """Return the margin with which the vibration drags the rotor of a drive along; None if the rotors did not synchronise."""
    machine, before = one.operation.case.machine, one.before.state
    if before.phases is None:
        return None
    return SynchronisationMargin.without_drive(machine, drive, before.speeds[machine.rotor.name], before.phases)


def _state_columns(machine: Machine, operations: Sequence[OperationRun], runs: Sequence[DrivenRun]) -> dict[str, Column]:
    """Return the states at the end of runs, as columns of a table. operations: to which they belong."""
    states, main = [run.state for run in runs], machine.rotor.name
    return {
        "configuration": (
            [one.operation.label or None for one in operations],
            "configuration in which the rotors run before",
        ),
        "outcome": ([str(s.outcome) for s in states], "outcome"),
        "phases": (
            [s.phases for s in states],
            "mean phases of the other rotors to the main one, and of the bodies to their rotor",
            "rad",
        ),
        "throw": (
            [s.throw and s.throw.stroke for s in states],
            "peak to peak of the centre of mass in the direction of its largest motion",
            "length",
        ),
        "throw_direction": (
            [s.throw and s.throw.numbers["throw_direction"] for s in states],
            "direction of the largest motion, from +x",
            "rad",
        ),
        "amplitude": ([s.amplitude for s in states], "largest amplitude of the axis at the end", machine.orbit_unit),
        "torques": ([s.torques for s in states], "mean torque of each drive at the end", "torque"),
        "speed": (
            [abs(s.speeds[main]) if s.outcome is Outcome.SYNCHRONISED else None for s in states],
            "common speed of the rotors",
            "speed",
        ),
        "speeds": ([s.speeds for s in states], "mean speeds of the rotors", "speed"),
    }


def _state_text(state: RunningState, amplitude: str) -> str:
    """Return a state as the text of a line."""
    speed = "{speed}, " if state.outcome is Outcome.SYNCHRONISED else "{speeds}; "
    throw, phases = "", ""
    if state.throw is not None:
        direction = state.throw.numbers["throw_direction"]
        throw = f"throw {{throw}}{'' if direction is None else f' at {math.degrees(direction):.1f}°'}"
    if state.phases is not None:
        angles = (f"{name} {math.degrees(x) % 360:.4g}°" for name, x in state.phases.items())
        phases = f", phase {', '.join(angles)}"
    return f"{speed}{f'{throw}{phases}, ' if throw else ''}amplitude {amplitude}"


def _state_courses(a: Answer, machine: Machine, cases: Sequence[Case]) -> None:
    """State torques, and the courses over the time from the failure on; before it that is negative."""
    times, speeds, amplitudes = list[np.ndarray](), list[np.ndarray](), list[np.ndarray]()
    for one, _, run in cases:
        before, after, failure_time = one.before.course, run.course, one.before.motion.trajectory.end_time
        before = before.within(failure_time - _SHARE_BEFORE * float(after.time[-1]), failure_time)
        times.append(np.append(before.time - failure_time, after.time))
        speeds.append(np.append(before.speeds, after.speeds, axis=1))
        amplitudes.append(np.append(before.amplitude, after.amplitude))
    drives = list(cases[0][2].state.torques)
    torques_after = [[run.state.torques[d] for d in drives] for _, _, run in cases]
    torques_before = [[one.before.state.torques[d] for d in drives] for one, _, _ in cases]
    a.curve("drive", drives, "rotor with a drive")
    a.curve("drive_torque", torques_after, "mean torque", "torque", "case drive")
    a.curve("operation_torque", torques_before, "mean torque before the failure", "torque", "case drive")
    a.curve("rotor", [r.name for r in machine.rotors], "rotor")
    a.curve("time", _pad_courses(times), "time after the failure", "time", "case sample", coordinate=True)
    a.curve("rotor_speed", _pad_courses(speeds), "speed", "speed", "case rotor sample")
    a.curve("amplitude", _pad_courses(amplitudes), "amplitude of the axis", machine.orbit_unit, "case sample")


def _pad_courses(courses: Sequence[np.ndarray]) -> np.ndarray:
    """Return courses of any lengths as one array, without a number after the end of one."""
    count = max(values.shape[-1] for values in courses)
    widths = ([(0, 0)] * (values.ndim - 1) + [(0, count - values.shape[-1])] for values in courses)
    return np.array([np.pad(x, width, constant_values=np.nan) for x, width in zip(courses, widths, strict=True)])


def _sentence(cases: Sequence[Case]) -> str:
    if not cases:
        return "no drive has failed yet"
    outcomes = [(drive, run.state.outcome) for _, drive, run in cases]
    locked_drives, open_drives = ([d for d, o in outcomes if o in of] for of in ((Outcome.SYNCHRONISED,), OPEN_OUTCOMES))
    lost_drives = [d for d, o in outcomes if o not in (Outcome.SYNCHRONISED, *OPEN_OUTCOMES)]
    if len(locked_drives) == len(cases):
        return f"the rotors stay synchronised whichever {'drive' if len(cases) > 1 else 'of the drives'} fails"
    clauses = [f"the rotors stay synchronised without the drive of {_listing(locked_drives)}"] if locked_drives else []
    if lost_drives:
        loss = (
            "not synchronised without that" if locked_drives else "the rotors are not synchronised any more without the drive"
        )
        clauses.append(f"{loss} of {_listing(lost_drives)}")
    clauses += [f"undecided without that of {_listing(open_drives)}"] if open_drives else []
    return "; ".join(clauses)


def _listing(drives: Sequence[str]) -> str:
    return " or ".join(dict.fromkeys(drives))


def _nothing(axis: Axes, result: xr.Dataset) -> None:
    axis.set(xlabel="time", ylabel="speed")


def _case(result: xr.Dataset, index: int) -> str:
    """The drive that fails, and the configuration before if there are several."""
    row = result.wucht.summary["cases"][index]
    several = len({r["configuration"] for r in result.wucht.summary["cases"]}) > 1
    configuration = f" ({row['configuration']})" if several else ""
    return f"{row['drive']}{configuration}"


def _speeds(index: int, axis: Axes, result: xr.Dataset) -> None:
    """Draw the speed of each rotor, forwards, before and after a failure."""
    case = result.isel(case=index)
    for k, name in enumerate(map(str, result.rotor.values)):
        speed = case.rotor_speed.values[k]
        forwards = np.sign(speed[np.isfinite(speed)][0]) or 1.0
        axis.plot(case.time.values, forwards * speed, label=name, **line_style(k))
    axis.axvline(0.0, label=f"{_case(result, index)} fails", **_FAILURE)
    low, high = axis.get_ylim()
    least = 0.02 * max(abs(low), abs(high))
    if high - low < least:
        axis.set_ylim((low + high - least) / 2, (low + high + least) / 2)
    name_speeds(axis, result, "rotor_speed")


def _amplitudes(axis: Axes, result: xr.Dataset) -> None:
    values, name = printed_values(result, "amplitude")
    looks = [line_style(k + 2) | {"label": f"{_case(result, k)} fails"} for k in range(result.sizes["case"])]
    draw_runs(axis, result.time.values, values, looks)
    axis.axvline(0.0, **_FAILURE)
    axis.set(ylabel=name, ylim=(0, None))


def _torques(axis: Axes, result: xr.Dataset) -> None:
    """Draw the magnitude of each drive's mean torque before and after each failure, as bars."""
    before, after = np.abs(result.operation_torque.values), np.abs(result.drive_torque.values)
    cases, drives = after.shape
    places = (np.arange(cases)[:, None] * (drives + 0.5) + np.arange(drives)).ravel()
    for side, (torques, name) in enumerate(((before, "before the failure"), (after, "after it"))):
        axis.bar(places + 0.4 * side - 0.2, torques.ravel(), 0.4, color=COLOURS[4 * (1 - side)], label=name, **BAR_STYLES[side])
    names = [f"{drive}\nif {_case(result, k)}\nfails" for k in range(cases) for drive in map(str, result.drive.values)]
    axis.set_xticks(places, names)
    axis.set(xlabel="drive", ylabel=label(result, "drive_torque"))


def _limits(result: xr.Dataset) -> tuple[float, float]:
    """The part of the time in which something happens."""
    last, end = 0.0, float(np.nanmax(result.time.values))
    for k in range(result.sizes["case"]):
        time, rows = result.time.values[k], [*result.rotor_speed.values[k], result.amplitude.values[k]]
        for values in rows:
            inside = np.isfinite(values)
            size = np.abs(values[inside]).max(initial=0.0)
            moving = np.abs(values[inside] - values[inside][-1]) > _TOLERANCE * size
            last = max(last, float(time[inside][moving].max(initial=0.0)))
    right = min(end, max(_LONGER * last, _LEAST * end))
    return max(float(np.nanmin(result.time.values)), -_BEFORE * right), right
