"""Breakpoints are taken exactly: Systems with piecewise functions against solutions known in closed form, by both integrators.

An integrator of high order that steps across a kink or a jump loses all its order: errors of 1e-3 to 1e-6 at any tolerance.
Where the breakpoints are located, the errors are those of the smooth pieces, 1e-12 and a few roundings.
"""

import math
import time

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import CubicSpline

from wucht.numerics.flow.compiled_batch import compile_batch
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.segments import Segmentation
from wucht.numerics.flow.trajectory import Trajectory
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated_pieces, step
from wucht.system import TIME, Output, System

x, y, v, w, a, b, c, d = sp.symbols("x y v w a b c d", real=True)
TRIANGLES = interpolated_pieces("triangles", np.arange(11.0), [0.0, 1.0] * 5 + [0.0], "linear")
BILINEAR = Pieces("spring", (0.0,), ((0, 1, 0, 0), (0, 4, 0, 0)))  # stiffness 1 on the left, 4 on the right
SIGN = step("sign", 0.0, -1.0, 1.0)
HEAVISIDE = step("H", 0.0, 0.0, 1.0)
# The interpolation between steps is of lower order than the steps.
BETWEEN = 1e-10


LANES = "lanes"  # of an ensemble: neither events nor quadratures
each_alone_and_on_lanes = pytest.mark.parametrize("engine", ["compiled", LANES])
on_all = pytest.mark.parametrize("engine", ["compiled", "radau", LANES])


def run(system, initial, end, samples=2, parameters=(), events=(), tolerance=1e-12, begin=0.0, engine=None, **more):
    times = np.linspace(begin, end, samples)
    if engine == LANES:
        return on_lanes(system, initial, times, parameters, tolerance)
    flow = compile_system(system, tolerance, events, engine)
    trajectory = integrate(flow, initial, parameters, times, **more)
    assert trajectory.failure is None
    return trajectory


def on_lanes(system, initial, times, parameters, tolerance):
    """The motion on lanes, the last of twenty: two vectors."""
    batch = compile_batch(system, tolerance)
    columns = (np.repeat(np.reshape(column, (-1, 1)), 20, axis=1) for column in (initial, batch.constant_values(parameters)))
    integrator = batch.acquire()
    result = integrator.advance(*columns, times)
    batch.release(integrator)
    assert not result.failures
    states = np.column_stack([initial, result.values[:, :, -1].T])
    return Trajectory(times, states, {}, np.array(parameters), float(times[-1]), result.states[:, -1])


def bilinear(time):
    """x'' = -x left, -4 x right, from x = 0 with x' = 1: half periods pi/2 to the right and pi to the left."""
    s = time % (1.5 * math.pi)
    right = s < math.pi / 2
    late = s - math.pi / 2
    return np.where(right, np.sin(2 * s) / 2, -np.sin(late)), np.where(right, np.cos(2 * s), -np.cos(late))


@on_all
@pytest.mark.parametrize("samples", [2, 97, 3001])
def test_a_polygon_over_time(engine, samples):
    """The integral of triangles, each of area 1/2: exact in binary at whole times."""
    system = System((x,), (PiecewiseCubic(TIME, TRIANGLES),))
    trajectory = run(system, [0.25], 12.0, samples, engine=engine)
    inside = np.minimum(trajectory.time, 10.0)
    s = inside % 2
    area = np.floor(inside / 2) + np.where(s < 1, s**2 / 2, 1 - (2 - s) ** 2 / 2)
    assert np.abs(trajectory.states[0] - 0.25 - area).max() < 2e-13


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "tolerance"),
    [(engine, tolerance) for engine in ("compiled", LANES) for tolerance in (1e-6, 1e-9, 1e-12)]
    + [("radau", 1e-6), ("radau", 1e-9)],
)
def test_a_kink_in_the_state_costs_no_accuracy(engine, tolerance):
    """Ten periods of a bilinear spring, forty breakpoints: the error stays near the tolerance, as for a smooth oscillator."""
    system = System((x, v), (v, -PiecewiseCubic(x, BILINEAR)))
    trajectory = run(system, [0.0, 1.0], 15 * math.pi, 333, tolerance=tolerance, engine=engine)
    error = np.abs(trajectory.states - bilinear(trajectory.time)).max()
    assert error < 300 * tolerance if tolerance > 1e-12 else error < 2e-11


@each_alone_and_on_lanes
def test_a_jump_in_the_state_costs_no_accuracy(engine):
    """x'' = -sign(x): parabolas of period 4 sqrt(2 h); fifty breakpoints, each of whose roundings is carried on."""
    system = System((x, v), (v, -PiecewiseCubic(x, SIGN)))
    period = 4 * math.sqrt(2)
    trajectory = run(system, [1.0, 0.0], 25.25 * period, 102, engine=engine)
    s = trajectory.time % period
    quarter = period / 4
    exact = np.where(
        s < quarter, 1 - s**2 / 2, np.where(s < 3 * quarter, -1 + (s - 2 * quarter) ** 2 / 2, 1 - (period - s) ** 2 / 2)
    )
    assert np.abs(trajectory.states[0] - exact).max() < 1e-10


@each_alone_and_on_lanes
def test_a_step_at_a_time(engine):
    """An oscillator on which a force of 3 acts from t = 1 on, sampled at the very time of the step."""
    force = PiecewiseCubic(TIME, step("F", 1.0, 0.0, 3.0))
    system = System((x, v), (v, -x + force))
    trajectory = run(system, [1.0, 0.0], 5.0, 501, engine=engine)
    exact = np.cos(trajectory.time) + np.where(trajectory.time < 1, 0, 3 * (1 - np.cos(trajectory.time - 1)))
    assert np.abs(trajectory.states[0] - exact).max() < BETWEEN


@on_all
@pytest.mark.parametrize("offset", [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 3e-10, 1e-9, 1e-7])
def test_two_arguments_reach_their_breakpoints_together(engine, offset):
    """Two clocks, one a little ahead: both segments must change at every breakpoint, in any order of their events."""
    fa, fb = PiecewiseCubic(a, TRIANGLES), PiecewiseCubic(b, TRIANGLES)
    system = System((a, b, x, y), (sp.S.One, sp.S.One, fa, fb))
    trajectory = run(system, [0.0, offset, 0.0, 0.0], 10.5, 22, engine=engine)
    eighths = np.cumsum([0, *([1, 3, 3, 1] * 5), 0])  # at every half second
    assert trajectory.states[2] == pytest.approx(eighths / 8, abs=1e-12)
    assert trajectory.states[3] == pytest.approx(trajectory.states[2], abs=1e-12 + 11 * offset)


@each_alone_and_on_lanes
@pytest.mark.parametrize("offset", [0.0, 1e-14, 1e-10, 3e-10])
def test_two_arguments_reach_jumps_together_in_opposite_directions(engine, offset):
    """x'' = -sign(x) twice, one mirrored and a little late: all hundred jumps of both are taken."""
    system = System((x, v, y, w), (v, -PiecewiseCubic(x, SIGN), w, -PiecewiseCubic(y, SIGN)))
    period = 4 * math.sqrt(2)
    trajectory = run(system, [1.0, 0.0, -1.0 - offset, 0.0], 12.5 * period, 2, engine=engine)
    assert trajectory.states[:2, -1] == pytest.approx([-1.0, 0.0], abs=1e-10)
    assert trajectory.states[2:, -1] == pytest.approx([1.0, 0.0], abs=1e-10 + 100 * offset)


@each_alone_and_on_lanes
def test_mirrored_motions_stay_mirrored(engine):
    """Symmetrical bodies meet their breakpoints at the same instant, for ever: x and y = -x of two equal systems."""
    system = System((x, v, y, w), (v, -PiecewiseCubic(x, BILINEAR), w, PiecewiseCubic(-y, BILINEAR)))
    trajectory = run(system, [0.0, 1.0, 0.0, -1.0], 15 * math.pi, 200, engine=engine)
    assert np.abs(trajectory.states[:2] + trajectory.states[2:]).max() < 1e-13
    assert np.abs(trajectory.states[:2] - bilinear(trajectory.time)).max() < 2e-11


@on_all
@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_an_argument_that_starts_on_its_breakpoint(engine, speed):
    """The piece on the side to which it moves holds."""
    system = System((x, v), (v, -PiecewiseCubic(x, BILINEAR)))
    trajectory = run(system, [0.0, speed], 1.5 * math.pi, 100, engine=engine)
    shift = 0.0 if speed > 0 else math.pi / 2
    assert np.abs(trajectory.states - bilinear(trajectory.time + shift)).max() < BETWEEN


@each_alone_and_on_lanes
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_argument_that_starts_on_its_breakpoint_at_rest_and_is_pushed_off(engine, side):
    """With a force of constant direction: x'' = side - spring."""
    system = System((x, v), (v, c - PiecewiseCubic(x, BILINEAR)), (c,))
    trajectory = run(system, [0.0, 0.0], 6.0, 60, parameters=[side], engine=engine)
    k = 4.0 if side > 0 else 1.0
    assert trajectory.states[0] == pytest.approx(side / k * (1 - np.cos(math.sqrt(k) * trajectory.time)), abs=BETWEEN)


@on_all
def test_an_argument_at_rest_on_its_breakpoint_stays(engine):
    system = System((x, v), (v, -PiecewiseCubic(x, BILINEAR)))
    assert np.abs(run(system, [0.0, 0.0], 10.0, 3, engine=engine).states).max() == 0.0


GRAZING = [0.0, *(s * 10.0**-k for k in (16, 15, 14, 13, 12, 11, 10, 8, 6, 4) for s in (1, -1))]


@each_alone_and_on_lanes
@pytest.mark.parametrize("height", GRAZING)
def test_an_argument_that_grazes_its_breakpoint_goes_back(engine, height):
    """x = 1 + height - (t - 3)^2 reaches the breakpoint 1 for an instant, or almost; what follows must not be missed:
    y' = slope 1 below the breakpoint, 100 above it."""
    kink = Pieces("k", (1.0,), ((0, 1, 0, 0), (0, 100, 0, 0)))
    system = System((x, v, y), (v, sp.Float(-2.0), PiecewiseCubic(x, kink)))
    trajectory = run(system, [1 + height - 9.0, 6.0, 0.0], 6.0, 7, engine=engine)
    t = trajectory.time - 3.0
    exact = height * (t + 3) - (t**3 + 27) / 3
    if height > 0:
        over = np.clip(t, -math.sqrt(height), math.sqrt(height))
        exact += 99 * (height * (over + math.sqrt(height)) - (over**3 + height**1.5) / 3)
    assert trajectory.states[2] == pytest.approx(exact, abs=2e-11)


@each_alone_and_on_lanes
def test_breakpoints_close_together(engine):
    """A thousand breakpoints 1e-5 apart, passed within 0.01: a staircase up and down."""
    heights = np.tile([0.0, 1.0], 500)
    system = System((x,), (PiecewiseCubic(TIME, interpolated_pieces("s", 1 + 1e-5 * np.arange(1000), heights, "steps")),))
    trajectory = run(system, [0.0], 2.0, 3, engine=engine)
    exact = 500e-5 + 1 - 999e-5 - 1e-5  # half of the stairs, then the last step holds
    assert trajectory.states[0, -1] == pytest.approx(exact, abs=1e-12)


@each_alone_and_on_lanes
def test_a_measured_record_of_hundreds_of_points(engine):
    """The integral of a cubic spline is known: a record of 300 points, uneven in time."""
    rng = np.random.default_rng(5)
    times = np.cumsum(rng.uniform(0.002, 0.05, 300))
    values = rng.normal(size=300)
    exact = CubicSpline(times, values, bc_type="clamped").antiderivative()
    system = System((x,), (PiecewiseCubic(TIME, interpolated_pieces("r", times, values, "spline")),))
    trajectory = run(system, [0.0], times[-1], 40, begin=times[0], engine=engine)
    assert trajectory.states[0] == pytest.approx(exact(trajectory.time), abs=1e-12)


@each_alone_and_on_lanes
def test_a_piecewise_function_of_a_piecewise_function(engine):
    """A stop that follows a schedule: f(x - g(t)), the breakpoint moves."""
    stop = interpolated_pieces("stop", [0.0, 2.0, 4.0], [1.0, 3.0, 1.0], "linear")
    gap = Pieces("contact", (0.0,), ((0, 0, 0, 0), (0, 1, 0, 0)))
    system = System((x, y), (sp.S.One, PiecewiseCubic(x - PiecewiseCubic(TIME, stop), gap)))
    trajectory = run(system, [-1.0, 0.0], 6.0, 61, engine=engine)
    t = trajectory.time  # the gap -2 until t = 2, then 2 t - 6 until t = 4, then t - 2
    middle, late = np.clip(t, 3, 4), np.maximum(t, 4)
    exact = (middle - 3) ** 2 + ((late - 2) ** 2 - 4) / 2
    assert trajectory.states[1] == pytest.approx(exact, abs=1e-12)


@each_alone_and_on_lanes
def test_breakpoints_of_a_parameter(engine):
    """The argument may hold parameters: one compiled flow, the breakpoint elsewhere."""
    system = System((x,), (PiecewiseCubic(TIME - c, HEAVISIDE),), (c,))
    for at in (-1.0, 0.0, 0.5, 1.0, 7.0):
        trajectory = run(system, [0.0], 2.0, 9, parameters=[at], engine=engine)
        assert trajectory.states[0] == pytest.approx(np.clip(trajectory.time - at, 0, trajectory.time), abs=1e-13)


def test_an_action_that_carries_an_argument_over_breakpoints(engine):
    """At t = 1 the state is thrown from the first triangle into the fourth, and later back."""
    throw = Event("throw", TIME - 1, +1, action=lambda _t, s, p: (s + np.array([3.25, 0.0]), p))
    back = Event("back", TIME - 2, +1, action=lambda _t, s, p: (s - np.array([5.0, 0.0]), p))
    system = System((a, y), (sp.S.One, PiecewiseCubic(a, TRIANGLES)))
    trajectory = run(system, [0.25, 0.0], 3.0, 4, events=(throw, back), engine=engine)
    first = (1 - 0.25**2) / 2 + (1 - 0.75**2) / 2  # from 0.25 to 1.25
    second = third = (1 - 0.5**2) / 2 + (1 - 0.5**2) / 2  # from 4.5 to 5.5, and from 0.5 to 1.5
    assert trajectory.states[1, -1] == pytest.approx(first + second + third, abs=1e-12)
    assert [h.name for h in trajectory.hits] == ["throw", "back"]  # breakpoints are no hits


def test_a_quadrature_gains_where_its_function_jumps(engine):
    """work = integral of x dp + the jumps of p x: with x = t and p = 2 from t = 1, 5 from t = 3 the work is 2 + 9."""
    p = PiecewiseCubic(TIME, interpolated_pieces("p", [0.0, 1.0, 3.0], [0.0, 2.0, 5.0], "steps"))
    work = Output("work", sp.diff(p, TIME) * x, jump=p * x)
    system = System((x,), (sp.S.One,), quadratures=(work,))
    for samples in (2, 5, 41):
        trajectory = run(system, [0.0], 4.0, samples, engine=engine)
        exact = np.where(trajectory.time >= 1, 2.0, 0.0) + np.where(trajectory.time >= 3, 9.0, 0.0)
        assert trajectory.quadratures["work"] == pytest.approx(exact, abs=1e-12)  # at the breakpoint itself: from the right


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
def test_a_jump_is_the_same_in_any_unit(unit):
    p = PiecewiseCubic(TIME, step("p", 1.0, 0.0, 2.0))
    system = System((x,), (sp.S.One,), quadratures=(Output("work", sp.S.Zero, jump=p * x), Output("other", x)))
    trajectory = run(system, [0.0], 4.0, 2, unit=unit)
    assert trajectory.quadratures["work"][-1] == pytest.approx(2.0, abs=1e-12)
    assert trajectory.quadratures["other"][-1] == pytest.approx(8.0, abs=1e-11)


def test_two_jumps_at_one_time():
    """p and q step together: the gain is that of both, once."""
    p, q = PiecewiseCubic(TIME, step("p", 1.0, 0.0, 2.0)), PiecewiseCubic(TIME, step("q", 1.0, 3.0, 4.0))
    system = System((x,), (sp.S.One,), quadratures=(Output("work", sp.S.Zero, jump=p * q * x),))
    assert run(system, [0.0], 4.0).quadratures["work"][-1] == pytest.approx(8.0, abs=1e-12)
    r = PiecewiseCubic(x, step("r", 1.0, 3.0, 4.0))  # another argument that reaches its breakpoint at the same time
    system = System((x,), (sp.S.One,), quadratures=(Output("work", sp.S.Zero, jump=p * r * x),))
    assert run(system, [0.0], 4.0).quadratures["work"][-1] == pytest.approx(8.0, abs=1e-12)


@pytest.mark.parametrize("pause", [1.0, math.pi / 2, math.pi / 2 + 1e-12, 3.0])
def test_a_run_is_resumed_anywhere(pause):
    """At a breakpoint, just after it, and elsewhere; with a step of time and a kink of the state."""
    force = PiecewiseCubic(TIME, step("F", 3.0, 0.0, 0.5))
    system = System((x, v), (v, -PiecewiseCubic(x, BILINEAR) + force), quadratures=(Output("q", force, jump=force * x),))
    whole = run(system, [0.0, 1.0], 10.0)
    first = run(system, [0.0, 1.0], pause)
    second = run(system, first.end_state, 10.0, begin=first.end_time)
    assert second.states[:, -1] == pytest.approx(whole.states[:, -1], abs=1e-11)
    if pause != 3.0:  # at the jump itself the first run may or may not have gained it; below the two are compared together
        assert second.quadratures["q"][-1] == pytest.approx(whole.quadratures["q"][-1], abs=1e-11)


def test_a_jump_at_the_end_of_a_leg_is_gained_once():
    """A run that is paused exactly at a step, and continued, gains the jump once."""
    p = PiecewiseCubic(TIME, step("p", 1.0, 0.0, 2.0))
    system = System((x,), (sp.S.One,), quadratures=(Output("work", sp.S.Zero, jump=p * x),))
    first = run(system, [0.0], 1.0, 11)
    second = run(system, first.end_state, 4.0, begin=1.0)
    assert second.quadratures["work"][-1] == pytest.approx(2.0, abs=1e-12)


def test_paused_and_continued_to_the_last_bit(engine):
    system = System((x, v), (v, -PiecewiseCubic(x, BILINEAR) + PiecewiseCubic(TIME, TRIANGLES)))
    flow, grid = compile_system(system, 1e-9, engine=engine), np.linspace(0, 12, 3000)
    whole = integrate(flow, [0.3, 1.0], [], grid)
    part = integrate(flow, [0.3, 1.0], [], grid[:1025])
    while len(part.time) < len(grid):
        last = len(part.time) - 1
        part = part.join(integrate(flow, part.end_state, [], grid[last : last + 1025]))
    assert np.array_equal(whole.states, part.states)


@pytest.mark.parametrize("restitution", [1.0, 0.8, 0.3])
def test_a_bouncing_ball(restitution):
    """On a linear spring and damper, under gravity, until the bounces are too small to leave the ground: no crossing may be
    forgotten, however soon the ball comes back. Energy and what the damper took stay the sum they were."""
    k, g = 1e6, 10.0
    bounce = math.log(restitution)
    zeta = -bounce / math.hypot(math.pi, bounce)
    on = PiecewiseCubic(x, step("contact", 0.0, 1.0, 0.0))
    damping = 2 * zeta * math.sqrt(k)
    lost = Output("lost", on * damping * v**2)
    system = System((x, v), (v, -g - on * (k * x + damping * v)), quadratures=(lost,))
    trajectory = run(system, [0.05, 0.0], 1.0, 500)
    x_, v_ = trajectory.states
    energy = v_**2 / 2 + g * x_ + np.where(x_ < 0, k * x_**2 / 2, 0.0)
    assert energy + trajectory.quadratures["lost"] == pytest.approx(0.5, abs=1e-10)
    assert x_.min() > -1.1e-3  # v/omega of the spring, 1 m/s by 1000 rad/s, and the weight
    if restitution == 0.3:
        assert x_[-1] == pytest.approx(-g / k, abs=1e-12)


def test_what_never_changes_is_no_event():
    """An event of parameters alone never happens, and does no harm beside others."""
    flat, late = Event("flat", c - 1, action=lambda _t, s, p: (s, p)), Event("late", TIME - c, +1, terminal=True)
    trajectory = run(System((x,), (sp.S.One,), (c, d)), [0.0], 5.0, 6, parameters=[2.0, 3.0], events=(flat, late))
    assert trajectory.stopped_by == "late"
    assert trajectory.end_time == pytest.approx(2.0, abs=1e-12)


def _switch_on(place):
    def action(_time, state, parameters):
        parameters[place] = 1.0
        return state, parameters

    return action


@pytest.mark.parametrize("at", [0.3, 1 / 3, 0.7, 2.0, math.pi, 4.999])
def test_two_actions_at_the_same_time(engine, at):
    """Two bodies are released at one instant, where a step comes as well: an integrator reports one, all three happen, once."""
    count = sp.Symbol("count", real=True)
    events = tuple(Event(n, TIME / at - 1, +1, action=_switch_on(k)) for k, n in enumerate(("one", "two")))
    thrown = Event("thrown", TIME - at, action=lambda _t, s, p: (s + np.array([0.0, 0.0, 1.0]), p))
    later = PiecewiseCubic(TIME, step("H", at, 0.0, 1.0))
    system = System((x, y, count), (c + 0 * x, d * later, sp.S.Zero), (c, d))
    for grid in ([0.0, 6.0], [0.0, at, 6.0], np.linspace(0, 6, 2001)):  # the second ends a leg there
        trajectory = integrate(
            compile_system(system, events=(*events, thrown), engine=engine), [0, 0, 0], [0, 0], np.array(grid)
        )
        assert trajectory.states[:, -1] == pytest.approx([6 - at, 6 - at, 1.0], abs=1e-10)
        assert sorted(h.name for h in trajectory.hits) == ["one", "thrown", "two"]


@pytest.mark.parametrize("at", [0.3, 1 / 3, 0.7])
def test_an_action_at_the_end_of_a_run_that_is_continued(at):
    """It happens in the first run or in the second; what it changed is handed over in the parameters."""
    system = System((x,), (c + 0 * x,), (c,))
    flow = compile_system(system, events=(Event("one", TIME / at - 1, +1, action=_switch_on(0)),))
    first = integrate(flow, [0.0], [0.0], np.linspace(0, at, 7))
    second = integrate(flow, first.end_state, first.final_parameter_values, np.array([first.end_time, 2.0]))
    assert second.states[0, -1] == pytest.approx(2.0 - at, abs=1e-11)


@each_alone_and_on_lanes
@pytest.mark.parametrize("apart", [1e-6, 1e-8, 5e-9])
def test_breakpoints_hardly_apart(engine, apart):
    """A hundred steps up and down that are passed within less than a microsecond."""
    heights = np.tile([0.0, 1.0], 50)
    system = System((x,), (PiecewiseCubic(TIME, interpolated_pieces("s", 1 + apart * np.arange(100), heights, "steps")),))
    trajectory = run(system, [0.0], 2.0, 3, engine=engine)
    assert trajectory.states[0, -1] == pytest.approx(49 * apart + 1 - 99 * apart, abs=1e-11)


@each_alone_and_on_lanes
@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
@pytest.mark.parametrize("reach", [0.1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_an_argument_that_turns_back_once_at_its_breakpoint_goes_beyond(engine, reach, tolerance):
    """x = 1 + s^3 - reach^2 s, s = t - 2.7: up through the breakpoint 1, down and up again, ever slower the nearer these are;
    y' = slope 1 below the breakpoint, 100 above it."""
    kink, s = Pieces("k", (1.0,), ((0, 1, 0, 0), (0, 100, 0, 0))), TIME - sp.Rational(27, 10)
    system = System((x, y), (3 * s**2 - a**2, PiecewiseCubic(x, kink)), (a,))
    initial = [1 - 2.7**3 + 2.7 * reach**2, 0.0]
    trajectory = run(system, initial, 5.7, 3, parameters=[reach], tolerance=tolerance, engine=engine)
    area = np.array([u**4 / 4 - reach**2 * u**2 / 2 for u in (-2.7, -reach, 0.0, reach, 3.0)])
    exact = np.diff(area) @ [1, 100, 1, 100]
    missed = 99 * reach**4 / 4  # three changes of sign within a part of a step count as one
    assert trajectory.states[1, -1] == pytest.approx(exact, abs=5e-11 + 1.1 * missed)


@each_alone_and_on_lanes
def test_rates_may_be_infinite_on_the_segments_where_a_run_does_not_begin(engine):
    """x' = 1/max(|x|, 1) from -1/2: on its first segment, continued, max(|x|, 1) is 1 - (x + 1), and zero at x = 0."""
    largest = Pieces("max", (-1.0, 1.0), ((1, -1, 0, 0), (1, 0, 0, 0), (1, 1, 0, 0)))
    system = System((x,), (1 / PiecewiseCubic(x, largest),))
    for start in (0.0, -0.5):
        trajectory = run(system, [start], 1.0 - start + 1.5, engine=engine)
        assert trajectory.states[0, -1] == pytest.approx(2.0, rel=1e-11)  # to 1 within 1 - start, then x^2 = 1 + 2 t


def test_a_segment_costs_the_same_however_many_there_are() -> None:
    """Each of 20,000 breakpoints is passed once: work at each that grows with their number took half a minute."""
    times = np.arange(20_000.0)
    pieces = interpolated_pieces("f", times, np.sin(times), "linear")
    segmentation = Segmentation.of(0, TIME, [pieces])
    begun = time.process_time()
    rows = [segmentation.segment(i, at) for i, at in enumerate(times + 0.5, 1)]
    assert time.process_time() - begun < 5
    low, high, *_, origin, value, slope = rows[77]
    assert (low, high, origin) == (77.0, 78.0, 77.0)
    assert (value, slope) == pytest.approx((np.sin(77.0), np.sin(78.0) - np.sin(77.0)))


TWO_TABLES = Segmentation.of(
    3,
    x,
    [Pieces("f", (1.0, 3.0), ((5.0, 0, 0, 0), (0, 2, 0, 0), (7, 0, 1, 0))), Pieces("g", (2.0,), ((1, 0, 0, 0), (0, 4, 0, 0)))],
)


def test_the_values_of_a_segment_are_those_of_its_pieces():
    """Its ends, whether it has them, and each function's polynomial there, from its origin."""
    assert TWO_TABLES.breakpoints.tolist() == [1.0, 2.0, 3.0] and TWO_TABLES.scale == 3.0
    f, g = TWO_TABLES.functions
    for i, (low, high) in enumerate([(0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 0.0)]):
        values = TWO_TABLES.segment(i)
        assert values[:4] == [low, high, float(i > 0), float(i < 3)]
        numbers = dict(zip(TWO_TABLES.symbols, values, strict=True))
        inside = low + 0.25 if i else 0.25
        found = [float(p.xreplace(numbers | {x: inside})) for p in TWO_TABLES.polynomials()]
        assert found == pytest.approx([float(f(inside)), float(g(inside))])
        above, below = (float(e.xreplace(numbers | {x: inside})) for e in TWO_TABLES.end_functions())
        assert above == pytest.approx((inside - high) / 3 if i < 3 else -1.0)
        assert below == pytest.approx((inside - low) / 3 if i else 1.0)


def test_the_ends_of_a_segment_lie_beyond_an_argument_on_them():
    """By 2e-15 of the largest number; others stay where they are."""
    low, high, *_ = TWO_TABLES.segment(1, 1.0)
    assert low == 1.0 - 6e-15 and high == 2.0
    low, high, *_ = TWO_TABLES.segment(1, 2.0, 1000.0)
    assert low == 1.0 and high == 2.0 + 2e-12
    assert TWO_TABLES.segment(1, 1.5)[:2] == [1.0, 2.0] and TWO_TABLES.segment(0, 1.0)[:2] == [0.0, 1.0 + 6e-15]


def test_the_segment_of_an_argument_on_a_breakpoint_is_that_to_which_it_moves():
    """Within a thousand roundings of the largest number, or of the time; where it rests that on the right."""
    near, up, down = 1000 * np.finfo(float).eps, 2.0 + 1e-9, 2.0 - 1e-9
    for value, ahead, size, segment in (
        (0.5, 0.6, 1.0, 0), (1.5, 1.4, 1.0, 1), (9.0, 9.0, 1.0, 3), (2.0, 2.1, 1.0, 2), (2.0, 1.9, 1.0, 1), (2.0, 2.0, 1.0, 2),
        (2.0 - 2.9 * near, up, 1.0, 2), (2.0 - 3.1 * near, up, 1.0, 1), (2.0 + 2.9 * near, down, 1.0, 1),
        (2.0 + 3.1 * near, down, 1.0, 2), (2.0 - 9.0 * near, up, 10.0, 2), (2.0 - 2.9 * near, 2.0 - 2.9 * near, 1.0, 1),
        (2.0 - 9.0 * near, 2.0 + 1e-8, 1.0, 2),
    ):  # fmt: skip
        assert TWO_TABLES.locate(value, ahead, size) == segment


def test_hundreds_of_events_and_breakpoints_in_one_leg() -> None:
    """A triangular wave between 0 and 1 passes 1/2 in the middle of each of its 400 segments."""
    slopes = np.tile([1.0, -1.0], 200)
    wave = PiecewiseCubic(TIME, interpolated_pieces("wave", np.arange(400.0), slopes, "steps"))
    flow = compile_system(System((x,), (wave,)), 1e-9, (Event("half", x - sp.Rational(1, 2)),))
    run = integrate(flow, [0.0], [], np.linspace(0.0, 400.0, 401))
    assert run.failure is None
    assert [h.time for h in run.hits] == pytest.approx(np.arange(400) + 0.5, abs=1e-9)
    assert run.states[0] == pytest.approx(np.arange(401) % 2, abs=1e-9)


def test_two_hundred_contacts_within_a_leg() -> None:
    """A ball between two elastic walls: it flies at constant speed, and is in contact for pi/omega: its period is known."""
    v = sp.Symbol("v", real=True)
    stiffness, gap = 1e6, 1.0
    wall = Pieces("walls", (0.0, gap), ((0, -stiffness, 0, 0), (0, 0, 0, 0), (0, -stiffness, 0, 0)))
    flow = compile_system(System((x, v), (v, PiecewiseCubic(x, wall))), 1e-12)
    speed, omega = 2.0, math.sqrt(stiffness)
    period = 2 * (gap / speed + math.pi / omega)
    run = integrate(flow, [gap / 2, speed], [], period * np.arange(101))
    assert run.failure is None
    # Each contact changes the speed by 3e-12, an error of three steps at this tolerance, always of one sign; 200 of them.
    assert run.states[1] == pytest.approx(np.full(101, speed), abs=1e-9)
    assert run.states[0] == pytest.approx(np.full(101, gap / 2), abs=6e-8)
    assert run.lowest_arguments is not None


@on_all
@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_chain_of_steps_that_depend_on_one_another_jumps_at_once(engine, count):
    """1 from t = 1 on, a step of this at 1/2, a step of that one: the last is 1 from t = 1 on too, its integral 2 at t = 3."""
    rate = PiecewiseCubic(TIME, step("first", 1.0, 0.0, 1.0))
    for k in range(1, count):
        rate = PiecewiseCubic(rate, step(f"step {k}", 0.5, 0.0, 1.0))
    assert run(System((x,), (rate,)), [0.0], 3.0, engine=engine).states[0, -1] == pytest.approx(2.0, abs=1e-11)


@each_alone_and_on_lanes
def test_a_fast_schedule_before_a_long_rest_stands_not_still(engine):
    """1000 points in 0.1 s, then a value of 1 for 1e6 s, without a sample between."""
    values = np.tile([0.0, 1.0], 500)
    rate = PiecewiseCubic(TIME, interpolated_pieces("burst", np.arange(1000) * 1e-4, values, "linear"))
    trajectory = run(System((x,), (rate,)), [0.0], 1e6, engine=engine)
    assert trajectory.states[0, -1] == pytest.approx(0.5 * 0.0999 + (1e6 - 0.0999), abs=1e-5)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("speed", [0.1, 0.37, 1.0, 1.9])
def test_the_deepest_compression_of_a_contact(tolerance, speed):
    """A mass meets a spring of 100 rad/s: by the conservation of energy it is compressed by speed / 100, between two steps."""
    contact = PiecewiseCubic(x, Pieces("contact", (0.0,), ((0, -1e4, 0, 0), (0, 0, 0, 0))))
    trajectory = run(System((x, v), (v, contact)), [1.0, -speed], 1.2 / speed, tolerance=tolerance)
    assert trajectory.lowest_arguments == pytest.approx([-speed / 100], rel=10 * tolerance)


def test_an_argument_that_ceases_to_be_finite_ends_the_run_there():
    """The root of a schedule that is 1 until t = 2, then -1."""
    schedule = PiecewiseCubic(TIME, interpolated_pieces("schedule", [0, 1, 2], [1, 1, -1], "steps"))
    system = System((x,), (PiecewiseCubic(sp.sqrt(schedule), step("H", 0.5, 0.0, 1.0)),))
    trajectory = integrate(compile_system(system), [0.0], {}, np.linspace(0.0, 3.0, 301))
    assert "ceases to be finite" in str(trajectory.failure)
    assert trajectory.time[-1] == pytest.approx(2.0, abs=0.011)


@each_alone_and_on_lanes
@pytest.mark.parametrize("turns", [187, 202.09, 234.4015, 373, 378])
def test_a_first_step_does_not_pass_whole_turns(engine, turns):
    """An angle of constant speed from 10^5 turns on, and a load that acts for half of each turn: steps follow no wave."""
    angle, speed = sp.symbols("angle speed", real=True)
    load = PiecewiseCubic(sp.sin(angle - sp.Rational(1, 3)), step("load", 0.0, 0.0, 1.0))
    for angles in (frozenset(), frozenset((angle,))):
        system = System((angle, x), (speed, load), (speed,), angles=angles)
        trajectory = run(system, [2e5 * math.pi, 0.0], 1.0, parameters=[2 * math.pi * turns], tolerance=1e-9, engine=engine)
        part = turns - 1 / (6 * math.pi)  # of the load's turns that are done; it acts in the first half of each
        half = (math.floor(part) + min(2 * (part % 1), 1)) / 2 / turns
        assert trajectory.states[1, -1] == pytest.approx(half, abs=1e-8)
