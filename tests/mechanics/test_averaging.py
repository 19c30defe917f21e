"""Averaging of x' = epsilon X(x, t), 002 (3.1)-(3.10): classical results to zero residual, and the orders of its errors."""

import math

import pytest
import sympy as sp
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
        (x + epsilon, "is not small"),
        (epsilon * sp.cos(x * TIME), "frequency in .* depends on x"),
        (epsilon * sp.cos((1 + epsilon) * TIME), "depends on epsilon"),
        (epsilon * sp.Abs(sp.cos(TIME)), "its mean cannot be computed"),
        (epsilon / sp.cos(TIME), "pole"),
        (epsilon / (x + sp.cos(TIME)), "depend on parameters or states"),
        (sp.Abs(epsilon) * x, "no expansion"),
        (epsilon / (2 + sp.tan(x * TIME) ** 2), "frequency in .* depends on x"),
    ],
)
def test_what_cannot_be_averaged_is_refused_with_a_reason(rate, sentence):
    with raises(WuchtError, match=sentence):
        averaged(System((x,), (rate,), (epsilon,)), epsilon)


@pytest.mark.parametrize("which", [1, 2])
@pytest.mark.parametrize(
    "rate",
    [
        epsilon * x / (1 + epsilon * TIME),
        epsilon * x * sp.cos(epsilon * TIME**2),
        epsilon * sp.cos(TIME + epsilon * TIME**2),
        epsilon * x * sp.exp(-epsilon * TIME),
        epsilon * sp.tan((1 + epsilon) * TIME) ** 2,
        epsilon * x + epsilon**2 * sp.exp(TIME),
    ],
)
def test_slow_time_is_refused(rate, which):
    """epsilon t grows to 1 in the time 1/epsilon over which the averaged equations are to hold."""
    with raises(WuchtError, match=r"slow time|frequency in .* depends on epsilon"):
        averaged(System((x,), (rate,), (epsilon,)), epsilon, which)


@pytest.mark.parametrize(
    "rate, mean",
    [
        (epsilon * sp.sin(x + epsilon * v * sp.cos(TIME)), sp.sin(x)),
        (epsilon * x / (1 + epsilon * sp.cos(TIME)), x),
        (epsilon * x * sp.exp(epsilon * sp.sin(TIME)), x),
        (epsilon * sp.Abs(x + epsilon * v), sp.Abs(x)),
    ],
)
def test_epsilon_beside_bounded_functions_of_time_is_no_slow_time(rate, mean):
    averaging = averaged(System((x, v), (rate, sp.S.Zero), (epsilon,)), epsilon)
    assert averaging.first == (mean, 0)


A, B = sp.symbols("a b", real=True)


def test_resonances_of_the_second_order_are_reported():
    """<(dX/dx) u> of cos(a t) and sin(b t) is zero unless a = b or a = -b."""
    averaging = averaged(
        System((x, v), (epsilon * v * sp.cos(A * TIME), epsilon * x * sp.sin(B * TIME)), (epsilon, A, B)), epsilon, 2
    )
    assert averaging.second == (0, 0)
    assert set(averaging.divisors) == {A, B, A - B, A + B}
    heat = Output("heat", sp.cos(A * TIME) * sp.cos(B * TIME))
    slow = averaged(System((x,), (epsilon,), (epsilon, A, B), quadratures=(heat,)), epsilon)
    assert set(slow.divisors) == {A - B, A + B}
    assert averaged(System((x,), (epsilon / (2 + sp.cos(A * TIME)),), (epsilon, A)), epsilon).divisors == (A,)


def test_the_period_is_of_all_that_is_averaged():
    halved = epsilon * x * sp.cos(TIME) + epsilon**2 * x * sp.cos(TIME / 4) ** 2
    assert averaged(System((x,), (halved,), (epsilon,)), epsilon, 2).period == 4 * sp.pi
    assert averaged(System((x,), (halved,), (epsilon,)), epsilon).period == 2 * sp.pi
    irrational = System((x,), (halved + epsilon**2 * x * sp.cos(sp.sqrt(2) * TIME),), (epsilon,))
    assert averaged(irrational, epsilon, 2).period is None
    with rejected("other-period", "2"):
        averaged(irrational, epsilon, 2, period=2 * sp.pi)


@pytest.mark.parametrize(
    "small, refusal",
    [
        (x, rejected("no-parameter", "x")),
        (sp.Symbol("mu", real=True), rejected("no-parameter")),
        (sp.Symbol("epsilon"), rejected("other-assumptions")),
        ("epsilon", rejected("no-symbol", "epsilon")),
    ],
)
def test_what_is_no_small_parameter_is_refused(small, refusal):
    with refusal:
        averaged(System((x,), (epsilon * x,), (epsilon,)), small)


def test_periods_that_are_none_are_refused():
    system = System((x,), (epsilon * sp.cos(TIME),), (epsilon, A))
    assert averaged(system, epsilon, period=4 * sp.pi).period == 4 * sp.pi
    assert averaged(system, epsilon, period=2 * math.pi).period == approx(2 * math.pi)
    for wrong in (sp.pi, 3.0, 5.0, 12.0, A):
        with rejected("other-period"):
            averaged(system, epsilon, period=wrong)
    for wrong in (0, -2 * sp.pi, sp.oo, sp.I):
        with rejected("not-positive"):
            averaged(system, epsilon, period=wrong)
    with rejected("text"):
        averaged(system, epsilon, period="2*pi")


d = sp.Symbol("d", real=True)
DEFINED = System((x, v), (v, -x - epsilon * d), (epsilon,), ((d, v * x),))


@pytest.mark.parametrize(
    "frequency, amplitude, phase, refusal",
    [
        (sp.S.Zero, r, psi, rejected("zero-frequency", "0")),
        (epsilon - epsilon * (sp.cos(1) ** 2 + sp.sin(1) ** 2), r, psi, rejected("zero-frequency")),
        (sp.S.One, r, r, rejected("name-twice", "r")),
        (sp.S.One, d, psi, rejected("name-taken", "d")),
    ],
)
def test_amplitudes_and_phases_that_are_none(frequency, amplitude, phase, refusal):
    with refusal:
        with_amplitude_and_phase(DEFINED, x, v, frequency, amplitude, phase)


w, y, k = sp.symbols("w y k", real=True)
GENERAL = System(
    (y, x, v),
    (k * y * v + sp.cos(TIME), v + epsilon * x * y, -(w**2) * x - d + epsilon * v),
    (epsilon, w, k),
    ((d, v**2 * x + y),),
    (Output("power", d * v, "W", "power"),),
    (Output("work", x * v, jump=x),),
)
AT = {r: 1.3, psi: 0.7, y: -0.4, TIME: 2.1, epsilon: 0.3, w: 1.7, k: 0.9}


def number(expression, system, at):
    """An expression with the definitions of a System put in, at numbers."""
    return float(system.explicit(sp.sympify(expression)).subs(at))


def test_amplitude_and_phase_move_as_position_and_velocity_do():
    """By the chain rule, where the rate of the position is not the velocity alone; x = r cos(w t + psi), v = -w r sin."""
    changed = with_amplitude_and_phase(GENERAL, x, v, w, r, psi)
    assert changed.states == (y, r, psi)
    assert changed.angles == {psi}
    place = {x: r * sp.cos(w * TIME + psi), v: -w * r * sp.sin(w * TIME + psi)}
    before = {**AT, x: float(place[x].subs(AT)), v: float(place[v].subs(AT))}
    rates = dict(zip(changed.states, (number(e, changed, AT) for e in changed.derivatives), strict=True))
    for symbol, expression in place.items():
        chain = sum(float(sp.diff(expression, s).subs(AT)) * rates.get(s, 1.0) for s in (r, psi, TIME))
        original = GENERAL.derivatives[GENERAL.states.index(symbol)]
        assert chain == pytest.approx(number(original, GENERAL, before), rel=1e-12)
    assert rates[y] == pytest.approx(number(GENERAL.derivatives[0], GENERAL, before), rel=1e-12)
    for name, expression in (("x", x), ("v", v), ("power", d * v), ("work", x * v)):
        found = changed.output(name)
        assert number(found.expression, changed, AT) == pytest.approx(number(expression, GENERAL, before), rel=1e-12)
    assert (changed.output("power").unit, changed.output("power").long_name) == ("W", "power")
    assert number(changed.output("work").jump, changed, AT) == pytest.approx(before[x])


def test_over_an_angle_all_rates_are_divided_by_its_speed():
    """Quadratures too; the time passed becomes one of them."""
    turning = System(
        (x, phi), (k * x * sp.sin(phi) + d, 2 + x**2), (k,), ((d, x * k),), (Output("power", d * x),), (Output("work", x + k),),
        frozenset({phi}),
    )  # fmt: skip
    changed = with_angle_as_time(turning, phi)
    assert changed.states == (x,)
    assert changed.angles == frozenset()
    at = {x: 0.6, k: 1.4}
    speed = 2 + 0.36
    (rate,) = changed.derivatives
    assert number(rate, changed, {**at, TIME: 0.9}) == pytest.approx((1.4 * 0.6 * math.sin(0.9) + 0.84) / speed)
    assert number(changed.output("power").expression, changed, at) == pytest.approx(0.84 * 0.6)
    assert number(changed.output("work").expression, changed, at) == pytest.approx(2.0 / speed)
    assert number(changed.output("time").expression, changed, at) == pytest.approx(1 / speed)


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
    with rejected("state-twice", "x"):
        with_amplitude_and_phase(VAN_DER_POL, x, x, sp.S.One, r, psi)
    turning = System((phi, x), (1 + x**2, epsilon * x), (epsilon,), quadratures=(Output("time", x),))
    with rejected("output-taken", "time"):
        with_angle_as_time(turning, phi)


def test_all_is_small_where_no_epsilon_is_written():
    averaging = averaged(System((x,), (sp.Rational(1, 100) * sp.sin(TIME) ** 2 * x,)))
    assert averaging.system.derivatives == (x / 200,)
