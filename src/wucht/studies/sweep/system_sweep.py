"""A sweep of equations of a table ``[system]``: question and equations -> plan -> findings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.limit_sets.stepped_parameter import Way, settling_span, step_through
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.system_states import refuse_machine_keys, refuse_singular_start, states_from
from wucht.dynamics.work import Work
from wucht.files.user_system import UserSystem
from wucht.schema import Unit
from wucht.studies.sweep.spec import Sweep

_FIRST = 0.1  # share of the work until the motion has settled at the first value


@dataclass(frozen=True, eq=False)
class SystemSweepPlan:
    """Sweep of equations. ways: first and last value of ``"up"`` and ``"down"``, in their order. points: values of each."""

    subject: UserSystem
    path: str
    ways: Mapping[str, tuple[float, float]]
    points: int
    start: np.ndarray
    settings: LongRunSettings


@dataclass(frozen=True, eq=False)
class SystemSweepFindings:
    """Finished ways. span: time at each value."""

    plan: SystemSweepPlan
    span: float
    ways: dict[str, Way] = field(default_factory=dict)


def system_sweep_plan(spec: Sweep, subject: UserSystem) -> SystemSweepPlan:
    """Return the plan. Raises ``InputError`` where the question does not fit the equations."""
    refuse_machine_keys(spec, ("rate", "jump_tolerance"))
    parameter = parameter_of(subject, spec.along)
    low, high = range_of(Unit(parameter.unit, parameter.long_name), spec.range)
    ways = {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if spec.direction in (way, "both")}
    start = states_from(subject.system, spec.start, "study.start")
    refuse_singular_start(subject.with_parameters({parameter.path: next(iter(ways.values()))[0]}), start, "study.start")
    return SystemSweepPlan(
        subject, parameter.path, ways, spec.points, start, LongRunSettings(None, spec.tolerance, spec.engine)
    )


def compute_system_sweep(plan: SystemSweepPlan, work: Work) -> Iterator[SystemSweepFindings]:
    """Yield the findings after each way."""
    first = next(iter(plan.ways.values()))[0]
    work.report(0.0, "settling")
    at_first = plan.subject.with_parameters({plan.path: first})
    span, state = work.unit("settling", partial(settling_span, at_first, plan.start, plan.settings))
    findings = SystemSweepFindings(plan, span)
    for k, (name, ends) in enumerate(plan.ways.items()):
        begin, end = (_FIRST + (1 - _FIRST) * n / len(plan.ways) for n in (k, k + 1))
        part = work.part(name, begin, end)
        values = np.linspace(*ends, plan.points)
        step = partial(step_through, plan.subject, plan.path, values, state, span, plan.settings)
        way, state = part.unit("values", partial(step, partial(_report_share, part, name)))
        findings = SystemSweepFindings(plan, span, findings.ways | {name: way})
        yield findings
        if way.failure:
            return


def _report_share(part: Work, name: str, share: float) -> None:
    part.report(share, name)
