"""A run-up of the full and of the slow equations from one start, and how far they are apart."""

from __future__ import annotations

import json
import time as clock
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.results.conventions import variable
from wucht.results.store import to_json
from wucht.studies.deviations import Course, Deviations, at_equal_angle, at_equal_phase, watched
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.run_up.model import slow_model
from wucht.studies.run_up.plan import Plan
from wucht.studies.run_up.study import RunUp, judged_by, prepared, single_run_up, summary

if TYPE_CHECKING:
    import xarray as xr

_SHOWN = ("angle", "speed", "amplitude", "phase", "rotor_phase", "radius")


def run_up_both(
    machine: Machine,
    question: RunUp,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """The Dataset of the full run-up, with the slow one at the same times.

    Variables slow_angle, slow_speed (body, time), slow_phase (balancer, time), slow_amplitude, slow_radius (time);
    speed_deviation and radius_deviation (compared), at equal angle of the rotor. Summary: ``slow`` and ``deviations``.
    """
    found, slow = both_runs(machine, question, progress, checkpoint, resume)
    asked = json.loads(found.attrs["input"])
    found.attrs["input"] = to_json(asked | {"study": asked["study"] | _model_of(question)}, indent=None)
    if slow is None:
        return found
    if not slow.attrs["finished"] and not slow.attrs["failure"]:  # Ctrl-C
        warnings = [*json.loads(found.attrs["warnings"]), "the slow equations were interrupted; --resume runs them again"]
        found.attrs |= {"warnings": to_json(warnings, indent=None), "finished": 0}
        return found
    if slow.attrs["failure"]:
        warnings = [*json.loads(found.attrs["warnings"]), f"slow equations: {slow.attrs['failure']}"]
        found.attrs["warnings"] = to_json(warnings, indent=None)
    sampled = slow.sizes["time"]
    for name in (n for n in _SHOWN if n in slow):
        values = np.full((*slow[name].shape[:-1], found.sizes["time"]), np.nan)
        values[..., :sampled] = slow[name].values
        attributes = found[name].attrs
        found[f"slow_{name}"] = variable(
            " ".join(map(str, found[name].dims)), values, f"{attributes['long_name']}, slow equations", attributes["units"]
        )
    by_angle, by_phase = compared(machine, found, slow)
    found = _with_deviations(found, by_angle)
    both = summary(found) | {
        "slow": summary(slow),
        "deviations": {"at_equal_angle": _largest(by_angle), "at_equal_phase": _largest(by_phase)},
    }
    found.attrs["summary"] = to_json(both, indent=None)
    return found


def both_runs(
    machine: Machine,
    question: RunUp,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> tuple[xr.Dataset, xr.Dataset | None]:
    """The Datasets of the full run-up and of the slow one at the same times, None where the full one is not complete."""
    full = single_run_up(machine, replace(question, model="full", inertia=None, order=1), progress, checkpoint, resume)
    if full.attrs["failure"] or not full.attrs["finished"] or full.sizes["time"] < 2:
        return full, None
    return full, slow_run(machine, question, full.time.values)


def slow_run(machine: Machine, question: RunUp, time: np.ndarray) -> xr.Dataset:
    """The Dataset of the slow run-up at given times (N,)."""
    from wucht.studies.run_up.result import result

    begun = clock.perf_counter()
    question = replace(question, model="slow")
    machine, initial = prepared(machine, question)
    model = slow_model(machine, initial, question.inertia, question.order)
    flow = compile_system(model.system, question.tolerance, (), question.engine)
    plan = Plan.of(machine, question, initial)
    trajectory = integrate(flow, model.initial, model.values, time, None, None, plan.energy)
    said = [*model.warnings, *(model.remedies if trajectory.failure else ())]
    return result(machine, question, flow, model, trajectory, judged_by(machine, plan, model.seen(trajectory)), said, begun)


def course_of(machine: Machine, run: xr.Dataset) -> Course:
    """What is compared of a run."""
    main = machine.rotor.name
    angle, speed = run.angle.sel(body=main).values, run.speed.sel(body=[b.name for b in watched(machine)]).values
    sense = float(np.sign(angle[-1] - angle[0])) or 1.0
    about = [b.name for b in machine.bodies if b.about == main]
    phase = sense * (run.angle.sel(body=about).values.mean(axis=0) - angle) if about else None
    return Course(sense * angle, sense * speed, run.radius.values, phase)


def compared(machine: Machine, full: xr.Dataset, slow: xr.Dataset) -> tuple[Deviations | None, Deviations | None]:
    """Deviations at equal angle and at equal phase."""
    mine, other = course_of(machine, full), course_of(machine, slow)
    return at_equal_angle(mine, other), at_equal_phase(mine, other)


def _model_of(question: RunUp) -> dict[str, Any]:
    given = {"model": question.model, "order": question.order}
    return given if question.inertia is None else given | {"inertia": question.inertia}


def _largest(found: Deviations | None) -> dict[str, float] | None:
    return None if found is None else dict(zip(("speed", "amplitude"), found.largest, strict=True))


def _with_deviations(result: xr.Dataset, found: Deviations | None) -> xr.Dataset:
    if found is None:
        return result
    name = "angle of the rotor at which the models are compared"
    return result.assign_coords(compared=variable("compared", found.at, name, "rad")).assign(
        speed_deviation=variable("compared", found.speed, "speed, full less slow", result.speed.attrs["units"]),
        radius_deviation=variable(
            "compared", found.radius, "distance of the axis, full less slow", result.radius.attrs["units"]
        ),
    )
