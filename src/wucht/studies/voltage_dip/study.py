"""The longest dip of the supply voltage after which the machine returns to operation by itself, and what a longer one does."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.analysis.time_constants import highest_speed
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.operating_state import machine_after_schedules
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.settled_operation import NO_OPERATION, NOT_TURNING, SettledOperation, operation_of
from wucht.dynamics.run_ups.voltage_dips import (
    CriticalDip,
    Dip,
    DippingSupply,
    LastingDip,
    critical_dip,
    one_dip,
    voltages_of_drives,
)
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import operating_speed
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer, Column
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Start, Tolerance, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.starting_variables import not_started_statement, state_starting_torques
from wucht.studies.study import FULL_EQUATIONS, Study
from wucht.studies.voltage_dip.figure import figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_POINTS = 200
_STORED_SAMPLES = 60_000  # of a run
_TURNS_BEFORE = 12  # of the main rotor, drawn before the dip
_MOST_TURNS = 1_000_000  # of a dip
_MOST_WARNINGS = 3
_SINGLE = "dip of the given duration"
_REQUIREMENT = "must be a time, or a pair [shortest, longest]"


def _parse_duration(raw: Any) -> Any:
    if isinstance(raw, list | tuple):
        if len(raw) != 2:
            raise ValueError(_REQUIREMENT)
        return tuple(raw)
    if raw is not None and (isinstance(raw, bool) or not isinstance(raw, int | float)):
        raise ValueError(_REQUIREMENT)
    return raw


Duration = Annotated[float | tuple[float, float] | None, BeforeValidator(_parse_duration)]


class VoltageDip(Study):
    """The longest dip of the supply voltage after which the machine returns to operation by itself."""

    kind = "voltage-dip"
    next_questions = (
        NextQuestion(
            "the speeds at which the motor, its load and the vibration are in balance", {"study.kind": "torque-balance"}
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves = (("dip_duration", "dip_speed"), ("dip_duration", "dip_peak_amplitude"))
    meaning = (*Study.meaning, "duration")
    solves = FULL_EQUATIONS
    from_start = True

    depth: SI[float] = si(
        "", "share of the voltage that is lost", gt=0, le=1, help="share of the voltage that is lost, up to 1, all of it"
    )
    duration: SI[Duration] = si("s", "duration of the dip", default=None, help=(
        "duration of a dip, of which the outcome is computed beside the critical duration; or a pair [shortest, longest] in "
        "which that is sought; by default it is sought up to the time at which the machine has settled at the low voltage"
    ))  # fmt: skip
    on: str | None = Field(default=None, title="body with the drive", description=(
        "body whose drive loses voltage; by default all drives do"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict, description=(
        "initial state of the run-up to the operating state; from rest by default"
    ))  # fmt: skip
    points: Whole = Field(default=8, ge=1, le=MOST_POINTS, description=(
        "number of durations that are tried before the bisection, evenly spaced in the speed that is lost"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """See ``Study``."""
        if self.duration is None:
            return
        ends = self.duration if isinstance(self.duration, tuple) else (self.duration,)
        if not all(t > 0 for t in ends):
            raise InputError("study.duration", self.duration, "must be greater than 0 s", code="limits")
        if len(ends) == 2 and not ends[0] < ends[1]:
            raise InputError("study.duration", list(ends), f"{_REQUIREMENT}, the shortest first", code="pair")

    @property
    def limits(self) -> tuple[float, float] | None:
        """The range in which the critical duration is sought; None up to that at which the machine has settled."""
        return self.duration if isinstance(self.duration, tuple) else None

    @property
    def single_duration(self) -> float | None:
        """The duration of the one dip in question, if there is one."""
        return None if isinstance(self.duration, tuple) else self.duration

    @property
    def _settings(self) -> RunSettings:
        return RunSettings(tolerance=self.tolerance, engine=self.engine, stored_samples=_STORED_SAMPLES)

    def prepare(self, machine: Machine) -> dict[str, float]:
        """Return the voltages that dip, by path, as they are in operation. Raises ``InputError``."""
        voltages = voltages_of_drives(machine, self.on)
        if machine.shaken_coordinate is not None:
            reason = "the carrier moves as prescribed, and a dip would begin at any phase of that motion"
            raise InputError("machine.carrier.motion", None, f"not allowed: {reason}", code="prescribed")
        RunUpCase.of(machine, self.start, self._settings)  # the start fits the machine
        longest = (self.limits or (0.0, self.single_duration or 0.0))[1]
        steady = machine.at(machine.breakpoints[-1])
        turns = longest * min(operating_speed(steady), highest_speed(steady)) / (2 * math.pi)
        if turns > _MOST_TURNS:
            allowed = f"{longest * _MOST_TURNS / turns:.3g} {machine.units.time}"
            requirement = f"must be at most {allowed}: these are {turns:.3g} turns or vibrations"
            raise InputError("study.duration", self.duration, requirement, code="limits")
        return voltages

    def solve(self, machine: Machine, voltages: dict[str, float], work: Work) -> Iterator[Answer]:
        """Bring the machine into operation, let the voltage stay low, then let it dip for many durations."""
        part = work.part("operation", 0.0, 0.2)
        part.report(0.0, "operation")
        operation = operation_of(machine, self.start, self._settings, _TURNS_BEFORE, part)
        so_far, trial = partial(self._fill, machine, voltages, operation), CriticalDip()
        yield Answer(machine.units, partial(so_far, None, trial))
        if operation.end.outcome in NO_OPERATION:
            return
        dip_machine = machine_after_schedules(machine, operation.locks)
        supply = DippingSupply(dip_machine, operation, voltages, self.depth, self._settings)
        lasting = supply.lasting_dip(self.limits and self.limits[1], self.points, work.part("lasting", 0.2, 0.3))
        yield Answer(machine.units, partial(so_far, lasting, trial))
        if self.single_duration is not None:
            trial = trial.with_dip(one_dip(supply.dip, self.single_duration, work.part("", 0.3, 0.35)))
            yield Answer(machine.units, partial(so_far, lasting, trial))
        shortest, durations = 0.0, lasting.levels.tolist()
        if self.limits is not None:
            shortest, longest = self.limits
            durations = [shortest, longest, *(t for t in durations if shortest < t < longest)]
        for further in critical_dip(supply.dip, sorted(durations), shortest, trial, work.part("", 0.35, 1.0)):
            yield Answer(machine.units, partial(so_far, lasting, further))

    def _fill(
        self, machine: Machine, voltages: Mapping[str, float], operation: SettledOperation,
        lasting: LastingDip | None, trial: CriticalDip, a: Answer,
    ) -> None:  # fmt: skip
        single = trial.dip_of(self.single_duration)
        self._state_operation(a, machine, voltages, operation)
        loss, critical = trial.shortest_loss, trial.critical
        outcome = next((d.end.outcome for d in (single, loss) if d is not None), operation.end.outcome)
        a.attribute(outcome=a.number("outcome", outcome, "outcome after the dip", headline=True))
        longest = "longest dip after which the machine returns by itself"
        a.number("critical_duration", critical and critical.duration, longest, "time", headline=True)
        fall = "speed of the main rotor at the end of that dip"
        a.number("critical_speed", critical and critical.speed_at_recovery, fall, "speed", headline=True)
        a.line("critical", "{critical_duration:.4g}, to 1 %; the speed is then {critical_speed}")
        _state_dip(a, machine, "dip", _SINGLE, single)
        _state_dip(a, machine, "beyond", "shortest dip after which it does not return", loss)
        _state_lasting(a, lasting)
        again = [d.duration for d in trial.later_returns]
        a.number("later_returns", again, "longer dips that were tried after which it returns again", "time")
        a.number("depth", self.depth, "share of the voltage that is lost")
        kinds: dict[str, type] = {
            "duration": float, "outcome": str, "speed": float, "returns": np.int8, "speed_at_recovery": float,
            "recovery_time": float, "peak_amplitude": float,
        }  # fmt: skip
        a.table("dips", "dips that were tried", "dip", kinds, **_dip_columns(machine, trial.dips))
        _state_courses(a, machine, operation, trial, single)
        state_starting_torques(a, machine.at(machine.breakpoints[-1]))
        a.line("dips", f"{len(trial.dips)} tried, {sum(d.is_return for d in trial.dips)} with a return")
        a.sentence = self._sentence(machine, operation, lasting, trial)
        _warn(a, machine, operation, lasting, trial)
        origin = "the machine has settled after a run-up from the start"
        if operation.working_point is not None:
            speed, reason = f"{operation.working_point:.5g} {machine.units.speed}", not_started_statement(machine)
            origin = (
                f"the machine does not start by itself{reason and f' ({reason})'}, and has settled at its stable working point"
            )
            origin += f", {speed}"
        a.assume(origin, "motors keep their steady characteristics in the dip, at the voltage that is left")

    def _state_operation(self, a: Answer, machine: Machine, voltages: Mapping[str, float], operation: SettledOperation) -> None:
        """State the operating state, and the voltages that dip."""
        end, full = operation.end, {path.removesuffix(".voltage"): u for path, u in voltages.items()}
        a.number("operating_outcome", end.outcome, "outcome in operation")
        a.number("operating_speed", end.speed, "mean speed of the main rotor in operation", "speed", headline=True)
        a.number("operating_amplitude", end.amplitude, "amplitude of the axis in operation", machine.orbit_unit)
        a.line("operation", f"{end.outcome}, {{operating_speed}}{', amplitude {operating_amplitude}' if end.amplitude else ''}")
        a.number("voltages", full, "voltage of each drive in operation", "V")
        share = {drive: (1 - self.depth) * u for drive, u in full.items()}
        a.number("dip_voltages", share, "voltage of each drive in the dip", "V")
        a.line("voltage", "{depth:%} lost; left: {dip_voltages:.4g}")

    def _sentence(self, machine: Machine, operation: SettledOperation, lasting: LastingDip | None, trial: CriticalDip) -> str:
        """Return the critical duration in words, or why there is none."""
        units, last, loss = machine.units, trial.longest_return, trial.shortest_loss
        if operation.end.outcome in NO_OPERATION:
            reason = next(o for o in Outcome if o == operation.end.outcome).sentence
            return f"the machine does not reach a state of operation: {reason}"
        if lasting is None or not trial.dips:
            return "not determined yet"
        loss_share = "all" if self.depth == 1 else f"{100 * self.depth:.4g} % of the"
        returns = f"with {loss_share} voltage lost, the machine returns by itself after"
        if loss is None:
            return f"{returns} {self._all_dips(machine, lasting, trial.dips[-1].duration)}"
        end = f"after {loss.duration:.4g} {units.time}: {loss.end.outcome}"
        if loss.end.outcome not in (Outcome.STOPPED, Outcome.NOT_STARTED):
            end += f", at {loss.end.speed:.4g} {units.speed}"
        if last is None:
            return f"{returns} none of the dips that were tried; {end}"
        return f"{returns} {'dips of up to' if trial.is_complete else 'a dip of'} {last.duration:.4g} {units.time}; {end}"

    def _all_dips(self, machine: Machine, lasting: LastingDip, longest: float) -> str:
        """Return the dips after all of which the machine returns, in words. longest: that was tried."""
        units = machine.units
        if self.limits is not None:
            return f"every dip of {self.limits[0]:.4g} to {self.limits[1]:.4g} {units.time}"
        if not lasting.is_settled:
            return f"all dips that were tried, up to {longest:.4g} {units.time}"
        if lasting.end.outcome == Outcome.STOPPED:
            return "every dip, however long: it stops, and starts again"
        return f"every dip, however long: it settles at {lasting.end.speed:.4g} {units.speed}, and returns from there"

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw two panels, three if the carrier moves."""
        return figure(result)


def _dip_columns(machine: Machine, dips: Sequence[Dip]) -> dict[str, Column]:
    """Return dips as columns of a table."""
    return {
        "duration": ([d.duration for d in dips], "duration of the dip", "time"),
        "outcome": ([d.end.outcome for d in dips], "outcome after the dip"),
        "speed": ([d.end.speed for d in dips], "speed at the end", "speed"),
        "returns": ([d.is_return for d in dips], "whether the machine returns to operation"),
        "speed_at_recovery": ([d.speed_at_recovery for d in dips], "speed when the voltage returns", "speed"),
        "recovery_time": (
            [d.recovery_time for d in dips], "time from then until speed and vibration have settled", "time",
        ),
        "peak_amplitude": (
            [d.peak_amplitude for d in dips], "largest amplitude of the axis in the dip and after it", machine.orbit_unit,
        ),
    }  # fmt: skip


def _state_dip(a: Answer, machine: Machine, name: str, what: str, dip: Dip | None) -> None:
    """State a dip of its own, with a line; None where there is none."""
    columns = _dip_columns(machine, [] if dip is None else [dip])
    row = dip and {column: values[0] for column, (values, *_) in columns.items()}
    a.number(name, row, what, parts={column: (words, a.unit(*unit)) for column, (_, words, *unit) in columns.items()})
    if dip is not None:
        verdict = "returns" if dip.is_return else f"does not return: {dip.end.outcome}, {{speed}}"
        settled = "" if dip.recovery_time is None else "; settled {recovery_time:.3g} after the voltage is back"
        peak = "; amplitude {peak_amplitude} at most" if dip.peak_amplitude else ""
        a.line(name, f"{{duration:.4g}}: {verdict}, from {{speed_at_recovery}}{settled}{peak}", at=name)


def _state_lasting(a: Answer, lasting: LastingDip | None) -> None:
    row = None if lasting is None else {
        "outcome": lasting.end.outcome, "speed": lasting.end.speed, "time": lasting.end.end, "settled": lasting.is_settled,
    }  # fmt: skip
    parts = {
        "outcome": ("outcome at the low voltage", ""),
        "speed": ("mean speed of the main rotor there", a.unit("speed")),
        "time": ("time at the low voltage until then", a.unit("time")),
        "settled": ("whether the machine has settled there", ""),
    }
    a.number("lasting", row, "motion while the voltage stays low", parts=parts)
    if lasting is not None:
        after = "after" if lasting.is_settled else "not settled after"
        a.line("low voltage", f"{lasting.end.outcome}, {{lasting.speed}}, {after} {{lasting.time:.4g}}")


def _state_courses(a: Answer, machine: Machine, operation: SettledOperation, trial: CriticalDip, single: Dip | None) -> None:
    """State the motion before, in and after the dips at the border, and the single one; nan where one ends early."""
    dips = {
        _SINGLE: single,
        "longest dip with a return": trial.longest_return,
        "shortest dip without": trial.shortest_loss,
    }
    chosen = {name: dip for name, dip in dips.items() if dip is not None and (name == _SINGLE or dip is not single)}
    courses = [MotionCourse.join([operation.course, d.course]) for d in chosen.values()] or [operation.course]
    longest = max(len(c.time) for c in courses)

    def stack(arrays: Sequence[np.ndarray]) -> np.ndarray:
        widths = [[(0, 0)] * (a.ndim - 1) + [(0, longest - a.shape[-1])] for a in arrays]
        return np.array([np.pad(a, w, constant_values=np.nan) for a, w in zip(arrays, widths, strict=True)])

    a.curve("course", np.array(list(chosen) or ["operation"], str), "motion", coordinate=True)
    a.curve("rotor", np.array([r.name for r in machine.rotors], str), "rotor", coordinate=True)
    durations = np.array([d.duration for d in chosen.values()] or [np.nan])
    a.curve("course_duration", durations, "duration of the dip", "time", "course")
    a.curve("time", stack([c.time for c in courses]), "time since the dip begins", "time", "course row", coordinate=True)
    a.curve("speed", stack([np.abs(c.speeds) for c in courses]), "speed", "speed", "course rotor row")
    amplitude = stack([c.amplitude for c in courses])
    a.curve("amplitude", amplitude, "amplitude of the axis", machine.orbit_unit, "course row")


def _warn(a: Answer, machine: Machine, operation: SettledOperation, lasting: LastingDip | None, trial: CriticalDip) -> None:
    """State what is in doubt."""
    ends, unit = [operation.end, *(d.end for d in trial.dips)], machine.units.time
    ends += [] if lasting is None else [lasting.end]
    if operation.working_point is None and any(end.outcome in NOT_TURNING for end in ends):
        a.warn(*filter(None, [not_started_statement(machine)]))
    if operation.end.outcome in NO_OPERATION:
        a.warn(*filter(None, [operation.end.advice]))
    elif again := trial.later_returns:
        a.warn(
            f"after longer dips the machine returns again: of those that were tried, after {len(again)} from "
            f"{again[0].duration:.4g} to {again[-1].duration:.4g} {unit}"
        )
    open_dips = [d for d in trial.dips if d.end.outcome == Outcome.UNIDENTIFIED]
    for dip in open_dips[:_MOST_WARNINGS]:
        a.warn(f"no verdict after a dip of {dip.duration:.4g} {unit}, taken as no return: {dip.end.advice}")
    failures = [d.failure for d in trial.dips] + ([] if lasting is None else [lasting.failure])
    a.warn(*[failure for failure in failures if failure][:1])
