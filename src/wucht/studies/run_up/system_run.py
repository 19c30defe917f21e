"""Runs of equations of a table ``[system]``: question and equations -> plan -> findings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.long_run import LongRun, LongRunSettings, long_run
from wucht.dynamics.parameters import parameter_of, values_of
from wucht.dynamics.system_states import refuse_machine_keys, refuse_singular_start, states_from
from wucht.dynamics.work import Work
from wucht.files.user_system import UserSystem
from wucht.studies.run_up.spec import RunUp

_KEYS_OF_MACHINES = ("turns", "model", "inertia", "order", "speed_limit", "over", "deck")


@dataclass(frozen=True, eq=False)
class SystemRunCase:
    """One run. label: in a legend. value: of the parameter ``along``. start: (n,)."""

    label: str
    value: float | None
    subject: UserSystem
    start: np.ndarray


@dataclass(frozen=True, eq=False)
class SystemRunPlan:
    """The runs of equations, at least one. several: True if the question has many."""

    spec: RunUp
    subject: UserSystem
    cases: tuple[SystemRunCase, ...]
    several: bool
    settings: LongRunSettings


@dataclass(frozen=True, eq=False)
class SystemRunFindings:
    """The finished runs, in the order of the cases."""

    plan: SystemRunPlan
    runs: tuple[LongRun, ...]


def system_run_plan(spec: RunUp, subject: UserSystem) -> SystemRunPlan:
    """Return the plan. Raises ``InputError`` for a key that holds for machines only, or a state that the equations lack."""
    refuse_machine_keys(spec, _KEYS_OF_MACHINES)
    locations = [f"study.starts[{k}]" for k in range(len(spec.starts))] or ["study.start"]
    starts = [
        (at, states_from(subject.system, values_by_name, at))
        for values_by_name, at in zip(spec.starts or [spec.start], locations, strict=True)
    ]
    along = None if spec.along is None else parameter_of(subject, spec.along)
    values = (None,) if along is None else values_of(subject, along, spec.values)
    cases = []
    for value in values:
        variant = subject if along is None or value is None else subject.with_parameters({along.path: value})
        names = [] if along is None or value is None else [f"{along.path} = {value:.6g}"]
        for at, start in starts:
            refuse_singular_start(variant, start, at)
            label = "; ".join([*names, *([_start_text(subject, start)] if spec.starts else [])])
            cases.append(SystemRunCase(label, value, variant, start))
    settings = LongRunSettings(spec.until, spec.tolerance, spec.engine)
    return SystemRunPlan(spec, subject, tuple(cases), bool(spec.starts or spec.values), settings)


def _start_text(subject: UserSystem, start: np.ndarray) -> str:
    """Return a start in words: the states that are not zero there."""
    places = [f"{name} = {x:.6g}" for name, x in zip(subject.system.state_names, start.tolist(), strict=True) if x]
    return ", ".join(places) or "all states 0"


def compute_system_run(plan: SystemRunPlan, work: Work) -> Iterator[SystemRunFindings]:
    """Yield the findings after each run."""
    runs, count = list[LongRun](), len(plan.cases)
    for k, case in enumerate(plan.cases):
        part = work.part(f"run {k + 1}", k / count, (k + 1) / count) if plan.several else work
        unit = partial(long_run, case.subject, case.start, plan.settings, partial(_tell_time, part.open_ended, plan.spec.until))
        runs.append(part.unit("run", unit))
        yield SystemRunFindings(plan, tuple(runs))


def _tell_time(work: Work, until: float | None, time: float) -> None:
    work.report(time / until if until else 0.0, f"t = {time:.4g}")
