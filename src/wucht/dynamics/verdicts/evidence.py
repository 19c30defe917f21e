"""From the turns of a rotor to the evidence for its outcome."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.analysis.vibration import Vibration, moments_along_guides, unbalances
from wucht.dynamics.verdicts.lags import Lag, lag_of, undecided, windows_until_apart
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import LAG_TOLERANCE, MODULATION_THRESHOLD, SPEED_TOLERANCE, UNBALANCE_TOLERANCE, Evidence
from wucht.dynamics.verdicts.swings import COASTS, windows_to_rest
from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody
from wucht.numerics.angles import wrapped
from wucht.numerics.observers.modulation import Modulation, modulation
from wucht.numerics.observers.projection import (
    AHEAD,
    LOOKAHEAD,
    SHARE,
    WINDOWS,
    Course,
    Projection,
    falling,
    projected,
    projected_each,
    trend,
    windows_of,
)
from wucht.numerics.observers.records import Blocks, TurnRecord

UNREST = 0.1  # of the residual unbalance: bodies are at rest that change it by less
_LAST_SHARE = 0.05
_CYCLES_ROUNDING = 1e-3  # of a modulation's range: the extremes of sampled cycles are not known better
_IN_NOISE = 6.0  # times the noise: bounds that are no further apart are not known better, as far as noise widens them
_LONGEST_BEFORE = 2.0  # times the turns since the rotor last turned back: the run, of which they are to be the larger part
_FEWEST_IRREGULAR = 30  # cycles: fewer that are not alike may be a long transient
_FEWEST_UNEVEN = 10  # cycles that take the same time: fewer, if their ranges differ, may decay unnoticed
_TENTHS, _TENTHS_IRREGULAR = 20.0, 2.0  # cycles in a tenth of the record: more need not be whole ones
WAVERS = "the motion fluctuates about the border between outcomes, and the fluctuation does not visibly decay"
IN_NOISE = "the outcome depends on differences within the noise of the integration (use a smaller tolerance)"
_LASTING, _FADING = 0.15, 0.02  # of its range: a modulation lasts whose range will change, or fall, by no more


@dataclass(frozen=True)
class Standing:
    """Assessment of a rotor's motion.

    evidence: for its outcome. window: the last turns, whole ones, or whole periods of a modulation. speed: its mean
    speed there, positive in its sense of rotation. residual: the largest share of its unbalance that is left there, None
    without unbalance. phases: of the bodies about it, circular means over the last turn. final_phases: the same as sigma alpha,
    with that of the rotor, 0 where a body lags. vibration: that they excite. projections: of mean speed and residual. growing:
    a modulation grows, or bodies leave their places. drifting: the lag of a body drifts. unrest: the range of the residual, as
    a share of it. extra_run_factor: the further run needed for a verdict, as a multiple of the length of the record; inf if
    unknown. undecidable_reason: the reason why no longer run would decide; else empty.
    """

    evidence: Evidence[float]
    sense: int
    window: Blocks
    speed: float
    residual: float | None
    phases: dict[str, float]
    final_phases: np.ndarray
    vibration: Vibration
    modulation: Modulation | None
    projections: tuple[Projection, ...]
    growing: bool
    drifting: bool
    unrest: float
    needed: float
    endless: str


@dataclass(frozen=True)
class _Projections:
    """Projections of the numbers that the criteria need. speed_range: of the speed, as a share of it. lags: of the bodies about
    the rotor. residual: of the unbalance, None if nothing could compensate it. divergence: see ``windows_until_divergence``.
    beats: cycles of a modulation are observed."""

    mean: Projection
    lowest: Projection
    varied: Projection
    lags: tuple[Lag, ...]
    left: Projection | None
    parted: float
    beats: bool

    @property
    def asynchronous(self) -> bool:
        """True if a body lags permanently."""
        return any(lag.low > LAG_TOLERANCE or lag.high < -LAG_TOLERANCE for lag in self.lags)

    @property
    def catching_up(self) -> bool:
        """True if a body lags that may catch up, so that the rotor's motion then changes."""
        return not self.asynchronous and any(undecided(lag) for lag in self.lags)

    @property
    def drifting(self) -> bool:
        """True if the lag of a body falls or grows without an end in sight."""
        return any(undecided(lag) and lag.course is Course.DRIFTING for lag in self.lags)

    @property
    def growing(self) -> bool:
        """True if a modulation grows, or bodies leave their places: the outcome is not known."""
        modulated = self.varied.course is Course.DRIFTING and self.varied.high > max(2 * self.varied.last, MODULATION_THRESHOLD)
        left = self.left
        leaving = left is not None and left.course is Course.DRIFTING and left.high > max(2 * left.last, UNBALANCE_TOLERANCE)
        return modulated or leaving or self.parted < math.inf or any(lag.growing for lag in self.lags)


def standing(
    machine: Machine, rotor: RotatingBody, record: TurnRecord, free: float | None, end: float, noise: Noise
) -> Standing:
    """Assess a rotor that has made some turns. free: the speed of its drive without vibration. end, noise: of the run."""
    bodies = machine.group(rotor)
    index, others = [machine.bodies.index(b) for b in bodies], [b for b in machine.bodies if b is not rotor]
    about, whole, sense = [others.index(b) for b in bodies[1:]], record.whole, record.sense
    moments, vibration = (unbalances(machine), moments_along_guides(machine)), Vibration.of(machine).only(index)
    unbalanced = any(bool(m[index].any()) for m in moments)
    expected = None if free is None else sense * free
    observed = modulation(record, MODULATION_THRESHOLD * float(record.last(SHARE).speed.mean()))
    series = _series(whole, observed)
    longer = max(1.0, end / max(float(whole.time[-1] - whole.time[0]), 1e-300))  # the run, as a multiple of its turns
    reference = abs(expected or float(series.means[-1]))
    balancing = unbalanced and bool(about) and len(vibration.mass) > 0  # else nothing moves the bodies to compensating phases
    p = _projections(whole, series, longer, reference, observed, about, noise, balancing=balancing)
    last = record.whole_turns(max(_LAST_SHARE, 2 / record.turns))
    phases = {b.name: float(wrapped(np.angle(x))) for b, x in zip(bodies[1:], last.phases[about, -1], strict=True)}
    final = np.array([0.0, *(0.0 if p.asynchronous else sense * phase for phase in phases.values())])
    # The residual of a compensated unbalance is rounding: its torque has the shape of the rotor's.
    compensated = p.left is not None and p.left.last <= noise.angle
    alone = Vibration.of(machine).only(index[:1]) if compensated else vibration
    resonance = alone.last_maximum(expected, final[:1] if compensated else final)
    lasting = _lasting(p.varied, observed)
    lasts = lasting[0] > MODULATION_THRESHOLD or lasting[1] <= MODULATION_THRESHOLD
    near = resonance is not None and p.lowest.low - resonance < 2 * float(series.highs[-1] - series.lows[-1])
    resting = p.mean.course is Course.STATIONARY and trend(series.means) == 0
    approached = resting or p.mean.width <= SPEED_TOLERANCE * reference
    residual = None if not unbalanced else _now(last) if p.left is None else p.left.bounds
    evidence = Evidence(
        turning=True,
        mean_speed=p.mean.bounds,
        lowest_speed=p.lowest.bounds,
        settled=approached and not p.growing and not p.catching_up and (lasts or not near) and longer <= _LONGEST_BEFORE,
        free_speed=expected,
        resonance=resonance,
        residual=residual,
        lags=tuple(lag.bounds for lag in p.lags),
        modulation=lasting,
    )
    waits = _waits(p, evidence, reference, whole, series)
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
        (p.mean,) if p.left is None else (p.mean, p.left),
        p.growing,
        p.drifting,
        0.0 if p.left is None else _unrest(whole.last(WINDOWS * SHARE)),
        _needed(waits, p.varied, None if evidence.modulated else observed, series.ahead, end),
        _endless(p, evidence, waits, noise, reference),
    )


def _projections(
    whole: Blocks,
    series: _Series,
    longer: float,
    reference: float,
    observed: Modulation | None,
    about: Sequence[int],
    noise: Noise,
    *,
    balancing: bool,
) -> _Projections:
    """Project the numbers of a record. longer: times the record, the run. about: rows of the bodies about the rotor."""
    ahead, rounding = series.ahead * longer, max(series.rounding, noise.speed * reference)
    speeds = projected_each(np.column_stack([series.means, series.lows]), ahead, rounding)
    mean, lowest = speeds.one(0), speeds.one(1)
    last = float(series.means[-1])
    varied = _of_positive(falling((series.highs - series.lows) / series.means, ahead, rounding / last))
    borders = observed.borders if observed is not None and _by_cycles(whole, observed) else None
    lags = tuple(lag_of(whole, i, last, ahead, borders, noise) for i in about)
    apart = math.inf if borders is None else windows_until_apart(whole, about, borders, noise)
    parted = apart if apart < ahead else math.inf
    return _Projections(
        mean, lowest, varied, lags, _left(whole, AHEAD * longer, noise) if balancing else None, parted, observed is not None
    )


def _endless(p: _Projections, e: Evidence[float], waits: list[float], noise: Noise, reference: float) -> str:
    """Return the reason why no longer run would decide; empty if one may."""
    if e.free_speed == 0 and not e.settled and waits == [math.inf] and p.mean.low < p.mean.last:
        return COASTS
    if p.growing:
        return ""
    open_ = _open_numbers(p, e, noise, reference)
    if open_ and all(x.width <= _IN_NOISE * size for x, size in open_):
        return IN_NOISE
    known = math.inf not in waits or any(x.course is not Course.STATIONARY for x, _ in open_)
    return "" if known else WAVERS


def _open_numbers(p: _Projections, e: Evidence[float], noise: Noise, reference: float) -> list[tuple[Projection, float]]:
    """Return the numbers that leave the outcome of the rotor open, each with its noise. reference: a speed."""
    of_speed = noise.speed * reference
    numbers = [] if e.settled and e.at_speed.known else [(p.mean, of_speed), (p.lowest, of_speed)]
    numbers += [] if p.left is None or e.balanced.known else [(p.left, noise.angle)]
    numbers += [] if e.beyond.known else [(p.lowest, of_speed)]
    numbers += [] if e.modulated.known else [(p.varied, noise.speed)]
    return numbers + [(lag, noise.speed) for lag in p.lags if undecided(lag)]


def _waits(p: _Projections, e: Evidence[float], reference: float, whole: Blocks, series: _Series) -> list[float]:
    """Return the windows until each open number will be known."""
    beats = p.beats and p.varied.last > MODULATION_THRESHOLD and p.mean.course is not Course.DRIFTING
    dies_out = beats and p.varied.course is Course.APPROACHING
    even = p.varied.windows_until(1e-3) if dies_out else math.inf  # mean and lowest speed settle with it
    if e.free_speed == 0 and not e.settled:  # it coasts: nothing else is open
        return [windows_to_rest(whole, series.means)]
    waits = [] if e.settled else [min(p.mean.windows_until(0.5 * SPEED_TOLERANCE * reference), even)]
    waits += [] if p.left is None or e.balanced.known else [p.left.windows_until(0.5 * UNBALANCE_TOLERANCE)]
    waits += [] if e.beyond.known else [min(p.lowest.windows_until(1e-3 * reference), even)]
    waits += [] if e.modulated.known else [p.varied.windows_until(0.5 * MODULATION_THRESHOLD)]
    if p.parted < math.inf:
        return [p.parted]
    waits += [p.varied.windows * math.log(1 / p.varied.last)] if p.growing and 0 < p.varied.last < 1 else []
    return waits + [lag.windows for lag in p.lags if not e.asynchronous.known and undecided(lag)]


def unrest(least: Any, greatest: Any) -> np.ndarray:
    """Return the range of a residual unbalance, as a share of its largest value; 0 if it is compensated.

    least, greatest: of the last half, as shares of the unbalance, of each motion.
    """
    return np.where(greatest > UNBALANCE_TOLERANCE, 1 - least / np.maximum(greatest, UNBALANCE_TOLERANCE), 0.0)


def _unrest(half: Blocks) -> float:
    """The unrest of a rotor in its last half."""
    return float(unrest(half.least_sum.min(), half.greatest_sum.max()))


def _now(last: Blocks) -> tuple[float, float]:
    """The bounds of the residual unbalance in the last turns."""
    return float(last.least_sum.min()), float(last.greatest_sum.max())


def _lasting(varied: Projection, observed: Modulation | None) -> tuple[float, float]:
    """Return the bounds between which the range of a modulation will stay. It lasts if its cycles, even or many, hardly change
    their range any more; else it may die out."""
    if varied.high <= MODULATION_THRESHOLD:
        return varied.bounds
    if observed is None:
        return 0.0, math.inf
    few = observed.cycles < _FEWEST_UNEVEN
    fades = few or (varied.course is Course.APPROACHING and varied.low < varied.last)
    even = varied.width <= (_FADING if fades else _LASTING) * varied.last
    if observed.regular:
        lasts = even or varied.course is Course.DRIFTING
    else:
        lasts = observed.cycles >= _FEWEST_IRREGULAR and (even or varied.course is not Course.APPROACHING)
    return varied.bounds if lasts else (0.0, varied.high)


def _needed(waits: list[float], varied: Projection, observed: Modulation | None, ahead: float, end: float) -> float:
    """Return the further run, as a multiple of the record's length, for so many windows; or for more cycles of a modulation
    that may not last, which are counted in the last half."""
    if observed is not None and observed.regular and observed.cycles < _FEWEST_UNEVEN and varied.course is Course.STATIONARY:
        return max(0.0, 2 * _FEWEST_UNEVEN * observed.period / end - 1)
    return max(waits, default=0.0) * LOOKAHEAD / ahead


@dataclass(frozen=True)
class _Series:
    """Mean, least and greatest speed (w,) in successive windows, the number of windows to look ahead, and their rounding."""

    means: np.ndarray
    lows: np.ndarray
    highs: np.ndarray
    ahead: float
    rounding: float


def _series(whole: Blocks, observed: Modulation | None) -> _Series:
    """Return the series over tenths of the record; with a slower modulation, over groups of its cycles."""
    duration = float(whole.time[-1] - whole.time[0])
    if observed is not None and _by_cycles(whole, observed):
        rounding = _CYCLES_ROUNDING * (observed.high - observed.low)
        means, lows, highs = observed.groups
        return _Series(means, lows, highs, LOOKAHEAD * duration / observed.span, rounding)
    means = 1 / windows_of(1 / whole.speed).mean(axis=1)
    lows, highs = windows_of(whole.lowest).min(axis=1), windows_of(whole.highest).max(axis=1)
    return _Series(means, lows, highs, AHEAD, _CYCLES_ROUNDING * float(highs[-1] - lows[-1]))


def _left(whole: Blocks, ahead: float, noise: Noise) -> Projection:
    """Project the residual unbalance: while bodies still move and it falls, it may fall to zero; one that has begun to rise
    may continue to do so."""
    moving, sizes = _unrest(whole.last(WINDOWS * SHARE)) > UNREST, windows_of(whole.greatest_sum).max(axis=1)
    p = falling(sizes, ahead, noise.angle, even_if_approaching=moving)
    later = projected(sizes[1:], ahead, noise.angle)
    begins_to_rise = p.course is Course.STATIONARY and later.course is Course.DRIFTING and later.high > p.high
    if begins_to_rise:
        return _of_positive(replace(later, low=p.low))
    low, high = noise.widened(np.array(p.bounds)).tolist() if p.course is Course.STATIONARY else p.bounds
    return _of_positive(replace(p, low=low, high=high))


def _of_positive(p: Projection) -> Projection:
    """Clip the projection of a number that cannot be less than zero."""
    return replace(p, low=max(p.low, 0.0))


def _by_cycles(whole: Blocks, observed: Modulation) -> bool:
    """True if a modulation is so slow that means are to be taken over whole cycles of it."""
    duration, most = float(whole.time[-1] - whole.time[0]), _TENTHS if observed.regular else _TENTHS_IRREGULAR
    return most * observed.period > SHARE * duration
