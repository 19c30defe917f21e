"""From the record of a coast-down to how it ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.results.outcomes import Outcome
from wucht.studies.coast_down.record import Record

AT_REST = 1e-4  # of the speed at the start
_LAST = 0.1  # share of the run that the outcome is judged by


@dataclass(frozen=True)
class Ending:
    """How it ends: an outcome of the contract or None while it turns, in words, the mean speed and its range at the end."""

    outcome: Outcome | None
    sentence: str
    speed: float
    low: float
    high: float


def ending(record: Record) -> Ending:
    """Judged by the last tenth of the run, or by what follows the first reversal if that is shorter.

    ``failed``: it could not be integrated further. ``stopped``: below a ten-thousandth of the speed at the start.
    ``oscillating``: turned back at least twice, and less than a turn was made. Else None: it still turns, or creeps on.
    """
    time, angle = record.rows["time"], record.rows["angle"]
    since = time[-1] - _LAST * (time[-1] - time[0])
    if record.reversal_time is not None:
        since = min(max(since, record.reversal_time), float(time[-2]))
    late = time >= since
    low, high = float(record.rows["min_speed"][late].min()), float(record.rows["max_speed"][late].max())
    duration = float(time[late][-1] - time[late][0])
    mean = float((angle[late][-1] - angle[late][0]) / duration) if duration else float(record.rows["speed"][-1])
    outcome = None
    if record.end.failure:
        outcome = Outcome.FAILED
    elif max(abs(low), abs(high)) <= AT_REST * abs(record.start_speed):
        outcome = Outcome.STOPPED
    elif record.swings >= 2 and np.ptp(angle[late]) < 2 * math.pi:
        outcome = Outcome.OSCILLATING
    return Ending(outcome, _still_turning(record, mean) if outcome is None else outcome.sentence, mean, low, high)


def _still_turning(record: Record, mean: float) -> str:
    reversed_ = record.reversal_time is not None
    speed = mean if reversed_ or not record.turns.size else record.turns[1, -1]
    turning = "the rotor has turned back" if reversed_ else "the rotor still turns"
    return f"{turning}, at {100 * abs(speed / record.start_speed):.3g} % of its speed at the start"
