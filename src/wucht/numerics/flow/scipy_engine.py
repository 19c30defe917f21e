"""The engine SciPy: Dormand-Prince 8(5,3) or Radau on an interpreted right-hand side.

It serves where heyoka and LLVM are absent, and as the independent witness in tests.
E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, section II.10.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from wucht.numerics.flow.cool_downs import CoolDowns
from wucht.numerics.flow.events import NOT_FINITE, Event, Hit, LegError, LegResult
from wucht.numerics.flow.program import Numbers, Program

_NOT_ZERO = 1e-300
_SMALLEST_TOLERANCE = 1e-13  # solve_ivp refuses less than 100 units of rounding
_REMEDY = "Look for a parameter that is off by a factor of thousands, or try another engine"


class ScipyEngine:
    """Compiled equations for SciPy's integrators, with the interface of the engine heyoka."""

    name = "scipy"

    def __init__(
        self, program: Program, events: Sequence[Event], event_program: Program, tolerance: float, method: str
    ) -> None:
        self.program, self.event_program, self.events = program, event_program, tuple(events)
        self.tolerance, self.method = max(tolerance, _SMALLEST_TOLERANCE), method
        self.rates, self.event_values = program.at_point(), event_program.at_point()
        self.rhs, self.event_functions = program.function("math"), event_program.function("math")

    def acquire(self) -> ScipyIntegrator:
        """Return a new integrator, which costs nothing."""
        return ScipyIntegrator(self)

    def release(self, integrator: ScipyIntegrator) -> None:
        """Take an integrator back: it is not reused."""


class ScipyIntegrator:
    """An integrator of one run. time, state (n,): the values reached."""

    def __init__(self, engine: ScipyEngine) -> None:
        self._engine, self._rhs, self._event_values, self._events = engine, engine.rhs, engine.event_functions, engine.events
        self.time, self.state = 0.0, np.zeros(len(engine.program.states))
        self._cool_downs = CoolDowns(engine.rates, engine.event_values, engine.events)

    def start(self, time: float, state: np.ndarray, parameter_values: Numbers) -> None:
        """Place the integrator."""
        self.time, self.state = time, np.array(state, dtype=float)
        programs = self._engine.program, self._engine.event_program
        constants = [program.constant_values(parameter_values) for program in programs]
        self._constants, self._event_constants = (values.tolist() for values in constants)
        self._cool_downs.start(time, self.state, *constants)

    def forget_events(self) -> None:
        """Clear the cool-downs: another part of the run begins."""
        self._cool_downs.clear()

    def _event_function(self, index: int) -> Callable[[float, np.ndarray], float]:
        event, event_values = self._events[index], self._event_values

        def function(t: float, y: np.ndarray) -> float:
            value = float(event_values(y.tolist(), t, self._event_constants)[index])
            end, sign = self._cool_downs.by_event.get(index, (-np.inf, 0.0))
            # Just after an event its function is rounding noise around zero, which must not count as another event.
            if t <= end:
                return (sign or -event.direction) * (abs(value) + _NOT_ZERO)
            # SciPy takes a function that stays exactly zero for one that goes through zero at every step.
            return value or -event.direction * _NOT_ZERO

        function.terminal = event.interrupts  # type: ignore[attr-defined]
        function.direction = event.direction  # type: ignore[attr-defined]
        return function

    def _rates(self, t: float, y: np.ndarray) -> Sequence[float]:
        try:
            rates: Sequence[float] = self._rhs(y.tolist(), t, self._constants)
        except (OverflowError, ValueError, ZeroDivisionError):  # with NaN SciPy would search for a step forever
            raise LegError(NOT_FINITE[0], _REMEDY, np.empty((len(y), 0))) from None
        return rates

    def leg(self, grid: np.ndarray) -> LegResult:
        """Advance over the grid (m,). Raises ``LegError`` when the integration fails."""
        from scipy.integrate import solve_ivp

        functions = [self._event_function(i) for i in range(len(self._events))]
        end = float(grid[-1])
        if end <= self.time:
            return LegResult(np.tile(self.state, (len(grid), 1)).T, self.time, self.state, (), None)
        solution = solve_ivp(
            self._rates,
            (self.time, end),
            self.state,
            method=self._engine.method,
            t_eval=grid,
            events=functions or None,
            rtol=self._engine.tolerance,
            atol=self._engine.tolerance * 1e-2,
        )
        # Without samples before an event, SciPy returns a list instead of an (n, 0) array.
        samples = np.asarray(solution.y).reshape(len(self.state), -1)
        if solution.status < 0 or not np.isfinite(samples).all():
            self.time = float(solution.t[-1]) if len(solution.t) else self.time
            self.state = samples[:, -1] if samples.size else self.state
            reason = str(solution.message).rstrip(".") if solution.status < 0 else NOT_FINITE[0]
            raise LegError(reason, _REMEDY, samples[:, np.isfinite(samples).all(axis=0)])
        hits, stopped_by = [], None
        for i, event in enumerate(self._events):
            for t, y in zip(solution.t_events[i], solution.y_events[i], strict=True):
                hits.append(Hit(event.name, float(t), np.array(y)))
                if event.interrupts:
                    stopped_by = i
        hits.sort(key=lambda h: h.time)
        if stopped_by is None:
            self.time, self.state = end, samples[:, -1]
        else:
            self.time, self.state = hits[-1].time, hits[-1].state
            self._cool_downs.add(stopped_by, self.time, self.state)
        return LegResult(samples, self.time, np.array(self.state), tuple(hits), stopped_by)
