"""All zeros of a function in a box, proved to be all: subdivision with bounds on the Jacobian.

In a box of centre c and radii r, with |J(y) - J(c)| <= D entrywise for all its y:
 - |f_i(c)| > sum_j (|J_ij(c)| + D_ij) r_j for an i: the box holds no zero (mean value theorem);
 - Y = J(c)^-1: all its zeros lie in K, the box of centre c - Y f(c) and radii |Y| D r; where K is inside the box, it holds
   exactly one; where both are disjoint, none (R. Krawczyk, Computing 4 (1969) 187-201; A. Neumaier, "Interval Methods for
   Systems of Equations", Cambridge 1990, chapter 5).
Undecided boxes are bisected. Rounding is covered by a margin, not by directed rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Function = Callable[[np.ndarray], np.ndarray]
Spread = Callable[[np.ndarray, np.ndarray], np.ndarray]
ProvedZero = tuple[
    np.ndarray, np.ndarray, np.ndarray
]  # a zero (n,), centre and radii (n,) of a box in which it is the only one

_INFLATION = 1.2  # a zero on the border of a box is inside that of its inflated neighbour
_MARGIN = 1 + 1e-10  # for rounding in the bounds
_CHUNK = 16384  # boxes examined together
_ROUNDING = 1e-12  # of a side: a zero that far outside is one on the border
_NARROWEST = 1e-10  # of a side: no box is shrunk to less, where rounding would count as much as its width
_STEPS, _CONVERGENCE = 30, 1e-9  # of Newton's method inside a box that holds one zero; the last, in shares of the box


@dataclass(frozen=True)
class Zeros:
    """Zeros. points: (n, k). undecided_boxes: centres and radii (n, u) of boxes without a proof. boxes: number examined.

    Where ``undecided_boxes`` is empty there are exactly k zeros, however near to each other.
    """

    points: np.ndarray
    undecided_boxes: tuple[np.ndarray, np.ndarray]
    boxes: int

    @property
    def complete(self) -> bool:
        """True if these are proved to be all zeros."""
        return not self.undecided_boxes[0].size


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
    check: Callable[[], None] | None = None,
) -> Zeros:
    """Compute the zeros of f in the box [low, high].

    function: (n, N) -> (n, N). jacobian: (n, N) -> (n, n, N). spread: centres and radii (n, N) -> (n, n, N), a bound on how
    much each entry of the Jacobian differs from that at the centre; not finite where none is known yet. periodic: coordinates
    whose two ends are the same. smallest: of each side; smaller boxes are abandoned, as those along a curve of zeros.
    most_boxes: to be examined. check: called between some thousand boxes; an exception that it raises ends the search.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    n, whole, border = len(low), high - low, _ROUNDING * (high - low)
    around = np.zeros(n, bool) if periodic is None else np.asarray(periodic, bool)
    box_count, waiting = 0, [(((low + high) / 2)[:, None], (whole / 2)[:, None])]
    given_up: list[tuple[np.ndarray, np.ndarray]] = []
    proved_zeros: list[ProvedZero] = []
    while waiting and box_count < most_boxes:
        if check is not None:
            check()
        centre, radius = waiting.pop()
        if centre.shape[1] > _CHUNK:
            waiting.append((centre[:, _CHUNK:], radius[:, _CHUNK:]))
            centre, radius = centre[:, :_CHUNK], radius[:, :_CHUNK]
        box_count += centre.shape[1]
        remaining, zeros = _examine(function, jacobian, spread, centre, radius, _NARROWEST * whole)
        proved_zeros += [z for z in zeros if ((z[0] >= low - border) & (z[0] <= high + border) | around).all()]
        small = (remaining[1] <= smallest / 2 * whole[:, None]).all(axis=0)
        if small.any():
            given_up.append((remaining[0][:, small], remaining[1][:, small]))
        rest = _bisect(remaining[0][:, ~small], remaining[1][:, ~small], whole, jacobian)
        if rest[0].shape[1]:
            waiting.append(rest)
    given_up += waiting
    points, doubtful = _distinct_zeros(proved_zeros, low, whole, around)
    given_up += doubtful
    centres, radii = (np.concatenate([np.empty((n, 0)), *(box[k] for box in given_up)], axis=1) for k in (0, 1))
    return Zeros(points, (centres, radii), box_count)


def _examine(
    function: Function, jacobian: Function, spread: Spread, centre: np.ndarray, radius: np.ndarray, narrowest: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], list[ProvedZero]]:
    """Return the boxes that stay undecided, shrunk where possible, and zeros with the boxes in which they are the only one."""
    f, matrix = function(centre), jacobian(centre)
    wide = _INFLATION * radius
    spread_bound = spread(centre, wide) * _MARGIN
    size = np.abs(matrix)
    with np.errstate(invalid="ignore"):
        reach = np.einsum("ijN,jN->iN", size + np.where(np.isfinite(spread_bound), spread_bound, np.inf), radius)
    open_ = ~(np.abs(f) > reach * _MARGIN).any(axis=0)
    usable = open_ & np.isfinite(spread_bound).all(axis=(0, 1))
    inverse = np.zeros_like(matrix)
    with np.errstate(all="ignore"):
        scaled_matrix = np.nan_to_num(matrix / np.abs(matrix).max(axis=1, keepdims=True))
    regular = np.flatnonzero(usable & (np.abs(np.linalg.det(np.moveaxis(scaled_matrix, -1, 0))) > 1e-12))
    inverse[:, :, regular] = np.linalg.inv(np.moveaxis(matrix[:, :, regular], -1, 0)).transpose(1, 2, 0)
    usable[regular] &= np.isfinite(inverse[:, :, regular]).all(axis=(0, 1))
    usable &= inverse.any(axis=(0, 1))
    step = -np.einsum("ijN,jN->iN", inverse, np.where(usable, f, 0.0))
    spreading = np.einsum("ijN,jkN->ikN", np.abs(inverse), np.where(usable, spread_bound, 0.0)) * _MARGIN
    inside, outside = (np.einsum("ijN,jN->iN", spreading, r) for r in (wide, radius))
    open_ &= ~(usable & (np.abs(step) > (radius + outside) * _MARGIN).any(axis=0))
    unique = open_ & usable & (np.abs(step) + inside < wide / _MARGIN).all(axis=0)
    at, has_converged = _polish(function, jacobian, centre[:, unique], wide[:, unique], step[:, unique])
    unique[np.flatnonzero(unique)[~has_converged]] = False
    candidates = (at[:, has_converged], centre[:, unique], wide[:, unique])
    zeros = list(zip(*(part.T for part in candidates), strict=True))
    rest = open_ & ~unique
    low, high = centre - radius, centre + radius
    shrinkable = rest & usable
    outside = np.maximum(outside, np.minimum(radius, narrowest[:, None]))
    low[:, shrinkable] = np.maximum(low, centre + step - outside)[:, shrinkable]
    high[:, shrinkable] = np.minimum(high, centre + step + outside)[:, shrinkable]
    return ((low + high)[:, rest] / 2, (high - low)[:, rest] / 2), zeros


def _polish(
    function: Function, jacobian: Function, centre: np.ndarray, radius: np.ndarray, step: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Apply Newton's method in boxes that hold one zero each; return its results (n, k), and whether it has converged (k,).

    It is confined to its box: there the Jacobian is regular, as the test has proved.
    """
    at, has_converged = centre + step, np.array([True] * centre.shape[1], bool)
    for _ in range(_STEPS if at.shape[1] else 0):
        matrix = np.moveaxis(jacobian(at), -1, 0)
        has_converged = np.asarray(np.isfinite(matrix).all(axis=(1, 2)))
        try:
            move = -np.linalg.solve(matrix[has_converged], function(at)[:, has_converged].T[..., None])[..., 0].T
        except np.linalg.LinAlgError:  # regular on paper, singular after rounding: the boxes are cut further
            return at, np.zeros_like(has_converged)
        next_points = np.clip(
            at[:, has_converged] + move, (centre - radius)[:, has_converged], (centre + radius)[:, has_converged]
        )
        change = np.abs(next_points - at[:, has_converged])
        at[:, has_converged] = next_points
        has_converged[has_converged] = (
            change <= _CONVERGENCE * radius[:, has_converged] + 4 * np.spacing(np.abs(next_points))
        ).all(axis=0)
        if has_converged.all():
            break
    return at, has_converged


def _bisect(centre: np.ndarray, radius: np.ndarray, whole: np.ndarray, jacobian: Function) -> tuple[np.ndarray, np.ndarray]:
    """Bisect each box along the side across which the function changes most, of those not much shorter than the longest."""
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


def _distinct_zeros(
    proved_zeros: list[ProvedZero], low: np.ndarray, whole: np.ndarray, around: np.ndarray
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Return the distinct zeros (n, k), and the boxes that may hold the same zero as another one within rounding.

    Two boxes with one zero each hold the same zero where it lies in both, and only then, however near the zeros are.
    """

    def holds(box: ProvedZero, point: np.ndarray) -> bool:
        away = np.abs(point - box[1])
        return bool((np.where(around, np.minimum(away % whole, -away % whole), away) <= box[2]).all())

    distinct: list[ProvedZero] = []
    doubtful: list[tuple[np.ndarray, np.ndarray]] = []
    for candidate in proved_zeros:
        overlaps = [(holds(zero, candidate[0]), holds(candidate, zero[0])) for zero in distinct]
        if any(a and b for a, b in overlaps):
            continue
        if any(a or b for a, b in overlaps):
            doubtful.append((candidate[1][:, None], candidate[2][:, None]))
            continue
        distinct.append(candidate)
    points = [np.where(around, low + (point - low) % whole, point) for point, _, _ in distinct]
    return np.array(sorted(points, key=lambda p: p.tolist())).T.reshape(len(low), len(distinct)), doubtful
