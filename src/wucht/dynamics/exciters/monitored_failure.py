"""A failing machine whose speed a slow sensor measures: when, its readings, and what averaged equations give."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wucht.dynamics.exciters.failing_machine import FailingMachine, FailingRun
from wucht.dynamics.exciters.speed_readings import AveragedSpeed, Readings, Windows, averaged_speed
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.piecewise import Pieces

_SETTLE = 3.0  # times the part over which the mean is taken: the settling time
_STEADY_TOLERANCE = 1e-4  # of the speed: a larger spread of readings indicates a motion that beats, or has not settled
_BEATING_OUTCOMES = (Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED, Outcome.UNIDENTIFIED)


@dataclass(frozen=True)
class ScheduledFall:
    """Schedule of the carrier's stiffness. begin, end: between which it changes."""

    pieces: Pieces
    begin: float
    end: float

    def share(self, time: np.ndarray) -> np.ndarray:
        """Return the share (N,) of the first value."""
        first, *_ = self.pieces.breakpoints
        return np.asarray(self.pieces(time)) / float(self.pieces(first - 1.0))


def changes_of(pieces: Pieces) -> list[float]:
    """Return the breakpoints of a schedule at or beside which the value changes."""
    jumps = list(pieces.jumps())
    for a, b in pairwise(pieces.breakpoints):
        if pieces(a) != pieces((a + b) / 2):
            jumps += [a, b]
    return jumps


def measuring_windows(
    end: float,
    broken: float | None,
    fall: ScheduledFall | None,
    is_gradual: bool,
    after: float | None,
    learning: float | None,
) -> Windows:
    """Return the windows in which the speed is measured, in a run so far.

    end: of it. broken: time at which the damage had reached 1. fall: by a schedule; None where the stiffness falls with the
    damage, and is_gradual if it does so from the beginning. after: time from which the speed before the failure is measured, by
    default half of that time. learning: for how long, by default until the fall begins.
    """
    if fall is not None:
        begin, fall_end = fall.begin, fall.end
        failure_time = chart_begin = begin if end > begin else None
    else:
        learnt = (after or 0.0) + (learning or 0.0)
        # A gradual fall may drive the exciter out of its resonance, which ends the damage: it is detected in any case.
        fall_end = broken if broken is not None else learnt if is_gradual else end
        begin, failure_time, chart_begin = (learnt, broken, learnt) if is_gradual else (fall_end, broken, broken)
    after = begin / 2 if after is None else after
    until = begin if learning is None else after + learning
    until = min(until, begin, end)
    earlier_window = (after, until) if until > after else None
    later_window = ((fall_end + end) / 2, end) if chart_begin is not None and end > fall_end else None
    return Windows(earlier_window, later_window, chart_begin, failure_time)


def averaged_speed_of(
    failing: FailingMachine, run: FailingRun, readings: Readings, is_after: bool, tolerance: float, engine: str | None
) -> AveragedSpeed:
    """Return the speed by the averaged equations, before the failure of a run or after it."""
    windows, machine = readings.windows, failing.machine
    if is_after:
        verdict, mean, window, used_readings = run.verdict, readings.after, windows.abnormal, readings.abnormal
    else:
        verdict, mean, window, used_readings = (
            run.verdict_before or run.verdict, readings.before, windows.normal, readings.normal,
        )  # fmt: skip
    assert mean is not None
    assert window is not None
    if is_after and (falling := failing.falling) is not None:
        machine = machine.with_unchecked_values({falling.parameter: falling.value * float(run.course.stiffness[-1])})
    steady = machine.at(window[1] if is_after else window[0]).with_fields(schedules=())
    # The averaged equations continue from the full motion, and settle before the mean is taken.
    leg = run.state.last if is_after else run.state.onset or run.state.last
    start, part = leg.trajectory.end_state[: len(failing.initial)], window[1] - window[0]
    spread = float(np.ptp(readings.speed[used_readings]))
    beats = verdict.outcome in _BEATING_OUTCOMES or spread > _STEADY_TOLERANCE * abs(mean)
    return averaged_speed(steady, mean, beats, start, (_SETTLE * part, part), tolerance, engine)
