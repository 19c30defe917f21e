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
from wucht.numerics.angles import wrapped
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, answer
from wucht.studies.entrainment.computation import Findings

if TYPE_CHECKING:
    import xarray as xr


_CREEPING = 0.02  # rad: a phase that moves further in the second half of the window is not steady yet


def dataset(case: EntrainmentCase, findings: Findings) -> xr.Dataset:
    """Return the Dataset. Phases of rotors are relative to the main one, its phase to the vibration, bodies to their rotor."""
    swept, frequency, outcome = case.swept, case.machine.shaking_frequency, _outcome(case, findings)
    runs = findings.runs or (() if findings.own is None else (findings.own,))
    quantities = [
        Quantity("outcome", str(outcome), "outcome"),
        *_of_bands(case, findings),
        *_of_machine(case, findings),
        *_of_motions(case, findings),
        *_of_runs(case, runs),
    ]
    return answer(
        quantities, _sentence(case, findings, outcome), _warnings(case, findings), (), findings.failure,
        along=swept.name, along_unit=swept.unit, along_what=swept.what,
        **({} if frequency is None else {"frequency": frequency}),
    )  # fmt: skip


def _in_a_turn(machine: Machine, phases: Any) -> np.ndarray:
    """Wrap phases: relative to a vibration into (-pi, pi], as in 001 (22), relative to a rotor into [0, 2 pi)."""
    return math.pi - wrapped(math.pi - phases) if machine.shaken is not None else wrapped(phases)


def _of_motions(case: EntrainmentCase, findings: Findings) -> list[Quantity]:
    """Return the motions of the averaged equations (point), and the locked motions of the full ones (orbit)."""
    machine, swept, motions, branches = case.machine, case.swept, findings.motions, findings.existing.branches
    names, equations, speed, angle = bodies_with_phase(machine), findings.existing.equations, machine.units.speed, _angle(case)
    sizes = [len(b.values) for b in branches]
    phases, speeds = np.full((len(names), sum(sizes)), np.nan), np.empty(0)
    if equations is not None and branches:
        states = np.concatenate([b.states for b in branches], axis=1)
        speeds = equations.speed(states)
        for name, row in equations.phase_rows.items():
            phases[names.index(name)] = _in_a_turn(machine, states[row])
    values, stable = (np.concatenate([np.empty(0), *(getattr(b, n) for b in branches)]) for n in ("values", "stable"))
    locked = np.array([_in_a_turn(machine, m.phases) for m in motions]).reshape(len(motions), len(names)).T
    return [
        Quantity("body", names or np.empty(0, "U1"), "body", "", "body"),
        Quantity("value", values, swept.what, swept.unit, "point"),
        Quantity("phase", phases, "phase", angle, "body point"),
        Quantity("speed", speeds, "speed", speed, "point"),
        Quantity("stable", stable.astype(np.int8), "stable", "", "point"),
        Quantity("branch", np.repeat(np.arange(len(sizes)), sizes), "branch", "", "point"),
        Quantity("orbit_value", [m.value for m in motions], swept.what, swept.unit, "orbit"),
        Quantity("orbit_phase", locked, "phase", angle, "body orbit"),
        Quantity("orbit_speed", [m.speed for m in motions], "speed", speed, "orbit"),
        Quantity("orbit_stable", np.array([m.stable for m in motions], np.int8), "stable", "", "orbit"),
        Quantity("orbit_multiplier", [m.multiplier for m in motions], "largest multiplier", "", "orbit"),
    ]


def _of_runs(case: EntrainmentCase, runs: Sequence[RunFromStart]) -> list[Quantity]:
    """Return the runs from the start. run_taken: 1 where the rotors end entrained."""
    machine, swept, units = case.machine, case.swept, case.machine.units
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
        Quantity("run_value", [r.value for r in runs], swept.what, swept.unit, "run"),
        Quantity("run_taken", np.array([r.entrained for r in runs], np.int8), "entrained", "", "run"),
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


def _of_bands(case: EntrainmentCase, findings: Findings) -> list[Quantity]:
    """Return the swept parameter and the bands of entrainment. An end beyond the range is None."""
    band, capture, swept, unit = findings.existing.band, findings.band, case.swept, case.swept.unit
    edges = None if band is None else [None if e.kind == "range" else e.value for e in (band.low, band.high)]
    islands = [] if capture is None else [list(i) for i in capture.islands]
    return [
        Quantity("along", swept.name, "swept parameter"),
        Quantity("along_unit", unit, "unit of the swept parameter"),
        Quantity("value", swept.own, "nominal value of the parameter", unit),
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


def _of_machine(case: EntrainmentCase, findings: Findings) -> list[Quantity]:
    """Return the motion at the nominal value, and the least vibration that entrains."""
    machine, own, motion, angle = case.machine, findings.own, findings.own_motion, _angle(case)
    phases, mean = _phases(case, findings), None if own is None else own.mean_speed
    averaged = {name: float(_in_a_turn(machine, phase)) for name, phase in findings.existing.phases.items()}
    speed = mean if motion is None or mean is None else math.copysign(motion.speed, mean)
    length = machine.orbit_unit if machine.shaken is None else machine.parameters[AMPLITUDE].unit
    return [
        Quantity("phase", _only(phases), "phase, of several by body", angle),
        Quantity("phases", phases, "phases by body", angle),
        Quantity("phase_slow", _only(averaged), "phase by the averaged equations, of several by body", angle),
        Quantity("phases_slow", averaged, "phases by body by the averaged equations", angle),
        Quantity("mean_speed", speed, "mean speed of the main rotor", machine.units.speed),
        Quantity("window", own and list(own.window), "window of the means", machine.units.time),
        Quantity("stable", motion and motion.stable, "true if the locked motion is stable"),
        Quantity("multiplier", motion and motion.multiplier, "its largest multiplier, without those that are always 1"),
        Quantity("threshold_amplitude", findings.threshold, "least amplitude of the vibration that entrains", length),
    ]


def _angle(case: EntrainmentCase) -> str:
    """Return the unit of angles."""
    return "rad" if case.machine.units.time else ""


def _phases(case: EntrainmentCase, findings: Findings) -> dict[str, float]:
    """Return the phases by body: of the locked motion, else at the end of the run where that is entrained."""
    names, own, motion = bodies_with_phase(case.machine), findings.own, findings.own_motion
    if motion is not None:
        return dict(zip(names, _in_a_turn(case.machine, motion.phases).tolist(), strict=True))
    if own is None or not own.entrained:
        return {}
    if "vibration" in own.phases:
        return {names[0]: float(_in_a_turn(case.machine, own.phases["vibration"]))}
    return dict(own.phases)


def _only(phases: dict[str, float]) -> float | dict[str, float] | None:
    """Return the phase where there is a single one, else all by name; None where there is none."""
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
        interrupted = "the study was interrupted before its band was determined"
        nowhere = "it is not reached from the start anywhere in the range"
        return f"{outcome.sentence}; {nowhere if findings.complete else interrupted}"
    band = band_in_words(findings.band.edges, case.swept.unit, f"{case.swept.name} = ")
    return f"{outcome.sentence}; this is reached from the start {band}"


def _warnings(case: EntrainmentCase, findings: Findings) -> list[str]:
    """Return warnings on doubtful, omitted or unfinished results."""
    swept, runs = case.swept, findings.runs
    unit = f" {swept.unit}" if swept.unit else ""
    lines = [*findings.existing.warnings, *(f"at {swept.name} = {r.value:.6g}: {r.failure}" for r in runs if r.failure)]
    lines += [findings.no_motion] if findings.no_motion is not None else []
    if not findings.complete and findings.failure is None:
        lines.append(f"{len(runs)} runs from the start are finished, but the search is not")
    if findings.band is not None and findings.band.islands:
        where = ", ".join(f"{low:.5g} to {high:.5g}" for low, high in findings.band.islands)
        lines.append(f"from the start it is also reached outside the band: {where}{unit}; finer points may show more")
    moving = next((r for r in runs if r.entrained and r.creep > _CREEPING), None)
    if moving is not None:
        where = f"{swept.name} = {moving.value:.6g}{unit}"
        lines.append(f"at {where} the phase still moves at the end of the run: give a longer until")
    return lines


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for the study ``entrainment``."""
    s, lines = result.wucht.summary, ReportLines(result)
    unit = f" {s['along_unit']}" if s["along_unit"] else ""
    words = partial(band_in_words, unit=s["along_unit"], digits=7)
    lines.add("parameter", "{along} = {value:.6g}")
    if s["existence_band"] is not None:
        kinds = dict.fromkeys(k for k in s["existence_edges"] if k != "range")
        how = f", ends: {', '.join(kinds)}" if kinds else ""
        lines.add("existence", f"{words(s['existence_band'])} (averaged equations{how})")
    if s["existence_band_full"] is not None:
        lines.add("", f"{words(s['existence_band_full'])} (full equations)")
    if s["band_from_rest"] is not None:
        lines.add("from start", f"{words(s['band_from_rest'])}, edges to {{resolution:.1e}}")
    for low, high in s["islands"]:
        lines.add("also", f"{low:.6g} to {high:.6g}{unit}")
    for body, phase in s["phases"].items():
        averaged = s["phases_slow"].get(body)
        beside = "" if averaged is None else f", averaged equations {_angle_in_words(result, averaged)}"
        lines.add("phase", f"{body}: {_angle_in_words(result, phase)}{beside}")
    lines.add("mean speed", "{mean_speed}")
    lines.add("stability", f"{'stable' if s['stable'] else 'not stable'}: largest multiplier of a period {{multiplier:.4g}}")
    lines.add("threshold", "the vibration must be larger than {threshold_amplitude} (averaged equations)")
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}")


def band_in_words(band: Sequence[float | None], unit: str, what: str = "", digits: int = 6) -> str:
    """Return a band (low, high) in words, None for an end beyond the range. prefix: written before its first value."""
    low, high = (None if edge is None else f"{edge:.{digits}g}" for edge in band)
    end = f" {unit}" if unit else ""
    if low is None:
        return "in the whole range" if high is None else f"below {what}{high}{end}"
    return f"above {what}{low}{end}" if high is None else f"between {what}{low} and {high}{end}"


def _angle_in_words(result: xr.Dataset, value: float) -> str:
    return f"{value:.5g}" if result.attrs["dimensionless"] else f"{value:.5g} rad ({math.degrees(value):.4g}°)"
