"""The direct separation of motions, 001 (1)-(7)."""

import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.mechanics.separation import THETA, separated
from wucht.system import TIME, Output, System

x, v, y, w = sp.symbols("x v y w", real=True)
a, g, L, k, d, m = sp.symbols("a g L k d m", positive=True)
PENDULUM = System((x, v), (v, -(g - a * k**2 * sp.cos(k * TIME)) / L * sp.sin(x) - d * v), (a, g, L, k, d))


def zero(expression):
    return sp.simplify(expression) == 0


def test_kapitza():
    """The pivot moves by a cos(k t): the vibrational force has the potential (a k sin x)^2/(4 L^2)."""
    separation = separated(PENDULUM, [x], k, mass=sp.Matrix([m]))
    potential = -g / L * sp.cos(x) + (a * k * sp.sin(x)) ** 2 / (4 * L**2)
    assert zero(separation.system.derivatives[1] + sp.diff(potential, x) + d * v)
    assert zero(separation.slow_force[0] + m * (g / L * sp.sin(x) + d * v))
    assert zero(separation.fast_force[0] - m * a * k**2 / L * sp.cos(THETA) * sp.sin(x))
    assert zero(separation.vibration_force[0] + m * (a * k / L) ** 2 * sp.sin(x) * sp.cos(x) / 2)
    upright = sp.diff(potential, x, 2).xreplace({x: sp.pi})
    assert zero(upright - ((a * k) ** 2 / (2 * L**2) - g / L))  # stable where (a k)^2 > 2 g L


def test_a_rotor_whose_axis_is_shaken():
    """001 (12)-(20): phi = W t + alpha gives J alpha'' + k1 alpha' = k1 (W1 - W) - (1/2) m1 e1 W^2 x0 sin alpha."""
    J, k1, W, W1, U, x0 = sp.symbols("J k1 Omega Omega1 U x0", positive=True)
    shaking = -(W**2) * x0 * sp.cos(W * TIME)
    torque = k1 * (W1 - W) - k1 * v + U * shaking * sp.sin(W * TIME + x)
    separation = separated(System((x, v), (v, torque / J), (J, k1, W, W1, U, x0), angles=frozenset({x})), [x], W)
    assert zero(J * separation.system.derivatives[1] - k1 * (W1 - W) + k1 * v + U * W**2 * x0 * sp.sin(x) / 2)
    assert separation.system.angles == {x}
    ripple = U * x0 * sp.sin(2 * THETA + x) / (8 * J)  # of the fluctuation at twice the speed
    assert zero(separation.fast[0] - ripple)


def test_two_coordinates():
    """The force of a fast field with a potential: Phi = -grad(U) cos(k t) gives -grad |grad U|^2/(4 k^2)."""
    U = x**2 * y + sp.cos(y)
    phi = [-sp.diff(U, s) for s in (x, y)]
    rates = (v, w, phi[0] * sp.cos(k * TIME) - x, phi[1] * sp.cos(k * TIME) - sp.sin(TIME) * y)
    separation = separated(System((x, y, v, w), rates, (k,)), [x, y], k)
    effective = (phi[0] ** 2 + phi[1] ** 2) / (4 * k**2)
    for force, s in zip(separation.vibration_force, (x, y), strict=True):
        assert zero(force + sp.diff(effective, s))
    assert zero(separation.system.derivatives[3] - separation.vibration_force[1] + sp.sin(TIME) * y)  # slow time stays


def test_quadratic_damping_feels_the_fast_speed():
    """<(X' + xi')^2> = X'^2 + <xi'^2>, with xi' = (f/k) sin(k t): F at the full speed (5)."""
    f = sp.Symbol("f", real=True)
    separation = separated(System((x, v), (v, -d * v**2 + f * sp.cos(k * TIME)), (d, f, k)), [x], k)
    assert zero(separation.system.derivatives[1] + d * (v**2 + f**2 / (2 * k**2)))


def test_outputs_and_quadratures():
    system = System(PENDULUM.states, PENDULUM.derivatives, PENDULUM.parameters, (),
                    (Output("height", -sp.cos(x), "m"),), (Output("lost", d * v**2, "J"),))  # fmt: skip
    slow = separated(system, [x], k).system
    assert zero(slow.explicit(slow.output("full.x").expression) - x + a / L * sp.cos(k * TIME) * sp.sin(x))
    assert zero(slow.explicit(slow.output("height").expression) + sp.cos(x - a / L * sp.cos(k * TIME) * sp.sin(x)))
    assert zero(slow.output("lost").expression - d * (v**2 + (a * k * sp.sin(x) / L) ** 2 / 2))


@pytest.mark.parametrize(
    "force, refusal",
    [
        (-x, rejected("no-fast-force")),
        (sp.cos(k * TIME / 2), rejected("other-period", "2")),
        (sp.cos(k * TIME**2), rejected("not-fast", "k", "t")),
        (sp.cos(k * TIME) - sp.Abs(v) * v, rejected("not-rational", "v")),
        (sp.exp(sp.cos(k * TIME)), rejected("uneven-argument")),
        (
            sp.tan(k * TIME) / (2 + sp.tan(k * TIME) ** 2) + k * sp.cos(k * TIME) * sp.sin(x),
            rejected("not-trigonometric", "k", "t"),
        ),
        (1 / (1 + k * TIME) + sp.cos(k * TIME), rejected("not-trigonometric", "k", "t")),
        (k * TIME * x + sp.cos(k * TIME), rejected("secular")),
        (-x + k**3 * sp.cos(k * TIME), rejected("grows", "k", "3")),
        (-x + a * k**3 * sp.cos(k * TIME), rejected("grows", "k", "3")),
        (-x + k * v * sp.cos(k * TIME), rejected("grows", "k", "1")),
        (sp.sqrt(1 + k**2) * sp.cos(k * TIME), rejected("growth-unclear", "k")),
    ],
)
def test_refusals(force, refusal):
    with refusal:
        separated(System((x, v), (v, force), (k, a)), [x], k)


def test_a_system_that_is_not_of_second_order_is_refused():
    with rejected("no-state", "y"):
        separated(PENDULUM, [y], k)
    with rejected("other-states"):
        separated(System((x, v), (-v, sp.cos(k * TIME)), (k,)), [x], k)
    given = System((x, v), (v, k * sp.cos(k * TIME)), (k,), quadratures=(Output("Q", x, jump=v),))
    with rejected("jumps", "Q", "k", "t"):
        separated(given, [x], k)
