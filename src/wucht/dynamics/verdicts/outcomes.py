"""Outcomes: every run has a label. The contract's criteria, decided from a few numbers, not from a trajectory.

They are written for M motions at once; one run is one of them, whose numbers are no arrays.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, Self, TypeVar

import numpy as np

SPEED_TOLERANCE = 0.005  # of what the drive reaches without vibration: contract, "compensated"
UNBALANCE_TOLERANCE = 0.01  # of the rotor's unbalance: contract, "compensated"
AMPLITUDE_TOLERANCE = 0.01  # of the largest amplitude of a run: one that differs by less from the last ones has settled
LAG_TOLERANCE = 0.001  # of the rotor's mean speed; more is another motion than a synchronous one
MODULATION_THRESHOLD = 2e-3  # range of the turn-averaged speed, of the mean speed: less is not called a modulation
AT_REST = 1e-4  # of the largest speed
FEWEST_TURNS = 6  # of a rotor that turns


class LabelWithSentence(StrEnum):
    """Base of labels that have a ``sentence`` each.

    Attributes
    ----------
    sentence : str
    """

    sentence: str

    def __new__(cls, label: str, sentence: str) -> Self:
        """Create a label with its sentence."""
        member = str.__new__(cls, label)
        member._value_, member.sentence = label, sentence
        return member


class Outcome(LabelWithSentence):
    """Outcome of a run: its label as text, such as ``"captured"``, with its sentence; the criteria are in docs/outcomes.md."""

    COMPENSATED = "compensated", "the rotor reaches its speed and the bodies compensate its unbalance"
    PASSED = "passed", "the rotor gets through its resonance; unbalance is left"
    CAPTURED = "captured", "the rotor is captured at its resonance, at a steady speed"
    CAPTURED_MODULATED = "captured-modulated", "the rotor is captured at its resonance, with modulated speed"
    BALANCER_CAPTURED = "balancer-captured", "the rotor reaches its speed, but bodies lag behind it, captured at the resonance"
    ENTRAINED = "entrained", "the rotor is entrained by the carrier's vibration, at its frequency"
    NOT_ENTRAINED = "not-entrained", "the rotor is not entrained by the carrier's vibration"
    SYNCHRONISED = "synchronised", "the rotors turn at the same mean speed"
    NOT_SYNCHRONISED = "not-synchronised", "the rotors turn at different mean speeds"
    NOT_STARTED = "not-started", "the rotor does not start: its drive does not lift its weight or load from rest"
    STOPPED = "stopped", "no rotation is left"
    OSCILLATING = "oscillating", "the rotor does not turn any more, it oscillates"
    RUNAWAY = "runaway", "the speed goes beyond the limit"
    UNIDENTIFIED = "unidentified", "the run is too short for a verdict"
    FAILED = "failed", "the run failed"


OUTCOMES = tuple(Outcome)
RESONANCE_PASSED = (Outcome.COMPENSATED, Outcome.PASSED)  # the resonance is passed
OPEN_OUTCOMES = (Outcome.UNIDENTIFIED, Outcome.FAILED)  # any other outcome is possible

Bounds = tuple[float, float]  # between which a number is expected to stay
T = TypeVar("T", float, np.ndarray)  # a number; of M motions an array (M,)
_ZERO: Any = (0.0, 0.0)
_ANY_SWING: Any = (0.0, math.inf)


@dataclass(frozen=True)
class Fact:
    """Truth of a criterion: ``yes``, ``no``, or neither while it is not known. For M motions each is an array (M,)."""

    yes: Any
    no: Any

    @classmethod
    def lies_within(cls, bounds: tuple[Any, Any], low: Any, high: Any) -> Self:
        """Decide if a number that stays between bounds stays between limits."""
        least, most = bounds
        return cls((low <= least) & (most <= high), (most < low) | (high < least))

    @classmethod
    def lies_above(cls, bounds: tuple[Any, Any], limit: Any, *, or_at: bool = False) -> Self:
        """Decide if it stays above a limit."""
        least, most = bounds
        if or_at:
            return cls(least >= limit, most < limit)
        return cls(least > limit, most <= limit)

    @property
    def is_known(self) -> Any:
        """True if it is known."""
        return self.yes | self.no

    def __bool__(self) -> bool:
        return bool(self.yes)

    def __and__(self, fact: Fact) -> Fact:
        return Fact(self.yes & fact.yes, self.no | fact.no)

    def __invert__(self) -> Fact:
        return Fact(self.no, self.yes)


_YES = Fact(yes=True, no=False)
_NO = ~_YES


@dataclass(frozen=True)
class Evidence(Generic[T]):
    """Evidence for the criteria: for numbers the bounds between which they will stay. Speeds are positive as the rotor turns.

    turning: at least a few turns were made. mean_speed, lowest_speed: of the rotor, averaged over turns. has_settled: its mean
    speed will not change by more than 0.5 % any more, and its motion lasts. free_speed: the drive's speed without
    vibration, None if that is not determined (of M motions: nan). resonance: speed of the last maximum of the vibration torque
    below it, None if there is none (nan). residual: largest share of the rotor's unbalance that is left (1: as without
    balancers), None without unbalance. lags: of each body behind the rotor, as a share of its speed. modulation:
    the range of the speed, as a share of it. swing: of a rotor that does not turn any more the largest speed, as a share of the
    largest in the run. is_held: of a rotor that does not turn: it never did, and its drive gives a torque at standstill that is
    not more than its weight and load take. unheld: from its present value on nothing limits the speed below the speed limit.
    """

    turning: bool | np.ndarray
    mean_speed: tuple[T, T] = _ZERO
    lowest_speed: tuple[T, T] = _ZERO
    has_settled: bool | np.ndarray = True
    free_speed: T | None = None
    resonance: T | None = None
    residual: tuple[T, T] | None = None
    lags: tuple[tuple[T, T], ...] = ()
    modulation: tuple[T, T] = _ZERO
    swing: tuple[T, T] = _ANY_SWING
    is_held: bool = False
    unheld: bool = False
    beyond_limit: bool = False

    @property
    def is_at_speed(self) -> Fact:
        """True if the rotor holds the drive's speed without vibration, within 0.5 %."""
        if self.free_speed is None:
            return _NO
        reach = SPEED_TOLERANCE * abs(self.free_speed)
        limits = self.free_speed - reach, self.free_speed + reach
        is_held = Fact.lies_within(self.mean_speed, *limits) & Fact.lies_within(self.lowest_speed, *limits)
        return Fact(is_held.yes, is_held.no | (self.free_speed != self.free_speed))

    @property
    def is_balanced(self) -> Fact:
        """True if less than 1 % of the unbalance is left."""
        return _NO if self.residual is None else ~Fact.lies_above(self.residual, UNBALANCE_TOLERANCE, or_at=True)

    @property
    def asynchronous(self) -> Fact:
        """True if a body lags by more than 0.1 % of the speed."""
        return ~functools.reduce(Fact.__and__, (Fact.lies_within(x, -LAG_TOLERANCE, LAG_TOLERANCE) for x in self.lags), _YES)

    @property
    def is_beyond_resonance(self) -> Fact:
        """True if the rotor stays beyond its resonance."""
        if self.resonance is None:
            return _YES
        above = Fact.lies_above(self.lowest_speed, self.resonance)
        return Fact(above.yes | (self.resonance != self.resonance), above.no)

    @property
    def is_modulated(self) -> Fact:
        """True if the speed varies by more than 0.2 %."""
        return Fact.lies_above(self.modulation, MODULATION_THRESHOLD)


def classify(e: Evidence[float]) -> Outcome:
    """Return the outcome of one motion: see ``classify_each``."""
    return OUTCOMES[int(classify_each(e))]


def classify_each(e: Evidence[Any]) -> np.ndarray:
    """Return the places in ``OUTCOMES`` (M,) of M motions; () of one.

    It is the single outcome that remains possible for a motion, each criterion taken for itself; ``unidentified`` if several
    remain. In this order:

    1. ``runaway``: beyond the limit, or approaching it with nothing that could limit the speed.
    2. not turning: ``not-started`` if it never turned and is held, and its swing is known to last or to end; else ``stopped``
       if no more than a ten-thousandth of the largest speed will be left, ``oscillating`` if more.
    3. ``unidentified``: the mean speed is not settled.
    4. ``compensated``: mean and lowest speed within 0.5 % of the free speed, less than 1 % of the unbalance left, no body lags.
    5. ``balancer-captured``: a body lags, while the rotor holds its free speed within 0.5 % or stays beyond the resonance.
    6. ``passed``: beyond the resonance, or there is none below the free speed.
    7. ``captured-modulated``: modulated, and at or before the resonance at least once a period. ``captured``: not modulated.
    """
    facts, swings = (
        (e.is_at_speed, e.is_balanced, e.asynchronous, e.is_beyond_resonance, e.is_modulated),
        Fact.lies_above(e.swing, AT_REST),
    )
    unknown = OUTCOMES.index(Outcome.UNIDENTIFIED)
    turning = _outcomes()[tuple(2 * f.yes + f.no - 1 for f in facts)]
    at_rest = np.where(swings.yes, OUTCOMES.index(Outcome.OSCILLATING), OUTCOMES.index(Outcome.STOPPED))
    at_rest = np.where(e.is_held, OUTCOMES.index(Outcome.NOT_STARTED), at_rest)
    outcome = np.where(e.turning, np.where(e.has_settled, turning, unknown), np.where(swings.is_known, at_rest, unknown))
    return np.where(e.beyond_limit or e.unheld, OUTCOMES.index(Outcome.RUNAWAY), outcome)


@functools.cache
def _outcomes() -> np.ndarray:
    """Table of the places in ``OUTCOMES`` of motions that turn, by their facts, each 0, 1, or -1 if it is not known."""
    table, unknown = np.empty((3,) * 5, np.int8), OUTCOMES.index(Outcome.UNIDENTIFIED)
    for facts in itertools.product((0, 1, -1), repeat=5):
        possible = {_outcome(*criteria) for criteria in itertools.product(*((0, 1) if f < 0 else (f,) for f in facts))}
        table[facts] = OUTCOMES.index(possible.pop()) if len(possible) == 1 else unknown
    return table


def _outcome(is_at_speed: int, is_balanced: int, asynchronous: int, is_beyond_resonance: int, is_modulated: int) -> Outcome:
    """Return the outcome of a motion with all facts known."""
    if is_at_speed and is_balanced and not asynchronous:
        return Outcome.COMPENSATED
    if is_beyond_resonance or (asynchronous and is_at_speed):
        return Outcome.BALANCER_CAPTURED if asynchronous else Outcome.PASSED
    return Outcome.CAPTURED_MODULATED if is_modulated else Outcome.CAPTURED


LOCK_TOLERANCE = 1e-3  # of the mean speed: contract, "by the mean speed over whole periods"
FEWEST_PERIODS = 5
PHASE_TOLERANCE = 0.2 * math.pi


@dataclass(frozen=True)
class Locking:
    """Evidence of the locking of rotors that may be entrained. periods: the number of whole periods observed.

    speed_differences: of the mean speed of each compared rotor to the reference, as shares of that; phases: the slow
    phases to it, in rad; both the bounds between which they will stay. is_bounded: the speeds stay bounded.
    """

    periods: int
    speed_differences: tuple[Bounds, ...]
    phases: tuple[Bounds, ...]
    is_bounded: bool = True

    @property
    def is_locked(self) -> bool | None:
        """True if all turn at one mean speed with phases at rest; None if that is not known.

        Locked: within 0.1 %, with phases that will move by less than a tenth of a turn. Not: a rotor stays further off.
        """
        if self.periods < FEWEST_PERIODS:
            return None
        facts = [Fact.lies_within(off, -LOCK_TOLERANCE, LOCK_TOLERANCE) for off in self.speed_differences]
        if any(fact.no for fact in facts):
            return False if self.is_bounded else None
        at_rest = all(high - low < PHASE_TOLERANCE for low, high in self.phases)
        return True if at_rest and all(fact.yes for fact in facts) else None

    def outcome(self, *, by_vibration: bool) -> Outcome:
        """Return ``entrained`` or ``synchronised``, not so, or ``unidentified``. by_vibration: by a prescribed vibration."""
        yes, no = (
            (Outcome.ENTRAINED, Outcome.NOT_ENTRAINED) if by_vibration else (Outcome.SYNCHRONISED, Outcome.NOT_SYNCHRONISED)
        )
        return Outcome.UNIDENTIFIED if self.is_locked is None else yes if self.is_locked else no
