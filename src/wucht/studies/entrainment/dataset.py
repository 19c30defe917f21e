"""Findings -> the Dataset of the study ``entrainment``, with the answer in numbers and in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase
from wucht.dynamics.entrainment.locked_motions import bodies_with_phase
from wucht.dynamics.entrainment.runs_from_start import RunFromStart
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrapped
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.entrainment.report import band_in_words
from wucht.studies.entrainment.run import Findings

if TYPE_CHECKING:
    import xarray as xr

_CREEPING = 0.02  # rad: a phase that moves more in the second half of the window is not yet steady


def dataset(case: EntrainmentCase, findings: Findings) -> xr.Dataset:
    """The Dataset.

    Coordinate: body, those that have a phase: to the rotor that they turn about, of a rotor to the main one, of the main rotor
    to the vibration (then in (-pi, pi], else in [0, 2 pi)). Of the averaged equations (point): value, phase (body, point),
    speed, stable, branch. Of locked motions of the full ones (orbit): orbit_value, orbit_phase, orbit_speed, orbit_stable,
    orbit_multiplier (the largest that is not 1 for reasons of form). Of runs from the start (run): run_value, run_taken
    (whether the rotors end entrained), run_speed (mean of the main rotor, in magnitude), run_mean_speed (with its sign),
    run_drift (creep of the phase), run_until (how long it was asked to be), run_end_time, run_failed (a sentence), run_window
    (end, run) of the means, run_rotor_speed, run_rotor_phase (rotor, run): mean speeds, and phases to the main rotor, of this
    one to the vibration; run_end_state (state, run), and free_speed of the main rotor.
    """
    import xarray as xr_

    names, swept, frequency = bodies_with_phase(case.machine), case.swept, case.machine.shaking_frequency
    runs = findings.runs or (() if findings.own is None else (findings.own,))
    result = xr_.Dataset(
        _of_motions(case, findings, names) | _of_runs(case, runs),
        coords={"body": variable("body", names or np.empty(0, "U1"), "body")},
    )
    answer = _summary(case, findings)
    return answered(
        result, answer, answer["sentence"], _warnings(case, findings), findings.failure,
        along=swept.name, along_unit=swept.unit, along_what=swept.what,
        **({} if frequency is None else {"frequency": frequency}),
    )  # fmt: skip


def _in_a_turn(machine: Machine, phases: Any) -> np.ndarray:
    """Phases to a vibration in (-pi, pi], as 001 (22) has them, to a rotor in [0, 2 pi)."""
    return math.pi - wrapped(math.pi - phases) if machine.shaken is not None else wrapped(phases)


def _of_motions(case: EntrainmentCase, findings: Findings, names: list[str]) -> dict[str, Variable]:
    """Of the averaged equations (point), and of locked motions of the full ones (orbit)."""
    machine, swept, motions, branches = case.machine, case.swept, findings.motions, findings.existing.branches
    angle, speed, equations = "rad" if machine.units.time else "", machine.units.speed, findings.existing.equations
    sizes = [len(b.values) for b in branches]
    phases, speeds = np.full((len(names), sum(sizes)), np.nan), np.empty(0)
    if equations is not None and branches:
        states = np.concatenate([b.states for b in branches], axis=1)
        speeds = equations.speed(states)
        for name, row in equations.phase_rows.items():
            phases[names.index(name)] = _in_a_turn(machine, states[row])
    locked = np.array([_in_a_turn(machine, m.phases) for m in motions]).reshape(len(motions), len(names)).T
    return {
        "value": variable("point", np.concatenate([np.empty(0), *(b.values for b in branches)]), swept.what, swept.unit),
        "phase": variable("body point", phases, "phase", angle),
        "speed": variable("point", speeds, "speed", speed),
        "stable": variable("point", np.concatenate([np.empty(0), *(b.stable for b in branches)]).astype(np.int8), "stable"),
        "branch": variable("point", np.repeat(np.arange(len(sizes)), sizes), "branch"),
        "orbit_value": variable("orbit", [m.value for m in motions], swept.what, swept.unit),
        "orbit_phase": variable("body orbit", locked, "phase", angle),
        "orbit_speed": variable("orbit", [m.speed for m in motions], "speed", speed),
        "orbit_stable": variable("orbit", np.array([m.stable for m in motions], np.int8), "stable"),
        "orbit_multiplier": variable("orbit", [m.multiplier for m in motions], "largest multiplier"),
    }


def _of_runs(case: EntrainmentCase, runs: Sequence[RunFromStart]) -> dict[str, Variable]:
    machine, swept, units = case.machine, case.swept, case.machine.units
    names, angle = [r.name for r in machine.rotors], "rad" if units.time else ""
    keys = ["vibration", *names[1:]]  # of phases

    def rows(count: int, of_runs: Sequence[Any]) -> np.ndarray:
        """Several numbers of each run, (count, run)."""
        return np.array(of_runs, float).reshape(len(runs), count).T

    speeds = rows(len(names), [[r.speeds.get(n, math.nan) for n in names] for r in runs])
    phases = rows(len(names), [[r.phases.get(k, math.nan) for k in keys] for r in runs])
    states = rows(len(machine.state_names), [r.end_state for r in runs])
    return {
        "run_value": variable("run", [r.value for r in runs], swept.what, swept.unit),
        "run_taken": variable("run", np.array([r.entrained for r in runs], np.int8), "entrained"),
        "run_speed": variable("run", [abs(r.mean_speed) for r in runs], "mean speed", units.speed),
        "run_mean_speed": variable("run", [r.mean_speed for r in runs], "mean speed", units.speed),
        "run_drift": variable("run", [r.creep for r in runs], "creep of the phase", angle),
        "run_until": variable("run", [r.until for r in runs], "time asked for", units.time),
        "run_end_time": variable("run", [r.end_time for r in runs], "end", units.time),
        "run_failed": variable("run", np.array([r.failure or "" for r in runs], str), "why the run failed"),
        "run_window": variable("end run", rows(2, [r.window for r in runs]), "window of the means", units.time),
        "run_rotor_speed": variable("rotor run", speeds, "mean speed", units.speed),
        "run_rotor_phase": variable("rotor run", phases, "phase", angle),
        "run_end_state": variable("state run", states, "state at the end"),
        "free_speed": variable("run", np.array([r.free_speed for r in runs], float), "speed without vibration", units.speed),
    }


def _summary(case: EntrainmentCase, findings: Findings) -> dict[str, Any]:
    """The summary of the contract."""
    own, motion, band, capture = findings.own, findings.own_motion, findings.existing.band, findings.band
    phases, outcome = _phases(case, findings), _outcome(case, findings)
    averaged = {name: float(_in_a_turn(case.machine, phase)) for name, phase in findings.existing.phases.items()}
    mean = None if own is None else own.mean_speed
    return {
        "sentence": _sentence(case, findings, outcome),
        "outcome": str(outcome),
        "along": case.swept.name,
        "along_unit": case.swept.unit,
        "value": case.swept.own,
        "range": None if findings.range is None else list(findings.range),
        "existence_band": None if band is None else [None if e.kind == "range" else e.value for e in (band.low, band.high)],
        "existence_band_from": None if band is None else "averaged equations",
        "existence_edges": None if band is None else [band.low.kind, band.high.kind],
        "branch": None if band is None else band.branch,
        "existence_band_full": list(findings.ends) if findings.motions else None,
        "band_from_rest": None if capture is None else list(capture.edges),
        "islands": [] if capture is None else [list(i) for i in capture.islands],
        "phase": _only(phases),
        "phases": phases,
        "phase_slow": _only(averaged),
        "phases_slow": averaged,
        "mean_speed": mean if motion is None or mean is None else math.copysign(motion.speed, mean),
        "window": None if own is None else list(own.window),
        "stable": None if motion is None else motion.stable,
        "multiplier": None if motion is None else motion.multiplier,
        "threshold_amplitude": findings.threshold,
        "resolution": findings.resolution,
    }


def _phases(case: EntrainmentCase, findings: Findings) -> dict[str, float]:
    """By body: of the locked motion, else at the end of the run where that is entrained."""
    names, own, motion = bodies_with_phase(case.machine), findings.own, findings.own_motion
    if motion is not None:
        return dict(zip(names, _in_a_turn(case.machine, motion.phases).tolist(), strict=True))
    if own is None or not own.entrained:
        return {}
    if "vibration" in own.phases:
        return {names[0]: float(_in_a_turn(case.machine, own.phases["vibration"]))}
    return dict(own.phases)


def _only(phases: dict[str, float]) -> float | dict[str, float] | None:
    """The phase where there is a single one, else all by name; None where there is none."""
    return next(iter(phases.values())) if len(phases) == 1 else phases or None


def _outcome(case: EntrainmentCase, findings: Findings) -> Outcome:
    if findings.own is None:
        return Outcome.UNIDENTIFIED
    if findings.failure is not None:
        return Outcome.FAILED
    if case.machine.shaken is not None:
        return Outcome.ENTRAINED if findings.own.entrained else Outcome.NOT_ENTRAINED
    return Outcome.SYNCHRONISED if findings.own.entrained else Outcome.NOT_SYNCHRONISED


def _sentence(case: EntrainmentCase, findings: Findings, outcome: Outcome) -> str:
    if findings.failure is not None:
        return findings.failure
    if findings.band is None:
        interrupted = "the study was interrupted before its band was found"
        nowhere = "nowhere in the range is it reached from the start"
        return f"{outcome.sentence}; {nowhere if findings.complete else interrupted}"
    band = band_in_words(findings.band.edges, case.swept.unit, f"{case.swept.name} = ")
    return f"{outcome.sentence}; from the start that is reached {band}"


def _warnings(case: EntrainmentCase, findings: Findings) -> list[str]:
    """What is doubtful, left out, or not yet done."""
    swept, runs = case.swept, findings.runs
    unit = f" {swept.unit}" if swept.unit else ""
    lines = [*findings.existing.warnings, *(f"at {swept.name} = {r.value:.6g}: {r.failure}" for r in runs if r.failure)]
    lines += [findings.no_motion] if findings.no_motion is not None else []
    if not findings.complete and findings.failure is None:
        lines.append(f"{len(runs)} runs from the start are finished; the search is not")
    if findings.band is not None and findings.band.islands:
        where = ", ".join(f"{low:.5g} to {high:.5g}" for low, high in findings.band.islands)
        lines.append(f"from the start it is also reached apart from the band: {where}{unit}; finer points may show more")
    moving = next((r for r in runs if r.entrained and r.creep > _CREEPING), None)
    if moving is not None:
        where = f"{swept.name} = {moving.value:.6g}{unit}"
        lines.append(f"at {where} the phase still moves at the end of the run: give a longer until")
    return lines
