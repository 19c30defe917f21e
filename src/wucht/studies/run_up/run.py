"""Plan -> findings: each run integrated leg by leg, and the verdict on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled import CompiledSystem, Integrator, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.results.outcomes import Outcome
from wucht.studies.observables import Rows
from wucht.studies.run_up.model import Model
from wucht.studies.run_up.prepare import Case, Plan
from wucht.studies.run_up.spec import RunUp
from wucht.studies.run_up.verdict import Verdict, judge
from wucht.studies.work import Work

_SETTLED_TOLERANCE = 1e-5
_JUDGED_IF_COARSE = 10_000  # samples: no outcome comes of them, only phases and the like
_SAMPLES_A_LEG = 2048
_FULL_SHARE = 0.9  # of the time that a run of both models takes


@dataclass(frozen=True)
class Motion:
    """What one model did. legs: of the model's own System, ``trajectory`` all of them; ``seen``: as one of the machine."""

    case: Case
    model: Model
    compiled: CompiledSystem
    legs: tuple[Trajectory, ...]

    @cached_property
    def trajectory(self) -> Trajectory:
        """The motion in the model's own states."""
        return Trajectory.of(self.legs)

    @cached_property
    def seen(self) -> Trajectory:
        """The machine's motion."""
        return self.model.seen(self.trajectory)

    @cached_property
    def rows(self) -> Rows:
        """The states and outputs (N,) of the machine's motion, by name."""
        states = dict(zip(self.case.machine.system.state_names, self.seen.states, strict=True))
        return states | dict(self.model.outputs(self.trajectory, self.seen))

    @cached_property
    def verdict(self) -> Verdict:
        """What became of the machine."""
        machine, horizon, seen = self.case.machine, self.case.horizon, self.seen
        free = free_at_end(machine, seen.end_time)
        if not horizon.too_coarse:
            return judge(machine, seen, free)
        verdict = judge(machine, seen.tail(_JUDGED_IF_COARSE), free)
        if verdict.outcome is Outcome.FAILED:
            return verdict
        return replace(verdict, outcome=Outcome.UNIDENTIFIED, advice="too few samples a turn are stored to tell")

    @property
    def complete(self) -> bool:
        """Whether it reached its end; one that failed did not."""
        return not self.legs[-1].failure


@dataclass(frozen=True)
class Findings:
    """The motions of each run, of the full equations first. finished: how many runs are."""

    motions: tuple[tuple[Motion, ...], ...]
    finished: int


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate; what is found after each leg."""
    done: list[tuple[Motion, ...]] = []
    for k, case in enumerate(plan.cases):
        count = len(plan.cases)
        part = work.part(f"run {k + 1}", k / count, (k + 1) / count) if plan.several else work
        motions: tuple[Motion, ...] = ()
        for motions in run_case(plan.spec, case, part):
            if not done:  # of later runs only whole ones are shown: they would be taken for finished
                yield Findings((motions,), 0)
        done.append(motions)
        yield Findings(tuple(done), len(done))


def run_case(spec: RunUp, case: Case, work: Work) -> Iterator[tuple[Motion, ...]]:
    """The motions of one run, after each leg."""
    first, *others = case.models
    share = _FULL_SHARE if others else 1.0
    motion: Motion | None = None
    for motion in _until_the_end(spec, case, first, work.part(first.name, 0.0, share)):
        yield (motion,)
    assert motion is not None
    if not others or not motion.complete or len(motion.trajectory.time) < 2:
        return
    (slow,) = others
    for second in _at_times(spec, case, slow, motion.trajectory.time, work.part(slow.name, share, 1.0)):
        yield motion, second


def _until_the_end(spec: RunUp, case: Case, model: Model, work: Work) -> Iterator[Motion]:
    """A model's motion as far as the horizon, an event, or the verdict lets it go."""
    horizon = case.horizon
    compiled = compile_system(model.system, spec.tolerance, model.events(horizon.events), spec.engine)
    integrator = compiled.engine.integrator()
    legs: tuple[Trajectory, ...] = (_at_start(compiled, model),)
    yield Motion(case, model, compiled, legs)
    for grid, goal, looked_at in horizon.legs():
        end = max(horizon.expected_end, goal)
        leg = partial(_leg, compiled, integrator, legs[-1], grid, horizon.energy, work, end)
        legs = (*legs, work.unit(f"leg {len(legs)}", leg))
        motion = Motion(case, model, compiled, legs)
        yield motion
        if legs[-1].ended or (looked_at and horizon.open_ended and _decided(case, motion.verdict)):
            return


def _at_times(spec: RunUp, case: Case, model: Model, time: np.ndarray, work: Work) -> Iterator[Motion]:
    """A model's motion at given times (N,)."""
    compiled = compile_system(model.system, spec.tolerance, (), spec.engine)
    integrator = compiled.engine.integrator()
    legs: tuple[Trajectory, ...] = (_at_start(compiled, model),)
    for begin in range(0, len(time) - 1, _SAMPLES_A_LEG):
        grid = time[begin : begin + _SAMPLES_A_LEG + 1]
        leg = partial(_leg, compiled, integrator, legs[-1], grid, case.horizon.energy, work, float(time[-1]))
        legs = (*legs, work.unit(f"leg {len(legs)}", leg))
        yield Motion(case, model, compiled, legs)
        if legs[-1].ended:
            return


def _at_start(compiled: CompiledSystem, model: Model) -> Trajectory:
    """The single sample from which a motion begins."""
    works = {q.name: np.zeros(1) for q in compiled.system.quadratures}
    state = np.concatenate([model.initial, np.zeros(len(works))])
    return Trajectory(np.zeros(1), model.initial[:, None], works, np.array(model.values, float), 0.0, state)


def _leg(
    compiled: CompiledSystem,
    integrator: Integrator,
    before: Trajectory,
    grid: np.ndarray,
    energy: float,
    work: Work,
    end: float,
) -> Trajectory:
    """The part of a motion over a grid that begins at the last sample of the part before. end: of the whole, for progress."""
    found = integrate(compiled, before.end_state, before.parameters, grid, lambda t: work.report(t / end), energy, integrator)
    if found.interrupted:
        raise KeyboardInterrupt
    return found


def _decided(case: Case, verdict: Verdict) -> bool:
    if case.horizon.until_settled:
        return verdict.settled_within(_SETTLED_TOLERANCE)
    return verdict.outcome in (Outcome.STOPPED, Outcome.OSCILLATING)  # the turns asked for will never be made


def free_at_end(machine: Machine, end: float) -> float | None:
    """The speed that the drive reaches without vibration, with the parameters of the end of a run."""
    return free_speed(machine.at(end), machine.rotor, end)
