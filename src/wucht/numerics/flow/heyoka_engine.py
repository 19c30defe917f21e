"""The engine heyoka: Taylor's method of high order, compiled by LLVM, with exact events.

F. Biscani, D. Izzo, "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
Monthly Notices of the Royal Astronomical Society 504 (2021) 2614-2628.
"""

from __future__ import annotations

import copy
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import RunError
from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.events import NOT_FINITE, Event, Hit, LegError, LegResult
from wucht.numerics.flow.program import Assignments, Numbers, Program
from wucht.numerics.flow.step_sizes import ignore_event, sentinels, step_limit_error
from wucht.system import TIME, System

# Above this many lines (five pendulums) LLVM's whole-function optimisation takes seconds; compact mode compiles loops instead,
# five times faster to compile and half as fast to run.
COMPACT_ABOVE = 80
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


class Translator:
    """SymPy expressions to heyoka's. Integer powers become products: ``x**n`` with n >= 3 gives NaN at x = 0 in heyoka."""

    def __init__(self, symbols: dict[sp.Symbol, Any]) -> None:
        import heyoka as hy

        self.hy = hy
        self.memo: dict[sp.Basic, Any] = dict(symbols)
        self.functions: dict[Any, Callable[..., Any]] = {
            sp.sin: hy.sin, sp.cos: hy.cos, sp.tan: hy.tan, sp.exp: hy.exp, sp.log: hy.log, sp.sinh: hy.sinh,
            sp.cosh: hy.cosh, sp.tanh: hy.tanh, sp.atan: hy.atan, sp.asin: hy.asin, sp.acos: hy.acos, sp.atan2: hy.atan2,
        }  # fmt: skip

    def __call__(self, e: sp.Expr) -> Any:
        """Translate an expression. Raises ``RunError`` for a function that heyoka does not have."""
        if e not in self.memo:
            self.memo[e] = self._translate(e)
        return self.memo[e]

    def program(self, lines: Assignments, results: Sequence[sp.Expr]) -> list[Any]:
        """Translate results that use lines before them."""
        for symbol, expression in lines:
            self.memo[symbol] = self(expression)
        return [self(r) for r in results]

    def _translate(self, e: sp.Expr) -> Any:
        if e.is_number:
            return self.hy.expression(float(e))
        if isinstance(e, sp.Add):
            return self.hy.sum([self(a) for a in e.args])
        if isinstance(e, sp.Mul):
            above, below = e.as_numer_denom() if any(a.is_Pow and a.exp.is_negative for a in e.args) else (e, sp.S.One)
            top = self.hy.prod([self(a) for a in above.args]) if isinstance(above, sp.Mul) else self(above)
            return top if below is sp.S.One else top / self(below)
        if isinstance(e, sp.Pow):
            return self._power(e)
        if e.func in self.functions:
            return self.functions[e.func](*(self(a) for a in e.args))
        raise RunError(f"heyoka has no function {e.func.__name__!r}; use the SciPy engine", code="no-function")

    def _power(self, e: sp.Pow) -> Any:
        base, exponent = self(e.base), e.exp
        if exponent == 2 and isinstance(e.base, sp.cos):  # the square of the sine occurs in most equations
            sine = self(sp.sin(e.base.args[0]))
            return 1.0 - sine * sine
        if exponent.is_Integer:
            product, square, n = None, base, int(abs(exponent))
            while n:
                if n & 1:
                    product = square if product is None else product * square
                square = square * square if n > 1 else square
                n >>= 1
            return product if exponent.is_positive else self.hy.expression(1.0) / product
        return self.hy.sqrt(base) if exponent == sp.Rational(1, 2) else base ** self(exponent)


def translation(program: Program, first: int = 0, units: np.ndarray | None = None) -> tuple[list[Any], Translator]:
    """Return heyoka's variables for a program's states, and the translator; constants are the parameters from ``first`` on.

    units: of the states (n,) in these variables; None: 1 each.
    """
    import heyoka as hy

    variables = [hy.make_vars(f"s{i}") for i in range(len(program.states))]
    unit_values = [1.0] * len(variables) if units is None else units.tolist()
    scaled_states = [v if unit == 1 else unit * v for v, unit in zip(variables, unit_values, strict=True)]
    symbols: dict[sp.Symbol, Any] = dict(zip(program.states, scaled_states, strict=True)) | {TIME: hy.time}
    return variables, Translator(symbols | {s: hy.par[first + i] for i, (s, _) in enumerate(program.constants)})


def taylor_equations(
    program: Program, variables: Sequence[Any], translate: Translator, units: np.ndarray
) -> list[tuple[Any, Any]]:
    """Pair each variable with its rate, in units (n,), as heyoka integrates them."""
    rates = translate.program(program.lines, program.results)
    return [(v, r if unit == 1 else r / unit) for v, r, unit in zip(variables, rates, units.tolist(), strict=True)]


@dataclass
class _Recorder:
    """Recorder of an event that does not interrupt. A copy of an integrator has a copy of it: nothing is shared.

    index: of the event. hits: in its direction. ways: +1, -1 of all crossings of the leg, as heyoka reports them.
    """

    index: int
    event: Event
    units: np.ndarray
    hits: list[Hit] = field(default_factory=list)
    ways: list[tuple[float, int]] = field(default_factory=list)

    def __call__(self, integrator: Any, time: float, way: int) -> None:
        self.ways.append((time, way))
        if self.event.direction in (0, way):
            integrator.update_d_output(time)
            self.hits.append(Hit(self.event.name, time, self.units * integrator.d_output))


def is_consistent(before: int, ways: Sequence[int], after: int) -> bool:
    """True if crossings (+1, -1 in order of time) lead from one sign of a function to another; 0: an unknown sign."""
    sign = before
    for way in ways:
        if way * sign > 0:
            return False
        sign = way
    return sign * after >= 0


class HeyokaEngine:
    """Compiled equations: an integrator that is copied for each run, and idle copies for the next one.

    LLVM's result is cached on disk by heyoka.
    """

    name = "heyoka"

    def __init__(
        self, program: Program, units: np.ndarray, events: Sequence[Event], event_program: Program, tolerance: float
    ) -> None:
        import heyoka as hy

        # Its log goes to stdout. Failures are reported as outcomes; its warnings of missed events are handled in ``leg``.
        hy.set_logger_level_critical()
        variables, translate = translation(program, units=units)
        _, translate_events = translation(event_program, len(program.constants), units)
        system = taylor_equations(program, variables, translate, units)
        functions = translate_events.program(event_program.lines, event_program.results)
        direction = {1: hy.event_direction.positive, -1: hy.event_direction.negative, 0: hy.event_direction.any}
        terminal, passing, interrupting = [], [], []
        constants = {s for s, _ in event_program.constants}
        for i, (event, function) in enumerate(zip(events, functions, strict=True)):
            if event_program.results[i].free_symbols <= constants:
                continue  # a constant function never passes zero, and heyoka refuses it as an event
            if event.interrupts:
                interrupting.append(i)
                # Beyond a breakpoint the event function is another: a second event may follow at once, as when a ball bounces.
                rest = {"cooldown": 0.0} if event.switch is not None else {}
                terminal.append(hy.t_event(function, direction=direction[event.direction], **rest))
            else:
                passing.append(hy.nt_event(function, callback=_Recorder(i, event, units)))
        passing += [hy.nt_event(f, callback=ignore_event) for f in sentinels(program, variables, translate)]
        extra = {"t_events": terminal} if terminal else {}
        extra |= {"nt_events": passing} if passing else {}
        self.program, self.event_program, self.units, self.events = program, event_program, units, tuple(events)
        self.interrupting, self.event_values = tuple(interrupting), event_program.function("math")
        self.rates = program.at_point()
        self._idle: deque[HeyokaIntegrator] = deque(maxlen=_IDLE)
        self._original = hy.taylor_adaptive(
            system, [0.0] * len(variables), tol=tolerance, compact_mode=len(program.lines) > COMPACT_ABOVE, **extra
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
        self._recorders = [c for c in callbacks if isinstance(c, _Recorder)]
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
