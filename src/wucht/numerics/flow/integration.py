"""Run a compiled System, leg by leg: dense samples, exact events, breakpoints, progress, and a sentence when it fails."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from wucht.errors import RunError
from wucht.numerics.flow.coincidences import Coincidence, same_instant_until
from wucht.numerics.flow.compiled.segment_changes import MOST_STILL, STILL
from wucht.numerics.flow.compiled_system import CompiledSystem, Integrator
from wucht.numerics.flow.events import Hit, LegError, LegResult, SlidingError
from wucht.numerics.flow.program import Numbers
from wucht.numerics.flow.step_sizes import UNKNOWN, advice
from wucht.numerics.flow.system_code import SystemCode
from wucht.numerics.flow.trajectory import Trajectory

_SAMPLES_A_LEG = 1024
_MOST_HITS = 1_000_000
TimeCallback = Callable[[float], None]


@dataclass
class Integration:
    """An integration in progress: its start, and the record so far.

    state: (n + m,) with the quadratures. parameter_values: in the System's order. unit: the size of the quadratures.
    before: their values (m,) at the beginning of the leg: the integrator accumulates only the gains of the leg, so that a large
    work does not loosen its tolerance. times, states: samples, leg by leg, ``done`` in all. decided_until: the time until which
    a passage of zero of each requested event is the one that was decided last. segments: those in use.
    sample_parameter_values: those at the last sample. lowest_arguments: see ``Trajectory``. still_count: stops in succession
    while time stood still.
    """

    compiled_system: CompiledSystem
    integrator: Integrator
    state: np.ndarray
    parameter_values: np.ndarray
    grid: np.ndarray
    unit: float = 1.0
    before: np.ndarray = field(default_factory=lambda: np.empty(0))
    times: list[np.ndarray] = field(default_factory=list)
    states: list[np.ndarray] = field(default_factory=list)
    hits: list[Hit] = field(default_factory=list)
    done: int = 0
    stopped_by: str | None = None
    decided_until: dict[int, float] = field(default_factory=dict)
    segments: np.ndarray = field(default_factory=lambda: np.empty(0))
    sample_parameter_values: np.ndarray = field(default_factory=lambda: np.empty(0))
    lowest_arguments: np.ndarray | None = None
    still_count: int = 0
    last_stop: float = -math.inf

    def start(self) -> None:
        """Place the integrator at the beginning."""
        time, locator = float(self.grid[0]), self.compiled_system.locator
        self.sample_parameter_values, self.before = self.parameter_values, self.state[len(self.compiled_system.system.states) :]
        if locator is not None:
            self.segments = locator.start(time, self.state, self._system_parameters)
        if self._code.request_count:  # the run may continue another: it starts beyond the events there
            state, parameters = self._convert_units(self.state), self._all_parameters
            self.decided_until = Coincidence.at(self._code, time, state, parameters, parameters).ends
        self.integrator.forget_events()
        self._place(time, self._convert_units(self.state))

    def _begin_leg(self) -> None:
        """Store the values of the quadratures, and begin a leg with gains of zero."""
        state, n = self._convert_units(self.integrator.state, back=True), len(self.compiled_system.system.states)
        self.before = state[n:]
        self._place(self.time, self._convert_units(state))

    def _place(self, time: float, state: np.ndarray) -> None:
        self.integrator.start(time, state, self._all_parameters)

    @property
    def time(self) -> float:
        """Time reached."""
        return self.integrator.time

    @property
    def _code(self) -> SystemCode:
        return self.compiled_system.engine.code

    @property
    def _system_parameters(self) -> np.ndarray:
        """Parameters without those of the segments."""
        return np.append(self.parameter_values, 1 / self.unit)

    @property
    def _all_parameters(self) -> np.ndarray:
        return np.concatenate([self._system_parameters, self.segments])

    def _convert_units(self, states: np.ndarray, back: bool = False) -> np.ndarray:
        """Convert states (n + m) or (n + m, N) to those with the leg's gains of the quadratures in their unit, or back."""
        n, result = len(self.compiled_system.system.states), states.copy()
        before = self.before if result.ndim == 1 else self.before[:, None]
        result[n:] = result[n:] * self.unit + before if back else (result[n:] - before) / self.unit
        return result

    def advance(self) -> bool:
        """Advance by one leg. Returns true if there is more to do."""
        # Legs end at the same samples whatever happens within: a run in parts has the same numbers as a whole one.
        end = (max(self.done - 1, 0) // _SAMPLES_A_LEG + 1) * _SAMPLES_A_LEG + 1
        piece = self.grid[self.done : end]
        if self.done > 1 and len(self.before):
            self._begin_leg()
        leg = self.integrator.leg(piece)
        self._record(piece, leg.states)
        if leg.segments is not None:
            self.segments = leg.segments
        if leg.lowest_arguments is not None:
            before = leg.lowest_arguments if self.lowest_arguments is None else self.lowest_arguments
            self.lowest_arguments = np.minimum(leg.lowest_arguments, before)
        self.sample_parameter_values = self.parameter_values
        if leg.stopped_by is not None or self.compiled_system.locator or self._code.request_count:
            self._end_leg(leg)
        self._refuse_standstill(leg)
        if len(self.hits) > _MOST_HITS:
            raise LegError(f"more than {_MOST_HITS} events happened", "Look for an event that repeats", leg.states[:, :0])
        return self.done < len(self.grid) and self.stopped_by is None

    def _refuse_standstill(self, leg: LegResult) -> None:
        """Raise ``LegError`` where a run stops again and again while time stands still: it slides along a jump."""
        if leg.stopped_by is not None:
            stands = leg.time - self.last_stop < STILL * max(1.0, abs(leg.time))
            self.still_count, self.last_stop = self.still_count + 1 if stands else 0, leg.time
        if self.still_count > MOST_STILL:
            raise SlidingError(leg.states[:, :0])

    def _record(self, piece: np.ndarray, samples: np.ndarray) -> None:
        count = samples.shape[1]
        self.times.append(piece[:count])
        self.states.append(self._convert_units(samples, back=True))
        self.done += count

    def _end_leg(self, leg: LegResult) -> None:
        """Change the segments at the end of a leg, and apply the event at which it stopped and those at the same time.

        Breakpoints and events exactly at the end of a leg are handled now: a run continued from there begins beyond them.
        """
        index, parameters, segments = leg.stopped_by, self._all_parameters, self.segments
        switch = None if index is None else self.compiled_system.events[index].switch
        state = self._change_segments(leg.time, leg.state, switch)
        next_state = self._apply_actions(leg.time, state, self._events_at_end(leg, parameters))
        has_changed = next_state is not state
        if has_changed:
            next_state = self._change_segments(leg.time, next_state, None)
        if has_changed or switch is not None or not np.array_equal(segments, self.segments):
            self._place(leg.time, next_state)

    def _events_at_end(self, leg: LegResult, before: np.ndarray) -> list[int]:
        """Record the hits within a leg; return the requested events that happen at its end, that at which it stopped first.

        before: the parameters of its equations.
        """
        if not self._code.request_count:
            return []
        events, index = self.compiled_system.events, leg.stopped_by
        now = Coincidence.at(self._code, leg.time, leg.state, before, self._all_parameters)
        numbers = {e.name: i for i, e in enumerate(events) if e.switch is None}
        for hit in leg.hits:
            i = numbers.get(hit.name, index)  # that of a breakpoint is none
            if i is not None and i != index and not self._is_decided(i, hit.time) and not now.includes(i, hit.time):
                self.hits.append(hit)
        stopping = [] if index is None or events[index].switch is not None or now.is_touched(index) else [index]
        together = [*stopping, *(i for i in now.ends if i not in stopping and now.happens(i, events[i].direction))]
        new = [i for i in together if not self._is_decided(i, leg.time)]
        self.decided_until |= dict.fromkeys(stopping, same_instant_until(leg.time)) | now.ends
        return new

    def _is_decided(self, index: int, time: float) -> bool:
        """True if a passage of zero at a time is the one of an event that was decided last."""
        return time <= self.decided_until.get(index, -math.inf)

    def _apply_actions(self, time: float, state: np.ndarray, event_indices: list[int]) -> np.ndarray:
        """Record the hits of events, and return the state after their actions."""
        n, before = len(self.compiled_system.system.states), state
        for event in (self.compiled_system.events[i] for i in event_indices):
            self.hits.append(Hit(event.name, time, before[:n].copy()))
            if event.action is not None:
                new_state, self.parameter_values = event.action(time, state[:n].copy(), self.parameter_values.copy())
                state = np.concatenate([new_state, state[n:]])
            if event.terminal:
                self.stopped_by = self.stopped_by or event.name
        return state

    def _change_segments(self, time: float, state: np.ndarray, switch: tuple[int, int] | None) -> np.ndarray:
        """Change the segments after an event; returns the state with the gains of the quadratures."""
        locator, before = self.compiled_system.locator, self.segments
        if locator is not None:
            self.segments = locator.values_after_event(time, state, self._system_parameters, before, switch)
        if locator is None or np.array_equal(before, self.segments):
            return state
        self._correct_sample(time, before)
        return self._apply_jumps(time, state, before, self.segments)

    def _correct_sample(self, time: float, before: np.ndarray) -> None:
        """Correct a sample exactly at a breakpoint: it lacks the quadratures' gain, and outputs are evaluated on the right."""
        block = next((s for s in reversed(self.states) if s.shape[1]), None)
        at, locator = float(self.grid[self.done - 1]), self.compiled_system.locator
        if block is None or locator is None or not self._code.gain_count or abs(at - time) > 1e-12 * max(1.0, abs(time)):
            return
        state = self._convert_units(block[:, -1])
        segments = locator.right_values(at, state, self._system_parameters, self.segments)
        block[:, -1] = self._convert_units(self._apply_jumps(at, state, before, segments), back=True)

    def _apply_jumps(self, time: float, state: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Return the state with the gains of the quadratures from the change of segments."""
        if not self._code.gain_count:
            return state
        old, new = (
            self._code.instant.at(time, state, np.concatenate([self._system_parameters, segments]))[-self._code.gain_count :]
            for segments in (before, after)
        )
        n = len(self.compiled_system.system.states)
        return np.concatenate([state[:n], state[n:] + (new - old)])

    def record_failure(self, error: LegError) -> str:
        """Record the last samples of a failed leg; returns the sentence."""
        self._record(self.grid[self.done :], error.samples)
        time = self.time
        end_time = time if np.isfinite(time) else float(self.grid[max(0, self.done - 1)])
        last = next((block[:, -1] for block in reversed(self.states) if block.shape[1]), self.state)
        if error.step is not None:
            error.remedy = self._advice(error.step)
        return error.sentence(end_time, self.compiled_system.system.state_names, last)

    def _advice(self, step: float) -> str:
        """Return advice for the state in which steps ran out."""
        system, program, state = (
            self.compiled_system.system,
            self.compiled_system.engine.code.rates.program,
            self.integrator.state,
        )
        function, n = program.function("math"), len(system.states)
        constants = program.constant_values(np.concatenate([self._system_parameters, self.segments])).tolist()

        def rates(x: np.ndarray) -> Sequence[float]:
            derivatives: Sequence[float] = function([*x.tolist(), *state[n:].tolist()], self.time, constants)
            return derivatives[:n]

        try:
            return advice(rates, state[:n], [i for i, x in enumerate(system.states) if x in system.angles], step)
        except (OverflowError, ValueError, ZeroDivisionError):
            return UNKNOWN

    def trajectory(self, failure: str | None, is_interrupted: bool, is_sliding: bool) -> Trajectory:
        """Return the trajectory computed so far."""
        if not self.done:
            self.times, self.states = [self.grid[:1]], [self.state[:, None]]
        times, states = np.concatenate(self.times), np.concatenate(self.states, axis=1)
        n = len(self.compiled_system.system.states)
        # The motion since the last sample is discarded, so that a continued run keeps its even grid.
        at_sample = is_interrupted or failure is not None
        return Trajectory(
            times,
            states[:n],
            {q.name: states[n + i] for i, q in enumerate(self.compiled_system.system.quadratures)},
            self.sample_parameter_values if at_sample else self.parameter_values,
            float(times[-1]) if at_sample else self.time,
            states[:, -1] if at_sample else self._convert_units(self.integrator.state, back=True),
            tuple(self.hits),
            self.stopped_by,
            failure,
            is_interrupted,
            self.lowest_arguments,
            is_sliding,
        )


def integrate(
    compiled_system: CompiledSystem,
    initial: Sequence[float] | np.ndarray,
    parameters: Numbers | Mapping[str, float],
    grid: np.ndarray,
    progress: TimeCallback | None = None,
    unit: float = 1.0,
) -> Trajectory:
    """Integrate from ``grid[0]`` and sample at the grid's points.

    Parameters
    ----------
    compiled_system : CompiledSystem
        With n states and m quadratures.
    initial : array_like, (n,) or (n + m,)
        The state; with the quadratures' values appended to continue a run.
    parameters : sequence of float, or mapping by name
        Values in the System's order, in the units of its equations (SI).
    grid : ndarray, (N,)
        Increasing times.
    progress : callable, optional
        Called with the time reached.
    unit : float
        A typical size of the quadratures, for their accuracy.

    Returns
    -------
    Trajectory
        A run that fails, or is stopped by Ctrl-C, returns its samples so far, with ``failure`` or ``is_interrupted``. The same
        run gives the same numbers to the last bit.

    Raises
    ------
    RunError
        For an initial state that is not finite, or a grid that does not increase.
    """
    system = compiled_system.system
    parameter_values = np.array(system.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
    n, quadrature_count = len(system.states), len(system.quadratures)
    state = np.asarray(initial, dtype=float)
    if state.shape not in ((n,), (n + quadrature_count,)) or not np.isfinite(state).all():
        raise RunError(
            f"the initial state {state} must have {n} finite numbers, one for each of {', '.join(system.state_names)}",
            code="initial-state",
        )
    state = np.concatenate([state, np.zeros(n + quadrature_count - len(state))])
    grid = np.asarray(grid, dtype=float)
    if len(grid) < 1 or not (np.isfinite(grid).all() and (np.diff(grid) > 0).all()):
        raise RunError("the times at which to sample must increase, and be finite", code="not-increasing")
    # The unit is a power of two, so that a run which is continued has the same numbers to the last bit.
    run = Integration(
        compiled_system, compiled_system.engine.acquire(), state, parameter_values, grid, 2.0 ** round(math.log2(unit))
    )
    failure, is_interrupted, is_sliding = None, False, False
    try:
        run.start()
        more = True
        while more:
            more = run.advance()
            if progress:
                progress(run.time)
    except KeyboardInterrupt:
        is_interrupted = True
    except LegError as error:
        failure, is_sliding = run.record_failure(error), isinstance(error, SlidingError)
    trajectory = run.trajectory(failure, is_interrupted, is_sliding)
    if failure is None and not is_interrupted:  # else it may have stopped anywhere
        compiled_system.engine.release(run.integrator)
    return trajectory
