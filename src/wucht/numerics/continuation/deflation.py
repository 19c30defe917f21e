"""Several equilibria at one parameter value, and the branches that do not touch, by deflated Newton's method.

A known solution x_i is divided out: Newton's method is applied to M(x) f(x) = 0 with

    M(x) = product over i of (1 / |x - x_i|^p + shift),

which does not go to zero at x_i, so that the same start leads elsewhere. The difference of angles is 2 sin of its half, so that
a solution and its copy after a whole turn are one. As J(Mf) = M f_x + f (grad M)^T, its correction is Newton's for f, d, times
1 / (1 - grad(ln M) . d): no further linear system is solved.
P. E. Farrell, A. Birkisson, S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026-A2045.

Deflation finds solutions but proves nothing: there may be more than it returns. It needs only values and the Jacobian, in any
number of states. Where all equilibria are required with a proof, in a box of a few states and with bounds on the
Jacobian, call ``numerics.subdivision.all_zeros``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.errors import InputError, RunError
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations, FunctionProblem
from wucht.numerics.continuation.equilibria import Branch, EquilibriumContinuation
from wucht.numerics.continuation.special_points import locate_zero

_SAME = 1e-6  # solutions that are nearer to each other, in units of scale, are one
_POLISHES = 2  # plain corrections after the last
_NEAR = 1e-4  # of the way between two points of a branch: a point nearer to the curve is on it
_ASIDE = 0.01  # distance of a start from a known solution, in units of scale


@dataclass(frozen=True)
class Deflation:
    """Settings of the search.

    power, shift: p and the shift of the operator. steps: of Newton's method from each start, at most. evaluations: of f and its
    Jacobian in all, at most. longest: the longest correction, in units of scale. tolerance: of the last one.
    """

    power: float = 2.0
    shift: float = 1.0
    steps: int = 100
    evaluations: int = 100_000
    longest: float = 10.0
    tolerance: float = 1e-8


def random_starts(
    low: Sequence[float] | np.ndarray, high: Sequence[float] | np.ndarray, count: int, seed: int = 0
) -> np.ndarray:
    """Draw starts uniformly in a box, for ``disconnected_branches``.

    Parameters
    ----------
    low, high : sequence of float, (n,)
        Corners of the box.
    count : int
    seed : int
        The same seed gives the same starts.

    Returns
    -------
    ndarray, (n, count)
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    return np.asarray(low[:, None] + (high - low)[:, None] * np.random.default_rng(seed).random((len(low), count)))


def deflated_solutions(
    equations: EquilibriumEquations,
    parameters: Sequence[float] | np.ndarray,
    starts: np.ndarray,
    known_solutions: np.ndarray | None = None,
    settings: Deflation = Deflation(),
) -> np.ndarray:
    """Return the distinct solutions (n, k) of f(x, p) = 0 at values of the parameters (m,) to which some starts lead.

    starts: (n, N), each used again after every new solution. known_solutions: (n, k), divided out from the beginning and not
    returned.
    """
    n, N = equations.n, starts.shape[1] if starts.ndim == 2 else 0
    if starts.shape != (n, N) or not N:
        raise InputError("starts", f"an array of shape {starts.shape}", f"a column of {n} states for each start")
    values = np.asarray(parameters, float)
    before = np.empty((n, 0)) if known_solutions is None else np.asarray(known_solutions, float).reshape(n, -1)
    solutions, evaluations = before, 0
    while True:
        more, spent, is_cut_short = _newton_round(
            equations, values, starts, solutions, settings, settings.evaluations - evaluations
        )
        evaluations += spent
        distinct = _distinct_points(equations, more, solutions)
        solutions = np.concatenate([solutions, distinct], axis=1)
        if is_cut_short or not distinct.shape[1]:
            return solutions[:, before.shape[1] :]


def _newton_round(
    equations: EquilibriumEquations,
    values: np.ndarray,
    starts: np.ndarray,
    solutions: np.ndarray,
    settings: Deflation,
    budget: int,
) -> tuple[np.ndarray, int, bool]:
    """Apply Newton's method to all starts: return the solutions (n, k), the evaluations, and whether it was cut short."""
    n, scale = equations.n, equations.scale[: equations.n, None]
    x, spent, endpoints = starts.copy(), 0, list[np.ndarray]()
    for _ in range(settings.steps):
        if not x.shape[1]:
            break
        if spent + (1 + _POLISHES) * x.shape[1] > budget:
            return _join_columns(endpoints, n), spent, True
        spent += x.shape[1]
        step = _newton(equations, x, values)
        usable = np.isfinite(step).all(axis=0)
        x, step = x[:, usable], step[:, usable]
        near = np.linalg.norm(step / scale, axis=0) <= settings.tolerance
        again = near & (_distances(equations, x + step, solutions).min(axis=1, initial=np.inf) <= _SAME)
        near &= ~again
        if near.any():
            at = x[:, near] + step[:, near]
            for _ in range(_POLISHES):
                spent += at.shape[1]
                at = at + np.nan_to_num(_newton(equations, at, values))
            endpoints.append(at)
        # A start that converges to a solution that was divided out stays there: it is given up.
        x, step = x[:, ~(near | again)], step[:, ~(near | again)]
        step = step / (1 - _steepness(equations, x, step, solutions, settings))
        long = np.linalg.norm(step / scale, axis=0)
        x = x + step * np.minimum(1.0, settings.longest / np.where(long > 0, long, 1.0))
    return _join_columns(endpoints, n), spent, False


def _join_columns(parts: list[np.ndarray], n: int) -> np.ndarray:
    return np.concatenate([np.empty((n, 0)), *parts], axis=1)


def _distinct_points(equations: EquilibriumEquations, points: np.ndarray, solutions: np.ndarray) -> np.ndarray:
    """Return those of some points (n, N) that differ from all solutions (n, k) and from the points before them."""
    columns = solutions
    for point in points.T[:, :, None]:
        if _distances(equations, point, columns).min(initial=np.inf) > _SAME:
            columns = np.concatenate([columns, point], axis=1)
    return columns[:, solutions.shape[1] :]


def _newton(equations: EquilibriumEquations, x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return Newton's corrections (n, N) of states (n, N), not a number where there is none."""
    n = equations.n
    f, derivatives = equations.values(np.concatenate([x, np.repeat(values[:, None], x.shape[1], axis=1)]))
    matrices, step = np.moveaxis(derivatives[:, :n], -1, 0), np.full_like(x, np.nan)
    with np.errstate(all="ignore"):
        good = np.flatnonzero(np.isfinite(f).all(axis=0) & np.isfinite(matrices).all(axis=(1, 2)))
        good = good[np.linalg.slogdet(matrices[good])[0] != 0]
        step[:, good] = -np.linalg.solve(matrices[good], f[:, good].T[..., None])[..., 0].T
    return step


def _distances(equations: EquilibriumEquations, x: np.ndarray, solutions: np.ndarray) -> np.ndarray:
    """Return the distances (N, k) of states (n, N) from solutions (n, k), in units of scale."""
    return np.asarray(np.sqrt((_differences(equations, x, solutions)[0] ** 2).sum(axis=0)))


def _differences(equations: EquilibriumEquations, x: np.ndarray, solutions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return differences (n, N, k) of states (n, N) and solutions (n, k) in units of scale, and their derivatives by states."""
    away, scale = x[:, :, None] - solutions[:, None, :], equations.scale[: equations.n, None, None]
    period = equations.turns[: equations.n, None, None]
    rate = np.divide(2 * np.pi, period, out=np.ones_like(period), where=period > 0)
    around = np.where(period > 0, 2 * np.sin(rate * away / 2) / rate, away)
    return around / scale, np.where(period > 0, np.cos(rate * away / 2), 1.0) / scale


def _steepness(
    equations: EquilibriumEquations, x: np.ndarray, step: np.ndarray, solutions: np.ndarray, settings: Deflation
) -> np.ndarray:
    """Return grad(ln M) . step (N,)."""
    difference, slope = _differences(equations, x, solutions)
    with np.errstate(all="ignore"):
        square = (difference**2).sum(axis=0)  # (N, k)
        closing = (difference * slope * step[:, :, None]).sum(axis=0)  # |x - x_i| d|x - x_i| along the step
        share = -settings.power * closing / square / (1 + settings.shift * square ** (settings.power / 2))
    return np.asarray(np.nan_to_num(share).sum(axis=1))


def equilibria_at(branch: Branch, value: float) -> np.ndarray:
    """Compute the states at which a branch passes a value of its parameter, on the curve between its points.

    Parameters
    ----------
    branch : Branch
    value : float
        The parameter's value.

    Returns
    -------
    ndarray, (n, k)
        A column a state; angles that differ by whole turns are one.
    """
    equations, points, off = branch.equations, branch.points, branch.unknowns[-1] - value
    curve, states = _curve(equations), [points[i].x for i in np.flatnonzero(off == 0)]
    for i in np.flatnonzero(np.sign(off[:-1]) * np.sign(off[1:]) < 0):
        at = locate_zero(curve, points[i].point, points[i + 1].point, _identity, lambda p: float(p.unknowns[-1] - value))
        if at is None:  # at one of the two points, but for rounding
            at = points[i if abs(off[i]) < abs(off[i + 1]) else i + 1].point
        states.append(at.unknowns[:-1])
    empty = np.empty((equations.n, 0))
    return _distinct_points(equations, np.array(states).T, empty) if states else empty


def _identity(point: CurvePoint) -> CurvePoint:
    return point


def _curve(equations: EquilibriumEquations) -> Curve:
    return Curve(FunctionProblem(equations.values, equations.scale, equations.turns))


def _is_on_branch(branch: Branch, unknowns: np.ndarray) -> bool:
    """True if unknowns (n+1,) lie on a branch, but for whole turns of angles: between the two points of it nearest to them."""
    scale, turns = branch.equations.scale, branch.equations.turns[:, None]
    away = unknowns[:, None] - branch.unknowns[:, :-1]
    away = (away - turns * np.rint(away / np.where(turns > 0, turns, np.inf))) / scale[:, None]
    way = np.diff(branch.unknowns, axis=1) / scale[:, None]
    long = (way**2).sum(axis=0)
    shares = np.clip((away * way).sum(axis=0) / np.where(long > 0, long, 1.0), 0.0, 1.0)
    i = int(((away - shares * way) ** 2).sum(axis=0).argmin())
    a, b = branch.points[i].point, branch.points[i + 1].point
    try:
        near = (_curve(branch.equations).point_between(a, b, float(shares[i])).unknowns - a.unknowns) / scale
    except RunError:
        near = shares[i] * way[:, i]
    return float(np.linalg.norm(away[:, i] - near)) < max(_SAME, _NEAR * math.sqrt(long[i]))


def disconnected_branches(
    problem: EquilibriumContinuation,
    values: Sequence[float],
    starts: np.ndarray,
    settings: Deflation = Deflation(),
    known_branches: Sequence[Branch] = (),
) -> tuple[Branch, ...]:
    """Compute the branches that pass some values of the parameter, each once, including those that touch no other.

    At each value the equilibria of the branches known so far are divided out; a further solution lies on a new branch,
    which is followed to its ends. That nothing is left is not proved: ``numerics.subdivision.all_zeros`` proves it in a box.

    Parameters
    ----------
    problem : EquilibriumContinuation
    values : sequence of float
        Of the parameter.
    starts : ndarray, (n, N)
        States from which Newton's method begins, as from ``random_starts``; the solutions at a value serve as starts at the
        next one, too.
    settings : Deflation
        Limits of the search.
    known_branches : sequence of Branch
        Not returned again.

    Returns
    -------
    tuple of Branch
        A solution from which no branch can be followed is left out.

    Raises
    ------
    InputError
        For starts of another shape.

    Examples
    --------
    The two branches of x^2 = 1 + p^2:

    >>> import sympy as sp
    >>> from wucht.numerics.continuation import EquilibriumContinuation, EquilibriumEquations, System
    >>> from wucht.numerics.continuation import disconnected_branches, random_starts
    >>> x, p = sp.symbols("x p", real=True)
    >>> equations = EquilibriumEquations.from_system(System((x,), (x**2 - 1 - p**2,), (p,)), ["p"], {})
    >>> problem = EquilibriumContinuation(equations, bounds=(-1.0, 1.0))
    >>> branches = disconnected_branches(problem, [0.5], random_starts([-3.0], [3.0], 10))
    >>> sorted(round(float(branch.points[0].x[0]), 4) for branch in branches)
    [-1.4142, 1.4142]
    """
    equations, branches, new_branches = problem.equations, list(known_branches), list[Branch]()
    empty = np.empty((equations.n, 0))
    before, random = empty, np.random.default_rng(0)
    for value in values:
        known_states = np.concatenate([empty, *(equilibria_at(b, value) for b in branches)], axis=1)
        # At a solution the operator has no direction.
        aside = before + _ASIDE * equations.scale[: equations.n, None] * random.normal(size=before.shape)
        more = deflated_solutions(equations, [value], np.concatenate([starts, aside], axis=1), known_states, settings)
        for x in more.T[:, :, None]:
            if not _distinct_points(equations, x, known_states).shape[1]:
                continue
            known_states = np.concatenate([known_states, x], axis=1)
            try:
                start = problem.start(x[:, 0], value)
                if any(_is_on_branch(b, start.unknowns) for b in branches if len(b.points) > 1):  # nearly singular: at a fold
                    continue
                branch = problem.follow_branch(start)
            except RunError:
                continue
            known_states = np.concatenate([known_states, equilibria_at(branch, value)], axis=1)
            branches.append(branch)
            new_branches.append(branch)
        before = known_states
    return tuple(new_branches)
