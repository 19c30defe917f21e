from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import failed

from wucht.numerics.collocation.condensation import CollocationJacobian

RNG = np.random.default_rng(5)


def random_jacobian(intervals: int, m: int, n: int, q: int, integrals: int, growth: float = 0.0) -> CollocationJacobian:
    """n + q - 1 conditions, so many of them on integrals. growth: of some directions, and decay of others, per interval."""
    inner = np.eye(m * n) + 0.3 * RNG.normal(size=(intervals, m * n, m * n)) / np.sqrt(m * n)
    first = 0.5 * RNG.normal(size=(intervals, m * n, n))
    if growth:
        rates = np.exp(np.where(np.arange(n) % 2, growth, -growth))
        turn = np.linalg.qr(RNG.normal(size=(n, n)))[0]
        first[:, -n:] = -(turn * rates) @ turn.T
        inner[:, -n:] = np.eye(m * n)[-n:]
    ends = n + q - 1 - integrals
    return CollocationJacobian(
        first,
        inner,
        RNG.normal(size=(intervals, m * n, q)),
        RNG.normal(size=(ends, n)),
        RNG.normal(size=(ends, n)),
        RNG.normal(size=(ends, q)),
        RNG.normal(size=(integrals, intervals, m + 1, n)) / intervals,
        RNG.normal(size=(integrals, q)),
    )


def full(j: CollocationJacobian, row: np.ndarray) -> np.ndarray:
    intervals, m, n, q = j.shape
    size = (intervals * m + 1) * n
    matrix = np.zeros((size + q, size + q))
    for i in range(intervals):
        rows, begin = slice(i * m * n, (i + 1) * m * n), i * m * n
        matrix[rows, begin : begin + n] = j.first[i]
        matrix[rows, begin + n : begin + (m + 1) * n] = j.inner[i]
        matrix[rows, size:] = j.by_parameters[i]
        for k, integral in enumerate(j.integrals):
            matrix[size - n + len(j.begin) + k, begin : begin + (m + 1) * n] += integral[i].ravel()
    ends = slice(intervals * m * n, intervals * m * n + len(j.begin))
    matrix[ends, :n], matrix[ends, size - n : size], matrix[ends, size:] = j.begin, j.end, j.ends_by_parameters
    matrix[ends.stop : -1, size:] = j.integrals_by_parameters
    matrix[-1] = row
    return matrix


@pytest.mark.parametrize("n", [1, 4])
@pytest.mark.parametrize(("intervals", "m"), [(1, 2), (7, 3), (61, 2)])
@pytest.mark.parametrize(("q", "integrals"), [(1, 0), (4, 3)])
def test_solution_is_that_of_the_full_matrix(n: int, intervals: int, m: int, q: int, integrals: int) -> None:
    """With few and many intervals, whose number four does not divide, and several right sides."""
    j = random_jacobian(intervals, m, n, q, integrals)
    row = RNG.normal(size=(intervals * m + 1) * n + q)
    matrix = full(j, row)
    wanted = RNG.normal(size=(len(row), 2))
    sides = matrix @ wanted
    x = j.solve(row, sides)
    scale = np.linalg.cond(matrix) * np.abs(wanted).max()
    assert np.abs(x - wanted).max() < 1e-13 * scale
    # Stable: what is left of the equations is rounding, whatever the condition is.
    assert np.abs(matrix @ x - sides).max() < 1e-11 * np.abs(matrix).max() * np.abs(x).max()


def test_growth_and_decay_together_cost_no_digits() -> None:
    """exp(+-300) in all: what elimination forward from the first value would lose."""
    j = random_jacobian(150, 1, 2, 2, 1, growth=2.0)
    row = RNG.normal(size=151 * 2 + 2)
    matrix, wanted = full(j, row), RNG.normal(size=151 * 2 + 2)
    assert np.linalg.cond(matrix) < 1e6
    np.testing.assert_allclose(j.solve(row, (matrix @ wanted)[:, None])[:, 0], wanted, atol=1e-10)


def test_singular_equations_are_told() -> None:
    j = random_jacobian(5, 2, 2, 2, 1)
    with failed("singular"):
        j.solve(np.zeros(5 * 2 * 2 + 2 + 2), np.ones((24, 1)))
