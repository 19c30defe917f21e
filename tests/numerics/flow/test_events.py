"""Events: their exact times, what they change, in which order, the same by both integrators."""

import math
import pickle

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event, LegError
from wucht.numerics.flow.integration import integrate
from wucht.system import TIME, System

x, v, w, b = sp.symbols("x v w b", real=True)
slope, no_load, inertia, held, rate, g, e = sp.symbols("slope no_load inertia held rate g e", real=True)

MOTOR = System((w,), (slope * (no_load - w) / inertia,), (slope, no_load, inertia))
MOTOR_VALUES = {"slope": 0.5, "no_load": 200.0, "inertia": 2.0}
OSCILLATOR = System((x, v), (v, -x))
TURN = 2 * math.pi


def run_with(system, events, initial, parameters, grid, engine=None):
    return integrate(compile_system(system, events=tuple(events), engine=engine), initial, parameters, grid)


def run_up_time(speed):
    """A motor of linear characteristic without load: w = no_load (1 - exp(-slope t / inertia))."""
    return -2.0 / 0.5 * math.log(1 - speed / 200.0)


def test_the_exact_time_of_a_speed(engine):
    run = run_with(MOTOR, (Event("150", w - 150, +1),), [0.0], MOTOR_VALUES, np.linspace(0, 30, 31), engine)
    (hit,) = run.hits
    assert hit.name == "150"
    assert hit.time == pytest.approx(run_up_time(150.0), abs=1e-11)
    assert hit.state == pytest.approx([150.0], abs=1e-9)
    assert run.time[-1] == 30.0  # an event without consequence stops nothing


def test_the_threshold_may_be_a_parameter():
    threshold = sp.Symbol("threshold", real=True)
    system = System(MOTOR.states, MOTOR.derivatives, (*MOTOR.parameters, threshold))
    for speed in (20.0, 150.0, 199.0):
        run = run_with(
            system, (Event("there", w - threshold),), [0.0], MOTOR_VALUES | {"threshold": speed}, np.array([0.0, 30.0])
        )
        assert run.hits[0].time == pytest.approx(run_up_time(speed), abs=1e-9)


def test_a_terminal_event_ends_the_run(engine):
    grid = np.linspace(0, 30, 301)
    run = run_with(MOTOR, (Event("150", w - 150, terminal=True), Event("never", w - 500)), [0.0], MOTOR_VALUES, grid, engine)
    assert run.stopped_by == "150"
    assert run.failure is None
    assert run.end_time == pytest.approx(run_up_time(150.0), abs=1e-11)
    assert run.end_state == pytest.approx([150.0], abs=1e-9)
    assert np.array_equal(run.time, grid[grid < run.end_time])
    assert [h.name for h in run.hits] == ["150"]


@pytest.mark.parametrize(
    ("direction", "expected"),
    [(+1, [0.75 * TURN, 1.75 * TURN]), (-1, [0.25 * TURN, 1.25 * TURN]), (0, [k * TURN / 4 for k in (1, 3, 5, 7)])],
)
def test_direction(engine, direction, expected):
    """x = cos t falls through zero at a quarter turn and rises at three quarters."""
    run = run_with(OSCILLATOR, (Event("zero", x, direction),), [1.0, 0.0], [], np.linspace(0, 2 * TURN, 50), engine)
    assert [h.time for h in run.hits] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("samples", [2, 40, 9000])
def test_hits_come_in_order_of_time(engine, samples):
    """Whatever the order in which events were given, and whether or not they fall into one step or one leg."""
    events = [Event(f"{k}", x - sp.Rational(k, 10)) for k in (3, -8, 8, 0, -3)]
    run = run_with(OSCILLATOR, events, [1.0, 0.0], [], np.linspace(0, 2 * TURN, samples), engine)
    fall, rise = ["8", "3", "0", "-3", "-8"], ["-8", "-3", "0", "3", "8"]
    assert [h.name for h in run.hits] == fall + rise + fall + rise
    times = [math.acos(int(h.name) / 10) for h in run.hits[:5]]
    assert [h.time for h in run.hits[:5]] == pytest.approx(times, abs=1e-10)


def test_hits_around_an_action_come_in_order():
    """Passing events before and after one that acts, within one step of the integrator."""
    clock = System((x,), (sp.S.One,))
    act = Event("act", x - sp.Rational(1, 2), action=lambda t, state, pars: (state, pars))
    around = (Event("late", x - sp.Rational(3, 5)), act, Event("early", x - sp.Rational(2, 5)))
    run = run_with(clock, around, [0.0], [], np.array([0.0, 1.0]))
    assert [h.name for h in run.hits] == ["early", "act", "late"]
    assert [h.time for h in run.hits] == pytest.approx([0.4, 0.5, 0.6], abs=1e-12)


# A leader that accelerates at a given rate, and a body that is held by it until it is released, then keeps its speed: `held`
# multiplies what the body has in common with the leader.
HELD = System((w, b), (rate, held * rate), (rate, held))


def release(t, state, parameters):
    return state, np.array([parameters[0], 0.0])


@pytest.mark.parametrize("samples", [2, 11, 9001])
def test_a_body_released_at_a_time(samples):
    """The grid of 11 has a sample at the very moment."""
    grid = np.linspace(0, 10, samples)
    run = run_with(HELD, (Event("release", TIME - 3, action=release),), [0.0, 0.0], {"rate": 2.0, "held": 1.0}, grid)
    assert np.array_equal(run.time, grid)
    assert [h.time for h in run.hits] == pytest.approx([3.0], abs=1e-12)
    assert np.abs(run.states[0] - 2 * grid).max() < 1e-11
    assert np.abs(run.states[1] - 2 * np.minimum(grid, 3.0)).max() < 1e-11
    assert run.final_parameter_values.tolist() == [2.0, 0.0]


def test_a_body_released_at_a_speed():
    grid = np.linspace(0, 10, 101)
    for acceleration in (2.0, 1.0, 0.5):
        run = run_with(
            HELD, (Event("release", w - 7, +1, action=release),), [0.0, 0.0], {"rate": acceleration, "held": 1.0}, grid
        )
        reached = 7 / acceleration
        assert [h.time for h in run.hits] == pytest.approx([reached] if reached < 10 else [], abs=1e-11)
        assert np.abs(run.states[1] - acceleration * np.minimum(grid, reached)).max() < 1e-10


def test_the_hit_shows_the_state_before_the_action():
    kick = Event("kick", TIME - 1, action=lambda t, state, pars: (np.array([0.0, 5.0]), pars))
    run = run_with(HELD, (kick,), [1.0, 0.0], [1.0, 1.0], np.array([0.0, 0.5, 2.0]))
    assert run.hits[0].state == pytest.approx([2.0, 1.0], abs=1e-12)
    assert run.states[:, -1] == pytest.approx([1.0, 6.0], abs=1e-12)


def test_two_actions_in_one_step_both_happen(engine):
    add = [Event(f"at {t}", TIME - t, action=lambda t, s, p: (s + np.array([0.0, 10.0]), p)) for t in (2, 1)]
    run = run_with(HELD, add, [0.0, 0.0], [1.0, 1.0], np.array([0.0, 5.0]), engine)
    assert [h.name for h in run.hits] == ["at 1", "at 2"]
    assert run.states[1, -1] == pytest.approx(25.0, abs=1e-12)


BALL = System((x, v), (v, -g), (g, e))


def bounce(t, state, parameters):
    return np.array([state[0], -parameters[1] * state[1]]), parameters


def bounces(count):
    """Dropped from 1 m: first contact at sqrt(2 h/g), then flights each shorter by e = 0.8."""
    first = math.sqrt(2 / 9.81)
    return [first * (1 + 2 * sum(0.8**k for k in range(1, n))) for n in range(1, count + 1)]


@pytest.mark.parametrize("direction", [-1, 0])
def test_a_bouncing_ball(engine, direction):
    """The action turns the state back to the side it came from, so the event function touches zero without crossing it."""
    run = run_with(
        BALL, (Event("floor", x, direction, action=bounce),), [1.0, 0.0], {"g": 9.81, "e": 0.8}, np.linspace(0, 3, 301), engine
    )
    assert [h.time for h in run.hits] == pytest.approx(bounces(6), abs=1e-10)
    assert run.states[0].min() > -1e-12


def test_an_action_may_also_end_the_run():
    last = Event("floor", x, -1, terminal=True, action=bounce)
    run = run_with(BALL, (last,), [1.0, 0.0], [9.81, 0.8], np.linspace(0, 3, 31))
    assert run.stopped_by == "floor"
    assert run.end_state[1] == pytest.approx(0.8 * math.sqrt(2 * 9.81), abs=1e-10)


@pytest.mark.parametrize("acts", [False, True])
def test_an_event_at_the_border_of_two_legs_counts_once(engine, acts, monkeypatch):
    """Samples are taken in legs; an event may lie exactly where one ends and the next begins."""
    clock, grid, borders = System((x,), (sp.S.One,)), np.linspace(0, 1, 20_001), []
    integrate(compile_system(clock, engine=engine), [0.0], [], grid, borders.append)
    assert len(borders) > 2
    border, action = borders[len(borders) // 2], (lambda t, s, p: (s, p)) if acts else None
    run = run_with(clock, (Event("border", TIME - border, action=action),), [0.0], [], grid, engine)
    assert [h.time for h in run.hits] == pytest.approx([border], abs=1e-12)
    assert np.abs(run.states[0] - grid).max() < 1e-12


@pytest.mark.parametrize("pace", [0.3, 0.7, 1.1, 1.7, 2.0, 3.1, 7.3, 11.7])
def test_an_event_within_rounding_of_the_end_of_a_run(engine, pace):
    """The state at the end and the interpolation there may lie on either side of it."""
    clock = System((x,), (rate,), (rate,))
    flow = compile_system(clock, events=(Event("one", x - 1),), engine=engine)
    first = integrate(flow, [0.0], [pace], np.array([0.0, 1 / pace]))
    second = integrate(flow, first.end_state, [pace], np.array([first.end_time, 2 / pace]))
    assert [h.time for h in (*first.hits, *second.hits)] == pytest.approx([1 / pace], rel=1e-12)


def test_more_than_a_million_events_fail_with_a_sentence(monkeypatch):
    """As a ball at rest would; what was computed until then is kept."""
    monkeypatch.setattr("wucht.numerics.flow.integration._MOST_HITS", 10)
    run = run_with(BALL, (Event("floor", x, -1, action=bounce),), [1.0, 0.0], {"g": 9.81, "e": 0.8}, np.linspace(0, 6, 61))
    assert "more than 10 events" in run.failure
    assert run.time[-1] == pytest.approx(3.6)


def test_a_ball_whose_flights_become_short():
    """Fifty contacts: the last flights take some 1e-5 s, and none of their ends is missed."""
    end = bounces(51)[-1] - 1e-6
    run = run_with(BALL, (Event("floor", x, -1, action=bounce),), [1.0, 0.0], {"g": 9.81, "e": 0.8}, np.linspace(0, end, 5))
    assert [h.time for h in run.hits] == pytest.approx(bounces(50), abs=1e-9)
    assert run.states[0].min() > -1e-12


@pytest.mark.parametrize("terminal", [False, True])
def test_a_run_does_not_know_of_the_events_of_the_run_before(engine, terminal):
    """A clock that creeps up to the event, then one that passes it soon after its start: both see it."""
    clock, action = System((x,), (rate,), (rate,)), None if terminal else (lambda t, state, pars: (state, pars))
    flow = compile_system(clock, events=(Event("one", x - 1, +1, terminal=terminal, action=action),), engine=engine)
    for speed, before in ((1e-6, 1e-6), (1.0, 1e-6)):
        run = integrate(flow, [1 - before], [speed], np.array([0.0, 2.0]))
        assert [h.name for h in run.hits] == ["one"]
        assert run.hits[0].time == pytest.approx(before / speed, rel=1e-5)


@pytest.mark.parametrize("speed", [0.01, 1.0, 300.0])
def test_steps_follow_an_event_function_that_changes_faster_than_the_states(speed):
    """An angle that turns evenly asks for no short steps, its sine does."""
    turning = System((x,), (rate,), (rate,), angles=frozenset({x}))
    run = run_with(turning, (Event("zero", sp.sin(x)),), [0.5], [speed], np.array([0.0, 100 / speed]))
    assert [h.time for h in run.hits] == pytest.approx([(k * math.pi - 0.5) / speed for k in range(1, 32)], rel=1e-11)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(-9, 9), min_size=1, max_size=5, unique=True))
def test_the_events_of_a_polynomial_are_its_roots(tenths):
    """Of x = cos t, fall and rise; neighbouring roots may lie within one step, of a fifth of a radian."""
    run = run_with(OSCILLATOR, (Event("root", sp.prod([10 * x - k for k in tenths])),), [1.0, 0.0], [], np.array([0.0, TURN]))
    falls = [math.acos(k / 10) for k in sorted(tenths, reverse=True)]
    assert [h.time for h in run.hits] == pytest.approx([*falls, *(TURN - t for t in reversed(falls))], abs=1e-9)


def test_a_run_continued_from_its_own_terminal_event_goes_on(engine):
    """x = sin t rises through 1/2 once a turn: six runs, each from where the last one ended."""
    event = Event("half", x - sp.Rational(1, 2), +1, terminal=True)
    time, state, times = 0.0, np.array([0.0, 1.0]), []
    for _ in range(6):
        run = run_with(OSCILLATOR, (event,), state, {}, np.array([time, time + 20.0]), engine)
        assert run.stopped_by == "half"
        assert [h.name for h in run.hits] == ["half"]
        time, state = run.end_time, run.end_state
        times.append(time)
    assert times == pytest.approx([math.pi / 6 + k * TURN for k in range(6)], abs=1e-7)


def test_a_quick_return_to_the_event_at_which_a_run_begins_is_one():
    """From x = 0 upwards at 1e-3 under gravity: it falls through 0 again after 2e-3/g."""
    falling = System((x, v), (v, -g), (g,))
    run = run_with(falling, (Event("floor", x, terminal=True),), [0.0, 1e-3], {"g": 10.0}, np.array([0.0, 1.0]))
    assert run.stopped_by == "floor"
    assert run.end_time == pytest.approx(2e-4, rel=1e-6)


def test_the_sentence_of_a_failure_names_the_largest_states():
    """Four of them, by their magnitudes, in that order."""
    error = LegError("it overflows", "Try again.", np.zeros((5, 0)))
    sentence = error.sentence(2.5, ["a", "b", "c", "d", "e"], np.array([1.0, -7.0, 3.0, 0.5, -2.0]))
    assert (
        "t = 2.5: it overflows" in sentence and "b = -7, c = 3, e = -2, a = 1)" in sentence and sentence.endswith("Try again.")
    )


def test_a_failure_goes_to_another_process_whole():
    error = pickle.loads(pickle.dumps(LegError("it overflows", "Try again.", np.ones((2, 3)), 1e-3)))
    assert (str(error), error.remedy, error.samples.tolist(), error.step) == (
        "it overflows",
        "Try again.",
        [[1.0] * 3] * 2,
        1e-3,
    )


def test_a_first_step_does_not_pass_whole_turns_with_their_events():
    """From any angle, large ones too, at any constant speed: each turn has its event."""
    angle, speed = sp.symbols("angle speed", real=True)
    rng, rising = np.random.default_rng(1), Event("rising", sp.sin(angle - sp.Rational(1, 3)), +1)
    for k in range(60):
        start, turns = 2 * np.pi * int(rng.integers(0, 100_000)), rng.uniform(1, 400) if k % 2 else int(rng.integers(1, 400))
        end = 2 * np.pi * turns
        for angles in (frozenset(), frozenset((angle,))):
            flow = compile_system(System((angle,), (speed,), (speed,), angles=angles), 1e-9, (rising,))
            run = integrate(flow, [start], [end], np.array([0.0, 1.0]))
            first, last = (np.floor((at - 1 / 3) / (2 * np.pi)) for at in (start, start + end))
            assert len(run.hits) == last - first
