"""Machines with contacts, inverters, schedules and tables: processor time of the integration, and starts a second.

The drum with twelve touching balls and an inverter over 30 s at 1e-9, beside a program in C++ for this machine alone (Dormand
and Prince's method of order 5, the same contacts, located the same way), which took 0.13 s at contacts of 339 rad/s and 0.39 s
at 2513 rad/s where these benchmarks were written. The others over 3 s, 16 starts of each, one after the other.

Ensembles: 64 starts on the lanes of vectors beside the same starts one after the other; what the second thread gains; the rate
of a drum with pendulums whose drive follows a schedule and whose load is a table, beside that of the same machine with smooth
laws; and of the drum with twelve balls, 64 starts to their verdicts on all processors.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from tests.validation.test_ball_drum import DRUM

from benchmarks.timing import processor_time
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.ensembles.ensemble import compile_ensemble, run_ensemble
from wucht.numerics.ensembles.members import Chunk, Members, Pace
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

_CPP = {339.3: 0.13, 2513.0: 0.39}  # s, of the program in C++
_NAMES = (
    "practice/laundry-drum",
    "practice/screen-loaded",
    "practice/fan-ball-ring",
    "practice/fan-on-belt",
    "practice/grinder-10-balls",
)
_UNTIL, _STARTS, _MEMBERS = 3.0, 16, 64
_DRUM = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.03, "bearing_damping": 1e-4}
_PENDULUM = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "damping": 0.169}
_SMOOTH: dict[str, Any] = {
    "carrier": {"mass": 9.0, "stiffness": 1e5, "damping": 200.0, "directions": "xy"},
    "bodies": [_DRUM, *(_PENDULUM | {"name": name} for name in ("p1", "p2"))],
    "drive": {"on": "drum", "kind": "linear", "slope": 0.05, "no_load_speed": 200.0},
}
_PIECES = {
    "load": {"kind": "table", "points": [[float(w), 1e-4 * float(w)] for w in np.linspace(-50.0, 250.0, 13)]},
    "schedules": [
        {"parameter": "drive.no_load_speed", "points": [[0.5 * k, 40.0 + 8.0 * k + 2.0 * (k % 2)] for k in range(21)]}
    ],
}


def measure() -> Iterator[tuple[str, str]]:
    for frequency, cpp in _CPP.items():
        machine = machine_from(DRUM | {"tracks": {"ring": {"contact_frequency": frequency}}})
        seconds = processor_time(_runs(machine, {"drum": 0.0}, 30.0, 1), 2)
        yield (
            f"drum beside the program in C++, contacts of {frequency:g} rad/s, 30 s; times it",
            f"{seconds:.2f} s {seconds / cpp:6.2f}",
        )
    for name in _NAMES:
        seconds = processor_time(_runs(load_machine(name), {}, _UNTIL, _STARTS), 2)
        yield f"{name}, {_UNTIL:g} s; starts a second", f"{seconds / _STARTS:.3f} s {_STARTS / seconds:6.0f}"
    for name in _NAMES:
        machine = load_machine(name)
        alone = processor_time(_runs(machine, {}, _UNTIL, _STARTS), 1) / _STARTS
        one, two = (min(_ensemble_seconds(machine, _UNTIL, threads) for _ in range(3)) / _MEMBERS for threads in (1, 2))
        gains = f"{1 / one:5.0f} {alone / one:6.2f} {one / two:6.2f}"
        yield f"{name}, on lanes: starts a second, times one by one, second thread", gains
    smooth, pieces = (min(_ensemble_seconds(machine_from(m), 10.0, 1) for _ in range(3)) for m in (_SMOOTH, _SMOOTH | _PIECES))
    yield "schedule and table on lanes; times the rate of smooth laws", f"{smooth / pieces:6.2f}"
    for frequency in _CPP:
        machine = machine_from(DRUM | {"tracks": {"ring": {"contact_frequency": frequency}}})
        question, starts = EnsembleQuestion(machine, until=30.0), _starts(machine, {"drum": 0.0}, _MEMBERS)
        outcomes_of(question, starts[:, :1], {})  # compiled
        begin = time.perf_counter()
        outcomes_of(question, starts, {})
        seconds = time.perf_counter() - begin
        yield f"starts of the drum to the verdict a second, contacts of {frequency:g} rad/s, 30 s", f"{_MEMBERS / seconds:6.1f}"


@dataclass(frozen=True)
class _Nothing:
    """A record of members without content."""

    members: np.ndarray


class _Ends:
    """An observer that observes nothing."""

    def begin(self, members: Members) -> _Nothing:
        return _Nothing(np.zeros(len(members)))

    def update(self, record: _Nothing, chunk: Chunk) -> tuple[_Nothing, np.ndarray]:
        return record, np.zeros(len(record.members), bool)

    def final_record(self, record: _Nothing) -> _Nothing:
        return record


def _ensemble_seconds(machine: Machine, until: float, threads: int) -> float:
    """Time that the members of an ensemble take, compiled before."""
    system = replace(machine.system, outputs=(), quadratures=())
    ensemble = compile_ensemble(system, 1e-9)
    starts, values = _starts(machine, {}, _MEMBERS), np.array(system.values(machine.values))
    members = Members.of(np.ascontiguousarray(starts.T), np.tile(values, (_MEMBERS, 1)))
    ensemble.release(ensemble.acquire())
    begin = time.perf_counter()
    run_ensemble(ensemble, members, _Ends(), Pace(until, round(20 * until), until), threads)
    return time.perf_counter() - begin


def _starts(machine: Machine, start: dict[str, float], count: int) -> np.ndarray:
    """Starts (n, count) from positions of the carrier that differ by a micrometre."""
    starts = np.repeat(initial_state(machine, start)[:, None], count, axis=1)
    starts[0] += 1e-6 * np.arange(count)
    return starts


def _runs(machine: Machine, start: dict[str, float], until: float, count: int) -> Callable[[], None]:
    """So many runs."""
    flow, grid = compile_system(machine.system, 1e-9), np.linspace(0.0, until, round(200 * until) + 1)
    starts = _starts(machine, start, count)

    def job() -> None:
        for state in starts.T:
            run = integrate(flow, state, machine.values, grid)
            assert run.failure is None, run.failure

    return job
