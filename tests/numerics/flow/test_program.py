"""Lowering: what is constant during a run is computed once, what nobody needs is left out."""

import numpy as np
import sympy as sp
from tests.refusals import failed, rejected

from wucht.numerics.flow.program import Evaluator, lower
from wucht.system import Output, System

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


def test_evaluator_of_outputs_over_arrays():
    system = System((a, w), (w, -a), (m, l), ((u, m * l**2 * w),), (Output("momentum", u), Output("mass", m)))
    evaluate = Evaluator.of(system, [o.expression for o in system.outputs], ["momentum", "mass"])
    states = np.array([[0.0, 0.1, 0.2], [1.0, 2.0, 3.0]])
    outputs = evaluate(np.arange(3.0), states, [2.0, 3.0])
    assert outputs["momentum"].tolist() == [18.0, 36.0, 54.0]
    assert outputs["mass"].tolist() == [2.0, 2.0, 2.0]  # one number a sample, although it is constant
