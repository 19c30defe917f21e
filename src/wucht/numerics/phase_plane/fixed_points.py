"""Fixed points of a planar System in a window, proved to be all where bounds of its Jacobian are known; and their kinds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.program import Numbers, lower
from wucht.numerics.intervals import bounds
from wucht.numerics.phase_plane.plane import Plane
from wucht.numerics.subdivision import Zeros, all_zeros
from wucht.piecewise import PiecewiseCubic
from wucht.system import System

SADDLE, CENTRE, DEGENERATE = "saddle", "centre", "degenerate"
STABLE = ("stable node", "stable focus")
UNSTABLE = ("unstable node", "unstable focus")
_SMALLEST = 1e-7  # of a side of the window: smaller boxes are around a fixed point at a bifurcation
_FEW_BOXES, _MOST_BOXES = 12_000, 400_000
_OPEN = 0.05  # of the window: where more is undecided after the few boxes, the bounds exclude next to nothing
_MOST_STARTS = 2000  # of Newton's method, in boxes that stay undecided
_SIDE = 24  # points per side of the grid from which Newton's method starts, where boxes stay undecided
_STEPS, _SAME = 60, 1e-7  # of Newton's method; and, of the window, the distance below which two results are one
_NOTHING = 1e-13  # of the window: a state that is smaller is zero
_ROUNDING = 1e-9  # of the largest eigenvalue: a real part that is smaller is none
_SIZES = (1.0, 10.0, 100.0, 1e3)  # half sides of the boxes that are searched one after the other
_MANY = 20  # fixed points: where a larger box has more, as of periodic functions, the smaller one is shown
_AROUND = 0.6  # of their extent: margin shown around the fixed points, and at least
_LEAST = 1.5  # times the distance of the farthest one from zero; 1.5 where all are at zero


def may_jump(system: System, values: Numbers, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return whether each of the n rates may jump in each of N boxes (n, N). values: of the parameters. low, high: (n, N).

    Raises ``WuchtError`` for a function of which no bounds are known.
    """
    jumps = np.zeros(low.shape, bool)
    pieces = _jumping(system)
    if not pieces:
        return jumps
    program = lower(system, [piece.args[0] for _, piece in pieces])
    below, above = bounds(program, program.constant_values(values), low, high)
    for (row, piece), a, b in zip(pieces, below, above, strict=True):
        at = np.array(piece.args[1].jumps())[:, None]
        jumps[row] |= ~((at < a) | (at > b)).all(axis=0)  # also where the argument has no bounds
    return jumps


@lru_cache(maxsize=64)
def _jumping(system: System) -> tuple[tuple[int, PiecewiseCubic], ...]:
    """Return the piecewise functions that jump, by the row of the rate that depends on them, definitions substituted."""
    meanings = system.definitions
    if not any(p.args[1].jumps() for e in (*system.derivatives, *(e for _, e in meanings)) for p in _pieces(e)):
        return ()
    whole = list(map(sp.sympify, system.derivatives))
    for symbol, expression in reversed(meanings):
        whole = [e.xreplace({symbol: sp.sympify(expression)}) for e in whole]
    return tuple((i, p) for i, e in enumerate(whole) for p in sorted(_pieces(e), key=str) if p.args[1].jumps())


def _pieces(e: sp.Expr) -> set[PiecewiseCubic]:
    return set(sp.sympify(e).atoms(PiecewiseCubic))


@dataclass(frozen=True, eq=False)
class FixedPoint:
    """A fixed point. state (2,): angles in the window. eigenvalues (2,), per unit of time: largest real part first. kind."""

    state: np.ndarray
    eigenvalues: np.ndarray
    kind: str

    @property
    def attracts(self) -> int:
        """Attraction: +1 if all curves nearby go to it, -1 if all come from it, else 0."""
        return (self.kind in STABLE) - (self.kind in UNSTABLE)


@dataclass(frozen=True, eq=False)
class FixedPoints:
    """Fixed points in the window, by their states. complete: true if proved to be all. evidence: how, or why not."""

    points: tuple[FixedPoint, ...]
    complete: bool
    evidence: str


def fixed_points(plane: Plane, check: Callable[[], None] | None = None) -> FixedPoints:
    """Compute the fixed points in the window. check: called now and then; an exception that it raises ends the search."""
    try:
        zeros = _zeros_by_subdivision(plane, check)
    except WuchtError as error:
        states = _search_from_grid(plane, np.empty((2, 0)), None, check)
        return FixedPoints(_points(plane, states), False, f"Newton's method from {_SIDE**2} starts: {error}")
    if zeros.complete:
        evidence = f"subdivision of the window, {zeros.boxes} boxes, with bounds on the Jacobian"
        return FixedPoints(_points(plane, zeros.points), True, evidence)
    centres = zeros.undecided_boxes[0]
    starts = centres[:, :: max(1, math.ceil(centres.shape[1] / _MOST_STARTS))]
    states = _search_from_grid(plane, np.concatenate([zeros.points, starts], axis=1), zeros.points, check)
    few = zeros.boxes < _MOST_BOXES and _open(plane, zeros) > _OPEN
    reason = "as where bounds on the Jacobian are wide" if few else "as at a bifurcation or a jump"
    obstacle = f"{centres.shape[1]} of {zeros.boxes} boxes were not decided, {reason}"
    return FixedPoints(_points(plane, states), False, f"{obstacle}: it is not proved that there are no more")


def point_at(plane: Plane, state: np.ndarray) -> FixedPoint:
    """Return a fixed point with its eigenvalues and kind."""
    values = np.linalg.eigvals(plane.jacobian(state[:, None])[..., 0]).astype(complex)
    values = values[np.lexsort((-values.imag, -values.real))]
    return FixedPoint(state, values, kind_of(values))


def kind_of(eigenvalues: np.ndarray) -> str:
    """Return the kind of a fixed point with two eigenvalues."""
    size = float(np.abs(eigenvalues).max(initial=0.0))
    real = np.where(np.abs(eigenvalues.real) > _ROUNDING * size, eigenvalues.real, 0.0)
    oscillates = bool((np.abs(eigenvalues.imag) > _ROUNDING * size).all()) and size > 0
    if (real > 0).any() and (real < 0).any():
        return SADDLE
    if oscillates and not real.any():
        return CENTRE
    if not real.all():
        return DEGENERATE
    return (STABLE if real[0] < 0 else UNSTABLE)[int(oscillates)]


def _points(plane: Plane, states: np.ndarray) -> tuple[FixedPoint, ...]:
    clean = np.where(np.abs(states) < _NOTHING * plane.scale[:, None], 0.0, states)
    return tuple(point_at(plane, x) for x in sorted(plane.wrap_to_window(clean).T, key=lambda x: x.tolist()))


def _zeros_by_subdivision(plane: Plane, check: Callable[[], None] | None) -> Zeros:
    lowered_jacobian, bare = plane.lowered_jacobian, replace(plane.system, outputs=(), quadratures=())
    constants, entries = lowered_jacobian.program.constant_values(plane.numbers), lowered_jacobian.places

    def spread(centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
        below, above = bounds(lowered_jacobian.program, constants, centre - radius, centre + radius)
        at, apart = plane.jacobian(centre), np.zeros((2, 2, centre.shape[1]))
        for (i, j), low, high in zip(entries, below[2:], above[2:], strict=True):
            apart[i, j] = np.maximum(high - at[i, j], at[i, j] - low)
        jumps = may_jump(bare, plane.numbers, centre - radius, centre + radius)
        return np.where(np.isnan(apart) | jumps[:, None], np.inf, apart)

    spread((plane.low + plane.high)[:, None] / 2, plane.scale[:, None] / 2)  # raises where a function has no bounds
    for most in (_FEW_BOXES, _MOST_BOXES):
        zeros = all_zeros(
            plane.rates, plane.jacobian, spread, plane.low, plane.high,
            periodic=(plane.turns > 0).tolist(), smallest=_SMALLEST, most_boxes=most, check=check,
        )  # fmt: skip
        if zeros.complete or zeros.boxes < most or _open(plane, zeros) > _OPEN:
            break
    return zeros


def _open(plane: Plane, zeros: Zeros) -> float:
    """Return the share of the window that is not decided."""
    return float((2 * zeros.undecided_boxes[1] / plane.scale[:, None]).prod(axis=0).sum())


def _search_from_grid(
    plane: Plane, more: np.ndarray, known_points: np.ndarray | None, check: Callable[[], None] | None
) -> np.ndarray:
    """Apply Newton's method from the points of a grid and from others (2, m): distinct results (2, k), the known ones first."""
    axes = [np.linspace(a, b, _SIDE) for a, b in zip(plane.low, plane.high, strict=True)]
    x = np.concatenate([np.array(np.meshgrid(*axes)).reshape(2, -1), more], axis=1)
    for _ in range(_STEPS):
        if check is not None:
            check()
        f, j = plane.rates(x), np.moveaxis(plane.jacobian(x), -1, 0)
        fine = np.isfinite(f).all(axis=0) & np.isfinite(j).all(axis=(1, 2))
        x, f, j = x[:, fine], f[:, fine], j[fine]
        size = np.abs(j).max(axis=(1, 2), initial=0.0)[:, None, None]
        move = -np.linalg.solve(j + 1e-13 * (size + 1e-300) * np.eye(2), f.T[..., None])[..., 0].T
        move /= np.maximum(1.0, 4 * np.hypot(*(move / plane.scale[:, None])))
        x = x + np.nan_to_num(move)
    has_converged = np.hypot(*(move / plane.scale[:, None])) < _SAME**2
    inside = ((x >= plane.low[:, None]) & (x <= plane.high[:, None]) | (plane.turns[:, None] > 0)).all(axis=0)
    distinct, remaining = np.empty((2, 0)) if known_points is None else known_points, x[:, has_converged & inside]
    for one in distinct.T:
        remaining = remaining[:, np.hypot(*plane.difference(remaining, one[:, None])) > _SAME]
    while remaining.shape[1]:
        if check is not None:
            check()
        distinct = np.concatenate([distinct, remaining[:, :1]], axis=1)
        remaining = remaining[:, np.hypot(*plane.difference(remaining, remaining[:, :1])) > _SAME]
    return distinct


def window_around(
    system: System, values: Mapping[str, float], low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return ends (2,), (2,) of a window where ``low`` and ``high`` are not numbers; None where there is no fixed point."""
    free = np.isnan(low)
    points: np.ndarray | None = None
    for size in _SIZES:
        plane = Plane(system, values, np.where(free, -size, low), np.where(free, size, high))
        states = np.array([p.state for p in fixed_points(plane).points]).T
        if states.size and points is not None and states.shape[1] > _MANY:
            break
        points = states if states.size else points
    if points is None:
        return None
    extent = np.maximum(np.ptp(points, axis=1), 0.0)
    far = np.abs(points).max(axis=1)
    margin = np.maximum(_AROUND * extent, np.where(far > 0, 0.5 * far, 0.0))
    margin = np.where(margin > 0, margin, _LEAST * (max(float(margin[free].max()), 0.0) or 1.0))
    return np.where(free, points.min(axis=1) - margin, low), np.where(free, points.max(axis=1) + margin, high)
