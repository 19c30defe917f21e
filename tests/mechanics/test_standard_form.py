"""Changes of variables to the standard form of averaging refuse names that are taken and oscillations that are none."""

import pytest
import sympy as sp
from pytest import raises

from wucht.errors import WuchtError
from wucht.mechanics.standard_form import with_amplitude_and_phase, with_angle_as_time
from wucht.system import TIME, Output, System

x, v, r, psi, phi, d, epsilon = sp.symbols("x v r psi phi d epsilon", real=True)
OSCILLATOR = System((x, v), (v, -x - epsilon * d), (epsilon,), ((d, v * x),))


@pytest.mark.parametrize(
    "frequency, amplitude, phase, sentence",
    [
        (sp.S.Zero, r, psi, "the frequency 0 is zero"),
        (epsilon - epsilon * (sp.cos(1) ** 2 + sp.sin(1) ** 2), r, psi, "is zero"),
        (sp.S.One, r, r, "both called r"),
        (sp.S.One, d, psi, "d is in the System already"),
        (sp.S.One, r, sp.Symbol("epsilon"), "epsilon is in the System already"),
        (sp.S.One, r, TIME, "t is in the System already"),
    ],
)
def test_amplitudes_and_phases_that_are_none(frequency, amplitude, phase, sentence):
    with raises(WuchtError, match=sentence):
        with_amplitude_and_phase(OSCILLATOR, x, v, frequency, amplitude, phase)


def test_position_and_velocity_are_two():
    with raises(WuchtError, match="x is given as position and as velocity"):
        with_amplitude_and_phase(OSCILLATOR, x, x, sp.S.One, r, psi)


def test_names_of_outputs_that_are_taken():
    for name in ("x", "v"):
        given = System(OSCILLATOR.states, OSCILLATOR.derivatives, (epsilon,), OSCILLATOR.definitions, (Output(name, x * v),))
        with raises(WuchtError, match=f"an output {name} is in the System already"):
            with_amplitude_and_phase(given, x, v, sp.S.One, r, psi)
    turning = System((phi, x), (1 + x**2, epsilon * x), (epsilon,), quadratures=(Output("time", x),))
    with raises(WuchtError, match="an output time is in the System already"):
        with_angle_as_time(turning, phi)


def test_a_jump_may_not_depend_on_the_time_that_becomes_an_angle():
    turning = System((phi, x), (1 + x**2, epsilon * x), (epsilon,), quadratures=(Output("work", x, jump=TIME * x),))
    with raises(WuchtError, match="depends on t itself"):
        with_angle_as_time(turning, phi)
