"""Runs: samples where they were asked for, accuracy that follows the tolerance, and failures that say what happened."""

import math
import re

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad
from scipy.special import ellipj, ellipk
from tests.refusals import failed

from wucht.errors import RunError
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.system import TIME, Output, System

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


def test_samples_lie_exactly_on_the_grid(engine):
    """An irregular grid of several legs, which starts neither at 0 nor with the first step."""
    time = 3.0 + np.cumsum(0.001 * (1.5 + np.sin(np.arange(9001.0))))
    run = integrate(compile_system(DAMPED, engine=engine), [1.0, 0.0], {"k": 1.0, "c": 0.0}, time)
    assert np.array_equal(run.time, time)
    assert np.abs(run.states[0] - np.cos(time - time[0])).max() < 1e-10
    assert run.end_time == time[-1]
    assert run.end_state[:2] == pytest.approx(run.states[:, -1], abs=1e-13)


def test_one_sample_is_the_start(engine):
    run = integrate(compile_system(DAMPED, engine=engine), [1.0, 2.0], VALUES, np.array([5.0]))
    assert run.time.tolist() == [5.0]
    assert run.states[:, 0].tolist() == [1.0, 2.0]


def test_explicit_time(engine):
    driven = System((x,), (sp.cos(TIME) * k,), (k,))
    time = np.linspace(1.0, 9.0, 33)
    run = integrate(compile_system(driven, engine=engine), [0.0], [3.0], time)
    assert np.abs(run.states[0] - 3 * (np.sin(time) - np.sin(1.0))).max() < 1e-11


def test_powers_through_zero():
    powers = System((x, y, v), (sp.S.One, x**3, x**4))
    run = integrate(compile_system(powers), [-1.0, 0.0, 0.0], [], np.array([0.0, 1.0, 2.0]))
    assert run.states[:, -1] == pytest.approx([1.0, 0.0, 2 / 5], abs=1e-13)


FUNCTIONS = [
    sp.tan(x), sp.exp(-x), sp.log(2 + x), sp.sinh(x), sp.cosh(x), sp.tanh(3 * x), sp.atan(x), sp.asin(x / 3), sp.acos(x / 3),
    sp.atan2(x, 1 + x), sp.sqrt(1 + x), (1 + x) ** sp.Rational(3, 2), (1 + x) ** -2, (1 + x) ** k, 1 / (1 + x), sp.pi * x,
]  # fmt: skip


@pytest.mark.parametrize("function", FUNCTIONS, ids=str)
def test_integrals_of_functions_are_those_of_quadrature(function):
    run = integrate(compile_system(System((x, y), (sp.S.One, function), (k,))), [0.0, 0.0], [0.7], np.array([0.0, 0.9]))
    exact, _ = quad(sp.lambdify(x, function.subs(k, 0.7), "math"), 0.0, 0.9, epsabs=0.0, epsrel=1e-13)
    assert run.states[1, -1] == pytest.approx(exact, rel=1e-11)


def test_a_function_without_machine_code_is_named():
    with failed("no-function", "besselj"):
        compile_system(System((x,), (sp.besselj(0, x),)))


def test_quadratures_are_integrated_along():
    time = np.linspace(0, 30, 301)
    run = integrate(compile_system(DAMPED), [1.0, 0.0], VALUES, time)
    energy = run.states[1] ** 2 / 2 + 4.0 * run.states[0] ** 2 / 2
    assert np.abs(run.quadratures["lost"] - (2.0 - energy)).max() < 1e-11
    assert np.abs(run.quadratures["way"] - (run.states[0] - 1.0)).max() < 1e-11


def test_continuing_from_the_end_is_the_same_as_one_run():
    flow = compile_system(DAMPED)
    time = np.linspace(0, 20, 401)
    whole = integrate(flow, [1.0, 0.0], VALUES, time)
    first = integrate(flow, [1.0, 0.0], VALUES, time[:151])
    both = first.join(integrate(flow, first.end_state, VALUES, np.concatenate([[first.end_time], time[151:]])))
    assert np.array_equal(both.time, time)
    assert np.abs(both.states - whole.states).max() < 1e-11
    assert np.abs(both.quadratures["lost"] - whole.quadratures["lost"]).max() < 1e-11
    assert np.abs(both.end_state - whole.end_state).max() < 1e-11


def test_a_flow_forgets_the_run_before():
    flow, time = compile_system(DAMPED), np.linspace(0, 5, 11)
    first = integrate(flow, [1.0, 0.0], VALUES, time)
    integrate(flow, [7.0, -3.0], {"k": 9.0, "c": 1.0}, time + 100.0)
    assert np.array_equal(integrate(flow, [1.0, 0.0], VALUES, time).states, first.states)


BEFORE = np.linspace(0, 2, 22)  # no sample at the pole t = 1 itself


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


def test_a_failure_after_many_legs_keeps_them_all():
    grid = np.linspace(0, 2, 20_000)
    run = integrate(compile_system(BLOW_UP), [1.0, 7.0], [1.0], grid)
    assert np.array_equal(run.time, grid[grid < 1])
    assert run.states[0] == pytest.approx(1 / (1 - run.time), rel=1e-7)


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


def test_progress_reports_the_time_reached():
    reached = []
    integrate(compile_system(DAMPED), [1.0, 0.0], VALUES, np.linspace(0, 10, 10_001), reached.append)
    assert reached == sorted(reached)
    assert reached[-1] == 10.0


@pytest.mark.parametrize("initial", [[math.nan, 0.0], [0.0, math.inf]])
def test_an_initial_state_that_is_not_finite_is_refused(initial):
    with failed("initial-state", "2"):
        integrate(compile_system(PENDULUM), initial, [], np.linspace(0, 1, 3))


@pytest.mark.parametrize("initial", [[], [1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0]])
def test_an_initial_state_of_the_wrong_length_is_refused(initial):
    """Two states, or two states and two quadratures: neither one, three nor five numbers."""
    with failed("initial-state", "2"):
        integrate(compile_system(DAMPED), initial, VALUES, np.linspace(0, 1, 3))


@pytest.mark.parametrize("grid", [[], [0.0, 1.0, 1.0], [0.0, 2.0, 1.0]])
def test_times_must_increase(grid):
    with failed("not-increasing"):
        integrate(compile_system(PENDULUM), [1.0, 0.0], [], np.array(grid))


def test_times_must_be_numbers():
    with pytest.raises(RunError):
        integrate(compile_system(PENDULUM), [1.0, 0.0], [], np.array([0.0, math.nan, 1.0]))


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


def test_a_run_begins_beyond_the_events_at_its_start(engine):
    """Those at the end of a run are its own, and not those of one that continues it: each event once, also exactly there."""
    rising = Event("one", x - 1, +1)
    flow = compile_system(System((x,), (sp.S.One,)), events=(rising, Event("two", x - 2)), engine=engine)
    state, hits = np.array([0.25]), []
    for begin, end in ((0.25, 1.0), (1.0, 2.0), (2.0, 3.0)):
        run = integrate(flow, state, [], np.array([begin, end]))
        hits.append([(h.name, h.time) for h in run.hits])
        state = run.end_state
    assert hits == [[("one", 1.0)], [("two", 2.0)], []]
