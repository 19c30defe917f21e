"""The coefficients against the conditions of order, one for each rooted tree: HNW II.2, theorem 2.13."""

from __future__ import annotations

from functools import cache
from itertools import combinations_with_replacement, product
from math import prod

import numpy as np
import pytest

from wucht.numerics.flow.compiled.dormand_prince import DENSE, ERROR_3, ERROR_5, NODES, STAGES, WEIGHTS, A

Tree = tuple["Tree", ...]  # of its root's branches


@cache
def partitions(total: int, largest: int) -> list[tuple[int, ...]]:
    if total == 0:
        return [()]
    return [(k, *rest) for k in range(min(total, largest), 0, -1) for rest in partitions(total - k, k)]


@cache
def trees(order: int) -> list[Tree]:
    result: list[Tree] = []
    for sizes in partitions(order - 1, order - 1):
        groups = [combinations_with_replacement(trees(k), sizes.count(k)) for k in sorted(set(sizes))]
        result += [tuple(branch for group in choice for branch in group) for choice in product(*groups)]
    return result


def size(tree: Tree) -> int:
    return 1 + sum(map(size, tree))


def density(tree: Tree) -> int:
    return size(tree) * prod(map(density, tree))


def stage_values(tree: Tree, a: np.ndarray) -> np.ndarray:
    """Product over the branches of what each contributes to every stage."""
    return np.prod([a @ stage_values(branch, a) for branch in tree], axis=0) if tree else np.ones(len(a))


def largest_defect(weights: np.ndarray, order: int, at: float = 1.0) -> float:
    a = A[: len(weights), : len(weights)]
    return max(abs(weights @ stage_values(t, a) - at ** size(t) / density(t)) for t in trees(order))


def test_numbers_of_trees() -> None:
    assert [len(trees(k)) for k in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


@pytest.mark.parametrize(("weights", "order"), [(WEIGHTS, 8), (WEIGHTS - ERROR_5, 5), (WEIGHTS - ERROR_3, 3)])
def test_the_order_is_what_it_is_called_and_no_more(weights: np.ndarray, order: int) -> None:
    assert max(largest_defect(weights, k) for k in range(1, order + 1)) < 5e-15
    assert largest_defect(weights, order + 1) > 1e-8


def test_stages_lie_at_the_sums_of_their_coefficients() -> None:
    assert np.abs(A.sum(axis=1) - NODES).max() < 2e-15
    assert (np.triu(A) == 0).all() and (A[STAGES, :STAGES] == WEIGHTS).all()


@pytest.mark.parametrize("x", [0.37, 0.93])
def test_the_dense_output_is_of_order_7(x: float) -> None:
    """Its weights at a part x of the step, as the stepper combines them."""
    at_end, at_begin, after_end = np.append(WEIGHTS, np.zeros(4)), np.eye(16)[0], np.eye(16)[STAGES]
    rows = [at_end, at_begin - at_end, 2 * at_end - after_end - at_begin, *DENSE]
    weights = np.zeros(16)
    for row in range(6, -1, -1):
        weights = (weights + rows[row]) * (x if row % 2 == 0 else 1 - x)
    assert max(largest_defect(weights, k, x) for k in range(1, 8)) < 1e-13
    assert largest_defect(weights, 8, x) > 1e-9
