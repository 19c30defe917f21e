"""Error bounds of averaging x' = epsilon X(x, t): the numbers of 002 (3.7), (3.8) and (3.11)-(3.13).

Suprema over a box of states are taken over a grid in it, its faces and corners included: they approach the true ones from below
as the grid is refined. (3.13) as printed holds at whole periods; within one, the integral of X - <X> over the part of the
period is missing (x' = epsilon cos t has lambda = 0 and yet an error epsilon sin t). ``error_bound`` adds it, delta(epsilon).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.program import Evaluator
from wucht.system import System

Box = Mapping[str, tuple[float, float]]
_STEPS_A_UNIT = 128


@dataclass(frozen=True)
class AveragingError:
    """Error estimates over a box of states. All norms are Euclidean.

    epsilon: the small parameter. bound_of_rate: M, sup |X| (3.7). lipschitz: lambda, sup |dX/dx| (3.8), spectral norm.
    delta: (3.12). period: T, or None where X is not periodic.
    """

    epsilon: float
    bound_of_rate: float
    lipschitz: float
    delta: float
    period: float | None

    @property
    def order(self) -> float:
        """Order delta^(1/2) of the error over times 1/epsilon for any X with a mean (3.11)."""
        return math.sqrt(self.delta)

    def periodic_bound(self, time: np.ndarray | float) -> np.ndarray:
        """Evaluate (3.13) as printed, 2 lambda M epsilon^2 T^2 (N + 1) exp(epsilon lambda t), N T <= t < (N + 1) T.

        It is right at t = N T.

        time: since the start, any shape. Raises ``WuchtError`` where X has no period.
        """
        if self.period is None:
            raise WuchtError("the bound (3.13) holds for periodic right-hand sides: this one has no period", code="no-period")
        t, e = np.asarray(time, float), self.epsilon
        whole = np.floor(t / self.period * (1 + 1e-12)) + 1  # a time N T that is rounded down still counts as the N-th
        error_bound = 2 * self.lipschitz * self.bound_of_rate * (e * self.period) ** 2 * whole * np.exp(e * self.lipschitz * t)
        return np.asarray(error_bound)

    def error_bound(self, time: np.ndarray | float) -> np.ndarray:
        """Return a bound of |x - y| at any time since a common start (any shape): (3.13) plus delta exp(epsilon lambda t)."""
        growth = self.delta * np.exp(self.epsilon * self.lipschitz * np.asarray(time, float))
        return np.asarray(self.periodic_bound(time) + growth)


def averaging_error(
    system: System,
    slow: System,
    small: str,
    values: Mapping[str, float],
    box: Box,
    period: float | None = None,
    length: float = 1.0,
    points: int = 5,
    steps: int | None = None,
) -> AveragingError:
    """Evaluate M, lambda and delta(epsilon) of a System in standard form and its averaged System.

    small: the name of epsilon among the parameters. values: of all parameters, by name. box: lowest and highest value of each
    state, by name. period: T in the unit of time, where there is one. length: L, the times are up to L/epsilon (without a
    period). points: grid points along each state. steps: in time, by default 128 per period or unit of time.

    Raises ``WuchtError`` for a parameter or state without a value, for an epsilon, period, length, number of points or of steps
    that is not positive, and where the right-hand side is not finite.
    """
    for name, value in (("period", period), ("length", length), ("points", points), ("steps", steps)):
        if value is not None and not (value > 0 and math.isfinite(value)):
            raise WuchtError(f"the {name} must be positive and finite, not {value}", code="period")
    parameters = system.values(values)
    missing = [s for s in system.state_names if s not in box]
    if missing:
        raise WuchtError(f"the box of states has no limits for {', '.join(missing)}", code="no-limits")
    if small not in system.parameter_names or not values[small] > 0:
        raise WuchtError(f"the small parameter {small} must be a parameter of the System and positive", code="epsilon")
    epsilon, limits = float(values[small]), [box[name] for name in system.state_names]
    axes = [np.linspace(low, high, points).tolist() if low != high else [float(low)] for low, high in limits]
    end = period if period is not None else length / epsilon
    count = 2 * math.ceil((steps or (_STEPS_A_UNIT if period is not None else math.ceil(_STEPS_A_UNIT * end))) / 2)
    time = np.linspace(0.0, end, count + 1)
    n = len(system.states)
    rates = [sp.sympify(system.explicit(f)) for f in system.derivatives]
    jacobian = [sp.diff(f, s) for f in rates for s in system.states]
    rate, slope = (Evaluator.of(system, e, [str(k) for k in range(len(e))]) for e in (rates, jacobian))
    mean, slow_values = Evaluator.of_rates(slow), slow.values(values)
    largest = steepest = furthest = 0.0
    for state in itertools.product(*axes):
        at = time, np.repeat(np.array(state)[:, None], len(time), axis=1)
        with np.errstate(all="ignore"):  # values that are not finite are reported below
            X = rate.array(*at, parameters) / epsilon
            J = slope.array(*at, parameters).reshape(n, n, -1) / epsilon
            difference = X - mean.array(*at, slow_values) / epsilon
        if not (np.isfinite(J).all() and np.isfinite(difference).all()):
            raise WuchtError(
                f"the right-hand side is not finite at {dict(zip(system.state_names, state, strict=True))}, in the box",
                code="not-finite",
            )
        largest = max(largest, float(np.linalg.norm(X, axis=0).max()))
        steepest = max(steepest, float(np.linalg.norm(J, 2, axis=(0, 1)).max()))
        furthest = max(furthest, float(np.linalg.norm(_integral(difference, time), axis=0).max()))
    return AveragingError(epsilon, largest, steepest, epsilon * furthest, period)


def _integral(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integrate from 0 to every second time by Simpson's rule. values: (n, N + 1), N even. Returns (n, N/2 + 1)."""
    h = time[1] - time[0]
    parts = h / 3 * (values[:, :-2:2] + 4 * values[:, 1:-1:2] + values[:, 2::2])
    return np.concatenate([np.zeros((len(values), 1)), np.cumsum(parts, axis=1)], axis=1)
