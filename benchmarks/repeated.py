"""A second run-up of R1 over 20 s, in multiples of its integration (asked: with verdict 2, with verdict and Dataset 4; what is
watched less than half as much again).

The first run derived and compiled; what is left is integration, verdict, and the Dataset with its outputs and attributes.
"""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.run_up import best
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.integration import integrate
from wucht.studies.run_up.study import RunUp
from wucht.studies.runner import run


def measure() -> Iterator[tuple[str, str]]:
    machine = load_machine("drozdetskaya-2020/r1")
    asked = RunUp(until=20.0, start={"p1": 0.3, "p2": -0.5})
    run(asked, machine)
    (first,) = asked.prepare(machine)
    motion, case = _motion(first.case), first.case
    initial, values, grid = case.models[0].initial, case.models[0].parameter_values, motion.trajectory.time
    alone = best(lambda: integrate(motion.compiled_system, initial, values, grid, None, case.horizon.energy), 9)
    yield "integration alone", f"{1e3 * alone:8.2f} ms"
    watched = best(lambda: _legs(motion, case), 25) / best(lambda: _unwatched(motion, case), 25)
    yield "integrated leg by leg and watched, times the same unwatched", f"{watched:8.2f}"
    judged = best(lambda: _motion(asked.prepare(machine)[0].case).verdict, 9)
    yield "checked, integrated and judged, times the integration", f"{judged / alone:8.1f}"
    whole = best(lambda: run(asked, machine), 9)
    yield "the same with its Dataset", f"{whole / alone:8.1f}"


def _legs(motion: Motion, case: RunUpCase) -> None:
    model, watched = case.models[0], motion.integration
    leg = watched.begin(model.initial, model.parameter_values)
    for grid in case.horizon.legs():
        leg = watched.leg(leg, grid.samples)
    watched.observation(leg)


def _unwatched(motion: Motion, case: RunUpCase) -> None:
    model, horizon = case.models[0], case.horizon
    state, values = model.initial, model.parameter_values
    for grid in horizon.legs():
        leg = integrate(motion.compiled_system, state, values, grid.samples, None, horizon.energy)
        state, values = leg.end_state, leg.final_parameter_values


def _motion(case: RunUpCase) -> Motion:
    for motions in run_up(case, Work()):
        (motion,) = motions
    return motion
