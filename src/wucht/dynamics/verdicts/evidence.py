"""From the turns of a rotor to the evidence for its outcome."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.analysis.vibration import Vibration, moments_along_guides, unbalances
from wucht.dynamics.verdicts.lags import Lag, is_undecided, lag_of, windows_until_divergence
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import LAG_TOLERANCE, MODULATION_THRESHOLD, SPEED_TOLERANCE, UNBALANCE_TOLERANCE, Evidence
from wucht.dynamics.verdicts.swings import REASON_COASTING, windows_to_rest
from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody
from wucht.numerics.angles import wrap_angle
from wucht.numerics.observers.modulation import Modulation, modulation
from wucht.numerics.observers.projection import (
    AHEAD,
    LOOKAHEAD,
    SHARE,
    WINDOWS,
    Course,
    Projection,
    falling_projection,
    project,
    project_signals,
    scattering_projection,
    scatters,
    trend,
    windows_of,
)
from wucht.numerics.observers.records import Blocks, TurnRecord

UNREST = 0.1  # of the residual unbalance: bodies are at rest that change it by less
_CYCLES_ROUNDING = 1e-3  # of a modulation's range: the extremes of sampled cycles are not known better
_NOISE_RANGE = 6.0  # times the noise: bounds that are no further apart are not known better, as far as noise widens them
_LONGEST_BEFORE = 2.0  # times the turns since the rotor last turned back: the run, of which they are to be the larger part
_FEWEST_IRREGULAR = 30  # cycles: fewer that are not alike may be a long transient
_FEWEST_UNEVEN = 10  # cycles that take the same time: fewer, if their ranges differ, may decay unnoticed
_TENTHS, _TENTHS_IRREGULAR = 20.0, 2.0  # cycles in a tenth of the record: more need not be whole ones
REASON_WAVERING = "the motion fluctuates about the border between outcomes, and the fluctuation does not visibly decay"
REASON_IN_NOISE = "the outcome depends on differences within the noise of the integration (use a smaller tolerance)"
_LASTING, _FADING = 0.15, 0.02  # of its range: a modulation lasts whose range will change, or fall, by no more


@dataclass(frozen=True)
class RotorAssessment:
    """Assessment of a rotor's motion.

    evidence: for its outcome. window: the last turns, whole ones, or whole periods of a modulation. speed: its mean
    speed there, positive in its sense of rotation. residual: the largest share of its unbalance that is left there, None
    without unbalance. unbalance_factor: by which the bodies increase the rotor's unbalance there, None where they do not.
    phases: of the bodies about it, circular means over the last turn. final_phases: the same as sigma alpha,
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
    unbalance_factor: float | None
    phases: dict[str, float]
    final_phases: np.ndarray
    vibration: Vibration
    modulation: Modulation | None
    projections: tuple[Projection, ...]
    growing: bool
    drifting: bool
    unrest: float
    extra_run_factor: float
    undecidable_reason: str


@dataclass(frozen=True)
class _Projections:
    """Projections of the numbers that the criteria need, from windows: tenths of the record, or groups of cycles.

    reference: speed of which tolerances are shares. means (w,): mean speeds in the windows; last_range: of the speed in the
    last one. ahead: number of windows to look ahead. speed_range: of the speed, as a share of it. lags: of the bodies about the
    rotor. residual: of the unbalance, None if nothing could compensate it. divergence: see ``windows_until_divergence``. beats:
    cycles of a modulation are observed.
    """

    reference: float
    means: np.ndarray
    last_range: float
    ahead: float
    mean: Projection
    lowest: Projection
    speed_range: Projection
    lags: tuple[Lag, ...]
    residual: Projection | None
    divergence: float
    beats: bool

    @property
    def asynchronous(self) -> bool:
        """True if a body lags permanently."""
        return any(lag.low > LAG_TOLERANCE or lag.high < -LAG_TOLERANCE for lag in self.lags)

    @property
    def catching_up(self) -> bool:
        """True if a body lags that may catch up, so that the rotor's motion then changes."""
        return not self.asynchronous and any(is_undecided(lag) for lag in self.lags)

    @property
    def drifting(self) -> bool:
        """True if the lag of a body falls or grows without an end in sight."""
        return any(is_undecided(lag) and lag.course is Course.DRIFTING for lag in self.lags)

    @property
    def growing(self) -> bool:
        """True if a modulation grows, or bodies leave their places: the outcome is not known."""
        modulation_grows = self.speed_range.course is Course.DRIFTING and self.speed_range.high > max(
            2 * self.speed_range.last, MODULATION_THRESHOLD
        )
        residual = self.residual
        leaving = (
            residual is not None
            and residual.course is Course.DRIFTING
            and residual.high > max(2 * residual.last, UNBALANCE_TOLERANCE)
        )
        return modulation_grows or leaving or self.divergence < math.inf or any(lag.growing for lag in self.lags)


def assess_rotor(
    machine: Machine, rotor: RotatingBody, record: TurnRecord, free: float | None, end: float, noise: Noise
) -> RotorAssessment:
    """Assess a rotor that has made some turns. free: the speed of its drive without vibration. end, noise: of the run."""
    bodies = machine.group(rotor)
    index, other_bodies = [machine.bodies.index(b) for b in bodies], [b for b in machine.bodies if b is not rotor]
    about, whole, sense = [other_bodies.index(b) for b in bodies[1:]], record.whole, record.sense
    moments, vibration = (unbalances(machine), moments_along_guides(machine)), Vibration.of(machine).select_bodies(index)
    has_unbalance = any(bool(m[index].any()) for m in moments)
    target_speed = None if free is None else sense * free
    observed_modulation = modulation(record, MODULATION_THRESHOLD * float(record.last(SHARE).speed.mean()))
    longer = max(1.0, end / max(float(whole.time[-1] - whole.time[0]), 1e-300))  # the run, as a multiple of its turns
    # Else nothing moves the bodies to compensating phases.
    balancing = has_unbalance and bool(about) and len(vibration.mass) > 0
    p = _projections(whole, longer, target_speed, observed_modulation, about, noise, balancing=balancing)
    last = record.final_turns()
    phases = {b.name: float(wrap_angle(np.angle(x))) for b, x in zip(bodies[1:], last.phases[about, -1], strict=True)}
    final = np.array([0.0, *(0.0 if p.asynchronous else sense * phase for phase in phases.values())])
    # The residual of a compensated unbalance is rounding: its torque has the shape of the rotor's.
    is_compensated = p.residual is not None and p.residual.last <= noise.angle
    excitation = Vibration.of(machine).select_bodies(index[:1]) if is_compensated else vibration
    resonance = excitation.last_maximum(target_speed, final[:1] if is_compensated else final)
    lasting = _lasting(p.speed_range, observed_modulation)
    lasts = lasting[0] > MODULATION_THRESHOLD or lasting[1] <= MODULATION_THRESHOLD
    near = resonance is not None and p.lowest.low - resonance < 2 * p.last_range
    resting = p.mean.course is Course.STATIONARY and trend(p.means) == 0
    is_steady = resting or p.mean.width <= SPEED_TOLERANCE * p.reference
    residual = (float(last.least_sum.min()), float(last.greatest_sum.max())) if has_unbalance else None
    if residual is not None and p.residual is not None:
        residual = p.residual.bounds
    evidence = Evidence(
        turning=True,
        mean_speed=p.mean.bounds,
        lowest_speed=p.lowest.bounds,
        has_settled=is_steady and not p.growing and not p.catching_up and (lasts or not near) and longer <= _LONGEST_BEFORE,
        free_speed=target_speed,
        resonance=resonance,
        residual=residual,
        lags=tuple(lag.bounds for lag in p.lags),
        modulation=lasting,
    )
    waits = _waits(p, evidence, whole)
    window = observed_modulation.window if evidence.is_modulated and observed_modulation is not None else last
    return RotorAssessment(
        evidence,
        sense,
        window,
        float(window.mean_speeds[0]),
        float(window.greatest_sum.max()) if has_unbalance else None,
        float(window.greatest_sum.max()) if moments[0][index[0]] and window.least_sum.min() > 1 + UNBALANCE_TOLERANCE else None,
        phases,
        final,
        vibration,
        observed_modulation if evidence.is_modulated else None,
        (p.mean,) if p.residual is None else (p.mean, p.residual),
        p.growing,
        p.drifting,
        0.0 if p.residual is None else _unrest(whole.last(WINDOWS * SHARE)),
        _extra_run_factor(waits, p.speed_range, None if evidence.is_modulated else observed_modulation, p.ahead, end),
        _undecidable_reason(p, evidence, waits, noise),
    )


def _projections(
    whole: Blocks,
    longer: float,
    target_speed: float | None,
    observed_modulation: Modulation | None,
    about: Sequence[int],
    noise: Noise,
    *,
    balancing: bool,
) -> _Projections:
    """Project the numbers of a record over tenths of it; with a slower modulation, over groups of its cycles.

    longer: times the record, the run. target_speed: of the drive without vibration. about: rows of the bodies about the rotor.
    """
    if observed_modulation is not None and _needs_cycles(whole, observed_modulation):
        means, lows, highs = observed_modulation.groups
        windows_ahead, borders = _groups_ahead(whole, observed_modulation), observed_modulation.borders
        rounding = _CYCLES_ROUNDING * (observed_modulation.high - observed_modulation.low)
    else:
        means, windows_ahead, borders = 1 / windows_of(1 / whole.speed).mean(axis=1), AHEAD, None
        lows, highs = windows_of(whole.lowest).min(axis=1), windows_of(whole.highest).max(axis=1)
        rounding = _CYCLES_ROUNDING * float(highs[-1] - lows[-1])
    last = float(means[-1])
    reference, ahead = abs(target_speed or last), windows_ahead * longer
    rounding = max(rounding, noise.speed * reference)
    speeds = project_signals(np.column_stack([means, lows]), ahead, rounding)
    return _Projections(
        reference,
        means,
        float(highs[-1] - lows[-1]),
        windows_ahead,
        mean=speeds.one(0),
        lowest=speeds.one(1),
        speed_range=_without_negative(falling_projection((highs - lows) / means, ahead, rounding / last)),
        lags=tuple(lag_of(whole, i, last, ahead, borders, noise) for i in about),
        residual=_residual_projection(whole, AHEAD * longer, noise) if balancing else None,
        divergence=_divergence(whole, about, observed_modulation, noise, longer) * ahead,
        beats=observed_modulation is not None,
    )


def _divergence(
    whole: Blocks, about: Sequence[int], observed_modulation: Modulation | None, noise: Noise, longer: float
) -> float:
    """Return the share of the time ahead after which bodies that are modulated together have diverged; inf if they do not."""
    if observed_modulation is None:
        return math.inf
    windows_apart = windows_until_divergence(whole, about, observed_modulation.borders, noise)
    share = windows_apart / (_groups_ahead(whole, observed_modulation) * longer)
    # Bodies that tumble are apart at once: their difference counts only where cycles are the windows.
    return share if share < 1 and (share > 0 or _needs_cycles(whole, observed_modulation)) else math.inf


def _undecidable_reason(p: _Projections, e: Evidence[float], waits: list[float], noise: Noise) -> str:
    """Return the reason why no longer run would decide; empty if one may."""
    if e.free_speed == 0 and not e.has_settled and waits == [math.inf] and p.mean.low < p.mean.last:
        return REASON_COASTING
    if p.growing:
        return ""
    open_ = _open_numbers(p, e, noise)
    if open_ and all(x.width <= _NOISE_RANGE * size for x, size in open_):
        return REASON_IN_NOISE
    is_decidable = math.inf not in waits or any(x.course is not Course.STATIONARY for x, _ in open_)
    return "" if is_decidable else REASON_WAVERING


def _open_numbers(p: _Projections, e: Evidence[float], noise: Noise) -> list[tuple[Projection, float]]:
    """Return the numbers that leave the outcome of the rotor open, each with its noise."""
    of_speed = noise.speed * p.reference
    numbers = [] if e.has_settled and e.is_at_speed.is_known else [(p.mean, of_speed), (p.lowest, of_speed)]
    numbers += [] if p.residual is None or e.is_balanced.is_known else [(p.residual, noise.angle)]
    numbers += [] if e.is_beyond_resonance.is_known else [(p.lowest, of_speed)]
    numbers += [] if e.is_modulated.is_known else [(p.speed_range, noise.speed)]
    return numbers + [(lag, noise.speed) for lag in p.lags if is_undecided(lag)]


def _waits(p: _Projections, e: Evidence[float], whole: Blocks) -> list[float]:
    """Return the windows until each open number will be known."""
    beats = p.beats and p.speed_range.last > MODULATION_THRESHOLD and p.mean.course is not Course.DRIFTING
    dies_out = beats and p.speed_range.course is Course.APPROACHING
    even = p.speed_range.windows_until(1e-3) if dies_out else math.inf  # mean and lowest speed settle with it
    if e.free_speed == 0 and not e.has_settled:  # it coasts: nothing else is open
        return [windows_to_rest(whole, p.means)]
    waits = [] if e.has_settled else [min(p.mean.windows_until(0.5 * SPEED_TOLERANCE * p.reference), even)]
    waits += [] if p.residual is None or e.is_balanced.is_known else [p.residual.windows_until(0.5 * UNBALANCE_TOLERANCE)]
    waits += [] if e.is_beyond_resonance.is_known else [min(p.lowest.windows_until(1e-3 * p.reference), even)]
    waits += [] if e.is_modulated.is_known else [p.speed_range.windows_until(0.5 * MODULATION_THRESHOLD)]
    if p.divergence < math.inf:
        return [p.divergence]
    waits += [p.speed_range.windows * math.log(1 / p.speed_range.last)] if p.growing and 0 < p.speed_range.last < 1 else []
    return waits + [lag.windows for lag in p.lags if not e.asynchronous.is_known and is_undecided(lag)]


def unrest(least: Any, greatest: Any) -> np.ndarray:
    """Return the range of a residual unbalance, as a share of its largest value; 0 if it is compensated.

    least, greatest: of the last half, as shares of the unbalance, of each motion.
    """
    return np.where(greatest > UNBALANCE_TOLERANCE, 1 - least / np.maximum(greatest, UNBALANCE_TOLERANCE), 0.0)


def _unrest(half: Blocks) -> float:
    """The unrest of a rotor in its last half."""
    return float(unrest(half.least_sum.min(), half.greatest_sum.max()))


def _lasting(speed_range: Projection, observed_modulation: Modulation | None) -> tuple[float, float]:
    """Return the bounds between which the range of a modulation will stay. It lasts if its cycles, even or many, hardly change
    their range any more; else it may die out."""
    if speed_range.high <= MODULATION_THRESHOLD:
        return speed_range.bounds
    if observed_modulation is None:
        return 0.0, math.inf
    few = observed_modulation.cycles < _FEWEST_UNEVEN
    fades = few or (speed_range.course is Course.APPROACHING and speed_range.low < speed_range.last)
    even = speed_range.width <= (_FADING if fades else _LASTING) * speed_range.last
    if observed_modulation.regular:
        lasts = even or speed_range.course is Course.DRIFTING
    else:
        lasts = observed_modulation.cycles >= _FEWEST_IRREGULAR and (even or speed_range.course is not Course.APPROACHING)
    return speed_range.bounds if lasts else (0.0, speed_range.high)


def _extra_run_factor(
    waits: list[float], speed_range: Projection, observed_modulation: Modulation | None, ahead: float, end: float
) -> float:
    """Return the further run, as a multiple of the record's length, for so many windows; or for more cycles of a modulation
    that may not last, which are counted in the last half."""
    if (
        observed_modulation is not None
        and observed_modulation.regular
        and observed_modulation.cycles < _FEWEST_UNEVEN
        and speed_range.course is Course.STATIONARY
    ):
        return max(0.0, 2 * _FEWEST_UNEVEN * observed_modulation.period / end - 1)
    return max(waits, default=0.0) * LOOKAHEAD / ahead


def _groups_ahead(whole: Blocks, observed_modulation: Modulation) -> float:
    """The groups of cycles to look ahead."""
    return LOOKAHEAD * float(whole.time[-1] - whole.time[0]) / observed_modulation.span


def _residual_projection(whole: Blocks, ahead: float, noise: Noise) -> Projection:
    """Project the residual unbalance: while bodies still move and it falls, it may fall to zero; one that has begun to rise
    may continue to do so. Changes within the scatter of turns, as of balls that knock under gravity, are neither."""
    moving, sizes = _unrest(whole.last(WINDOWS * SHARE)) > UNREST, windows_of(whole.greatest_sum).max(axis=1)
    if scatters(whole.greatest_sum):
        return _without_negative(_with_noise(scattering_projection(sizes), noise))
    p = falling_projection(sizes, ahead, noise.angle, even_if_approaching=moving)
    later = project(sizes[1:], ahead, noise.angle)
    begins_to_rise = p.course is Course.STATIONARY and later.course is Course.DRIFTING and later.high > p.high
    if begins_to_rise:
        return _without_negative(replace(later, low=p.low))
    return _without_negative(_with_noise(p, noise) if p.course is Course.STATIONARY else p)


def _with_noise(p: Projection, noise: Noise) -> Projection:
    """Widen the bounds of a residual unbalance that is at rest but for the noise of the integration."""
    low, high = noise.widen(np.array(p.bounds)).tolist()
    return replace(p, low=low, high=high)


def _without_negative(p: Projection) -> Projection:
    """Clip the projection of a number that cannot be less than zero."""
    return replace(p, low=max(p.low, 0.0))


def _needs_cycles(whole: Blocks, observed_modulation: Modulation) -> bool:
    """True if a modulation is so slow that means are to be taken over whole cycles of it."""
    duration, most = float(whole.time[-1] - whole.time[0]), _TENTHS if observed_modulation.regular else _TENTHS_IRREGULAR
    return most * observed_modulation.period > SHARE * duration
