"""Branches of the planar averaged equations (002 (5.17)-(5.18), corrected) against AUTO-07p's times, and SciPy in the same run.

AUTO-07p is not run: its times are those it took on two shared cores, on one thread: equilibria 120 points in 3.3 ms, fold curve
in (u, sigma) 452 points in 12.9 ms, rotating orbit from u1* to u2* 986 points (60 intervals of 4 collocation points) in 0.34 s.
How far its curves of equilibria and folds went in u is not known: there, the ratios are of the same order of work, no more.
"The same accuracy" is measured: by how much the same orbits are wrong on 60 such intervals, placed where they are best.
Times here are of the processor, the least of several, in a process of its own with one thread and empty caches.
Asked: a point of equilibria and of a fold curve below 100 us, the orbit's branch in 2.5 of AUTO's times, compiled in 1 s.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np
import sympy as sp

from wucht.analysis.planar_portraits import planar_section
from wucht.files.catalogue import load_machine
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.deflation import deflated_solutions, random_starts
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import Branch, EquilibriumContinuation
from wucht.numerics.continuation.fold_curves import Folds
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import STEPS, Cycles
from wucht.system import System

T = TypeVar("T")
Function = Callable[..., np.ndarray]

AUTO = {"equilibria": 3.3e-3, "folds": 12.9e-3, "orbits": 0.34}  # s
FOLDS = (1.8331080, 5.8710372)  # u1*, u2* where sigma = 0.1
_AT = 3.0  # u of one orbit
_LONGEST = 2e4  # period up to which the orbit is followed: within 3e-3 of both ends
_ACCURACY = 4e-7  # of the orbits that are followed
_STEPS = replace(STEPS, turn=0.5, most=1.0)  # as many points as the branch needs, not a figure
_AUTOS_MESH = 60, 4  # intervals, points of collocation in each
_FINE = 1e-11  # accuracy of the periods that others are compared with


def measure() -> Iterator[tuple[str, str]]:
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"XDG_CACHE_HOME": cache, "WUCHT_CACHE_DIR": cache, "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "benchmarks.continuation"]
        out = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout
    for line in out.splitlines():
        label, value = line.rsplit("  ", 1)
        yield label.strip(), f"{value:>9}"


def measured() -> Iterator[tuple[str, str]]:
    """In this process, whose caches are empty."""
    system, values = _planar()
    begin = time.perf_counter()
    equations = _equations(system, values, "u")
    both = _equations(system, values, "u", "sigma")
    one = time.perf_counter()
    cycles = _cycles(system, values)
    cycles.equations.values(np.ones(len(cycles.equations.scale)))
    yield "equilibria and folds: derivatives, compiled, nothing cached", f"{one - begin:.2f} s"
    yield "orbits: the same", f"{time.perf_counter() - one:.2f} s"
    yield from _of_equilibria(system, values, equations, both)
    yield from _of_orbits(system, values, cycles)


def least(function: Callable[[], T], repetitions: int) -> tuple[float, T]:
    """The least time of the processor, in seconds, and what comes out."""
    times = list[float]()
    for _ in range(repetitions):
        begin = time.process_time()
        result = function()
        times.append(time.process_time() - begin)
    return min(times), result


def _planar() -> tuple[System, Mapping[str, float]]:
    """The equations of both pendulums together, and the numbers of Table 5.1."""
    made = planar_section(load_machine("drozdetskaya-2020/table-5.1"), together=True)
    return made.system, made.values


def _equations(system: System, values: Mapping[str, float], *varied: str) -> EquilibriumEquations:
    made = EquilibriumEquations.from_system(system, varied, {name: v for name, v in values.items() if name not in varied})
    made.values(np.ones(len(made.scale)))
    return made


def _of_equilibria(
    system: System, values: Mapping[str, float], equations: EquilibriumEquations, both: EquilibriumEquations
) -> Iterator[tuple[str, str]]:
    problem = EquilibriumContinuation(equations, (0.05, 20.0))
    states = deflated_solutions(equations, [1.0], random_starts([-math.pi, 0.4], [math.pi, 2.0], 60))
    start = problem.start(states[:, states[1].argmin()], 1.0)
    taken, branch = least(lambda: problem.follow_branch(start), 100)
    (fold,) = branch.special
    points = len(branch.points)
    yield f"equilibria, u from 0.05 to the fold and back, {points} points, a point", f"{1e6 * taken / points:.0f} us"
    yield "the same branch, times AUTO's stated time", f"{taken / AUTO['equilibria']:.2f}"
    yield "its fold, relative error", f"{abs(fold.parameter / FOLDS[0] - 1):.0e}"
    functions = _lambdified(system, values)
    slow, count = least(lambda: _naive(*functions, branch), 5)
    yield f"SciPy's root per value of u up to the fold, {count} points, a point", f"{1e6 * slow / count:.0f} us"
    yield "SciPy, times ours, a point", f"{slow / count / (taken / points):.1f}"
    folds = Folds(both, [(0.1, 20.0), (1e-3, 0.5)])
    first = folds.start(fold.x, (fold.parameter, values["sigma"]))
    taken, curve = least(lambda: folds.follow_curve(first), 50)
    points = len(curve.points)
    yield f"fold curve in (u, sigma), {points} points, a point", f"{1e6 * taken / points:.0f} us"
    yield "the same curve, times AUTO's stated time", f"{taken / AUTO['folds']:.2f}"


def _naive(rates: Function, slopes: Function, branch: Branch) -> int:
    """The same values of u up to the fold, one by one, from the solution before: with SymPy's Jacobian, and eigenvalues."""
    from scipy.optimize import root

    rising = branch.unknowns[:, : branch.unknowns[-1].argmax()]
    x = rising[:-1, 0]
    for unknowns in rising[-1]:
        found = root(
            lambda x, unknowns=unknowns: rates(*x, unknowns),
            x,
            jac=lambda x, unknowns=unknowns: slopes(*x, unknowns),
            options={"xtol": 1e-10},
        )
        x = found.x
        np.linalg.eigvals(slopes(*x, unknowns))
    return rising.shape[1]


def _lambdified(system: System, values: Mapping[str, float]) -> tuple[Function, Function]:
    """f (2,) and df/dx (2, 2) of psi, speed and u, as one has them from SymPy."""
    numbers = {p: values[p.name] for p in system.parameters if p.name != "u"}
    rates = sp.Matrix([system.explicit(sp.sympify(d)).xreplace(numbers) for d in system.derivatives])
    given = (*system.states, next(p for p in system.parameters if p.name == "u"))
    f = sp.lambdify(given, list(rates), "numpy", cse=True)
    f_x = sp.lambdify(given, rates.jacobian(system.states).tolist(), "numpy", cse=True)
    return lambda *x: np.array(f(*x)), lambda *x: np.array([np.broadcast_arrays(*row) for row in f_x(*x)])


def _cycles(system: System, values: Mapping[str, float], accuracy: float = _ACCURACY) -> Cycles:
    fixed = {name: v for name, v in values.items() if name != "u"}
    bounds, periods = (1.0, 8.0), (0.0, _LONGEST)
    return Cycles.of(system, "u", fixed, bounds, winding={"psi": -1}, periods=periods, steps=_STEPS, accuracy=accuracy)


def _of_orbits(system: System, values: Mapping[str, float], cycles: Cycles) -> Iterator[tuple[str, str]]:
    times, states = _a_period(system, values)
    alone, first = least(lambda: cycle_near(cycles, times, states, _AT), 5)

    def branch() -> list[Cycle]:
        one, other = list(cycles.walk(first)), list(cycles.walk(cycles.backwards(first)))
        return [*one[::-1], first, *other]

    taken, orbits = least(branch, 5)
    yield f"rotating orbit from u1* to u2*, {len(orbits)} orbits", f"{taken:.2f} s"
    yield "the same branch, times AUTO's stated time", f"{taken / AUTO['orbits']:.2f}"
    fine = _cycles(system, values, _FINE)
    some = [c for c in orbits if not c.kind and c.period < _LONGEST / 2][:: max(1, len(orbits) // 20)]
    exact = [cycle_near(fine, c.tau * c.period, c.states, c.parameter).period for c in some]
    off = np.abs([c.period / period - 1 for c, period in zip(some, exact, strict=True)])
    yield f"relative error of the period, median of {len(some)} orbits", f"{np.median(off):.0e}"
    yield "the largest of them", f"{off.max():.0e}"
    peers = np.abs([_on_autos_mesh(system, values, c) / period - 1 for c, period in zip(some, exact, strict=True)])
    yield "the same on AUTO's mesh, median", f"{np.median(peers):.0e}"
    yield "the largest of them", f"{peers.max():.0e}"
    exact_period = cycle_near(fine, times, states, _AT).period
    wanted = max(abs(first.period / exact_period - 1), 1e-9)
    slow, error = _by_solve_bvp(system, values, times, states, exact_period, wanted)
    yield f"one orbit at u = {_AT:g} from samples, relative error {wanted:.0e}", f"{1e3 * alone:.0f} ms"
    yield f"SciPy's solve_bvp, relative error {error:.0e}, times ours", f"{slow / alone:.1f}"


def _on_autos_mesh(system: System, values: Mapping[str, float], cycle: Cycle) -> float:
    """The period of an orbit by as many intervals and points of collocation as AUTO had, where the orbit wants them."""
    intervals, degree = _AUTOS_MESH
    cycles = replace(_cycles(system, values), degree=degree)
    mesh, y = cycle.problem.mesh, cycle.states.T
    unknowns = np.empty(0)
    for _ in range(3):
        better = Mesh(mesh.adapt(y, True, intervals).edges, degree)
        problem = cycles.problem(better, cycle.period)
        unknowns = np.concatenate([mesh.interpolate(y, better.nodes).ravel(), [cycle.period, cycle.parameter]])
        problem = replace(problem, reference=problem.reference_from(unknowns))
        towards = np.zeros(len(unknowns))
        towards[-1] = 1.0
        unknowns = cycles.exactly(cycles.curve(problem)).start(unknowns, towards).unknowns
        mesh, y = better, problem.split(unknowns)[0]
    return float(unknowns[-2])


def _a_period(system: System, values: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Samples of the last period of a run."""
    run = integrate(compile_system(system, 1e-10), [0.0, 0.9], system.values({**values, "u": _AT}), np.linspace(0, 3000, 30001))
    psi = run.states[0]
    begin = int(np.flatnonzero(psi <= psi[-1] + 2 * math.pi)[0])
    i = np.linspace(begin, len(psi) - 1, 400).astype(int)
    states = run.states[:, i]
    states[0] -= 2 * math.pi * round(states[0, 0] / (2 * math.pi))
    return run.time[i] - run.time[begin], states


def _by_solve_bvp(
    system: System, values: Mapping[str, float], times: np.ndarray, states: np.ndarray, exact: float, wanted: float
) -> tuple[float, float]:
    """The time it takes at the loosest of its tolerances with which it is as accurate, and its error."""
    from scipy.integrate import solve_bvp

    rates, slopes = _lambdified(system, values)

    def f(_: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        return np.asarray(p[0] * rates(*y, _AT))

    def f_y(_: np.ndarray, y: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return p[0] * slopes(*y, _AT), rates(*y, _AT)[:, None]

    def ends(a: np.ndarray, b: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.array([b[0] - a[0] + 2 * math.pi, b[1] - a[1], a[0] - states[0, 0]])

    def solved(tolerance: float) -> float:
        found = solve_bvp(f, ends, times / times[-1], states, [times[-1]], fun_jac=f_y, tol=tolerance, max_nodes=100_000)
        return abs(float(found.p[0]) / exact - 1)

    for tolerance in 10.0 ** -np.arange(3, 13):
        taken, error = least(lambda tolerance=tolerance: solved(tolerance), 2)
        if error <= wanted:
            break
    return taken, error


if __name__ == "__main__":
    for label, value in measured():
        print(f"{label:76}  {value}")
