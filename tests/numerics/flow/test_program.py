"""Lowering: what is constant during a run is computed once, what nobody needs is left out."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from tests.refusals import failed, rejected

from wucht.numerics.flow.point_function import point_function
from wucht.numerics.flow.program import Program, lower
from wucht.system import TIME, System

a, w, u, v = sp.symbols("a w u v", real=True)
m, l, g, c = sp.symbols("m l g c", real=True)  # noqa: E741


def test_parameters_are_folded_into_constants():
    pendulum = System((a, w), (w, -m * g * l * sp.sin(a) / (m * l**2) - c * w / (m * l**2)), (m, l, g, c))
    program = lower(pendulum, pendulum.derivatives)
    left = set().union(*(r.free_symbols for r in program.results))
    assert not left & {m, l, g, c}
    assert left == {a, w, *(s for s, _ in program.constants)}
    assert len(program.constants) == 2  # -g/l and -c/(m l^2), whatever the number of parameters
    constants = dict(zip([s for s, _ in program.constants], program.constant_values([2.0, 0.5, 10.0, 3.0]), strict=True))
    acceleration = program.results[1].xreplace(constants | {a: sp.pi / 2, w: 1.0})
    assert float(acceleration) == -20.0 - 6.0


def test_constant_definitions_become_constants_and_unused_ones_disappear():
    system = System((a, w), (w, u * sp.sin(a)), (m, l), ((u, m * l**2), (v, u * sp.cos(a) + w), (g, v**2)))
    assert lower(system, system.derivatives).lines == ()
    needing_all = lower(system, (g,))
    assert [s for s, _ in needing_all.lines] == [v, g]
    assert [e for _, e in needing_all.constants] == [m * l**2]


def test_what_is_another_line_or_its_opposite_or_a_multiple_is_put_into_what_uses_it():
    lines = ((u, m + sp.cos(a) * w), (v, -m - sp.cos(a) * w), (g, m * sp.sin(a)))
    program = lower(System((a, w), (sp.S.Zero, sp.S.Zero), (m, l), lines), (v * u, g * l * sp.sin(a)))
    assert [s for s, _ in program.lines] == [u]
    (_, one), (product, other) = program.constants
    assert (one, other) == (m, l * m)
    assert program.results == (-(u**2), product * sp.sin(a) ** 2)
    found = program.function()([0.3, 0.7], 0.0, program.constant_values([2.0, 5.0]))
    np.testing.assert_allclose(found, [-((2 + np.cos(0.3) * 0.7) ** 2), 10 * np.sin(0.3) ** 2], rtol=1e-15)


def test_parameters_with_which_nothing_can_be_computed():
    system = System((a,), (a / (m - l),), (m, l))
    program = lower(system, system.derivatives)
    with failed("not-evaluated", "m = 2", "l = 2"):
        program.constant_values([2.0, 2.0])
    with failed("not-evaluated", "m = nan"):
        program.constant_values([np.nan, 1.0])


def test_a_system_asks_for_all_its_parameters():
    system = System((a,), (m * a * l,), (m, l))
    assert system.values({"l": 2, "m": 1, "more": 3}) == (1.0, 2.0)
    with rejected("no-value", "l"):
        system.values({"m": 1.0})


MANY = System((a, w), (sp.S.Zero, sp.S.Zero), (m, l))
RESULTS = (m * sp.sin(a) * w**2, w / (l + sp.cos(a) ** 2) + TIME, sp.exp(m * a), sp.sqrt(w - 1))


def program(*results: sp.Expr) -> Program:
    return lower(MANY, results)


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


def test_without_states_or_constants() -> None:
    nothing = lower(System((), (), ()), (sp.S.One, TIME))
    assert point_function(nothing)(np.empty((0, 3)), np.empty(0), 2.0).tolist() == [[1.0] * 3, [2.0] * 3]
