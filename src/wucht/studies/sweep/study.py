"""The study of a sweep: what is sweep, through which values, and what is read of it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from wucht.analysis.working_points import energy_scale
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.sweeps.course import SweptSubject
from wucht.dynamics.sweeps.jumps import JUMP_TOLERANCE
from wucht.dynamics.sweeps.moving import MovedMachine, rate_unit, sweep_pace
from wucht.dynamics.sweeps.ramps import RampedMachine
from wucht.dynamics.sweeps.steps import SteppedEquations
from wucht.dynamics.system_states import refuse_machine_keys, refuse_singular_start, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.schema import Composite, Parameter, Unit, composite, read_quantity
from wucht.studies.answer import Answer
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Pair, Path, Start, Tolerance, Value, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import FULL_EQUATIONS, Study
from wucht.studies.sweep.answer import Observables, SweepQuestion, state_sweep
from wucht.studies.sweep.figure import sweep_figure
from wucht.studies.sweep.observables import machine_observables, state_observables

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_KEYS_OF_MACHINES = ("rate", "jump_tolerance")

Prepared = tuple[SweepQuestion, SweptSubject, Observables]


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

    def prepare(self, subject: Subject) -> Prepared:
        """Return what is sweep, through which values, and what is read of it. Raises ``InputError``."""
        parameter = parameter_of(subject, self.along)
        low, high = range_of(Unit(parameter.unit, parameter.long_name), self.range)
        ways = {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if self.direction in (way, "both")}
        question = SweepQuestion(parameter, (low, high), ways, rate_unit(subject, parameter.path), self.rate is None)
        if isinstance(subject, Machine):
            return question, *self._machine_ramps(subject, question)
        return question, *self._equation_steps(subject, question)

    def solve(self, subject: Subject, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Move the parameter. A failure ends the sweep with a sentence."""
        question, sweep, observables = prepared
        for course in sweep.courses(question.ways, work):
            yield Answer(subject.units, partial(state_sweep, question, observables, course))

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        return sweep_figure(result)

    def _equation_steps(self, subject: Subject, question: SweepQuestion) -> tuple[SweptSubject, Observables]:
        refuse_machine_keys(self, _KEYS_OF_MACHINES)
        path, start = question.parameter.path, states_from(subject.system, self.start, "study.start")
        refuse_singular_start(subject.with_values({path: question.first_value}), start, "study.start")
        sweep = SteppedEquations(subject, path, self.points, start, self.tolerance, self.engine)
        return sweep, state_observables(sweep)

    def _machine_ramps(self, machine: Machine, question: SweepQuestion) -> tuple[SweptSubject, Observables]:
        parameter, ends = question.parameter, question.ends
        path, rate = parameter.path, self._rate(machine, parameter)
        if machine.schedules:
            raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
        if machine.shaking is not None and path == machine.shaking[1].name:
            raise InputError("study.along", path, "not allowed: the phase of the motion would run away")
        if path in {f"{b.name}.{key}" for b in machine.bodies for key in ("locked", "release.time", "release.speed")}:
            raise InputError("study.along", path, "not allowed: it says when a body is released")
        for i, value in enumerate(ends):
            machine.check_values({path: value}, f"study.range[{i}]")
        machine = machine.with_unchecked_values({path: question.first_value})
        initial = initial_state(machine, with_default_start(machine, self.start))
        machine = machine_in_state(machine, initial)
        pace = sweep_pace(machine, path, *ends, rate)
        moved_machine = MovedMachine(machine, initial, path, pace, energy_scale(machine))
        sweep = RampedMachine(moved_machine, self.jump_tolerance, self.tolerance, self.engine)
        return sweep, machine_observables(sweep, ends, is_rate_chosen=self.rate is None)

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
