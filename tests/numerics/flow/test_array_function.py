"""Programs at many points: the numbers of NumPy, each point to the last bit the same whatever is beside it."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow import array_function as module
from wucht.numerics.flow.array_function import ArrayFunction
from wucht.numerics.flow.program import Program, lower
from wucht.system import System

a, w, m, l = sp.symbols("a w m l", real=True)  # noqa: E741
CONSTANTS = np.array([[2.0], [0.5]])


def program(*results: sp.Expr) -> Program:
    return lower(System((a, w), (sp.S.Zero, sp.S.Zero), (m, l)), results)


def states(count: int, members: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(-3, 3, (2, count, members))


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (80, 7), (700, 40)])
def test_it_is_what_numpy_computes(shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    function, x = ArrayFunction(program(m * sp.sin(a) * w**2, w / (l + sp.cos(a) ** 2))), states(*shape)
    constants = np.repeat(CONSTANTS, shape[1], axis=1) * np.arange(1, shape[1] + 1)
    found = function(x, constants)
    monkeypatch.setattr(module, "heyoka_function", lambda _: None)
    np.testing.assert_allclose(found, ArrayFunction(function.program)(list(x), constants), rtol=1e-13)
    assert found.shape == (2, *shape)


def test_a_point_does_not_depend_on_the_others() -> None:
    function, x = ArrayFunction(program(sp.sin(a) / (l + w**2), sp.exp(m * a))), states(300, 90)
    whole = function(x, CONSTANTS)
    for rows, members in ((slice(0, 1), slice(3, 4)), (slice(5, 200), slice(1, 90)), (slice(299, 300), slice(0, 17))):
        assert np.array_equal(function(x[:, rows, members], CONSTANTS), whole[:, rows, members])


def test_states_are_handed_on_and_constants_need_none() -> None:
    x = states(4, 3)
    assert np.array_equal(ArrayFunction(program(w, a))(x, np.empty((0, 1))), x[::-1])
    alone = lower(System((), (), (m, l)), (m * l,))
    assert np.array_equal(ArrayFunction(alone)(np.empty((0, 4, 3)), np.array([[6.0]])), np.full((1, 4, 3), 6.0))


def test_a_point_at_which_nothing_can_be_computed_leaves_the_others_alone() -> None:
    function, x = ArrayFunction(program(m / w + l, a)), states(2, 3)
    x[1, 1, 1] = 0.0
    found = function(x, CONSTANTS)
    assert np.isfinite(found).sum() == found.size - 1
    assert not np.isfinite(found[0, 1, 1])
