"""Motions on the lanes of vectors: each as if it were alone, to the last bit, whatever becomes of those beside it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow import step_sizes
from wucht.numerics.flow.compiled import lanes_stepper, leg_memory
from wucht.numerics.flow.compiled.dormand_prince import NODES, ROW_BEGINS, ROW_STAGES, ROW_WEIGHTS
from wucht.numerics.flow.compiled.lane_memory import LanesMemory
from wucht.numerics.flow.compiled_batch import WIDTH, CompiledBatch, LanesResult, Quantities, compile_batch
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Program
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated_pieces
from wucht.system import TIME, System

x, v, w, d, q = sp.symbols("x v w d q", real=True)
# A forced oscillator; with q it runs away.
FORCED = System((x, v), (v, -(w**2) * x - 2 * d * v + sp.cos(2 * TIME) + q * x**2), (w, d, q))
# The same between stops, under a force that follows a schedule.
_STOPS = Pieces("stops", (-0.2, 0.3), ((-1.0, 5.0, 0, 0), (0, 0, 0, 0), (1.5, 50.0, 0, 0)))
_FORCE = interpolated_pieces("force", [3.5, 6.0, 6.25, 20.0], [1.0, 2.0, -1.0, 0.0], "linear")
STOPPED = System(
    (x, v), (v, -(w**2) * x - 2 * d * v + PiecewiseCubic(TIME, _FORCE) - PiecewiseCubic(x, _STOPS) + q * x**2), (w, d, q)
)
TIMES = np.linspace(3.0, 13.0, 6)
each_system = pytest.mark.parametrize("system", [FORCED, STOPPED], ids=["smooth", "piecewise"])
TOLERANCE = 1e-12


def advance(
    starts: np.ndarray,
    parameters: np.ndarray,
    times: np.ndarray = TIMES,
    system: System = FORCED,
    quantities: Quantities | None = None,
) -> LanesResult:
    batch = compile_batch(system, TOLERANCE, quantities)
    constants = np.array([batch.constant_values(p) for p in parameters]).reshape(len(parameters), -1).T
    integrator = batch.acquire()
    result = integrator.advance(starts.T, constants, times)
    batch.release(integrator)
    return result


def drawn(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Starts (M, 2) and parameters (M, 3), none of which runs away."""
    rng = np.random.default_rng(seed)
    parameters = np.column_stack([rng.uniform(0.5, 1.5, count), rng.uniform(0.05, 0.3, count), np.zeros(count)])
    return rng.uniform(-1, 1, (count, 2)), parameters


def closed_form(start: np.ndarray, frequency: float, damping: float, times: np.ndarray) -> np.ndarray:
    """x (K,) of the forced oscillator: the forced motion, and a decaying one from what the start leaves."""
    response = 1 / (frequency**2 - 4 + 4j * damping)  # x = Re(response exp(2 i t))
    root = -damping + 1j * np.sqrt(frequency**2 - damping**2)
    left = start - [(response * f * np.exp(2j * times[0])).real for f in (1, 2j)]
    amplitude = left[0] - 1j * (left[1] - root.real * left[0]) / root.imag  # Re a = x, Re(a root) = v
    free = (amplitude * np.exp(root * (times - times[0]))).real
    return free + (response * np.exp(2j * times)).real


def test_the_closed_form_with_parameters_and_starts_of_each() -> None:
    starts, parameters = drawn(21)
    result = advance(starts, parameters)
    exact = np.array([closed_form(s, p[0], p[1], TIMES) for s, p in zip(starts, parameters, strict=True)]).T
    assert result.values.shape == (5, 2, 21)
    assert np.abs(result.values[:, 0] - exact[1:]).max() < 1e-11
    assert np.array_equal(result.states, result.values[-1])
    assert not result.failures


@pytest.mark.parametrize(("system", "apart"), [(FORCED, 1e-11), (STOPPED, 1e-10)], ids=["smooth", "piecewise"])
def test_a_single_run_at_the_same_tolerance(system: System, apart: float) -> None:
    """The state at a breakpoint is interpolated, which is of lower order than the steps."""
    starts, parameters = drawn(9)
    result = advance(starts, parameters, system=system)
    compiled = compile_system(system, TOLERANCE, engine="compiled")
    for lane in range(9):
        alone = integrate(compiled, starts[lane], parameters[lane], TIMES)
        assert np.abs(result.values[:, :, lane].T - alone.states[:, 1:]).max() < apart * np.abs(alone.states).max(initial=1.0)


@each_system
def test_each_lane_is_as_if_alone(system: System) -> None:
    """Bits: alone, in any order, in two parts; a chunk is a function of its beginning."""
    starts, parameters = drawn(19)
    whole = advance(starts, parameters, system=system)
    order = np.random.default_rng(2).permutation(19)
    mixed = advance(starts[order], parameters[order], system=system)
    assert np.array_equal(mixed.values, whole.values[:, :, order])
    assert np.array_equal(mixed.states, whole.states[:, order])
    for lane in (0, 7, 18):
        alone = advance(starts[lane : lane + 1], parameters[lane : lane + 1], system=system)
        assert np.array_equal(alone.values[:, :, 0], whole.values[:, :, lane])


@each_system
@pytest.mark.parametrize("runaways", [[4], [0, 3, 9], [8, 9, 10], list(range(8)), [10]])
def test_a_lane_that_runs_away_does_not_touch_the_others(runaways: list[int], system: System) -> None:
    starts, parameters = drawn(11)
    clean, spoilt, times = advance(starts, parameters, system=system), parameters.copy(), TIMES
    spoilt[runaways, 2] = [100.0 + i for i in range(len(runaways))]  # at times of their own
    starts[runaways] = [3.0, 0.0]
    result, others = advance(starts, spoilt, system=system), np.setdiff1d(np.arange(11), runaways)
    assert sorted(result.failures) == runaways
    assert np.array_equal(result.values[:, :, others], clean.values[:, :, others])
    assert np.array_equal(result.states[:, others], clean.states[:, others])
    for lane, error in result.failures.items():
        assert times[0] < result.times[lane] < times[1]
        assert "ceases to be finite" in str(error)


def test_where_a_state_runs_away_and_what_was_sampled_before() -> None:
    """x' = x^2 from x(0) = 1/2 is 1/(2 - t)."""
    system = System((x,), (q * x**2,), (q,))
    times = np.linspace(0.0, 4.2, 8)
    result = advance(np.array([[0.5], [-0.5]]), np.array([[1.0], [1.0]]), times, system)
    assert list(result.failures) == [0]
    assert result.times[0] == pytest.approx(2.0, abs=1e-6)
    assert result.sample_times[0] == times[3] and result.states[0, 0] == pytest.approx(1 / (2 - times[3]), rel=1e-9)
    assert result.values[:, 0, 1] == pytest.approx(-1 / (2 + times[1:]), rel=1e-11)


def test_a_stiff_lane_runs_out_of_steps_alone() -> None:
    system = System((x,), (-q * x,), (q,))
    starts, rates = np.ones((10, 1)), np.linspace(0.5, 1.5, 10)[:, None]
    clean = advance(starts, rates, np.array([0.0, 5.0, 10.0]), system)
    rates[3] = 1e7
    result = advance(starts, rates, np.array([0.0, 5.0, 10.0]), system)
    assert list(result.failures) == [3]
    assert "500000 steps were not enough" in str(result.failures[3])
    assert 0 < result.times[3] < 5
    others = np.arange(10) != 3
    assert np.array_equal(result.values[:, :, others], clean.values[:, :, others])


def test_equations_without_parameters() -> None:
    system = System((x, v), (v, -x))
    result = advance(np.array([[1.0, 0.0], [0.0, 1.0]]), np.empty((2, 0)), np.linspace(0, 6, 7), system)
    assert np.abs(result.values[:, 0] - np.array([np.cos(np.arange(1, 7)), np.sin(np.arange(1, 7))]).T).max() < 1e-11


def test_integrators_are_lent_and_leave_nothing_behind() -> None:
    """Threads at once have the bits of one; an integrator that has failed is as good as new."""
    starts, parameters = drawn(16)
    first = advance(starts, parameters)
    bad = parameters.copy()
    bad[::2, 2] = 9.0
    assert advance(starts + 3.0, bad).failures
    together = threading.Barrier(3)

    def begin(_: int) -> LanesResult:
        together.wait(30)
        return advance(starts, parameters)

    with ThreadPoolExecutor(3) as pool:
        assert all(np.array_equal(r.values, first.values) for r in pool.map(begin, range(3)))
    integrators = [compile_batch(FORCED, TOLERANCE).acquire() for _ in range(2)]
    assert integrators[0] is not integrators[1]
    compile_batch(FORCED, TOLERANCE).release(integrators[0])
    assert compile_batch(FORCED, TOLERANCE).acquire() is integrators[0]


def test_work_can_be_given_up_between_rounds() -> None:
    """A motion of a million steps is stopped after a few thousand."""
    calls, batch = [], compile_batch(FORCED, TOLERANCE)

    def check() -> None:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt

    starts, parameters = drawn(5)
    constants = np.array([batch.constant_values(p) for p in parameters]).T
    integrator = batch.acquire()
    with pytest.raises(KeyboardInterrupt):
        integrator.advance(starts.T, constants, np.array([0.0, 1e6]), check)
    assert len(calls) == 3
    again = integrator.advance(starts.T, constants, TIMES)
    assert np.array_equal(again.values, advance(starts, parameters).values)


def test_quantities_are_those_of_the_states() -> None:
    starts, parameters = drawn(2 * WIDTH + 3)
    states = advance(starts, parameters).values
    observed = advance(starts, parameters, quantities=Quantities((x * v + w, sp.sin(TIME) * d), (x, -x)))
    assert observed.values[:, 0] == pytest.approx(states[:, 0] * states[:, 1] + parameters[:, 0], abs=1e-13)
    assert observed.values[:, 1] == pytest.approx(np.sin(TIMES[1:, None]) * parameters[:, 1], abs=1e-15)
    assert np.array_equal(observed.states, advance(starts, parameters).states)


def test_functions_of_the_c_library_on_lanes() -> None:
    """Which has none for vectors: on each lane its own argument."""
    functions = (sp.tan, sp.exp, sp.log, sp.sinh, sp.cosh, sp.tanh, sp.atan, sp.asin, sp.acos, sp.sqrt)
    system = System((x, v), (sp.S.Zero, sp.S.Zero))
    starts = np.random.default_rng(6).uniform(0.1, 0.9, (2 * WIDTH, 2))
    quantities = Quantities((*(f(x) for f in functions), sp.atan2(x, v), x**v, 1 / sp.sqrt(v), x**-3))
    values = advance(starts, np.empty((len(starts), 0)), np.array([0.0, 1.0]), system, quantities).values[0]
    a, b = starts.T
    names = ("tan", "exp", "log", "sinh", "cosh", "tanh", "arctan", "arcsin", "arccos", "sqrt")
    expected = [*(getattr(np, name)(a) for name in names), np.arctan2(a, b), a**b, b**-0.5, a**-3.0]
    assert values == pytest.approx(np.array(expected), rel=1e-14)


@pytest.mark.parametrize("turns", [0.0, 3.0, -1e3, 1e6])
def test_sines_of_many_turns_on_lanes(turns: float) -> None:
    """To the rounding of the argument."""
    angles = 2 * np.pi * turns + np.linspace(-4.0, 4.0, 64)
    system = System((x,), (sp.S.Zero,))
    quantities = Quantities((sp.sin(x), sp.cos(x)))
    values = advance(angles[:, None], np.empty((64, 0)), np.array([0.0, 1.0]), system, quantities).values[0]
    assert np.abs(values - [np.sin(angles), np.cos(angles)]).max() < 3e-16


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_largest_values_lie_between_samples_and_steps(tolerance: float) -> None:
    """Against 20,000 samples of each: to 1e-3 of the height, of a quantity with twice the frequency of the motion."""
    starts, parameters = drawn(60, seed=4)
    square, times = (x + sp.Rational(1, 10)) ** 2 + v**2 / 50, np.array([0.0, 0.7, 30.0])
    batch = compile_batch(FORCED, tolerance, Quantities((x, v), (square,)))
    constants = np.array([batch.constant_values(p) for p in parameters]).T
    peaks = batch.acquire().advance(starts.T, constants, times).peaks[0]
    dense = advance(starts, parameters, np.linspace(0.0, 30.0, 20_001)).values
    everything = np.concatenate([starts.T[None], dense])
    expected = ((everything[:, 0] + 0.1) ** 2 + everything[:, 1] ** 2 / 50).max(axis=0)
    assert np.abs(peaks / expected - 1).max() < 1e-3
    assert (peaks < expected * (1 + 1e-4)).all()


def test_motions_are_continued_with_their_progress() -> None:
    """The largest values are those of the whole, and the steps go on as long as they were."""
    starts, parameters = drawn(40, seed=5)
    batch = compile_batch(FORCED, 1e-9, Quantities((x, v), (x**2, -v)))
    constants = np.array([batch.constant_values(p) for p in parameters]).T
    whole = batch.acquire().advance(starts.T, constants, TIMES)
    first = batch.acquire().advance(starts.T, constants, TIMES[:3])
    assert (first.progress[0] > 0.05).all() and (first.peaks <= whole.peaks + 1e-9).all()
    second = batch.acquire().advance(first.states, constants, TIMES[2:], progress=first.progress)
    assert second.values == pytest.approx(whole.values[2:], abs=1e-7) and second.peaks == pytest.approx(whole.peaks, abs=1e-3)
    assert (second.peaks >= first.peaks).all() and (second.peaks[0] > first.peaks[0]).any()


@pytest.mark.parametrize("spacing", [0.02, 0.3, 0.45, 1.0, 3.0])
def test_samples_within_steps_and_at_their_ends(spacing: float) -> None:
    """Of times that are nearer to each other than steps (of half a unit of time) and farther: by closed form."""
    starts, parameters = drawn(20, seed=7)
    times = 3.0 + spacing * np.arange(25)
    values = advance(starts, parameters, times).values[:, 0]
    expected = [closed_form(s, *p[:2], times)[1:] for s, p in zip(starts, parameters, strict=True)]
    assert values == pytest.approx(np.array(expected).T, abs=1e-9)


def test_the_beginning_counts_among_the_largest_values() -> None:
    decay = System((x,), (-w * x,), (w,))
    rates = np.linspace(0.5, 1.5, 40)[:, None]
    result = advance(np.ones((40, 1)), rates, np.array([0.0, 1.0]), decay, Quantities((x,), (x, -x)))
    assert result.peaks[0].tolist() == [1.0] * 40
    assert result.peaks[1] == pytest.approx(-np.exp(-rates[:, 0]), rel=1e-9)


def test_the_largest_value_beside_a_breakpoint() -> None:
    """x' = 1 until t = 1/2, then -3: the largest value is 1/2, where none of the pieces has one."""
    rate = PiecewiseCubic(TIME, interpolated_pieces("rate", [0.0, 0.5], [1.0, -3.0], "steps"))
    for times in (np.array([0.0, 1.0]), np.linspace(0.0, 1.0, 18)):
        result = advance(np.zeros((3, 1)), np.zeros((3, 0)), times, System((x,), (rate,)), Quantities((x,), (x, 10 - x)))
        assert result.peaks[0] == pytest.approx([0.5] * 3, abs=1e-12)
        assert result.peaks[1] == pytest.approx([11.0] * 3, abs=1e-12)
        assert result.states[0] == pytest.approx([-1.0] * 3, abs=1e-12)


@pytest.mark.parametrize("samples", [2, 50])
def test_a_quantity_is_largest_just_after_its_jump(samples: int) -> None:
    """x = exp(w (1 - t)), observed from t = 1 on, where it is 1: then it falls, a little or by far."""
    switched_on = PiecewiseCubic(TIME, interpolated_pieces("on", [0.0, 1.0], [0.0, 1.0], "steps"))
    rates, decay = np.linspace(0.1, 300.0, 20)[:, None], System((x,), (-w * x,), (w,))
    observed = Quantities((x,), (switched_on * x,))
    result = advance(np.exp(rates), rates, np.linspace(0.0, 3.0, samples), decay, observed)
    assert result.peaks[0] == pytest.approx(np.ones(20), rel=1e-9)


def test_python_runs_the_same_stepper() -> None:
    """Interpreted, on NumPy's arrays, it takes the steps of the compiled one: its numbers differ by rounding."""
    count = WIDTH + 2
    starts, parameters = drawn(count)
    system, quantities = System((x, v), (v, -(w**2) * x - 2 * d * v), (w, d, q)), Quantities((x, v), (x**2,))
    compiled = advance(starts, parameters, system=system, quantities=quantities)
    batch = CompiledBatch(system, TOLERANCE, quantities)
    memory = interpreted(batch, starts, parameters)
    assert lanes_stepper.advance_lanes(memory, leg_memory.LegMemory(*[0] * len(leg_memory.LegMemory._fields))) == 0
    assert memory.endings.tolist() == [leg_memory.END] * len(starts)
    assert memory.samples.reshape(compiled.values.shape) == pytest.approx(compiled.values, abs=1e-13)
    assert memory.states.reshape(compiled.states.shape) == pytest.approx(compiled.states, abs=1e-13)
    assert memory.progress[count:] == pytest.approx(
        compiled.peaks[0], rel=1e-8
    )  # their places are differences of nearly equal numbers


def interpreted(batch: CompiledBatch, starts: np.ndarray, parameters: np.ndarray) -> LanesMemory:
    """The memory of the stepper, with functions of Python."""
    count, n = starts.shape
    counts = [len(program.constants) for program in batch.programs]
    functions = dict(zip(("rates", "samplers", "peak_quantities"), map(on_lanes, batch.programs), strict=True))
    numbers = {
        "width": WIDTH, "n": n, "rate_constant_count": counts[0], "sampler_constant_count": counts[1],
        "peak_constant_count": counts[2], "event_count": 0, "event_constant_count": 0, "instant_constant_count": 0,
        "value_count": 2, "peak_count": 1, "peak_state_count": len(batch.peak_states),
        "member_count": count, "grid_count": len(TIMES), "rounds": 10_000,
        "most_steps": step_sizes.MAX_STEPS, "tolerance": TOLERANCE,
    }  # fmt: skip
    constants = np.array([batch.constant_values(p) for p in parameters]).T
    arrays = {
        "peak_states": batch.peak_states, "is_angle": np.zeros(n), "constants": constants.ravel(), "nodes": NODES,
        "row_weights": ROW_WEIGHTS, "row_places": ROW_STAGES * n, "row_begins": ROW_BEGINS,
        "grid": TIMES, "states": starts.T.ravel(),
        "samples": np.zeros((len(TIMES) - 1) * 2 * count), "progress": batch.begin(count).ravel(), "times": np.zeros(count),
        "sample_times": np.zeros(count), "endings": np.zeros(count, int),
        "counts": np.array([lanes_stepper.NONE_BEGUN, 0, 0]),
        **{name: np.zeros(WIDTH, int) for name in ("members", "rows", "queue_members", "queue_rows")},
    }  # fmt: skip
    rest = set(LanesMemory._fields) - set(functions) - set(numbers) - set(arrays)
    return LanesMemory(**functions, **numbers, **arrays, **{name: np.zeros((64, WIDTH)) for name in rest})


def on_lanes(program: Program) -> Callable[..., np.ndarray]:
    """A program as a function of times (1, W), states and constants; it returns vectors."""
    function = program.function()

    def values(time: np.ndarray, state: np.ndarray, constants: np.ndarray) -> np.ndarray:
        states = tuple(state[: len(program.states)])
        results = function(states, time[0], tuple(constants[: len(program.constants)]))
        return np.array([np.broadcast_to(r, time[0].shape) for r in results])

    return values
