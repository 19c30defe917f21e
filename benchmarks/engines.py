"""The engine against heyoka's Taylor series and SciPy's DOP853: processor time of a motion, compiled before, and its error.

Error: the largest deviation of 401 samples from heyoka's motion at 1e-17, relative to the largest value of each state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from tests.reference_integrators import rates_of, taylor_equations, taylor_states

from benchmarks.timing import processor_time
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import System

_MOTIONS = {
    "R1, 80 turns": ("drozdetskaya-2020/r1", {"p1": 0.3, "p2": -0.5}, 5.0),
    "laboratory centrifuge, 1 s": ("practice/laboratory-centrifuge", {}, 1.0),
    "exciter with two pendulums, 1 s": ("practice/exciter-two-pendulums", {}, 1.0),
    "screen, 2 s": ("practice/screen", {}, 2.0),
}


def measure() -> Iterator[tuple[str, str]]:
    for label, (name, start, until) in _MOTIONS.items():
        machine, grid = load_machine(name), np.linspace(0.0, until, 401)
        system, initial = replace(machine.system, quadratures=(), outputs=()), initial_state(machine, start)
        exact = taylor_states(system, initial, machine.values, grid, 1e-17)
        scale = np.abs(exact).max(axis=1, keepdims=True)
        for tolerance in (1e-6, 1e-12):
            jobs = _jobs(system, initial, machine.values, grid, tolerance)
            errors = ", ".join(f"{engine} {float((np.abs(job() - exact) / scale).max()):.1e}" for engine, job in jobs.items())
            times = {engine: processor_time(job, 1 if engine == "SciPy" else 5) for engine, job in jobs.items()}
            ratios = " : ".join(f"{seconds / times['heyoka']:.2f}" for seconds in times.values())
            yield f"{label}, {tolerance:g}: errors {errors}; processor time", ratios


def _jobs(
    system: System, initial: np.ndarray, values: dict[str, float], grid: np.ndarray, tolerance: float
) -> dict[str, Callable[[], np.ndarray]]:
    """The same motion, states (n, N), by each engine."""
    import heyoka as hy

    flow, rates = compile_system(system, tolerance), rates_of(system, values)
    taylor = hy.taylor_adaptive(taylor_equations(system, values), initial.tolist(), tol=tolerance)
    allowed: dict[str, Any] = {"rtol": tolerance, "atol": 1e-2 * tolerance}

    def by_taylor() -> np.ndarray:
        taylor.time, taylor.state[:] = grid[0], initial
        return np.asarray(taylor.propagate_grid(grid)[-1]).T

    return {
        "compiled": lambda: integrate(flow, initial, values, grid).states,
        "heyoka": by_taylor,
        "SciPy": lambda: np.asarray(solve_ivp(rates, grid[[0, -1]], initial, "DOP853", grid, **allowed).y),
    }
