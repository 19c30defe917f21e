"""Question and machine -> plan -> findings: the start of each run, its length, and its equations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from wucht.dynamics.limit_sets.long_run import INTERVALS
from wucht.dynamics.parameters import parameter_of, values_of
from wucht.dynamics.run_ups.contacts import ContactCheck, check_contacts
from wucht.dynamics.run_ups.horizon import numbers_per_sample
from wucht.dynamics.run_ups.neighbours import Neighbour, neighbour_of
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.run_ups.run_variations import start_states
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.studies.run_up.spec import RunUp
from wucht.studies.run_up.system_run import SystemRunFindings, SystemRunPlan, compute_system_run, system_run_plan


@dataclass(frozen=True)
class RunCase:
    """One run. value: of the parameter ``along``, if there is one. run: the case to be integrated."""

    label: str
    start: Mapping[str, Any]
    value: float | None
    run: RunUpCase


@dataclass(frozen=True)
class Plan:
    """The runs, at least one. machine: as given. several: True if the question has many runs."""

    spec: RunUp
    machine: Machine
    cases: tuple[RunCase, ...]
    several: bool


def prepare(spec: RunUp, subject: Machine | UserSystem) -> Plan | SystemRunPlan:
    """Return the plan. Raises ``InputError`` where the question does not fit the subject."""
    return _machine_plan(spec, subject) if isinstance(subject, Machine) else system_run_plan(spec, subject)


def _machine_plan(spec: RunUp, machine: Machine) -> Plan:
    if spec.over == "psi" and not any(b.about == machine.rotor.name for b in machine.bodies):
        raise InputError("study.over", spec.over, "must be 'time' or 'phi': no body turns about the rotor")
    cases, starts = [], spec.starts or (spec.start,)
    values = (None,) if spec.along is None else values_of(machine, parameter_of(machine, spec.along), spec.values)
    for value in values:
        variant = machine if spec.along is None or value is None else machine.with_values({spec.along: value})
        cases += [_case(spec, variant, start, value) for start in starts]
    return Plan(spec, machine, tuple(cases), bool(spec.starts or spec.values))


def numbers(plan: Plan | SystemRunPlan) -> float:
    """Bound the count of stored numbers."""
    if isinstance(plan, SystemRunPlan):
        return float(2 * (2 * INTERVALS + 1) * len(plan.subject.system.states) * len(plan.cases))
    return sum(run.horizon.samples * len(run.models) * numbers_per_sample(run.machine) for run in (c.run for c in plan.cases))


def _case(spec: RunUp, machine: Machine, start: Mapping[str, Any], value: float | None) -> RunCase:
    """Return one run of a question. Raises ``InputError``."""
    if spec.deck is not None and (machine.dimensionless or "y" not in machine.labels):
        raise InputError("study.deck", spec.deck, "allowed only for a machine with units whose carrier moves up and down (y)")
    run = RunUpCase.of(machine, start, spec.settings)
    return RunCase(_label(spec, run.machine, start, value), start, value, run)


def _label(spec: RunUp, machine: Machine, start: Mapping[str, Any], value: float | None) -> str:
    """Return the label of a run in a legend: the value of the parameter, the start, or both."""
    parts = [] if value is None or spec.along is None else [machine.parameters[spec.along].value_text(value)]
    if spec.starts:
        units = {name: state.unit.si for name, state in start_states(machine).items()}
        parts.append(", ".join(f"{k} = {_value_text(v, units.get(k, ''))}" for k, v in start.items()) or "at rest")
    return "; ".join(parts)


def _value_text(value: Any, unit: str = "") -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} {_value_text(v)}" for k, v in value.items()) + "}"
    return f"{value:.6g} {unit}".rstrip() if isinstance(value, int | float) else str(value)


@dataclass(frozen=True)
class Findings:
    """The motions of each run, of the full equations first. finished_count: of the finished runs. neighbours: of
    these, where small differences grow. contact_checks: of these, where bodies touch."""

    motions: tuple[tuple[Motion, ...], ...]
    finished_count: int
    neighbours: tuple[Neighbour | None, ...] = ()
    contact_checks: tuple[ContactCheck | None, ...] = ()


_SHARE_BESIDE_CONTACTS = 0.4  # of the work in a run, where it may be made again with stiffer contacts


def run(plan: Plan | SystemRunPlan, work: Work) -> Iterator[Findings | SystemRunFindings]:
    """Integrate the runs; yield the findings after each leg."""
    if isinstance(plan, SystemRunPlan):
        yield from compute_system_run(plan, work)
        return
    done, neighbours, checks = list[tuple[Motion, ...]](), list[Neighbour | None](), list[ContactCheck | None]()
    count = len(plan.cases)
    for k, case in enumerate(plan.cases):
        part = work.part(f"run {k + 1}", k / count, (k + 1) / count) if plan.several else work
        motions: tuple[Motion, ...] = ()
        share = _SHARE_BESIDE_CONTACTS if case.run.machine.tracks else 1.0
        for motions in run_up(case.run, part.part("", 0.0, share)):
            if not done:  # later runs are reported when they are complete: partial ones would count as finished
                yield Findings((motions,), 0)
        check = check_contacts(motions[0], part.part("contacts", share, 1.0))
        if check is not None and check.is_stiffer:
            motions = (check.motion, *motions[1:])
        done.append(motions)
        checks.append(check)
        neighbours.append(neighbour_of(motions[0], part.part("neighbour", 1.0, 1.0)))
        yield Findings(tuple(done), len(done), tuple(neighbours), tuple(checks))
