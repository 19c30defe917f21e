"""Newton's method for a boundary value problem from far away: damped, by what is left as the last linearisation measures it.

That measure does not depend on the units of the equations, and accepts the whole step where the linearisation holds.
P. Deuflhard, "Newton Methods for Nonlinear Problems", Springer 2011, section 3.3 (natural monotonicity test); U. M. Ascher,
R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential Equations", SIAM
1995, section 8.1.
"""

from __future__ import annotations

import numpy as np

from wucht.errors import RunError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem

_LEAST = 2.0**-8  # share of a step
_ROUNDED = 1e-7  # corrections that small and no longer smaller are rounding


def solved(
    problem: BoundaryValueProblem, u: np.ndarray, row: np.ndarray, positive: int, most_steps: int, tolerance: float
) -> tuple[np.ndarray, int]:
    """The solution near u in the plane through it across a row, and after how many steps.

    Parameters
    ----------
    problem : BoundaryValueProblem
    u, row : ndarray
        Of all unknowns; changes of u are zero along the row.
    positive : int
        Index of an unknown that stays positive: of a period.
    most_steps : int
    tolerance : float
        Of the correction that is left, by the problem's scale.

    Raises
    ------
    RunError
        Where Newton's method does not converge.
    """
    scale = problem.scale

    def correction(jacobian: object, off: np.ndarray) -> tuple[np.ndarray, float]:
        sides = np.append(off, 0.0)[:, None]
        change = problem.solution(jacobian, row, sides)[0][:, 0]  # type: ignore[arg-type]
        return change, float(np.linalg.norm(change / scale))

    off, jacobian = problem.residual(u)
    change, size = correction(jacobian, off)
    share = 1.0
    for step in range(1, most_steps + 1):
        while True:
            at = u - share * change
            if at[positive] > 0:
                off, after = problem.residual(at)
                rest, left = correction(jacobian, off)
                if left <= max((1 - share / 2) * size, tolerance) or (share == 1.0 and left < _ROUNDED and left < 2 * size):
                    break
            share /= 2
            if not share >= _LEAST:
                raise RunError("Newton's method does not converge", code="no-convergence")
        u = at
        if share == 1.0 and (left <= tolerance or size / 2 < left < _ROUNDED):
            return u - rest, step
        jacobian, (change, size) = after, correction(after, off)
        share = min(1.0, 2 * share)
    raise RunError(f"after {most_steps} steps of Newton's method {size:.2g} is left", code="too-many-steps")
