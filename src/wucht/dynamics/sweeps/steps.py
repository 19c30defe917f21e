"""The sweep of equations: the parameter is moved in small steps, and the motion tends to something at each value.

At each value the motion continues from where it was at the one before, for a time in which the first one settled; in the second
half of that the range of each state is recorded, and its maxima. Where both ways differ the state depends on the history.
A forcing is at the beginning of a period whenever the parameter changes: otherwise each step would change its phase.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.limit_set import whole_periods
from wucht.dynamics.limit_sets.long_run import long_run
from wucht.dynamics.limit_sets.resting_states import decays
from wucht.dynamics.sweeps.course import Ends, SweepCourse
from wucht.dynamics.work import Work
from wucht.errors import RunError
from wucht.machines.subject import Subject
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.jacobian import Jacobian

_AT_REST = 1e-9  # of the size of a state: it changes less in the recorded half of a step where the motion rests
_SAMPLES = 4000  # in the recorded half of a step
MOST_MAXIMA = 60  # of a state at a value
_DIFFERENT = 0.01  # of the range of a state over the whole sweep: more is another state
_FIRST = 0.1  # share of the work until the motion has settled at the first value
_JUMP, _NEIGHBOURS = 8.0, 4  # times the median change of the values beside it, and as many on either side


@dataclass(frozen=True, eq=False)
class Way:
    """One way through the range.

    Attributes
    ----------
    values : ndarray, (V,)
        Of the parameter, in their order on this way.
    low, high, mean : ndarray, (n, V)
        Of each state; NaN from where the run failed.
    maxima : ndarray, (n, V, 60)
        The last maxima of each state, NaN where there are fewer.
    failure : str, optional
        Why it ended early.
    """

    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    maxima: np.ndarray
    failure: str | None = None


@dataclass(frozen=True)
class StateJump:
    """A jump of the motion. value: of the parameter, in the middle of the bracket. before, after: largest value of the state
    that jumps most. direction: in which the parameter moves, "up" or "down"."""

    value: float
    state: str
    before: float
    after: float
    direction: str
    bracket: tuple[float, float]

    @property
    def change(self) -> str:
        """What changes most, in words."""
        return f"{self.state} jumps from {self.before:.4g} to {self.after:.4g}"


@dataclass(frozen=True, eq=False)
class SteppedEquations:
    """Equations whose parameter is moved in steps. points: number of its values. start: state (n,) to settle from.

    tolerance, engine: as of ``long_run``.
    """

    subject: Subject
    path: str
    points: int
    start: np.ndarray
    tolerance: float
    engine: str | None

    def courses(self, ways: Mapping[str, Ends], work: Work) -> Iterator[SweepCourse]:
        """Yield the course after each way. ways: the ends of each. Raises ``RunError`` where the first motion fails."""
        course, (first, last) = SweepCourse(), next(iter(ways.values()))
        yield course
        work.report(0.0, "settling")
        at_first = self.subject.with_values({self.path: first})
        span, state = work.unit("settling", partial(_settle, at_first, self.start, self.tolerance, self.engine))
        course = replace(course, span=span, rate=abs(last - first) / ((self.points - 1) * span))
        for k, (name, values) in enumerate(ways.items()):
            begin, end = (_FIRST + (1 - _FIRST) * n / len(ways) for n in (k, k + 1))
            part, grid = work.part(name, begin, end), np.linspace(*values, self.points)
            way, state = part.unit("values", partial(self._way, grid, state, span, partial(part.report, label=name)))
            course = self._with_way(course, name, way)
            yield course
            if course.failure:
                return
        yield replace(course, is_complete=True)

    def _with_way(self, course: SweepCourse, name: str, way: Way) -> SweepCourse:
        system = self.subject.system
        rows = [i for i, state in enumerate(system.states) if state not in system.angles]
        ways = {**course.ways, name: way}
        return replace(
            course.with_doubts(*self._doubts(name, way)),
            ways=ways,
            jumps=(*course.jumps, *_jumps(way, name, system.state_names, rows)),
            hysteresis=_range_of_history(ways["up"], ways["down"], rows) if len(ways) == 2 else None,
            failure=way.failure,
        )

    def _doubts(self, name: str, way: Way) -> Iterator[str]:
        values = self._unstable_values(way)
        if len(values):
            low, high = values.min(), values.max()
            between = f"between {low:.5g} and {high:.5g}" if high > low else f"at {low:.5g}"
            yield (
                f"{name}: for {self.path} {between} the motion rests on an unstable equilibrium, which any disturbance leaves; "
                "jumps do not show there. Begin beside it (study.start)"
            )

    def _way(
        self, values: np.ndarray, start: np.ndarray, span: float, report: Callable[[float], None]
    ) -> tuple[Way, np.ndarray]:
        """Move a parameter through values (V,) and return what is recorded, and the last state (n,). span: the time at each."""
        subject, path = self.subject, self.path
        compiled_system = compile_system(subject.system, self.tolerance, (), self.engine)
        n, state = len(subject.system.states), np.asarray(start, float)
        low, high, mean = (np.full((n, len(values)), np.nan) for _ in range(3))
        maxima = np.full((n, len(values), MOST_MAXIMA), np.nan)
        for k, value in enumerate(values.tolist()):
            report(k / len(values))
            numbers = subject.system.values({**subject.values, path: value})
            end = whole_periods(subject.with_values({path: value}), span)
            grid = np.concatenate([[0.0], np.linspace(end / 2, end, _SAMPLES + 1)])
            run = integrate(compiled_system, state, numbers, grid).reraise_interrupt()
            if run.failure is not None:
                return Way(values, low, high, mean, maxima, f"at {path} = {value:.6g}: {run.failure}"), state
            recorded_states, state = run.states[:, 1:], run.states[:, -1]
            low[:, k], high[:, k], mean[:, k] = recorded_states.min(1), recorded_states.max(1), recorded_states.mean(1)
            for i, x in enumerate(recorded_states):
                peaks = _peaks(x)[-MOST_MAXIMA:]
                maxima[i, k, : len(peaks)] = peaks
        return Way(values, low, high, mean, maxima), state

    def _unstable_values(self, way: Way) -> np.ndarray:
        """Return the values of the parameter at which the motion rests on an equilibrium that a disturbance leaves.

        It stays there only because it is computed without a disturbance: from a start exactly on it, or by a symmetry.
        """
        subject = self.subject
        if subject.system.depends_on_time:
            return np.empty(0)
        is_rest = (way.high - way.low <= _AT_REST * np.maximum(np.abs(way.low), np.abs(way.high))).all(axis=0)
        jacobian, unstable = Jacobian.of(subject.system), list[float]()
        for k in np.flatnonzero(is_rest).tolist():
            values = subject.system.values({**subject.values, self.path: float(way.values[k])})
            matrix = jacobian.values_at(way.mean[:, k], values)[1]
            if np.isfinite(matrix).all() and decays(np.linalg.eigvals(matrix)) is False:
                unstable.append(float(way.values[k]))
        return np.array(unstable)


def _peaks(x: np.ndarray) -> np.ndarray:
    """Return the maxima of samples (K,), of the parabola through each three; the last value of a motion without one."""
    inner = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])) + 1
    if not len(inner):
        return np.array([x[-1]])
    a, b, c = x[inner - 1], x[inner], x[inner + 1]
    bend = a - 2 * b + c
    return np.asarray(b - np.where(bend < 0, (a - c) ** 2 / np.where(bend < 0, 8 * bend, -1.0), 0.0))


def _settle(subject: Subject, start: np.ndarray, tolerance: float, engine: str | None) -> tuple[float, np.ndarray]:
    """Return the time in which the motion from a start (n,) settles, and its state at the end."""
    run = long_run(subject, start, None, tolerance, engine)
    if run.failure is not None:
        raise RunError(run.failure)
    return run.end_time, run.states[:, -1]


def _jumps(way: Way, direction: str, names: tuple[str, ...], rows: Sequence[int]) -> Iterator[StateJump]:
    """Yield the jumps on a way: changes of a state's range that are many times those at the values beside it.

    rows: of the states that are no angles.
    """
    if not len(rows):
        return
    measures = np.stack([way.low, way.high])[:, rows]  # (2, r, V)
    sizes = np.nanmax(way.high[rows], axis=1) - np.nanmin(way.low[rows], axis=1)
    changes = np.abs(np.diff(measures, axis=2)).max(axis=0) / np.where(sizes > 0, sizes, 1.0)[:, None]  # (n, V - 1)
    largest = np.nan_to_num(changes.max(axis=0))
    for k in range(len(largest)):
        beside = np.concatenate([largest[max(0, k - _NEIGHBOURS) : k], largest[k + 1 : k + 1 + _NEIGHBOURS]])
        if largest[k] > 5 * _DIFFERENT and largest[k] > _JUMP * np.median(beside) and largest[k] >= beside.max():
            i = rows[int(changes[:, k].argmax())]
            value, (before, after) = float((way.values[k] + way.values[k + 1]) / 2), way.high[i, k : k + 2].tolist()
            low, high = sorted(way.values[k : k + 2].tolist())
            yield StateJump(value, names[i], before, after, direction, (low, high))


def _range_of_history(up: Way, down: Way, rows: Sequence[int]) -> list[float] | None:
    """Return the range of the parameter in which the motion depends on the way; None where it nowhere does.

    rows: of the states that are no angles.
    """
    if not len(rows):
        return None
    sizes = np.nanmax(up.high[rows], axis=1) - np.nanmin(up.low[rows], axis=1)
    scale = np.where(sizes > 0, sizes, 1.0)[:, None]
    apart = [np.abs(getattr(up, name)[rows] - getattr(down, name)[rows, ::-1]) for name in ("low", "high")]
    off = np.maximum(*apart) / scale
    at = up.values[(off > 5 * _DIFFERENT).any(axis=0)]
    return [float(at.min()), float(at.max())] if len(at) else None
