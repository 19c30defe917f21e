"""Changes of variables to the standard form of averaging refuse names that are taken and oscillations that are none."""

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
