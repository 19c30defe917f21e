"""Findings -> the quantities of an entrainment, and its lines in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.entrainment.entrainment_case import AMPLITUDE, EntrainmentCase
from wucht.dynamics.entrainment.locked_motions import bodies_with_phase
from wucht.dynamics.entrainment.runs_from_start import RunFromStart
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_angle
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.entrainment.computation import Findings

if TYPE_CHECKING:
    import xarray as xr


_CREEP_LIMIT = 0.02  # rad: a phase that moves further in the second half of the window is not steady yet


def dataset(case: EntrainmentCase, findings: Findings) -> xr.Dataset:
    """Return the Dataset. Phases: of rotors relative to the main one, of it to the vibration, of bodies to their rotor."""
    parameter, frequency, outcome = case.parameter, case.machine.shaking_frequency, _outcome(case, findings)
    runs = findings.runs or (() if findings.nominal_run is None else (findings.nominal_run,))
    quantities = [
        Quantity("outcome", str(outcome), "outcome"),
        *_band_quantities(case, findings),
        *_machine_quantities(case, findings),
        *_motion_quantities(case, findings),
        *_run_quantities(case, runs),
    ]
    return result_dataset(
        quantities, _sentence(case, findings, outcome), _warnings(case, findings), (), findings.failure,
        along=parameter.name, along_unit=parameter.unit, along_what=parameter.description,
        **({} if frequency is None else {"frequency": frequency}),
    )  # fmt: skip


def _wrap_phases(machine: Machine, phases: Any) -> np.ndarray:
    """Wrap phases: relative to a vibration into (-pi, pi], as in 001 (22), relative to a rotor into [0, 2 pi)."""
    return math.pi - wrap_angle(math.pi - phases) if machine.shaken_coordinate is not None else wrap_angle(phases)


def _motion_quantities(case: EntrainmentCase, findings: Findings) -> list[Quantity]:
    """Return the motions of the averaged equations (point), and the locked motions of the full ones (orbit)."""
    machine, parameter, motions, branches = case.machine, case.parameter, findings.motions, findings.existing.branches
    names, equations, speed, angle = bodies_with_phase(machine), findings.existing.equations, machine.units.speed, _angle(case)
    sizes = [len(b.values) for b in branches]
    phases, speeds = np.full((len(names), sum(sizes)), np.nan), np.empty(0)
    if equations is not None and branches:
        states = np.concatenate([b.states for b in branches], axis=1)
        speeds = equations.speed(states)
        for name, row in equations.phase_rows.items():
            phases[names.index(name)] = _wrap_phases(machine, states[row])
    values, stable = (np.concatenate([np.empty(0), *(getattr(b, n) for b in branches)]) for n in ("values", "stable"))
    orbit_phases = np.array([_wrap_phases(machine, m.phases) for m in motions]).reshape(len(motions), len(names)).T
    return [
        Quantity("body", names or np.empty(0, "U1"), "body", "", "body"),
        Quantity("value", values, parameter.description, parameter.unit, "point"),
        Quantity("phase", phases, "phase", angle, "body point"),
        Quantity("speed", speeds, "speed", speed, "point"),
        Quantity("stable", stable.astype(np.int8), "stable", "", "point"),
        Quantity("branch", np.repeat(np.arange(len(sizes)), sizes), "branch", "", "point"),
        Quantity("orbit_value", [m.value for m in motions], parameter.description, parameter.unit, "orbit"),
        Quantity("orbit_phase", orbit_phases, "phase", angle, "body orbit"),
        Quantity("orbit_speed", [m.speed for m in motions], "speed", speed, "orbit"),
        Quantity("orbit_stable", np.array([m.stable for m in motions], np.int8), "stable", "", "orbit"),
        Quantity("orbit_multiplier", [m.multiplier for m in motions], "largest multiplier", "", "orbit"),
    ]


def _run_quantities(case: EntrainmentCase, runs: Sequence[RunFromStart]) -> list[Quantity]:
    """Return the runs from the start. run_taken: 1 where the rotors end entrained."""
    machine, parameter, units = case.machine, case.parameter, case.machine.units
    names, angle = [r.name for r in machine.rotors], _angle(case)
    keys = ["vibration", *names[1:]]  # of phases

    def rows(count: int, of_runs: Sequence[Any]) -> np.ndarray:
        """Return several numbers of each run, (count, run)."""
        return np.array(of_runs, float).reshape(len(runs), count).T

    speeds = rows(len(names), [[r.speeds.get(n, math.nan) for n in names] for r in runs])
    phases = rows(len(names), [[r.phases.get(k, math.nan) for k in keys] for r in runs])
    states, windows = rows(len(machine.state_names), [r.end_state for r in runs]), rows(2, [r.window for r in runs])
    free = np.array([r.free_speed for r in runs], float)
    return [
        Quantity("run_value", [r.value for r in runs], parameter.description, parameter.unit, "run"),
        Quantity("run_taken", np.array([r.is_entrained for r in runs], np.int8), "entrained", "", "run"),
        Quantity("run_speed", [abs(r.mean_speed) for r in runs], "mean speed", units.speed, "run"),
        Quantity("run_mean_speed", [r.mean_speed for r in runs], "mean speed", units.speed, "run"),
        Quantity("run_drift", [r.creep for r in runs], "creep of the phase", angle, "run"),
        Quantity("run_until", [r.until for r in runs], "prescribed duration", units.time, "run"),
        Quantity("run_end_time", [r.end_time for r in runs], "end", units.time, "run"),
        Quantity("run_failed", np.array([r.failure or "" for r in runs], str), "reason why the run failed", "", "run"),
        Quantity("run_window", windows, "window of the means", units.time, "end run"),
        Quantity("run_rotor_speed", speeds, "mean speed", units.speed, "rotor run"),
        Quantity("run_rotor_phase", phases, "phase", angle, "rotor run"),
        Quantity("run_end_state", states, "state at the end", "", "state run"),
        Quantity("free_speed", free, "speed without vibration", units.speed, "run"),
    ]


def _band_quantities(case: EntrainmentCase, findings: Findings) -> list[Quantity]:
    """Return the swept parameter and the bands of entrainment. An end beyond the range is None."""
    band, capture, parameter, unit = findings.existing.band, findings.band, case.parameter, case.parameter.unit
    edges = None if band is None else [None if e.kind == "range" else e.value for e in (band.low, band.high)]
    islands = [] if capture is None else [list(i) for i in capture.islands]
    return [
        Quantity("along", parameter.name, "swept parameter"),
        Quantity("along_unit", unit, "unit of the swept parameter"),
        Quantity("value", parameter.nominal_value, "nominal value of the parameter", unit),
        Quantity("range", findings.range and list(findings.range), "lowest and highest value of the parameter", unit),
        Quantity("existence_band", edges, "band in which the entrained motion exists and is stable", unit),
        Quantity("existence_band_from", band and "averaged equations", "equations of that band"),
        Quantity("existence_edges", band and [band.low.kind, band.high.kind], "kinds of the ends of that band"),
        Quantity("branch", band and band.branch, "branch of that band"),
        Quantity("existence_band_full", list(findings.ends) if findings.motions else None, "band by the full equations", unit),
        Quantity("band_from_rest", capture and list(capture.edges), "band of entrainment from the start", unit),
        Quantity("islands", islands, "intervals outside that band in which it is reached", unit),
        Quantity("resolution", findings.resolution, "resolution of the edges", unit),
    ]


def _machine_quantities(case: EntrainmentCase, findings: Findings) -> list[Quantity]:
    """Return the motion at the nominal value, and the least vibration that entrains."""
    machine, nominal_run, motion, angle = case.machine, findings.nominal_run, findings.nominal_motion, _angle(case)
    phases, mean = _phases(case, findings), None if nominal_run is None else nominal_run.mean_speed
    averaged_phases = {name: float(_wrap_phases(machine, phase)) for name, phase in findings.existing.phases.items()}
    speed = mean if motion is None or mean is None else math.copysign(motion.speed, mean)
    length = machine.orbit_unit if machine.shaken_coordinate is None else machine.parameters[AMPLITUDE].unit
    return [
        Quantity("phase", _single_or_all(phases), "phase, of several by body", angle),
        Quantity("phases", phases, "phases by body", angle),
        Quantity("phase_slow", _single_or_all(averaged_phases), "phase by the averaged equations, of several by body", angle),
        Quantity("phases_slow", averaged_phases, "phases by body by the averaged equations", angle),
        Quantity("mean_speed", speed, "mean speed of the main rotor", machine.units.speed),
        Quantity("window", nominal_run and list(nominal_run.window), "window of the means", machine.units.time),
        Quantity("stable", motion and motion.stable, "true if the locked motion is stable"),
        Quantity("multiplier", motion and motion.multiplier, "its largest multiplier, without those that are always 1"),
        Quantity("threshold_amplitude", findings.threshold, "least amplitude of the vibration that entrains", length),
    ]


def _angle(case: EntrainmentCase) -> str:
    """Return the unit of angles."""
    return "rad" if case.machine.units.time else ""


def _phases(case: EntrainmentCase, findings: Findings) -> dict[str, float]:
    """Return the phases by body: of the locked motion, else at the end of the run where that is entrained."""
    names, nominal_run, motion = bodies_with_phase(case.machine), findings.nominal_run, findings.nominal_motion
    if motion is not None:
        return dict(zip(names, _wrap_phases(case.machine, motion.phases).tolist(), strict=True))
    if nominal_run is None or not nominal_run.is_entrained:
        return {}
    if "vibration" in nominal_run.phases:
        return {names[0]: float(_wrap_phases(case.machine, nominal_run.phases["vibration"]))}
    return dict(nominal_run.phases)


def _single_or_all(phases: dict[str, float]) -> float | dict[str, float] | None:
    """Return the phase where there is a single one, else all by name; None where there is none."""
    return next(iter(phases.values())) if len(phases) == 1 else phases or None


def _outcome(case: EntrainmentCase, findings: Findings) -> Outcome:
    if findings.nominal_run is None:
        return Outcome.UNIDENTIFIED
    if findings.failure is not None:
        return Outcome.FAILED
    if case.machine.shaken_coordinate is not None:
        return Outcome.ENTRAINED if findings.nominal_run.is_entrained else Outcome.NOT_ENTRAINED
    return Outcome.SYNCHRONISED if findings.nominal_run.is_entrained else Outcome.NOT_SYNCHRONISED


def _sentence(case: EntrainmentCase, findings: Findings, outcome: Outcome) -> str:
    if findings.failure is not None:
        return findings.failure
    if findings.band is None:
        interruption = "the study was interrupted before its band was determined"
        nowhere = "it is not reached from the start anywhere in the range"
        return f"{outcome.sentence}; {nowhere if findings.complete else interruption}"
    band = band_in_words(findings.band.edges, case.parameter.unit, f"{case.parameter.name} = ")
    return f"{outcome.sentence}; this is reached from the start {band}"


def _warnings(case: EntrainmentCase, findings: Findings) -> list[str]:
    """Return warnings on doubtful, omitted or unfinished results."""
    parameter, runs = case.parameter, findings.runs
    unit = f" {parameter.unit}" if parameter.unit else ""
    lines = [*findings.existing.warnings, *(f"at {parameter.name} = {r.value:.6g}: {r.failure}" for r in runs if r.failure)]
    lines += [findings.no_motion] if findings.no_motion is not None else []
    if not findings.complete and findings.failure is None:
        lines.append(f"{len(runs)} runs from the start are finished, but the search is not")
    if findings.band is not None and findings.band.islands:
        location = ", ".join(f"{low:.5g} to {high:.5g}" for low, high in findings.band.islands)
        lines.append(f"from the start it is also reached outside the band: {location}{unit}; finer points may show more")
    moving = next((r for r in runs if r.is_entrained and r.creep > _CREEP_LIMIT), None)
    if moving is not None:
        location = f"{parameter.name} = {moving.value:.6g}{unit}"
        lines.append(f"at {location} the phase still moves at the end of the run: give a longer study.until")
    return lines


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for the study ``entrainment``."""
    s, lines = result.wucht.summary, ReportLines(result)
    unit = f" {s['along_unit']}" if s["along_unit"] else ""
    words = partial(band_in_words, unit=s["along_unit"], digits=7)
    lines.add("parameter", "{along} = {value:.6g}")
    if s["existence_band"] is not None:
        kinds = dict.fromkeys(k for k in s["existence_edges"] if k != "range")
        end_kinds = f", ends: {', '.join(kinds)}" if kinds else ""
        lines.add("existence", f"{words(s['existence_band'])} (averaged equations{end_kinds})")
    if s["existence_band_full"] is not None:
        lines.add("", f"{words(s['existence_band_full'])} (full equations)")
    if s["band_from_rest"] is not None:
        lines.add("from start", f"{words(s['band_from_rest'])}, edges to {{resolution:.1e}}")
    for low, high in s["islands"]:
        lines.add("also", f"{low:.6g} to {high:.6g}{unit}")
    for body, phase in s["phases"].items():
        averaged_phase = s["phases_slow"].get(body)
        beside = "" if averaged_phase is None else f", averaged equations {_angle_in_words(result, averaged_phase)}"
        lines.add("phase", f"{body}: {_angle_in_words(result, phase)}{beside}")
    lines.add("mean speed", "{mean_speed}")
    lines.add("stability", f"{'stable' if s['stable'] else 'not stable'}: largest multiplier of a period {{multiplier:.4g}}")
    lines.add("threshold", "the vibration must be larger than {threshold_amplitude} (averaged equations)")
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}")


def band_in_words(band: Sequence[float | None], unit: str, prefix: str = "", digits: int = 6) -> str:
    """Return a band (low, high) in words, None for an end beyond the range. prefix: written before its first value."""
    low, high = (None if edge is None else f"{edge:.{digits}g}" for edge in band)
    end = f" {unit}" if unit else ""
    if low is None:
        return "in the whole range" if high is None else f"below {prefix}{high}{end}"
    return f"above {prefix}{low}{end}" if high is None else f"between {prefix}{low} and {high}{end}"


def _angle_in_words(result: xr.Dataset, value: float) -> str:
    return f"{value:.5g}" if result.attrs["dimensionless"] else f"{value:.5g} rad ({math.degrees(value):.4g}°)"
