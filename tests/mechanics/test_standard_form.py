"""Changes of variables to the standard form of averaging refuse names that are taken and oscillations that are none."""

import math

import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.mechanics.standard_form import with_amplitude_and_phase, with_angle_as_time
from wucht.system import TIME, Output, System

x, v, r, psi, phi, d, epsilon = sp.symbols("x v r psi phi d epsilon", real=True)
OSCILLATOR = System((x, v), (v, -x - epsilon * d), (epsilon,), ((d, v * x),))


@pytest.mark.parametrize(
    "frequency, amplitude, phase, refusal",
    [
        (sp.S.Zero, r, psi, rejected("zero-frequency", "0")),
        (epsilon - epsilon * (sp.cos(1) ** 2 + sp.sin(1) ** 2), r, psi, rejected("zero-frequency")),
        (sp.S.One, r, r, rejected("name-twice", "r")),
        (sp.S.One, d, psi, rejected("name-taken", "d")),
        (sp.S.One, r, sp.Symbol("epsilon"), rejected("name-taken", "epsilon")),
        (sp.S.One, r, TIME, rejected("name-taken", "t")),
    ],
)
def test_amplitudes_and_phases_that_are_none(frequency, amplitude, phase, refusal):
    with refusal:
        with_amplitude_and_phase(OSCILLATOR, x, v, frequency, amplitude, phase)


def test_position_and_velocity_are_two():
    with rejected("state-twice", "x"):
        with_amplitude_and_phase(OSCILLATOR, x, x, sp.S.One, r, psi)


def test_names_of_outputs_that_are_taken():
    for name in ("x", "v"):
        given = System(OSCILLATOR.states, OSCILLATOR.derivatives, (epsilon,), OSCILLATOR.definitions, (Output(name, x * v),))
        with rejected("output-taken", name):
            with_amplitude_and_phase(given, x, v, sp.S.One, r, psi)
    turning = System((phi, x), (1 + x**2, epsilon * x), (epsilon,), quadratures=(Output("time", x),))
    with rejected("output-taken", "time"):
        with_angle_as_time(turning, phi)


def test_a_jump_may_not_depend_on_the_time_that_becomes_an_angle():
    turning = System((phi, x), (1 + x**2, epsilon * x), (epsilon,), quadratures=(Output("work", x, jump=TIME * x),))
    with rejected("time-dependent", "t"):
        with_angle_as_time(turning, phi)


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
