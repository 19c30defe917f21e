"""Motions on the lanes of a register: each as if it were alone, to the last bit, whatever becomes of those beside it."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.heyoka_batch import HeyokaBatch, LanesResult, compile_batch
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import lower
from wucht.system import TIME, System

pytest.importorskip("heyoka")

x, v, w, d, q = sp.symbols("x v w d q", real=True)
# A forced oscillator; with q it runs away.
FORCED = System((x, v), (v, -(w**2) * x - 2 * d * v + sp.cos(2 * TIME) + q * x**2), (w, d, q))
TIMES = np.linspace(3.0, 13.0, 6)
TOLERANCE = 1e-12


def batch_of(system: System, tolerance: float = TOLERANCE) -> HeyokaBatch:
    return compile_batch(system, tolerance)


def advance(starts: np.ndarray, parameters: np.ndarray, times: np.ndarray = TIMES, system: System = FORCED) -> LanesResult:
    program, integrator = lower(system, system.derivatives), batch_of(system).lend()
    constants = np.array([program.constant_values(p) for p in parameters]).reshape(len(parameters), -1).T
    result = integrator.advance(starts.T, constants, times)
    batch_of(system).give_back(integrator)
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
    assert result.samples.shape == (5, 2, 21)
    assert np.abs(result.samples[:, 0] - exact[1:]).max() < 1e-11
    assert np.abs(result.states - result.samples[-1]).max() < 1e-12  # the end is sampled off the last step's polynomial
    assert not result.failures


def test_the_scalar_integrator_at_the_same_tolerance() -> None:
    starts, parameters = drawn(9)
    result = advance(starts, parameters)
    compiled = compile_system(FORCED, TOLERANCE, engine="heyoka")
    for lane in range(9):
        alone = integrate(compiled, starts[lane], parameters[lane], TIMES)
        assert np.abs(result.samples[:, :, lane].T - alone.states[:, 1:]).max() < 1e-11


def test_each_lane_is_as_if_alone() -> None:
    """Bits: alone, in any order, in two parts; a chunk is a function of its beginning."""
    starts, parameters = drawn(19)
    whole = advance(starts, parameters)
    order = np.random.default_rng(2).permutation(19)
    mixed = advance(starts[order], parameters[order])
    assert np.array_equal(mixed.samples, whole.samples[:, :, order])
    assert np.array_equal(mixed.states, whole.states[:, order])
    for lane in (0, 7, 18):
        alone = advance(starts[lane : lane + 1], parameters[lane : lane + 1])
        assert np.array_equal(alone.samples[:, :, 0], whole.samples[:, :, lane])


@pytest.mark.parametrize("runaways", [[4], [0, 3, 9], [8, 9, 10], list(range(8)), [10]])
def test_a_lane_that_runs_away_does_not_touch_the_others(runaways: list[int]) -> None:
    starts, parameters = drawn(11)
    clean, spoilt, times = advance(starts, parameters), parameters.copy(), TIMES
    spoilt[runaways, 2] = [5.0 + i for i in range(len(runaways))]  # at times of their own
    starts[runaways] = [3.0, 0.0]
    result, others = advance(starts, spoilt), np.setdiff1d(np.arange(11), runaways)
    assert sorted(result.failures) == runaways
    assert np.array_equal(result.samples[:, :, others], clean.samples[:, :, others])
    assert np.array_equal(result.states[:, others], clean.states[:, others])
    for failure in result.failures.values():
        assert times[0] < failure.time < times[1]
        assert failure.error.samples.shape == (2, 0)
        assert "ceases to be finite" in str(failure.error)


def test_where_a_state_runs_away_and_what_was_sampled_before() -> None:
    """x' = x^2 from x(0) = 1/2 is 1/(2 - t)."""
    system = System((x,), (q * x**2,), (q,))
    times = np.linspace(0.0, 4.2, 8)
    result = advance(np.array([[0.5], [-0.5]]), np.array([[1.0], [1.0]]), times, system)
    failure = result.failures[0]
    assert failure.time == pytest.approx(2.0, abs=1e-6)
    assert failure.error.samples[0] == pytest.approx(1 / (2 - times[1:4]), rel=1e-9)
    assert result.samples[:, 0, 1] == pytest.approx(-1 / (2 + times[1:]), rel=1e-11)


def test_a_stiff_lane_runs_out_of_steps_alone() -> None:
    system = System((x,), (-q * x,), (q,))
    starts, rates = np.ones((10, 1)), np.linspace(0.5, 1.5, 10)[:, None]
    clean = advance(starts, rates, np.array([0.0, 5.0, 10.0]), system)
    rates[3] = 1e7
    result = advance(starts, rates, np.array([0.0, 5.0, 10.0]), system)
    assert list(result.failures) == [3]
    assert "500000 steps were not enough" in str(result.failures[3].error)
    assert 0 < result.failures[3].time < 5
    others = np.arange(10) != 3
    assert np.array_equal(result.samples[:, :, others], clean.samples[:, :, others])


def test_equations_without_parameters() -> None:
    system = System((x, v), (v, -x))
    result = advance(np.array([[1.0, 0.0], [0.0, 1.0]]), np.empty((2, 0)), np.linspace(0, 6, 7), system)
    assert np.abs(result.samples[:, 0] - np.array([np.cos(np.arange(1, 7)), np.sin(np.arange(1, 7))]).T).max() < 1e-11


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
        assert all(np.array_equal(r.samples, first.samples) for r in pool.map(begin, range(3)))
    lent = [batch_of(FORCED).lend() for _ in range(2)]
    assert lent[0] is not lent[1]
    batch_of(FORCED).give_back(lent[0])
    assert batch_of(FORCED).lend() is lent[0]


def test_work_can_be_given_up_between_batches() -> None:
    starts, parameters = drawn(40)
    calls = []

    def check() -> None:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt

    program, integrator = lower(FORCED, FORCED.derivatives), batch_of(FORCED).lend()
    constants = np.array([program.constant_values(p) for p in parameters]).T
    with pytest.raises(KeyboardInterrupt):
        integrator.advance(starts.T, constants, TIMES, check)
    assert len(calls) == 3
