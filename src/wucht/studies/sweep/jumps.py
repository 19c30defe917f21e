"""Where a branch ends: the jumps of a sweep, found closer than its finite rate lets them be seen.

A ramp passes the fold p_f of a branch late, by a distance that grows with rate^(2/3). So the parameter is held: from the last
steady state before the jump it is led to values in between, and held there until the machine has settled, or left the branch.
Behind a fold the branch is left after a time T ~ (p - p_f)^(-1/2); this law tells how long to wait before it counts as staying.
Near the fold p is a parabola in the speed, whose vertex is the fold (J. Guckenheimer, P. Holmes, Nonlinear Oscillations,
Dynamical Systems, and Bifurcations of Vector Fields, 1983, section 3.4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.machines.machine import Machine
from wucht.studies.sweep.moving import Leg, Mover, Place, Reading
from wucht.studies.sweep.pace import Pace
from wucht.studies.sweep.settling import SETTLED, settle
from wucht.studies.sweep.spec import JUMP_TOLERANCE

_STEEP, _SMALLEST, _MOST = 2.0, 0.02, 8  # times the median slope; share of the whole range; candidates
_OTHER = 0.3  # of the change: if holding the parameter changes the signal by more, the ramp was in another state
_SAME = 0.2  # of the change between the legs is left between two values that close: else it is steep, but no jump
_CORE = 0.25  # of the largest change between two legs: what changes less is not the jump, but the branch that bends towards it
_MOST_WINDOWS = 400
_PATIENCE = 3.0
_FEWEST_WINDOWS = 10
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


def candidates(machine: Machine, legs: Sequence[Leg]) -> list[tuple[int, int]]:
    """Where the signal of a ramp changes faster than elsewhere: pairs of legs before and after, the largest changes only.

    Whether the machine jumps there is found by holding the parameter.
    """
    y = np.array([signal(machine, leg.reading) for leg in legs])
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


def signal(machine: Machine, reading: Reading) -> float:
    """What jumps: the speed; where that is prescribed, the amplitude."""
    return reading.speed if machine.rotor.coordinate.prescribed is None else reading.amplitude


def find_jump(mover: Mover, pace: Pace, legs: Sequence[Leg], first: int, last: int, tolerance: float) -> Jump | None:
    """The end of the branch between two legs of a ramp, None if the signal is steep there but does not jump.

    tolerance: relative, of the value. Raises ``IntegrationError``.
    """
    beyond = legs[min(last + 1, len(legs) - 1)].place
    landed = settle(mover, pace, beyond).leg.reading
    search = _Search(mover, pace, tolerance, signal(mover.machine, landed))
    held, seen = search.last_steady(legs[: first + 1])
    expected = abs(search.after - search.signal(seen))
    if held.left_after is not None or abs(search.signal(held.reading) - search.signal(seen)) > _OTHER * expected:
        return None if search.overlap(seen, landed) else _as_seen(legs[first], beyond, landed)
    return None if search.overlap(held.reading, landed) else search.closed_in(held, beyond, expected)


def _as_seen(before: Leg, beyond: Place, landed: Reading) -> Jump:
    """The jump as the ramp shows it: where the parameter is held before it, the machine goes to another state."""
    ends = before.place.value, beyond.value
    bracket = min(ends), max(ends)
    return Jump(sum(ends) / 2, ends[1] > ends[0], before.reading.speed, before.reading.amplitude, landed, bracket, False, True)


@dataclass(frozen=True)
class _Held:
    """What holding the parameter showed. left_after: the time after which the branch was left, None where it was not."""

    place: Place
    reading: Reading
    left_after: float | None


@dataclass(frozen=True)
class _Search:
    """For one jump. tolerance: relative, of its value. after: the signal where the machine lands."""

    mover: Mover
    pace: Pace
    tolerance: float
    after: float

    def signal(self, reading: Reading) -> float:
        """What jumps."""
        return signal(self.mover.machine, reading)

    def overlap(self, one: Reading, other: Reading) -> bool:
        """Whether the beats of two readings overlap: then their means differ only by where the beats are cut."""
        by_speed = self.mover.machine.rotor.coordinate.prescribed is None
        return by_speed and max(one.low, other.low) < min(one.high, other.high)

    def last_steady(self, legs: Sequence[Leg]) -> tuple[_Held, Reading]:
        """Held at the last leg before the jump at which the machine stays, and the ramp's reading there.

        A fast ramp has passed it when the jump is seen. If it stays nowhere: held at the first leg, the reading of the last.
        """
        back, last = 0, len(legs) - 1
        while True:
            i = max(0, last - back)
            leg = legs[i]
            held = self._hold(leg.place, leg.place.value, self.signal(leg.reading), math.inf)
            if held.left_after is None:
                return held, leg.reading
            if i == 0:
                return held, legs[last].reading
            back = 2 * back + 1

    def closed_in(self, low: _Held, beyond: Place, expected: float) -> Jump | None:
        """The jump between a place where the machine stays and one beyond, None if what is left of the change is too small."""
        high, left, upward = beyond.value, beyond, beyond.value > low.place.value
        wait = math.inf
        while abs(high - low.place.value) > self._width(high):
            held = self._hold(low.place, (low.place.value + high) / 2, self.signal(low.reading), wait)
            if held.left_after is None:
                low = held
            else:
                high, left = held.place.value, held.place
                wait = _PATIENCE * held.left_after * math.sqrt(max(1.0, abs(high - low.place.value) / self._width(high)))
        after, steady = settle(self.mover, self.pace, left).leg.reading, low.reading
        height = abs(self.signal(after) - self.signal(steady))
        if height < _SAME * expected or self.overlap(steady, after):
            return None
        vertex = self._vertex(low, high)
        value = low.place.value
        bracket = (min(value, high), max(value, high))
        if vertex is None:
            return Jump((value + high) / 2, upward, steady.speed, steady.amplitude, after, bracket, False)
        return Jump(vertex[0], upward, vertex[1], vertex[2], after, bracket, True)

    @property
    def _window(self) -> float:
        return max(2 * self.pace.answer, 4 * self.pace.turn)

    def _width(self, value: float) -> float:
        """The width of the bracket that is asked for."""
        return self.tolerance * max(abs(value), 1e-3 * self.pace.rate * self.pace.samples * self.pace.step)

    def _left(self, reading: Reading, before: float) -> bool:
        """Whether the machine has left its branch, on which the signal was ``before``."""
        here = self.signal(reading)
        return abs(here - self.after) < abs(here - before)

    def _hold(self, place: Place, value: float, before: float, wait: float) -> _Held:
        """Lead the parameter to a value and hold it there. before: the signal on the branch."""
        begun = place.time
        last, quiet = self.mover.leg(place, self._window, value), 0
        for k in range(_MOST_WINDOWS):
            leg = self.mover.leg(last.place, self._window)
            waited = leg.place.time - begun
            if self._left(leg.reading, before):
                return _Held(leg.place, leg.reading, waited)
            change = abs(self.signal(leg.reading) - self.signal(last.reading))
            quiet, last = (quiet + 1 if change <= SETTLED * abs(self.after - before) else 0), leg
            if quiet >= 2 or (k >= _FEWEST_WINDOWS and waited > wait):
                break
        return _Held(last.place, last.reading, None)

    def _vertex(self, low: _Held, high: float) -> tuple[float, float, float] | None:
        """Fold, speed and amplitude there, from steady states beside it; None if their parabola does not end here."""
        begin, before = low.place.value, self.signal(low.reading)
        sense, gap = math.copysign(1.0, high - begin), abs(high - begin)
        reach = _REACH * min(self._width(high), JUMP_TOLERANCE * max(abs(high), abs(begin)))
        beside, place = list[Reading](), low.place
        for distance in _SPREAD:
            place = self.mover.leg(place, self._window, begin - sense * reach * distance).place
            settled = settle(self.mover, self.pace, place)
            if not settled.steady or self._left(settled.leg.reading, before):
                return None
            beside.append(settled.leg.reading)
            place = settled.leg.place
        y = np.array([self.signal(r) for r in beside])
        p = np.array([r.value for r in beside]) - high
        middle, span = y.mean(), np.ptp(y) or 1.0
        cubic = np.polynomial.Polynomial.fit((y - middle) / span, p, 3)
        for root in cubic.deriv().roots():
            value = cubic(root.real)
            if abs(root.imag) < 1e-9 and abs(value + sense * gap / 2) <= gap / 2 + self._width(high) / 2:
                speed, amplitude = (
                    float(np.polynomial.Polynomial.fit((y - middle) / span, np.array(column), 3)(root.real))
                    for column in zip(*((r.speed, r.amplitude) for r in beside), strict=True)
                )
                inside = sense * max(-gap, min(0.0, sense * float(value)))
                return high + inside, speed, amplitude
        return None
