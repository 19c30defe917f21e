"""Narrow transitions against closed solutions: a step that begins far away must not pass them unseen."""

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_batch import compile_batch
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.step_sizes import LONG, STIFF, STIFF_AT_REST, UNKNOWN, advice
from wucht.system import TIME, System

v, y, far, width, rate = sp.symbols("v y far width rate", real=True)
# v goes evenly through zero, from 1 to -2; y is the integral of tanh(v/width): 1 - 2 = -1 and e (ln cosh ..) of the transition.
PASSING = System((v, y, far), (-rate, rate * sp.tanh(v / width), sp.S.Zero), (width, rate))
WIDTHS = [1e-9, 1e-4, 0.1, 1.0]


def log_cosh(u):
    return np.logaddexp(u, -u) - np.log(2)


def passed(width, reached=2.0):
    """y when v, from 1, has come to -reached."""
    return width * (log_cosh(1 / width) - log_cosh(reached / width))


def run(width, tolerance=1e-12, size=0.0, sense=1.0, rate=1.0):
    flow = compile_system(PASSING, tolerance)
    trajectory = integrate(flow, [sense, 0.0, size], [width, sense * rate], [0.0, 3.0 / rate])
    assert trajectory.failure is None
    return trajectory.states[1, -1]


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("width", WIDTHS)
def test_a_transition_of_any_width_is_seen(width, sense):
    """Not seen, y would be 3 instead of -1."""
    assert run(width, sense=sense) == pytest.approx(passed(width), abs=1e-10)


@pytest.mark.parametrize("rate", [1e-5, 1e5])
def test_at_any_pace(rate):
    assert run(1e-4, rate=rate) == pytest.approx(passed(1e-4), abs=1e-10)


def test_two_passages_within_what_would_be_one_step():
    """v = t^2 - 1/4 dips below zero between -1/2 and 1/2."""
    dip = System((y,), (sp.tanh((TIME**2 - sp.Rational(1, 4)) / width),), (width,))
    trajectory = integrate(compile_system(dip), [0.0], [1e-5], [-2.0, 2.0])
    assert trajectory.states[0, -1] == pytest.approx(3 - 1, abs=1e-9)


def test_in_batches_each_as_if_it_were_alone():
    batch, widths = compile_batch(PASSING, 1e-6), np.array([*WIDTHS, *WIDTHS[::-1]])
    constants = np.array([batch.constant_values([w, 1.0]) for w in widths]).T
    starts = np.tile([[1.0], [0.0], [1e4]], len(widths))
    got = batch.acquire().advance(starts, constants, np.linspace(0.0, 3.0, 4)).states[1]
    assert got == pytest.approx([passed(w) for w in widths], abs=1e-3)
    assert (got == got[::-1]).all()


def _linear(matrix):
    return lambda state: np.array(matrix) @ state


@pytest.mark.parametrize(
    ("matrix", "angles", "expected"),
    [
        # A decay 100 times as fast as the vibration 3 beside a slow one, which does not count; or 10 times.
        ([[0, 3, 0, 0], [-3, 0, 0, 0], [0, 0, -300, 0], [0, 0, 0, -1]], [], STIFF.format(times=100.0)),
        ([[0, 3, 0, 0], [-3, 0, 0, 0], [0, 0, -30, 0], [0, 0, 0, -1]], [], LONG.format(radians=0.5 * 3)),
        # What grows as fast is not stiff.
        ([[0, 3, 0, 0], [-3, 0, 0, 0], [0, 0, 300, 0], [0, 0, 0, -1]], [], LONG.format(radians=0.5 * 3)),
        # An angle that turns with -7 is the fastest motion, or it would be if it were an angle.
        ([[0, 3, 0, 0], [-3, 0, 0, 0], [0, 0, -100, 0], [0, 0, 0, -7]], [3], LONG.format(radians=0.5 * 7)),
        ([[0, 3, 0, 0], [-3, 0, 0, 0], [0, 0, -100, 0], [0, 0, 0, -7]], [], STIFF.format(times=100 / 3)),
    ],
)
def test_advice_where_steps_run_out(matrix, angles, expected):
    assert advice(_linear(matrix), np.array([0.0, 0.0, 0.0, 1.0]), angles, 0.5) == expected


def test_no_advice_where_the_equations_cannot_be_evaluated_or_steps_are_short_for_another_reason():
    assert advice(lambda s: np.full(2, np.nan), np.zeros(2), [0], 0.5) == UNKNOWN
    assert advice(_linear([[0, 3], [-3, 0]]), np.zeros(2), [], 1e-9) == UNKNOWN


def test_differences_are_taken_at_the_size_of_a_state():
    """x' = -(x - 1e9)^3 at 1e9: differences of 1e-6 of the state, not of 1, give a decay of 1e6."""
    assert advice(lambda s: np.array([-((s[0] - 1e9) ** 3)]), np.array([1e9]), [], 1.0) == STIFF_AT_REST.format(time=1e-6)
