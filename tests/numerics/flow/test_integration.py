"""Runs: samples where they were asked for, accuracy that follows the tolerance, and failures that say what happened."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad
from scipy.special import ellipj, ellipk
from tests.refusals import failed

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.system import Output, System

x, y, v = sp.symbols("x y v", real=True)
k, c = sp.symbols("k c", real=True)
PENDULUM = System((x, v), (v, -sp.sin(x)), angles=frozenset({x}))
DAMPED = System((x, v), (v, -k * x - c * v), (k, c), quadratures=(Output("lost", c * v**2), Output("way", v)))
BLOW_UP = System((x, v), (x**2, sp.S.Zero), (k,))
VALUES = {"k": 4.0, "c": 0.1}


def swing(time, amplitude=2.0):
    """The pendulum let go at an angle: sin(x/2) = sin(amplitude/2) cd(t), an elliptic function."""
    modulus = math.sin(amplitude / 2)
    sine = ellipj(ellipk(modulus**2) - time, modulus**2)[0]
    return 2 * np.arcsin(modulus * sine)


def test_a_swinging_pendulum_is_an_elliptic_function():
    time = np.linspace(0, 20, 201)
    run = integrate(compile_system(PENDULUM), [2.0, 0.0], [], time)
    assert np.abs(run.states[0] - swing(time)).max() < 1e-9


def test_the_error_falls_with_the_tolerance(engine):
    """Measured order: the slope of log(error) over log(tolerance) is 1.28 (explicit) and 1.30 (implicit)."""
    tolerances, end = 10.0 ** -np.arange(4, 10), np.array([0.0, 10.0])
    runs = [integrate(compile_system(PENDULUM, t, engine=engine), [2.0, 0.0], [], end) for t in tolerances]
    errors = np.array([abs(run.states[0, -1] - swing(10.0)) for run in runs])
    assert 0.9 < np.polyfit(np.log(tolerances), np.log(errors), 1)[0] < 1.5
    assert (errors < 20 * tolerances).all()


FUNCTIONS = [
    sp.tan(x), sp.exp(-x), sp.log(2 + x), sp.sinh(x), sp.cosh(x), sp.tanh(3 * x), sp.atan(x), sp.asin(x / 3), sp.acos(x / 3),
    sp.atan2(x, 1 + x), sp.sqrt(1 + x), (1 + x) ** sp.Rational(3, 2), (1 + x) ** -2, (1 + x) ** k, 1 / (1 + x), sp.pi * x,
]  # fmt: skip


def test_integrals_of_functions_are_those_of_quadrature():
    integrals = sp.symbols(f"s:{len(FUNCTIONS)}", real=True)
    system = System((x, *integrals), (sp.S.One, *FUNCTIONS), (k,))
    run = integrate(compile_system(system), np.zeros(1 + len(FUNCTIONS)), [0.7], np.array([0.0, 0.9]))
    for function, found in zip(FUNCTIONS, run.states[1:, -1], strict=True):
        exact, _ = quad(sp.lambdify(x, function.subs(k, 0.7), "math"), 0.0, 0.9, epsabs=0.0, epsrel=1e-13)
        assert found == pytest.approx(exact, rel=1e-11), function


def test_a_function_without_machine_code_is_named():
    with failed("no-function", "besselj"):
        compile_system(System((x,), (sp.besselj(0, x),)))


def test_quadratures_are_integrated_along():
    time = np.linspace(0, 30, 301)
    run = integrate(compile_system(DAMPED), [1.0, 0.0], VALUES, time)
    energy = run.states[1] ** 2 / 2 + 4.0 * run.states[0] ** 2 / 2
    assert np.abs(run.quadratures["lost"] - (2.0 - energy)).max() < 1e-11
    assert np.abs(run.quadratures["way"] - (run.states[0] - 1.0)).max() < 1e-11


BEFORE = np.linspace(0, 2, 22)  # no sample at the pole t = 1 itself


@pytest.mark.slow
def test_a_failure_names_time_state_and_remedy_and_keeps_the_samples_before_it(engine):
    """x' = x^2 from x = 1 is 1/(1 - t): infinite at t = 1. The last sample is at t = 20/21, where x = 21."""
    tolerance = {"compiled": 1e-12, "radau": 1e-9}[engine]
    run = integrate(compile_system(BLOW_UP, tolerance, engine=engine), [1.0, 7.0], [1.0], BEFORE)
    time = float(re.match(r"the integration failed at t = ([\d.]+): ", run.failure)[1])
    assert 20 / 21 - 1e-6 <= time <= 1
    assert "x = 21, v = 7" in run.failure
    assert "Look for a parameter that is off by a factor of thousands" in run.failure
    assert not run.is_interrupted
    assert run.time.tolist() == BEFORE[:11].tolist()
    assert run.states[0] == pytest.approx(1 / (1 - BEFORE[:11]), rel=100 * tolerance)
    assert run.states[1].tolist() == [7.0] * 11
    # The state reached is a number, so that the run can be examined, and continued with other parameters.
    assert run.end_state[0] == pytest.approx(1 / (1 - run.end_time), rel=1000 * tolerance)


@pytest.mark.parametrize("rate", [-1 - sp.sqrt(x), -sp.sqrt(x), 1 / (x - 1)], ids=str)
def test_rates_that_are_not_numbers_end_a_run(engine, rate):
    """From x = 1: beyond x = 0, or at once, which SciPy's linear algebra would otherwise refuse with its own words."""
    run = integrate(compile_system(System((x,), (rate,)), 1e-8, engine=engine), [1.0], [], np.linspace(0, 3, 31))
    assert run.failure.startswith("the integration failed at t = ")
    assert np.isfinite(run.states).all()


def test_parameters_that_divide_by_zero_are_refused_with_a_sentence():
    system = System((x,), (x / k,), (k,))
    with failed("not-evaluated", "k = 0"):
        integrate(compile_system(system), [1.0], {"k": 0.0}, np.linspace(0, 1, 5))


def test_ctrl_c_keeps_what_was_computed():
    flow = compile_system(DAMPED)
    time, reached = np.linspace(0, 10, 10_001), []

    def impatient(at):
        reached.append(at)
        if len(reached) == 2:
            raise KeyboardInterrupt

    run = integrate(flow, [1.0, 0.0], VALUES, time, impatient)
    count = len(run.time)
    assert run.is_interrupted
    assert run.failure is None
    assert 0 < count < len(time)
    assert np.array_equal(run.time, time[:count])
    assert run.end_time == reached[-1] == time[count - 1]
    assert run.end_state[:2] == pytest.approx(run.states[:, -1], abs=1e-13)
    rest = integrate(flow, run.end_state, VALUES, time[count - 1 :])
    whole = integrate(flow, [1.0, 0.0], VALUES, time)
    assert np.array_equal(run.join(rest).time, time)
    assert np.abs(run.join(rest).states - whole.states).max() < 1e-11
    assert np.abs(run.join(rest).quadratures["lost"] - whole.quadratures["lost"]).max() < 1e-11


@pytest.mark.parametrize("initial", [[0.0, math.inf], [1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0]])
def test_an_initial_state_that_is_not_finite_or_of_the_wrong_length_is_refused(initial):
    """Two states, or two states and two quadratures."""
    with failed("initial-state", "2"):
        integrate(compile_system(DAMPED), initial, VALUES, np.linspace(0, 1, 3))


@pytest.mark.parametrize("grid", [[], [0.0, 1.0, 1.0], [0.0, 2.0, 1.0]])
def test_times_must_increase(grid):
    with failed("not-increasing"):
        integrate(compile_system(PENDULUM), [1.0, 0.0], [], np.array(grid))


@pytest.mark.parametrize(
    ("system", "start", "end", "says"),
    [
        (System((x, v), (v, -x)), [1.0, 0.0], 1e8, "not stiff, but the time between samples is long"),
        (System((x,), (sp.S.One,), angles=frozenset({x})), [0.0], 1e8, None),
        (System((x, v), (v, -1e9 * (v - sp.cos(x))), angles=frozenset({x})), [0.0, 1.0], 100.0, "The machine is stiff"),
    ],
)
def test_where_steps_run_out_it_says_whether_the_machine_is_stiff_or_the_run_only_long(system, start, end, says):
    run = integrate(compile_system(system), start, [], np.array([0.0, end]))
    if says is None:
        assert run.failure is None
    else:
        assert "500000 steps were not enough" in run.failure
        assert says in run.failure


CLOCK = System((x,), (sp.S.One,), quadratures=(Output("area", x),))
GRID = np.linspace(0.0, 1.0, 11)


def _assert_clock(run, time):
    assert run.time.tolist() == list(time)
    assert run.states[0] == pytest.approx(time, abs=1e-12)
    assert run.quadratures["area"] == pytest.approx(np.square(time) / 2, abs=1e-12)


def test_every_third_sample_and_the_last_one():
    run = integrate(compile_system(CLOCK), [0.0], [], GRID)
    for with_last, kept in ((False, [0, 3, 6, 9]), (True, [0, 3, 6, 9, 10])):
        _assert_clock(run.subsample(3, with_last), GRID[kept])


def test_a_part_that_begins_at_an_event_between_two_samples_keeps_all_of_its_own():
    stop = Event("stop", x - sp.Rational(11, 20), terminal=True)
    first = integrate(compile_system(CLOCK, events=(stop,)), [0.0], [], GRID)
    assert first.stopped_by == "stop"
    time = np.array([first.end_time, *GRID[6:]])
    rest = integrate(compile_system(CLOCK), first.end_state, [], time)
    _assert_clock(first.join(rest), [*GRID[:6], *time])


eps = sp.Symbol("eps", real=True)
VAN_DER_POL = System((x, v), (v, ((1 - x**2) * v - x) / eps), (eps,))
TIMES, START = np.array([0.0, 1.0, 2.0]), [2.0, 0.0]
REFERENCE = [[-1.863646254808130, 1.706167732170456], [0.7535430865435460, -0.8928097010248257]]  # x, v at 1 and 2


def test_few_evaluations() -> None:
    """A wrong Jacobian changes no result but their number: 7,743; with one that is 10 % too small 8,055, with none millions."""
    integrator = compile_system(VAN_DER_POL, 1e-6, engine="radau").engine.acquire()
    integrator.start(0.0, np.array([*START]), [1e-6, 1.0])
    integrator.leg(TIMES)
    assert integrator.evaluation_count < 7_900


def test_the_reference_solution() -> None:
    """The measured error is 7e-8 at 1e-6, 3e-9 at 1e-8 and 1e-13 at 1e-12."""
    run = integrate(compile_system(VAN_DER_POL, 1e-8, engine="radau"), START, [1e-6], TIMES)
    assert run.failure is None
    assert run.states[:, 1:] == pytest.approx(np.array(REFERENCE), abs=1e-8)
