"""The question of a sweep, and its answer as it grows: ramps of the parameter, and a search for the jumps of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from wucht.analysis.working_points import energy_scale
from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.limit_sets.stepped_parameter import Way, settling_span, step_through
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.sweeps.jumps import JUMP_TOLERANCE, Jump, candidates, find_jump
from wucht.dynamics.sweeps.moving import (
    IntegrationError,
    MovedMachine,
    Mover,
    Place,
    SweepLeg,
    moving_system,
    rate_unit,
    sweep_pace,
)
from wucht.dynamics.system_states import refuse_machine_keys, refuse_singular_start, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.numerics.flow.compiled_system import compile_system
from wucht.schema import Composite, Parameter, Unit, composite, read_quantity
from wucht.studies.answer import Answer
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Pair, Path, Start, Tolerance, Value, Whole
from wucht.studies.motion_variables import state_parameters
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import FULL_EQUATIONS, Study
from wucht.studies.sweep.answer import (
    Ends,
    free_speeds,
    settling_doubts,
    state_free_speeds,
    state_machine_jumps,
    state_question,
    state_ramps,
    state_sentence,
    system_answer,
)
from wucht.studies.sweep.figure import SENSE, sweep_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_TURNS_A_UNIT, _MOST_LEGS_A_UNIT = 500, 20
_JUMPS_SHARE = 0.55  # of the time of a ramp: completed share when the search for jumps begins
_FIRST = 0.1  # share of the work until the motion of equations has settled at the first value

MachineSweep = tuple[MovedMachine, Parameter, Ends]  # the machine has the parameter at its first value
SystemSweep = tuple[Parameter, Ends, np.ndarray, LongRunSettings]  # with the state (n,) at the start


class Sweep(Study):
    """Move the parameter ``along``, the swept parameter, through ``range``, so slowly that the machine follows."""

    kind = "sweep"
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions = (
        NextQuestion(
            "all branches of steady operation, also those that a sweep jumps over",
            {"study.kind": "speed-curve", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves = (("value", "speed"), ("value", "amplitude"))
    curves_of_equations = (("value", "high"), ("value", "low"))
    solves = FULL_EQUATIONS
    from_start = True

    along: Path = Field(description="path of the parameter that is swept")
    range: Composite[Pair]
    rate: Value | None = Field(default=None, title="rate of the parameter", description=(
        "rate of the parameter, in its unit per unit of time; by default the range takes a thousand times as long as the "
        "response of the machine"
    ))  # fmt: skip
    direction: Literal["both", "up", "down"] = Field(
        default="both", description='direction of the sweep: `"both"` (up, then down again), `"up"` or `"down"`'
    )
    start: Composite[Start] = composite(default_factory=dict, description=(
        "initial state; the machine starts there with the parameter at its first value, and settles"
    ))  # fmt: skip
    jump_tolerance: float = Field(
        default=JUMP_TOLERANCE, ge=1e-8, le=0.1, description="relative tolerance of the values of jumps"
    )
    points: Whole = Field(
        default=101, ge=11, le=10_000, description="number of values of the parameter, of the equations of a table [system]"
    )
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def prepare(self, subject: Subject) -> MachineSweep | SystemSweep:
        """Return what is swept, and where it starts. Raises ``InputError``."""
        if not isinstance(subject, Machine):
            refuse_machine_keys(self, ("rate", "jump_tolerance"))
        parameter = parameter_of(subject, self.along)
        ends = range_of(Unit(parameter.unit, parameter.long_name), self.range)
        if isinstance(subject, Machine):
            return self._prepare_machine(subject, parameter, ends)
        start, first = states_from(subject.system, self.start, "study.start"), self._first_value(ends)
        refuse_singular_start(subject.with_values({parameter.path: first}), start, "study.start")
        return parameter, ends, start, LongRunSettings(None, self.tolerance, self.engine)

    def solve(self, subject: Subject, prepared: MachineSweep | SystemSweep, work: Work) -> Iterator[Answer]:
        """Run the ramps. A failure ends the sweep with a sentence."""
        if isinstance(subject, Machine):
            yield from self._sweep_machine(prepared, work)  # type: ignore[arg-type]
        else:
            yield from self._sweep_system(subject, prepared, work)  # type: ignore[arg-type]

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        return sweep_figure(result)

    def _ways(self, ends: Ends) -> dict[str, Ends]:
        """Return the first and the last value of the ramps ``"up"`` and ``"down"``, in their order."""
        low, high = ends
        return {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if self.direction in (way, "both")}

    def _first_value(self, ends: Ends) -> float:
        return next(iter(self._ways(ends).values()))[0]

    def _prepare_machine(self, machine: Machine, parameter: Parameter, ends: Ends) -> MachineSweep:
        path, rate = parameter.path, self._rate(machine, parameter)
        if machine.schedules:
            raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
        if machine.shaking is not None and path == machine.shaking[1].name:
            raise InputError("study.along", path, "not allowed: the phase of the motion would run away")
        if path in {f"{b.name}.{key}" for b in machine.bodies for key in ("locked", "release.time", "release.speed")}:
            raise InputError("study.along", path, "not allowed: it says when a body is released")
        for i, value in enumerate(ends):
            machine.check_values({path: value}, f"study.range[{i}]")
        machine = machine.with_unchecked_values({path: self._first_value(ends)})
        initial = initial_state(machine, with_default_start(machine, self.start))
        machine = machine_in_state(machine, initial)
        pace = sweep_pace(machine, path, *ends, rate)
        return MovedMachine(machine, initial, path, pace, energy_scale(machine)), parameter, ends

    def _rate(self, machine: Machine, parameter: Parameter) -> float | None:
        """The rate of the parameter, None if it is not given. Raises ``InputError``."""
        if self.rate is None:
            return None
        time, long_name = machine.units.time, f"rate of the {parameter.long_name}"
        unit = f"{parameter.unit or '1'}/{time}" if time else parameter.unit
        rate = read_quantity(Unit(unit, long_name), self.rate, "study.rate")
        if rate <= 0:
            unit = f", in {rate_unit(machine, parameter.path)}" if time else ""
            raise InputError("study.rate", self.rate, f"must be a {long_name} greater than 0{unit}")
        return rate

    def _sweep_machine(self, prepared: MachineSweep, work: Work) -> Iterator[Answer]:
        """Yield the answer after each part of a ramp and each search for a jump."""
        moved_machine, parameter, ends = prepared
        machine, pace, ways = moved_machine.machine, moved_machine.pace, self._ways(ends)
        flow = compile_system(moving_system(machine, parameter.path), self.tolerance, release_events(machine), self.engine)
        driven, mover = (pace.driven, 0.0), Mover(moved_machine, flow, _ignore_time)
        ramp, longest = pace.samples * pace.step, mover.longest_settling
        ramp_share = _JUMPS_SHARE * ramp / (ramp + longest)
        first = longest / (longest + len(ways) * (ramp + longest) / _JUMPS_SHARE)  # as long as what follows, for its time
        ramps, jumps, doubts = dict[str, tuple[SweepLeg, ...]](), list[Jump](), list(pace.warnings)
        without_vibration = free_speeds(machine, parameter, ends)

        def answer(failure: str | None = None, is_complete: bool = False) -> Answer:
            a = Answer(machine.units)
            a.failure = failure
            a.attribute(along=parameter.path, along_unit=parameter.unit, rate=pace.rate, engine=flow.engine_name)
            a.warn(*doubts)
            state_machine_jumps(a, machine, parameter, jumps)
            state_question(a, moved_machine, parameter, ends, self.rate is None, self.jump_tolerance)
            state_free_speeds(a, parameter, *without_vibration)
            state_parameters(a, machine)
            state_ramps(a, moved_machine, parameter, ramps, jumps)
            state_sentence(a, parameter, ends, jumps, is_complete)
            return a

        yield answer()
        work.report(0.0, "settling")
        try:
            settling = replace(mover, report=_time_reporter(work.part("", 0.0, first).open_ended, 0.0, longest, "settling"))
            settled_leg, steady = work.unit("settling", partial(settling.settle, settling.begin(), driven))
            doubts += settling_doubts(moved_machine, settled_leg, steady, "before the sweep")
            for k, way in enumerate(ways):
                begin, end = (first + (1 - first) * n / len(ways) for n in (k, k + 1))
                part = work.part(way, begin, end)
                for legs in self._ramp(mover, settled_leg.place, way, ways[way], part, ramp_share):
                    ramps[way] = legs
                    yield answer()
                all_legs = [leg for of_ramp in ramps.values() for leg in of_ramp]
                speed, amplitude = np.abs([driven, *((leg.speed, leg.amplitude) for leg in all_legs)]).max(axis=0)
                settling_part = part.part("", ramp_share, _JUMPS_SHARE).open_ended
                at_end = replace(mover, report=_time_reporter(settling_part, legs[-1].place.time, longest, "settling"))
                settled_leg, steady = part.unit("settling", partial(at_end.settle, legs[-1].place, (speed, amplitude)))
                doubts += settling_doubts(moved_machine, settled_leg, steady, f"after the ramp {way}", all_legs)
                yield answer()
                for jump in self._jumps(mover, legs, part.part("jump", _JUMPS_SHARE, 1.0)):
                    jumps.append(jump)
                    yield answer()
            work.report(1.0)
            yield answer(is_complete=True)
        except IntegrationError as error:
            yield answer(failure=str(error))

    def _ramp(
        self, mover: Mover, place: Place, way: str, values: Ends, work: Work, share: float
    ) -> Iterator[tuple[SweepLeg, ...]]:
        """Run one ramp in equal legs; yield the completed legs after each unit of work. share: of the work."""
        pace = mover.moved_machine.pace
        turns = pace.step * pace.fastest / (2 * math.pi)
        count = max(1, min(_MOST_LEGS_A_UNIT, round(_TURNS_A_UNIT / turns)))
        report = _time_reporter(work.part("", 0.0, share), place.time, pace.samples * pace.step, SENSE[way])
        ramping, legs = replace(mover, report=report), tuple[SweepLeg, ...]()
        steps = np.linspace(*values, pace.samples + 1)[1:]
        for begin in range(0, pace.samples, count):
            unit = partial(ramping.legs, place, pace.step, steps[begin : begin + count].tolist())
            more, failure = work.unit(f"legs {begin + 1} on", unit)
            legs += more
            yield legs
            if failure:
                raise IntegrationError(failure)
            place = legs[-1].place

    def _jumps(self, mover: Mover, legs: Sequence[SweepLeg], work: Work) -> Iterator[Jump]:
        """Yield the jumps of one ramp."""
        pairs = candidates(mover, legs)
        for i, (first, last) in enumerate(pairs):
            searching = replace(mover, report=_share_reporter(work, i / len(pairs), f"jump {i + 1} of {len(pairs)} at most"))
            jump = work.unit(str(i + 1), partial(find_jump, searching, legs, first, last, self.jump_tolerance))
            if jump is not None:
                yield jump

    def _sweep_system(self, subject: Subject, prepared: SystemSweep, work: Work) -> Iterator[Answer]:
        """Yield the answer after each way."""
        parameter, ends, start, settings = prepared
        path, ways, completed_ways = parameter.path, self._ways(ends), dict[str, Way]()
        work.report(0.0, "settling")
        at_first = subject.with_values({path: self._first_value(ends)})
        span, state = work.unit("settling", partial(settling_span, at_first, start, settings))
        for k, (name, values) in enumerate(ways.items()):
            begin, end = (_FIRST + (1 - _FIRST) * n / len(ways) for n in (k, k + 1))
            part = work.part(name, begin, end)
            step = partial(step_through, subject, path, np.linspace(*values, self.points), state, span, settings)
            way, state = part.unit("values", partial(step, partial(_report_share, part, name)))
            completed_ways[name] = way
            yield system_answer(subject, path, ends, span, completed_ways)
            if way.failure:
                return


def _time_reporter(work: Work, begin: float, duration: float, activity: str) -> Callable[[float], None]:
    """Progress function of a mover from a time on, for a duration at most.

    All parts of a sweep have shares as long as they last: the pace of the first seconds of a ramp tells how long the whole will
    take.
    """
    return lambda time: work.report((time - begin) / duration, activity)


def _ignore_time(_time: float) -> None:
    """Ignore the progress of a mover."""


def _share_reporter(work: Work, share: float, activity: str) -> Callable[[float], None]:
    """Progress function of a mover while its duration is unknown."""
    return lambda _: work.report(share, activity)


def _report_share(part: Work, name: str, share: float) -> None:
    part.report(share, name)
