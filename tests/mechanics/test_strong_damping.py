"""Averaging of partially strongly damped systems, 002 (3.14)-(3.26) corrected."""

import math

import numpy as np
import pytest
import sympy as sp
from convergence import evaluate, full, order, run
from pytest import approx, raises
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.files.building import machine_from
from wucht.mechanics.standard_form import with_angle_as_time
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


def _rotor(directions):
    """002 (3.33)-(3.34), or (3.59)-(3.61), solved for the accelerations, with the angle as the independent variable."""
    names = [(xi, dxi), (eta, deta)][:directions]
    turning = [(sp.cos(phi), sp.sin(phi)), (sp.sin(phi), -sp.cos(phi))][:directions]
    w, *a = sp.symbols("w a b", real=True)[: directions + 1]
    equations = [acc + 2 * sigma * d + q - omega**2 * c - w * s for acc, (q, d), (c, s) in zip(a, names, turning, strict=True)]
    equations.append(w - epsilon * (u * (lam - omega) + sum(acc * s for acc, (_, s) in zip(a, turning, strict=True))))
    solved = sp.solve(equations, [w, *a], dict=True)[0]
    states = [(phi, omega), (omega, solved[w])]
    states += [pair for acc, (q, d) in zip(a, names, strict=True) for pair in ((q, d), (d, solved[acc]))]
    system = System(tuple(s for s, _ in states), tuple(f for _, f in states), (epsilon, u, lam, sigma), angles=frozenset({phi}))
    return with_angle_as_time(system, phi), [s for pair in names for s in pair]


@pytest.mark.slow
@pytest.mark.parametrize("directions", [1, 2])
def test_the_sommerfeld_effect_from_the_full_equations(directions):
    """(3.33)-(3.34) become (3.50), (3.59)-(3.61) become (3.68); the carrier follows (3.37), (3.63), (3.64)."""
    system, damped = _rotor(directions)
    reduction = strongly_damped(system, damped, epsilon)
    A, B = 1 - omega**2, 2 * sigma * omega
    resistance = directions * sigma * omega**5 / (A**2 + B**2)
    assert zero(reduction.averaging.first[0] - (u * (lam - omega) - resistance) / omega)
    assert zero(reduction.manifold[0] - omega**2 * (A * sp.cos(TIME) + B * sp.sin(TIME)) / (A**2 + B**2))
    if directions == 2:
        assert zero(reduction.manifold[2] - omega**2 * (A * sp.sin(TIME) - B * sp.cos(TIME)) / (A**2 + B**2))
    assert reduction.conditions == ()


@pytest.mark.slow
def test_a_machine_from_its_energies():
    """The whole machine, gravity and all, with a heavy drum (J/epsilon), becomes the torque balance of its steady motion.

    Torque of the carrier's damping per turn: c w^5 U^2 for each of two directions, over 2 |k - m w^2 + i c w|^2.
    """
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e5, "damping": 200.0},
        "bodies": [{"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03}],
    }).system  # fmt: skip
    positive = {p: sp.Symbol(p.name, positive=True) for p in (*machine.parameters, machine.states[5])}
    c, k, m0, m, e, J, b = (
        sp.Symbol(n, positive=True)
        for n in ("carrier.damping", "carrier.stiffness", "carrier.mass", "drum.mass", "drum.eccentricity", "drum.inertia",
                  "drum.bearing_damping")
    )  # fmt: skip
    heavy = System(
        tuple(positive.get(s, s) for s in machine.states),
        tuple(machine.explicit(f).xreplace(positive).xreplace({J: J / epsilon}) for f in machine.derivatives),
        (*(positive[p] for p in machine.parameters), epsilon),
        angles=machine.angles,
    )
    at, vx, vy, w = heavy.states[2:]
    reduction = strongly_damped(with_angle_as_time(heavy, at), [*heavy.states[:2], vx, vy], epsilon)
    impedance = (k - (m0 + m) * w**2) ** 2 + (c * w) ** 2
    assert zero(reduction.averaging.first[0] * w * J + b * w + c * w**5 * (m * e) ** 2 / impedance)
    assert reduction.conditions == ()


def _on_manifold(reduction, values, slow):
    """The full start for a slow state, on the manifold."""
    names = ["x", "y", "z"][: 1 + len(reduction.manifold)]
    return full(reduction.averaging.system, names, values, np.zeros(1), np.array([[slow]]))[:, 0]


def _errors(system, damped, which, ks):
    """Largest errors of x and of y up to t = 1/epsilon of a run that begins on the manifold."""
    reduction, errors = strongly_damped(system, damped, epsilon, which), []
    for small in 2.0**-ks:
        values, time = {"epsilon": small}, np.linspace(0, 1 / small, 301)
        near = full(
            reduction.averaging.system, system.state_names, values, time, run(reduction.averaging.system, values, [0.4], time)
        )
        gap = np.abs(near - run(system, values, _on_manifold(reduction, values, 0.4), time)).max(axis=1)
        errors.append((gap[0], gap[1:].max()))
    return np.array(errors).T


@pytest.mark.slow
@pytest.mark.parametrize("which", [1, 2])
def test_errors_of_an_unforced_system(which):
    """x: O(epsilon) (3.26), or O(epsilon^2) at order 2. y is of the size epsilon itself: its error is O(epsilon^2) at once."""
    ks = np.arange(6.0, 11.0)
    of_x, of_y = _errors(UNFORCED, [y, z], which, ks)
    assert order(2.0**-ks, of_x) == approx(which, abs=0.15)
    assert order(2.0**-ks, of_y) == approx(2, abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("which", [1, 2])
def test_errors_of_a_forced_system(which):
    ks = np.arange(5.0, 10.0)
    of_x, of_y = _errors(FORCED, [y], which, ks)
    assert order(2.0**-ks, of_x) == approx(which, abs=0.15)
    assert order(2.0**-ks, of_y) == approx(which, abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("which", [1, 2])
def test_errors_of_the_sommerfeld_effect(which):
    """The rotor on a carrier (3.33)-(3.34) through its resonance: speed and carrier against the averaged equations.

    Over angles up to 1/epsilon; the carrier's error bends the slope more, its resonance being sharper than epsilon is small.
    """
    (system, damped), ks, errors = _rotor(1), np.arange(6.0, 10.0), []
    reduction = strongly_damped(system, damped, epsilon, which)
    for small in 2.0**-ks:
        values, time = {"epsilon": small, "u": 1.0, "lambda": 2.0, "sigma": 0.3}, np.linspace(0, 1 / small, 301)
        start = full(reduction.averaging.system, system.state_names, values, np.zeros(1), np.array([[0.5]]))[:, 0]
        near = full(
            reduction.averaging.system, system.state_names, values, time, run(reduction.averaging.system, values, [0.5], time)
        )
        gap = np.abs(near - run(system, values, start, time)).max(axis=1)
        errors.append((gap[0], gap[1:].max()))
    of_speed, of_carrier = np.array(errors).T
    assert order(2.0**-ks, of_speed) == approx(which, abs=0.1)
    assert order(2.0**-ks, of_carrier) == approx(which, abs=0.15)


def test_the_damped_states_relax_onto_the_manifold():
    """From y = 1.5 the distance falls like exp(-t), as K's eigenvalues -1 +- 2i say, to O(epsilon^2): after 2 ln(1/epsilon)."""
    reduction, rest = strongly_damped(UNFORCED, [y, z], epsilon, 2), []
    for small in (2.0**-6, 2.0**-8):
        values, later = {"epsilon": small}, 2 * math.log(1 / small)
        time = np.linspace(0, 2 * later, 200)
        true = run(UNFORCED, values, [0.4, 1.5, 0.0], time)
        on = evaluate(reduction.averaging.system, [small * e for e in reduction.next], values, time, true[:1])
        gap = np.linalg.norm(true[1:] - on, axis=0)
        early = time < later / 2
        assert np.polyfit(time[early], np.log(gap[early]), 1)[0] == approx(-1, abs=0.05)
        rest.append(gap[time > later].max())
        assert rest[-1] < 10 * small**2
    assert math.log2(rest[0] / rest[1]) / 2 == approx(2, abs=0.2)  # it decreases as epsilon^2


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


def test_conditions_come_back():
    a = sp.Symbol("a", real=True)
    reduction = strongly_damped(System((x, y), (epsilon * y, -a * y + epsilon), (epsilon, a)), [y], epsilon)
    assert reduction.conditions == (a,)
    assert reduction.next == (1 / a,)


@pytest.mark.parametrize(
    "rate, sentence",
    [
        (y + epsilon, "is not stable"),
        (-(y**3) + epsilon, "not linear"),
        (-(2 + sp.cos(TIME)) * y, "depends on t"),
        (-y + TIME, "forcing of y cannot be averaged.*secular"),
        (-y + sp.cos(x * TIME), "forcing of y cannot be averaged: the frequency in .* depends on x"),
        (-y + epsilon * sp.cos(x * TIME), "frequency in .* depends on x"),
        (-y / (1 + epsilon * TIME) + sp.cos(TIME), "slow time"),
        (-y + sp.cos(TIME) + epsilon * TIME, "slow time"),
        (-y + sp.sqrt(epsilon), "no expansion"),
        (-y + sp.Abs(epsilon), "no expansion"),
        (-y + sp.cos((1 + epsilon) * TIME), "depends on epsilon"),
    ],
)
def test_refusals(rate, sentence):
    with raises(WuchtError, match=sentence):
        strongly_damped(System((x, y), (epsilon * y, rate), (epsilon,)), [y], epsilon)


@pytest.mark.parametrize("which", [1, 2])
def test_a_frequency_that_depends_on_a_slow_state_is_refused_at_each_order(which):
    """x' = e (1 - x), y' = -y + cos(x t): dx/dt t enters the phase, which the manifold over a held x does not know."""
    with raises(WuchtError, match="depends on x"):
        strongly_damped(System((x, y), (epsilon * (1 - x), -y + sp.cos(x * TIME)), (epsilon,)), [y], epsilon, which)


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


def test_outputs_stay_where_the_fast_part_is_not_known():
    given = System(
        (x, y), (epsilon * (1 - x) / (2 + sp.cos(TIME)), -y + sp.cos(TIME)), (epsilon,), outputs=(Output("sum", x + y),)
    )
    averaging = strongly_damped(given, [y], epsilon).averaging
    assert [o.name for o in averaging.system.outputs] == ["full.y", "sum"]
    assert zero(averaging.system.explicit(averaging.system.output("sum").expression) - x - forced(1, 1))


def test_the_small_parameter_and_the_order_are_checked():
    for small in (x, sp.Symbol("epsilon"), "epsilon"):
        with raises(WuchtError, match=r"is not a parameter|is not a symbol"):
            strongly_damped(FORCED, [y], small)
    with rejected("order", "1", "2"):
        strongly_damped(FORCED, [y], epsilon, True)


def test_which_states_are_damped_must_be_told():
    for damped in ([], [x, y], [z]):
        with rejected("damped-states"):
            strongly_damped(FORCED, damped, epsilon)
