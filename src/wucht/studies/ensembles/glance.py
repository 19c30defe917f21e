"""A first look at all members at once: those that come to rest are judged, those that need a closer look are found."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.ensembles.members import Members
from wucht.numerics.observers.projection import WINDOWS
from wucht.numerics.peaks import between_samples
from wucht.results.outcomes import MODULATION_THRESHOLD, SPEED_TOLERANCE, UNBALANCE_TOLERANCE, Outcome
from wucht.studies.ensembles.at_rest import LastHalf, Resting, resting
from wucht.studies.ensembles.attractors import Attractor
from wucht.studies.ensembles.ensemble_equations import Equations, Numbered, Variants, places
from wucht.studies.ensembles.member_outcomes import OUTCOMES
from wucht.studies.motion.observation import weights_of

SAMPLES = 32 * WINDOWS  # in each chunk, and parts in which its course is kept
_FINER = (4, 2)  # times as many of the amplitude in the first ones: there resonances are passed fast
SETTLED = 1e-4  # of speed and unbalance: bounds that are as near tell that a member has settled
UNDECIDED = -1
_LONG, _LONGER = 3, 5  # chunks, after which members that do not come to rest deserve a closer look; to an attractor either
_ROUND = 1e-3  # rad: resonances are those of phases rounded so
_CODE = {outcome: OUTCOMES.index(outcome) for outcome in OUTCOMES}


@dataclass(frozen=True)
class DoublingPace:
    """Each chunk is as long as all before it together. first: the end of the first one; chunks: how many."""

    first: float
    chunks: int

    @classmethod
    def until(cls, end: float, first: float) -> DoublingPace:
        """That ends at a time, with a first chunk of about this length."""
        doublings = max(0, math.ceil(math.log2(end / first)))
        return cls(end / 2**doublings, doublings + 1)

    def times(self, index: int) -> np.ndarray:
        """See ``Pace``."""
        end, finer = self.first * 2.0**index, _FINER[index] if index < len(_FINER) else 1
        return np.linspace(end / 2 if index else 0.0, end, finer * SAMPLES + 1)


@dataclass(frozen=True)
class Glimpse:
    """Of M members: their number, how many chunks were seen, the outcome (``UNDECIDED``), whether a closer look is needed, the
    square of the largest distance, the settling time; and in each of as many parts of the time as there are samples in a chunk
    the least and the largest speed and share of unbalance that is left (4, K, M), to see when they settled."""

    number: np.ndarray
    outcome: np.ndarray
    closer: np.ndarray
    square: np.ndarray
    settling: np.ndarray
    course: np.ndarray


@dataclass(frozen=True)
class Glance:
    """The observer. equations, variants: of all members, by their numbers. final: whether the end of the pace is where all are
    judged, as was asked; else members are followed until they have settled. attractors: on which they may end. known:
    resonances."""

    equations: Equations
    variants: Variants
    attractors: tuple[Attractor, ...]
    pace: DoublingPace
    final: bool
    known: dict[tuple[int, int, tuple[float, ...]], float | None] = field(default_factory=dict, compare=False)

    def begin(self, members: Members) -> Glimpse:
        """See ``Observer``."""
        assert isinstance(members, Numbered)
        m = len(members)
        nothing = np.full(m, np.nan)
        return Glimpse(
            members.numbers, np.full(m, UNDECIDED, np.int8), np.zeros(m, bool), np.zeros(m), nothing, np.empty((4, SAMPLES, m))
        )

    @np.errstate(all="ignore")  # shares of nothing; it is called in threads, which know no other state
    def after(self, record: Glimpse, times: np.ndarray, samples: np.ndarray) -> tuple[Glimpse, np.ndarray]:
        """See ``Observer``."""
        index = round(math.log2(times[-1] / self.pace.first))
        variants = self.variants.taken(record.number)
        sight = self.equations.seen(samples, variants)
        sparse = slice(len(times) // SAMPLES - 1, None, len(times) // SAMPLES)
        speed, phases = sight.speed[sparse], sight.phases[:, sparse]
        left = self._left(phases, variants)
        course = _lengthened(record.course if index else None, speed, left)
        # Where samples are far apart, a cubic through two of them goes far beyond.
        dense = index < len(_FINER)
        largest = (between_samples(times, sight.square, sight.rate) if dense else sight.square).max(axis=0)
        square = np.maximum(record.square, largest)
        half = slice(0 if index else SAMPLES // 2, None)
        duration = times[-1] if not index else times[-1] / 2
        seen = LastHalf(duration, speed[half], phases[:, half], left[half])
        rest = resting(seen)
        outcome = self._outcome(rest, phases[:, -1], variants)
        last = index == self.pace.chunks - 1
        at_end = last and self.final
        decided = (outcome != UNDECIDED) & (at_end | (rest.width <= SETTLED))
        hopeless = self._hopeless(rest, seen, variants) if at_end else np.zeros(len(outcome), bool)
        outcome = np.where(decided, outcome, UNDECIDED)
        free = self._free[variants.of]
        settling = np.where(decided, _settling_time(course, times[-1], free), np.nan)
        if index:
            at = places(self.equations.system, samples[sparse])
            self._arrive((outcome, settling, square), at, course, float(times[-1]), free)
        outcome = np.where((outcome == UNDECIDED) & hopeless, _CODE[Outcome.UNIDENTIFIED], outcome).astype(np.int8)
        closer = (outcome == UNDECIDED) & (last | (not self.final and self._stuck(rest, index)))
        record = replace(record, outcome=outcome, closer=closer, square=square, settling=settling, course=course)
        return record, (outcome != UNDECIDED) | closer

    def _stuck(self, rest: Resting, index: int) -> np.ndarray:
        """Which members (M,) are not worth waiting for after so many chunks: they neither come to rest nor to an attractor."""
        if self.attractors:
            return np.asarray((rest.cycling | ~rest.nearing) & ~rest.known & (index >= _LONGER))
        return np.asarray(rest.cycling | (~rest.nearing & ~rest.known & (index >= _LONG)))

    def _arrive(
        self,
        filled: tuple[np.ndarray, np.ndarray, np.ndarray],
        at: np.ndarray,
        course: np.ndarray,
        end: float,
        free: np.ndarray,
    ) -> None:
        """Fill in outcome, settling time and square (M,) of those that stay near an attractor, by their places (K, M, d)."""
        outcome, settling, square = filled
        for one in self.attractors:
            open_ = np.flatnonzero(outcome == UNDECIDED)
            arrived = open_[one.holds(at[:, open_])] if len(open_) else open_
            outcome[arrived] = one.outcome
            settling[arrived] = _arrival(course[..., arrived], end, one, free[arrived])
            square[arrived] = np.maximum(square[arrived], one.square)

    def _left(self, phases: np.ndarray, variants: Variants) -> np.ndarray:
        """What is left of the rotor's unbalance, as a share of it (K, M), with the bodies about it at phases (b, K, M)."""
        # In real numbers: the last bit of a complex product depends on where in an array it stands.
        (first, *others), real, imaginary = self._weights[:, variants.of], 0.0, 0.0
        for weight, phase in zip(others, phases, strict=True):
            cosine, sine = np.cos(phase), np.sin(phase)
            real = real + (weight.real * cosine - weight.imag * sine)
            imaginary = imaginary + (weight.real * sine + weight.imag * cosine)
        return np.asarray(np.sqrt((first.real + real) ** 2 + (first.imag + imaginary) ** 2) + np.zeros(phases.shape[1:]))

    @cached_property
    def _weights(self) -> np.ndarray:
        """The unbalances of the main rotor and of the bodies about it, as shares of its own (1 + b, V), of each variant."""
        return np.array([_weights(m) for m in self.variants.machines]).T

    @cached_property
    def _free(self) -> np.ndarray:
        """What the drive reaches without vibration (V,), signed; nan where nothing says so."""
        each = [free_speed(m, m.rotor) for m in self.variants.machines]
        return np.array([np.nan if f is None else f for f in each])

    def _resonance(self, variant: int, sense: int, phases: tuple[float, ...]) -> float | None:
        """The speed of the last maximum of the vibration torque below the free speed, with the bodies about the main rotor at
        phases as sigma alpha."""
        key = variant, sense, phases
        if key not in self.known:
            self.known[key] = _resonance(self.variants.machines[variant], sense, phases)
        return self.known[key]

    def _outcome(self, rest: Resting, phases: np.ndarray, variants: Variants) -> np.ndarray:
        """The outcome (M,) of members at rest with the bodies about the rotor at phases (b, M), ``UNDECIDED`` of others."""
        outcome = np.full(len(rest.known), UNDECIDED, np.int8)
        (at_speed, speed_known), (balanced, balance_known) = rest.at_speed(self._free[variants.of]), rest.balanced
        outcome[rest.known & at_speed & balanced] = _CODE[Outcome.COMPENSATED]
        others = rest.known & ((speed_known & ~at_speed) | (balance_known & ~balanced))
        for i in np.flatnonzero(others):
            rounded = np.zeros(len(phases)) if self.equations.isotropic else np.round(rest.sense[i] * phases[:, i] / _ROUND)
            resonance = self._resonance(int(variants.of[i]), int(rest.sense[i]), tuple((_ROUND * rounded).tolist()))
            if resonance is None or rest.lowest[0, i] > resonance:
                outcome[i] = _CODE[Outcome.PASSED]
            elif rest.lowest[1, i] <= resonance:
                outcome[i] = _CODE[Outcome.CAPTURED]
        return outcome

    def _hopeless(self, rest: Resting, seen: LastHalf, variants: Variants) -> np.ndarray:
        """Which members (M,) no closer look can tell: their speed goes up and down, below the resonance, too seldom yet,
        or they are far from their end."""
        window = rest.sense * seen.speed.reshape(WINDOWS, -1, seen.speed.shape[1])[-1]
        low, high = window.min(axis=0), window.max(axis=0)
        restless = ~rest.known & ~rest.early & (low > 0) & (high - low > MODULATION_THRESHOLD * high) & (rest.rises < 2)
        before = rest.early.copy()
        for i in np.flatnonzero(restless) if self.equations.isotropic else ():
            resonance = self._resonance(int(variants.of[i]), int(rest.sense[i]), (0.0,) * len(seen.phases))
            before[i] = resonance is not None and low[i] < resonance
        return before


def _resonance(machine: Machine, sense: int, phases: tuple[float, ...]) -> float | None:
    """See ``Glance._resonance``."""
    free = free_speed(machine, machine.rotor)
    if free == 0:
        return None
    index = [machine.bodies.index(b) for b in machine.group(machine.rotor)]
    expected = None if free is None else sense * free
    return Vibration.of(machine).only(index).last_maximum(expected, np.array([0.0, *phases]))


def _weights(machine: Machine) -> tuple[complex, ...]:
    """The unbalances of the main rotor and of the bodies about it, as shares of its own."""
    weights, others = weights_of(machine, machine.rotor), [b for b in machine.bodies if b is not machine.rotor]
    return (weights[0], *(weights[1 + others.index(b)] for b in machine.group(machine.rotor)[1:]))


def _lengthened(course: np.ndarray | None, speed: np.ndarray, left: np.ndarray) -> np.ndarray:
    """The course (4, K, M) of a ``Glimpse`` after a chunk of samples (K, M), as long as all of it before."""
    new = np.array([speed, speed, left, left])
    if course is None:
        return new
    pairs = np.concatenate([course, new], axis=1).reshape(4, SAMPLES, 2, -1)
    return np.array([(np.minimum, np.maximum)[k % 2](row[:, 0], row[:, 1]) for k, row in enumerate(pairs)])


def _settling_time(course: np.ndarray, end: float, free: np.ndarray) -> np.ndarray:
    """From when on (M,) the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of what they end with."""
    low, high, least, most = course
    margin = SPEED_TOLERANCE * np.where(np.isnan(free), np.abs(low[-1]), np.abs(free))
    speed, left = (low[-1] + high[-1]) / 2, (least[-1] + most[-1]) / 2
    off = (high > speed + margin) | (low < speed - margin)
    off |= (most > left + UNBALANCE_TOLERANCE) | (least < left - UNBALANCE_TOLERANCE)
    first = np.where(off.any(axis=0), SAMPLES - off[::-1].argmax(axis=0), 0)
    return np.asarray(first * end / SAMPLES)


def _arrival(course: np.ndarray, end: float, attractor: Attractor, free: np.ndarray) -> np.ndarray:
    """From when on (M,) the speed stays in an attractor's range, widened by 0.5 % (of the free speed), and a period."""
    low, high = np.sort(np.sign(course[0, -1]) * np.array([attractor.low, attractor.high])[:, None], axis=0)
    margin = SPEED_TOLERANCE * np.where(np.isnan(free), np.abs(attractor.low), np.abs(free))
    off = (course[1] > high + margin) | (course[0] < low - margin)
    first = np.where(off.any(axis=0), SAMPLES - off[::-1].argmax(axis=0), 0)
    return np.asarray(first * end / SAMPLES + attractor.period)
