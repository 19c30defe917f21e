"""Outcomes: every run gets a label. The contract's criteria, decided from a few numbers, not from a trajectory."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

SPEED_TOLERANCE = 0.005  # of what the drive reaches without vibration: contract, "compensated"
UNBALANCE_TOLERANCE = 0.01  # of the rotor's unbalance: contract, "compensated"
AMPLITUDE_TOLERANCE = 0.01  # of the largest amplitude of a run: one that differs by less from the last ones has settled
LAG_TOLERANCE = 0.001  # of the rotor's mean speed; more is another motion than a synchronous one
MODULATION_THRESHOLD = 2e-3  # range of the turn-averaged speed, of the mean speed: less is not called a modulation
AT_REST = 1e-4  # of the largest speed


class Outcome(StrEnum):
    """How a run ended, and that in words."""

    sentence: str

    def __new__(cls, label: str, sentence: str) -> Self:
        """A label with its sentence."""
        member = str.__new__(cls, label)
        member._value_, member.sentence = label, sentence
        return member

    COMPENSATED = "compensated", "the rotor reaches its speed and the bodies compensate its unbalance"
    PASSED = "passed", "the rotor gets through its resonance; unbalance is left"
    CAPTURED = "captured", "the rotor is captured at its resonance, at a steady speed"
    CAPTURED_MODULATED = "captured-modulated", "the rotor is captured at its resonance, with modulated speed"
    BALANCER_CAPTURED = "balancer-captured", "the rotor reaches its speed, but bodies lag behind it, captured at the resonance"
    ENTRAINED = "entrained", "the rotor is entrained by the carrier's vibration, at its frequency"
    NOT_ENTRAINED = "not-entrained", "the rotor is not entrained by the carrier's vibration"
    SYNCHRONISED = "synchronised", "the rotors turn at the same mean speed"
    NOT_SYNCHRONISED = "not-synchronised", "the rotors turn at different mean speeds"
    STOPPED = "stopped", "no rotation is left"
    OSCILLATING = "oscillating", "the rotor does not turn any more, it oscillates"
    RUNAWAY = "runaway", "the speed goes beyond the limit"
    UNIDENTIFIED = "unidentified", "the run is too short for a verdict"
    FAILED = "failed", "the run failed"


THROUGH = (Outcome.COMPENSATED, Outcome.PASSED)  # the resonance is passed
OPEN = (Outcome.UNIDENTIFIED, Outcome.FAILED)  # could have come to any other

Bounds = tuple[float, float]  # between which something will stay, as far as it can be told
_NOTHING: Bounds = (0.0, 0.0)


@dataclass(frozen=True)
class Evidence:
    """What the criteria need: of numbers the bounds between which they will stay. Speeds are positive as the rotor turns.

    turning: at least a few turns were made. mean_speed, lowest_speed: of the rotor, averaged over turns. settled: its mean
    speed will not change by more than 0.5 % any more, and what it does goes on. free_speed: what the drive reaches without
    vibration, None if that is not determined. resonance: speed of the last maximum of the vibration torque below it, None if
    there is none. residual: largest share of the rotor's unbalance that is left (1: as without balancers), None without
    unbalance. lags: by how much each body lags behind the rotor, as a share of its speed. modulation: the range of the speed,
    as a share of it. swing: of a rotor that does not turn any more the largest speed, as a share of the largest there was.
    unheld: nothing can hold the speed before the limit, from where it is.
    """

    turning: bool
    mean_speed: Bounds = _NOTHING
    lowest_speed: Bounds = _NOTHING
    settled: bool = True
    free_speed: float | None = None
    resonance: float | None = None
    residual: Bounds | None = None
    lags: tuple[Bounds, ...] = ()
    modulation: Bounds = _NOTHING
    swing: Bounds = (0.0, math.inf)
    unheld: bool = False
    beyond_limit: bool = False

    @property
    def at_speed(self) -> bool | None:
        """Whether the rotor holds what the drive reaches without vibration, within 0.5 %; None: it cannot be told."""
        if self.free_speed is None:
            return False
        reach = SPEED_TOLERANCE * abs(self.free_speed)
        limits = self.free_speed - reach, self.free_speed + reach
        each = [_within(bounds, *limits) for bounds in (self.mean_speed, self.lowest_speed)]
        return False if False in each else None if None in each else True

    @property
    def balanced(self) -> bool | None:
        """Whether less than 1 % of the unbalance is left, likewise."""
        return False if self.residual is None else _not(_above(self.residual, UNBALANCE_TOLERANCE, or_at=True))

    @property
    def asynchronous(self) -> bool | None:
        """Whether a body lags by more than 0.1 % of the speed, likewise."""
        each = [_within(lag, -LAG_TOLERANCE, LAG_TOLERANCE) for lag in self.lags]
        return True if False in each else None if None in each else False

    @property
    def beyond(self) -> bool | None:
        """Whether the rotor stays beyond its resonance, likewise."""
        return True if self.resonance is None else _above(self.lowest_speed, self.resonance)

    @property
    def modulated(self) -> bool | None:
        """Whether the speed varies by more than 0.2 %, likewise."""
        return _above(self.modulation, MODULATION_THRESHOLD)


def _within(bounds: Bounds, low: float, high: float) -> bool | None:
    """Whether what stays between bounds stays between limits."""
    return True if low <= bounds[0] and bounds[1] <= high else False if bounds[1] < low or high < bounds[0] else None


def _above(bounds: Bounds, limit: float, *, or_at: bool = False) -> bool | None:
    """Whether it stays above a limit."""
    above = bounds[0] >= limit if or_at else bounds[0] > limit
    below = bounds[1] < limit if or_at else bounds[1] <= limit
    return True if above else False if below else None


def _not(fact: bool | None) -> bool | None:
    return None if fact is None else not fact


def classify(e: Evidence) -> Outcome:
    """The outcome, if all that can still come of it gives the same; else ``unidentified``. Each criterion is taken for itself.

    In this order:

    1. ``runaway``: beyond the limit, or on the way there with nothing that could hold it.
    2. not turning: ``stopped`` if no more than a ten-thousandth of the largest speed will be left, ``oscillating`` if more.
    3. ``unidentified``: the mean speed is not settled.
    4. ``compensated``: mean and lowest speed within 0.5 % of the free speed, less than 1 % of the unbalance left, no body lags.
    5. ``balancer-captured``: a body lags, while the rotor holds its free speed within 0.5 % or stays beyond the resonance.
    6. ``passed``: beyond the resonance, or there is none below the free speed.
    7. ``captured-modulated``: modulated, and at or before the resonance at least once a period. ``captured``: not modulated.
    """
    if e.beyond_limit or e.unheld:
        return Outcome.RUNAWAY
    if not e.turning:
        swings = _above(e.swing, AT_REST)
        return Outcome.UNIDENTIFIED if swings is None else Outcome.OSCILLATING if swings else Outcome.STOPPED
    if not e.settled:
        return Outcome.UNIDENTIFIED
    facts = (e.at_speed, e.balanced, e.asynchronous, e.beyond, e.modulated)
    possible = {_outcome(*each) for each in itertools.product(*((True, False) if f is None else (f,) for f in facts))}
    return possible.pop() if len(possible) == 1 else Outcome.UNIDENTIFIED


def _outcome(at_speed: bool, balanced: bool, asynchronous: bool, beyond: bool, modulated: bool) -> Outcome:
    """The outcome of a motion of which all is known."""
    if at_speed and balanced and not asynchronous:
        return Outcome.COMPENSATED
    if beyond or (asynchronous and at_speed):
        return Outcome.BALANCER_CAPTURED if asynchronous else Outcome.PASSED
    return Outcome.CAPTURED_MODULATED if modulated else Outcome.CAPTURED


LOCK_TOLERANCE = 1e-3  # of the mean speed: contract, "by the mean speed over whole periods"
FEWEST_PERIODS = 5
PHASE_TOLERANCE = 0.2 * math.pi


@dataclass(frozen=True)
class Locking:
    """Of rotors that may be entrained. periods: how many whole ones were seen.

    apart: by how much the mean speed of each compared rotor differs from the reference, as a share of that; phases: the slow
    phases to it, in rad; both the bounds between which they will stay. bounded: whether the speeds will.
    """

    periods: int
    apart: tuple[Bounds, ...]
    phases: tuple[Bounds, ...]
    bounded: bool = True

    @property
    def locked(self) -> bool | None:
        """Whether all turn at one mean speed with phases at rest; None: it cannot be told.

        Locked: within 0.1 %, with phases that will move by less than a tenth of a turn. Not: a rotor is further off for good.
        """
        if self.periods < FEWEST_PERIODS:
            return None
        each = [_within(off, -LOCK_TOLERANCE, LOCK_TOLERANCE) for off in self.apart]
        if False in each:
            return False if self.bounded else None
        at_rest = all(high - low < PHASE_TOLERANCE for low, high in self.phases)
        return True if at_rest and None not in each else None

    def outcome(self, *, by_vibration: bool) -> Outcome:
        """``entrained`` or ``synchronised``, not so, or ``unidentified``. by_vibration: by a prescribed vibration."""
        yes, no = (
            (Outcome.ENTRAINED, Outcome.NOT_ENTRAINED) if by_vibration else (Outcome.SYNCHRONISED, Outcome.NOT_SYNCHRONISED)
        )
        return Outcome.UNIDENTIFIED if self.locked is None else yes if self.locked else no
