"""The same run gives the same numbers to the last bit: chaotic transients would make another run of any smaller difference."""

import numpy as np

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate


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
