"""The question of a run-up: its runs, one or many, their start, length and equations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from wucht.dynamics.limit_sets.long_run import INTERVALS, LongRun, LongRunSettings, long_run
from wucht.dynamics.parameters import parameter_of, values_of
from wucht.dynamics.run_ups.contacts import ContactCheck, check_contacts
from wucht.dynamics.run_ups.hanging_start import is_hanging_start
from wucht.dynamics.run_ups.horizon import RunSettings, numbers_per_sample
from wucht.dynamics.run_ups.neighbours import Neighbour, neighbour_of
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.run_ups.run_variations import start_states
from wucht.dynamics.system_states import refuse_machine_keys
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Path, Starts, Values
from wucht.studies.next_question import NextQuestion
from wucht.studies.run_up.answer import fill_run
from wucht.studies.run_up.combined_runs import RunCase, state_machine_runs
from wucht.studies.run_up.figure import run_up_figure
from wucht.studies.run_up.system_run import MOST_PLACES, fill_system_run, fill_system_runs, system_cases
from wucht.studies.single_run import SingleRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_RUNS = 500
_MOST_SAMPLES = 1_000_000  # of all runs of equations together
_SHARE_BESIDE_CONTACTS = 0.4  # of the work in a run, where it may be made again with stiffer contacts
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
            "the speeds at which the motor, its load and the vibration are in balance",
            {"study.kind": "torque-balance"},
            ("captured", "captured-modulated", "not-started", "stopped"),
        ),
        NextQuestion(
            "all steady phases, and which of them are stable",
            {"study.kind": "synchronous-states"},
            ("synchronised", "not-synchronised", "balancer-captured"),
        ),
        NextQuestion("what happens when it is switched off", {"study.kind": "coast-down"}, ("compensated",)),
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

    @property
    def is_several(self) -> bool:
        """True if it has many runs."""
        return bool(self.starts or self.values)

    def prepare(self, subject: Subject) -> tuple[RunCase, ...]:
        """Return the runs, at least one. Raises ``InputError``."""
        if not isinstance(subject, Machine):
            refuse_machine_keys(self, _KEYS_OF_MACHINES)
            starts = {f"study.starts[{k}]": start for k, start in enumerate(self.starts)} or {"study.start": self.start}
            return system_cases(subject, starts, bool(self.starts), self.along, self.values)
        if self.over == "psi" and not any(b.about == subject.rotor.name for b in subject.bodies):
            raise InputError("study.over", self.over, "must be 'time' or 'phi': no body turns about the rotor")
        cases = list[RunCase]()
        values = (None,) if self.along is None else values_of(subject, parameter_of(subject, self.along), self.values)
        for value in values:
            variant = subject if self.along is None or value is None else subject.with_values({self.along: value})
            cases += [self._case(variant, start, value) for start in self.starts or (self.start,)]
        return tuple(cases)

    def stored_numbers(self, prepared: tuple[RunCase, ...]) -> float:
        """See ``Study``."""
        return sum(_stored_numbers(case.run) for case in prepared)

    def solve(self, subject: Subject, prepared: tuple[RunCase, ...], work: Work) -> Iterator[Answer]:
        """Integrate the runs, those of a machine leg by leg."""
        if isinstance(subject, Machine):
            yield from self._run_machine(subject, prepared, work)
        else:
            yield from self._run_system(prepared, work)

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        return run_up_figure(result)

    def _case(self, machine: Machine, start: Mapping[str, Any], value: float | None) -> RunCase:
        """Return one run of a machine. Raises ``InputError``."""
        if self.deck is not None and (machine.dimensionless or "y" not in machine.labels):
            raise InputError(
                "study.deck", self.deck, "allowed only for a machine with units whose carrier moves up and down (y)"
            )
        run = RunUpCase.of(machine, start, self.settings)
        return RunCase(self._label(run.machine, start, value), start, value, run)

    def _label(self, machine: Machine, start: Mapping[str, Any], value: float | None) -> str:
        """Return the label of a run in a legend: the value of the parameter, the start, or both."""
        parts = [] if value is None or self.along is None else [machine.parameters[self.along].value_text(value)]
        if self.starts:
            units = {name: state.unit.si for name, state in start_states(machine).items()}
            parts.append(", ".join(f"{k} = {_value_text(v, units.get(k, ''))}" for k, v in start.items()) or "at rest")
        return "; ".join(parts)

    def _parts(self, cases: tuple[RunCase, ...], work: Work) -> Iterator[tuple[RunCase, Work]]:
        """Yield each run with its part of the work."""
        count = len(cases)
        for k, case in enumerate(cases):
            yield case, work.part(f"run {k + 1}", k / count, (k + 1) / count) if self.is_several else work

    def _run_machine(self, machine: Machine, cases: tuple[RunCase, ...], work: Work) -> Iterator[Answer]:
        done = list[tuple[tuple[Motion, ...], Neighbour | None, ContactCheck | None]]()
        for case, part in self._parts(cases, work):
            motions: tuple[Motion, ...] = ()
            share = _SHARE_BESIDE_CONTACTS if case.run.machine.tracks else 1.0
            for motions in run_up(case.run, part.part("", 0.0, share)):
                if not done:  # later runs are reported when they are complete: partial ones would count as finished
                    yield Answer(machine.units, partial(self._fill, machine, cases, ((motions, None, None),), 0))
            check = check_contacts(motions[0], part.part("contacts", share, 1.0))
            if check is not None and check.is_stiffer:
                motions = (check.motion, *motions[1:])
            done.append((motions, neighbour_of(motions[0], part.part("neighbour", 1.0, 1.0)), check))
            yield Answer(machine.units, partial(self._fill, machine, cases, tuple(done), len(done)))

    def _fill(
        self,
        machine: Machine,
        cases: tuple[RunCase, ...],
        runs: tuple[tuple[tuple[Motion, ...], Neighbour | None, ContactCheck | None], ...],
        finished_count: int,
        a: Answer,
    ) -> None:
        """State the runs of a machine: the motions of each, the full equations first; a neighbour of the first, and a check."""
        fills = [
            partial(fill_run, *run, self.deck, is_hanging_start(case.run.machine, case.start))
            for case, run in zip(cases, runs, strict=False)
        ]
        if not self.is_several:
            fills[0](a)
            return
        results = [Answer(machine.units, fill).fill() for fill in fills]
        state_machine_runs(a, self.along, self.over, cases, results, finished_count)

    def _run_system(self, cases: tuple[RunCase, ...], work: Work) -> Iterator[Answer]:
        settings, most = LongRunSettings(self.until, self.tolerance, self.engine), self.stored_samples or _MOST_SAMPLES
        runs = list[LongRun]()
        for case, part in self._parts(cases, work):
            equations, start = case.run
            report = partial(_tell_time, part.open_ended, self.until)
            run = part.unit("run", partial(long_run, equations, start, settings, report))
            runs.append(run)
            if self.is_several:
                yield Answer(fill=partial(fill_system_runs, self.along, cases, most, self.tolerance, tuple(runs)))
            else:
                yield Answer(fill=partial(fill_system_run, equations, run, max(most, 2), MOST_PLACES, self.tolerance))


def _stored_numbers(run: Any) -> float:
    """Bound of a run of a machine, or of equations with their start."""
    if isinstance(run, RunUpCase):
        return run.horizon.samples * len(run.models) * numbers_per_sample(run.machine)
    equations, _ = run
    return float(2 * (2 * INTERVALS + 1) * len(equations.system.states))


def _tell_time(work: Work, until: float | None, time: float) -> None:
    work.report(time / until if until else 0.0, f"t = {time:.4g}")


def _value_text(value: Any, unit: str = "") -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} {_value_text(v)}" for k, v in value.items()) + "}"
    return f"{value:.6g} {unit}".rstrip() if isinstance(value, int | float) else str(value)
