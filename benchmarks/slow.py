"""Averaged equations: built and compiled for a rotor with six pendulums (asked: 0.1 s and 2 s); a run of R1, slow against full.

The runs go over 20 s (320 turns) with 401 samples at the default tolerance, without works. Asked: without the inertia of the
pendulums at least 10 times faster than the full equations, with it 1.5 times.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace

from benchmarks.run_up import GRID
from benchmarks.timing import processor_time
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import System

_SCRIPT = """
import time
import sympy
from wucht.files.building import machine_from
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.numerics.flow.compiled_system import compile_system
pendulum = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "damping": 0.1}
def machine(n):
    return machine_from({
        "carrier": {"stiffness": [1e5, 2e5], "damping": [200.0, 300.0]},
        "bodies": [{"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.03}]
        + [pendulum | {"name": f"p{i}"} for i in range(n)],
        "drive": {"on": "drum", "kind": "linear", "slope": 0.02, "no_load_speed": 200.0},
    })
averaged_equations_of(machine(1)).system  # SymPy's own start
six = machine(6)
a = time.perf_counter(); six.linear_carrier
b = time.perf_counter(); slow = averaged_equations_of(six).system
c = time.perf_counter(); compile_system(slow)
d = time.perf_counter(); print(b - a, c - b, d - c)
"""
_MOVED = {"drum": 0.0, "p1": 0.3, "p2": -0.5}


def measure() -> Iterator[tuple[str, str]]:
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"XDG_CACHE_HOME": cache, "WUCHT_CACHE_DIR": cache}
        out = subprocess.run([sys.executable, "-c", _SCRIPT], capture_output=True, text=True, check=True, env=environment)
    read, build, compile_ = map(float, out.stdout.split())
    yield "six pendulums, directions that differ: M, C, K and couplings off the energies", f"{read:8.3f} s"
    yield "the averaged equations built from them", f"{build:8.3f} s"
    yield "compiled, nothing cached", f"{compile_:8.3f} s"
    machine = load_machine("drozdetskaya-2020/r1")
    begin, values = initial_state(machine, {"p1": 0.3, "p2": -0.5}), machine.system.values(machine.values)
    full = processor_time(_run(machine.system, begin, values))
    yield "R1 over 320 turns, full equations", f"{1e3 * full:8.3f} ms"
    labels = {
        False: "averaged equations without the pendulums' inertia, times faster",
        True: "averaged equations with the pendulums' inertia, times faster",
    }
    for inertia, label in labels.items():
        averaged_equations = averaged_equations_of(machine, inertia)
        start = averaged_equations.state(_MOVED, dict.fromkeys(_MOVED, 0.0))
        yield label, f"{full / processor_time(_run(averaged_equations.system, start, averaged_equations.values())):8.1f}"


def _run(system: System, start: object, values: tuple[float, ...]) -> object:
    flow = compile_system(replace(system, quadratures=(), outputs=()))
    return lambda: integrate(flow, start, values, GRID)
