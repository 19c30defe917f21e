"""Full classification of members that do not simply come to rest: each is observed turn by turn and judged as a run-up is."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.averaged import FullMotion
from wucht.dynamics.run_ups.horizon import Horizon
from wucht.dynamics.run_ups.run_up_models import FullModel, SlowModel, slow_model
from wucht.dynamics.sampling.ensemble_equations import Numbered, Variants, parameters_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes, Report, part_of
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import Watch, fastest_in_each
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.dynamics.verdicts.verdict import judge
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.ensembles.ensemble import compile_ensemble, tiles
from wucht.numerics.ensembles.members import Ends, Members, Pace, Status
from wucht.numerics.flow.trajectory import Trajectory

_PER_TURN, _TURNS = 16, 200  # samples a turn of the fastest motion that is expected, and turns a chunk
_FASTER, _MOST = 1.5, 10  # times as fast as expected: still sampled densely enough; doublings
_TILE = 32  # members: their samples are held at once
_REGISTERS = 64  # numbers: a whole number of vector registers of any processor
_SETTLED = 1e-3  # see ``Verdict.settled_within``
_OVER = (Outcome.STOPPED, Outcome.OSCILLATING)


def looked_at(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: Report
) -> MemberOutcomes:
    """Classify members that start in states (n, M) of the machine's System. horizon: of a run-up of the machine."""
    doublings, parts, order, done = _doublings(starts, variants, horizon), list[MemberOutcomes](), list[np.ndarray](), 0
    for k in np.unique(doublings).tolist():
        mine = np.flatnonzero(doublings == k)
        finer = replace(horizon, step=horizon.step / 2**k, span=horizon.span / 2**k)
        asked = replace(question, longest=question.longest * 2**k)
        told = part_of(report, done / len(doublings), len(mine) / len(doublings))
        for ends in watched(asked, starts[:, mine], variants.taken(mine).compact, finer, told):
            parts.append(_outcomes(ends))
        order.append(mine)
        done += len(mine)
    return MemberOutcomes.joined(parts).taken(np.argsort(np.concatenate(order)))


def _outcomes(ends: Ends[Watching]) -> MemberOutcomes:
    """Return the outcomes of some members."""
    record = ends.record
    outcome = np.where(ends.status == Status.FAILED, OUTCOMES.index(Outcome.FAILED), record.outcome).astype(np.int8)
    largest = np.array([s.largest for s in record.seen])
    return MemberOutcomes(outcome, record.settling, largest, ends.times, tuple(sorted(ends.sentences.items())))


def _doublings(starts: np.ndarray, variants: Variants, horizon: Horizon) -> np.ndarray:
    """The number of doublings of the sampling density for each member (M,): it may turn faster than the machine of the
    question, by its start or its parameters."""
    driven = [max((abs(free_speed(m, r) or 0.0) for r in m.rotors), default=0.0) for m in variants.machines]
    fastest = np.maximum(np.array(driven)[variants.of], fastest_in_each(variants.machines[0], starts))
    return np.asarray(np.ceil(np.log2((fastest / _sampled(horizon)).clip(1.0, 2.0**_MOST))).astype(int))


def begins_fast(starts: np.ndarray, machine: Machine, horizon: Horizon) -> np.ndarray:
    """Mask (M,) of the members that start so fast that only the full classification samples their motion densely enough."""
    return fastest_in_each(machine, starts) > _sampled(horizon)


def _sampled(horizon: Horizon) -> float:
    """The fastest speed that is sampled densely enough."""
    return _FASTER * 2 * math.pi / (horizon.step * horizon.samples_per_turn)


def watched(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: Report
) -> Iterator[Ends[Watching]]:
    """Observe some members at a time: yield the observation of each, and the states in which they ended."""
    models = tuple(_model(question, m, starts[:, np.flatnonzero(variants.of == i)[0]]) for i, m in enumerate(variants.machines))
    system, turn = models[0].system, horizon.step * horizon.samples_per_turn
    begun = np.stack([_model(question, models[v].machine, s).initial for v, s in zip(variants.of, starts.T, strict=True)])
    chunk = _TURNS * turn
    if question.until is not None:
        chunk = question.until / math.ceil(question.until / chunk)
    end = question.until or question.longest * turn
    pace = Pace(chunk, max(1, round(_PER_TURN * chunk / turn)), end)
    look = CloserLook(models, variants.of, horizon.span, Noise.of(question.tolerance), pace, question.until is not None)
    members = Numbered(begun, parameters_of(system, variants), np.arange(len(begun)))
    for tile in tiles(compile_ensemble(system, question.tolerance), members, look, pace, _TILE, report=report):
        yield tile.ends


def _model(question: EnsembleQuestion, machine: Machine, start: np.ndarray) -> FullModel:
    if question.model == "full":
        return FullModel(machine, start)
    return slow_model(machine, start, question.inertia, question.order)


@dataclass(frozen=True)
class Watching:
    """The record of M members: their numbers, observations, outcomes so far, and settling times, nan before they are known."""

    number: np.ndarray
    seen: np.ndarray
    outcome: np.ndarray
    settling: np.ndarray


@dataclass(frozen=True)
class CloserLook:
    """The observer. models: of the machines that differ; model_index: that of each member. span, noise: see
    ``MotionObserver``. final: all are judged at the end of the pace; else each whenever its time has doubled."""

    models: tuple[FullModel, ...]
    of: np.ndarray
    span: float
    noise: Noise
    pace: Pace
    final: bool

    @np.errstate(all="ignore")  # see ``ScreeningObserver.begin``
    def begin(self, members: Members) -> Watching:
        """Return the first record: see ``Observer``."""
        assert isinstance(members, Numbered)
        count = len(members)
        seen, nothing = np.empty(count, object), np.full(count, np.nan)
        record = Watching(members.numbers, seen, np.full(count, OUTCOMES.index(Outcome.UNIDENTIFIED), np.int8), nothing)
        return replace(record, seen=self._seen(record, np.zeros(1), members.starts.T[None]))

    @np.errstate(all="ignore")  # see ``ScreeningObserver.update``
    def after(self, record: Watching, times: np.ndarray, samples: np.ndarray) -> tuple[Watching, np.ndarray]:
        """Return the record after a chunk, and which members have ended: see ``Observer``."""
        record = replace(record, seen=self._seen(record, times, samples))
        outcome, settling, over = record.outcome.copy(), record.settling.copy(), np.zeros(len(record.number), bool)
        chunks = round(times[-1] / self.pace.chunk)
        if (self.final and times[-1] < self.pace.until) or (not self.final and chunks.bit_count() > 1):
            return record, over
        for i, number in enumerate(record.number):
            machine = self.models[self.of[number]].machine
            verdict = judge(machine, record.seen[i], free_speed(machine, machine.rotor))
            outcome[i] = OUTCOMES.index(verdict.outcome)
            settling[i] = np.nan if verdict.settling_time is None else verdict.settling_time
            over[i] = verdict.settled_within(_SETTLED) or verdict.outcome in _OVER
        return replace(record, outcome=outcome, settling=settling), over

    def kept(self, record: Watching) -> Watching:
        """Return all of the record: see ``Observer``."""
        return record

    def _seen(self, record: Watching, times: np.ndarray, samples: np.ndarray) -> np.ndarray:
        """Return the observation of each member (M,) after samples (K, k, M)."""
        seen, variants = np.empty(len(record.number), object), self.of[record.number]
        for variant in np.unique(variants):
            mine, model = np.flatnonzero(variants == variant), self.models[variant]
            watch = Watch(model.machine, self.span, self.noise)
            # All at once, whole registers of each member: so the last bit of a number does not depend on those beside it.
            index = np.append(np.arange(count := len(times)), np.full(-count % _REGISTERS, count - 1))
            together = watch.samples(_motion(model, np.tile(times[index], len(mine)), samples[index][:, :, mine]))
            for k, i in enumerate(mine):
                first = k * len(index)
                seen[i] = watch.after(record.seen[i] or watch.begin(), together.part(slice(first, first + count)))
        return seen


def _motion(model: FullModel, time: np.ndarray, samples: np.ndarray) -> Trajectory:
    """Return the machine's motion from samples (K, k, M), one member after the other."""
    machine, states = model.machine, samples.transpose(1, 2, 0).reshape(samples.shape[1], -1)
    if isinstance(model, SlowModel):
        states = FullMotion(model.slow)(time, states[:-1], states[-1])
    return Trajectory(time, states, {}, np.array(machine.system.values(machine.values)), float(time[-1]), states[:, -1])
