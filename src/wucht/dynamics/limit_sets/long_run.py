"""A run of ordinary differential equations until it is known what its motion tends to, or until a given time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, StateMetric
from wucht.dynamics.limit_sets.resting_states import equilibrium_near, state_extents
from wucht.dynamics.limit_sets.settled_motion import RunSegment, settled_motion
from wucht.errors import RunError
from wucht.files.user_system import UserSystem
from wucht.machines.subject import Subject
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE, CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

INTERVALS = 20_000  # of samples in a leg, and in the stored run
_FIRST_SPAN = 30.0  # times the time in which states change as much as they are large
_MOST_HALVINGS = 30  # of the given length of a run, until its first leg is as short as without one
_ROUNDING = 1e-9  # of a state: as near to an equilibrium it lies on it, but for rounding; changes as slow do not tell the pace
_FEWEST_LEGS = 2  # before anything is judged: the first one has the transients
_BEYOND = 1e6  # times the largest state at the start, at least 1: a motion that comes so far diverges
_ZOOMS = 4  # into the interval in which a run fails
_LONGER = 4.0  # times a run that was too short is advised
_WINDOWS = 100  # in a run: in each, more than half of the samples are near to a set on which the motion has settled
_NEAR = 0.02  # of the states' sizes: farther away from what it tends to a motion has not settled

Heartbeat = Callable[[float], None]  # called with the time reached; may raise ``KeyboardInterrupt``
_SETTLED_SHARE = 1.2  # of its settling time: a motion is shown until then


@dataclass(frozen=True, eq=False)
class LongRun:
    """A run and what its motion tends to.

    Attributes
    ----------
    time : ndarray, (N,)
        Evenly spaced.
    states : ndarray, (n, N)
        Angles are not wrapped.
    kind : MotionKind
    limit_set : LimitSet, optional
        What the motion tends to, where there is such a set.
    engine : str
    failure : str, optional
        Why the integration failed.
    start_equilibrium : LimitSet, optional
        On which the start lies, but for rounding.
    """

    time: np.ndarray
    states: np.ndarray
    kind: MotionKind
    limit_set: LimitSet | None = None
    engine: str = ""
    failure: str | None = None
    start_equilibrium: LimitSet | None = None

    @property
    def end_time(self) -> float:
        """The time reached."""
        return float(self.time[-1])

    def settling_states(self, most: int) -> np.ndarray:
        """The states (n, K) until it has settled, and a little beyond; of more than so many only every second, third, ..."""
        until = self.end_time if self.settling_time is None else _SETTLED_SHARE * self.settling_time
        states = self.states[:, self.time <= until]
        return states[:, :: max(1, -(-states.shape[1] // most))]

    @cached_property
    def settling_time(self) -> float | None:
        """The time after which the motion is near to what it tends to: within a fiftieth of the states' sizes, or the gaps
        between the samples of a chaotic set or a torus. None where it has not settled.
        """
        if self.limit_set is None:
            return None
        away = self.limit_set.distances(self.time, self.states) > max(_NEAR, self.limit_set.reach)
        if self.limit_set.kind in (MotionKind.CHAOTIC, MotionKind.QUASI_PERIODIC):  # which are known by samples only
            window = max(1, len(away) // _WINDOWS)
            away = np.convolve(away, np.ones(window), "same") > window / 2
        last = int(np.flatnonzero(away)[-1]) if away.any() else -1
        return float(self.time[last + 1]) if last + 1 < len(self.time) else None

    @property
    def advised_time(self) -> float | None:
        """A longer time for a run that was too short to tell, else None."""
        return _LONGER * self.end_time if self.kind is MotionKind.NOT_SETTLED else None


def long_run(
    subject: Subject,
    start: np.ndarray,
    until: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    engine: str | None = None,
    *,
    exponent_accuracy: float = 0.02,
    first_leg: float | None = None,
    legs: int = 13,
    report: Heartbeat | None = None,
    earlier_states: np.ndarray | None = None,
) -> LongRun:
    """Run from a state at time zero until it is known what the motion tends to.

    The run is doubled until then, or its legs are used up; with a given end, until that. What a shorter record has shown stands
    until a longer one shows something else.

    Parameters
    ----------
    subject : Subject
    start : ndarray, (n,)
    until : float, optional
        The end of the run; None: until it is known what the motion tends to.
    tolerance : float
    engine : str, optional
        As of ``compile_system``.
    exponent_accuracy : float
        Half the width of the interval of a positive Lyapunov exponent, relative to it, that is aimed at.
    first_leg : float, optional
        The time of the first leg without a given end; by default a multiple of that in which the states change.
    legs : int
        The largest number of legs without a given end: each is as long as all before it.
    report : callable, optional
        Called with the time reached; may raise ``KeyboardInterrupt``.
    earlier_states : ndarray, (n, K), optional
        Of the motion before its start; how far a state has moved is told by them too.
    """
    system, start = replace(subject.system, outputs=(), quadratures=()), np.asarray(start, float)
    bare = UserSystem(system, {name: subject.values[name] for name in system.parameter_names}, subject.title)
    record = _Record(bare, compile_system(bare.system, tolerance, (), engine), start, report)
    if earlier_states is not None:
        record.extend_ranges(earlier_states)
    length, count = first_leg or record.first_span, legs
    if until is not None:
        halvings = min(max(1, math.ceil(math.log2(until / length))), _MOST_HALVINGS)
        length, count = until / 2**halvings, halvings + 1
    limit_set: LimitSet | None = None
    for number in range(count):
        if failure := record.advance(length if number < _FEWEST_LEGS else record.time):
            return failure
        if number + 1 < _FEWEST_LEGS or (limit_set is not None and limit_set.attracts):
            continue
        if record.is_beyond(record.state):
            return record.run(MotionKind.DIVERGES)
        if not system.has_formulas:
            continue
        # The verdict of a shorter record stands where a longer one has none.
        accuracy = exponent_accuracy if limit_set is None or number + 1 == count else None
        limit_set = settled_motion(bare, record.compiled_system, record.segment(), accuracy) or limit_set
        if limit_set is not None and until is None:
            break
    unknown_kind = MotionKind.NOT_SETTLED if system.has_formulas else MotionKind.UNKNOWN
    return record.run(unknown_kind if limit_set is None else limit_set.kind, limit_set)


class _Record:
    """The legs of a run so far."""

    def __init__(self, bare: Subject, compiled_system: CompiledSystem, start: np.ndarray, report: Heartbeat | None) -> None:
        self.compiled_system, self._values, self._report = compiled_system, bare.system.values(bare.values), report
        self._start, self._legs, self._low, self._high = start, list[Trajectory](), start, start
        self._turning = np.array(bare.system.is_angle)
        self.time, self.state, self._engine = 0.0, start, compiled_system.engine_name
        self.start_equilibrium, self.first_span = _first_span(bare, start, compiled_system.tolerance)

    def advance(self, length: float) -> LongRun | None:
        """Add a leg. Returns the whole run where it fails."""
        grid = self.time + np.linspace(0.0, length, INTERVALS + 1)
        leg = self._integrate(grid, self._report)
        self._legs.append(leg)
        if leg.failure is not None:
            return self._failed_run()
        self.time, self.state = float(grid[-1]), leg.states[:, -1]
        self.extend_ranges(leg.states)
        return None

    def extend_ranges(self, states: np.ndarray) -> None:
        """Extend the ranges of the states over the run by states (n, K)."""
        self._low, self._high = np.minimum(self._low, states.min(axis=1)), np.maximum(self._high, states.max(axis=1))

    def _integrate(self, grid: np.ndarray, progress: Heartbeat | None = None) -> Trajectory:
        return integrate(self.compiled_system, self.state, self._values, grid, progress).reraise_interrupt()

    def segment(self) -> RunSegment:
        """Return the last leg."""
        leg, ranges = self._legs[-1], self._high - self._low
        extents = state_extents(ranges, self.state, self._turning, self.compiled_system.tolerance)
        return RunSegment(leg.time, leg.states, ranges, extents)

    def run(self, kind: MotionKind, limit_set: LimitSet | None = None, failure: str | None = None) -> LongRun:
        """Return the whole run."""
        time, states = _even([leg for leg in self._legs if len(leg.time) > 1] or self._legs)
        return LongRun(time, states, kind, limit_set, self._engine, failure, self.start_equilibrium)

    def is_beyond(self, state: np.ndarray) -> bool:
        """True if a state is so far from the start that the motion diverges."""
        return self._size(state) > _BEYOND * max(1.0, self._size(self._start))

    def _size(self, state: np.ndarray) -> float:
        """Return the largest state that is no angle."""
        return float(np.abs(state[~self._turning]).max(initial=0.0))

    def _failed_run(self) -> LongRun:
        """Return a run that failed: it diverges where its states grow beyond all bounds before, in ever shorter intervals."""
        last = self._legs[-1]
        step = (last.time[1] - last.time[0]) if len(last.time) > 1 else 1.0
        time, state = float(last.time[-1]), last.states[:, -1]
        for _ in range(_ZOOMS):
            if self.is_beyond(state):
                break
            grid = time + np.linspace(0.0, step, INTERVALS + 1)
            if grid[1] <= grid[0]:
                break
            try:
                near = integrate(self.compiled_system, state, self._values, grid).reraise_interrupt()
            except RunError:
                break
            time, state, step = float(near.time[-1]), near.states[:, -1], step / INTERVALS
        if self.is_beyond(state):
            return self.run(MotionKind.DIVERGES)
        return self.run(MotionKind.FAILED, failure=last.failure)


def _first_span(bare: Subject, start: np.ndarray, tolerance: float) -> tuple[LimitSet | None, float]:
    """Return a multiple of the time in which states change as much as they are large, or disturbances of a start at rest.

    With the equilibrium on which the start lies, but for rounding.
    """
    system, sizes = bare.system, np.maximum(np.abs(start), 1.0)
    rates = Evaluator.of_rates(system).array(np.zeros(1), start[:, None], system.values(bare.values))[:, 0]
    with np.errstate(all="ignore"):
        fastest = float(np.nan_to_num(np.abs(rates) / sizes, posinf=0.0).max())
    nearest = None
    if fastest <= _ROUNDING and system.has_formulas and not system.depends_on_time:
        metric = StateMetric(sizes, np.array(system.is_angle), 0.0)
        nearest = equilibrium_near(bare, start, metric, tolerance)
        if nearest is not None and (np.abs(nearest.states[:, 0] - start) > _ROUNDING * sizes).any():
            nearest = None
        if nearest is not None and nearest.eigenvalues is not None:
            fastest = max(fastest, float(np.abs(nearest.eigenvalues).max()))
    return nearest, _FIRST_SPAN / fastest if fastest > 0 else _FIRST_SPAN


def _even(legs: list[Trajectory]) -> tuple[np.ndarray, np.ndarray]:
    """Return evenly spaced samples of legs, each as long as all before it."""
    step = legs[-1].time[1] - legs[-1].time[0] if len(legs[-1].time) > 1 else 0.0
    times, states = [legs[0].time[:1]], [legs[0].states[:, :1]]
    for leg in legs:
        stride = max(1, round(step / (leg.time[1] - leg.time[0]))) if len(leg.time) > 1 else 1
        times.append(leg.time[stride::stride])
        states.append(leg.states[:, stride::stride])
    return np.concatenate(times), np.concatenate(states, axis=1)
