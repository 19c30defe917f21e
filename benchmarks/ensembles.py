"""Ensembles: basins of 128 x 128 run-ups from rest to tau = 1000 at 1e-6, and of 256 x 256 of the slow equations.

Of the machine of Table 5.1, and of a drum with two pendulums on unequal supports, which has no frame of its own to turn with.
The study ``basin``: sampled, classified and stored. The peers, in turn with it: heyoka's batches of the same members as one
writes them by hand, not looked at: not sampled either, and sampled at a hundred times. No study that samples can be faster than
the second. Two threads cannot gain more than the two processors do, which is what the first of the peers gains by its second
thread. Of five, the medians of rates and ratios.
"""

from __future__ import annotations

import copy
import math
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Literal

import numpy as np
from tests.reference_integrators import taylor_equations

from wucht.dynamics.sampling.ensemble_equations import Variants, member_equations, parameters_of
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.basin.study import Basin
from wucht.studies.runner import run

_TOLERANCE, _REPETITIONS, _SAMPLES = 1e-6, 5, 100
_PENDULUM = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "damping": 0.169}


@dataclass(frozen=True)
class Case:
    """Cells in each direction, and until when."""

    name: str
    machine: Machine
    model: Literal["full", "slow"]
    cells: int
    until: float

    @property
    def question(self) -> Basin:
        axes = {"psi": [0.0, 2 * math.pi, self.cells], "delta": [0.0, math.pi, self.cells]}
        return Basin(axes=axes, model=self.model, until=self.until, tolerance=_TOLERANCE)


def cases() -> Iterator[Case]:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    yield Case("full, turning frame", machine, "full", 128, 1000.0)
    yield Case("full, fixed frame", _on_unequal_supports(), "full", 128, 10.0)
    yield Case("slow equations", machine, "slow", 256, 2000.0)


def _on_unequal_supports() -> Machine:
    """A drum with two pendulums, with a natural frequency of 100 rad/s."""
    return machine_from(
        {
            "carrier": {"stiffness": [1.00e5, 1.01e5], "damping": 200.0},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.03},
                *(_PENDULUM | {"name": n} for n in ("p1", "p2")),
            ],
            "drive": {"on": "drum", "kind": "linear", "slope": 0.02, "no_load_speed": 200.0},
        }
    )


def measure() -> Iterator[tuple[str, str]]:
    for case in cases():
        count = case.cells**2
        sampled = np.linspace(0.0, case.until, _SAMPLES + 1)
        ends = sampled[[0, -1]]
        by_hand = {"hand": _by_hand(case, ends, 2), "alone": _by_hand(case, ends, 1), "sampled": _by_hand(case, sampled, 2)}
        times = _in_turn({**by_hand, 2: _asked(case, 2), 1: _asked(case, 1)})
        what = f"{case.name}, {count} members"
        yield f"{what}: sampled, classified and stored, a second", f"{count / median(times[2]):8.0f}"
        yield f"{what}: by hand, a second", f"{count / median(times['hand']):8.0f}"
        yield f"{what}: by hand, sampled, a second", f"{count / median(times['sampled']):8.0f}"
        yield f"{what}: share of the rate by hand", f"{_ratio(times['hand'], times[2]):8.2f}"
        yield f"{what}: share of the rate by hand, sampled", f"{_ratio(times['sampled'], times[2]):8.2f}"
        yield f"{what}: two threads, times faster than one", f"{_ratio(times[1], times[2]):8.2f}"
        yield f"{what}: by hand, two threads, times faster than one", f"{_ratio(times['alone'], times['hand']):8.2f}"


def _in_turn(jobs: dict[str | int, Callable[[], object]]) -> dict[str | int, list[float]]:
    """The times of jobs that are done in turn, after a first time of each: what else the machine does slows them all."""
    times: dict[str | int, list[float]] = {name: [] for name in jobs}
    for round_ in range(_REPETITIONS + 1):
        for name, job in jobs.items():
            begun = time.perf_counter()
            job()
            times[name] += [time.perf_counter() - begun] if round_ else []
    return times


def _ratio(one: list[float], other: list[float]) -> float:
    return median(a / b for a, b in zip(one, other, strict=True))


def _asked(case: Case, threads: int) -> Callable[[], object]:
    """The study, on as many processors."""
    question, all_of_them = case.question, os.sched_getaffinity(0)

    def job() -> None:
        os.sched_setaffinity(0, set(sorted(all_of_them)[:threads]))
        try:
            with tempfile.TemporaryDirectory() as folder:
                result = run(question, case.machine, folder=Path(folder))
        finally:
            os.sched_setaffinity(0, all_of_them)
        assert result.attrs["finished"]

    return job


def _by_hand(case: Case, times: np.ndarray, threads: int) -> Callable[[], object]:
    """Threads, each with its batch integrator and its share of the batches of members, to the last of these times in one go;
    sampled where there are more than two."""
    import heyoka as hy

    (map_, _) = case.question.prepare(case.machine)
    begun, _ = map_.starts(0, np.arange(case.cells**2))
    equations, variants = member_equations(map_.question, begun[:, 0]), Variants.from_values(case.machine, {}, begun.shape[1])
    system, starts = equations.system, equations.starts(begun, variants)
    right, width = taylor_equations(system, parameters_of(system, variants)[0]), 2 * hy.recommended_simd_size()
    original = hy.taylor_adaptive_batch(right, np.zeros((len(right), width)), tol=_TOLERANCE)
    integrators, grid = [copy.deepcopy(original) for _ in range(threads)], np.repeat(times[:, None], width, axis=1)

    def part(thread: int) -> None:
        integrator = integrators[thread]
        for first in range(thread * width, starts.shape[1], threads * width):
            integrator.set_time(0.0)
            integrator.state[:] = starts[:, first : first + width]
            if len(grid) > 2:
                integrator.propagate_grid(grid)
            else:
                integrator.propagate_until(grid[-1])

    def job() -> None:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(part, range(threads)))

    return job
