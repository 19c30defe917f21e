"""The engine heyoka: Taylor's method of high order, compiled by LLVM, with exact events.

F. Biscani, D. Izzo, "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
Monthly Notices of the Royal Astronomical Society 504 (2021) 2614-2628.
"""

from __future__ import annotations

import copy
import math
import pickle
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp

from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.events import NOT_FINITE, Event, Hit, LegError, LegResult
from wucht.numerics.flow.heyoka_compilation import EventKind, Recorder, compiled_integrator, constant_events, processor
from wucht.numerics.flow.program import Numbers, Program
from wucht.numerics.flow.step_sizes import step_limit_error
from wucht.system import TIME, System

_IDLE = 16  # idle integrators kept: more than threads that integrate the same equations at once
_ROUNDING = 1e-12  # of an event function: the sign of a smaller value is rounding
_JUST_BEFORE = 1e-3  # of a step
_SHORTER, _OTHER_STEPS = 0.37, 6  # times the longest step: so that its middle is elsewhere; number of attempts
_OTHER_ENGINE = 'Try study.engine = "scipy"'


# heyoka's steps are accurate relative to the largest state. An angle that integrates a speed is no measure of the size of a
# motion, and its accuracy is that of the speed: in so large a unit it does not loosen the tolerance, however far it has turned.
# A power of two, so that no number is rounded.
_ANGLE_UNIT = 2.0**20


def state_units(system: System) -> np.ndarray:
    """Return heyoka's unit of each state (n,) of a System: large for angles that integrate a given rate or one state."""
    # Definitions are not substituted: they are shared, and written out they may be exponentially long.
    definitions, states = dict(system.definitions), set(system.states)
    moving = {s: {s} for s in (*states, TIME)}
    for symbol, expression in system.definitions:
        moving[symbol] = set().union(*(moving.get(s, set()) for s in sp.sympify(expression).free_symbols))

    def integrates_a_speed(rate: sp.Expr) -> bool:
        """True if a rate is a function of time, or a constant times a state that is no angle."""
        while rate in definitions:
            rate = definitions[rate]
        sources = set().union(*(moving.get(s, set()) for s in rate.free_symbols)) - {TIME}
        if len(sources) != 1:
            return not sources
        (speed,) = sources
        return speed not in system.angles and not any(moving.get(s) for s in (rate / speed).free_symbols)

    large = [
        s in system.angles and integrates_a_speed(sp.sympify(r)) for s, r in zip(system.states, system.derivatives, strict=True)
    ]
    return np.where(large, _ANGLE_UNIT, 1.0)


def is_consistent(before: int, ways: Sequence[int], after: int) -> bool:
    """True if crossings (+1, -1 in order of time) lead from one sign of a function to another; 0: an unknown sign."""
    sign = before
    for way in ways:
        if way * sign > 0:
            return False
        sign = way
    return sign * after >= 0


class HeyokaEngine:
    """Compiled equations: an integrator that is copied for each run, and idle copies for the next one."""

    name = "heyoka"

    def __init__(
        self, program: Program, units: np.ndarray, events: Sequence[Event], event_program: Program, tolerance: float
    ) -> None:
        import heyoka as hy

        # Its log goes to stdout. Failures are reported as outcomes; its warnings of missed events are handled in ``leg``.
        hy.set_logger_level_critical()
        kinds, target = tuple(map(EventKind.of, events)), (hy.__version__, processor())
        constant = constant_events(event_program)
        self.program, self.event_program, self.units, self.events = program, event_program, units, tuple(events)
        self.interrupting = tuple(i for i, event in enumerate(events) if event.interrupts and i not in constant)
        self.event_values, self.rates = event_program.function("math"), program.at_point()
        self._idle: deque[HeyokaIntegrator] = deque(maxlen=_IDLE)
        self._original = pickle.loads(
            compiled_integrator(program, tuple(units.tolist()), kinds, event_program, tolerance, target)
        )

    def acquire(self) -> HeyokaIntegrator:
        """Lend an integrator to one run alone: to make one takes as long as a short run."""
        try:
            return self._idle.pop()
        except IndexError:
            return HeyokaIntegrator(self, copy.deepcopy(self._original))

    def release(self, integrator: HeyokaIntegrator) -> None:
        """Take an integrator back for the next run. ``start`` and ``forget_events`` clear the previous run."""
        self._idle.append(integrator)


class HeyokaIntegrator:
    """An integrator of one run. adaptive: heyoka's, not shared."""

    def __init__(self, engine: HeyokaEngine, adaptive: Any) -> None:
        import heyoka as hy

        self._engine, self._adaptive = engine, adaptive
        callbacks = [e.callback for e in adaptive.nt_events] if adaptive.with_events else []
        self._recorders = [c for c in callbacks if isinstance(c, Recorder)]
        self._parameters, self._event_constants = np.empty(0), list[float]()
        self._time_limit, self._bad_state = hy.taylor_outcome.time_limit, hy.taylor_outcome.err_nf_state

    def start(self, time: float, state: np.ndarray, parameter_values: Numbers) -> None:
        """Place the integrator. After an event's action the cool-down of the event is kept."""
        ta, engine = self._adaptive, self._engine
        ta.time = time
        ta.state[:] = state / engine.units
        if not np.array_equal(parameter_values, self._parameters):
            values = [
                *engine.program.constant_values(parameter_values),
                *engine.event_program.constant_values(parameter_values),
            ]
            ta.pars[:] = values[: len(ta.pars)]  # those of constant events come last
            self._parameters = np.array(parameter_values, float)
            self._event_constants = engine.event_program.constant_values(parameter_values).tolist()

    def forget_events(self) -> None:
        """Clear the cool-downs: another part of the run begins."""
        if self._engine.interrupting:
            self._adaptive.reset_cooldowns()

    def leg(self, grid: np.ndarray) -> LegResult:
        """Advance over the grid (m,).

        heyoka isolates the zeros of an event function within a step by halving it, and misses some where one lies exactly in
        the middle; where the events contradict the signs of their functions the leg is repeated with other steps.

        Raises ``LegError`` when the state ceases to be finite, steps run out, or events cannot be located.
        """
        if not self._engine.events:
            return self._advance(grid, math.inf)[0]
        ta, begin, state = self._adaptive, self.time, self._adaptive.state.copy()
        signs, longest = self._signs(begin, self.state), math.inf
        for _ in range(_OTHER_STEPS):
            leg, step = self._advance(grid, longest)
            if self._missed_event(signs, leg) is None:
                return leg
            longest = _SHORTER * step
            ta.time, ta.state[:] = begin, state
        name = self._engine.events[self._missed_event(signs, leg) or 0].name
        raise LegError(f"the event {name!r} cannot be located", _OTHER_ENGINE, leg.states[:, :0])

    def _missed_event(self, before: list[int], leg: LegResult) -> int | None:
        """Return the first event with missed crossings in a leg, by the signs of its function; None if there is none.

        before: those signs at the beginning of the leg. Crossings missed in pairs are not detected, nor those of an event that
        interrupts in one direction only, unless the function ends beyond zero.
        """
        after, events = self._signs(leg.time, leg.state), self._engine.events
        for recorder in self._recorders:
            if not is_consistent(before[recorder.index], [way for _, way in sorted(recorder.ways)], after[recorder.index]):
                return recorder.index
        for i in self._engine.interrupting:
            if i == leg.stopped_by:
                if events[i].direction == 0 and self._just_before(leg.time)[i] * before[i] < 0:
                    return i
            elif before[i] * after[i] < 0 and events[i].direction in (0, after[i]):
                return i
        return None

    def _signs(self, time: float, state: np.ndarray) -> list[int]:
        """Return the signs of all event functions; 0 where rounding decides."""
        values = self._engine.event_values(state.tolist(), time, self._event_constants)
        return [0 if abs(value) <= _ROUNDING else int(math.copysign(1, value)) for value in values]

    def _just_before(self, time: float) -> list[int]:
        """Return the signs a little before the end of the last step."""
        ta = self._adaptive
        earlier = time - _JUST_BEFORE * ta.last_h
        ta.update_d_output(earlier)
        return self._signs(earlier, self._engine.units * ta.d_output)

    def _advance(self, grid: np.ndarray, longest: float) -> tuple[LegResult, float]:
        """Integrate the leg in steps no longer than a limit; return also the longest step."""
        ta, interrupting, units = self._adaptive, self._engine.interrupting, self._engine.units
        for recorder in self._recorders:
            recorder.hits.clear()
            recorder.ways.clear()
        begin, ahead = float(ta.time), grid[0] > ta.time  # heyoka's grids begin at the integrator's time
        times = np.concatenate([[ta.time], grid]) if ahead else grid
        result = ta.propagate_grid(times, max_steps=step_sizes.MAX_STEPS, max_delta_t=longest)
        outcome, samples = result[0], units[:, None] * np.asarray(result[-1][int(ahead) :]).T.reshape(len(units), -1)
        hits = sorted((h for recorder in self._recorders for h in recorder.hits), key=lambda h: h.time)
        state = self.state
        stopped_by = None
        if outcome != self._time_limit:
            code = int(outcome)
            index = -code - 1 if -len(interrupting) <= code <= -1 else code
            if not 0 <= index < len(interrupting):
                raise (
                    LegError(*NOT_FINITE, samples) if outcome == self._bad_state else step_limit_error(samples, begin, ta.time)
                )
            stopped_by = interrupting[index]
            hits.append(Hit(self._engine.events[stopped_by].name, float(ta.time), state))
        mean = (float(ta.time) - begin) / max(
            int(result[3]), 1
        )  # a step that the grid cuts short does not count as the longest
        return LegResult(samples, float(ta.time), state, tuple(hits), stopped_by), max(float(result[2]), mean)

    @property
    def time(self) -> float:
        """Time reached."""
        return float(self._adaptive.time)

    @property
    def state(self) -> np.ndarray:
        """State reached, (n,)."""
        return np.asarray(self._engine.units * self._adaptive.state)
