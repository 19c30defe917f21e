"""Plan -> findings: each run integrated leg by leg, and the verdict on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.trajectory import Trajectory
from wucht.studies.motion.observation import Observation
from wucht.studies.motion.verdict import Verdict, judge
from wucht.studies.motion.watched import Leg, Watched
from wucht.studies.observables import Rows
from wucht.studies.run_up.horizon import SPEED_LIMIT, Grid
from wucht.studies.run_up.model import FullModel
from wucht.studies.run_up.prepare import Case, Plan
from wucht.studies.run_up.spec import RunUp
from wucht.studies.work import Work

_SAMPLES_A_LEG = 2048
_FULL_SHARE = 0.9  # of the time that a run of both models takes


@dataclass(frozen=True)
class Motion:
    """What one model did.

    trajectory: what is stored, of the model's own System; ``seen`` is the machine's. last: the last leg.
    """

    case: Case
    model: FullModel
    watched: Watched[Observation]
    trajectory: Trajectory
    last: Leg[Observation]

    @cached_property
    def seen(self) -> Trajectory:
        """The machine's motion."""
        return self.model.seen(self.trajectory)

    @property
    def rows(self) -> Rows:
        """The states and outputs (N,) of the machine's motion, by name: not kept, as they are more than what is stored."""
        return self.model.rows(self.trajectory, self.seen)

    @property
    def compiled(self) -> CompiledSystem:
        """What is integrated."""
        return self.watched.compiled

    @cached_property
    def observation(self) -> Observation:
        """What was seen of it."""
        return self.watched.observation(self.last)

    @cached_property
    def verdict(self) -> Verdict:
        """What became of the machine."""
        machine, last = self.case.machine, self.trajectory
        free = free_speed(machine.at(last.end_time), machine.rotor, last.end_time)
        return judge(machine, self.observation, free, last.failure, last.stopped_by == SPEED_LIMIT)


@dataclass(frozen=True)
class Findings:
    """The motions of each run, of the full equations first. finished: how many runs are."""

    motions: tuple[tuple[Motion, ...], ...]
    finished: int


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate; the findings after each leg."""
    done: list[tuple[Motion, ...]] = []
    count = len(plan.cases)
    for k, case in enumerate(plan.cases):
        part = work.part(f"run {k + 1}", k / count, (k + 1) / count) if plan.several else work
        motions: tuple[Motion, ...] = ()
        for motions in run_case(plan.spec, case, part):
            if not done:  # of later runs only whole ones are shown: they would be taken for finished
                yield Findings((motions,), 0)
        done.append(motions)
        yield Findings(tuple(done), len(done))


def run_case(spec: RunUp, case: Case, work: Work) -> Iterator[tuple[Motion, ...]]:
    """The motions of one run, after each leg; a second model goes as far as the first did."""
    first, *others = case.models
    share = _FULL_SHARE if others else 1.0
    for motion in _motions(spec, case, first, case.horizon.events, None, work.part(first.name, 0.0, share)):
        yield (motion,)
    time = motion.trajectory.time
    if motion.trajectory.failure or len(time) < 2:
        return
    for other in others:
        for second in _motions(spec, case, other, (), time, work.part(other.name, share, 1.0)):
            yield motion, second


def _motions(
    spec: RunUp, case: Case, model: FullModel, events: tuple[Event, ...], at: np.ndarray | None, work: Work
) -> Iterator[Motion]:
    """A model's motion after each leg, as far as the legs, an event, or the verdict let it go. at: samples (N,) to store; None:
    as the motion asks."""
    compiled = compile_system(model.system, spec.tolerance, model.events(events), spec.engine)

    watched = Watched(case.watch, compiled, model.seen, case.horizon.vibration, case.horizon.energy)
    last = watched.begin(model.initial, model.values)
    motion = Motion(case, model, watched, last.stored, last)
    yield motion
    if last.stored.ended:
        return

    def rate() -> float:
        return watched.rate(last)

    for count, grid in enumerate(case.horizon.legs(rate) if at is None else _given(at), 1):
        report, closest = partial(_report, work, grid.end), grid.closest if at is None else None
        last = work.unit(f"leg {count}", partial(watched.leg, last, grid.samples, report, closest))
        motion = Motion(case, model, watched, motion.trajectory.joined(last.stored), last)
        yield motion
        if last.stored.ended or (grid.judged and case.horizon.decided(motion.verdict)):
            return


def _given(time: np.ndarray) -> Iterator[Grid]:
    """Legs over given samples (N,)."""
    for i in range(0, len(time) - 1, _SAMPLES_A_LEG):
        yield Grid(time[i : i + _SAMPLES_A_LEG + 1], 0.0, time[-1], False)


def _report(work: Work, end: float, time: float) -> None:
    work.report(time / end)
