"""Machines with contacts, inverters, schedules and tables: processor time of the integration, and starts a second.

The drum with twelve touching balls and an inverter over 30 s at 1e-9, beside a program in C++ for this machine alone (Dormand
and Prince's method of order 5, the same contacts, located the same way), which took 0.13 s at contacts of 339 rad/s and 0.39 s
at 2513 rad/s where these benchmarks were written. The others over 3 s, 16 starts of each, one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from tests.validation.test_ball_drum import DRUM

from benchmarks.engines import processor_time
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

_CPP = {339.3: 0.13, 2513.0: 0.39}  # s, of the program in C++
_NAMES = ("practice/laundry-drum", "practice/fan-ball-ring", "practice/fan-on-belt", "practice/grinder-10-balls")
_UNTIL, _STARTS = 3.0, 16


def measure() -> Iterator[tuple[str, str]]:
    for frequency, cpp in _CPP.items():
        machine = machine_from(DRUM | {"tracks": {"ring": {"contact_frequency": frequency}}})
        seconds = processor_time(_runs(machine, {"drum": 0.0}, 30.0, 1), 2)
        yield f"drum, contacts of {frequency:g} rad/s, 30 s; times the program in C++", f"{seconds:.2f} s {seconds / cpp:6.2f}"
    for name in _NAMES:
        seconds = processor_time(_runs(load_machine(name), {}, _UNTIL, _STARTS), 2)
        yield f"{name}, {_UNTIL:g} s; starts a second", f"{seconds / _STARTS:.3f} s {_STARTS / seconds:6.0f}"


def _runs(machine: Machine, start: dict[str, float], until: float, count: int) -> Callable[[], None]:
    """So many runs, from positions of the carrier that differ by a micrometre."""
    flow, grid = compile_system(machine.system, 1e-9), np.linspace(0.0, until, round(200 * until) + 1)
    initial = initial_state(machine, start)

    def job() -> None:
        for k in range(count):
            state = initial.copy()
            state[0] += 1e-6 * k
            run = integrate(flow, state, machine.values, grid)
            assert run.failure is None, run.failure

    return job
