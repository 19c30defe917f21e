"""Averaging of x' = epsilon X(x, t), 002 (3.1)-(3.10): classical results to zero residual, and the orders of its errors."""

import numpy as np
import pytest
import sympy as sp
from convergence import evaluate, full, order, run
from pytest import approx, raises
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.standard_form import with_amplitude_and_phase, with_angle_as_time
from wucht.system import TIME, Output, System

x, v, r, psi, epsilon, u, lam, sigma = sp.symbols("x v r psi epsilon u lambda sigma", real=True)
omega = sp.Symbol("omega", positive=True)
phi = sp.Symbol("phi", real=True)
VAN_DER_POL = System((x, v), (v, -x + epsilon * (1 - x**2) * v), (epsilon,))
OSCILLATOR = with_amplitude_and_phase(VAN_DER_POL, x, v, sp.S.One, r, psi)
SMALL = 2.0 ** -np.arange(5, 10)


def zero(expression):
    return sp.simplify(expression) == 0


def test_van_der_pol():
    """r' = epsilon r (1 - r^2/4)/2 with the limit cycle r = 2, and no shift of frequency."""
    averaging = averaged(OSCILLATOR, epsilon)
    assert zero(averaging.system.derivatives[0] - epsilon * r * (1 - r**2 / 4) / 2)
    assert averaging.system.derivatives[1] == 0
    assert averaging.first[0].xreplace({r: sp.Integer(2)}) == 0
    assert sp.diff(averaging.first[0], r).xreplace({r: sp.Integer(2)}) < 0
    assert averaging.period == sp.pi  # of X; that of the motion is twice as long
    assert averaging.system.angles == {psi}


def test_van_der_pol_second_order():
    """-epsilon^2/16 at r = 2, the second term of Lindstedt's series; the whole rate after Bogoliubov and Mitropolsky."""
    second = averaged(OSCILLATOR, epsilon, order=2).second
    assert second[0] == 0
    assert zero(second[1] + sp.Rational(1, 8) - sp.Rational(3, 16) * r**2 + sp.Rational(11, 256) * r**4)
    assert second[1].xreplace({r: sp.Integer(2)}) == -sp.Rational(1, 16)


def test_duffing_second_order():
    """Frequency of x'' + x + epsilon x^3 = 0 at amplitude A: 1 + 3 epsilon A^2/8 - 21 epsilon^2 A^4/256 (elliptic integral)."""
    A = sp.Symbol("A", positive=True)
    duffing = System((x, v), (v, -x - epsilon * x**3), (epsilon,))
    averaging = averaged(with_amplitude_and_phase(duffing, x, v, sp.S.One, r, psi), epsilon, order=2)
    assert averaging.first[0] == 0
    assert averaging.second[0] == 0
    # A is the full amplitude where the angle t + psi is zero; r = A - epsilon u(A) there.
    shift = averaging.fast[0].xreplace({TIME: sp.S.Zero, psi: sp.S.Zero, r: A})
    rate = averaging.system.derivatives[1].xreplace({r: A - epsilon * shift})
    expansion = sp.series(sp.expand(rate), epsilon, 0, 3).removeO()
    assert zero(expansion - sp.Rational(3, 8) * epsilon * A**2 + sp.Rational(21, 256) * epsilon**2 * A**4)


def test_forced_duffing():
    """The classical slow flow, and the amplitude-frequency curve (D - 3 a r^2/4)^2 r^2 + 4 (mu W r)^2 = f^2."""
    Omega, mu, a, f = sp.symbols("Omega mu alpha f", positive=True)
    D = sp.Symbol("Delta", real=True)  # Omega^2 - epsilon Delta is the square of the natural frequency
    force = -2 * mu * v - a * x**3 + f * sp.cos(Omega * TIME) + D * x
    duffing = System((x, v), (v, -(Omega**2) * x + epsilon * force), (epsilon, Omega, mu, a, f, D))
    averaging = averaged(with_amplitude_and_phase(duffing, x, v, Omega, r, psi), epsilon)
    assert zero(averaging.first[0] + mu * r + f * sp.sin(psi) / (2 * Omega))
    assert zero(r * averaging.first[1] + (D * r / 2 - 3 * a * r**3 / 8 + f * sp.cos(psi) / 2) / Omega)
    sine, cosine = sp.symbols("s c", real=True)
    rest = [e.xreplace({sp.sin(psi): sine, sp.cos(psi): cosine}) for e in averaging.first]
    solved = sp.solve(rest, [sine, cosine], dict=True)[0]
    curve = sp.expand(f**2 * (solved[sine] ** 2 + solved[cosine] ** 2 - 1))
    assert zero(curve - (r**2 * (D - 3 * a * r**2 / 4) ** 2 + 4 * (mu * Omega * r) ** 2 - f**2))
    assert sp.simplify(averaging.period * Omega / sp.pi) == 1
    assert set(averaging.divisors) == {2 * Omega, 4 * Omega}


def test_kapitza():
    """theta' = e (p + sin T sin theta) etc. in T = Omega t, e = a/l: the mean is the effective potential's force."""
    theta, p = sp.symbols("theta p", real=True)
    kappa = sp.Symbol("kappa", positive=True)  # kappa^2 = g l/(a Omega)^2
    s, c = sp.sin(theta), sp.cos(theta)
    # theta'' = -e (kappa^2 e - cos T) sin theta with theta' = e (p + sin T sin theta).
    momentum = -(kappa**2) * s - sp.sin(TIME) * c * (p + sp.sin(TIME) * s)
    pendulum = System((theta, p), (epsilon * (p + sp.sin(TIME) * s), epsilon * momentum), (epsilon, kappa))
    acceleration = sp.diff(pendulum.derivatives[0], theta) * pendulum.derivatives[0]
    acceleration += sp.diff(pendulum.derivatives[0], p) * pendulum.derivatives[1] + sp.diff(pendulum.derivatives[0], TIME)
    assert zero(acceleration + epsilon * (kappa**2 * epsilon - sp.cos(TIME)) * s)  # it is the pendulum's equation
    averaging = averaged(pendulum, epsilon)
    potential = -(kappa**2) * sp.cos(theta) + sp.sin(theta) ** 2 / 4
    assert zero(averaging.first[0] - p)
    assert zero(averaging.first[1] + sp.diff(potential, theta))
    upright = sp.diff(potential, theta, 2).xreplace({theta: sp.pi})
    assert zero(upright - (sp.Rational(1, 2) - kappa**2))  # stable where (a Omega)^2 > 2 g l


def test_rotor_on_a_carrier():
    """002 (3.48), its sign corrected, becomes (3.49) and, averaged, (3.50)."""
    A, B = 1 - omega**2, 2 * sigma * omega
    torque = u * (lam - omega) - omega**4 * (A * sp.cos(phi) + B * sp.sin(phi)) * sp.sin(phi) / (A**2 + B**2)
    rotor = System((phi, omega), (omega, epsilon * torque), (epsilon, u, lam, sigma), angles=frozenset({phi}))
    over_angle = with_angle_as_time(rotor, phi)
    assert zero(over_angle.derivatives[0] - epsilon / omega * torque.xreplace({phi: TIME}))
    averaging = averaged(over_angle, epsilon)
    resistance = omega**5 * sigma / ((1 - omega**2) ** 2 + 4 * sigma**2 * omega**2)
    assert zero(averaging.first[0] - (u * (lam - omega) - resistance) / omega)
    assert averaging.system.output("time").expression == 1 / omega


def test_an_angle_as_time_takes_definitions_outputs_and_quadratures_along():
    """dx/dphi = x'/phi' with definitions in the angle; an integral over time becomes one over the angle."""
    swing = sp.Symbol("swing", real=True)
    given = System(
        (phi, x), (2 + x, epsilon * swing * x), (epsilon,), ((swing, 1 + sp.cos(phi)),),
        (Output("height", sp.sin(phi), "m"),), (Output("work", swing, "J"),), frozenset({phi}),
    )  # fmt: skip
    over_angle = with_angle_as_time(given, phi)
    assert over_angle.states == (x,)
    assert over_angle.angles == frozenset()
    assert zero(over_angle.explicit(over_angle.derivatives[0]) - epsilon * (1 + sp.cos(TIME)) * x / (2 + x))
    assert over_angle.output("height").expression == sp.sin(TIME)
    assert zero(over_angle.explicit(over_angle.output("work").expression) - (1 + sp.cos(TIME)) / (2 + x))
    slow = averaged(over_angle, epsilon).system
    assert zero(slow.derivatives[0] - epsilon * x / (2 + x))
    assert zero(slow.output("work").expression - 1 / (2 + x))


def test_laval_rotor_is_autonomous_before_it_is_averaged():
    """002 (3.67) gives (3.68), with nothing fast in it."""
    torque = u * (lam - omega) - 2 * sigma * omega**5 / ((1 - omega**2) ** 2 + 4 * sigma**2 * omega**2)
    rotor = System((phi, omega), (omega, epsilon * torque), (epsilon, u, lam, sigma), angles=frozenset({phi}))
    averaging = averaged(with_angle_as_time(rotor, phi), epsilon, order=2)
    assert zero(averaging.first[0] - torque / omega)
    assert averaging.second == (0,)
    assert averaging.fast == (0,)
    assert averaging.period is None


def test_second_order_of_two_fields_is_their_bracket():
    """x' = epsilon (f cos t + g sin t): -(epsilon^2/2) (f' g - g' f) in one dimension, checked on x^2 and x: -x^2/2."""
    averaging = averaged(System((x,), (epsilon * (x**2 * sp.cos(TIME) + x * sp.sin(TIME)),), (epsilon,)), epsilon, order=2)
    assert averaging.first == (0,)
    assert zero(averaging.second[0] + x**2 / 2)


def test_what_stands_at_epsilon_squared_has_its_part():
    averaging = averaged(
        System((x,), (epsilon * sp.cos(TIME) + epsilon**2 * x * sp.cos(TIME) ** 2,), (epsilon,)), epsilon, order=2
    )
    assert zero(averaging.system.derivatives[0] - epsilon**2 * x / 2)


def test_exact_solution_with_the_fast_part_put_back():
    """x' = epsilon x^2 cos t: 1/x = 1/x_0 - epsilon sin t; the mean stands still, x + epsilon x^2 sin t misses epsilon^2."""
    averaging = averaged(System((x,), (epsilon * x**2 * sp.cos(TIME),), (epsilon,)), epsilon, order=2)
    assert averaging.system.derivatives == (0,)
    back = averaging.system.explicit(averaging.system.output("full.x").expression)
    exact = 1 / (1 / x - epsilon * sp.sin(TIME))
    assert zero(sp.series(exact - back, epsilon, 0, 2).removeO())
    assert not zero(sp.series(exact - back, epsilon, 0, 3).removeO())


def test_frequencies_that_have_no_common_period():
    """The mean (3.5) exists all the same; a beat of sqrt(2) - 1 is no resonance."""
    two = sp.cos(TIME) + sp.cos(sp.sqrt(2) * TIME)
    averaging = averaged(System((x,), (epsilon * (two**2 * x - x**3 + two),), (epsilon,)), epsilon, order=2)
    assert averaging.period is None
    assert zero(averaging.first[0] - x + x**3)


def test_definitions_outputs_and_quadratures_go_along():
    """Definitions that stand still stay; outputs are of the full motion; a quadrature integrates the mean of its rate."""
    still, moving = sp.symbols("still moving", real=True)
    given = System(
        (x,),
        (epsilon * (still + moving * x),),
        (epsilon,),
        ((still, 1 + x**2), (moving, sp.cos(TIME) + still)),
        (Output("square", x**2 + still, "m2", "square of x"),),
        (Output("work", sp.cos(TIME) ** 2 * x, "J"),),
    )
    for which in (1, 2):
        slow = averaged(given, epsilon, which).system
        assert zero(sp.diff(slow.explicit(slow.derivatives[0]), epsilon).xreplace({epsilon: 0}) - (1 + x**2) * (1 + x))
        back = slow.explicit(slow.output("full.x").expression)
        assert zero(back - x - epsilon * x * sp.sin(TIME))
        assert zero(slow.explicit(slow.output("square").expression) - 2 * back**2 - 1)
        assert (slow.output("square").unit, slow.output("square").long_name) == ("m2", "square of x")
        assert zero(slow.explicit(slow.output("work").expression) - x / 2)  # <cos^2 sin> = 0 at order 2
        assert slow.output("work").unit == "J"


def test_quadratures_of_second_order_know_the_fast_part():
    """Under the integral of x sin t, x = y + epsilon y sin t gives epsilon <y sin^2 t> = epsilon y/2, unseen at first order."""
    given = System((x,), (epsilon * x * sp.cos(TIME),), (epsilon,), quadratures=(Output("work", x * sp.sin(TIME)),))
    assert averaged(given, epsilon).system.output("work").expression == 0
    assert zero(averaged(given, epsilon, order=2).system.output("work").expression - epsilon * x / 2)


@pytest.mark.parametrize("rate", [x * sp.cos(epsilon * TIME), x / (1 + epsilon * TIME), sp.cos(x * TIME)])
def test_quadratures_of_slow_time_are_refused(rate):
    given = System((x,), (epsilon * x,), (epsilon,), quadratures=(Output("work", rate),))
    with raises(WuchtError, match=r"depends on|secular|no period"):
        averaged(given, epsilon)


def test_all_is_small_where_no_epsilon_is_written():
    averaging = averaged(System((x,), (sp.Rational(1, 100) * sp.sin(TIME) ** 2 * x,)))
    assert averaging.system.derivatives == (x / 200,)


def test_a_mean_without_a_transformation():
    """1/(2 + cos t) has the mean 1/sqrt(3); the fast part has no closed form, and the second order is refused."""
    system = System((x,), (epsilon * x / (2 + sp.cos(TIME)),), (epsilon,))
    averaging = averaged(system, epsilon)
    assert zero(averaging.first[0] - x / sp.sqrt(3))
    assert averaging.fast == ()
    assert "denominator" in averaging.reason
    assert averaging.period == 2 * sp.pi
    with rejected("no-second-order"):
        averaged(system, epsilon, order=2)


@pytest.mark.parametrize(
    "rate, sentence",
    [
        (epsilon * TIME * x, "secular"),
        (epsilon * x * sp.exp(-TIME), "no certain period"),
        (x + epsilon, "is not small"),
        (epsilon * sp.cos(x * TIME), "frequency in .* depends on x"),
        (epsilon * sp.cos((1 + epsilon) * TIME), "depends on epsilon"),
        (epsilon * sp.Abs(sp.cos(TIME)), "its mean cannot be computed"),
        (epsilon / sp.cos(TIME), "pole"),
        (epsilon / (x + sp.cos(TIME)), "depend on parameters or states"),
        (sp.sqrt(epsilon) * x, "no expansion"),
        (sp.Abs(epsilon) * x, "no expansion"),
        (sp.Max(0, epsilon) * x, "no expansion"),
        (epsilon * sp.sin(x / epsilon), "no expansion"),
        (epsilon / (2 + sp.tan(x * TIME) ** 2), "frequency in .* depends on x"),
        (epsilon / (2 + sp.sec(x * TIME) ** 2), "frequency in .* depends on x"),
    ],
)
def test_what_cannot_be_averaged_is_refused_with_a_reason(rate, sentence):
    with raises(WuchtError, match=sentence):
        averaged(System((x,), (rate,), (epsilon,)), epsilon)


def test_changes_of_variables_refuse_what_has_no_meaning():
    with rejected("no-state"):
        with_angle_as_time(VAN_DER_POL, phi)
    with rejected("time-dependent", "t"):
        with_angle_as_time(System((phi, x), (1 + x, sp.cos(TIME))), phi)
    with rejected("does-not-turn"):
        with_angle_as_time(System((phi, x), (sp.S.Zero, x)), phi)
    with rejected("no-state", "r"):
        with_amplitude_and_phase(VAN_DER_POL, r, v, sp.S.One, r, psi)
    with rejected("frequency-varies", "r"):
        with_amplitude_and_phase(VAN_DER_POL, x, v, r, r, psi)
    with rejected("name-taken", "x"):
        with_amplitude_and_phase(VAN_DER_POL, x, v, sp.S.One, x, psi)


def _errors(system, start, which):
    """Largest errors up to t = 1/epsilon: of the averaged states; at order 2 from ``start``, with the fast part put back."""
    averaging = averaged(system, epsilon, which)
    names, errors = system.state_names, []
    for small in SMALL:
        values, time = {"epsilon": small}, np.linspace(0, 1 / small, 301)
        true = run(system, values, start, time)
        at = evaluate(system, averaging.start, values, np.zeros(1), np.array(start)[:, None])[:, 0]
        if which == 1:
            near = run(averaging.system, values, start, time)
        else:
            near = full(averaging.system, names, values, time, run(averaging.system, values, at, time))
        errors.append(np.abs(near - true).max())
    return errors


CASES = {
    "van der Pol": (OSCILLATOR, [1.0, 0.3]),
    "two fields": (System((x,), (epsilon * (x**2 * sp.cos(TIME) + x * sp.sin(TIME) - x**3 / 4),), (epsilon,)), [0.8]),
    "no common period": (
        System((x,), (epsilon * (x * sp.cos(TIME) + x**2 * sp.sin(sp.sqrt(2) * TIME) + 1 - x),), (epsilon,)), [0.5],
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("which", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_errors_fall_with_the_order_of_the_averaging(name, which):
    """O(epsilon) and O(epsilon^2) over 0 <= t <= 1/epsilon; the next terms bend the slope by less than 0.1 here."""
    assert order(SMALL, _errors(*CASES[name], which)) == approx(which, abs=0.1)
