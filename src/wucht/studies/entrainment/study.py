"""The question of the band of a parameter in which rotors are entrained, and its answer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from wucht.analysis.synchronising_torque import has_exciters
from wucht.dynamics.entrainment.entrainment_case import AMPLITUDE, EntrainmentCase, check_entrainable, swept_parameter
from wucht.dynamics.entrainment.existence import RANGE, Existence, existence, range_around, threshold
from wucht.dynamics.entrainment.locked_motions import LockedMotion, LockedMotions, bodies_with_phase
from wucht.dynamics.entrainment.runs_from_start import CaptureBand, RunFromStart, RunsFromStart, capture_band, senses_of
from wucht.dynamics.parameters import range_of
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work, result_or_reason
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_angle
from wucht.results.formatting import band_in_words
from wucht.schema import SI, Composite, Unit, article, composite, read_quantity, si
from wucht.studies.answer import Answer
from wucht.studies.entrainment.figure import figure
from wucht.studies.key_types import Pair, Path, Start, Value, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

DEFAULT_POINTS = 25
_FEWEST, _MOST = 5, 2000
_RESOLUTION = 1e-5  # of the range
_TOO_SHORT = 1.5  # ratio of required to actual duration beyond which a run is repeated


class Entrainment(Study):
    """Band of a parameter in which rotors are entrained by a vibration or by each other, and their phases."""

    kind = "entrainment"
    next_questions = (
        NextQuestion("all steady phases, and which of them are stable", {"study.kind": "synchronous-states"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves = f"{FULL_EQUATIONS} for the runs, {AVERAGED_EQUATIONS} for the band of existence"
    from_start = True

    along: Path | None = Field(
        default=None,
        title="path of a parameter, or 'detuning': no-load speed of the second motor less the first",
        description='path of a parameter, or `"detuning"`, the no-load speed of the second rotor\'s motor less that of '
        "the first, each counted in its sense of rotation, at the same mean: positive where the second "
        "would be faster; by default the no-load speed of the main rotor's drive; for two exciters "
        '`"detuning"`; for a rotor without a drive the amplitude of the vibration',
    )
    range: Composite[Pair | None] = composite(
        default=None, description="pair [low, high] of it; by default the band of existence with a margin"
    )
    points: Whole = Field(default=DEFAULT_POINTS, description="number of runs from the start, evenly over the range")
    resolution: Value | None = Field(default=None, description="resolution of the edges, in the parameter's unit")
    start: Composite[Start] = composite(default_factory=dict)
    until: SI[float | None] = si(
        "s", "time", default=None, gt=0, help="least duration of a run; by default from the averaged equations"
    )

    def check(self) -> None:
        """Check the number of points."""
        if not _FEWEST <= self.points <= _MOST:
            raise InputError("study.points", self.points, f"must be a whole number from {_FEWEST} to {_MOST}")

    def prepare(self, machine: Machine) -> EntrainmentCase:
        """Return the case. Raises ``InputError`` where the study does not fit the machine."""
        check_entrainable(machine)
        parameter = swept_parameter(machine, self.along)
        unit = Unit(parameter.unit, parameter.description)
        range_ = None if self.range is None else range_of(unit, self.range)
        resolution = None if self.resolution is None else read_quantity(unit, self.resolution, "study.resolution")
        if resolution is not None and resolution <= 0:
            raise InputError("study.resolution", self.resolution, f"must be {article(unit.long_name)} greater than 0")
        return EntrainmentCase.of(machine, parameter, self.start, self.points, range_, resolution, self.until)

    def solve(self, machine: Machine, case: EntrainmentCase, work: Work) -> Iterator[Answer]:
        """Make runs over the parameter, and follow the locked motions; an answer after each run and each motion."""
        fill, nominal_value = partial(_state_entrainment, case=case, existing=Existence()), case.parameter.nominal_value
        units = case.machine.units
        yield Answer(units, fill)
        runs = RunsFromStart(case)
        nominal_run = runs.run(nominal_value, work.part("own", 0.0, 0.03))
        yield Answer(units, partial(fill, nominal_run=nominal_run))
        if nominal_run.failure is not None:
            return
        senses = senses_of(case.machine, case.initial, nominal_run)
        try:
            existing = existence(case, nominal_run, senses, work.part("existence", 0.03, 0.1))
        except InputError as error:
            existing = Existence(warnings=(f"the averaged equations are left out: {error.explanation}",))
        limits = low, high = case.range or range_around(case, existing.band)
        resolution = case.resolution or _RESOLUTION * (high - low)
        runs = RunsFromStart(case, senses, existing.slowest_rate)
        if runs.duration > _TOO_SHORT * nominal_run.end_time:
            nominal_run = runs.run(nominal_value, work.part("own, longer", 0.1, 0.1))
        fill = partial(fill, nominal_run=nominal_run, limits=limits, resolution=resolution, existing=existing)
        yield Answer(units, fill)
        for done in runs.search(nominal_run, limits, resolution, work.part("runs", 0.1, 0.8)):
            yield Answer(units, partial(fill, runs=done))
        fill = partial(fill, runs=done, band=capture_band(done, nominal_value))
        entrained_runs = [r for r in done if r.is_entrained]
        if entrained_runs:
            nearest = min(entrained_runs, key=lambda r: abs(r.value - nominal_value))
            motion_solver = LockedMotions(case, senses, nearest.end_time)
            at_end = partial(motion_solver.motion, nearest.value, nearest.end_state, abs(nearest.mean_speed))
            seed = work.unit("locked motion", partial(result_or_reason, at_end))
            if isinstance(seed, str):
                fill = partial(fill, no_motion=f"at {case.parameter.name} = {nearest.value:.6g}: {seed}")
            else:
                fill = partial(fill, motions=(seed,))
                yield Answer(units, fill)
                band = existing.band
                edges = limits if band is None else (max(low, band.ends[0]), min(high, band.ends[1]))
                for motions, ends in motion_solver.follow_both_ways(seed, limits, edges, resolution, work):
                    fill = partial(fill, motions=motions, ends=ends)
                    yield Answer(units, fill)
        least = threshold(case, existing, work.part("threshold", 0.95, 1.0))
        work.report(1.0)
        yield Answer(units, partial(fill, least=least, is_complete=True))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw phases and speed over the parameter, and the bands."""
        return figure(result)


def _state_entrainment(
    a: Answer,
    case: EntrainmentCase,
    existing: Existence,
    nominal_run: RunFromStart | None = None,
    limits: tuple[float, float] | None = None,
    resolution: float = 0.0,
    runs: Sequence[RunFromStart] = (),
    band: CaptureBand | None = None,
    motions: Sequence[LockedMotion] = (),
    ends: tuple[float | None, float | None] = (None, None),
    no_motion: str | None = None,
    least: float | None = None,
    is_complete: bool = False,
) -> None:
    """Phases: of rotors relative to the main one, of it to the vibration, of bodies to their rotor.

    nominal_run: at the nominal value of the parameter; if it failed, no search follows. limits, resolution: of the parameter.
    runs, motions: in increasing order of their value. ends: of the motions below and above, None where beyond the range.
    no_motion: reason why there are none. least: amplitude of the vibration that entrains.
    """
    machine, parameter = case.machine, case.parameter
    entrained_value = nominal_run.value if nominal_run is not None and nominal_run.is_entrained else None
    outcome = Outcome.UNIDENTIFIED
    if nominal_run is not None and nominal_run.failure is not None:
        outcome, a.failure = Outcome.FAILED, nominal_run.failure
    elif nominal_run is not None and machine.shaken_coordinate is not None:
        outcome = Outcome.NOT_ENTRAINED if entrained_value is None else Outcome.ENTRAINED
    elif nominal_run is not None:
        outcome = Outcome.NOT_SYNCHRONISED if entrained_value is None else Outcome.SYNCHRONISED
    a.attribute(along=parameter.name, along_unit=parameter.unit, along_what=parameter.description)
    if machine.shaking_frequency is not None:
        a.attribute(frequency=machine.shaking_frequency)
    a.warn(*existing.warnings, *(f"at {parameter.name} = {r.value:.6g}: {r.failure}" for r in runs if r.failure))
    a.warn(*([no_motion] if no_motion is not None else []))
    if not is_complete and a.failure is None:
        a.warn(f"{len(runs)} runs from the start are finished, but the search is not")
    a.number("outcome", str(outcome), "outcome")
    _state_parameter(a, case, limits)
    _state_existence(a, parameter.unit, existing, ends if motions else None)
    _state_capture(a, parameter.unit, band, resolution)
    nominal_motion = next((m for m in motions if m.value == entrained_value), None)
    _state_nominal_motion(a, machine, nominal_run, nominal_motion, existing)
    length = machine.orbit_unit if machine.shaken_coordinate is None else machine.parameters[AMPLITUDE].unit
    a.number("threshold_amplitude", least, "least amplitude of the vibration that entrains", length)
    a.line("threshold", "the vibration must be larger than {threshold_amplitude} (averaged equations)")
    if has_exciters(machine):
        a.line("margin", "what torque can pass between the rotors, and what has to: study.kind = 'synchronous-states'")
    _state_motions(a, case, existing, motions)
    _state_runs(a, case, runs or (() if nominal_run is None else (nominal_run,)))
    capture = "the study was interrupted before its band was determined"
    if band is not None:
        capture = f"this is reached from the start {band_in_words(band.edges, parameter.unit, f'{parameter.name} = ')}"
    elif is_complete:
        capture = "it is not reached from the start anywhere in the range"
    a.sentence = a.failure or f"{outcome.sentence}; {capture}"
    a.verdict = f"{str(outcome).upper()}: {a.sentence}"


def _state_parameter(a: Answer, case: EntrainmentCase, limits: tuple[float, float] | None) -> None:
    parameter = case.parameter
    a.number("along", parameter.name, "swept parameter")
    a.number("along_unit", parameter.unit, "unit of the swept parameter")
    a.number("value", parameter.nominal_value, "nominal value of the parameter", parameter.unit)
    a.line("parameter", "{along} = {value:.6g}")
    a.number("range", limits and list(limits), "lowest and highest value of the parameter", parameter.unit)


def _state_existence(a: Answer, unit: str, existing: Existence, ends: tuple[float | None, float | None] | None) -> None:
    """State the bands of the averaged equations and, by its ends, of the full ones. An end beyond the range is None."""
    band, edges = existing.band, None
    if band is not None:
        edges = [None if kind == RANGE else value for value, kind in zip(band.ends, band.kinds, strict=True)]
        kinds = dict.fromkeys(kind for kind in band.kinds if kind != RANGE)
        end_kinds = f", ends: {', '.join(kinds)}" if kinds else ""
        a.line("existence", f"{band_in_words(edges, unit, digits=7)} (averaged equations{end_kinds})")
    a.number("existence_band", edges, "band in which the entrained motion exists and is stable", unit)
    a.number("existence_band_from", band and "averaged equations", "equations of that band")
    a.number("existence_edges", band and list(band.kinds), "kinds of the ends of that band")
    a.number("branch", band and band.branch, "branch of that band")
    a.number("existence_band_full", ends and list(ends), "band by the full equations", unit)
    if ends is not None:
        a.line("", f"{band_in_words(ends, unit, digits=7)} (full equations)")


def _state_capture(a: Answer, unit: str, band: CaptureBand | None, resolution: float) -> None:
    """State the band that is reached from the start."""
    islands = [] if band is None else [list(i) for i in band.islands]
    a.number("band_from_rest", band and list(band.edges), "band of entrainment from the start", unit)
    a.number("islands", islands, "intervals outside that band in which it is reached", unit)
    a.number("resolution", resolution, "resolution of the edges", unit)
    if band is not None:
        a.line("from start", f"{band_in_words(band.edges, unit, digits=7)}, edges to {{resolution:.1e}}")
    for low, high in islands:
        a.line("also", f"{low:.6g} to {high:.6g} {unit}".rstrip())
    if islands:
        location = f"{', '.join(f'{low:.5g} to {high:.5g}' for low, high in islands)} {unit}".rstrip()
        a.warn(f"from the start it is also reached outside the band: {location}; finer points may show more")


def _state_nominal_motion(
    a: Answer, machine: Machine, run: RunFromStart | None, motion: LockedMotion | None, existing: Existence
) -> None:
    """State the motion at the nominal value: the locked one, else that at the end of the run where that is entrained."""
    names, angle, phases = bodies_with_phase(machine), _angle(machine), dict[str, float]()
    if motion is not None:
        phases = dict(zip(names, _wrap_phases(machine, motion.phases).tolist(), strict=True))
    elif run is not None and run.is_entrained and "vibration" in run.phases:
        phases = {names[0]: float(_wrap_phases(machine, run.phases["vibration"]))}
    elif run is not None and run.is_entrained:
        phases = dict(run.phases)
    averaged_phases = {name: float(_wrap_phases(machine, phase)) for name, phase in existing.phases.items()}
    averaged = "phase by the averaged equations, of several by body"
    a.number("phase", _single_or_all(phases), "phase, of several by body", angle)
    a.number("phases", phases, "phases by body", angle)
    a.number("phase_slow", _single_or_all(averaged_phases), averaged, angle)
    a.number("phases_slow", averaged_phases, "phases by body by the averaged equations", angle)
    for body, phase in phases.items():
        averaged_phase = averaged_phases.get(body)
        beside = "" if averaged_phase is None else f", averaged equations {_angle_in_words(machine, averaged_phase)}"
        a.line("phase", f"{body}: {_angle_in_words(machine, phase)}{beside}")
    mean = None if run is None else run.mean_speed
    speed = mean if motion is None or mean is None else math.copysign(motion.speed, mean)
    a.number("mean_speed", speed, "mean speed of the main rotor", "speed")
    a.line("mean speed", "{mean_speed}")
    a.number("window", run and list(run.window), "window of the means", "time")
    a.number("stable", motion and motion.stable, "true if the locked motion is stable")
    a.number("multiplier", motion and motion.multiplier, "its largest multiplier, without those that are always 1")
    stability = "stable" if motion is not None and motion.stable else "not stable"
    a.line("stability", f"{stability}: largest multiplier of a period {{multiplier:.4g}}")


def _state_motions(a: Answer, case: EntrainmentCase, existing: Existence, motions: Sequence[LockedMotion]) -> None:
    """State the motions of the averaged equations (point), and the locked motions of the full ones (orbit)."""
    machine, what, unit, branches = case.machine, case.parameter.description, case.parameter.unit, existing.branches
    names, equations, angle = bodies_with_phase(machine), existing.equations, _angle(machine)
    sizes = [len(b.kinds) for b in branches]
    phases, speeds = np.full((len(names), sum(sizes)), np.nan), np.empty(0)
    if equations is not None and branches:
        states = np.concatenate([b.unknowns[:-1] for b in branches], axis=1)
        speeds = equations.speed(states)
        for name, row in equations.phase_rows.items():
            phases[names.index(name)] = _wrap_phases(machine, states[row])
    values = np.concatenate([np.empty(0), *(b.parameter_values for b in branches)])
    stable = np.concatenate([np.empty(0), *(b.stable for b in branches)])
    orbit_phases = np.array([_wrap_phases(machine, m.phases) for m in motions]).reshape(len(motions), len(names)).T
    a.curve("body", names or np.empty(0, "U1"), "body")
    a.curve("value", values, what, unit, "point")
    a.curve("phase", phases, "phase", angle, "body point")
    a.curve("speed", speeds, "speed", "speed", "point")
    a.curve("stable", stable.astype(np.int8), "stable", "", "point")
    a.curve("branch", np.repeat(np.arange(len(sizes)), sizes), "branch", "", "point")
    a.curve("orbit_value", [m.value for m in motions], what, unit, "orbit")
    a.curve("orbit_phase", orbit_phases, "phase", angle, "body orbit")
    a.curve("orbit_speed", [m.speed for m in motions], "speed", "speed", "orbit")
    a.curve("orbit_stable", np.array([m.stable for m in motions], np.int8), "stable", "", "orbit")
    a.curve("orbit_multiplier", [m.multiplier for m in motions], "largest multiplier", "", "orbit")


def _state_runs(a: Answer, case: EntrainmentCase, runs: Sequence[RunFromStart]) -> None:
    """State the runs from the start. run_taken: 1 where the rotors end entrained."""
    machine, angle, names = case.machine, _angle(case.machine), [r.name for r in case.machine.rotors]

    def rows(count: int, of_runs: Sequence[Any]) -> np.ndarray:
        """Return several numbers of each run, (count, run)."""
        return np.array(of_runs, float).reshape(len(runs), count).T

    speeds = rows(len(names), [[r.speeds.get(n, math.nan) for n in names] for r in runs])
    phases = rows(len(names), [[r.phases.get(k, math.nan) for k in ("vibration", *names[1:])] for r in runs])
    a.curve("run_value", [r.value for r in runs], case.parameter.description, case.parameter.unit, "run")
    a.curve("run_taken", np.array([r.is_entrained for r in runs], np.int8), "entrained", "", "run")
    a.curve("run_speed", [abs(r.mean_speed) for r in runs], "mean speed", "speed", "run")
    a.curve("run_mean_speed", [r.mean_speed for r in runs], "mean speed", "speed", "run")
    a.curve("run_drift", [r.creep for r in runs], "creep of the phase", angle, "run")
    a.curve("run_until", [r.until for r in runs], "prescribed duration", "time", "run")
    a.curve("run_end_time", [r.end_time for r in runs], "end", "time", "run")
    a.curve("run_failed", np.array([r.failure or "" for r in runs], str), "reason why the run failed", "", "run")
    a.curve("run_window", rows(2, [r.window for r in runs]), "window of the means", "time", "end run")
    a.curve("run_rotor_speed", speeds, "mean speed", "speed", "rotor run")
    a.curve("run_rotor_phase", phases, "phase", angle, "rotor run")
    states = rows(len(machine.state_names), [r.end_state for r in runs])
    a.curve("run_end_state", states, "state at the end", "", "state run")
    a.curve("free_speed", np.array([r.free_speed for r in runs], float), "speed without vibration", "speed", "run")


def _angle(machine: Machine) -> str:
    """Return the unit of angles."""
    return "rad" if machine.units.time else ""


def _angle_in_words(machine: Machine, value: float) -> str:
    return f"{value:.5g}" if machine.dimensionless else f"{value:.5g} rad ({math.degrees(value):.4g}°)"


def _wrap_phases(machine: Machine, phases: Any) -> np.ndarray:
    """Wrap phases: relative to a vibration into (-pi, pi], as in 001 (22), relative to a rotor into [0, 2 pi)."""
    return math.pi - wrap_angle(math.pi - phases) if machine.shaken_coordinate is not None else wrap_angle(phases)


def _single_or_all(phases: dict[str, float]) -> float | dict[str, float] | None:
    """Return the phase where there is a single one, else all by name; None where there is none."""
    return next(iter(phases.values())) if len(phases) == 1 else phases or None
