"""Where a branch ends: the jumps of a sweep, found closer than its finite rate lets them be seen.

A ramp passes the fold p_f of a branch late, by a distance that grows with rate^(2/3). So the parameter is held: from the last
steady state before the jump it is led to values in between, and held there until the machine has settled, or left the branch.
Behind a fold the branch is left after a time T ~ (p - p_f)^(-1/2); this law tells how long to wait before it counts as staying.
Near the fold p is a parabola in the speed, whose vertex is the fold (J. Guckenheimer, P. Holmes, Nonlinear Oscillations,
Dynamical Systems, and Bifurcations of Vector Fields, 1983, section 3.4).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from wucht.studies.sweep.flow import Mover, Place, Reading
from wucht.studies.sweep.plan import Plan

_STEEP, _SMALLEST, _MOST = 2.0, 0.02, 8  # times the median slope; share of the whole range; candidates
_SETTLED = 1e-6
_OTHER = 0.3  # of the change: if holding the parameter changes the signal by more, the ramp was in another state
_SAME = 0.2  # of the change between the legs is left between two values that close: else it is steep, but no jump
_CORE = 0.25  # of the largest change between two legs: what changes less is not the jump, but the branch that bends towards it
_MOST_WINDOWS = 400
_PATIENCE = 3.0
_FEWEST_WINDOWS = 10
JUMP_TOLERANCE = 1e-4
_REACH = 4.0  # of the first of them before the end of the branch, in widths of the bracket
_SPREAD = (1.0, 4.0, 9.0, 16.0)  # of the points of the parabola: evenly spaced in the speed


@dataclass(frozen=True)
class Jump:
    """value: of the parameter where the branch ends. upward: whether it rises. after: a steady reading where the machine lands.

    speed, amplitude: on the branch at its end. bracket: between which values the end lies. fold: whether the branch ends in a
    parabola there; else it loses its stability in another way. only_seen: by the ramp, because the machine does not stay in the
    state before the jump if the parameter is held.
    """

    value: float
    upward: bool
    speed: float
    amplitude: float
    after: Reading
    bracket: tuple[float, float]
    fold: bool
    only_seen: bool = False


@dataclass(frozen=True)
class Scale:
    """The largest speed and amplitude seen so far: a change is small or large beside them, also at a standstill."""

    speed: float = 0.0
    amplitude: float = 0.0

    def with_(self, readings: Iterable[Reading]) -> Scale:
        """The scale after more readings."""
        known = [(abs(r.speed), r.amplitude) for r in readings]
        return Scale(max([self.speed, *(s for s, _ in known)]), max([self.amplitude, *(a for _, a in known)]))


def settle(mover: Mover, plan: Plan, place: Place, most: int = 60, scale: Scale | None = None) -> tuple[Place, Reading, bool]:
    """Hold the parameter until nothing changes any more. Returns whether that was reached; a steady beat counts as settled.

    scale: of what was seen before; a speed that changes by less than a millionth of the largest has settled.
    """
    window = max(5 * plan.answer, 8 * plan.turn)
    place, last = mover.leg(place, window)
    scale, quiet = (scale or Scale()).with_([last]), 0
    for _ in range(most):
        place, here = mover.leg(place, window)
        scale = scale.with_([here])
        still = abs(here.speed - last.speed) <= _SETTLED * scale.speed
        still = still and abs(here.amplitude - last.amplitude) <= 10 * _SETTLED * scale.amplitude
        quiet = quiet + 1 if still else 0
        last = here
        if quiet >= 2:
            return place, here, True
    return place, last, last.beating > 2e-3


def jumps(mover: Mover, plan: Plan, places: Sequence[Place], readings: Sequence[Reading], tolerance: float) -> Iterator[Jump]:
    """The jumps of one ramp. places, readings: at the end of each of its legs. tolerance: relative, of the value."""
    signal = _Signal(mover)
    y = np.array([signal(r) for r in readings])
    for first, last in _steep(y):
        found = _Search(mover, plan, signal, tolerance).jump(places, readings, first, last)
        if found is not None:
            yield found


class _Signal:
    """What jumps: the speed; where that is prescribed, the amplitude."""

    def __init__(self, mover: Mover) -> None:
        self.of_amplitude = mover.machine.rotor.coordinate.prescribed is not None

    def __call__(self, reading: Reading) -> float:
        return reading.amplitude if self.of_amplitude else reading.speed


def _steep(y: np.ndarray) -> list[tuple[int, int]]:
    """Where the signal (N,) changes faster than elsewhere: pairs of indices before and after, the largest changes only.

    These are candidates only: whether the machine jumps there is found by holding the parameter.
    """
    if len(y) < 4 or not np.ptp(y) > 1e-6 * np.abs(y).max():
        return []
    change = np.abs(np.diff(y))
    usual, least = float(np.median(change)), _SMALLEST * float(np.ptp(y))
    steep = np.flatnonzero(change > max(_STEEP * usual, 0.1 * least))
    if not len(steep):
        return []
    groups = np.split(steep, np.flatnonzero(np.diff(steep) > 3) + 1)
    cores = [g[change[g] > _CORE * change[g].max()] for g in groups]
    pairs = [(int(g[0]), int(g[-1]) + 1) for g in cores]
    large = [p for p in pairs if abs(y[p[1]] - y[p[0]]) - (p[1] - p[0]) * usual > least]
    return sorted(sorted(large, key=lambda p: -abs(y[p[1]] - y[p[0]]))[:_MOST])


@dataclass
class _Search:
    mover: Mover
    plan: Plan
    signal: _Signal
    tolerance: float
    after: float = math.nan
    before: float = math.nan
    window: float = 0.0
    steady: Reading = field(default_factory=lambda: Reading(*[math.nan] * 6))

    def jump(self, places: Sequence[Place], readings: Sequence[Reading], first: int, last: int) -> Jump | None:
        """The end of the branch between two legs, None if the signal is steep there but does not jump."""
        beyond = min(last + 1, len(places) - 1)
        _, landed, _ = settle(self.mover, self.plan, places[beyond])
        self.after, self.window = self.signal(landed), max(2 * self.plan.answer, 4 * self.plan.turn)
        found = self._last_steady(places, readings, first)
        seen = readings[first] if found is None else found[1]
        expected = abs(self.after - self.signal(seen))
        if found is None or abs(self.signal(self.steady) - self.signal(seen)) > _OTHER * expected:
            return None if self._overlap(seen, landed) else self._as_seen(places, readings, first, beyond, landed)
        if self._overlap(self.steady, landed):
            return None
        return self._closed_in(found[0], places[beyond], expected)

    def _closed_in(self, low: Place, beyond: Place, expected: float) -> Jump | None:
        """The jump between a place where the machine stays and one beyond, None if what is left of the change is too small."""
        self.before, high, upward = self.signal(self.steady), beyond.value, beyond.value > low.value
        wait, left = math.inf, None
        while abs(high - low.value) > self._width(high):
            held, steady, took = self._hold(low, (low.value + high) / 2, wait)
            if took is None:
                low, self.steady, self.before = held, steady, self.signal(steady)
            else:
                high, left = held.value, held
                wait = _PATIENCE * took * math.sqrt(max(1.0, abs(high - low.value) / self._width(high)))
        if left is None:
            left = beyond
        _, after, _ = settle(self.mover, self.plan, left)
        height = abs(self.signal(after) - self.signal(self.steady))
        if height < _SAME * expected or self._overlap(self.steady, after):
            return None
        vertex = self._vertex(low, high)
        bracket = (min(low.value, high), max(low.value, high))
        if vertex is None:
            return Jump((low.value + high) / 2, upward, self.steady.speed, self.steady.amplitude, after, bracket, False)
        return Jump(vertex[0], upward, vertex[1], vertex[2], after, bracket, True)

    def _overlap(self, one: Reading, other: Reading) -> bool:
        """Whether the beats of two readings overlap: then their means differ only by where the beats are cut."""
        return not self.signal.of_amplitude and max(one.low, other.low) < min(one.high, other.high)

    @staticmethod
    def _as_seen(places: Sequence[Place], readings: Sequence[Reading], first: int, beyond: int, landed: Reading) -> Jump:
        """The jump as the ramp shows it: where the parameter is held before it, the machine goes to another state."""
        ends = places[first].value, places[beyond].value
        before = readings[first]
        return Jump(
            sum(ends) / 2, ends[1] > ends[0], before.speed, before.amplitude, landed, (min(ends), max(ends)), False, True
        )

    def _width(self, value: float) -> float:
        """The width of the bracket that is asked for."""
        return self.tolerance * max(abs(value), 1e-3 * self.plan.rate * self.plan.samples * self.plan.step)

    def _last_steady(self, places: Sequence[Place], readings: Sequence[Reading], first: int) -> tuple[Place, Reading] | None:
        """The last place before the jump at which the machine stays if the parameter is held, and the ramp's reading there.

        A fast ramp has passed it when the jump is seen.
        """
        back = 0
        while True:
            i = max(0, first - back)
            self.before = self.signal(readings[i])
            held, self.steady, took = self._hold(places[i], places[i].value, math.inf)
            if took is None:
                return held, readings[i]
            if i == 0:
                return None
            back = 2 * back + 1

    def _hold(self, place: Place, value: float, wait: float) -> tuple[Place, Reading, float | None]:
        """Lead the parameter to a value and hold it there. Returns where that ends, and after what time the branch was left."""
        begun = place.time
        place, last = self.mover.leg(place, self.window, value)
        quiet, reading = 0, last
        for k in range(_MOST_WINDOWS):
            place, reading = self.mover.leg(place, self.window)
            here = self.signal(reading)
            if abs(here - self.after) < abs(here - self.before):
                return place, reading, place.time - begun
            still = abs(here - self.signal(last)) <= _SETTLED * abs(self.after - self.before)
            quiet, last = (quiet + 1 if still else 0), reading
            if quiet >= 2 or (k >= _FEWEST_WINDOWS and place.time - begun > wait):
                break
        return place, reading, None

    def _vertex(self, low: Place, high: float) -> tuple[float, float, float] | None:
        """Fold, speed and amplitude there, from steady states beside it; None if their parabola does not end here."""
        sense, gap = math.copysign(1.0, high - low.value), abs(high - low.value)
        reach = _REACH * min(self._width(high), JUMP_TOLERANCE * max(abs(high), abs(low.value)))
        found, place = list[Reading](), low
        for distance in _SPREAD:
            place, _ = self.mover.leg(place, self.window, low.value - sense * reach * distance)
            place, reading, settled = settle(self.mover, self.plan, place)
            if not settled or abs(self.signal(reading) - self.after) < abs(self.signal(reading) - self.before):
                return None
            found.append(reading)
        y = np.array([self.signal(r) for r in found])
        p = np.array([r.value for r in found]) - high
        middle, span = y.mean(), np.ptp(y) or 1.0
        cubic = np.polynomial.Polynomial.fit((y - middle) / span, p, 3)
        for root in cubic.deriv().roots():
            value = cubic(root.real)
            if abs(root.imag) < 1e-9 and abs(value + sense * gap / 2) <= gap / 2 + self._width(high) / 2:
                speed, amplitude = (
                    float(np.polynomial.Polynomial.fit((y - middle) / span, np.array(column), 3)(root.real))
                    for column in zip(*((r.speed, r.amplitude) for r in found), strict=True)
                )
                inside = sense * max(-gap, min(0.0, sense * float(value)))
                return high + inside, speed, amplitude
        return None
