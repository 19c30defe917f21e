"""What the last leg of a run tends to: an equilibrium, a periodic orbit, a torus or a chaotic set, or nothing known yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.limit_sets.conservation import preserves_volume
from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, StateMetric, forcing_period
from wucht.errors import RunError, WuchtError
from wucht.files.user_system import UserSystem
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.integration import integrate
from wucht.numerics.jacobian import Jacobian
from wucht.numerics.lyapunov import LyapunovExponent, equations_jump, largest_lyapunov_exponent
from wucht.numerics.orbits import PeriodicOrbit, periodic_orbit
from wucht.numerics.recurrence import Recurrence, recurrence

_AT_REST = 1e-6  # of the extent of the whole run: a smaller change in half a leg is none
# Times the tolerance: as small a change is the noise of an integration, whose steps grow at an equilibrium until they are
# barely stable. Measured with Lorenz' equations: 26 (compiled, SciPy).
_NOISE = 100.0
_NEWTON, _LAST_STEP = 30, 1e-10  # steps; relative to the states' sizes
_NEUTRAL = 1e-6  # a disturbance that changes less in a period, or in the time of the fastest one, neither grows nor decays
_ORBIT_SAMPLES, _SPACINGS = 4096, 3  # rounds in which the samples are spaced
_MOST_PARTS, _SAME = 8, 1e-6  # of an orbit; relative to the states' sizes, a smaller difference is none
_PERIODS_AGREE = 0.02  # relative: of recurrence and orbit
_OFF = 0.05  # of its size: so near to the orbit the run is
_FEWEST_CYCLES, _CYCLES_OF_TORUS = 100, 500  # oscillations in a leg before its exponent is computed, or is believed to be zero
_GROWTH = 12.0  # e-folds of a change over the duration: more than a change that grows with a power of time
_EXTENSIONS, _EXTENSION, _HALF_WIDTH = 3, 4, 0.1  # rounds, each longer, until the interval of a positive exponent is so narrow
_SPREAD = 0.05  # of the sizes: greatest distance between halves of a set that is covered
_COVERAGE = 0.95  # share of samples


@dataclass(frozen=True, eq=False)
class RunSegment:
    """A segment of a run. extents (n,): range of each state over the whole run so far, of its size where there is none."""

    time: np.ndarray
    states: np.ndarray
    extents: np.ndarray

    @property
    def duration(self) -> float:
        """Its length."""
        return float(self.time[-1] - self.time[0])

    @property
    def oscillations(self) -> int:
        """Number of its oscillations: upward passages of a state through its mean, of the state with most of them."""
        deviation = self.states - self.states.mean(axis=1, keepdims=True)
        return int(((deviation[:, :-1] < 0) & (deviation[:, 1:] >= 0)).sum(axis=1).max())


def settled_motion(subject: UserSystem, compiled_system: CompiledSystem, leg: RunSegment) -> LimitSet | None:
    """Return what a leg tends to, None where that cannot be told from it."""
    metric = StateMetric.of(subject, leg.extents)
    late = leg.states[:, leg.states.shape[1] // 2 :]
    if (np.ptp(late, axis=1) <= max(_AT_REST, _NOISE * compiled_system.tolerance) * leg.extents).all():
        return _equilibrium(subject, leg, metric)
    repetition = recurrence(leg.time, leg.states, metric.turning)
    if repetition is not None and (orbit := _orbit(subject, compiled_system, leg, repetition, metric)) is not None:
        return orbit
    if equations_jump(subject.system) or leg.oscillations < _FEWEST_CYCLES:
        return None
    return _irregular_motion(subject, compiled_system, leg, metric)


def _equilibrium(subject: UserSystem, leg: RunSegment, metric: StateMetric) -> LimitSet | None:
    """Return the equilibrium at the end of a leg, by Newton's method; None where this leads elsewhere."""
    system, values, x = subject.system, subject.system.values(subject.values), leg.states[:, -1].copy()
    if system.depends_on_time:
        return LimitSet(MotionKind.EQUILIBRIUM, leg.time[-1:], leg.states[:, -1:], metric, None, eigenvalues=np.empty(0))
    jacobian = Jacobian.of(system).with_parameters(values)
    for _ in range(_NEWTON):
        f, derivative = jacobian(x)
        if not (np.isfinite(f).all() and np.isfinite(derivative).all()):
            return None
        step = -np.linalg.lstsq(derivative * metric.sizes, f, rcond=None)[0] * metric.sizes
        x = x + step
        if (np.abs(step) <= _LAST_STEP * np.maximum(metric.sizes, np.abs(x))).all():
            break
    if (np.abs(x - leg.states[:, -1]) > _OFF * metric.sizes).any():
        return None
    eigenvalues = np.linalg.eigvals(jacobian(x)[1])
    eigenvalues = eigenvalues[np.lexsort((-eigenvalues.imag, -eigenvalues.real))]
    attracts = decays(eigenvalues)
    return LimitSet(MotionKind.EQUILIBRIUM, leg.time[-1:], x[:, None], metric, attracts, eigenvalues=eigenvalues)


def decays(eigenvalues: np.ndarray) -> bool | None:
    """Return whether all disturbances of an equilibrium with these eigenvalues decay; None if the slowest neither grows nor
    decays."""
    return _sign_of_growth(eigenvalues.real, _NEUTRAL * float(np.abs(eigenvalues).max(initial=0.0)))


def _sign_of_growth(growth: np.ndarray, neutral: float) -> bool | None:
    """True if all disturbances decay, False if one grows, None if the slowest does neither."""
    largest = float(growth.max(initial=-np.inf))
    return True if largest < -neutral else False if largest > neutral else None


def _orbit(
    subject: UserSystem, compiled_system: CompiledSystem, leg: RunSegment, repetition: Recurrence, metric: StateMetric
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
    multipliers = orbit.nontrivial(0 if has_forcing else 1)
    attracts = _sign_of_growth(np.abs(multipliers) - 1, _NEUTRAL)
    turns = np.round(orbit.advance / (2 * np.pi)).astype(int)
    gap = float(np.linalg.norm(np.diff(metric.points(times, states), axis=0), axis=1).max()) / 2
    limit_set = LimitSet(MotionKind.PERIODIC, times, states, metric, attracts, orbit.period, turns, multipliers, gap=gap)
    wide = np.ptp(states, axis=1) >= np.ptp(last, axis=1) / 2  # else the orbit has shrunk to an equilibrium
    near = limit_set.distances(leg.time[is_last], last).max() <= _OFF * np.sqrt(len(end)) + gap
    return limit_set if attracts is not False and near and wide[still.argmax()] else None


def _repetitions(subject: UserSystem, compiled_system: CompiledSystem, orbit: PeriodicOrbit, metric: StateMetric) -> int:
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


def _period_of(subject: UserSystem, period: float) -> float | None:
    """Return the period of an orbit that repeats after about a time: a multiple of the forcing's where there is one."""
    if not subject.system.depends_on_time:
        return period
    forcing = forcing_period(subject.system, subject.values)
    count = 0 if forcing is None else round(period / forcing)
    return count * forcing if forcing and count and abs(period / (count * forcing) - 1) < _PERIODS_AGREE else None


def _irregular_motion(
    subject: UserSystem, compiled_system: CompiledSystem, leg: RunSegment, metric: StateMetric
) -> LimitSet | None:
    """Return the chaotic set or the torus on which a leg is, None where its exponent does not tell."""
    duration = leg.duration
    for _ in range(_EXTENSIONS):
        exponent, times, states = largest_lyapunov_exponent(
            subject.system, subject.system.values(subject.values), leg.states[:, -1], duration,
            time=float(leg.time[-1]), tolerance=compiled_system.tolerance, engine=compiled_system.engine_name,
        )  # fmt: skip
        kind = _kind_of(exponent, leg.oscillations)
        if kind is not MotionKind.CHAOTIC or exponent.high - exponent.low <= 2 * _HALF_WIDTH * exponent.value:
            break
        duration *= _EXTENSION
    if kind is None:
        return None
    gap = _gap(metric.points(times, states))
    if gap > _SPREAD:
        return None
    attracts = None if kind is MotionKind.QUASI_PERIODIC or preserves_volume(subject) else True
    return LimitSet(kind, times, states, metric, attracts, exponent=exponent, gap=gap)


def _kind_of(exponent: LyapunovExponent, oscillations: int) -> MotionKind | None:
    """Return CHAOTIC where the exponent is positive beyond doubt, QUASI_PERIODIC where it is zero, None where neither holds."""
    if exponent.low > 0 and exponent.low * exponent.duration > _GROWTH:
        return MotionKind.CHAOTIC
    is_zero = exponent.low <= 0 <= exponent.high and (exponent.high - exponent.low) * exponent.duration < _GROWTH
    return MotionKind.QUASI_PERIODIC if oscillations >= _CYCLES_OF_TORUS and is_zero else None


def _gap(points: np.ndarray) -> float:
    """Return by how much the halves of points (P, d) are apart: nearly all of each are as near to the other."""
    from scipy.spatial import KDTree

    first, second = np.array_split(points, 2)
    pairs = ((first, second), (second, first))
    return max(float(np.quantile(KDTree(a).query(b)[0], _COVERAGE)) for a, b in pairs)
