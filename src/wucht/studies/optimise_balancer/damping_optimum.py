"""The damping between oscillation and creep: 000, section 6. Small damping lets bodies swing about their places for long, great
damping lets them creep there; between them lies the damping with which they are in place soonest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.studies.optimise_balancer.candidates import Evaluated, Trials, evaluated
from wucht.studies.optimise_balancer.standing_states import decay_rate


@dataclass(frozen=True)
class DampingCurve:
    """Over the damping (N,) of the bodies: the mean settling time of the runs that end well, the share of those that do, and
    the slowest rate at which small deviations decay (linearised averaged equations). optimum: the damping of the shortest
    settling time; of_rates: that of the greatest rate."""

    damping: np.ndarray
    settling_time: np.ndarray
    well: np.ndarray
    rate: np.ndarray
    optimum: float
    of_rates: float


def damping_curve(trials: Trials, dampings: np.ndarray, slow: bool, report: Callable[[float], None]) -> DampingCurve:
    """Of a machine with the dampings (N,), which the only variable of ``trials`` is."""
    seen: Evaluated = evaluated(trials, "slow" if slow else "full", dampings[:, None], report)
    settling, well = seen.objectives[:, 0], 1 - seen.objectives[:, 3]

    def rate(damping: float) -> float:
        return decay_rate(trials.of([damping])) if slow else np.nan

    rates = np.array([rate(b) for b in dampings.tolist()])
    # Times of few runs that end well say little.
    most = np.where(well >= well.max(), settling, np.nan)
    optimum = float(dampings[np.nanargmin(most)]) if np.isfinite(most).any() else np.nan
    return DampingCurve(dampings, settling, well, rates, optimum, _greatest(rate, dampings, rates))


def _greatest(rate: Callable[[float], float], dampings: np.ndarray, rates: np.ndarray) -> float:
    """The damping of the greatest rate: the curve has a corner there, so that it is found by halving."""
    from scipy.optimize import minimize_scalar

    if not np.isfinite(rates).any():
        return np.nan
    k = int(np.nanargmax(rates))
    if k in (0, len(rates) - 1):
        return float(dampings[k])
    ends = np.log(dampings[[k - 1, k + 1]])
    found = minimize_scalar(lambda x: -rate(float(np.exp(x))), bounds=tuple(ends), method="bounded", options={"xatol": 1e-3})
    return float(np.exp(found.x))
