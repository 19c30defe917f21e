"""Run a Flow: dense samples, exact events, progress, and a sentence when it fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from wucht.errors import RunError
from wucht.numerics.compile import Flow
from wucht.numerics.events import Hit, LegError

Progress = Callable[[float], None]
_SAMPLES_A_LEG = 4096
_MAX_ACTIONS = 1_000_000


@dataclass(frozen=True)
class Trajectory:
    """What a run computed.

    time: (N,). states: (n, N), in the System's order. quadratures: an (N,) array a name, zero at the first sample.
    hits: events in order. ``end_time``, ``end_state`` (with the quadratures): where it stopped, to continue from.
    stopped_by: the name of the terminal event that ended it. failure: the sentence why it failed, with all samples before.
    interrupted: the user stopped it.
    """

    time: np.ndarray
    states: np.ndarray
    quadratures: Mapping[str, np.ndarray]
    parameters: np.ndarray
    end_time: float
    end_state: np.ndarray
    hits: tuple[Hit, ...] = ()
    stopped_by: str | None = None
    failure: str | None = None
    interrupted: bool = False

    def joined(self, later: Trajectory) -> Trajectory:
        """This trajectory followed by one that continued from its end."""
        skip = int(bool(len(self.time)) and bool(len(later.time)) and later.time[0] <= self.time[-1])
        return Trajectory(
            np.concatenate([self.time, later.time[skip:]]),
            np.concatenate([self.states, later.states[:, skip:]], axis=1),
            {k: np.concatenate([v, later.quadratures[k][skip:]]) for k, v in self.quadratures.items()},
            later.parameters,
            later.end_time,
            later.end_state,
            self.hits + later.hits,
            later.stopped_by,
            later.failure,
            later.interrupted,
        )


@dataclass
class _Record:
    times: list[np.ndarray] = field(default_factory=list)
    states: list[np.ndarray] = field(default_factory=list)
    hits: list[Hit] = field(default_factory=list)


def integrate(
    flow: Flow,
    initial: Sequence[float] | np.ndarray,
    parameters: Sequence[float] | Mapping[str, float],
    grid: np.ndarray,
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate from ``grid[0]`` and sample at the grid's points.

    initial: the state (n,), or with the quadratures' values appended (n + m,) to continue a run. parameters: in the System's
    order, or by name. grid: (N,), increasing. progress: called with the time reached. A run that fails returns what it has
    with the sentence in ``failure``; so does Ctrl-C, with ``interrupted``. Raises ``RunError`` for an initial state that is
    not finite.
    """
    system = flow.system
    pars = np.array(system.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
    n, extra = len(system.states), len(system.quadratures)
    state = np.asarray(initial, dtype=float)
    state = np.concatenate([state, np.zeros(n + extra - len(state))])
    if not np.isfinite(state).all() or len(state) != n + extra:
        raise RunError(f"the initial state {np.asarray(initial)} has not {n} finite numbers")
    grid = np.asarray(grid, dtype=float)
    if len(grid) < 1 or (np.diff(grid) <= 0).any():
        raise RunError("the times at which to sample must increase")
    engine, record = flow.engine, _Record()
    failure, stopped_by, interrupted, done = None, None, False, 0
    try:
        engine.forget_events()
        engine.start(float(grid[0]), state, pars)
        while done < len(grid) and stopped_by is None:
            piece = grid[done : done + _SAMPLES_A_LEG]
            leg = engine.leg(piece)
            taken = leg.states.shape[1]
            record.times.append(piece[:taken])
            record.states.append(leg.states)
            record.hits.extend(leg.hits)
            done += taken
            if len(record.hits) > _MAX_ACTIONS:
                raise RunError(f"more than {_MAX_ACTIONS} events")
            if leg.stopped_by is not None:
                event = flow.events[leg.stopped_by]
                if event.action is not None:
                    changed, pars = event.action(leg.time, leg.state[:n].copy(), pars.copy())
                    engine.start(leg.time, np.concatenate([changed, leg.state[n:]]), pars)
                if event.terminal:
                    stopped_by = event.name
            if progress:
                progress(engine.time)
    except KeyboardInterrupt:
        interrupted = True
    except LegError as error:
        record.times.append(grid[done : done + error.samples.shape[1]])
        record.states.append(error.samples)
        reached = engine.time if np.isfinite(engine.time) else float(grid[max(0, done + error.samples.shape[1] - 1)])
        failure = _failure(str(error), error.remedy, flow, reached, record.states)
    if not sum(map(len, record.times)):
        record.times, record.states = [grid[:1]], [state[:, None]]
    times, states = np.concatenate(record.times), np.concatenate(record.states, axis=1)
    end_time, end_state = engine.time, engine.state
    if interrupted:
        # What was computed since the last samples were taken is given up, so that a resumed run keeps its even grid.
        end_time, end_state = float(times[-1]), states[:, -1]
    return Trajectory(
        times,
        states[:n],
        {q.name: states[n + i] for i, q in enumerate(system.quadratures)},
        pars,
        end_time,
        end_state,
        tuple(record.hits),
        stopped_by,
        failure,
        interrupted,
    )


def _failure(reason: str, remedy: str, flow: Flow, time: float, samples: list[np.ndarray]) -> str:
    seen = [block[:, -1] for block in samples if block.shape[1]]
    last = seen[-1] if seen else np.empty(0)
    largest = sorted(zip(flow.system.state_names, last, strict=False), key=lambda p: -abs(p[1]))
    shown = ", ".join(f"{name} = {value:.4g}" for name, value in largest[:4]) or "none was reached"
    return f"the integration failed at t = {time:.6g}: {reason} (largest states sampled last: {shown}). {remedy}"
