"""Outcomes: every run gets a label. The contract's criteria, decided from a few numbers, not from a trajectory."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

SPEED_TOLERANCE = 0.005  # of what the drive reaches without vibration: contract, "compensated"
UNBALANCE_TOLERANCE = 0.01  # of the rotor's unbalance: contract, "compensated"
LAG_TOLERANCE = 0.001  # of the rotor's mean speed; more is another motion than a synchronous one


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
    RUNAWAY = "runaway", "the speed went beyond the given limit"
    UNIDENTIFIED = "unidentified", "the run is too short for a verdict"
    FAILED = "failed", "the run failed"


@dataclass(frozen=True)
class Evidence:
    """What the criteria need, all over the last window; speeds positive in the sense in which the drive turns.

    mean_speed, lowest_speed: of the rotor, averaged over turns (mean and least). free_speed: what the drive reaches without
    vibration, None if that is not determined. resonance: speed of the last maximum of the vibration torque below it, None if
    there is none. residual: largest share of the rotor's unbalance that is left (1: as without balancers), None without
    unbalance. lag: the largest amount by which a body lags behind the rotor, in speed. steady: nothing changes any more.
    modulated: with a range that neither grows nor decays. turning: at least a few turns were made. moving: an oscillation is
    left.
    """

    turning: bool
    mean_speed: float = 0.0
    lowest_speed: float = 0.0
    free_speed: float | None = None
    resonance: float | None = None
    residual: float | None = None
    lag: float = 0.0
    steady: bool = False
    modulated: bool = False
    moving: bool = False
    at_rest: bool = False
    beyond_limit: bool = False


def classify(e: Evidence) -> Outcome:
    """The outcome. The order of the criteria:

    1. ``runaway``: beyond the given limit.
    2. not turning: ``oscillating`` if a steady oscillation is left, ``stopped`` if nothing moves, else ``unidentified``.
    3. ``compensated``: mean and lowest speed within 0.5 % of the free speed, less than 1 % of the unbalance left, no lag.
    4. ``balancer-captured``: a body lags, while the rotor holds its free speed within 0.5 % or stays beyond the resonance.
    5. ``captured``: steady, at or before the resonance.
    6. ``captured-modulated``: modulated, and at or before the resonance at least once a period.
    7. ``passed``: steady or modulated beyond the resonance, or there is no resonance below the free speed.
    8. ``unidentified``: anything else.
    """
    if e.beyond_limit:
        return Outcome.RUNAWAY
    if not e.turning:
        oscillating = e.moving and (e.steady or e.modulated)
        return Outcome.STOPPED if e.at_rest else Outcome.OSCILLATING if oscillating else Outcome.UNIDENTIFIED
    at_speed = e.free_speed is not None and all(
        abs(w - e.free_speed) <= SPEED_TOLERANCE * abs(e.free_speed) for w in (e.mean_speed, e.lowest_speed)
    )
    asynchronous = e.lag > LAG_TOLERANCE * abs(e.mean_speed)
    if at_speed and not asynchronous and e.residual is not None and e.residual < UNBALANCE_TOLERANCE:
        return Outcome.COMPENSATED
    if not (e.steady or e.modulated):
        return Outcome.UNIDENTIFIED
    beyond = e.resonance is None or e.lowest_speed > e.resonance
    if beyond or (asynchronous and at_speed):
        return Outcome.BALANCER_CAPTURED if asynchronous else Outcome.PASSED
    return Outcome.CAPTURED_MODULATED if e.modulated else Outcome.CAPTURED


LOCK_TOLERANCE = 1e-3  # of the mean speed: contract, "by the mean speed over whole periods"
FEWEST_PERIODS = 5


@dataclass(frozen=True)
class Locking:
    """Mean speeds over whole periods, in magnitude: of the rotors, and the frequency of a prescribed vibration if there is one.

    periods: how many. creep: by how much the slow phase moved in the second half of them, in rad.
    """

    speeds: tuple[float, ...]
    frequency: float | None
    periods: int
    creep: float

    def outcome(self) -> Outcome:
        """The outcome. Without enough periods it is ``unidentified``.

        With a prescribed vibration: ``entrained`` if the main rotor's mean speed is its frequency within 0.1 % and its phase
        has come to rest (it moved by less than a tenth of a turn), else ``not-entrained``. With several rotors:
        ``synchronised`` if all have the main rotor's mean speed within 0.1 %, likewise, else ``not-synchronised``.
        """
        if self.periods < FEWEST_PERIODS:
            return Outcome.UNIDENTIFIED
        reference = self.frequency if self.frequency is not None else self.speeds[0]
        compared = self.speeds[:1] if self.frequency is not None else self.speeds[1:]
        same = all(abs(w - reference) <= LOCK_TOLERANCE * reference for w in compared) and self.creep < 0.2 * math.pi
        if self.frequency is not None:
            return Outcome.ENTRAINED if same else Outcome.NOT_ENTRAINED
        return Outcome.SYNCHRONISED if same else Outcome.NOT_SYNCHRONISED
