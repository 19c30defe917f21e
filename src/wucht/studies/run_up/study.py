"""The question of a run-up: its runs, one or many, their start, length and equations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from wucht.dynamics.parameters import parameter_of, values_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.run_variations import start_states
from wucht.dynamics.system_states import refuse_machine_keys, refuse_singular_start, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.plots.run_panels import figure_of_run
from wucht.plots.several_runs import figure_of_runs
from wucht.plots.state_courses import figure_of_states
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Path, Starts, TrueOrFalse, Values
from wucht.studies.next_question import NextQuestion
from wucht.studies.run_up.equation_run import EquationRun
from wucht.studies.run_up.machine_run import MachineRun
from wucht.studies.single_run import SingleRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_RUNS = 500
Run = MachineRun | EquationRun
_MOST_SAMPLES, _MOST_PLACES = 1_000_000, 20_001  # of all runs of equations together: over time, of what they tend to
_KEYS_OF_MACHINES = ("turns", "model", "inertia", "order", "speed_limit", "over", "deck")


class RunUp(SingleRun):
    """Start the machine and follow its motion to the end.

    It runs ``until`` a time, for ``turns`` of the main rotor, or, without either, until it has ``settled``. Of equations of a
    table [system]: integrate them, and tell what the motion tends to.
    """

    kind = "run-up"
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions = (
        NextQuestion(
            "the same run, as long as its verdict needs", {"study.until": "{advised_time:.6g}"}, ("unidentified", "unsettled")
        ),
        NextQuestion(
            "the same with a motor that lifts weight and load from any position", {}, ("not-started",), "motors_that_start"
        ),
        NextQuestion(
            "its steady speeds over the size of the motor: with which it is no longer held at the resonance",
            {"study.kind": "speed-curve", "study.along": "{motor}", "study.range": "[{motor_low:.4g}, {motor_high:.4g}]"},
            ("captured", "captured-modulated"),
        ),
        NextQuestion(
            "the speeds at which the motor, its load and the vibration are in balance",
            {"study.kind": "torque-balance"},
            ("captured", "captured-modulated", "not-started", "stopped"),
        ),
        NextQuestion(
            "whether the rotors stay synchronised when a motor fails", {"study.kind": "drive-failure"}, ("synchronised",)
        ),
        NextQuestion(
            "all steady phases, and which of them are stable",
            {"study.kind": "synchronous-states"},
            ("synchronised", "not-synchronised", "balancer-captured"),
        ),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}, ("passed",)),
        NextQuestion("what happens when it is switched off", {"study.kind": "coast-down"}),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
    )
    curves = (("time", "speed"), ("time", "amplitude"))
    curves_of_equations = (("time", "states"),)
    without_inertia = True

    starts: Composite[Starts] = composite(default=(), description="several initial states: a run each, in one result")
    along: Path | None = Field(default=None, description="path of a parameter with several `values`")
    values: Composite[Values] = composite(default=(), description="values of the parameter `along`: a run each, in one result")
    stored_samples: int | None = Field(
        default=None,
        gt=1,
        title="largest number of stored samples, of all runs together",
        description="largest number of stored samples, of all runs together; by default a million, or as many as take 240 MB",
    )
    limit_set: TrueOrFalse | None = Field(
        default=None,
        description="whether the motion is followed until it is known what it tends to: an orbit with its period and Floquet "
        "multipliers, a torus, or a chaotic motion with its largest Lyapunov exponent; of a table [system] always",
    )
    over: Literal["time", "phi", "psi"] = Field(default="time", description=(
        "abscissa of the figure: `\"time\"`, `\"phi\"` (the rotor's angle) or `\"psi\"` (mean phase of its bodies)"
    ))  # fmt: skip
    deck: SI[float | None] = si("rad", "inclination of the deck", default=None, gt=-1.5, lt=1.5, help=(
        "inclination of a screen's deck, counter-clockwise from +x, for its throw number"
    ))  # fmt: skip

    @property
    def settings(self) -> RunSettings:
        """Return the settings of each run."""
        runs = len(self.starts or [0]) * len(self.values or [0])
        return replace(super().settings, stored_samples=self.stored_samples, runs=runs)

    def check(self) -> None:
        """Check that start and starts exclude each other, and that along comes with values."""
        if self.starts and self.start:
            raise InputError("study.starts", None, "give either start or starts")
        if bool(self.values) != (self.along is not None):
            missing = "values" if self.along is not None else "along"
            raise InputError(
                f"study.{missing}", None, "this key is missing; along = PATH and values = [...] belong together", code="missing"
            )
        if len(self.starts or [0]) * len(self.values or [0]) > MOST_RUNS:
            raise InputError("study.values", len(self.values), f"there must be at most {MOST_RUNS} runs, starts times values")
        super().check()

    def prepare(self, subject: Subject) -> tuple[Run, ...]:
        """Return the runs, at least one. Raises ``InputError``."""
        starts = {f"study.starts[{k}]": start for k, start in enumerate(self.starts)} or {"study.start": self.start}
        prepare_run: Callable[..., Run] = self._machine_run if isinstance(subject, Machine) else self._equation_run
        parameter, runs = None if self.along is None else parameter_of(subject, self.along), list[Run]()
        for value in (None,) if parameter is None else values_of(subject, parameter, self.values):
            variant, names = subject, list[str]()
            if parameter is not None and value is not None:
                variant, names = subject.with_values({parameter.path: value}), [parameter.value_text(value)]
            for at, start in starts.items():
                run = prepare_run(variant, start, at)
                label = "; ".join([*names, run.label] if self.starts else names)
                runs.append(replace(run, label=label, value=value))
        return tuple(runs)

    def stored_numbers(self, prepared: tuple[Run, ...]) -> float:
        """See ``Study``."""
        return sum(run.stored_numbers for run in prepared)

    def solve(self, subject: Subject, prepared: tuple[Run, ...], work: Work) -> Iterator[Answer]:
        """Integrate the runs; later ones are reported when they are complete: partial ones would count as finished."""
        if not self.starts and not self.values:
            yield from prepared[0].answers(work)
            return
        ends, count = tuple[Answer, ...](), len(prepared)
        for k, run in enumerate(prepared):
            for answer in run.answers(work.part(f"run {k + 1}", k / count, (k + 1) / count)):
                if not ends:
                    yield Answer(subject.units, partial(run.state_many, self.along, prepared, (answer,), 0))
            ends = (*ends, answer)
            yield Answer(subject.units, partial(run.state_many, self.along, prepared, ends, k + 1))

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        of_machine = figure_of_runs if "case" in result.dims else figure_of_run
        return (figure_of_states if result.attrs.get("subject") == "system" else of_machine)(result)

    def _machine_run(self, machine: Machine, start: Mapping[str, Any], location: str) -> MachineRun:
        if self.over == "psi" and not any(b.about == machine.rotor.name for b in machine.bodies):
            raise InputError("study.over", self.over, "must be 'time' or 'phi': no body turns about the rotor")
        if self.deck is not None and (machine.dimensionless or "y" not in machine.labels):
            raise InputError(
                "study.deck", self.deck, "allowed only for a machine with units whose carrier moves up and down (y)"
            )
        if self.limit_set and self.model == "slow":
            raise InputError("study.limit_set", True, "allowed only with the full equations, model = 'full' or 'both'")
        case = RunUpCase.of(machine, start, self.settings, location)  # checks the start, which is named below
        units = {name: state.unit.si for name, state in start_states(machine).items()}
        name = ", ".join(f"{k} = {_value_text(v, units.get(k, ''))}" for k, v in start.items()) or "at rest"
        return MachineRun(name, start, None, case, self.over, self.deck, bool(self.limit_set))

    def _equation_run(self, subject: Subject, start: Mapping[str, Any], location: str) -> EquationRun:
        refuse_machine_keys(self, _KEYS_OF_MACHINES)
        if self.limit_set is False:
            raise InputError("study.limit_set", False, "must be true, or not given, for a table [system]")
        if self.until is None and not subject.system.has_formulas:
            raise InputError(
                "study.until", None, "must be given for a Python function without formulas: the run does not end itself"
            )
        state = states_from(subject.system, start, location)
        refuse_singular_start(subject, state, location)
        values = dict(zip(subject.system.state_names, state.tolist(), strict=True))
        name = ", ".join(f"{name} = {x:.6g}" for name, x in values.items() if x) or "all states 0"
        samples = max((self.stored_samples or _MOST_SAMPLES) // self.settings.runs, 2)
        places = _MOST_PLACES // self.settings.runs
        return EquationRun(name, values, None, subject, self.until, self.tolerance, self.engine, samples, places)


def _value_text(value: Any, unit: str = "") -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} {_value_text(v)}" for k, v in value.items()) + "}"
    return f"{value:.6g} {unit}".rstrip() if isinstance(value, int | float) else str(value)
