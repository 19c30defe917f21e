"""Laws by which a period grows without bound near a critical parameter value, fitted to the last orbits of a branch.

At a saddle-node on the orbit T = C/sqrt(mu) + c, at a connection of saddles T = -ln(mu)/lambda + c, with mu = |p - p*|.
S. H. Strogatz, "Nonlinear Dynamics and Chaos", Perseus 1994, section 8.4; Yu. A. Kuznetsov, "Elements of Applied Bifurcation
Theory", Springer 2004, sections 6.2 and 7.1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

SADDLE_NODE, CONNECTION = "saddle-node", "connection"
_SHAPES: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    SADDLE_NODE: lambda mu: mu**-0.5,
    CONNECTION: lambda mu: -np.log(mu),
}
_RESOLUTIONS = (1e-9, 1e-8, 1e-7)  # of the parameter's size: nearer to its last value orbits are not distinguished
_PRECISION = 1e-11  # of the parameter: accuracy of orbits
_LATE = 1e-6  # of the parameter's size: orbits so near to the end scatter about p*
_WINDOWS = (1.15, 1.3, 1.6, 2.0, 3.0)  # growth of the period over the fitted orbits
_FEWEST = 6  # orbits
_NEAREST, _FARTHEST, _PLACES = 1e-12, 1e3, 120  # of the window's width: range beyond the last orbit in which p* is searched


@dataclass(frozen=True)
class PeriodLaw:
    """Law fitted to some orbits. critical: p*. error: estimate for p*, from its changes with the fitted orbits.
    factor: C, or 1/lambda. residual: root mean square deviation of the periods from the law, over the range of these
    periods.
    """

    name: str
    critical: float
    error: float
    factor: float
    residual: float


def better_law(laws: Iterable[PeriodLaw]) -> PeriodLaw:
    """Return the law with the smaller residual."""
    return min(laws, key=lambda law: law.residual)


def laws_of_growth(values: np.ndarray, periods: np.ndarray) -> tuple[PeriodLaw, PeriodLaw] | None:
    """Fit the laws by which the periods (N,) grow at the end of a branch, given the parameter's values (N,).

    The first law is that of a saddle-node, the second that of a connection. They are fitted to the last orbits that differ from
    the very last one by more than rounding, over which the period grows by a factor: that at which one of the laws fits best.
    None where there are too few.
    """
    apart, size = np.abs(values - values[-1]), float(max(np.abs(values).max(), np.ptp(values)))
    monotone = np.empty(0, int)
    for resolution in _RESOLUTIONS:
        distinct = np.flatnonzero(apart > resolution * size)
        falls = np.flatnonzero((np.diff(periods) <= 0) | (np.diff(apart) >= 0)) if len(distinct) else np.empty(0, int)
        monotone = distinct[distinct > falls[falls < distinct[-1]].max(initial=-1)] if len(distinct) else distinct
        if len(monotone) >= _FEWEST:
            break
    if not len(monotone):
        return None
    scatter = float(apart[monotone[-1] + 1 :].max(initial=0.0)) if apart[monotone[-1]] < _LATE * size else 0.0
    windows = [monotone[periods[monotone] >= periods[monotone[-1]] / factor] for factor in _WINDOWS]
    last = float(values[-1])
    fits = [[_law(name, values[w], periods[w], last) for name in _SHAPES] for w in windows if len(w) >= _FEWEST]
    if not fits:
        return None
    best = min(fits, key=lambda laws: better_law(laws).residual)

    def with_error(k: int) -> PeriodLaw:
        distances = (abs(laws[k].critical - best[k].critical) for laws in fits)
        return replace(best[k], error=max(_PRECISION * size, scatter, *distances))

    return with_error(0), with_error(1)


def _law(name: str, values: np.ndarray, periods: np.ndarray, last: float) -> PeriodLaw:
    """Return the best fit of a law."""
    from scipy.optimize import minimize_scalar

    away, sense, shape = np.abs(last - values), math.copysign(1.0, last - values[0]), _SHAPES[name]
    width, range_ = float(away.max()), float(np.ptp(periods))

    def fit(beyond: float) -> tuple[float, float]:
        columns = np.column_stack([shape(away + beyond), np.ones_like(away)])
        size = np.linalg.norm(columns, axis=0)
        share = np.linalg.lstsq(columns / size, periods, rcond=None)[0]
        off = columns / size @ share - periods
        return float(share[0] / size[0]), math.sqrt(float(off @ off) / len(off)) / range_

    places = np.log(np.geomspace(_NEAREST, _FARTHEST, _PLACES) * width)
    least = int(np.argmin([fit(math.exp(x))[1] for x in places]))
    around = places[max(least - 1, 0)], places[min(least + 1, _PLACES - 1)]
    best = minimize_scalar(lambda x: fit(math.exp(x))[1], bounds=around, method="bounded", options={"xatol": 1e-12})
    beyond = math.exp(best.x)
    factor, residual = fit(beyond)
    return PeriodLaw(name, last + sense * beyond, math.nan, factor, residual)
