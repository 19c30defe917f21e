"""Ensembles: 64 x 64 run-ups from rest of the machine of Table 5.1 to tau = 1000 at 1e-6, and its slow equations 256 x 256.

Watched: 101 samples a member in chunks of some hundred steps (five, and two of the slow equations), of which the largest of one
state is kept. The peer, in turn with it: heyoka's batches of the same members as one writes them by hand, without samples and
with. Of five, the medians of rates and ratios.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from statistics import median

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.files.catalogue import load_machine
from wucht.numerics.ensembles.ensemble import CompiledEnsemble, compile_ensemble, run_ensemble
from wucht.numerics.ensembles.members import Members, Pace, Status
from wucht.numerics.flow.heyoka_engine import translation
from wucht.numerics.flow.program import lower
from wucht.studies.initial_state import initial_state
from wucht.system import System

_TOLERANCE, _REPETITIONS = 1e-6, 5
_FULL, _SLOW = 64, 256  # starts in each direction
_PACE, _SLOW_PACE = Pace(200.0, 20, 1000.0), Pace(1000.0, 50, 2000.0)


@dataclass(frozen=True)
class Largest:
    value: np.ndarray


@dataclass(frozen=True)
class Watch:
    """The largest value of one state. Nothing settles."""

    row: int

    def begin(self, members: Members) -> Largest:
        return Largest(members.starts[:, self.row].copy())

    def after(self, record: Largest, times: np.ndarray, samples: np.ndarray) -> tuple[Largest, np.ndarray]:
        return Largest(np.maximum(record.value, samples[:, self.row].max(axis=0))), np.zeros(samples.shape[-1], bool)


@dataclass(frozen=True)
class Case:
    name: str
    system: System
    members: Members
    pace: Pace


def cases() -> Iterator[Case]:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    starts = [initial_state(machine, {"psi": psi, "delta": delta}) for psi, delta in _grid(_FULL)]
    relative = RelativeEquilibria.of(machine)
    turning, values = relative.turned(np.array(starts).T).T, relative.system.values(relative.values)
    yield Case("full, turning frame", relative.system, Members.of(turning, values), _PACE)
    fixed = Members.of(np.array(starts), machine.system.values(machine.values))
    yield Case("full, fixed frame", machine.system, fixed, _PACE)
    slow = averaged_machine(machine, inertia=False)
    angles = ({"rotor": 0.0, "p1": psi + delta / 2, "p2": psi - delta / 2} for psi, delta in _grid(_SLOW))
    rest = dict.fromkeys(("rotor", "p1", "p2"), 0.0)
    begun = np.array([slow.state(a, rest) for a in angles])
    yield Case("slow equations", slow.system, Members.of(begun, slow.values()), _SLOW_PACE)


def _grid(count: int) -> Iterator[tuple[float, float]]:
    """psi in (0, 2 pi) and delta in (0, pi), the centres of cells."""
    for i, j in np.ndindex(count, count):
        yield 2 * np.pi * (i + 0.5) / count, np.pi * (j + 0.5) / count


def measure() -> Iterator[tuple[str, str]]:
    for case in cases():
        compiled = compile_ensemble(case.system, _TOLERANCE)
        watched = {threads: _watched(compiled, case, threads) for threads in (1, 2)}
        jobs = {"hand": _by_hand(compiled, case, 0), "sampled": _by_hand(compiled, case, 101), **watched}
        times = _in_turn(jobs)
        count = len(case.members)
        what = f"{case.name}, {count} members"
        yield f"{what}: watched, a second", f"{count / median(times[2]):8.0f}"
        yield f"{what}: by hand, not sampled, a second", f"{count / median(times['hand']):8.0f}"
        yield f"{what}: watched, times the time by hand", f"{_ratio(times[2], times['hand']):8.2f}"
        yield f"{what}: watched, times the time by hand with 101 samples", f"{_ratio(times[2], times['sampled']):8.2f}"
        yield f"{what}: two threads, times faster than one", f"{_ratio(times[1], times[2]):8.2f}"


def _in_turn(jobs: dict[str | int, Callable[[], object]]) -> dict[str | int, list[float]]:
    """The times of jobs that are done in turn: what else the machine does slows them all."""
    times: dict[str | int, list[float]] = {name: [] for name in jobs}
    for _ in range(_REPETITIONS):
        for name, job in jobs.items():
            begun = time.perf_counter()
            job()
            times[name].append(time.perf_counter() - begun)
    return times


def _ratio(one: list[float], other: list[float]) -> float:
    return median(a / b for a, b in zip(one, other, strict=True))


def _watched(compiled: CompiledEnsemble, case: Case, threads: int) -> Callable[[], object]:
    watch = Watch(compiled.system.state_names.index("rotor.speed"))

    def job() -> None:
        ends = run_ensemble(compiled, case.members, watch, case.pace, threads)
        assert ends.count(Status.LIMIT) == len(case.members)

    return job


def _by_hand(compiled: CompiledEnsemble, case: Case, samples: int) -> Callable[[], object]:
    """Two threads, each with its batch integrator and every other batch of members, to the end in one go."""
    import heyoka as hy

    program, width = lower(compiled.system, compiled.system.derivatives), compiled.width
    variables, translate = translation(program)
    right = list(zip(variables, translate.program(program.lines, program.results), strict=True))
    original = hy.taylor_adaptive_batch(right, np.zeros((len(variables), width)), tol=_TOLERANCE)
    original.pars[:] = program.constant_values(case.members.parameters[0])[:, None]
    integrators, starts, end = (
        [copy.deepcopy(original) for _ in range(2)],
        case.members.starts.T,
        np.full(width, case.pace.until),
    )

    grid = np.linspace(0, end, samples) if samples else None

    def part(thread: int) -> None:
        integrator = integrators[thread]
        for first in range(thread * width, len(case.members), 2 * width):
            integrator.set_time(0.0)
            integrator.state[:] = starts[:, first : first + width]
            if samples:
                integrator.propagate_grid(grid)
            else:
                integrator.propagate_until(end)

    def job() -> None:
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(part, range(2)))

    return job
