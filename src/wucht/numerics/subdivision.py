"""All zeros of a function in a box, shown to be all: subdivision with bounds on the Jacobian.

In a box of centre c and radii r, with |J(y) - J(c)| <= D entrywise for all its y:
 - |f_i(c)| > sum_j (|J_ij(c)| + D_ij) r_j for an i: the box holds no zero (mean value theorem);
 - Y = J(c)^-1: all its zeros lie in K, the box of centre c - Y f(c) and radii |Y| D r; where K is inside the box, it holds
   exactly one; where both are disjoint, none (R. Krawczyk, Computing 4 (1969) 187-201; A. Neumaier, "Interval Methods for
   Systems of Equations", Cambridge 1990, chapter 5).
What is left is cut in two. Rounding is covered by a margin, not by directed rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Function = Callable[[np.ndarray], np.ndarray]
Spread = Callable[[np.ndarray, np.ndarray], np.ndarray]

_INFLATED = 1.2  # a zero on the border of a box is inside that of its inflated neighbour
_MARGIN = 1 + 1e-10  # for what rounding adds to the bounds
_SHRUNK = 0.6  # of a side: a box that Krawczyk's step shrinks more than that is not cut
_CHUNK = 16384  # boxes looked at together
_SAME = 1e-7  # of the box' sides: Newton's method ends much nearer to a zero than that


@dataclass(frozen=True)
class Zeros:
    """points: (n, k). undecided: centres and radii (n, u) of boxes in which nothing was shown. boxes: how many were looked at.

    Where ``undecided`` is empty there are exactly k zeros.
    """

    points: np.ndarray
    undecided: tuple[np.ndarray, np.ndarray]
    boxes: int

    @property
    def complete(self) -> bool:
        """Whether these are shown to be all."""
        return not self.undecided[0].size


def all_zeros(
    function: Function,
    jacobian: Function,
    spread: Spread,
    low: Sequence[float] | np.ndarray,
    high: Sequence[float] | np.ndarray,
    *,
    periodic: Sequence[bool] | None = None,
    smallest: float = 1e-4,
    most_boxes: int = 1_000_000,
) -> Zeros:
    """The zeros of f in the box [low, high].

    function: (n, N) -> (n, N). jacobian: (n, N) -> (n, n, N). spread: centres and radii (n, N) -> (n, n, N), a bound on how
    much each entry of the Jacobian differs from that at the centre; not finite where none is known yet. periodic: coordinates
    whose two ends are the same. smallest: of each side; smaller boxes are given up, as those along a curve of zeros.
    most_boxes: that are looked at.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    n, whole = len(low), high - low
    around = np.zeros(n, bool) if periodic is None else np.asarray(periodic, bool)
    waiting = [(((low + high) / 2)[:, None], (whole / 2)[:, None])]
    given_up: list[tuple[np.ndarray, np.ndarray]] = []
    found: list[np.ndarray] = []
    looked = 0
    while waiting and looked < most_boxes:
        centre, radius = waiting.pop()
        if centre.shape[1] > _CHUNK:
            waiting.append((centre[:, _CHUNK:], radius[:, _CHUNK:]))
            centre, radius = centre[:, :_CHUNK], radius[:, :_CHUNK]
        looked += centre.shape[1]
        left, zeros = _examined(function, jacobian, spread, centre, radius)
        found += [z for z in zeros.T if ((z >= low - _SAME * whole) & (z <= high + _SAME * whole) | around).all()]
        small = (left[1] <= smallest / 2 * whole[:, None]).all(axis=0)
        if small.any():
            given_up.append((left[0][:, small], left[1][:, small]))
        rest = _cut(left[0][:, ~small], left[1][:, ~small], whole, jacobian)
        if rest[0].shape[1]:
            waiting.append(rest)
    given_up += waiting
    empty = np.empty((n, 0))
    both = [np.concatenate([empty, *(box[k] for box in given_up)], axis=1) for k in (0, 1)]
    return Zeros(_distinct(found, low, whole, around), (both[0], both[1]), looked)


def _examined(
    function: Function, jacobian: Function, spread: Spread, centre: np.ndarray, radius: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """The boxes that stay undecided, shrunk where that can be, and the zeros (n, k) that were found."""
    f, matrix = function(centre), jacobian(centre)
    wide = _INFLATED * radius
    bound = spread(centre, wide) * _MARGIN
    size = np.abs(matrix)
    with np.errstate(invalid="ignore"):
        reach = np.einsum("ijN,jN->iN", size + np.where(np.isfinite(bound), bound, np.inf), radius)
    open_ = ~(np.abs(f) > reach * _MARGIN).any(axis=0)
    usable = open_ & np.isfinite(bound).all(axis=(0, 1))
    inverse = np.zeros_like(matrix)
    for k in _regular(matrix, usable):
        inverse[:, :, k] = np.linalg.inv(np.moveaxis(matrix[:, :, k], -1, 0)).transpose(1, 2, 0)
        usable[k] &= np.isfinite(inverse[:, :, k]).all(axis=(0, 1))
    usable &= inverse.any(axis=(0, 1))
    step = -np.einsum("ijN,jN->iN", inverse, np.where(usable, f, 0.0))
    spreading = np.einsum("ijN,jkN->ikN", np.abs(inverse), np.where(usable, bound, 0.0)) * _MARGIN
    inside, outside = (np.einsum("ijN,jN->iN", spreading, r) for r in (wide, radius))
    open_ &= ~(usable & (np.abs(step) > (radius + outside) * _MARGIN).any(axis=0))
    unique = open_ & usable & (np.abs(step) + inside < wide / _MARGIN).all(axis=0)
    zeros = _polished(function, jacobian, centre[:, unique] + step[:, unique])
    rest = open_ & ~unique
    low, high = centre - radius, centre + radius
    shrinkable = rest & usable
    low[:, shrinkable] = np.maximum(low, centre + step - outside)[:, shrinkable]
    high[:, shrinkable] = np.minimum(high, centre + step + outside)[:, shrinkable]
    return ((low + high)[:, rest] / 2, (high - low)[:, rest] / 2), zeros


def _regular(matrix: np.ndarray, usable: np.ndarray) -> list[np.ndarray]:
    """The indices of matrices that can be inverted, in one array."""
    with np.errstate(all="ignore"):
        scaled = matrix / np.abs(matrix).max(axis=1, keepdims=True)
        determinant = np.linalg.det(np.moveaxis(np.nan_to_num(scaled), -1, 0))
    chosen = np.flatnonzero(usable & (np.abs(determinant) > 1e-12))
    return [chosen] if len(chosen) else []


def _polished(function: Function, jacobian: Function, at: np.ndarray) -> np.ndarray:
    for _ in range(6 if at.shape[1] else 0):
        matrix = np.moveaxis(jacobian(at), -1, 0)
        at = at - np.linalg.solve(matrix, function(at).T[..., None])[..., 0].T
    return at


def _cut(centre: np.ndarray, radius: np.ndarray, whole: np.ndarray, jacobian: Function) -> tuple[np.ndarray, np.ndarray]:
    """Each box halved along the side across which the function changes most, of those not much shorter than the longest."""
    if not centre.shape[1]:
        return centre, radius
    relative = radius / whole[:, None]
    matrix = np.abs(jacobian(centre))
    with np.errstate(all="ignore"):
        rows = matrix / np.einsum("ijN,jN->iN", matrix, radius)[:, None]
        change = np.nan_to_num(rows).max(axis=0) * radius
    change = np.where(relative >= 0.1 * relative.max(axis=0), change + 1e-3 * relative / relative.max(axis=0), -1.0)
    side, index = change.argmax(axis=0), np.arange(centre.shape[1])
    half = radius.copy()
    half[side, index] /= 2
    shift = np.zeros_like(radius)
    shift[side, index] = half[side, index]
    return np.concatenate([centre - shift, centre + shift], axis=1), np.concatenate([half, half], axis=1)


def _distinct(found: list[np.ndarray], low: np.ndarray, whole: np.ndarray, around: np.ndarray) -> np.ndarray:
    kept: list[np.ndarray] = []
    for point in found:
        at = np.where(around, low + (point - low) % whole, point)
        apart = [np.abs(at - other) / whole for other in kept]
        if not any((np.minimum(a, np.where(around, 1 - a, a)) <= _SAME).all() for a in apart):
            kept.append(at)
    return np.array(sorted(kept, key=lambda p: p.tolist())).T.reshape(len(low), len(kept))
