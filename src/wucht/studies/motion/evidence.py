"""From the turns of a rotor to the evidence of what becomes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.vibration import Vibration, unbalances
from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody
from wucht.numerics.observers.modulation import Modulation, modulation
from wucht.numerics.observers.projection import AHEAD, LOOKAHEAD, SHARE, Course, Projection, projected, windows_of
from wucht.numerics.observers.turn_record import Blocks, TurnRecord
from wucht.numerics.observers.turns import PER_TURN
from wucht.results.conventions import wrapped
from wucht.results.outcomes import LAG_TOLERANCE, MODULATION_THRESHOLD, SPEED_TOLERANCE, UNBALANCE_TOLERANCE, Evidence

_LAST_SHARE = 0.05
_ROUNDING = 1e-10  # of the speed
_CYCLES_ROUNDING = 1e-3  # of a modulation's range: the extremes of sampled cycles are not known better
_LONGEST_BEFORE = 2.0  # times the turns since the rotor last turned back: the run, of which they are to be the larger part
_FEWEST_IRREGULAR = 50  # cycles: fewer that are not alike may be the long way to another end
_AT_REST = 1e-3  # rad: a phase that moves less from window to window is at rest
_TENTHS, _TENTHS_IRREGULAR = 20.0, 2.0  # cycles in a tenth of the record: more need not be whole ones
_LIBRATION = math.pi / 2  # rad: a body that swings by less about where it rests on the rotor keeps doing so
_WIDER = 1.5  # times the range of the lag seen: it may go beyond that by as much
_CATCHING_UP = 0.25  # of the lag: a drift that takes away less, as far as it is looked ahead, does not count
_LASTING = 0.15  # of its range: a modulation lasts that is going to change by no more


@dataclass(frozen=True)
class Standing:
    """Where a rotor stands.

    evidence: of what becomes of it. window: the last turns, whole ones, or whole periods of a modulation. speed: its mean
    speed there, with the sense of turning taken away. residual: the largest share of its
    unbalance that is left there, None without unbalance. phases: of the bodies about it, circular means over the last turn.
    final_phases: the same as sigma alpha, with that of the rotor, 0 where a body lags. vibration: what they excite.
    projections: of the mean speed and of the residual. needed: for how many more times the length of the record it must be
    watched; inf where nothing says so.
    """

    evidence: Evidence
    sense: int
    window: Blocks
    speed: float
    residual: float | None
    phases: dict[str, float]
    final_phases: np.ndarray
    vibration: Vibration
    modulation: Modulation | None
    projections: tuple[Projection, ...]
    needed: float


def standing(machine: Machine, rotor: RotatingBody, record: TurnRecord, free: float | None, end: float) -> Standing:
    """Where a rotor stands that has made some turns. free: what its drive reaches without vibration. end: of the run."""
    bodies = machine.group(rotor)
    index, others = [machine.bodies.index(b) for b in bodies], [b for b in machine.bodies if b is not rotor]
    about, whole, sense = [others.index(b) for b in bodies[1:]], record.whole, record.sense
    unbalanced, vibration = bool(unbalances(machine)[index].any()), Vibration.of(machine).only(index)
    expected = None if free is None else sense * free
    observed = modulation(record, MODULATION_THRESHOLD * float(record.last(SHARE).speed.mean()))
    means, lows, highs, each, rounding = _series(whole, observed)
    longer = max(1.0, end / max(float(whole.time[-1] - whole.time[0]), 1e-300))  # than its turns the run has lasted
    ahead = each * longer
    reference = expected or float(means[-1])
    mean, lowest = (projected(x, ahead, max(rounding, _ROUNDING * abs(reference))) for x in (means, lows))
    varied = projected((highs - lows) / means, ahead, max(rounding / abs(means[-1]), _ROUNDING))
    lags = tuple(_lag(whole, i, means[-1], ahead, observed) for i in about)
    left = projected(windows_of(whole.greatest_sum).max(axis=1), AHEAD * longer, _ROUNDING) if unbalanced and about else None
    asynchronous = any(lag.low > LAG_TOLERANCE or lag.high < -LAG_TOLERANCE for lag in lags)
    last = record.whole_turns(max(_LAST_SHARE, 2 / record.turns))
    phases = {b.name: float(wrapped(np.angle(p))) for b, p in zip(bodies[1:], last.phases[about, -1], strict=True)}
    final = np.array([0.0, *(0.0 if asynchronous else sense * phase for phase in phases.values())])
    growing = varied.course is Course.DRIFTING and varied.high > max(2 * varied.last, MODULATION_THRESHOLD)
    resonance = None if expected == 0 else vibration.last_maximum(expected, final)
    lasting = _lasting(varied, observed)
    lasts, ripple = lasting[0] > MODULATION_THRESHOLD or lasting[1] <= MODULATION_THRESHOLD, float(highs[-1] - lows[-1])
    near = resonance is not None and lowest.low - resonance < 2 * ripple
    catching_up = not asynchronous and any(_undecided(lag) for lag in lags)
    if left is None:
        residual = (1.0, 1.0) if unbalanced else None
    else:  # without vibration nothing turns the bodies to where they compensate
        residual = left.bounds if len(vibration.mass) else (left.last, left.last)
    approached = mean.course is Course.STATIONARY or mean.width <= SPEED_TOLERANCE * abs(reference)
    evidence = Evidence(
        turning=True,
        mean_speed=mean.bounds,
        lowest_speed=lowest.bounds,
        settled=approached and not growing and not catching_up and (lasts or not near) and longer <= _LONGEST_BEFORE,
        free_speed=expected,
        resonance=resonance,
        residual=residual,
        lags=tuple(lag.bounds for lag in lags),
        modulation=lasting,
    )
    waits = [
        *([] if evidence.settled else [mean.windows_until(0.5 * SPEED_TOLERANCE * abs(reference))]),
        *([] if left is None or evidence.balanced is not None else [left.windows_until(0.5 * UNBALANCE_TOLERANCE)]),
        *(
            []
            if evidence.asynchronous is not None
            else [lag.windows * math.log(max(lag.width / LAG_TOLERANCE, 1.0)) for lag in lags if _undecided(lag)]
        ),
        *([] if evidence.beyond is not None else [lowest.windows_until(1e-3 * abs(reference))]),
        *([] if evidence.modulated is not None else [varied.windows_until(0.5 * MODULATION_THRESHOLD)]),
    ]
    window = observed.window if evidence.modulated and observed is not None else last
    return Standing(
        evidence,
        sense,
        window,
        float(window.mean_speeds[0]),
        float(window.greatest_sum.max()) if unbalanced else None,
        phases,
        final,
        vibration,
        observed if evidence.modulated else None,
        (mean,) if left is None else (mean, left),
        _needed(waits, observed, each, end),
    )


def _undecided(lag: Projection) -> bool:
    """Whether it cannot be told if a body lags."""
    return (lag.low < -LAG_TOLERANCE <= lag.high) or (lag.low <= LAG_TOLERANCE < lag.high)


def _lasting(varied: Projection, observed: Modulation | None) -> tuple[float, float]:
    """Between which bounds the range of a modulation will stay. It lasts if it is seen to: in cycles, even ones or many, whose
    range hardly changes any more; else it may die out."""
    if varied.high <= MODULATION_THRESHOLD:
        return varied.bounds
    if observed is None:
        return 0.0, math.inf
    even = varied.width <= _LASTING * varied.last
    if observed.regular:
        lasts = even or varied.course is Course.DRIFTING
    else:
        lasts = observed.cycles >= _FEWEST_IRREGULAR and (even or varied.course is not Course.APPROACHING)
    return varied.bounds if lasts else (0.0, varied.high)


def _needed(waits: list[float], observed: Modulation | None, ahead: float, end: float) -> float:
    """For how many more times the length of the record it must be watched, if it needs so many windows."""
    if observed is not None and not observed.regular and observed.cycles < _FEWEST_IRREGULAR:
        return 2 * _FEWEST_IRREGULAR * observed.period / end
    return max(waits, default=0.0) * LOOKAHEAD / ahead


def _series(whole: Blocks, observed: Modulation | None) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, float]:
    """Mean, least and greatest speed (w,) in successive windows, how many of these are looked ahead, and their rounding.

    The windows are tenths of the record; where a modulation is slower than that, groups of its cycles.
    """
    duration = float(whole.time[-1] - whole.time[0])
    if observed is not None and _by_cycles(whole, observed):
        means, lows, highs = observed.groups
        return means, lows, highs, LOOKAHEAD * duration / observed.span, _CYCLES_ROUNDING * (observed.high - observed.low)
    means = 1 / windows_of(1 / whole.speed).mean(axis=1)
    lows, highs = windows_of(whole.lowest).min(axis=1), windows_of(whole.highest).max(axis=1)
    return means, lows, highs, AHEAD, _CYCLES_ROUNDING * float(highs[-1] - lows[-1])


def _by_cycles(whole: Blocks, observed: Modulation) -> bool:
    """Whether a modulation is so slow that means are to be taken over whole cycles of it."""
    duration, most = float(whole.time[-1] - whole.time[0]), _TENTHS if observed.regular else _TENTHS_IRREGULAR
    return most * observed.period > SHARE * duration


def _lag(whole: Blocks, i: int, speed: float, ahead: float, observed: Modulation | None) -> Projection:
    """By how much a body will lag, as a share of the speed: not as long as it goes to and fro within a turn."""
    lag, durations = whole.followers[i] - whole.speed, 1 / whole.speed
    slip = np.cumsum(lag * durations) * (2 * math.pi * whole.size / PER_TURN)
    moving = projected(windows_of(slip).mean(axis=1), ahead, _AT_REST)
    if np.ptp(slip[len(slip) // 2 :]) < _LIBRATION and moving.width < 2 * math.pi:
        return Projection(0.0, 0.0, 0.0, Course.STATIONARY)
    if observed is not None and _by_cycles(whole, observed):
        means = np.diff(np.interp(observed.borders, whole.time, slip)) / np.diff(observed.borders) / speed
    else:
        means = windows_of(lag * durations).sum(axis=1) / windows_of(durations).sum(axis=1) / speed
    p = projected(means, ahead, _ROUNDING, _WIDER)
    if abs(p.last) <= LAG_TOLERANCE:
        return p
    p = replace(p, low=min(p.low, float(means.min())), high=max(p.high, float(means.max())))
    # One that catches up, however slowly, will have done so; and one that has slipped by less than a turn may do so.
    change = abs(float(means[-1] - means[-2])) * ahead
    catching_up = p.course is Course.DRIFTING and (p.high > p.last) == (p.last < 0) and change > _CATCHING_UP * abs(p.last)
    late = slip[-max(2, len(slip) // 5) :]
    if catching_up:
        p = replace(p, windows=abs(p.last) * ahead / change)
    return replace(p, low=min(p.low, 0.0), high=max(p.high, 0.0)) if catching_up or np.ptp(late) < 2 * math.pi else p
