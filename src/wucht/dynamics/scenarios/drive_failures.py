"""Drives that fail one by one: a machine in operation, and a run without each of its drives from there on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

from wucht.dynamics.run_ups.drive_losses import RunningState, case_without_drive
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.operating_state import OperationCase
from wucht.dynamics.run_ups.run_up import Motion, run_up
from wucht.dynamics.scenarios.runs_in_turn import runs_in_turn
from wucht.dynamics.work import Work
from wucht.machines.parts.base import Drive

_OPERATION_SHARE = 0.25  # of the time that all runs take


@dataclass(frozen=True)
class DrivenRun:
    """A run with some of the drives. drives: of the machine in operation, of which one may be switched off."""

    motion: Motion
    drives: tuple[Drive, ...]

    @cached_property
    def state(self) -> RunningState:
        """The state at its end."""
        return RunningState.of(self.motion, self.drives)

    @cached_property
    def course(self) -> MotionCourse:
        """Its course."""
        return MotionCourse.from_turns(self.motion.case.machine, self.motion.trajectory, self.motion.observation)


@dataclass(frozen=True)
class OperationRun:
    """A machine in operation, and what becomes of it without each of its drives: as far as these runs are computed.

    failures: the runs after the failure, by the body of the drive. finished_count: how many are.
    """

    operation: OperationCase
    before: DrivenRun
    failures: Mapping[str, DrivenRun] = field(default_factory=dict)
    finished_count: int = 0

    @property
    def motions(self) -> list[Motion]:
        """The motions before the failure and after it."""
        return [self.before.motion, *(run.motion for run in self.failures.values())]


def failures_in_turn(
    operations: Sequence[OperationCase], settings: RunSettings, work: Work
) -> Iterator[tuple[OperationRun, ...]]:
    """Let each drive fail after each operation; yield the runs so far after each leg. settings: of the runs after a failure."""
    return runs_in_turn(operations, partial(_failures_of, settings), work, "operation")


def _failures_of(settings: RunSettings, operation: OperationCase, work: Work) -> Iterator[OperationRun]:
    drives = operation.case.machine.drives
    for (motion,) in run_up(operation.case, work.part("", 0.0, _OPERATION_SHARE)):
        run = OperationRun(operation, DrivenRun(motion, drives))
        yield run
    if motion.trajectory.failure:
        return
    for i, drive in enumerate(drives):
        begin, end = (_OPERATION_SHARE + (1 - _OPERATION_SHARE) * n / len(drives) for n in (i, i + 1))
        case = case_without_drive(motion, drive, settings)
        for (latest,) in run_up(case, work.part(f"without {drive.on}", begin, end)):
            run = replace(run, failures={**run.failures, drive.on: DrivenRun(latest, drives)}, finished_count=i)
            yield run
    yield replace(run, finished_count=len(drives))
