"""A program at many points in machine code: what NumPy computes, each point for itself, in any thread."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.point_function import point_function
from wucht.numerics.flow.program import Program, lower
from wucht.system import TIME, System

a, w, m, l = sp.symbols("a w m l", real=True)  # noqa: E741
SYSTEM = System((a, w), (sp.S.Zero, sp.S.Zero), (m, l))
RESULTS = (m * sp.sin(a) * w**2, w / (l + sp.cos(a) ** 2) + TIME, sp.exp(m * a), sp.sqrt(w - 1))


def program(*results: sp.Expr) -> Program:
    return lower(SYSTEM, results)


def points(*shape: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(-3, 3, (2, *shape))


@pytest.mark.parametrize("shape", [(), (0,), (9,), (200,)])
def test_it_is_what_numpy_computes(shape: tuple[int, ...]) -> None:
    whole, x, constants = program(*RESULTS), points(*shape), program(*RESULTS).constant_values([2.0, 0.5])
    with np.errstate(all="ignore"):
        expected = [np.broadcast_to(v, shape) for v in whole.function()(tuple(x), 0.25, constants)]
    values = point_function(whole)(x, constants, 0.25)
    assert values.shape == (4, *shape)
    np.testing.assert_allclose(values, expected, rtol=1e-13)  # not a number where the root has none


def test_a_point_does_not_depend_on_the_others() -> None:
    whole, x = program(*RESULTS), points(90)
    constants = whole.constant_values([2.0, 0.5])
    values = point_function(whole)(x, constants)
    for part in (slice(0, 1), slice(5, 20), slice(17, 90), slice(0, 90, 7)):
        assert np.array_equal(point_function(whole)(x[:, part], constants), values[:, part], equal_nan=True)
    assert np.array_equal(point_function(whole)(x[:, 4], constants), values[:, 4], equal_nan=True)


def test_threads_share_a_function() -> None:
    whole = program(*RESULTS)
    constants = [whole.constant_values([1.0 + k, 0.5]) for k in range(4)]
    alone = [point_function(whole)(points(500), c) for c in constants]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(20):
            together = list(pool.map(lambda c: point_function(whole)(points(500), c), constants))
            assert all(np.array_equal(one, other, equal_nan=True) for one, other in zip(alone, together, strict=True))


def test_without_states_or_constants() -> None:
    nothing = lower(System((), (), ()), (sp.S.One, TIME))
    assert point_function(nothing)(np.empty((0, 3)), np.empty(0), 2.0).tolist() == [[1.0] * 3, [2.0] * 3]
