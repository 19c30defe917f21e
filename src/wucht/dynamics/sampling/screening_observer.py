"""Screening of all members at once: those that have settled are judged, those that need a full classification are marked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.dynamics.sampling.attractors import Attractor
from wucht.dynamics.sampling.ensemble_equations import Equations, NumberedMembers, Variants
from wucht.dynamics.sampling.member_views import FullView, SlowView, VariantFunction, View, member_residual_unbalance
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import weights_of
from wucht.dynamics.verdicts.outcomes import (
    MODULATION_THRESHOLD,
    OUTCOMES,
    SPEED_TOLERANCE,
    UNBALANCE_TOLERANCE,
    Outcome,
    classify_each,
)
from wucht.dynamics.verdicts.screening import LastHalf, Screening, screening_of
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.ensembles.members import Members
from wucht.numerics.observers.projection import WINDOWS
from wucht.numerics.zeros_and_peaks import interval_maxima

WINDOW = 16  # samples
SAMPLES = WINDOW * WINDOWS  # in each chunk, twice as many in the first one: its halves are like the chunks after it
PARTS = 2 * SAMPLES  # of the time, for which the course is recorded
# Times as many of the amplitude in each part of the first chunk: vibrations of the start die out, resonances are passed.
FINER = np.repeat((4, 2), SAMPLES)
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
    if not index:
        pieces = zip(parts[:-1], parts[1:], FINER, strict=True)
        parts = np.append(0.0, np.concatenate([b + (e - b) * np.arange(1, n + 1) / n for b, e, n in pieces]))
    times = begin + (end - begin) * parts
    times[-1] = end
    times.setflags(write=False)
    return np.asarray(times)


SETTLED_WIDTH = 1e-4  # of speed and unbalance: a member has settled whose bounds are as near
_FOLLOWED_SHARE = 0.5  # of the differences of samples: a cubic that misses more of them has not been sampled densely enough
UNDECIDED_OUTCOME = -1
_LONG, _LONGER = 3, 5  # chunks, after which members that do not come to rest are classified fully; to an attractor either
_ROUND = 1e-3  # rad: resonances are those of phases rounded so
_ENDS = np.cumsum(FINER) - 1  # samples at the ends of the parts of the first chunk
_UNIDENTIFIED_INDEX, _COMPENSATED_INDEX = OUTCOMES.index(Outcome.UNIDENTIFIED), OUTCOMES.index(Outcome.COMPENSATED)


@dataclass(frozen=True)
class MemberRecord:
    """The record of M members: their number, outcome (or ``UNDECIDED_OUTCOME``), square of the largest distance, settling time.

    needs_classification: mask of those that screening cannot decide. end: the square of the distance at the last sample, and
    its derivative (2, M). course: in each of ``PARTS`` of the time the least and the largest speed and residual unbalance
    (4, K, M), for the settling time.
    """

    number: np.ndarray
    outcome: np.ndarray
    needs_classification: np.ndarray
    square: np.ndarray
    settling: np.ndarray
    end: np.ndarray
    course: np.ndarray


@dataclass(frozen=True)
class ScreeningObserver:
    """The observer. equations, variants: of all members, by their numbers. final: all are judged at the end of the pace, the
    requested time; else each when it has settled. noise: of the integration. attractors: on which they may end. resonances:
    those computed so far."""

    equations: Equations
    variants: Variants
    attractors: tuple[Attractor, ...]
    pace: DoublingSchedule
    final: bool
    noise: Noise
    resonances: dict[tuple[int, int, tuple[float, ...]], float | None] = field(default_factory=dict, compare=False)

    @np.errstate(all="ignore")  # averaged equations of a rotor at rest
    def begin(self, members: Members) -> MemberRecord:
        """Return the first record: see ``Observer``."""
        assert isinstance(members, NumberedMembers)
        m, numbers = len(members), members.numbers
        initial_view = self._view.view(members.starts.T[None], self.variants.machine_index[numbers])
        outcome, nothing = np.full(m, UNDECIDED_OUTCOME, np.int8), np.full(m, np.nan)
        end = np.concatenate([initial_view.square, self._rate(initial_view, members.starts.T[None], numbers)])
        return MemberRecord(numbers, outcome, np.zeros(m, bool), initial_view.square[0], nothing, end, np.empty((4, PARTS, m)))

    @np.errstate(all="ignore")  # shares of nothing; it is called in threads, which know no other state
    def update(self, record: MemberRecord, times: np.ndarray, samples: np.ndarray) -> tuple[MemberRecord, np.ndarray]:
        """Return the record after a chunk, and which members have ended: see ``Observer``."""
        index, variants = round(math.log2(times[-1] / self.pace.first)), self.variants.select(record.number)
        ends = slice(None) if index else _ENDS
        view = self._view.view(samples, variants.machine_index, ends)
        whole, signal = np.append(self.pace.times(index)[0], times), np.concatenate([record.end[:1], view.square])
        if view.rate is None:
            peak, rate = self._peak(whole, signal, record, samples), self._rate(view, samples[-1:], record.number)
        else:
            slope, rate = np.concatenate([record.end[1:], view.rate]), view.rate[-1:]
            peak = _peaks(whole[:, None], signal, slope, WINDOW)
        square, end = np.maximum(record.square, peak), np.concatenate([signal[-1:], rate])
        speed, phases = view.speed, view.phases
        residual = self._residual(phases, variants.machine_index)[0]
        course = _extend_course(record.course if index else None, speed, residual)
        half = slice(-SAMPLES, None)
        last_half, free = (
            LastHalf(times[-1] / 2, speed[half], phases[:, half], residual[half]),
            self._free[variants.machine_index],
        )
        rest = screening_of(last_half, free, self.noise)
        last = index == self.pace.chunks - 1
        is_final = last and self.final
        outcome = self._outcome(rest, last_half, variants)
        outcome = np.where(is_final | rest.still | (rest.width <= SETTLED_WIDTH), outcome, UNDECIDED_OUTCOME)
        settling = np.where(outcome != UNDECIDED_OUTCOME, _settling_time(course, times[-1], free), np.nan)
        if index:
            self._arrive((outcome, settling, square), samples, course, times[-1], free)
        if is_final:
            hopeless = (outcome == UNDECIDED_OUTCOME) & self._is_hopeless(rest, last_half, variants)
            outcome = np.where(hopeless, _UNIDENTIFIED_INDEX, outcome)
        needs_classification = (outcome == UNDECIDED_OUTCOME) & (last | (not self.final and self._stuck(rest, index)))
        record = MemberRecord(record.number, outcome.astype(np.int8), needs_classification, square, settling, end, course)
        return record, (outcome != UNDECIDED_OUTCOME) | needs_classification

    def final_record(self, record: MemberRecord) -> MemberRecord:
        """Return all of the record but the course, which is most of it: see ``Observer``."""
        return replace(record, course=record.course[:, :0])

    @cached_property
    def _view(self) -> FullView | SlowView:
        return self.equations.view(self.variants)

    def _stuck(self, rest: Screening, index: int) -> np.ndarray:
        """Mask (M,) of the members not worth waiting for after so many chunks: they approach neither rest nor an attractor."""
        if self.attractors:
            return np.asarray((rest.cycling | ~rest.nearing) & ~rest.has_settled & (index >= _LONGER))
        return np.asarray(rest.cycling | (~rest.nearing & ~rest.has_settled & (index >= _LONG)))

    def _arrive(
        self,
        results: tuple[np.ndarray, np.ndarray, np.ndarray],
        samples: np.ndarray,
        course: np.ndarray,
        end: float,
        free: np.ndarray,
    ) -> None:
        """Fill in outcome, settling time and square (M,) of those that stay near an attractor, by samples (K, k, M)."""
        outcome, settling, square = results
        time_left = self.pace.end - end if self.final else math.inf
        speeds = np.array([course[0, SAMPLES:].min(axis=0), course[1, SAMPLES:].max(axis=0)])
        for one in self.attractors:
            if 0 < time_left < one.period:  # the part of it that is reached until the end is not known yet
                continue
            open_ = np.flatnonzero(outcome == UNDECIDED_OUTCOME)
            if not len(open_):
                return
            arriving = one.resident_members(self.equations, samples, speeds, end / 2, open_)
            outcome[arriving] = one.outcome
            settling_time = _arrival(course[..., arriving], end, one, free[arriving])
            settling[arriving] = np.where(settling_time <= end + time_left, settling_time, np.nan)
            if time_left or end / 2 >= one.period:
                square[arriving] = np.maximum(square[arriving], one.square)

    def _rate(self, view: View, samples: np.ndarray, members: np.ndarray) -> np.ndarray:
        """The derivative of the square (K, M), at samples (K, k, M) of these members."""
        if view.rate is not None:
            return view.rate
        assert isinstance(self._view, SlowView)
        return self._view.rate(samples, self.variants.machine_index[members])

    def _peak(self, times: np.ndarray, signal: np.ndarray, record: MemberRecord, samples: np.ndarray) -> np.ndarray:
        """The largest value (M,) of slow signals (K + 1, M): beside the largest sample. samples (K, k, M): after the first."""
        rows = np.clip(signal.argmax(axis=0) + np.array([[-1], [0], [1]]), 0, len(samples))
        members = np.arange(signal.shape[1])
        near = np.moveaxis(samples[np.maximum(rows - 1, 0), :, members], 2, 1)
        assert isinstance(self._view, SlowView)
        slope = np.where(rows == 0, record.end[1], self._view.rate(near, self.variants.machine_index[record.number]))
        return _peaks(times[rows], signal[rows, members], slope, len(rows) - 1)

    @cached_property
    def _residual(self) -> VariantFunction:
        return member_residual_unbalance(np.array([_weights(m) for m in self.variants.machines]))

    @cached_property
    def _free(self) -> np.ndarray:
        """The speed that the drive reaches without vibration (V,), signed; nan where it is not determined."""
        free_speeds = [free_speed(m, m.rotor) for m in self.variants.machines]
        return np.array([np.nan if f is None else f for f in free_speeds])

    def _resonance(self, variant: int, sense: int, phases: tuple[float, ...]) -> float | None:
        """The speed of the last maximum of the vibration torque below the free speed, with the bodies about the main rotor at
        phases as sigma alpha."""
        key = variant, sense, phases
        if key not in self.resonances:
            self.resonances[key] = _resonance(self.variants.machines[variant], sense, phases)
        return self.resonances[key]

    def _outcome(self, rest: Screening, last_half: LastHalf, variants: Variants) -> np.ndarray:
        """The outcome (M,) of members that have settled with quiet or compensating bodies; else ``UNDECIDED_OUTCOME``."""
        e, phases = rest.evidence, last_half.phases[:, -1]
        needs_resonance = rest.has_settled & rest.quiet & (e.is_at_speed.no | e.is_balanced.no)
        resonance = np.full(len(needs_resonance), np.nan)
        for i in np.flatnonzero(needs_resonance):
            rounded_phases = (
                np.zeros(len(phases)) if self.equations.isotropic else np.round(last_half.sense[i] * phases[:, i] / _ROUND)
            )
            at = self._resonance(
                int(variants.machine_index[i]), int(last_half.sense[i]), tuple((_ROUND * rounded_phases).tolist())
            )
            resonance[i] = np.nan if at is None else at
        outcome = classify_each(replace(e, resonance=resonance))
        is_decided = (outcome == _COMPENSATED_INDEX) | (needs_resonance & (outcome != _UNIDENTIFIED_INDEX))
        return np.asarray(np.where(is_decided, outcome, UNDECIDED_OUTCOME), np.int8)

    def _is_hopeless(self, rest: Screening, last_half: LastHalf, variants: Variants) -> np.ndarray:
        """Mask (M,) of the members that no full classification decides: their speed rises and falls, below the resonance, too
        seldom yet, or they are far from their end."""
        window = last_half.sense * last_half.speed.reshape(WINDOWS, -1, last_half.speed.shape[1])[-1]
        low, high = window.min(axis=0), window.max(axis=0)
        restless = ~rest.has_settled & ~rest.early & (low > 0) & (high - low > MODULATION_THRESHOLD * high) & (rest.rises < 2)
        before = rest.early.copy()
        for i in np.flatnonzero(restless) if self.equations.isotropic else ():
            resonance = self._resonance(int(variants.machine_index[i]), int(last_half.sense[i]), (0.0,) * len(last_half.phases))
            before[i] = resonance is not None and low[i] < resonance
        return before


def _resonance(machine: Machine, sense: int, phases: tuple[float, ...]) -> float | None:
    """Compute a resonance: see ``ScreeningObserver._resonance``."""
    free = free_speed(machine, machine.rotor)
    index = [machine.bodies.index(b) for b in machine.group(machine.rotor)]
    target_speed = None if free is None else sense * free
    return Vibration.of(machine).select_bodies(index).last_maximum(target_speed, np.array([0.0, *phases]))


def _weights(machine: Machine) -> tuple[complex, ...]:
    """The unbalances of the main rotor and of the bodies about it, as shares of the rotor's."""
    weights, other_bodies = weights_of(machine, machine.rotor), [b for b in machine.bodies if b is not machine.rotor]
    return (weights[0], *(weights[1 + other_bodies.index(b)] for b in machine.group(machine.rotor)[1:]))


def _peaks(times: np.ndarray, signal: np.ndarray, slope: np.ndarray, window: int) -> np.ndarray:
    """The largest value (M,) of signals (K + 1, M): between samples where these resolve them, else at the samples.

    times: (K + 1, 1) or of each (K + 1, M). They are resolved if, in a window of so many intervals, slopes and differences
    agree: less than about a third of an oscillation lies between two samples.
    """
    change = np.diff(signal, axis=0)
    mismatch = np.abs(change - 0.5 * np.diff(times, axis=0) * (slope[:-1] + slope[1:]))
    mismatch, change = (x.reshape(-1, window, x.shape[1]).sum(axis=1) for x in (mismatch, np.abs(change)))
    is_followed = np.repeat(mismatch <= _FOLLOWED_SHARE * change, window, axis=0)
    between = np.where(is_followed, interval_maxima(times, signal, slope), -math.inf)
    return np.asarray(np.maximum(between.max(axis=0), signal.max(axis=0)))


def _extend_course(course: np.ndarray | None, speed: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Extend the course (4, K, M) of a ``MemberRecord`` by a chunk of samples (K, M), as long as all of it before."""
    new = np.array([speed, speed, residual, residual])
    if course is None:
        return new
    longer = np.empty_like(course)
    for k, (row, before) in enumerate(zip(longer, course, strict=True)):
        (np.minimum, np.maximum)[k % 2](before[::2], before[1::2], out=row[:SAMPLES])
    longer[:, SAMPLES:] = new
    return longer


def _settling_time(course: np.ndarray, end: float, free: np.ndarray) -> np.ndarray:
    """The time (M,) from which the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of their ends."""
    low, high, least, most = course
    margin = SPEED_TOLERANCE * np.where(np.isnan(free), np.abs(low[-1]), np.abs(free))
    speed, residual = (low[-1] + high[-1]) / 2, (least[-1] + most[-1]) / 2
    is_outside = (high > speed + margin) | (low < speed - margin)
    is_outside |= (most > residual + UNBALANCE_TOLERANCE) | (least < residual - UNBALANCE_TOLERANCE)
    first = np.where(is_outside.any(axis=0), PARTS - is_outside[::-1].argmax(axis=0), 0)
    return np.asarray(first * end / PARTS)


def _arrival(course: np.ndarray, end: float, attractor: Attractor, free: np.ndarray) -> np.ndarray:
    """The time (M,) from which the speed stays in an attractor's range, widened by 0.5 % (of the free speed), plus a period."""
    low, high = np.sort(np.sign(course[0, -1]) * np.array([attractor.low, attractor.high])[:, None], axis=0)
    margin = SPEED_TOLERANCE * np.where(np.isnan(free), np.abs(attractor.low), np.abs(free))
    is_outside = (course[1] > high + margin) | (course[0] < low - margin)
    first = np.where(is_outside.any(axis=0), PARTS - is_outside[::-1].argmax(axis=0), 0)
    return np.asarray(first * end / PARTS + attractor.period)
