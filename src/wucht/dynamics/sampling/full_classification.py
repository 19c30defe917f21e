"""Full classification of members that have not settled: each is observed turn by turn and judged as a run-up is."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.averaged_equations import states_with_fast_parts
from wucht.dynamics.run_ups.horizon import Horizon, distinctive_times
from wucht.dynamics.run_ups.run_up import free_speed_at_end
from wucht.dynamics.run_ups.run_up_models import FullModel, SlowModel, slow_model
from wucht.dynamics.sampling.ensemble_equations import Variants, parameters_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes, subprogress
from wucht.dynamics.verdicts.certificate import TOLERANCE, MotionEnd, certified_verdict
from wucht.dynamics.verdicts.judging import judge
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver, Observation, fastest_speeds
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import TaskReport
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.ensembles.ensemble import compile_ensemble, tiles
from wucht.numerics.ensembles.members import Chunk, EnsembleResult, Members, Pace, Status
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.trajectory import Trajectory

_SAMPLES_PER_TURN, _TURNS_PER_CHUNK = 16, 200  # samples a turn of the fastest motion that is expected, and turns a chunk
_DENSE_SPEED_FACTOR, _MOST_DOUBLINGS = 1.5, 10  # times as fast as expected: still sampled densely enough; doublings
_MEMBERS_PER_TILE = 16  # those of a vector: their samples are held at once
_REGISTERS = 64  # numbers: a whole number of vector registers of any processor
_SETTLED_WIDTH = 1e-3  # see ``Verdict.settled_within``
_FINAL_OUTCOMES = (Outcome.STOPPED, Outcome.OSCILLATING, Outcome.NOT_STARTED)


def classify_members(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: TaskReport
) -> MemberOutcomes:
    """Classify members that start in states (n, M) of the machine's System. horizon: of a run-up of the machine."""
    doublings, parts, order, done = _doublings(starts, variants, horizon), list[MemberOutcomes](), list[np.ndarray](), 0
    for k in np.unique(doublings).tolist():
        members = np.flatnonzero(doublings == k)
        finer_horizon = replace(horizon, step=horizon.step / 2**k, span=horizon.span / 2**k)
        finer_question = replace(question, longest=question.longest * 2**k)
        progress = subprogress(report, done / len(doublings), len(members) / len(doublings))
        for ends in observe_members(
            finer_question, starts[:, members], variants.select(members).compact, finer_horizon, progress
        ):
            parts.append(_outcomes(ends))
        order.append(members)
        done += len(members)
    return MemberOutcomes.join_in_order(parts, order)


def _outcomes(ends: EnsembleResult[ObserverState]) -> MemberOutcomes:
    """Return the outcomes of some members."""
    record = ends.record
    outcome = np.where(ends.status == Status.FAILED, OUTCOMES.index(Outcome.FAILED), record.outcome).astype(np.int8)
    largest = np.array([s.largest for s in record.observations])
    return MemberOutcomes(outcome, record.settling_time, largest, ends.times, tuple(sorted(ends.sentences.items())))


def _doublings(starts: np.ndarray, variants: Variants, horizon: Horizon) -> np.ndarray:
    """The number of doublings of the sampling density for each member (M,): it may turn faster than the machine of the
    question, by its start or its parameters."""
    drive_speeds = [
        max(abs(free_speed(at, r, t) or 0.0) for t in distinctive_times(m) for at in (m.at(t),) for r in m.rotors)
        for m in variants.machines
    ]
    fastest = np.maximum(np.array(drive_speeds)[variants.machine_index], fastest_speeds(variants.machines[0], starts))
    return np.asarray(np.ceil(np.log2((fastest / _sampled_speed(horizon)).clip(1.0, 2.0**_MOST_DOUBLINGS))).astype(int))


def begins_fast(starts: np.ndarray, machine: Machine, horizon: Horizon) -> np.ndarray:
    """Mask (M,) of the members that start so fast that only the full classification samples their motion densely enough."""
    return fastest_speeds(machine, starts) > _sampled_speed(horizon)


def _sampled_speed(horizon: Horizon) -> float:
    """The fastest speed that is sampled densely enough."""
    return _DENSE_SPEED_FACTOR * 2 * math.pi / (horizon.step * horizon.samples_per_turn)


def observe_members(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: TaskReport
) -> Iterator[EnsembleResult[ObserverState]]:
    """Observe some members at a time: yield the observation of each, and the states in which they ended."""
    models = tuple(
        model_of(question, m, starts[:, np.flatnonzero(variants.machine_index == i)[0]])
        for i, m in enumerate(variants.machines)
    )
    system, turn = models[0].system, horizon.step * horizon.samples_per_turn
    initial = np.stack(
        [model_of(question, models[v].machine, s).initial for v, s in zip(variants.machine_index, starts.T, strict=True)]
    )
    chunk = _TURNS_PER_CHUNK * turn
    if question.until is not None:
        chunk = question.until / math.ceil(question.until / chunk)
    end = question.until or question.longest * turn
    pace = Pace(chunk, max(1, round(_SAMPLES_PER_TURN * chunk / turn)), end)
    observer = ClassifyingObserver(
        models, variants.machine_index, horizon.span, Noise.of(question.tolerance), pace, question.until is not None
    )
    members = Members.of(initial, parameters_of(system, variants))
    yield from tiles(compile_ensemble(system, question.tolerance), members, observer, pace, _MEMBERS_PER_TILE, report=report)


def model_of(question: EnsembleQuestion, machine: Machine, start: np.ndarray) -> FullModel:
    """Return the equations of a member that starts in a state (n,) of the machine's System."""
    if question.model == "full":
        return FullModel(machine, start)
    return slow_model(machine, start, question.inertia, question.order)


@dataclass(frozen=True)
class ObserverState:
    """The record of M members: their numbers, observations, outcomes so far, and settling times, nan before they are known."""

    number: np.ndarray
    observations: np.ndarray
    outcome: np.ndarray
    settling_time: np.ndarray


@dataclass(frozen=True)
class ClassifyingObserver:
    """The observer. models: of the machines that differ; model_index: that of each member. span, noise: see
    ``MotionObserver``. final: all are judged at the end of the pace; else each whenever its time has doubled."""

    models: tuple[FullModel, ...]
    model_index: np.ndarray
    span: float
    noise: Noise
    pace: Pace
    final: bool

    @np.errstate(all="ignore")  # see ``ScreeningObserver.begin``
    def begin(self, members: Members) -> ObserverState:
        """Return the first record: see ``Observer``."""
        count = len(members)
        observations, settling_time = np.empty(count, object), np.full(count, np.nan)
        record = ObserverState(
            members.numbers, observations, np.full(count, OUTCOMES.index(Outcome.UNIDENTIFIED), np.int8), settling_time
        )
        return replace(record, observations=self._observe(record, np.zeros(1), members.starts.T[None]))

    @np.errstate(all="ignore")  # see ``ScreeningObserver.update``
    def update(self, record: ObserverState, chunk: Chunk) -> tuple[ObserverState, np.ndarray]:
        """Return the record after a chunk, and which members have ended: see ``Observer``."""
        times, samples = chunk.times, chunk.samples
        record = replace(record, observations=self._observe(record, times, samples))
        outcome, settling_time = record.outcome.copy(), record.settling_time.copy()
        has_ended = np.zeros(len(record.number), bool)
        chunks = round(times[-1] / self.pace.chunk)
        if (self.final and times[-1] < self.pace.until) or (not self.final and chunks.bit_count() > 1):
            return record, has_ended
        for i, number in enumerate(record.number):
            model = self.models[self.model_index[number]]
            verdict = member_verdict(model, record.observations[i], samples[-1, :, i])
            outcome[i] = OUTCOMES.index(verdict.outcome)
            settling_time[i] = np.nan if verdict.settling_time is None else verdict.settling_time
            is_final = verdict.outcome in _FINAL_OUTCOMES or verdict.never_parts
            has_ended[i] = verdict.settled_within(_SETTLED_WIDTH) or is_final
        return replace(record, outcome=outcome, settling_time=settling_time), has_ended

    def final_record(self, record: ObserverState) -> ObserverState:
        """Return all of the record: see ``Observer``."""
        return record

    def _observe(self, record: ObserverState, times: np.ndarray, samples: np.ndarray) -> np.ndarray:
        """Return the observation of each member (M,) after samples (K, k, M)."""
        observations, variants = np.empty(len(record.number), object), self.model_index[record.number]
        for variant in np.unique(variants):
            rows, model = np.flatnonzero(variants == variant), self.models[variant]
            observer = MotionObserver(model.machine, self.span, self.noise)
            # All at once, whole registers of each member: so the last bit of a number does not depend on those beside it.
            index = np.append(np.arange(count := len(times)), np.full(-count % _REGISTERS, count - 1))
            all_samples = observer.samples(_motion(model, np.tile(times[index], len(rows)), samples[index][:, :, rows]))
            for k, i in enumerate(rows):
                first = k * len(index)
                observations[i] = observer.update_from_samples(
                    record.observations[i] or observer.begin(), all_samples.part(slice(first, first + count))
                )
        return observations


def member_verdict(model: FullModel, observation: Observation, state: np.ndarray) -> Verdict:
    """Judge a member that was observed until it is in a state (k,) of its equations."""
    machine = model.machine
    verdict = judge(machine, observation, free_speed_at_end(machine, observation, observation.end_time))
    equations, values = partial(compile_system, model.system, TOLERANCE), np.array(model.parameter_values)
    return certified_verdict(machine, verdict, MotionEnd(model.system, equations, values, state, observation.end_time))


def _motion(model: FullModel, time: np.ndarray, samples: np.ndarray) -> Trajectory:
    """Return the machine's motion from samples (K, k, M), one member after the other."""
    machine, states = model.machine, samples.transpose(1, 2, 0).reshape(samples.shape[1], -1)
    if isinstance(model, SlowModel):
        states = states_with_fast_parts(model.averaged_equations, time, states[:-1], states[-1])
    return Trajectory(time, states, {}, np.array(machine.system.values(machine.values)), float(time[-1]), states[:, -1])
