"""Run-up of R1 over 20 s (320 turns): compiled flow against SciPy DOP853 on a NumPy right-hand side, at equal achieved error.

The error is the largest deviation over 401 samples from a reference (heyoka at the smallest tolerance), relative to the largest
value of each state. Each engine runs at the loosest of its tolerances with which it achieves 1e-9.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.integrate import solve_ivp
from tests.reference_integrators import taylor_states

from benchmarks.timing import processor_time
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import System

TARGET = 1e-9
UNTIL = 20.0
GRID = np.linspace(0, UNTIL, 401)


def numpy_right_hand_side(values: dict[str, float]) -> Callable[[float, np.ndarray], np.ndarray]:
    """(4.1)-(4.5) of 002 as one would write them in NumPy: pendulums as arrays, bodies eliminated before the carrier."""
    arms = [values["drum.eccentricity"], values["p1.length"], values["p2.length"]]
    unbalance = np.array([values["drum.mass"], values["p1.mass"], values["p2.mass"]]) * arms
    inertia = np.array([values["drum.inertia"], values["p1.inertia"], values["p2.inertia"]])
    mass = values["carrier.mass"] + values["drum.mass"] + values["p1.mass"] + values["p2.mass"]
    b = np.array([values["p1.damping"], values["p2.damping"]])
    c, d = values["carrier.stiffness"], values["carrier.damping"]
    slope, no_load = values["drive.slope"], values["drive.no_load_speed"]

    def right_hand_side(_t: float, y: np.ndarray) -> np.ndarray:
        position, angles, velocity, speeds = y[:2], y[2:5], y[5:7], y[7:]
        relative = b * (speeds[1:] - speeds[0])
        torque = np.concatenate([[slope * (no_load - speeds[0]) + relative.sum()], -relative])
        radial = unbalance * np.array([np.cos(angles), np.sin(angles)])
        tangential = np.array([-radial[1], radial[0]])
        reduced = mass * np.eye(2) - (tangential / inertia) @ tangential.T
        force = radial @ speeds**2 - c * position - d * velocity - tangential @ (torque / inertia)
        acceleration = np.linalg.solve(reduced, force)
        return np.concatenate([velocity, speeds, acceleration, (torque - acceleration @ tangential) / inertia])

    return right_hand_side


def measure() -> Iterator[tuple[str, str]]:
    machine = load_machine("drozdetskaya-2020/r1")
    bare = System(**{f: getattr(machine.system, f) for f in ("states", "derivatives", "parameters", "definitions")})
    initial = initial_state(machine, {"p1": 0.3, "p2": -0.5})
    reference = taylor_states(bare, initial, machine.values, GRID, 1e-17)
    scale = np.abs(reference).max(axis=1, keepdims=True)

    def error(states: np.ndarray) -> float:
        return float((np.abs(states - reference) / scale).max())

    right = numpy_right_hand_side(machine.values)
    peer = _loosest(
        lambda tolerance: lambda: solve_ivp(right, (0, UNTIL), initial, "DOP853", GRID, rtol=tolerance, atol=tolerance).y,
        (1e-8, 1e-9, 1e-10, 1e-11, 1e-12), error,
    )  # fmt: skip
    flows = {t: compile_system(bare, t) for t in (1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)}
    own = _loosest(lambda t: lambda: integrate(flows[t], initial, machine.values, GRID).states, tuple(flows), error)
    yield f"SciPy DOP853, NumPy: tolerance {peer[0]:g}, achieved {peer[1]:.1e}", f"{peer[2]:8.3f} s"
    yield f"wucht: tolerance {own[0]:g}, achieved {own[1]:.1e}", f"{1e3 * own[2]:8.3f} ms"
    yield "ratio (asked: at least 100)", f"{peer[2] / own[2]:8.0f}"
    full = compile_system(machine.system)
    default = processor_time(lambda: integrate(full, initial, machine.values, GRID).states)
    yield "wucht with energy balance at its default tolerance, ratio to SciPy above", f"{peer[2] / default:8.0f}"


def _loosest(
    make: Callable[[float], Callable[[], np.ndarray]], tolerances: tuple[float, ...], error: Callable[[np.ndarray], float]
) -> tuple[float, float, float]:
    for tolerance in tolerances:
        job = make(tolerance)
        achieved = error(job())
        if achieved <= TARGET:
            return tolerance, achieved, processor_time(job)
    raise SystemExit(f"none of the tolerances {tolerances} achieves {TARGET}")
