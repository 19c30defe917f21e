"""A run of ordinary differential equations until it is known what its motion tends to, or until a given time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind
from wucht.dynamics.limit_sets.settled_motion import RunSegment, settled_motion
from wucht.errors import RunError
from wucht.files.user_system import UserSystem
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE, CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

INTERVALS = 20_000  # of samples in a leg, and in the stored run
_FIRST_SPAN = 30.0  # times the time in which states change as much as they are large
_DOUBLINGS = 13  # of the run, at most
_FEWEST_LEGS = 2  # before anything is judged: the first one has the transients
_BEYOND = 1e6  # times the largest state at the start, at least 1: a motion that comes so far diverges
_STILL, _MOST_SWITCHES = 1e-9, 200  # of a leg: a shorter advance; as many in succession
_BEFORE = 1e-4  # of a leg: as much before a run slides its samples end
_ZOOMS = 4  # into the interval in which a run fails
_LONGER = 4.0  # times a run that was too short is advised
_WINDOWS = 100  # in a run: in each, more than half of the samples are near to a set on which the motion has settled
_NEAR = 0.02  # of the states' sizes: farther away from what it tends to a motion has not settled

Heartbeat = Callable[[float], None]  # called with the time reached; may raise ``KeyboardInterrupt``


@dataclass(frozen=True)
class LongRunSettings:
    """How long a run is, and how it is integrated.

    Parameters
    ----------
    until : float, optional
        The end of the run; None: until it is known what the motion tends to.
    tolerance : float
    engine : str, optional
        As in ``compile_system``.
    """

    until: float | None = None
    tolerance: float = DEFAULT_TOLERANCE
    engine: str | None = None


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
    """

    time: np.ndarray
    states: np.ndarray
    kind: MotionKind
    limit_set: LimitSet | None = None
    engine: str = ""
    failure: str | None = field(default=None)

    @property
    def end_time(self) -> float:
        """The time reached."""
        return float(self.time[-1])

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
    subject: UserSystem, start: np.ndarray, settings: LongRunSettings = LongRunSettings(), report: Heartbeat | None = None
) -> LongRun:
    """Run from a state (n,) at time zero.

    Without a given end the run is doubled until it is known what the motion tends to, thirteen times at most.
    """
    compiled_system = compile_system(_bare(subject).system, settings.tolerance, (), settings.engine)
    span = settings.until / 2 if settings.until is not None else _first_span(subject, start)
    legs, begin, state = list[Trajectory](), 0.0, np.asarray(start, float)
    limit_set, kind, values = None, MotionKind.NOT_SETTLED, subject.system.values(subject.values)
    for number in range(2 if settings.until is not None else _DOUBLINGS):
        length = span if number < _FEWEST_LEGS else begin
        grid = begin + np.linspace(0.0, length, INTERVALS + 1)
        try:
            leg = integrate(compiled_system, state, values, grid, _SlidingGuard(length, report)).reraise_interrupt()
        except _SlidingError as error:
            before = integrate(compiled_system, state, values, grid[grid < error.time - _BEFORE * length]).reraise_interrupt()
            time, states = _even([*legs, before])
            return LongRun(time, states, MotionKind.FAILED, None, compiled_system.engine.name, str(error))
        legs.append(leg)
        if leg.failure is not None:
            return _failed_run(compiled_system, values, legs, start)
        begin, state = float(grid[-1]), leg.states[:, -1]
        if number + 1 < _FEWEST_LEGS:
            continue
        if _size(compiled_system, leg.states[:, -1]) > _BEYOND * max(1.0, _size(compiled_system, start)):
            kind = MotionKind.DIVERGES
            break
        extents = np.ptp(np.concatenate([one.states for one in legs], axis=1), axis=1)
        limit_set = settled_motion(_bare(subject), compiled_system, RunSegment(leg.time, leg.states, _extents(extents, state)))
        if limit_set is not None:
            kind = limit_set.kind
            break
    time, states = _even(legs)
    return LongRun(time, states, kind, limit_set, compiled_system.engine.name)


class _SlidingError(RunError):
    """The motion slides along a jump of the equations from a time on."""

    def __init__(self, time: float) -> None:
        super().__init__(
            f"at t = {time:.6g} the motion slides along a jump of the equations, which have no solution beyond; replace "
            "sign(v) by a steep tanh(v/0.001)"
        )
        self.time = time


class _SlidingGuard:
    """Report of the time reached that ends a run in which time stands still: one that switches to and fro at a jump."""

    def __init__(self, length: float, report: Heartbeat | None) -> None:
        self._least, self._report, self._count, self._last = _STILL * length, report, 0, -np.inf

    def __call__(self, time: float) -> None:
        self._count = self._count + 1 if time - self._last < self._least else 0
        self._last = time
        if self._count > _MOST_SWITCHES:
            raise _SlidingError(time)
        if self._report is not None:
            self._report(time)


def _bare(subject: UserSystem) -> UserSystem:
    """Return the equations without outputs and quadratures."""
    return replace(subject, system=replace(subject.system, outputs=(), quadratures=()))


def _extents(extents: np.ndarray, state: np.ndarray) -> np.ndarray:
    """Return the extents (n,) of the run's states, of those that do not change their size."""
    return np.where(extents > 0, extents, np.abs(state))


def _first_span(subject: UserSystem, start: np.ndarray) -> float:
    """Return a multiple of the time in which states change as much as they are large."""
    system, x = subject.system, np.asarray(start, float)
    rates = Evaluator.of_rates(system).array(np.zeros(1), x[:, None], system.values(subject.values))[:, 0]
    with np.errstate(all="ignore"):
        fastest = float(np.nan_to_num(np.abs(rates) / np.maximum(np.abs(x), 1.0), posinf=0.0).max())
    return _FIRST_SPAN / fastest if fastest > 0 else _FIRST_SPAN


def _size(compiled_system: CompiledSystem, state: np.ndarray) -> float:
    """Return the largest state that is no angle."""
    system = compiled_system.system
    return max((abs(float(x)) for x, s in zip(state, system.states, strict=True) if s not in system.angles), default=0.0)


def _even(legs: list[Trajectory]) -> tuple[np.ndarray, np.ndarray]:
    """Return evenly spaced samples of legs, each as long as all before it."""
    step = legs[-1].time[1] - legs[-1].time[0] if len(legs[-1].time) > 1 else 0.0
    times, states = [legs[0].time[:1]], [legs[0].states[:, :1]]
    for leg in legs:
        stride = max(1, round(step / (leg.time[1] - leg.time[0]))) if len(leg.time) > 1 else 1
        times.append(leg.time[stride::stride])
        states.append(leg.states[:, stride::stride])
    return np.concatenate(times), np.concatenate(states, axis=1)


def _failed_run(
    compiled_system: CompiledSystem, values: tuple[float, ...], legs: list[Trajectory], start: np.ndarray
) -> LongRun:
    """Return a run that failed: it diverges where its states grow beyond all bounds before, in ever shorter intervals."""
    last, farthest = legs[-1], _BEYOND * max(1.0, _size(compiled_system, start))
    step = (last.time[1] - last.time[0]) if len(last.time) > 1 else 1.0
    time, state = float(last.time[-1]), last.states[:, -1]
    for _ in range(_ZOOMS):
        if _size(compiled_system, state) > farthest:
            break
        grid = time + np.linspace(0.0, step, INTERVALS + 1)
        if grid[1] <= grid[0]:
            break
        try:
            near = integrate(compiled_system, state, values, grid).reraise_interrupt()
        except RunError:
            break
        time, state, step = float(near.time[-1]), near.states[:, -1], step / INTERVALS
    diverges = _size(compiled_system, state) > farthest
    kind = MotionKind.DIVERGES if diverges else MotionKind.FAILED
    times, states = _even([one for one in legs if len(one.time) > 1] or legs)
    return LongRun(times, states, kind, None, compiled_system.engine.name, None if diverges else last.failure)
