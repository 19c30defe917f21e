"""The damping between oscillation and creep: 000, section 6. Small damping lets bodies swing about their places for long, great
damping lets them creep there; between them lies the damping with which they are in place soonest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.balancers.candidates import CAPTURE, SETTLING, Evaluated, Trials
from wucht.dynamics.balancers.compensated_states import decay_rate, states_at_speed
from wucht.errors import InputError


@dataclass(frozen=True)
class Rates:
    """The slowest rate (N,) at which small deviations decay (linearised averaged equations), and where it is greatest."""

    each: np.ndarray
    greatest_at: float


@dataclass(frozen=True)
class DampingCurve:
    """Over the damping (N,) of the bodies: after which time half of the runs are in place, the share of those that get through,
    and the slowest rate at which small deviations decay. optimum: the damping of the shortest settling time; of_rates: that of
    the greatest rate."""

    damping: np.ndarray
    settling_time: np.ndarray
    through: np.ndarray
    rate: np.ndarray
    optimum: float
    of_rates: float


def damping_curve(dampings: np.ndarray, seen: Evaluated, rates: Rates) -> DampingCurve:
    """From the runs of a machine with the dampings (N,), and its rates."""
    settling, through = seen.objectives[:, SETTLING], 1 - seen.objectives[:, CAPTURE]
    # Times of few runs that get through say little.
    most = np.where(through >= through.max(), settling, np.nan)
    optimum = float(dampings[np.nanargmin(most)]) if np.isfinite(most).any() else np.nan
    return DampingCurve(dampings, settling, through, rates.each, optimum, rates.greatest_at)


def rates_of(trials: Trials, dampings: np.ndarray) -> Rates:
    """Of a machine with the dampings (N,), which the only variable of ``trials`` is; nan without averaged equations."""

    try:
        states = states_at_speed(trials.machine)
    except InputError:
        return Rates(np.full(len(dampings), np.nan), np.nan)

    def rate(damping: float) -> float:
        return decay_rate(trials.of([damping]), states)

    rates = np.array([rate(b) for b in dampings.tolist()])
    return Rates(rates, _greatest(rate, dampings, rates))


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
