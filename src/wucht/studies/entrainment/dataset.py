"""Findings -> the Dataset of the study ``entrainment``: phases and speeds over the parameter, and runs from the start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.entrainment.locked_motions import bodies_with_phase
from wucht.studies.entrainment.prepare import Plan
from wucht.studies.entrainment.run import Findings
from wucht.studies.entrainment.runs import RunFromStart
from wucht.studies.entrainment.summary import in_a_turn, summary, warnings

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset.

    Coordinate: body, those that have a phase: to the rotor that they turn about, of a rotor to the main one, of the main rotor
    to the vibration (then in (-pi, pi], else in [0, 2 pi)). Of the averaged equations (point): value, phase (body, point),
    speed, stable, branch. Of locked motions of the full ones (orbit): orbit_value, orbit_phase, orbit_speed, orbit_stable,
    orbit_multiplier (the largest that is not 1 for reasons of form). Of runs from the start (run): run_value, run_taken,
    run_speed (mean of the main rotor, in magnitude), run_mean_speed (with its sign), run_drift, run_until (how long it was
    asked to be), run_end_time, run_failed (a sentence), run_window (end, run) of the means, run_rotor_speed, run_rotor_phase
    (rotor, run): mean speeds, and phases to the main rotor, of this one to the vibration; run_end_state (state, run), and
    free_speed of the main rotor.
    """
    import xarray as xr_

    names, swept = bodies_with_phase(plan.machine), plan.swept
    runs = findings.runs or (() if findings.own is None else (findings.own,))
    result = xr_.Dataset(
        _of_branches(plan, findings, names) | _of_motions(plan, findings, names) | _of_runs(plan, runs),
        coords={"body": variable("body", names or np.empty(0, "U1"), "body")},
    )
    answer, frequency = summary(plan, findings), plan.machine.shaking_frequency
    return answered(
        result, answer, answer["sentence"], warnings(plan, findings), findings.failure,
        along=swept.name, along_unit=swept.unit, along_what=swept.what,
        **({} if frequency is None else {"frequency": frequency}),
    )  # fmt: skip


def _of_branches(plan: Plan, findings: Findings, names: list[str]) -> dict[str, Variable]:
    machine, swept, existing = plan.machine, plan.swept, findings.existing
    branches = existing.branches if existing is not None else ()
    states = np.concatenate([b.states for b in branches], axis=1) if branches else np.empty((0, 0))
    phases, speeds = np.full((len(names), states.shape[1]), np.nan), np.empty(0)
    if existing is not None and branches:
        speeds = existing.equations.speed(states)
        for name, row in existing.equations.phase_rows.items():
            phases[names.index(name)] = in_a_turn(machine, states[row])
    numbers = _joined([np.full(len(b.values), k) for k, b in enumerate(branches)]).astype(int)
    return {
        "value": variable("point", _joined([b.values for b in branches]), swept.what, swept.unit),
        "phase": variable("body point", phases, "phase", _angle_unit(machine)),
        "speed": variable("point", speeds, "speed", machine.units.speed),
        "stable": variable("point", _joined([b.stable for b in branches]).astype(np.int8), "stable"),
        "branch": variable("point", numbers, "branch"),
    }


def _of_motions(plan: Plan, findings: Findings, names: list[str]) -> dict[str, Variable]:
    machine, swept, motions = plan.machine, plan.swept, findings.motions
    phases = np.array([in_a_turn(machine, m.phases) for m in motions]).reshape(len(motions), len(names)).T
    return {
        "orbit_value": variable("orbit", _each([m.value for m in motions]), swept.what, swept.unit),
        "orbit_phase": variable("body orbit", phases, "phase", _angle_unit(machine)),
        "orbit_speed": variable("orbit", _each([m.speed for m in motions]), "speed", machine.units.speed),
        "orbit_stable": variable("orbit", np.array([m.stable for m in motions], np.int8), "stable"),
        "orbit_multiplier": variable("orbit", _each([m.multiplier for m in motions]), "largest multiplier"),
    }


def _of_runs(plan: Plan, runs: Sequence[RunFromStart]) -> dict[str, Variable]:
    machine, swept, units, count = plan.machine, plan.swept, plan.machine.units, len(runs)
    names, angle, size = [r.name for r in machine.rotors], _angle_unit(machine), len(machine.state_names)
    keys = ["vibration", *names[1:]]  # of phases
    speeds = _each([[r.speeds.get(n, math.nan) for n in names] for r in runs]).reshape(count, len(names)).T
    phases = _each([[r.phases.get(k, math.nan) for k in keys] for r in runs]).reshape(count, len(names)).T
    windows = _each([r.window for r in runs]).reshape(count, 2).T
    return {
        "run_value": variable("run", _each([r.value for r in runs]), swept.what, swept.unit),
        "run_taken": variable("run", np.array([r.entrained for r in runs], np.int8), "taken along"),
        "run_speed": variable("run", _each([abs(r.mean_speed) for r in runs]), "mean speed", units.speed),
        "run_mean_speed": variable("run", _each([r.mean_speed for r in runs]), "mean speed", units.speed),
        "run_drift": variable("run", _each([r.drift for r in runs]), "drift of the phase", angle),
        "run_until": variable("run", _each([r.until for r in runs]), "time asked for", units.time),
        "run_end_time": variable("run", _each([r.end_time for r in runs]), "end", units.time),
        "run_failed": variable("run", np.array([r.failure or "" for r in runs], str), "why the run failed"),
        "run_window": variable("end run", windows, "window of the means", units.time),
        "run_rotor_speed": variable("rotor run", speeds, "mean speed", units.speed),
        "run_rotor_phase": variable("rotor run", phases, "phase", angle),
        "run_end_state": variable("state run", _each([r.end_state for r in runs]).reshape(count, size).T, "state at the end"),
        "free_speed": variable("run", _each([r.free_speed for r in runs]), "speed without vibration", units.speed),
    }


def _each(values: Sequence[Any]) -> np.ndarray:
    return np.array(values, float)


def _angle_unit(machine: Machine) -> str:
    return "rad" if machine.units.time else ""


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    return np.concatenate(parts) if parts else np.empty(0)
