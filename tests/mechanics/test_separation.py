"""The direct separation of motions, 001 (1)-(7)."""

import numpy as np
import pytest
import sympy as sp
from convergence import full, order, run
from pytest import approx, raises
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.means import mean
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


def test_the_fast_part_solves_its_equation_with_mean_zero():
    """m k^2 d2xi/dtheta2 = Phi and (3)."""
    separation = separated(PENDULUM, [x], k)
    assert zero(k**2 * sp.diff(separation.fast[0], THETA, 2) - separation.fast_force[0])
    assert zero(k * sp.diff(separation.fast[0], THETA) - separation.rate[0])
    assert mean(separation.fast[0], THETA) == 0


def test_kapitza_is_the_same_by_averaging_the_standard_form():
    """Another formulation: theta' = e (p + sin T sin theta) in T = k t, e = a/L, averaged, and its second derivative in t."""
    p, e = sp.symbols("p e", real=True)
    kappa = g * L / (a * k) ** 2
    momentum = -kappa * sp.sin(x) - sp.sin(TIME) * sp.cos(x) * (p + sp.sin(TIME) * sp.sin(x))
    slow = averaged(System((x, p), (e * (p + sp.sin(TIME) * sp.sin(x)), e * momentum), (e, g, L, a, k)), e)
    acceleration = slow.system.derivatives[1] * e * k**2  # x'' = e p'
    undamped = System(PENDULUM.states, (v, PENDULUM.derivatives[1].xreplace({d: sp.S.Zero})), PENDULUM.parameters)
    separation = separated(undamped, [x], k)
    assert zero(separation.system.derivatives[1] - acceleration.xreplace({e: a / L}))


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


def test_a_fast_force_that_depends_on_the_speed():
    """Phi = v cos + f sin(k t): xi' = (v sin - f cos)/k, <(dPhi/dv) xi'> = -f/(2 k)."""
    f = sp.Symbol("f", real=True)
    theta = k * TIME
    separation = separated(System((x, v), (v, v * sp.cos(theta) + f * sp.sin(theta)), (f, k)), [x], k)
    assert zero(separation.system.derivatives[1] + f / (2 * k))


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
        (sp.cos(sp.sqrt(2) * k * TIME), rejected("other-period", "2")),
        (sp.cos(k * TIME**2), rejected("not-fast", "k", "t")),
        (sp.cos(k * TIME * x), rejected("not-fast", "k", "t")),
        (sp.cos(k * TIME) - sp.Abs(v) * v, rejected("not-rational", "v")),
        (sp.exp(sp.cos(k * TIME)), rejected("uneven-argument")),
        (
            sp.tan(k * TIME) / (2 + sp.tan(k * TIME) ** 2) + k * sp.cos(k * TIME) * sp.sin(x),
            rejected("not-trigonometric", "k", "t"),
        ),
        (sp.Mod(k * TIME, 1) + sp.cos(k * TIME), rejected("not-trigonometric", "k", "t")),
        (1 / (1 + k * TIME) + sp.cos(k * TIME), rejected("not-trigonometric", "k", "t")),
        (sp.cos(k * TIME + sp.sin(k * TIME)), rejected("not-trigonometric", "k", "t")),
        (k * TIME * x + sp.cos(k * TIME), rejected("secular")),
        (-x + k**3 * sp.cos(k * TIME), rejected("grows", "k", "3")),
        (-x + a * k**3 * sp.cos(k * TIME), rejected("grows", "k", "3")),
        (-x + k**2 * sp.cos(k * TIME), rejected("grows", "k", "2")),
        (-x + k * v * sp.cos(k * TIME), rejected("grows", "k", "1")),
        (-x + k * sp.cos(k * TIME) + v * sp.cos(k * TIME), rejected("grows", "k", "1")),
        (sp.sqrt(1 + k**2) * sp.cos(k * TIME), rejected("growth-unclear", "k")),
    ],
)
def test_refusals(force, refusal):
    with refusal:
        separated(System((x, v), (v, force), (k, a)), [x], k)


@pytest.mark.parametrize(
    "force",
    [
        sp.sqrt(k) * sp.cos(k * TIME),
        k**3 / (1 + k**2) * sp.cos(k * TIME) * sp.sin(TIME),
        a * k**2 * sp.cos(k * TIME),  # a is O(1/k)
        sp.cos(k * TIME) + (k * sp.sin(TIME) + x) ** 2 / k**2 + 1 / (k + sp.cos(TIME)),
    ],
)
def test_sizes_and_slow_functions_that_are_allowed(force):
    separation = separated(System((x, v), (v, force), (k, a)), [x], k)
    assert zero(k**2 * sp.diff(separation.fast[0], THETA, 2) - separation.fast_force[0])


def test_the_fast_parameter_and_jumps_are_checked():
    for fast in (x, sp.Symbol("k"), TIME, "k"):
        with raises(WuchtError, match=r"is not a parameter|is not a symbol"):
            separated(PENDULUM, [x], fast)
    given = System((x, v), (v, k * sp.cos(k * TIME)), (k,), quadratures=(Output("Q", x, jump=v),))
    with rejected("jumps", "Q", "k", "t"):
        separated(given, [x], k)


def test_a_system_that_is_not_of_second_order_is_refused():
    with rejected("no-state", "y"):
        separated(PENDULUM, [y], k)
    with rejected("other-states"):
        separated(System((x, v), (-v, sp.cos(k * TIME)), (k,)), [x], k)


@pytest.mark.slow
def test_measured_order_of_kapitzas_pendulum():
    """With a k fixed the errors of angle and speed, fast parts put back, fall with 1/k; the slope is near 1 from k = 64 on.

    At a time at which cos(k t) = 1, sin(k t) = 0, as at the start, so that X, X' begin where the pendulum does to O(1/k).
    """
    ks, errors = 2.0 ** np.arange(6, 11), []
    slow = separated(PENDULUM, [x], k).system
    for number in ks:
        values = {"a": 3.0 / number, "g": 1.0, "L": 1.0, "k": number, "d": 0.1}
        time = np.linspace(0, 6, 241)
        true = run(PENDULUM, values, [2.6, 0.2], time)
        states = run(slow, values, [2.6, 0.2], time)
        errors.append(np.abs(full(slow, ["x", "v"], values, time, states) - true).max())
    assert order(1 / ks, errors) == approx(1, abs=0.15)
