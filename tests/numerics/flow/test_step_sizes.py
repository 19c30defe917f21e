"""Narrow transitions against closed solutions: a step that begins far away must not pass them unseen."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_batch import compile_batch
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.step_sizes import LONG, STIFF, STIFF_AT_REST, UNKNOWN, advice
from wucht.piecewise import PiecewiseCubic, step
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


x = sp.Symbol("x", real=True)
SIGN = step("sign", 0.0, -1.0, 1.0)


@pytest.mark.parametrize(
    ("system", "start", "meeting", "place"),
    [
        # x' = 1/2 - sign(x) from -3.
        (System((x,), (sp.Rational(1, 2) - PiecewiseCubic(x, SIGN),)), [-3.0], 2.0, [0.0]),
        # A spring and dry friction, from 1: after two half swings the spring holds less than friction.
        (System((x, v), (v, -x - sp.Rational(3, 10) * PiecewiseCubic(v, SIGN))), [1.0, 0.0], 2 * np.pi, [-0.2, 0.0]),
    ],
    ids=["drift", "dry friction"],
)
@pytest.mark.parametrize("engine", ["compiled", "radau"])
def test_it_ends_at_the_jump(system: System, start: list[float], meeting: float, place: list[float], engine: str) -> None:
    run = integrate(compile_system(system, 1e-9, engine=engine), start, {}, np.linspace(0.0, 20.0, 20_001))
    assert "slides along a jump" in str(run.failure)
    assert run.time[-1] == pytest.approx(meeting, abs=1e-3)  # the last sample before
    assert run.states[:, -1] == pytest.approx(place, abs=2e-3)


def test_a_fast_rotor_that_runs_down_before_a_long_rest_does_not_slide() -> None:
    """x' = 10^4 exp(-t / 2) passes 6366 jumps of the sign of its sine in seconds, and stays at 2 10^4 rad, where that is 1."""
    system = System((x, v), (10_000 * sp.exp(-TIME / 2), PiecewiseCubic(sp.sin(x), SIGN)))
    run = integrate(compile_system(system, 1e-9), [0.0, 0.0], {}, np.linspace(0.0, 1e6, 2))
    assert run.failure is None
    assert run.states[0, -1] == pytest.approx(2e4, rel=1e-9)


@pytest.mark.parametrize("share", [0.001, 0.999])
def test_friction_that_is_hardly_larger_than_its_force_slides(share: float) -> None:
    """A spring holds a share of the friction: the motion stays where it starts."""
    system = System((x, v), (v, -x - PiecewiseCubic(v, SIGN)))
    run = integrate(compile_system(system, 1e-9), [share, 0.0], {}, np.linspace(0.0, 40.0, 161))
    assert run.is_sliding
    assert run.end_time == 0.0


def test_a_lane_that_slides_ends_alone() -> None:
    """Friction of 0.3 beside a spring from 1 to 20, and none: after two half swings only the weak springs hold less."""
    stiffness, friction = sp.symbols("k f", real=True)
    system = System((x, v), (v, -stiffness * x - friction * PiecewiseCubic(v, SIGN)), (stiffness, friction))
    parameters = np.array([[k, f] for k in (1.0, 4.0, 20.0) for f in (0.3, 0.0)] * 4)
    batch = compile_batch(system, 1e-9)
    constants = np.array([batch.constant_values(p) for p in parameters]).T
    starts, times = np.tile([[1.0], [0.0]], len(parameters)), np.linspace(0.0, 40.0, 401)
    result = batch.acquire().advance(starts, constants, times)
    assert sorted(result.failures) == [i for i, (_, f) in enumerate(parameters) if f]
    for lane, error in result.failures.items():
        alone = integrate(compile_system(system, 1e-9), [1.0, 0.0], parameters[lane], times)
        assert str(error) == str(alone.failure).split(": ", 1)[1].split(" (largest")[0]
        assert result.times[lane] == pytest.approx(alone.end_time, abs=0.1 + 1e-6)
    for lane in np.flatnonzero(parameters[:, 1] == 0):
        assert result.states[0, lane] == pytest.approx(np.cos(np.sqrt(parameters[lane, 0]) * 40.0), abs=1e-6)
