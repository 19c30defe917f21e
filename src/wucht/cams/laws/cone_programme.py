"""Second-order cone programmes of the synthesis: an objective over linear restrictions and cones, and their solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.errors import RunError

REMEDY = "its restrictions leave hardly any admissible motion; widen them, or request fewer harmonics"
_TOLERANCE = 1e-10  # of the interior point method, relative
_ROUNDING, _MOST_REFINEMENTS = 1e-16, 50
_VIOLATION = 1e-7  # of the bounds: restrictions may be violated by so much in a solution
_LARGE = 0.1  # units: a widening of so many is exact enough; a smaller one is computed in a smaller unit
_SMALLER = 1e-4  # times at most
_NEGLIGIBLE = 1e-12  # of the largest bound: a widening below is none
_ROUNDING_FLOOR = 1e-8  # of the largest bound: a widening below need not be known to all its digits
_RANK_TOLERANCE = 1e-13  # of the largest singular value


class InfeasibleError(Exception):
    """No x satisfies the restrictions."""


@dataclass(frozen=True, eq=False)
class Programme:
    """Minimise t, or |W x| with t = 0, over x (n,) and t >= 0 such that

    equal x = to; rows x <= bounds + widths t (m,); |(x_i, x_j)| <= size + width t for each cap (i, j, size, width).

    weights: the diagonal of W (n,); None: t is minimised.
    """

    equal: np.ndarray
    targets: np.ndarray
    rows: np.ndarray
    bounds: np.ndarray
    widths: np.ndarray
    caps: Sequence[tuple[int, int, float, float]] = ()
    weights: np.ndarray | None = None

    @property
    def size(self) -> float:
        """The largest bound."""
        return float(max([*np.abs(self.targets), *np.abs(self.bounds), *(size for _, _, size, _ in self.caps), 0.0])) or 1.0


def solve_cone_programme(programme: Programme, estimate: float = 0.0) -> tuple[np.ndarray, float]:
    """Return the optimal x (n,) and t. estimate: t of a programme with fewer rows, 0 where nothing is known.

    A ripple may be 1e-9 of the stroke: unknowns are chosen that are as large as what is to be small, and units in which t is
    about 1. Raises ``InfeasibleError``.
    """
    smallest = _NEGLIGIBLE * programme.size
    unit = max(estimate, smallest) if estimate else programme.size
    try:
        x, t = _interior_point(programme, _basis(programme, unit), unit)
    except RunError:
        if not estimate:
            raise
        return solve_cone_programme(programme)  # a unit that is much too small
    while programme.weights is None and t < _LARGE * unit and unit > smallest:
        unit = max(t, _SMALLER * unit, smallest)
        try:
            x, t = _interior_point(programme, _basis(programme, unit), unit)
        except RunError:
            if t > _ROUNDING_FLOOR * programme.size:
                raise
            break  # a widening that rounding hides is as good as none
    return x, t


def _basis(p: Programme, unit: float) -> np.ndarray:
    """Return B (n, n) with x = B z, such that rows B over their bounds are orthonormal as far as they determine x; or W B.

    unit: the unit of the bounds; t is about as large.
    """
    slack = np.abs(p.bounds) / unit + p.widths
    tight = p.rows / np.where(slack > 0, slack, 1.0)[:, None] if p.weights is None else np.diag(p.weights)
    if not len(tight):
        return np.eye(p.rows.shape[1])
    _, singular_values, directions = np.linalg.svd(np.vstack([tight, np.zeros((tight.shape[1],) * 2)]), full_matrices=False)
    sizes = np.where(singular_values > _RANK_TOLERANCE * singular_values[0], singular_values, singular_values[0] or 1.0)
    return np.asarray(directions.T / sizes)


def _interior_point(p: Programme, basis: np.ndarray, unit: float) -> tuple[np.ndarray, float]:
    import clarabel
    from scipy.sparse import csc_matrix

    n = len(basis)
    equal, equal_size = _normalised_rows(np.column_stack([p.equal @ basis, np.zeros(len(p.targets))]))
    rows, rows_size = _normalised_rows(np.column_stack([p.rows @ basis, -p.widths]))
    blocks, sides = [equal, rows, -np.eye(n + 1)[n:]], [p.targets / unit / equal_size, p.bounds / unit / rows_size, np.zeros(1)]
    cones: list[Any] = [clarabel.ZeroConeT(len(p.targets)), clarabel.NonnegativeConeT(len(p.bounds) + 1)]
    for i, j, size, width in p.caps:
        blocks.append(np.column_stack([-np.vstack([np.zeros(n), basis[[i, j]]]), [-width, 0.0, 0.0]]))
        sides.append(np.array([size / unit, 0.0, 0.0]))
        cones.append(clarabel.SecondOrderConeT(3))
    square, linear = np.zeros((n + 1, n + 1)), np.append(np.zeros(n), 1.0)
    if p.weights is not None:
        square[:n, :n] = (basis.T * p.weights**2) @ basis
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _TOLERANCE
    # The solver regularises its linear systems; refined to rounding, they are solved where a ripple is 1e-7 of the stroke.
    settings.iterative_refinement_reltol = settings.iterative_refinement_abstol = _ROUNDING
    settings.iterative_refinement_max_iter = _MOST_REFINEMENTS
    whole, right_side = np.vstack(blocks), np.concatenate(sides)
    result = clarabel.DefaultSolver(csc_matrix(np.triu(square)), linear, csc_matrix(whole), right_side, cones, settings).solve()
    if "Infeasible" in str(result.status):
        raise InfeasibleError
    z = np.asarray(result.x)
    # The solver measures against the size of z, which grows without end where the restrictions contradict each other.
    if "Solved" not in str(result.status) or np.abs(whole @ z + result.s - right_side).max() > _VIOLATION * (
        1 + np.abs(right_side).max()
    ):
        raise RunError(f"no motion law could be computed ({result.status}): {REMEDY}")
    return unit * basis @ z[:n], float(unit * z[n])


def _normalised_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows (m, n) of length 1, and their original lengths (m,)."""
    size = np.linalg.norm(rows, axis=1)
    size[size == 0] = 1.0
    return rows / size[:, None], size
