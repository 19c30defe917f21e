"""What the last leg of a run tends to: an equilibrium, a periodic orbit, a torus or a chaotic set, or nothing known yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, StateMetric, forcing_period, gap_of_halves
from wucht.dynamics.limit_sets.resting_states import equilibrium_near, rests, sign_of_growth, time_of_rest
from wucht.errors import RunError, WuchtError
from wucht.machines.subject import Subject
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.integration import integrate
from wucht.numerics.lyapunov import BLOCKS, LyapunovExponent, equations_jump, largest_lyapunov_exponent
from wucht.numerics.orbits import PeriodicOrbit, periodic_orbit
from wucht.numerics.recurrence import Recurrence, recurrence

_NEUTRAL = 1e-6  # a disturbance that changes less in a period neither grows nor decays
_ORBIT_SAMPLES, _SPACINGS = 4096, 3  # rounds in which the samples are spaced
_MOST_PARTS, _SAME = 8, 1e-6  # of an orbit; relative to the states' sizes, a smaller difference is none
_PERIODS_AGREE = 0.02  # relative: of recurrence and orbit
_OFF = 0.05  # of its size: so near to the orbit the run is
_FEWEST_CYCLES, _CYCLES_OF_TORUS = 100, 500  # oscillations in a leg before its exponent is computed, or is believed to be zero
_GROWTH = 12.0  # e-folds of a change over the duration: more than a change that grows with a power of time
_TORUS_SWING = 4.0  # e-folds: by less the means of the growth over blocks differ on a torus
_LONGER, _MOST_LONGER, _ROUNDS = 1.3, 40.0, 3  # times the duration that the scatter demands; times that before; records
_SPLITS, _STRIDE = 99, 8  # of a record into two parts at random, to which its halves are compared; of its samples every eighth
_COVERAGE = 0.95  # share of samples


@dataclass(frozen=True, eq=False)
class RunSegment:
    """A segment of a run. ranges (n,): of each state over the whole run so far. extents: see ``state_extents``."""

    time: np.ndarray
    states: np.ndarray
    ranges: np.ndarray
    extents: np.ndarray

    @property
    def duration(self) -> float:
        """Its length."""
        return float(self.time[-1] - self.time[0])

    def oscillations(self, turning: np.ndarray) -> int:
        """Number of its oscillations: upward passages of a state through its mean, or turns of an angle, whichever are more."""
        deviation = self.states - self.states.mean(axis=1, keepdims=True)
        passages = ((deviation[:, :-1] < 0) & (deviation[:, 1:] >= 0)).sum(axis=1)
        turns = np.where(turning, np.abs(self.states[:, -1] - self.states[:, 0]) / (2 * np.pi), 0.0)
        return int(max(passages.max(), turns.max()))


def settled_motion(
    subject: Subject, compiled_system: CompiledSystem, leg: RunSegment, exponent_accuracy: float | None
) -> LimitSet | None:
    """Return what a leg tends to, None where that cannot be told from it.

    exponent_accuracy: as of ``long_run``; None: chaotic sets and tori are not tried.
    """
    metric = StateMetric.of(subject, leg.extents)
    late = np.ptp(leg.states[:, leg.states.shape[1] // 2 :], axis=1)
    if rests(late, leg.ranges, leg.states[:, -1], metric.turning, compiled_system.tolerance):
        return _equilibrium(subject, compiled_system, leg, metric)
    repetition = recurrence(leg.time, leg.states, metric.turning)
    if repetition is not None and (orbit := _orbit(subject, compiled_system, leg, repetition, metric)) is not None:
        return orbit if _remains(orbit, leg) else None
    if exponent_accuracy is None or equations_jump(subject.system) or leg.oscillations(metric.turning) < _FEWEST_CYCLES:
        return None
    return _irregular_motion(subject, compiled_system, leg, metric, exponent_accuracy)


def _equilibrium(subject: Subject, compiled_system: CompiledSystem, leg: RunSegment, metric: StateMetric) -> LimitSet | None:
    """Return the equilibrium at which a leg rests; None where none is nearby, or a saddle at which it may not stay."""
    end = leg.states[:, -1]
    if subject.system.depends_on_time:
        return LimitSet(MotionKind.EQUILIBRIUM, leg.time[-1:], end[:, None], metric, None, eigenvalues=np.empty(0))
    nearest = equilibrium_near(subject, end, metric, compiled_system.tolerance, float(leg.time[-1]))
    if nearest is None or nearest.eigenvalues is None:
        return None
    has_moved = (leg.states != leg.states[:, :1]).any()
    return None if has_moved and leg.duration / 2 < time_of_rest(nearest.eigenvalues) else nearest


def _orbit(
    subject: Subject, compiled_system: CompiledSystem, leg: RunSegment, repetition: Recurrence, metric: StateMetric
) -> LimitSet | None:
    """Return the periodic orbit at the end of a leg that repeats itself, by Newton's method; None where the run leaves it."""
    values = subject.system.values(subject.values)
    has_forcing = subject.system.depends_on_time
    period = _period_of(subject, repetition.period)
    if period is None:
        return None
    begin, end = float(leg.time[-1]), leg.states[:, -1]
    gains = 2 * np.pi * repetition.turns
    is_last = leg.time >= begin - repetition.period
    last = leg.states[:, is_last]
    still = np.where(gains == 0, np.ptp(last, axis=1), 0.0) / metric.sizes
    phase_state = None if has_forcing or gains.any() else int(still.argmax())
    try:
        orbit = periodic_orbit(
            compiled_system, values, end, period, gains, free_period=not has_forcing, phase_state=phase_state, time=begin
        )
        if abs(orbit.period / repetition.period - 1) > _PERIODS_AGREE:
            return None
        parts = _repetitions(subject, compiled_system, orbit, metric)
        if parts > 1:
            orbit = periodic_orbit(
                compiled_system, values, orbit.state, orbit.period / parts, gains / parts,
                free_period=not has_forcing, phase_state=phase_state, time=begin,
            )  # fmt: skip
        times, states = _course(compiled_system, values, orbit, metric)
    except WuchtError:  # the run has not settled yet
        return None
    driven = subject.system.second_order.driven if subject.system.second_order else ()
    multipliers = orbit.nontrivial(max(len(driven), 0 if has_forcing else 1))
    attracts = sign_of_growth(np.abs(multipliers) - 1, _NEUTRAL)
    turns = np.round(orbit.advance / (2 * np.pi)).astype(int)
    gap = float(np.linalg.norm(np.diff(metric.points(times, states), axis=0), axis=1).max()) / 2
    limit_set = LimitSet(MotionKind.PERIODIC, times, states, metric, attracts, orbit.period, turns, multipliers, gap=gap)
    widest = int(still.argmax())
    is_wide = gains.any() or np.ptp(states[widest]) >= np.ptp(last[widest]) / 2  # else it has shrunk to an equilibrium
    if attracts is False:
        late = leg.time >= begin - leg.duration / 2
        return limit_set if limit_set.distances(leg.time[late], leg.states[:, late]).max() <= limit_set.reach else None
    near = limit_set.distances(leg.time[is_last], last).max() <= _OFF * np.sqrt(len(end)) + gap
    return limit_set if near and is_wide else None


def _remains(orbit: LimitSet, leg: RunSegment) -> bool:
    """True if a motion on an orbit remains there: it is stable, or what is as small as rounding had the time to grow."""
    if orbit.attracts is not False or orbit.multipliers is None:
        return True
    growth = np.log(np.abs(orbit.multipliers).max()) / orbit.period
    return bool(leg.duration / 2 >= time_of_rest(np.array([growth])))


def _repetitions(subject: Subject, compiled_system: CompiledSystem, orbit: PeriodicOrbit, metric: StateMetric) -> int:
    """Return how often an orbit goes through the shortest one: a motion that tends to it from alternate sides returns late."""
    forcing = forcing_period(subject.system, subject.values)
    start, values = orbit.state, subject.system.values(subject.values)
    for parts in range(_MOST_PARTS, 1, -1):
        period, turns = orbit.period / parts, orbit.advance / (2 * np.pi * parts)
        if (forcing is not None and abs(period / forcing - round(period / forcing)) > _NEUTRAL) or (turns % 1 > 0).any():
            continue
        run = integrate(compiled_system, start, values, orbit.time + np.array([0.0, period])).reraise_interrupt()
        if run.failure is None and (np.abs(run.states[:, -1] - start - orbit.advance / parts) <= _SAME * metric.sizes).all():
            return parts
    return 1


def _course(
    compiled_system: CompiledSystem, values: Sequence[float], orbit: PeriodicOrbit, metric: StateMetric
) -> tuple[np.ndarray, np.ndarray]:
    """Return times (P,) and states (n, P) of a period at about equal distances. Raises ``RunError`` where the run fails."""
    shares = np.linspace(0.0, 1.0, _ORBIT_SAMPLES + 1)
    for _ in range(_SPACINGS):
        times = orbit.time + orbit.period * shares
        run = integrate(compiled_system, orbit.state, values, times).reraise_interrupt()
        if run.failure is not None:
            raise RunError(run.failure)
        lengths = np.linalg.norm(np.diff(metric.points(times, run.states), axis=0), axis=1)
        steps = lengths / lengths.sum() + np.diff(shares)  # half the samples evenly in time
        arc = np.append(0.0, np.cumsum(steps)) / steps.sum()
        shares = np.interp(np.linspace(0.0, 1.0, _ORBIT_SAMPLES + 1), arc, shares)
    return times, run.states


def _period_of(subject: Subject, period: float) -> float | None:
    """Return the period of an orbit that repeats after about a time: a multiple of the forcing's where there is one."""
    if not subject.system.depends_on_time:
        return period
    forcing = forcing_period(subject.system, subject.values)
    count = 0 if forcing is None else round(period / forcing)
    return count * forcing if forcing and count and abs(period / (count * forcing) - 1) < _PERIODS_AGREE else None


def _irregular_motion(
    subject: Subject, compiled_system: CompiledSystem, leg: RunSegment, metric: StateMetric, accuracy: float
) -> LimitSet | None:
    """Return the chaotic set or the torus on which a leg is, None where its exponent does not tell.

    The record of a chaotic motion is made longer until the interval of its exponent is narrow. Where it ends in an equilibrium
    or on an orbit the motion was a transient; otherwise the verdict of a shorter record stands.
    """
    duration, verdict = leg.duration, None
    for _ in range(_ROUNDS):
        try:
            exponent, times, states = largest_lyapunov_exponent(
                subject.system, subject.system.values(subject.values), leg.states[:, -1], duration,
                time=float(leg.time[-1]), tolerance=compiled_system.tolerance, engine=compiled_system.engine_name,
            )  # fmt: skip
        except RunError:
            return verdict
        kind = _kind_of(exponent, leg.oscillations(metric.turning))
        if verdict is not None and kind is not MotionKind.CHAOTIC:
            record = RunSegment(times, states, leg.ranges, leg.extents)
            return None if settled_motion(subject, compiled_system, record, None) is not None else verdict
        points = metric.points(times, states)
        if kind is None or _drifts(points) or not _covers_one_set(points):
            return verdict
        verdict = LimitSet(kind, times, states, metric, None, exponent=exponent, gap=gap_of_halves(points, _COVERAGE))
        width = (exponent.high - exponent.low) / (2 * accuracy * exponent.value)
        if kind is not MotionKind.CHAOTIC or width <= 1:
            break
        duration *= min(_LONGER * width**2, _MOST_LONGER)
    return verdict


def _kind_of(exponent: LyapunovExponent, oscillations: int) -> MotionKind | None:
    """Return CHAOTIC where the exponent is positive beyond doubt all the time, QUASI_PERIODIC where changes do not grow."""
    if exponent.low > 0 and exponent.low * exponent.duration > _GROWTH:
        return MotionKind.CHAOTIC if exponent.is_steady else None
    return MotionKind.QUASI_PERIODIC if oscillations >= _CYCLES_OF_TORUS and exponent.swing < _TORUS_SWING else None


def _drifts(points: np.ndarray) -> bool:
    """True if the spread of a record, points (P, d), in a direction changes one way from each of its blocks to the next.

    So it does in a decay that is slower than any exponential, however long the record is; by chance once in 20!/2 records.
    """
    spreads = np.array([block.std(axis=0) for block in np.array_split(points, BLOCKS)])
    changes = np.diff(spreads, axis=0)
    one_way = (changes > 0).all(axis=0) | (changes < 0).all(axis=0)
    return bool((one_way & (np.ptp(spreads, axis=0) > _SAME)).any())


def _covers_one_set(points: np.ndarray) -> bool:
    """True if the halves of a record, points (P, d), are no farther apart than parts of as many blocks of it at random.

    Where a motion drifts, its halves are. The limit follows from the scatter of the record itself and falls with its length: a
    permutation test at the level of one in a hundred (P. Good, "Permutation, Parametric and Bootstrap Tests of Hypotheses",
    Springer 2005, chapter 3).
    """
    from scipy.spatial import KDTree

    blocks = np.array_split(points[::_STRIDE], BLOCKS)
    whole, owner = np.concatenate(blocks), np.repeat(np.arange(BLOCKS), [len(block) for block in blocks])
    distances = np.column_stack([KDTree(block).query(whole)[0] for block in blocks])  # of each sample from each block

    def gap(part: np.ndarray) -> float:
        inside = part[owner]
        sides = (distances[inside][:, ~part], distances[~inside][:, part])
        return max(float(np.quantile(side.min(axis=1), _COVERAGE)) for side in sides)

    halves, random = np.arange(BLOCKS) < BLOCKS // 2, np.random.default_rng(0)
    splits = (random.permutation(halves) for _ in range(_SPLITS))
    between_halves = gap(halves)
    return any(gap(split) >= between_halves for split in splits if 0 < (split == halves).sum() < BLOCKS)  # not the halves again
