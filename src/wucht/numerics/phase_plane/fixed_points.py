"""All fixed points of a planar System in a window, proved to be all where bounds of its Jacobian are known; and their kinds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.phase_plane.box_bounds import bounds
from wucht.numerics.phase_plane.plane import Plane
from wucht.numerics.subdivision import Zeros, all_zeros

SADDLE, CENTRE, DEGENERATE = "saddle", "centre", "degenerate"
STABLE = ("stable node", "stable focus")
UNSTABLE = ("unstable node", "unstable focus")

_SMALLEST = 1e-7  # of a side of the window: smaller boxes are around a fixed point at a bifurcation
_MOST_BOXES = 400_000
_SIDE = 24  # Newton's method starts from the points of a grid of so many a side, where boxes stay undecided
_STEPS, _SAME = 60, 1e-7  # of it; and, of the window, how far apart two of its ends are that are one
_NOTHING = 1e-13  # of the window: a state that is smaller is zero
_ROUNDING = 1e-9  # of the largest eigenvalue: a real part that is smaller is none


@dataclass(frozen=True, eq=False)
class FixedPoint:
    """state (2,), its angles in the window. eigenvalues (2,), the largest real part first, per unit of time. kind: in words."""

    state: np.ndarray
    eigenvalues: np.ndarray
    kind: str

    @property
    def attracts(self) -> int:
        """+1 where all that is near goes to it, -1 where all that is near has come from it, else 0."""
        return (self.kind in STABLE) - (self.kind in UNSTABLE)


@dataclass(frozen=True, eq=False)
class FixedPoints:
    """Those in the window, by their states. complete: whether these are shown to be all. shown: how, or why not."""

    points: tuple[FixedPoint, ...]
    complete: bool
    shown: str


def fixed_points(plane: Plane, watch: Callable[[], None] | None = None) -> FixedPoints:
    """The fixed points in the window. watch: called now and then; what it raises ends the search."""
    try:
        zeros = _subdivided(plane, watch)
    except WuchtError as error:
        found = _from_grid(plane, np.empty((2, 0)))
        return FixedPoints(_points(plane, found), False, f"Newton's method from {_SIDE**2} starts: {error}")
    if zeros.complete:
        how = f"subdivision of the window, {zeros.boxes} boxes, with bounds on the Jacobian"
        return FixedPoints(_points(plane, zeros.points), True, how)
    found = _from_grid(plane, np.concatenate([zeros.points, zeros.undecided[0]], axis=1), zeros.points)
    why = f"{zeros.undecided[0].shape[1]} of {zeros.boxes} boxes were not decided, as at a bifurcation"
    return FixedPoints(_points(plane, found), False, f"{why}: it is not shown that there are no more")


def point_at(plane: Plane, state: np.ndarray) -> FixedPoint:
    """A fixed point with its eigenvalues and kind."""
    values = np.linalg.eigvals(plane.jacobian(state[:, None])[..., 0]).astype(complex)
    values = values[np.lexsort((-values.imag, -values.real))]
    return FixedPoint(state, values, kind_of(values))


def kind_of(eigenvalues: np.ndarray) -> str:
    """What a fixed point with two eigenvalues is called."""
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
    return tuple(point_at(plane, x) for x in sorted(plane.wrapped(clean).T, key=lambda x: x.tolist()))


def _subdivided(plane: Plane, watch: Callable[[], None] | None) -> Zeros:
    lowered = plane.lowered
    constants, entries = lowered.program.constant_values(plane.numbers), lowered.places

    def spread(centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
        below, above = bounds(lowered.program, constants, centre - radius, centre + radius)
        at, apart = plane.jacobian(centre), np.zeros((2, 2, centre.shape[1]))
        for (i, j), low, high in zip(entries, below[2:], above[2:], strict=True):
            apart[i, j] = np.maximum(high - at[i, j], at[i, j] - low)
        return np.where(np.isnan(apart), np.inf, apart)

    spread((plane.low + plane.high)[:, None] / 2, plane.scale[:, None] / 2)  # raises for what has no bounds
    return all_zeros(
        plane.rates, plane.jacobian, spread, plane.low, plane.high,
        periodic=(plane.turns > 0).tolist(), smallest=_SMALLEST, most_boxes=_MOST_BOXES, watch=watch,
    )  # fmt: skip


def _from_grid(plane: Plane, more: np.ndarray, known: np.ndarray | None = None) -> np.ndarray:
    """The ends (2, k) of Newton's method from the points of a grid and from others (2, m), each once; those known first."""
    axes = [np.linspace(a, b, _SIDE) for a, b in zip(plane.low, plane.high, strict=True)]
    x = np.concatenate([np.array(np.meshgrid(*axes)).reshape(2, -1), more], axis=1)
    for _ in range(_STEPS):
        f, j = plane.rates(x), np.moveaxis(plane.jacobian(x), -1, 0)
        fine = np.isfinite(f).all(axis=0) & np.isfinite(j).all(axis=(1, 2))
        x, f, j = x[:, fine], f[:, fine], j[fine]
        size = np.abs(j).max(axis=(1, 2), initial=0.0)[:, None, None]
        move = -np.linalg.solve(j + 1e-13 * (size + 1e-300) * np.eye(2), f.T[..., None])[..., 0].T
        move /= np.maximum(1.0, 4 * np.hypot(*(move / plane.scale[:, None])))
        x = x + np.nan_to_num(move)
    settled = np.hypot(*(move / plane.scale[:, None])) < _SAME**2
    inside = ((x >= plane.low[:, None]) & (x <= plane.high[:, None]) | (plane.turns[:, None] > 0)).all(axis=0)
    distinct: list[np.ndarray] = [] if known is None else list(known.T)
    for candidate in x[:, settled & inside].T:
        if all(np.hypot(*plane.apart(candidate, other)) > _SAME for other in distinct):
            distinct.append(candidate)
    return np.array(distinct).T.reshape(2, len(distinct))
