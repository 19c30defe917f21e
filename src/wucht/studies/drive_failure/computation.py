"""Question and machine -> plan -> findings: the machine in operation, and a run without each of its drives from there on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from wucht.dynamics.run_ups.drive_losses import case_without_drive, check_drives
from wucht.dynamics.run_ups.horizon import numbers_per_sample
from wucht.dynamics.run_ups.operating_state import machine_in_operation, operating_states
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.studies.drive_failure.spec import DriveFailure

_OPERATION_SHARE = 0.25  # of the time that all runs take


@dataclass(frozen=True)
class OperationPlan:
    """The run until the failure. label: of the configuration in which it begins, empty at rest. rest_reason: why the carrier
    begins at rest."""

    case: RunUpCase
    label: str
    rest_reason: str = ""


@dataclass(frozen=True)
class Plan:
    """The runs until the failure, one for each configuration, and the drives that fail after each.

    reason: why the machine is run up from rest, empty where it is not or as requested.
    """

    spec: DriveFailure
    machine: Machine
    operations: tuple[OperationPlan, ...]
    drives: tuple[Drive, ...]
    reason: str = ""


def prepare(spec: DriveFailure, machine: Machine, watch: Callable[[], None] | None = None) -> Plan:
    """The plan. watch: called often.

    Raises ``InputError`` where fewer than two rotors are driven, and where the start does not fit the machine.
    """
    check_drives(machine)
    driven, settings, reason = machine_in_operation(machine), spec.operation_settings, ""
    if spec.begin != "rest":
        reason = "no synchronous configuration of the rotors is stable"
        try:
            states = operating_states(machine, spec.start, watch)
        except InputError as error:
            if error.key.startswith("study.start"):
                raise
            states, reason = (), error.explanation
        operations = tuple(
            OperationPlan(RunUpCase.from_state(s.machine, s.state, settings), s.label, s.rest_reason) for s in states
        )
        if operations:
            return Plan(spec, driven, operations, driven.drives)
        if spec.begin == "operation":
            explanation = f"not possible here: {reason}; study.begin = 'rest' runs the machine up at the phases of study.start"
            raise InputError("study.begin", spec.begin, explanation, code="no-stable-phases")
    return Plan(spec, driven, (OperationPlan(RunUpCase.of(driven, spec.start, settings), ""),), driven.drives, reason)


def numbers(plan: Plan) -> float:
    """Bound the count of stored numbers: two runs at a time, and the state after each."""
    return sum(2 * o.case.horizon.samples * numbers_per_sample(o.case.machine) for o in plan.operations[:1])


@dataclass(frozen=True)
class FailureRun:
    """The run after a failure. drive: that fails."""

    drive: Drive
    motion: Motion


@dataclass(frozen=True)
class OperationRun:
    """The run until the failure, and those after it, of each drive in turn: as far as they are computed."""

    plan: OperationPlan
    motion: Motion
    failures: tuple[FailureRun, ...] = ()


@dataclass(frozen=True)
class Findings:
    """The runs so far. finished_count: number of failures whose run is finished."""

    operations: tuple[OperationRun, ...]
    finished_count: int


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate the runs; yield the findings after each leg."""
    complete, finished_count, total = list[OperationRun](), 0, len(plan.operations)
    for k, operation in enumerate(plan.operations):
        part = work.part(f"operation {k + 1}" if total > 1 else "operation", k / total, (k + 1) / total)
        motion, failures = None, list[FailureRun]()
        for (motion,) in run_up(operation.case, part.part("", 0.0, _OPERATION_SHARE)):
            yield Findings((*complete, OperationRun(operation, motion)), finished_count)
        assert motion is not None
        if not motion.trajectory.failure:
            for i, drive in enumerate(plan.drives):
                begin, end = (_OPERATION_SHARE + (1 - _OPERATION_SHARE) * n / len(plan.drives) for n in (i, i + 1))
                case = case_without_drive(motion, drive, plan.spec.failure_settings)
                latest = None
                for (latest,) in run_up(case, part.part(f"without {drive.on}", begin, end)):
                    run_so_far = FailureRun(drive, latest)
                    yield Findings((*complete, OperationRun(operation, motion, (*failures, run_so_far))), finished_count)
                assert latest is not None
                failures.append(FailureRun(drive, latest))
                finished_count += 1
        complete.append(OperationRun(operation, motion, tuple(failures)))
    yield Findings(tuple(complete), finished_count)
