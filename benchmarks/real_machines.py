"""Machines with contacts, inverters, schedules and tables: processor time of the integration, and starts a second.

The drum with twelve touching balls and an inverter over 30 s at 1e-9, beside a program in C++ for this machine alone (Dormand
and Prince's method of order 5, the same contacts, located the same way), which took 0.13 s at contacts of 339 rad/s and 0.39 s
at 2513 rad/s where these benchmarks were written. The others over 3 s, 16 starts of each, one after the other.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

_CPP = {339.3: 0.13, 2513.0: 0.39}  # s, of the program in C++
_NAMES = ("practice/laundry-drum", "practice/fan-ball-ring", "practice/fan-on-belt", "practice/grinder-10-balls")
_UNTIL, _STARTS = 3.0, 16


def drum(contact_frequency: float, balls: int = 12) -> Machine:
    """A drum with 3 kg of laundry on one side and a ring of balls, run up by an inverter."""
    return machine_from(
        {
            "carrier": {
                "mass": "45 kg", "directions": "xy", "frequency": ["2.3 Hz", "2.7 Hz"], "damping_ratio": 0.15,
                "gravity": "9.81 m/s^2",
            },
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": "15 kg", "unbalance": "0.72 kg m", "inertia": "0.75 kg m^2"},
                {
                    "kind": "roller", "name": "b", "count": balls, "about": "drum", "mass": "0.3 kg", "track_radius": "0.26 m",
                    "radius": "21 mm", "shape_factor": 0.4, "damping": "0.05 N m s", "track": "ring",
                },
            ],
            "drive": {
                "on": "drum", "kind": "inverter", "set_speed": "1200 rpm", "gain": "3 N m s", "integral_time": "0.5 s",
                "torque_limit": "15 N m", "power_limit": "700 W",
            },
            "loads": [{"on": "drum", "kind": "quadratic", "coefficient": "1.2e-4 N m s^2"}],
            "schedules": [{"parameter": "drive.set_speed", "points": [["0 s", "0 rpm"], ["15 s", "1200 rpm"]]}],
            "tracks": {"ring": {"contact_frequency": contact_frequency}},
        }
    )  # fmt: skip


def measure() -> Iterator[tuple[str, str]]:
    for frequency, cpp in _CPP.items():
        machine = drum(frequency)
        seconds = processor_time(_runs(machine, {"drum": 0.0}, 30.0, 1))
        yield f"drum, contacts of {frequency:g} rad/s, 30 s; times the program in C++", f"{seconds:.2f} s {seconds / cpp:6.2f}"
    for name in _NAMES:
        seconds = processor_time(_runs(load_machine(name), {}, _UNTIL, _STARTS))
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


def processor_time(job: Callable[[], None]) -> float:
    """Seconds that do not depend on what else the computer does, after a first time."""
    job()
    begun = time.process_time()
    job()
    return time.process_time() - begun
