"""Averaging of partially strongly damped systems, 002 (3.14)-(3.26) corrected."""

import pytest
import sympy as sp
from pytest import raises
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.strong_damping import stability_conditions, strongly_damped
from wucht.system import TIME, Output, System

x, y, z, epsilon, u, lam, phi, xi, eta, dxi, deta = sp.symbols("x y z epsilon u lambda phi xi eta dxi deta", real=True)
sigma, omega, k = sp.symbols("sigma omega k", positive=True)

# As in 002: at epsilon = 0 nothing but K y. The manifold is y = epsilon eta_1.
UNFORCED = System(
    (x, y, z),
    (
        epsilon * (1 - x + y * sp.cos(TIME) + x * sp.sin(TIME) + y * z),
        -y + 2 * z + epsilon * (x * sp.cos(TIME) + y**2),
        -2 * y - z + epsilon * x**2,
    ),
    (epsilon,),
)
# With K(x) and a forcing at epsilon = 0: the manifold is a forced motion.
FORCED = System(
    (x, y), (epsilon * (1 - x + y * sp.cos(TIME) - y**2), -(1 + x**2) * y + x * sp.cos(TIME) + epsilon * y * x), (epsilon,)
)


def zero(expression):
    return sp.simplify(expression) == 0


def forced(rate, force):
    """The periodic solution of y' = -rate y + force cos t."""
    return force * (rate * sp.cos(TIME) + sp.sin(TIME)) / (rate**2 + 1)


def test_without_forcing_the_damped_states_are_zero():
    """(3.24)-(3.25): eta_0 = 0; what is left of y is epsilon times the bounded solution of y' = K y + Y(x, 0, t)."""
    reduction = strongly_damped(UNFORCED, [y, z], epsilon)
    assert reduction.manifold == (0, 0)
    assert zero(reduction.averaging.first[0] - (1 - x))
    assert reduction.conditions == ()
    K, Y = reduction.rates, sp.Matrix([x * sp.cos(TIME), x**2])
    following = sp.Matrix(reduction.next)
    assert (sp.diff(following, TIME) - K * following - Y).applyfunc(sp.simplify) == sp.zeros(2, 1)


def test_with_forcing_they_follow_it():
    reduction = strongly_damped(FORCED, [y], epsilon)
    expected = forced(1 + x**2, x)
    assert zero(reduction.manifold[0] - expected)
    c = x / ((1 + x**2) ** 2 + 1)  # <eta_0 cos t> = c (1 + x^2)/2, <eta_0^2> = c^2 ((1 + x^2)^2 + 1)/2 = c x/2
    assert zero(reduction.averaging.first[0] - (1 - x + c * (1 + x**2) / 2 - c * x / 2))


def test_outputs_and_quadratures_know_the_damped_states():
    system = System(FORCED.states, FORCED.derivatives, FORCED.parameters, (),
                    (Output("sum", x + y),), (Output("heat", y**2, "J"),))  # fmt: skip
    slow = strongly_damped(system, [y], epsilon).averaging.system
    assert [o.name for o in slow.outputs] == ["full.x", "full.y", "sum"]
    X, Y = (slow.output(f"full.{n}").expression for n in "xy")
    assert slow.output("sum").expression == X + Y
    assert zero(dict(slow.definitions)[Y] - forced(1 + X**2, X))  # over the full x, not over its mean
    assert zero(slow.output("heat").expression - x**2 / ((1 + x**2) ** 2 + 1) / 2)


def test_stability():
    """Hurwitz: of what is known nothing is said, of what is not a condition is left, of what fails an error."""
    a, b = sp.symbols("a b", real=True)
    assert stability_conditions(sp.Matrix([[0, 1], [-k, -2 * sigma]])) == ()  # not negative in the Euclidean norm, but stable
    assert stability_conditions(sp.Matrix([[0, 1], [-a, -b]])) == (b, a * b)
    # s^3 + a s^2 + b s + k: a > 0, a b > k.
    conditions = stability_conditions(sp.Matrix([[0, 1, 0], [0, 0, 1], [-k, -b, -a]]))
    assert {sp.expand(c) for c in conditions} == {a, a * b - k, sp.expand(k * (a * b - k))}
    for matrix in ([[1]], [[0, 1], [-1, 0]], [[-1, 3], [1, -1]], [[0, 1], [-k, sigma]]):
        with rejected("unstable"):
            stability_conditions(sp.Matrix(matrix))


@pytest.mark.parametrize(
    "rate, sentence",
    [
        (y + epsilon, "is not stable"),
        (-(y**3) + epsilon, "not linear"),
        (-(2 + sp.cos(TIME)) * y, "depends on t"),
        (-y + TIME, "forcing of y cannot be averaged.*secular"),
        (-y + epsilon * sp.cos(x * TIME), "frequency in .* depends on x"),
        (-y + sp.cos(TIME) + epsilon * TIME, "slow time"),
        (-y + sp.sqrt(epsilon), "no expansion"),
    ],
)
def test_refusals(rate, sentence):
    with raises(WuchtError, match=sentence):
        strongly_damped(System((x, y), (epsilon * y, rate), (epsilon,)), [y], epsilon)


@pytest.mark.parametrize(("of_order", "follows"), [(1, 0), (2, 3 * epsilon * x)])
def test_jumps_are_as_accurate_as_the_motion(of_order, follows):
    """y' = x^2 - y + 5 epsilon x with x' = epsilon: y is x^2, and in the second order 5 epsilon x - 2 x x' more."""
    system = System((x, y), (epsilon, x**2 - y + 5 * epsilon * x), (epsilon,), quadratures=(Output("Q", y, jump=3 * y),))
    slow = strongly_damped(system, [y], epsilon, of_order).averaging.system
    assert zero(slow.output("Q").jump - 3 * (x**2 + follows))


def test_jumps_of_quadratures_know_definitions_and_damped_states():
    half, K = sp.Symbol("half", real=True), 2 + x
    given = System((x, y), (epsilon * (half - x * y), -K * y + x), (epsilon,), ((half, x / 2),),
                   quadratures=(Output("Q", y + half, jump=half * y), Output("P", x, jump=half)))  # fmt: skip
    slow = strongly_damped(given, [y], epsilon).averaging.system
    assert zero(slow.output("Q").jump - x / 2 * x / K)
    assert zero(slow.output("P").jump - x / 2)
    turning = System((x, y), (epsilon * x, -y + sp.cos(TIME)), (epsilon,), quadratures=(Output("Q", y, jump=y),))
    with rejected("jumps", "Q", "t"):
        strongly_damped(turning, [y], epsilon)


def test_which_states_are_damped_must_be_told():
    for damped in ([], [x, y], [z]):
        with rejected("damped-states"):
            strongly_damped(FORCED, damped, epsilon)
