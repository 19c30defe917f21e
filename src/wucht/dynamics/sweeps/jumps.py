"""Ends of branches: the jumps of a sweep, located more closely than its finite rate allows.

A ramp passes the fold p_f of a branch late, by a distance that grows with rate^(2/3). So the parameter is held: from the last
steady state before the jump it is moved to values in between, and held there until the machine has settled, or left the
branch. Beyond a fold the branch is left after a time T ~ (p - p_f)^(-1/2); from this law follows how long to wait before the
machine counts as staying.
Near the fold p is a parabola in the speed, whose vertex is the fold (J. Guckenheimer, P. Holmes, Nonlinear Oscillations,
Dynamical Systems, and Bifurcations of Vector Fields, 1983, section 3.4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np

from wucht.dynamics.sweeps.moving import SETTLING_TOLERANCE, Mover, Place, SweepLeg

JUMP_TOLERANCE = 1e-4
_STEEP, _SMALLEST, _MOST = 2.0, 0.02, 8  # times the median slope; share of the whole range; candidates
_OTHER_STATE = 0.3  # of the change: if holding the parameter changes the signal by more, the ramp was in another state
_SAME = 0.2  # least share of the change between the legs that remains between two close values: else it is steep, but no jump
_CORE = 0.25  # of the largest change between two legs: smaller changes belong to the branch that bends towards the jump
_MOST_WINDOWS = 400
_PATIENCE = 3.0
_FEWEST_WINDOWS = 10
_REACH = 4.0  # of the first point before the end of the branch, in widths of the bracket
_SPREAD = (1.0, 4.0, 9.0, 16.0)  # of the points of the parabola: evenly spaced in the speed

_Vertex = tuple[float, float, float]  # the fold, speed and amplitude there


@dataclass(frozen=True)
class Jump:
    """Jump at the end of a branch. value: of the parameter there. direction: in which it moves, "up" or "down".

    from_speed, from_amplitude: on the branch at its end; to_speed, to_amplitude: of the steady state after the jump. fold: True
    if the branch ends in a parabola; else it loses its stability in another way. only_seen: observed by the ramp only, because
    the machine does not stay in the state before the jump if the parameter is held. bracket: values between which the end lies.
    """

    value: float
    from_speed: float
    to_speed: float
    direction: str
    from_amplitude: float
    to_amplitude: float
    fold: bool
    only_seen: bool
    bracket: tuple[float, float]

    @property
    def change(self) -> str:
        """What changes most, in words."""
        if math.isclose(self.from_speed, self.to_speed, rel_tol=1e-4):
            return f"the amplitude jumps from {self.from_amplitude:.4g} to {self.to_amplitude:.4g}"
        return f"the speed jumps from {self.from_speed:.5g} to {self.to_speed:.5g}"

    @property
    def doubts(self) -> tuple[str, ...]:
        """Where it is observed by the ramp only, that it is."""
        if not self.only_seen:
            return ()
        low, high = self.bracket
        return (
            f"the jump near {self.value:.5g} is only known to lie between {low:.6g} and {high:.6g}: with "
            "the parameter held before it, the machine does not remain in the state of the sweep; a lower rate shows where it "
            "settles",
        )


def hysteresis(jumps: Sequence[Jump]) -> list[float] | None:
    """Return the range of values in which the state depends on the direction of the sweep; None if there is none."""
    up, down = ([j.value for j in jumps if j.direction == way] for way in ("up", "down"))
    return [min(down), max(up)] if up and down and min(down) < max(up) else None


def candidates(mover: Mover, legs: Sequence[SweepLeg]) -> list[tuple[int, int]]:
    """Return where the signal of a ramp changes faster than elsewhere: pairs of legs before and after, largest changes only.

    Holding the parameter shows then if the machine jumps there.
    """
    y = np.array([mover.signal(leg) for leg in legs])
    if len(y) < 4 or not np.ptp(y) > 1e-6 * np.abs(y).max():
        return []
    change = np.abs(np.diff(y))
    usual, least = float(np.median(change)), _SMALLEST * float(np.ptp(y))
    steep = np.flatnonzero(change > max(_STEEP * usual, 0.1 * least))
    if not len(steep):
        return []
    groups = np.split(steep, np.flatnonzero(np.diff(steep) > 3) + 1)
    cores = [g[change[g] > _CORE * change[g].max()] for g in groups]
    sizes = {(int(g[0]), int(g[-1]) + 1): abs(y[g[-1] + 1] - y[g[0]]) for g in cores}
    large = [pair for pair, size in sizes.items() if size - (pair[1] - pair[0]) * usual > least]
    return sorted(sorted(large, key=lambda pair: -sizes[pair])[:_MOST])


def find_jump(mover: Mover, legs: Sequence[SweepLeg], first: int, last: int, tolerance: float) -> Jump | None:
    """Locate the end of the branch between two legs of a ramp, None if the signal is steep there but does not jump.

    tolerance: of the value, relative. Raises ``IntegrationError``.
    """
    before, beyond = legs[first], legs[min(last + 1, len(legs) - 1)].place
    landing, _ = mover.settle(beyond)
    search = _Search(mover, mover.signal(landing), tolerance)
    held_leg, left_after, ramp_leg = search.last_steady(legs[: first + 1])
    expected_change = abs(search.after - mover.signal(ramp_leg))
    if left_after is None and abs(mover.signal(held_leg) - mover.signal(ramp_leg)) <= _OTHER_STATE * expected_change:
        return None if search.overlap(held_leg, landing) else search.close_in(held_leg, beyond, expected_change)
    if search.overlap(ramp_leg, landing):
        return None
    return _jump((before.place.value, beyond.value), before, landing, ramp_only=True)


def _jump(
    ends: tuple[float, float], before: SweepLeg, after: SweepLeg, vertex: _Vertex | None = None, ramp_only: bool = False
) -> Jump:
    """Return a jump between two values, in the order in which they are passed; at the vertex of a parabola if there is one."""
    value, speed, amplitude = vertex or (sum(ends) / 2, before.speed, before.amplitude)
    way, bracket = "up" if ends[1] > ends[0] else "down", (min(ends), max(ends))
    return Jump(value, speed, after.speed, way, amplitude, after.amplitude, vertex is not None, ramp_only, bracket)


@dataclass(frozen=True)
class _Search:
    """Search of one jump. after: the signal after the jump. tolerance: of the value of the parameter, relative."""

    mover: Mover
    after: float
    tolerance: float

    def overlap(self, first: SweepLeg, second: SweepLeg) -> bool:
        """True if the modulations in two legs overlap: then their means differ only by where the modulation is cut."""
        by_speed = self.mover.moved_machine.machine.rotor.coordinate.prescribed_velocity is None
        return by_speed and max(first.low, second.low) < min(first.high, second.high)

    def last_steady(self, legs: Sequence[SweepLeg]) -> tuple[SweepLeg, float | None, SweepLeg]:
        """Hold at the last leg before the jump at which the machine stays; return the result of ``_hold`` and that leg.

        A fast ramp has passed it when the signal jumps. If the machine stays nowhere: held at the first leg, and the last leg.
        """
        for k in count():
            leg = legs[max(0, len(legs) - 2**k)]
            held_leg, left_after = self._hold(leg.place, leg.place.value, self.mover.signal(leg), math.inf)
            if left_after is None:
                return held_leg, None, leg
            if leg is legs[0]:
                break
        return held_leg, left_after, legs[-1]

    def close_in(self, low: SweepLeg, beyond: Place, expected_change: float) -> Jump | None:
        """Bracket the jump between a place where the machine stays and one beyond, None if the remaining change is small."""
        high, wait = beyond, math.inf
        while (gap := abs(high.value - low.place.value)) > self._width(high.value):
            middle = (low.place.value + high.value) / 2
            held_leg, left_after = self._hold(low.place, middle, self.mover.signal(low), wait)
            if left_after is None:
                low = held_leg
            else:
                high, gap = held_leg.place, abs(held_leg.place.value - low.place.value)
                wait = _PATIENCE * left_after * math.sqrt(max(1.0, gap / self._width(high.value)))
        after, _ = self.mover.settle(high)
        if abs(self.mover.signal(after) - self.mover.signal(low)) < _SAME * expected_change or self.overlap(low, after):
            return None
        return _jump((low.place.value, high.value), low, after, self._vertex(low, high.value))

    @property
    def _window(self) -> float:
        return max(2 * self.mover.moved_machine.pace.response_time, 4 * self.mover.moved_machine.pace.turn)

    def _width(self, value: float) -> float:
        """Return the requested width of the bracket."""
        pace = self.mover.moved_machine.pace
        return self.tolerance * max(abs(value), 1e-3 * pace.rate * pace.samples * pace.step)

    def _has_left(self, leg: SweepLeg, before: float) -> bool:
        """True if the machine has left its branch, on which the signal was ``before``."""
        signal = self.mover.signal(leg)
        return abs(signal - self.after) < abs(signal - before)

    def _hold(self, place: Place, value: float, before: float, wait: float) -> tuple[SweepLeg, float | None]:
        """Move the parameter to a value and hold it: return the last leg, and the time at which the branch was left, or None.

        before: the signal on the branch.
        """
        leg, quiet = self.mover.leg(place, self._window, value), 0
        for k in range(_MOST_WINDOWS):
            last, leg = leg, self.mover.leg(leg.place, self._window)
            waiting_time = leg.place.time - place.time
            if self._has_left(leg, before):
                return leg, waiting_time
            change = abs(self.mover.signal(leg) - self.mover.signal(last))
            quiet = quiet + 1 if change <= SETTLING_TOLERANCE * abs(self.after - before) else 0
            if quiet == 2 or (k >= _FEWEST_WINDOWS and waiting_time > wait):
                break
        return leg, None

    def _vertex(self, low: SweepLeg, high: float) -> _Vertex | None:
        """Return the vertex from steady states beside the fold; None if their parabola does not end between the two values."""
        begin, before, place = low.place.value, self.mover.signal(low), low.place
        sense, gap = math.copysign(1.0, high - begin), abs(high - begin)
        reach = _REACH * min(self._width(high), JUMP_TOLERANCE * max(abs(high), abs(begin)))
        beside = list[SweepLeg]()
        for distance in _SPREAD:
            approach = self.mover.leg(place, self._window, begin - sense * reach * distance)
            settled_leg, steady = self.mover.settle(approach.place)
            if not steady or self._has_left(settled_leg, before):
                return None
            beside.append(settled_leg)
            place = settled_leg.place
        y = np.array([self.mover.signal(r) for r in beside])
        x = (y - y.mean()) / (np.ptp(y) or 1.0)
        p, *branch = (
            np.polynomial.Polynomial.fit(x, np.array(column), 3)
            for column in zip(*((r.value - high, r.speed, r.amplitude) for r in beside), strict=True)
        )
        for root in p.deriv().roots():
            value = p(root.real)
            if abs(root.imag) < 1e-9 and abs(value + sense * gap / 2) <= gap / 2 + self._width(high) / 2:
                speed, amplitude = (float(of_root(root.real)) for of_root in branch)
                return high + sense * max(-gap, min(0.0, sense * float(value))), speed, amplitude
        return None
