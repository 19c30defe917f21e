"""Ends of branches of periodic orbits: a Hopf point, a saddle-node on the orbit, a saddle connection, or a limit.

Two things have to agree. The law by which the period grows (``period_laws``), and the equilibrium that the orbit approaches,
computed from where the last orbit is slowest: at a saddle-node on the orbit it has a fold at the law's p*; at a connection it
is a hyperbolic saddle, one of whose eigenvalues next to zero is the law's lambda.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import CURVE_IS_CLOSED as CURVE_CLOSED
from wucht.numerics.continuation.equilibria import FOLD, Equilibrium
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.hopf_ends import SHRINKS, equilibria_of, hopf_point, nearest_special
from wucht.numerics.periodic.period_laws import CONNECTION, SADDLE_NODE, PeriodLaw, better_law, laws_of_growth
from wucht.numerics.zeros_and_peaks import stretches

SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION, HOPF = "saddle-node-on-orbit", "saddle-connection", "hopf"
RANGE, CLOSED_BRANCH, PERIOD_LIMIT, NOT_IDENTIFIED = "range", "closed", "period-limit", "not-identified"

_FITS = {SADDLE_NODE: 1e-3, CONNECTION: 1e-2}  # largest residual of a law that holds
_BETTER = 3.0  # least ratio of the residual of the other law
_GROWN = 1.5  # times the shortest period of the branch: less growth is no growth without bound
_SLOW, _DWELLS = 0.05, 0.05  # of the highest speed along the orbit: slow; of the period: least share of a place where it stays
_NEAR = 0.5  # of the orbit's size: largest distance of the equilibrium from the slowest place
_AGREE_CRITICAL = 0.05  # of the last orbit's distance from p*
_AGREE_RATE = 0.1  # relative: where nu is small, lambda is approached as slowly as |p - p*|^nu
_GROWN_AT_REST = 1.3  # least factor by which the period grows while the parameter no longer changes
_RESOLUTION, _FEWEST = 1e-8, 6  # of the parameter's size: a smaller change is none; orbits
_AROUND = 0.1  # of the orbit's size: near a saddle
_APPROACH = 3.0  # least number of e-folds by which an orbit comes nearer to a saddle than that
_ALL_AT_SADDLES = 0.02  # of the growth of the period: largest share elsewhere
_FINE = 20  # places of an interval, by which the time near a saddle is measured
_AT_A_BOUND = 1e-9  # relative
_ERRORS = 10.0  # times the error of the fit: smaller differences do not count
_IN_A_SUBSPACE = 1e-6  # relative: smaller components do not count
_ROUNDING = 1e-12  # of the range: smaller values of the parameter are the rounding errors of 0


@dataclass(frozen=True)
class BranchEnd:
    """End of a branch of periodic orbits.

    Attributes
    ----------
    kind : str
        ``"saddle-node-on-orbit"``, ``"saddle-connection"``, ``"hopf"``, ``"range"`` (of the parameter), ``"closed"``,
        ``"period-limit"`` (of the periods that are followed, reached without a law of growth), ``"not-identified"``.
    parameter : float
        p*: of the equilibrium's fold or Hopf point, or by the law of the period; else of the last orbit.
    error : float
        Estimate for p*; 0 where it is that of an equilibrium or a bound, and nan where it is not identified.
    period : float
        Of the last orbit.
    sentence : str
        The end in words, with the parameter's value.
    equilibrium : ndarray, (n,)
        That the last orbits approach, empty where there is none.
    eigenvalues : ndarray of complex, (n,)
        Of the equilibrium.
    saddle_node, connection : PeriodLaw or None
        Both laws with their residuals, where the period grows.
    """

    kind: str
    parameter: float
    error: float
    period: float
    sentence: str
    equilibrium: np.ndarray = field(default_factory=lambda: np.empty(0))
    eigenvalues: np.ndarray = field(default_factory=lambda: np.empty(0, complex))
    saddle_node: PeriodLaw | None = None
    connection: PeriodLaw | None = None


@dataclass(frozen=True, eq=False)
class _Saddle:
    """Saddle with the rates of its slowest growing and decaying disturbances, of those that the orbit has."""

    point: Equilibrium
    growing: float
    decaying: float


def significant_value(value: float, bounds: tuple[float, float]) -> float:
    """Return a value of the parameter, but 0 where it is a rounding error of that, for a parameter within the bounds."""
    size = max((abs(end) for end in bounds if math.isfinite(end)), default=0.0)
    return 0.0 if abs(value) < _ROUNDING * size else value


def branch_end(cycles: Cycles, values: np.ndarray, periods: np.ndarray, last: Sequence[Cycle], reason: str) -> BranchEnd:
    """Identify the end of a branch of periodic orbits.

    Parameters
    ----------
    cycles : Cycles
        Of which the branch is one.
    values, periods : ndarray, (N,)
        Of all its orbits in order, the end being the last.
    last : sequence of Cycle
        The last ones, two or more where there are as many.
    reason : str
        The sentence with which following the branch ended (``Walk.end``).

    Returns
    -------
    BranchEnd
    """
    here, name = last[-1], cycles.equations.parameter_names[-1]
    value, period = here.parameter, here.period
    if reason == CURVE_CLOSED:
        return BranchEnd(CLOSED_BRANCH, value, 0.0, period, "the branch is closed")
    clean = partial(significant_value, bounds=cycles.bounds)
    if reason == SHRINKS and (hopf := hopf_point(cycles.equations, last)) is not None:
        sentence = f"at {name} = {clean(hopf.parameter):.9g} the orbit shrinks to an equilibrium: a Hopf point"
        return BranchEnd(HOPF, hopf.parameter, 0.0, period, sentence, hopf.x, hopf.eigenvalues)
    range_end = next((b for b in cycles.bounds if abs(value - b) <= _AT_A_BOUND * max(1.0, abs(b))), None)
    if range_end is not None and "leaves the range" in reason:
        return BranchEnd(RANGE, value, 0.0, period, f"the range ends at {name} = {clean(value):.9g}")
    return _lengthening_end(cycles, values, periods, last, reason)


def _lengthening_end(cycles: Cycles, values: np.ndarray, periods: np.ndarray, last: Sequence[Cycle], reason: str) -> BranchEnd:
    """Return the end of a branch whose period may grow without bound: see ``branch_end``."""
    here, name = last[-1], cycles.equations.parameter_names[-1]
    value, period = here.parameter, here.period
    value_text = f"{significant_value(value, cycles.bounds):.9g}"
    is_longest = abs(period - cycles.periods[1]) <= _AT_A_BOUND * period
    if is_longest:
        reason = f"the period reaches {period:.6g}, up to which orbits are followed"
    laws = laws_of_growth(values, periods) if period >= _GROWN * periods.min() else None
    by_law = None if laws is None else _end_by_law(cycles, here, laws, reason)
    if by_law is not None and by_law.kind != NOT_IDENTIFIED:
        return by_law
    if (connection := _unresolved_connection(cycles, values, periods, last)) is not None:
        return connection
    if is_longest and (laws is None or not _holds(laws)):
        saddle_node, connection_law = laws or (None, None)
        sentence = f"at {name} = {value_text} {reason}"
        return BranchEnd(PERIOD_LIMIT, value, math.nan, period, sentence, saddle_node=saddle_node, connection=connection_law)
    unknown = BranchEnd(NOT_IDENTIFIED, value, math.nan, period, f"at {name} = {value_text} it is not identified: {reason}")
    return by_law or unknown


def _end_by_law(cycles: Cycles, here: Cycle, laws: tuple[PeriodLaw, PeriodLaw], reason: str) -> BranchEnd:
    """Return the end of a branch whose period grows, by the law of its growth."""
    name, law = cycles.equations.parameter_names[-1], better_law(laws)
    make_end = partial(BranchEnd, saddle_node=laws[0], connection=laws[1])
    clean = partial(significant_value, bounds=cycles.bounds)
    places, beyond = _slow_places(cycles, here), "the period grows beyond all bounds, as"
    holds = _holds(laws)
    if holds and law.name == SADDLE_NODE:
        fold = _fold(cycles, here, places)
        if fold is not None and _agree(fold.parameter, law, here.parameter):
            description = f"{law.factor:.5g}/sqrt|{name} - {name}*|: equilibria appear on the orbit, a saddle-node"
            sentence = f"at {name} = {clean(fold.parameter):.9g} {beyond} {description}"
            equilibrium = fold.x, fold.eigenvalues
            return make_end(SADDLE_NODE_ON_ORBIT, fold.parameter, 0.0, here.period, sentence, *equilibrium)
    elif holds:
        saddles = _saddles(cycles, here, places, law.critical)
        if saddles and any(abs(rate * law.factor - 1) < _AGREE_RATE for rate in _rates(saddles)):
            first, count = saddles[0].point, "a saddle" if len(saddles) == 1 else f"{len(saddles)} saddles"
            description = f"-ln|{name} - {name}*|/{1 / law.factor:.5g}: the orbit runs into {count}"
            equilibrium = first.x, first.eigenvalues
            sentence = f"at {name} = {clean(law.critical):.9g} {beyond} {description}"
            return make_end(SADDLE_CONNECTION, law.critical, law.error, here.period, sentence, *equilibrium)
    diagnosis = "no law of the period fits" if not holds else f"the period follows the law of a {law.name.replace('-', ' ')}"
    missing = "" if not holds else ", but no matching equilibrium was found where the orbit is slowest"
    explanation = f"the end is not identified: {diagnosis}{missing} ({reason})"
    sentence = f"near {name} = {clean(here.parameter):.9g} the period grows; {explanation}"
    return make_end(NOT_IDENTIFIED, here.parameter, math.nan, here.period, sentence)


def _holds(laws: tuple[PeriodLaw, PeriodLaw]) -> bool:
    """True if the better law fits, and the other one by far not as well."""
    law, worst = better_law(laws), max(one.residual for one in laws)
    return law.residual < _FITS[law.name] and worst > _BETTER * law.residual and law.factor > 0


def _unresolved_connection(cycles: Cycles, values: np.ndarray, periods: np.ndarray, last: Sequence[Cycle]) -> BranchEnd | None:
    """Identify a saddle connection so near that the parameter no longer changes: only the time spent at saddles still grows.

    It is the only sign of a connection where the law of the period is not reached before that.
    """
    here, name = last[-1], cycles.equations.parameter_names[-1]
    late = values[periods > here.period / _GROWN_AT_REST]
    resolution = _RESOLUTION * max(float(np.abs(values).max()), float(np.ptp(values)))
    if len(late) < _FEWEST or np.ptp(late) > resolution or here.period <= last[0].period:
        return None
    saddles = _saddles(cycles, here, _slow_places(cycles, here), here.parameter)
    spent, spent_before = ([_time_near(c, s.point.x, _sizes(here)) for s in saddles] for c in (here, last[0]))
    comes_near = [
        t * s.growing * s.decaying / (s.growing + s.decaying) > _APPROACH for t, s in zip(spent, saddles, strict=True)
    ]
    gain_share = (sum(spent) - sum(spent_before)) / (here.period - last[0].period)
    if not saddles or not all(comes_near) or abs(gain_share - 1) > _ALL_AT_SADDLES:
        return None
    count = "a saddle" if len(saddles) == 1 else f"{len(saddles)} saddles"
    sentence = (
        f"at {name} = {significant_value(here.parameter, cycles.bounds):.9g} the period grows beyond all bounds: {name} no "
        f"longer changes, and all that the period still gains is time near {count}"
    )
    equilibrium = saddles[0].point.x, saddles[0].point.eigenvalues
    return BranchEnd(SADDLE_CONNECTION, here.parameter, resolution, here.period, sentence, *equilibrium)


def _time_near(cycle: Cycle, x: np.ndarray, sizes: np.ndarray) -> float:
    """Return the time that an orbit spends near a state (n,)."""
    edges = cycle.problem.mesh.edges
    tau = np.unique(np.concatenate([a + (b - a) * np.linspace(0, 1, _FINE) for a, b in pairwise(edges)]))
    away = np.linalg.norm((cycle.states_at(tau) - x[:, None]) / sizes[:, None], axis=0) - _AROUND
    inside, total = (np.abs(signal[1:]) + np.abs(signal[:-1]) for signal in (np.minimum(away, 0.0), away))
    return cycle.period * float(np.diff(tau) @ (inside / total))


def _agree(parameter: float, law: PeriodLaw, last: float) -> bool:
    return abs(parameter - law.critical) <= max(_ERRORS * law.error, _AGREE_CRITICAL * abs(last - law.critical))


def _sizes(here: Cycle) -> np.ndarray:
    """Return the extent of the orbit in each state (n,)."""
    return np.asarray(np.maximum(np.ptp(here.states, axis=1), 1e-2 * here.problem.sizes[:-2]))


def _slow_places(cycles: Cycles, here: Cycle) -> list[np.ndarray]:
    """Return the states (n,) where an orbit stays long, in the order in which it passes them."""
    tau, states = here.tau, here.states
    points = np.concatenate([states, np.tile([[1.0], [here.parameter]], states.shape[1])])
    speed = np.linalg.norm(cycles.equations.values(points)[0] / _sizes(here)[:, None], axis=0)[:-1]
    slow, shares = speed < _SLOW * speed.max(), np.diff(tau)
    if slow.all() or not slow.any():
        return [states[:, speed.argmin()]]
    begin = int(np.flatnonzero(slow & ~np.roll(slow, 1))[0])
    order = np.roll(np.arange(len(slow)), -begin)
    waits = [order[a:b] for a, b in stretches(slow[order])]
    return [states[:, i[speed[i].argmin()]] for i in waits if shares[i].sum() > _DWELLS]


def _is_near(here: Cycle, place: np.ndarray, x: np.ndarray) -> bool:
    return bool(np.linalg.norm((x - place) / _sizes(here)) < _NEAR)


def _fold(cycles: Cycles, here: Cycle, places: Sequence[np.ndarray]) -> Equilibrium | None:
    """Return the fold of equilibria near the place where an orbit is slowest: there are none at the orbit's parameter value."""
    if len(places) != 1:
        return None
    equilibria = equilibria_of(cycles.equations)
    unknowns = np.append(places[0], here.parameter)
    scale = equilibria.equations.scale[:-1]
    across = np.linalg.svd(equilibria.equations.values(unknowns)[1][:, :-1] * scale / scale[:, None])[2][-1]
    try:
        fold = nearest_special(equilibria, equilibria.curve.start(unknowns, np.append(across * scale, 0.0)), FOLD)
    except RunError:
        return None
    return fold if fold is not None and _is_near(here, places[0], fold.x) else None


def _saddles(cycles: Cycles, here: Cycle, places: Sequence[np.ndarray], value: float) -> list[_Saddle]:
    """Return the saddles at the slow places of an orbit, none where one of these is no saddle."""
    equilibria, saddles = equilibria_of(cycles.equations), list[_Saddle]()
    for place in places:
        try:
            point = equilibria.evaluate(equilibria.start(place, value))
        except RunError:
            return []
        rates = _passage_rates(here, point)
        if not (_is_near(here, place, point.x) and rates.min() < 0 < rates.max()):
            return []
        saddles.append(_Saddle(point, float(rates[rates > 0].min()), float(-rates[rates < 0].max())))
    return saddles


def _passage_rates(here: Cycle, saddle: Equilibrium) -> np.ndarray:
    """Return the real parts (k,) of the eigenvalues in whose directions an orbit passes: it may lie in a subspace."""
    n, sizes = len(saddle.x), _sizes(here)
    away = (here.states - saddle.x[:, None]) / sizes[:, None]
    matrix = saddle.point.jacobian[:, :n] * sizes / sizes[:, None]
    values, left_vectors = np.linalg.eig(matrix.T)
    along = np.abs(left_vectors.T @ away[:, np.linalg.norm(away, axis=0) < _NEAR]).max(axis=1)
    return np.asarray(values.real[along > _IN_A_SUBSPACE * along.max()])


def _rates(saddles: Sequence[_Saddle]) -> list[float]:
    """Return possible ratios of -ln|p - p*| to the period of an orbit past saddles, if one connection breaks, or all alike.

    A deviation d from the stable manifold takes the time -ln d/lambda_u past a saddle and becomes d^nu,
    nu = |lambda_s|/lambda_u. The first deviation is |p - p*| where the orbit is
    stable; in reversed time it is where it is unstable.
    """
    growing, decaying = np.array([(s.growing, s.decaying) for s in saddles]).T
    rates = []
    for u, s in ((growing, decaying), (decaying[::-1], growing[::-1])):
        rates.append(1 / (1 / u).sum())
        for first in range(len(saddles)):
            outward, inward = np.roll(u, -first), np.roll(s, -first)
            rates.append(1 / (np.cumprod([1.0, *(inward / outward)[:-1]]) / outward).sum())
    return [float(rate) for rate in rates]
