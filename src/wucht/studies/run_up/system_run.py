"""A run of equations of a table ``[system]``: question and equations -> plan -> findings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.long_run import LongRun, LongRunSettings, long_run
from wucht.dynamics.system_states import refuse_machine_keys, states_from
from wucht.dynamics.work import Work
from wucht.files.user_system import UserSystem
from wucht.studies.run_up.spec import RunUp

_KEYS_OF_MACHINES = ("turns", "model", "inertia", "order", "speed_limit", "over", "deck", "starts", "along", "values")


@dataclass(frozen=True, eq=False)
class SystemRunPlan:
    """The run of equations. start: (n,)."""

    spec: RunUp
    subject: UserSystem
    start: np.ndarray
    settings: LongRunSettings


@dataclass(frozen=True, eq=False)
class SystemRunFindings:
    """The finished run."""

    plan: SystemRunPlan
    run: LongRun


def system_run_plan(spec: RunUp, subject: UserSystem) -> SystemRunPlan:
    """Return the plan. Raises ``InputError`` for a key that holds for machines only, or a state that the equations lack."""
    refuse_machine_keys(spec, _KEYS_OF_MACHINES)
    start = states_from(subject.system, spec.start, "study.start")
    return SystemRunPlan(spec, subject, start, LongRunSettings(spec.until, spec.tolerance, spec.engine))


def compute_system_run(plan: SystemRunPlan, work: Work) -> Iterator[SystemRunFindings]:
    """Yield the finished run."""
    report = work.open_ended

    def tick(time: float) -> None:
        report.report(time / plan.spec.until if plan.spec.until else 0.0, f"t = {time:.4g}")

    yield SystemRunFindings(plan, work.unit("run", partial(long_run, plan.subject, plan.start, plan.settings, tick)))
