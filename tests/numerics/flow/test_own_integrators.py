"""What is compiled is shared; what runs belongs to one run: threads, runs within runs, and Systems in turn do not touch."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.piecewise import PiecewiseCubic, interpolated_pieces
from wucht.system import TIME, Output, System

x, v, k = sp.symbols("x v k", real=True)
SPRING = System((x, v), (v, -k * x), (k,), quadratures=(Output("work", v**2),))
DRIVEN = System((x, v), (v, PiecewiseCubic(TIME, interpolated_pieces("ramp", [1.0, 4.0], [0.0, 2.0], "linear")) - k * x), (k,))
GRID = np.linspace(0.0, 12.0, 1201)
PASSING, ACTING = Event("middle", x, +1), Event("kick", x - 0.5, +1, action=lambda t, y, p: (y * [1.0, 1.01], p))


def run(system: System, engine: str, stiffness: float, events: tuple[Event, ...] = (), **keys: object) -> Trajectory:
    return integrate(compile_system(system, 1e-6, events, engine), [1.0, 0.0], [stiffness], GRID, **keys)


def same(a: Trajectory, b: Trajectory) -> bool:
    hits = [(h.name, h.time, h.state.tolist()) for h in a.hits] == [(h.name, h.time, h.state.tolist()) for h in b.hits]
    return hits and np.array_equal(a.states, b.states) and a.failure is b.failure is None


@pytest.mark.slow
def test_many_threads_at_once(engine: str) -> None:
    """Each thread gets the numbers to the last bit that it gets alone, whatever the others integrate meanwhile."""
    stiffnesses = [0.5 + 0.25 * i for i in range(4)]
    alone = [run(SPRING, engine, s, (PASSING, ACTING)) for s in stiffnesses]
    together = threading.Barrier(4)

    def begin(s: float) -> Trajectory:
        together.wait(30)
        return run(SPRING, engine, s, (PASSING, ACTING))

    with ThreadPoolExecutor(4) as pool:
        trajectories = list(pool.map(begin, stiffnesses))
    assert all(map(same, trajectories, alone))
    assert not any(same(a, b) for a, b in pairwise(trajectories))


@pytest.mark.slow
def test_a_run_within_a_run(engine: str) -> None:
    """A callback of progress that integrates the same compiled System with other values does not touch the outer run."""
    outer, inner = run(DRIVEN, engine, 1.0, (PASSING,)), run(DRIVEN, engine, 3.0, (PASSING,))
    nested: list[Trajectory] = []
    trajectory = run(DRIVEN, engine, 1.0, (PASSING,), progress=lambda _t: nested.append(run(DRIVEN, engine, 3.0, (PASSING,))))
    assert nested
    assert same(trajectory, outer)
    assert all(same(n, inner) for n in nested)


DIVERGING = System((x, v), (x**2, k * x), (k,))


@pytest.mark.slow
@pytest.mark.parametrize(("system", "events"), [(SPRING, (PASSING, ACTING)), (DIVERGING, ())])
def test_a_run_leaves_nothing_to_the_next(engine: str, system: System, events: tuple[Event, ...]) -> None:
    """After Ctrl-C, a state that is not finite, or an end at an event, a run has the bits of one with new integrators."""

    def once(begin: float, progress: object = None) -> Trajectory:
        compiled = compile_system(system, 1e-6, events, engine)
        return integrate(compiled, [begin, 0.0], [1.0] * len(system.parameters), GRID, progress)

    def ctrl_c(_time: float) -> None:
        raise KeyboardInterrupt

    compile_system.cache_clear()
    first = once(-1.0)
    spoilt = [once(2.0, ctrl_c), once(1.0), once(0.5), once(1e150)]
    assert spoilt[0].is_interrupted or spoilt[0].failure
    assert spoilt[3].failure or system is not DIVERGING
    for _ in range(3):
        assert same(once(-1.0), first)


def test_twice_and_paused_and_continued() -> None:
    """An inverter, a schedule, balls that touch."""
    machine = load_machine("practice/laundry-drum")
    flow = compile_system(machine.system, tolerance=1e-10)
    initial, grid = initial_state(machine, {}), np.linspace(0, 4.0, 3500)
    once, again = (integrate(flow, initial, machine.values, grid) for _ in range(2))
    assert np.array_equal(once.states, again.states)
    part = integrate(flow, initial, machine.values, grid[:1025])
    while len(part.time) < len(grid):
        last = len(part.time) - 1
        part = part.join(integrate(flow, part.end_state, machine.values, grid[last : last + 1025]))
    assert np.array_equal(once.states, part.states)
    assert np.array_equal(once.quadratures["supplied_work"], part.quadratures["supplied_work"])
