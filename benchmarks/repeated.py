"""A second run-up of R1 over 20 s, in multiples of its integration, in processor time (watched: asked, 1.5).

The first run derived and compiled; what is left is integration, verdict, and the Dataset with its outputs and attributes.
Verdict and Dataset integrate as well: like bodies that move together are followed from the end of the run with differences
between them, and a neighbour of the run shows which of its numbers are chance.
"""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.timing import processor_time
from wucht.dynamics.run_ups.neighbours import neighbour_of
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.verdicts.certificate import MotionEnd, certified_verdict
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.integration import integrate
from wucht.studies.run_up.machine_run import MachineRun
from wucht.studies.run_up.study import RunUp
from wucht.studies.runner import run


def measure() -> Iterator[tuple[str, str]]:
    machine = load_machine("drozdetskaya-2020/r1")
    asked = RunUp(until=20.0, start={"p1": 0.3, "p2": -0.5})
    run(asked, machine)
    case = _case(asked, machine)
    motion = _motion(case)
    initial, values, grid = case.models[0].initial, case.models[0].parameter_values, motion.trajectory.time
    alone = processor_time(lambda: integrate(motion.compiled_system, initial, values, grid, None, case.horizon.energy), 25)
    yield "integration alone", f"{1e3 * alone:8.2f} ms"
    unwatched = processor_time(lambda: _unwatched(motion, case), 25)
    yield (
        "integrated leg by leg and watched, times the same unwatched",
        f"{processor_time(lambda: _legs(motion, case), 25) / unwatched:8.2f}",
    )
    followed = processor_time(lambda: _follow(motion), 25)
    yield "the run, like bodies and a neighbour integrated, times the integration", f"{1 + followed / alone:8.1f}"
    judged = processor_time(lambda: _motion(_case(asked, machine)).verdict, 25)
    yield "checked, integrated and judged, times the integration", f"{judged / alone:8.1f}"
    whole = processor_time(lambda: run(asked, machine), 25)
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


def _follow(motion: Motion) -> None:
    """Integrate what the verdict and the Dataset need beside the run."""
    end = motion.trajectory
    certified_verdict(
        motion.case.machine,
        motion.verdict,
        MotionEnd(
            motion.compiled_system.system,
            lambda: motion.compiled_system,
            end.final_parameter_values,
            end.end_state,
            end.end_time,
        ),
    )
    neighbour_of(motion, Work())


def _case(asked: RunUp, machine: Machine) -> RunUpCase:
    (only,) = asked.prepare(machine)
    assert isinstance(only, MachineRun)
    return only.case


def _motion(case: RunUpCase) -> Motion:
    for motions in run_up(case, Work()):
        (motion,) = motions
    return motion
