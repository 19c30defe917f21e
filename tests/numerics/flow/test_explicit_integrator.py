"""The explicit integrator: its order, its numbers to the last bit, what is kept on disk, and the code as Python runs it."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.system import TIME, System

x, v, k = sp.symbols("x v k", real=True)
SPRING = System((x, v), (v, -k * x), (k,))


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 0, 3, 1)])
@pytest.mark.parametrize("turned", [0.0, 1e6])
def test_rounding_of_large_angles_does_not_stop_a_run(turned: float, order: tuple[int, ...]) -> None:
    """Two discs that have turned by many radians, with a stiff spring between them: gap 1e-3 cos(omega t), omega = 2 k^(1/2).

    The rounding of the angles, 4e-12 of 3e4, times k of 1e6 is more than the tolerance allows in any but tiny steps.
    """
    a, b, va, vb = sp.symbols("a b va vb", real=True)
    rates = {a: va, b: vb, va: 2 * k * (b - a), vb: 2 * k * (a - b)}
    states = [tuple(rates)[i] for i in order]
    discs = System(tuple(states), tuple(rates[x] for x in states), (k,), angles=frozenset((a, b)))
    start, grid = {a: turned, b: turned + 1e-3, va: 50.0, vb: 50.0}, np.linspace(0.0, 0.5, 513)
    run = integrate(compile_system(discs, 1e-12), [start[x] for x in states], [1e6], grid)
    assert run.failure is None and run.end_time == 0.5
    at = {x: run.states[i] for i, x in enumerate(states)}
    gap = at[b] - at[a]
    assert np.abs(gap - gap[0] * np.cos(2e3 * grid)).max() < 1e-9 + 1e3 * np.spacing(turned)
    assert np.abs((at[va] + at[vb]) / 2 - 50.0).max() < 1e-9


@pytest.mark.parametrize("tolerance", [1e-9])
def test_the_same_run_has_the_same_bits(tolerance: float) -> None:
    """Twice, and in parts that end where legs do."""
    flow, grid = compile_system(SPRING, tolerance), np.linspace(0.0, 50.0, 2049)
    once, again = (integrate(flow, [1.0, 0.0], [2.0], grid) for _ in range(2))
    assert np.array_equal(once.states, again.states)
    first = integrate(flow, [1.0, 0.0], [2.0], grid[:1025])
    second = integrate(flow, first.end_state, [2.0], grid[1024:])
    assert np.array_equal(first.join(second).states, once.states)


def test_more_events_in_a_leg_than_there_was_room_for() -> None:
    """Two thousand zeros between two samples."""
    flow = compile_system(SPRING, events=(Event("zero", x),))
    run = integrate(flow, [0.0, 1.0], [1.0], np.array([0.0, 2000.5 * np.pi]))
    assert [h.time for h in run.hits][-2000:] == pytest.approx(np.pi * np.arange(1, 2001), abs=1e-8)


def test_an_event_function_that_dips_below_zero_within_a_part_of_a_step() -> None:
    """t^2 - d^2 has the same sign at both ends of every step but one that ends between -d and d."""
    clock = System((x,), (sp.S.One,))
    for depth in (0.3, 0.1, 0.01):
        flow = compile_system(clock, events=(Event("edge", TIME**2 - sp.Float(depth) ** 2),))
        run = integrate(flow, [0.0], [], np.array([-3.0, 3.0]))
        assert [h.time for h in run.hits] == pytest.approx([-depth, depth], abs=1e-12)


@pytest.mark.parametrize("size", [1.0, 1e9])
def test_sines_and_cosines_are_those_of_the_library(size: float) -> None:
    code = compile_system(System((x, v), (sp.sin(x), sp.cos(x)))).engine.code
    for angle in np.random.default_rng(7).uniform(-size, size, 500):
        sine, cosine = code.rates(np.array([angle, 0.0]), 0.0, np.empty(0))
        assert (sine, cosine) == pytest.approx((np.sin(angle), np.cos(angle)), abs=2.5e-16)


CHILD = """
import sys
from time import perf_counter
import sympy as sp
from wucht.numerics.flow.compiled import machine_code
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import System
compiled, compile_object = [], machine_code.compiled_object
def compiled_object(*arguments):
    compiled.append(arguments[1])
    return compile_object(*arguments)
machine_code.compiled_object = compiled_object
x, v, k = sp.symbols("x v k", real=True)
run = integrate(compile_system(System((x, v), (v, -k * x), (k,))), [1.0, 0.0], [1.0], [0.0, 1.0])
print(len(compiled), run.states[:, -1].tobytes().hex(), "numba" in sys.modules)
"""


def test_a_second_process_compiles_nothing_and_gives_the_same_bits(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path))

    def child() -> list[str]:
        return subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=True).stdout.split()

    first, second = child(), child()
    assert (first[0], second[0]) == ("2", "0")
    assert first[1:] == second[1:]
    for path in tmp_path.rglob("*_file-*"):  # damaged files are not loaded
        path.write_bytes(path.read_bytes()[:-1] + b"x")
    assert child() == first
