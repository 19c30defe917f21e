"""Screening of all members at once: those that have settled are judged, those that need a full classification are marked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.dynamics.sampling.attractors import Attractor
from wucht.dynamics.sampling.ensemble_equations import Variants
from wucht.dynamics.sampling.member_quantities import MemberQuantities
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import (
    MODULATION_THRESHOLD,
    OUTCOMES,
    SPEED_TOLERANCE,
    UNBALANCE_TOLERANCE,
    Outcome,
    classify_each,
)
from wucht.dynamics.verdicts.screening import Screening, rises_of, screening_of
from wucht.machines.changes import last_change
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.ensembles.members import Chunk, Members
from wucht.numerics.observers.projection import WINDOWS

WINDOW = 16  # samples
SAMPLES = WINDOW * WINDOWS  # in each chunk, twice as many in the first one: its halves are like the chunks after it
PARTS = 2 * SAMPLES  # of the time, for which the envelopes is recorded
# Samples that are shifted a little, alike in all windows: a motion of one period can not be taken for rest.
_SHIFTS = np.append(0.5 * (np.arange(1, WINDOW) * (math.sqrt(5) - 1) / 2 % 1 - 0.5), 0.0)


@dataclass(frozen=True)
class DoublingSchedule:
    """Each chunk is as long as all before it together. first: the end of the first one; chunks: how many."""

    first: float
    chunks: int

    @classmethod
    def from_end(cls, end: float, first: float) -> DoublingSchedule:
        """Return the schedule that ends at a time, with a first chunk of about this length."""
        doublings = max(0, math.ceil(math.log2(end / first)))
        return cls(end / 2**doublings, doublings + 1)

    @property
    def end(self) -> float:
        """The end of the last chunk."""
        return self.first * 2.0 ** (self.chunks - 1)

    def times(self, index: int) -> np.ndarray:
        """Return the times of a chunk: see ``Pace``."""
        return _times(self.first, index)


@lru_cache(maxsize=64)  # every tile needs them
def _times(first: float, index: int) -> np.ndarray:
    """Return the times of a chunk (see ``Pace``) as a read-only array."""
    end = first * 2.0**index
    begin, ends = (end / 2, np.arange(1, SAMPLES + 1)) if index else (0.0, np.arange(1, PARTS + 1))
    ends = ends + np.tile(_SHIFTS, len(ends) // WINDOW)
    parts = np.append(0.0, ends) / len(ends)
    times = begin + (end - begin) * parts
    times[-1] = end
    times.setflags(write=False)
    return np.asarray(times)


_SINGLE = np.float32  # of the envelopes, of which half a per cent matters: half of the memory that is read and written
SETTLED_WIDTH = 1e-4  # of speed and unbalance: a member has settled whose bounds are as near
_NEAR = 0.05  # of speed and unbalance: nearer bounds may be known from each turn
UNDECIDED_OUTCOME = -1
# Chunks after which members that approach neither rest nor an attractor are classified one by one, which takes far longer.
_WAIT_CHUNKS = 5
_SHAPE_TOLERANCE = 1e-9  # relative difference of shapes that are the same
_ROUND = 1e-3  # rad: resonances are those of phases rounded so
_UNIDENTIFIED_INDEX, _COMPENSATED_INDEX = OUTCOMES.index(Outcome.UNIDENTIFIED), OUTCOMES.index(Outcome.COMPENSATED)


@dataclass(frozen=True)
class MemberRecord:
    """The record of M members: their number, outcome (or ``UNDECIDED_OUTCOME``), square of the largest distance, settling time.

    needs_classification: mask of those that screening cannot decide. envelopes: in each of ``PARTS`` of the time the least and
    the largest speed and residual unbalance (4, K, M), for the settling time.
    """

    number: np.ndarray
    outcome: np.ndarray
    needs_classification: np.ndarray
    peak_distance_squared: np.ndarray
    settling_time: np.ndarray
    envelopes: np.ndarray


@dataclass(frozen=True)
class ScreeningObserver:
    """The observer. quantities: what the samples are. variants: of all members, by their numbers. final: all are
    judged at the end of the pace, the requested time; else each when it has settled. noise: of the integration. attractors: on
    which they may end. resonances, vibrations: those computed so far."""

    quantities: MemberQuantities
    variants: Variants
    attractors: tuple[Attractor, ...]
    pace: DoublingSchedule
    final: bool
    noise: Noise
    resonances: dict[tuple[int, int, tuple[float, ...]], float | None] = field(default_factory=dict, compare=False)
    vibrations: dict[int, Vibration] = field(default_factory=dict, compare=False)

    def begin(self, members: Members) -> MemberRecord:
        """Return the first record: see ``Observer``."""
        m = len(members)
        outcome, settling_time = np.full(m, UNDECIDED_OUTCOME, np.int8), np.full(m, np.nan)
        envelopes = np.empty((4, PARTS, m), _SINGLE)
        return MemberRecord(members.numbers, outcome, np.zeros(m, bool), np.zeros(m), settling_time, envelopes)

    @np.errstate(all="ignore")  # shares of nothing; it is called in threads, which know no other state
    def update(self, record: MemberRecord, chunk: Chunk) -> tuple[MemberRecord, np.ndarray]:
        """Return the record after a chunk, and which members have ended: see ``Observer``."""
        times, samples = chunk.times, chunk.samples
        index, variants = round(math.log2(times[-1] / self.pace.first)), self.variants.select(record.number)
        peak_distance_squared = np.maximum(record.peak_distance_squared, chunk.peaks[0])
        speed, phases, residual = (
            f(samples) for f in (self.quantities.speed, self.quantities.phases, self.quantities.residual)
        )
        envelopes = _extend_envelopes(record.envelopes if index else None, speed, residual)
        half, free = slice(-SAMPLES, None), self._free_speeds[variants.machine_index]
        late_speed, late_phases = speed[half], phases[:, half]
        screening = screening_of(times[-1] / 2, late_speed, late_phases, residual[half], free, self.noise)
        last = index == self.pace.chunks - 1
        is_final, is_changing = last and self.final, times[-1] / 2 < self._last_changes[variants.machine_index]
        outcome = self._outcome(screening, late_phases[:, -1], variants)
        is_decided = ~is_changing & (is_final | screening.still | (screening.width <= SETTLED_WIDTH))
        outcome = np.where(is_decided, outcome, UNDECIDED_OUTCOME)
        settling_time, endings = np.full(len(outcome), np.nan), np.flatnonzero(outcome != UNDECIDED_OUTCOME)
        settling_time[endings] = _settling_time(np.take(envelopes, endings, axis=-1), times[-1], free[endings])
        needs_nothing = np.zeros(len(outcome), bool)
        record = MemberRecord(record.number, outcome, needs_nothing, peak_distance_squared, settling_time, envelopes)
        if index:
            self._assign_to_attractors(record, samples, times[-1], free)
        if is_final:
            hopeless = self._is_hopeless(screening, late_speed, late_phases, envelopes, variants)
            hopeless &= outcome == UNDECIDED_OUTCOME
            hopeless &= self._last_changes[variants.machine_index] == 0
            outcome = np.where(hopeless, _UNIDENTIFIED_INDEX, outcome)
        needs_classification = (outcome == UNDECIDED_OUTCOME) & (
            last | (not self.final and self._has_stalled(screening, index) & ~is_changing)
        )
        record = replace(record, outcome=outcome.astype(np.int8), needs_classification=needs_classification)
        return record, (outcome != UNDECIDED_OUTCOME) | needs_classification

    def final_record(self, record: MemberRecord) -> MemberRecord:
        """Return all of the record but the envelopes, which is most of it: see ``Observer``."""
        return replace(record, envelopes=record.envelopes[:, :0])

    def _has_stalled(self, screening: Screening, index: int) -> np.ndarray:
        """Mask (M,) of the members not worth waiting for after so many chunks: they approach neither rest nor an attractor."""
        is_undecided = (screening.cycling | ~screening.nearing) & ~screening.has_settled
        return np.asarray(is_undecided & (index >= _WAIT_CHUNKS))

    def _assign_to_attractors(self, record: MemberRecord, samples: np.ndarray, end: float, free: np.ndarray) -> None:
        """Fill in what becomes of the members that stay near an attractor, by samples (K, v, M)."""
        outcome, envelopes, peaks = record.outcome, record.envelopes, record.peak_distance_squared
        time_left = self.pace.end - end if self.final else math.inf
        speeds = np.array([envelopes[0, SAMPLES:].min(axis=0), envelopes[1, SAMPLES:].max(axis=0)])
        for attractor in self.attractors:
            if 0 < time_left < attractor.period:  # the part of it that is reached until the end is not known yet
                continue
            candidates = np.flatnonzero(outcome == UNDECIDED_OUTCOME)
            if not len(candidates):
                return
            members = attractor.resident_members(self.quantities.points, samples, speeds, end / 2, candidates)
            outcome[members] = attractor.outcome
            arrival_time = _arrival_time(envelopes[..., members], end, attractor, free[members])
            record.settling_time[members] = np.where(arrival_time <= end + time_left, arrival_time, np.nan)
            if time_left or end / 2 >= attractor.period:
                peaks[members] = np.maximum(peaks[members], attractor.peak_distance_squared)

    @cached_property
    def _free_speeds(self) -> np.ndarray:
        """The speed that the drive reaches without vibration (V,), signed; nan where it is not determined."""
        pairs = zip(self._last_machines, self._last_changes.tolist(), strict=True)
        free_speeds = [free_speed(machine, machine.rotor, time) for machine, time in pairs]
        return np.array([np.nan if f is None else f for f in free_speeds])

    @cached_property
    def _last_machines(self) -> tuple[Machine, ...]:
        """The machines as their schedules leave them."""
        return tuple(m.at(t) for m, t in zip(self.variants.machines, self._last_changes.tolist(), strict=True))

    @cached_property
    def _last_changes(self) -> np.ndarray:
        """The time (V,) from which no schedule changes the machine any more."""
        return np.array([last_change(m) for m in self.variants.machines])

    def _vibration(self, variant: int) -> Vibration:
        """The vibration that the main rotor and the bodies about it excite: see ``_of_one_shape``."""
        if variant not in self.vibrations:
            machine = self._last_machines[variant]
            index = [machine.bodies.index(b) for b in machine.group(machine.rotor)]
            self.vibrations[variant] = _of_one_shape(Vibration.of(machine).select_bodies(index))
        return self.vibrations[variant]

    def _resonance(self, variant: int, sense: int, phases: np.ndarray) -> float | None:
        """The speed of the last maximum of the vibration torque below the free speed, with the bodies about the main rotor at
        phases (b,) as sigma alpha."""
        vibration, free = self._vibration(variant), self._free_speeds[variant]
        rounded_phases = (_ROUND * np.round(phases / _ROUND)) if len(vibration.excitation) > 1 else np.empty(0)
        key = variant, sense, tuple(rounded_phases.tolist())
        if key not in self.resonances:
            self.resonances[key] = vibration.last_maximum(
                None if np.isnan(free) else sense * free, np.append(0.0, rounded_phases)
            )
        return self.resonances[key]

    def _outcome(self, screening: Screening, phases: np.ndarray, variants: Variants) -> np.ndarray:
        """The outcome (M,) of members that have settled with quiet or compensating bodies; else ``UNDECIDED_OUTCOME``.

        phases (b, M): of the bodies at the end.
        """
        e = screening.evidence
        needs_resonance = screening.has_settled & screening.quiet & (e.is_at_speed.no | e.is_balanced.no)
        resonance, sense = np.full(len(needs_resonance), np.nan), screening.sense
        for i in np.flatnonzero(needs_resonance):
            speed = self._resonance(int(variants.machine_index[i]), int(sense[i]), sense[i] * phases[:, i])
            resonance[i] = np.nan if speed is None else speed
        outcome = classify_each(replace(e, resonance=resonance))
        is_decided = (outcome == _COMPENSATED_INDEX) | (needs_resonance & (outcome != _UNIDENTIFIED_INDEX))
        return np.asarray(np.where(is_decided, outcome, UNDECIDED_OUTCOME), np.int8)

    def _is_hopeless(
        self, screening: Screening, speed: np.ndarray, phases: np.ndarray, envelopes: np.ndarray, variants: Variants
    ) -> np.ndarray:
        """Mask (M,) of the members that no full classification decides: they are far from their end, or their speed has risen
        and fallen too seldom and they are not running up either: they are below the resonance, or their bodies move without
        lagging. Of a modulation that has risen twice, all in the last half, there are two cycles at most. speed (K, M), phases
        (b, K, M): in that half."""
        sense = screening.sense
        window = sense * speed.reshape(WINDOWS, -1, speed.shape[1])[-1]
        low, high = window.min(axis=0), window.max(axis=0)
        is_restless = (
            ~screening.has_settled
            & ~screening.early
            & (screening.width > _NEAR)
            & (low > 0)
            & (high - low > MODULATION_THRESHOLD * high)
            & (screening.rises <= 2)
        )
        rises_twice = np.flatnonzero(is_restless & (screening.rises == 2))
        if len(rises_twice):
            is_restless[rises_twice] = (
                rises_of(sense[rises_twice] * np.take(envelopes[:2], rises_twice, axis=-1).mean(axis=0)) <= 2
            )
        is_moving = ~screening.quiet & (np.ptp(phases, axis=1) < 2 * math.pi).all(axis=0)
        is_moving |= screening.rises == 2  # and lag in between
        hopeless, no_phases = screening.early | (is_restless & is_moving), np.zeros(len(phases))
        for i in np.flatnonzero(is_restless & ~is_moving):
            variant = int(variants.machine_index[i])
            if len(self._vibration(variant).excitation) == 1:  # of one shape
                resonance = self._resonance(variant, int(sense[i]), no_phases)
                hopeless[i] = resonance is not None and low[i] < resonance
        return np.asarray(hopeless)


def _of_one_shape(vibration: Vibration) -> Vibration:
    """Return the vibration that the strongest body alone excites, if all excite the same shape; else that of all.

    All bodies about one axis do: their forces add up to one that turns, of which the phase is a matter of the moment. The
    torque over the speed then has one shape, whatever their phases.
    """
    sizes = np.abs(vibration.excitation).sum(axis=1)
    singular_values = np.linalg.svd(vibration.excitation, compute_uv=False)
    if len(singular_values) and (singular_values[1:] > _SHAPE_TOLERANCE * singular_values[0]).any():
        return vibration
    return vibration.select_bodies([int(sizes.argmax())])


def _extend_envelopes(envelopes: np.ndarray | None, speed: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Extend the envelopes (4, K, M) of a ``MemberRecord`` by a chunk of samples (K, M), as long as all of it before."""
    new_envelopes = np.array([speed, speed, residual, residual], _SINGLE)
    if envelopes is None:
        return new_envelopes
    all_envelopes = np.empty_like(envelopes)
    for k, (row, old_row) in enumerate(zip(all_envelopes, envelopes, strict=True)):
        (np.minimum, np.maximum)[k % 2](old_row[::2], old_row[1::2], out=row[:SAMPLES])
    all_envelopes[:, SAMPLES:] = new_envelopes
    return all_envelopes


def _settling_time(envelopes: np.ndarray, end: float, free: np.ndarray) -> np.ndarray:
    """The time (M,) from which the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of their ends."""
    low, high, least, most = envelopes
    margin = SPEED_TOLERANCE * np.where(np.isnan(free), np.abs(low[-1]), np.abs(free))
    speed, residual = (low[-1] + high[-1]) / 2, (least[-1] + most[-1]) / 2
    is_outside = (high > speed + margin) | (low < speed - margin)
    is_outside |= (most > residual + UNBALANCE_TOLERANCE) | (least < residual - UNBALANCE_TOLERANCE)
    first = np.where(is_outside.any(axis=0), PARTS - is_outside[::-1].argmax(axis=0), 0)
    return np.asarray(first * end / PARTS)


def _arrival_time(envelopes: np.ndarray, end: float, attractor: Attractor, free: np.ndarray) -> np.ndarray:
    """The time (M,) from which the speed stays in an attractor's range, widened by 0.5 % (of the free speed), plus a period."""
    low, high = np.sort(np.sign(envelopes[0, -1]) * np.array([attractor.low, attractor.high])[:, None], axis=0)
    margin = SPEED_TOLERANCE * np.where(np.isnan(free), np.abs(attractor.low), np.abs(free))
    is_outside = (envelopes[1] > high + margin) | (envelopes[0] < low - margin)
    first = np.where(is_outside.any(axis=0), PARTS - is_outside[::-1].argmax(axis=0), 0)
    return np.asarray(first * end / PARTS + attractor.period)
