"""The engine heyoka: Taylor's method of high order, compiled by LLVM, with exact events.

F. Biscani, D. Izzo, "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
Monthly Notices of the Royal Astronomical Society 504 (2021) 2614-2628.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import RunError
from wucht.numerics.events import Event, Hit, Leg, LegError
from wucht.numerics.program import Numbers, Program
from wucht.system import TIME

# Above this many lines (five pendulums) LLVM's whole-function optimisation takes seconds; compact mode compiles loops instead,
# five times faster to compile and half as fast to run.
_COMPACT_ABOVE = 80
_MAX_STEPS = 500_000  # a leg: a hundred times what a leg of an ordinary machine takes


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
        """Translate. Raises ``RunError`` for a function that heyoka does not have."""
        if e not in self.memo:
            self.memo[e] = self._translate(e)
        return self.memo[e]

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
        raise RunError(f"heyoka has no function {e.func.__name__!r}; use the SciPy engine")

    def _power(self, e: sp.Pow) -> Any:
        base, exponent = self(e.base), e.exp
        if exponent.is_Integer:
            n = int(abs(exponent))
            product, square = None, base
            while n:
                if n & 1:
                    product = square if product is None else product * square
                square = square * square if n > 1 else square
                n >>= 1
            return product if exponent.is_positive else self.hy.expression(1.0) / product
        if exponent == sp.Rational(1, 2):
            return self.hy.sqrt(base)
        return base ** self(exponent)


class HeyokaEngine:
    """A compiled flow. The integrator is built on the first run; LLVM's result is cached on disk by heyoka."""

    name = "heyoka"

    def __init__(self, program: Program, events: Sequence[Event], event_program: Program, tolerance: float) -> None:
        import heyoka as hy

        hy.set_logger_level_critical()  # what it has to say would stand on stdout; failures are told by outcomes
        n_own = len(program.constants)
        variables = hy.make_vars(*(f"s{i}" for i in range(len(program.states)))) if program.states else []
        variables = variables if isinstance(variables, list) else [variables]
        symbols: dict[sp.Symbol, Any] = dict(zip(program.states, variables, strict=True))
        symbols[TIME] = hy.time
        translate = Translator(symbols | {s: hy.par[i] for i, (s, _) in enumerate(program.constants)})
        for symbol, expression in program.lines:
            translate.memo[symbol] = translate(expression)
        system = list(zip(variables, (translate(r) for r in program.results), strict=True))
        watch = Translator(symbols | {s: hy.par[n_own + i] for i, (s, _) in enumerate(event_program.constants)})
        for symbol, expression in event_program.lines:
            watch.memo[symbol] = watch(expression)
        self._program, self._event_program, self._events = program, event_program, tuple(events)
        self._hits: list[Hit] = []
        direction = {1: hy.event_direction.positive, -1: hy.event_direction.negative, 0: hy.event_direction.any}
        terminal, passing = [], []
        self._terminal = []
        constants = {s for s, _ in event_program.constants}
        for i, (event, result) in enumerate(zip(events, event_program.results, strict=True)):
            if result.free_symbols <= constants:
                continue  # what does not change never goes through zero, and heyoka refuses to watch it
            function = watch(result)
            if event.interrupts:
                self._terminal.append(i)
                # At a corner another function is watched from then on: a second one may follow at once, as when a ball bounces.
                rest = {"cooldown": 0.0} if event.switch is not None else {}
                terminal.append(hy.t_event(function, direction=direction[event.direction], **rest))
            else:
                passing.append(hy.nt_event(function, callback=self._note(i), direction=direction[event.direction]))
        extra = {"t_events": terminal} if terminal else {}
        extra |= {"nt_events": passing} if passing else {}
        self._integrator = hy.taylor_adaptive(
            system,
            [0.0] * len(variables),
            tol=tolerance,
            compact_mode=len(program.lines) > _COMPACT_ABOVE,
            **extra,
        )
        self._reached, self._bad_state = hy.taylor_outcome.time_limit, hy.taylor_outcome.err_nf_state

    def _note(self, index: int) -> Callable[[Any, float, int], None]:
        hits, name = self._hits, self._events[index].name

        def callback(integrator: Any, time: float, _sign: int) -> None:
            integrator.update_d_output(time)
            hits.append(Hit(name, time, np.array(integrator.d_output)))

        return callback

    def start(self, time: float, state: np.ndarray, parameters: Numbers) -> None:
        """Place the integrator. After an event's action the cool-down of the event is kept."""
        ta = self._integrator
        ta.time = time
        ta.state[:] = state
        values = [*self._program.constant_values(parameters), *self._event_program.constant_values(parameters)]
        ta.pars[:] = values[: len(ta.pars)]  # those of events that are not watched come last

    def forget_events(self) -> None:
        """Clear the cool-downs: a new run begins."""
        if self._terminal:
            self._integrator.reset_cooldowns()

    def leg(self, grid: np.ndarray) -> Leg:
        """Advance over the grid (m,). Raises ``LegError`` when the state ceases to be finite or steps run out."""
        ta = self._integrator
        self._hits.clear()
        ahead = grid[0] > ta.time  # heyoka's grids begin at the integrator's own time
        result = ta.propagate_grid(np.concatenate([[ta.time], grid]) if ahead else grid, max_steps=_MAX_STEPS)
        outcome, samples = result[0], result[-1][int(ahead) :]
        hits = list(self._hits)
        state = np.array(ta.state)
        stopped_by = None
        if outcome != self._reached:
            code = int(outcome)
            index = -code - 1 if -len(self._terminal) <= code <= -1 else code
            if not 0 <= index < len(self._terminal):
                raise self._failed(outcome == self._bad_state, np.asarray(samples).T.reshape(len(state), -1))
            stopped_by = self._terminal[index]
            hits.append(Hit(self._events[stopped_by].name, float(ta.time), state))
        return Leg(np.asarray(samples).T.reshape(len(state), -1), float(ta.time), state, tuple(hits), stopped_by)

    @staticmethod
    def _failed(not_finite: bool, samples: np.ndarray) -> LegError:
        if not_finite:
            return LegError(
                "the state ceases to be finite", samples, "Look for a parameter that is off by a factor of thousands"
            )
        return LegError(
            f"{_MAX_STEPS} steps were not enough for one leg",
            samples,
            "The machine is stiff: try engine = 'scipy-radau', or look for a parameter that is off by a factor of thousands",
        )

    @property
    def time(self) -> float:
        """The time reached."""
        return float(self._integrator.time)

    @property
    def state(self) -> np.ndarray:
        """The state reached, (n,)."""
        return np.array(self._integrator.state)
