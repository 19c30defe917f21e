"""The implicit integrator, for stiff systems: SciPy's Radau on the right-hand side and the Jacobian in machine code.

E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", Springer 1996, section IV.8.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.cool_downs import CoolDowns
from wucht.numerics.flow.events import NOT_FINITE, Hit, LegError, LegResult
from wucht.numerics.flow.jacobian import Jacobian
from wucht.numerics.flow.program import Numbers
from wucht.numerics.flow.system_code import SystemCode

_NOT_ZERO = 1e-300
_SMALLEST_TOLERANCE = 1e-13  # SciPy refuses less than 100 units of rounding
_ABSOLUTE = 1e-2  # of the relative tolerance
_REMEDY = "Look for a parameter that is off by a factor of thousands, or try engine = 'compiled'"


class ImplicitIntegrator:
    """An integrator of one run. time, state (n,): the values reached. evaluation_count: of the rates in the last leg."""

    def __init__(self, code: SystemCode, jacobian: Jacobian, tolerance: float) -> None:
        self._code, self._jacobian, self._tolerance = code, jacobian, max(tolerance, _SMALLEST_TOLERANCE)
        self.time, self.state = 0.0, np.zeros(len(code.rates.program.states))
        self._cool_downs = CoolDowns(code.rates, code.event_values, code.events)
        self._parameters, self._constants, self._event_constants = np.empty(0), np.empty(0), np.empty(0)
        self.evaluation_count = 0

    def start(self, time: float, state: np.ndarray, parameter_values: Numbers) -> None:
        """Place the integrator."""
        self.time, self.state, self._parameters = time, np.array(state, dtype=float), np.array(parameter_values, float)
        self._constants = self._code.rates.program.constant_values(parameter_values)
        self._event_constants = self._code.event_values.program.constant_values(parameter_values)
        self._cool_downs.start(time, self.state, self._constants, self._event_constants)

    def forget_events(self) -> None:
        """Clear the cool-downs: another part of the run begins."""
        self._cool_downs.clear()

    def _event_function(self, index: int) -> Callable[[float, np.ndarray], float]:
        event = self._code.events[index]
        # SciPy evaluates the ends of a step twice, by the state and by interpolation: within rounding of zero signs may differ.
        first_values: dict[float, float] = {}

        def function(t: float, y: np.ndarray) -> float:
            if t not in first_values:
                first_values[t] = evaluate(t, y)
            return first_values[t]

        def evaluate(t: float, y: np.ndarray) -> float:
            value = float(self._code.event_values(y, t, self._event_constants)[index])
            end, sign = self._cool_downs.by_event.get(index, (-np.inf, 0.0))
            # Just after an event its function is rounding noise around zero, which must not count as another event.
            if t <= end:
                return (sign or -event.direction) * (abs(value) + _NOT_ZERO)
            # SciPy takes a function that stays exactly zero for one that goes through zero at every step.
            return value or -event.direction * _NOT_ZERO

        function.terminal = event.interrupts  # type: ignore[attr-defined]
        function.direction = event.direction  # type: ignore[attr-defined]
        return function

    def _rates(self, t: float, y: np.ndarray) -> np.ndarray:
        self.evaluation_count += 1
        if self.evaluation_count > step_sizes.MAX_STEPS:
            self.time = t
            reason = f"{step_sizes.MAX_STEPS} evaluations of the rates were not enough for one leg"
            raise LegError(reason, _REMEDY, np.empty((len(y), 0)))
        return np.array(self._code.rates(y, t, self._constants))

    def _rate_changes(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the Jacobian of the rates (n, n)."""
        return self._jacobian.values_at(y, self._parameters, t)[1]

    def leg(self, grid: np.ndarray) -> LegResult:
        """Advance over the grid (m,). Raises ``LegError`` when the integration fails."""
        from scipy.integrate import solve_ivp

        functions, self.evaluation_count = [self._event_function(i) for i in range(len(self._code.events))], 0
        end = float(grid[-1])
        if end <= self.time:
            return LegResult(np.tile(self.state, (len(grid), 1)).T, self.time, self.state, (), None)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                solution = solve_ivp(
                    self._rates,
                    (self.time, end),
                    self.state,
                    method="Radau",
                    t_eval=grid,
                    events=functions or None,
                    jac=self._rate_changes,
                    rtol=self._tolerance,
                    atol=self._tolerance * _ABSOLUTE,
                )
        except ValueError as error:
            if "infs or NaNs" not in str(error):  # of linear algebra, where a number is not finite
                raise
            raise LegError(NOT_FINITE[0], _REMEDY, np.empty((len(self.state), 0))) from error
        # Without samples before an event, SciPy returns a list instead of an (n, 0) array.
        samples = np.asarray(solution.y).reshape(len(self.state), -1)
        if solution.status < 0 or not np.isfinite(samples).all():
            self.time = float(solution.t[-1]) if len(solution.t) else self.time
            self.state = samples[:, -1] if samples.size else self.state
            reason = str(solution.message).rstrip(".") if solution.status < 0 else NOT_FINITE[0]
            raise LegError(reason, _REMEDY, samples[:, np.isfinite(samples).all(axis=0)])
        hits, stopped_by = [], None
        for i, event in enumerate(self._code.events):
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
