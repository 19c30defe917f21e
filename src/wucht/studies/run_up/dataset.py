"""Findings -> the quantities of a run-up, of its end and its verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.analysis.throw import NUMBERS, Throw, largest_of
from wucht.dynamics.run_ups.bearing_loads import BearingLife, bearing_warnings, lives_at_end, loads_at_end
from wucht.dynamics.run_ups.contacts import ContactCheck, track_contacts
from wucht.dynamics.run_ups.hanging_start import hanging_words, is_hanging_start
from wucht.dynamics.run_ups.neighbours import Neighbour
from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import motion_of
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.machines.machine import MISMATCH
from wucht.machines.operation import natural_frequencies
from wucht.numerics.observers.records import smooth_weights
from wucht.numerics.zeros_and_peaks import extremes
from wucht.results.quantities import Quantity, StudyResult, dataset_from_quantities
from wucht.studies.bearing_variables import life_quantities, load_quantities
from wucht.studies.motion_variables import envelopes, motion_quantities
from wucht.studies.run_up.chance import with_neighbour
from wucht.studies.run_up.combined_runs import gather_runs, join_models
from wucht.studies.run_up.computation import Findings, Plan
from wucht.studies.run_up.system_run import SystemRunFindings, SystemRunPlan
from wucht.studies.run_up.system_run_result import system_run_dataset
from wucht.studies.starting_variables import start_warnings, starting_quantities

if TYPE_CHECKING:
    import xarray as xr

_FEWEST = 8  # samples
_KEYS = ("free_speed", "peak_amplitude")  # variables that are keys of the summary
_FEWEST_A_TURN = 8
_BALANCE_LIMIT = 1e-6  # an energy residual beyond it is reported as a warning


def _vibration_at_the_end(motion: Motion, result: xr.Dataset, noise: Noise, deck: float | None) -> list[Quantity]:
    """Return quantities of the carrier's centre of mass in the last window; none without units, or if it only turns."""
    machine, inside = motion.case.machine, _window(result, motion.verdict)
    ways = [d for d in "xy" if d in machine.labels]
    if not ways or machine.dimensionless or np.count_nonzero(inside) < _FEWEST:
        return []
    samples = result.isel(time=inside)
    place, velocity = (_plane(samples[name]) for name in ("displacement", "velocity"))
    throw = Throw.from_samples(samples.time.values, place, velocity, deck).beyond(noise.angle * motion.observation.largest)
    force = noise.without(largest_of(_plane(samples.bearing_force)), largest_of(_plane(result.bearing_force)))
    quantities = [
        Quantity("bearing_force", force, "largest force of all bodies together on the carrier", "N"),
        *(Quantity(n, x, *NUMBERS[n], headline=n == "machine_number") for n, x in throw.numbers.items()),
    ]
    if deck is not None:
        quantities += [
            Quantity("deck", deck, "inclination of the deck", "rad"),
            Quantity("throw_number", throw.throw_number(deck), "largest acceleration normal to the deck over that of gravity"),
        ]
    return quantities


def _plane(of: xr.DataArray) -> np.ndarray:
    """Return its components in x and y (2, N), zero where the carrier cannot move."""
    there = [str(d) for d in of.direction.values]
    zero = np.zeros(of.sizes["time"])
    return np.array([of.values[there.index(d)] if d in there else zero for d in "xy"])


def dataset(plan: Plan | SystemRunPlan, findings: Findings | SystemRunFindings) -> xr.Dataset:
    """Return the Dataset of one run, of one run of both models, or of many, with the dimension ``case``."""
    if isinstance(findings, SystemRunFindings):
        return system_run_dataset(findings)
    assert isinstance(plan, Plan)
    hanging = [is_hanging_start(case.run.machine, case.start) for case in plan.cases]
    runs = [
        _run_result(motions, neighbour, check, plan.spec.deck, hangs)
        for hangs, (motions, neighbour, check) in zip(
            hanging, zip_longest(findings.motions, findings.neighbours, findings.contact_checks), strict=False
        )
    ]
    return gather_runs(plan, runs, findings.finished_count) if plan.several else runs[0].to_dataset()


def _run_result(
    motions: Sequence[Motion], neighbour: Neighbour | None, check: ContactCheck | None, deck: float | None, hangs: bool
) -> StudyResult:
    """Return the result of one run, of all its models. neighbour, check: of the first. hangs: it starts at rest, hanging."""
    first, *averaged = motions
    results = [_motion_result(first, deck, hangs, check), *(_motion_result(m, deck, hangs) for m in averaged)]
    result = join_models(motions, results)
    if neighbour is None:
        return result
    return with_neighbour(result, _motion_result(neighbour.motion, deck, hangs), neighbour.growth)


def _motion_result(motion: Motion, deck: float | None, hangs: bool, check: ContactCheck | None = None) -> StudyResult:
    """Return the result for the motion of one model. hangs: the machine starts at rest, hanging."""
    machine, trajectory, verdict = motion.case.machine, motion.trajectory, motion.verdict
    quantities = motion_quantities(machine, motion.rows, motion.machine_motion, motion.observation.largest)
    limits = _observe_limits(motion) if _sampling_warnings(motion) else None
    quantities += [] if limits is None else envelopes(machine, motion.observation.main.last(1.0))
    result = dataset_from_quantities(quantities)
    residual = float(result.energy_residual.max())
    noise = Noise.of(motion.compiled_system.tolerance)
    summary = _summary(motion, result, limits, noise)
    summary += [Quantity("start_state", hanging_words(machine), "start of the machine")] if hangs else []
    summary += starting_quantities(machine.at(trajectory.end_time))
    lives = dict[str, BearingLife]()
    if motion.model.name == "full":
        lives = lives_at_end(machine, motion.machine_motion, verdict.window)
        loads = loads_at_end(machine, motion.machine_motion, verdict.window)
        summary += _vibration_at_the_end(motion, result, noise, deck)
        summary += load_quantities({name: load.beyond(noise) for name, load in loads.items()}) + life_quantities(lives)
        summary += _contact_quantities(motion) + ([] if check is None else _check_quantities(check))
    quantities = [replace(q, in_summary=q.name in _KEYS, headline=q.name == "peak_amplitude") for q in quantities]
    flow = {
        "engine": motion.compiled_system.engine_name,
        "tolerance": motion.compiled_system.tolerance,
        "model": motion.model.name,
    }
    end = {"outcome": str(verdict.outcome), "end_time": trajectory.end_time, "end_state": trajectory.end_state}
    warnings = _warnings(motion, residual) + bearing_warnings(lives)
    warnings += [check.warning()] if check is not None and check.is_stiffer else []
    return StudyResult([*summary, *quantities], verdict.sentence, warnings, (), trajectory.failure, flow | end)


def _warnings(motion: Motion, residual: float) -> list[str]:
    verdict, evidence, failure = motion.verdict, motion.verdict.evidence, motion.trajectory.failure
    run_warnings, horizon, unit = tuple[str, ...](), motion.case.horizon, motion.case.machine.units.time
    if motion.model is motion.case.models[0]:  # of both models the horizon is that of the full one
        limit_warnings = horizon.limit_warnings(motion.trajectory.end_time, verdict, unit)
        run_warnings = (*horizon.warnings, *_sampling_warnings(motion), *limit_warnings)
    warnings = [*run_warnings, *motion.model.warnings, *((*motion.model.remedies, failure) if failure else ())]
    if verdict.outcome is Outcome.PASSED and verdict.faster_branch:
        warnings.append(
            f"the rotor settled at {verdict.speed:.4g}, just beyond the maximum of the vibration torque at "
            f"{evidence.resonance:.4g}, although the drive could hold a higher speed too: this is the branch of the "
            "captured states, close to its end"
        )
    if motion.model.name == "full":  # averaged equations have no weight
        turning = {r.name for r in motion.case.machine.rotors} - set(verdict.not_started)
        warnings += start_warnings(motion.case.machine, motion.machine_motion.states[:, 0], turning)
    warnings += [verdict.advice] if verdict.advice else []
    warnings += [warning for contacts in track_contacts(motion).values() if (warning := contacts.warning())]
    if not residual <= _BALANCE_LIMIT:  # NaN does not close either
        warnings.append(
            f"the energy balance closes only to {residual:.1e}: the run is not accurate; look for a parameter or a start that "
            "is off by a factor of thousands, or give a smaller study.tolerance"
        )
    return warnings


def _sampling_warnings(motion: Motion) -> tuple[str, ...]:
    """Return a warning where the motion is stored with few samples a turn."""
    time, record, machine = motion.machine_motion.time, motion.machine_motion, motion.case.machine
    speeds = np.abs([motion_of(machine, record, b)[1] for b in machine.bodies]).max(axis=0)
    largest_angle = float((np.diff(time) * np.maximum(speeds[1:], speeds[:-1])).max(initial=0.0))
    samples = 2 * math.pi / largest_angle if largest_angle else math.inf
    if samples >= _FEWEST_A_TURN:
        return ()
    return (
        f"only {samples:.1f} samples a turn are stored, to keep the result below {motion.case.horizon.most} samples: "
        "its variables do not show the whole motion, but least_speed, greatest_speed, least_radius and greatest_radius show "
        "its limits; verdict, speeds and amplitudes of the summary do not depend on them. study.stored_samples sets the limit",
    )


@dataclass(frozen=True)
class _MotionLimits:
    """Limits of the integrated motion, in the window of the verdict: the least and the greatest speed of the main rotor, and
    of the amplitude the mean, the least and the greatest."""

    speeds: tuple[float, float]
    amplitudes: tuple[float, float, float]


def _observe_limits(motion: Motion) -> _MotionLimits:
    machine, verdict, spans = motion.case.machine, motion.verdict, motion.observation.main.last(1.0)
    turns = motion.observation.rotors[machine.rotor.name].whole
    begin, end = verdict.window
    inside, inside_turns = spans.time >= begin, (turns.time >= begin) & (turns.time <= end)
    inside[-1:] = True
    speeds = float(spans.least_speed[inside].min()), float(spans.greatest_speed[inside].max())
    if inside_turns.any():
        selection = slice(int(np.argmax(inside_turns)), None)
        return _MotionLimits(speeds, turns.part(selection).amplitudes)
    distance = spans.greatest_distance[inside]
    return _MotionLimits(speeds, (float(distance.mean()), float(distance.min()), float(distance.max())))


def _window(result: xr.Dataset, verdict: Verdict) -> np.ndarray:
    """True for the samples (N,) of the verdict."""
    time = result.time.values
    inside: np.ndarray = (time >= verdict.window[0]) & (time <= verdict.window[1])
    inside[-1] |= not inside.any()
    return inside


def _summary(motion: Motion, result: xr.Dataset, limits: _MotionLimits | None, noise: Noise) -> list[Quantity]:
    """Return the summary of the contract. limits: where the variables of the result are too few samples of the motion."""
    verdict, machine = motion.verdict, motion.case.machine.at(float(result.time.values[-1]))
    evidence, modulation, inside = verdict.evidence, verdict.modulation, _window(result, verdict)
    rotor = result.speed.sel(body=machine.rotor.name).values[inside]
    envelope, (low, high) = result.amplitude.values[inside], limits.speeds if limits else extremes(rotor)
    amplitudes = verdict.amplitudes or (limits.amplitudes if limits else None)
    values = amplitudes or [float(f(envelope)) for f in (np.mean, np.min, np.max)]
    amplitude, least, greatest = (noise.without(a, motion.observation.largest) for a in values)
    residual = None if verdict.residual is None else noise.without(verdict.residual, 1.0)
    if evidence.turning:
        mean = (float(np.sign(rotor.mean())) or 1.0) * verdict.speed
    else:
        weights = smooth_weights(len(rotor))
        mean = float(np.average(rotor, weights=weights if weights.any() else None))
    depth = (modulation.high - modulation.low) / (2 * abs(mean)) if modulation and mean else None
    speed, length, time = machine.units.speed, machine.orbit_unit, machine.units.time
    quantities = [
        Quantity("outcome", str(verdict.outcome), "outcome"),
        Quantity("final_speed", mean, "mean speed of the main rotor at the end", speed, headline=True),
        Quantity("min_speed", low, "least speed of the main rotor at the end", speed),
        Quantity("max_speed", high, "greatest speed of the main rotor at the end", speed),
        Quantity("final_amplitude", amplitude, "mean amplitude of the axis at the end", length, headline=True),
        Quantity("min_amplitude", least, "least amplitude of the axis at the end", length),
        Quantity("max_amplitude", greatest, "greatest amplitude of the axis at the end", length),
        Quantity("amplitude_unit", length, "unit of amplitudes"),
        Quantity("final_phases", verdict.phases, "mean phases of the bodies relative to their rotor at the end", "rad"),
        Quantity("final_residual_unbalance", residual, "residual share of the rotor's unbalance", headline=True),
        Quantity("settling_time", verdict.settling_time, "time until the speed has settled", time, headline=True),
        Quantity(
            "amplitude_settling_time", verdict.amplitude_settling_time, "time after which the amplitude has settled", time
        ),
        Quantity("modulation_period", modulation and modulation.period, "period of the modulation", time),
        Quantity("modulation_period_phi", modulation and modulation.period_angle, "angle of the rotor in that period", "rad"),
        Quantity("modulation_depth", depth, "share of the mean speed by which it is modulated to either side"),
        Quantity("energy_residual", float(result.energy_residual.max()), "largest relative error of the energy balance"),
        Quantity("damper_mismatch", _mismatch(result), "relative mismatch of damper torques that are not reciprocal"),
        Quantity("resonance_speed", evidence.resonance, "speed of the largest vibration torque", speed),
        Quantity("natural_frequencies", natural_frequencies(machine), "natural frequencies by mode", speed),
        Quantity("dimensionless", dimensionless_numbers(machine), "dimensionless numbers of the machine"),
        Quantity("advice", verdict.advice, "advice"),
        Quantity("advised_time", verdict.needed_time, "sufficient time", time),
    ]
    if verdict.unbalance_factor is not None:
        factor = noise.without(verdict.unbalance_factor, 1.0)
        quantities.append(Quantity("unbalance_factor", factor, "factor by which the bodies increase the rotor's unbalance"))
    if verdict.locking is not None:
        quantities += [
            Quantity("mean_speeds", verdict.locking.final_speeds, "mean speeds of the rotors", speed),
            Quantity("rotor_phases", verdict.locking.phases, "mean phases of the rotors", "rad"),
        ]
    if verdict.rotors:
        outcomes = {name: str(o) for name, o in verdict.rotors.items()}
        quantities.append(Quantity("rotor_outcomes", outcomes, "outcome of each rotor"))
    return quantities


def _contact_quantities(motion: Motion) -> list[Quantity]:
    """Return how stiff the contacts of balls are, and how far balls overlap in the run; nothing without tracks."""
    contacts = track_contacts(motion)
    overlaps = {name: c.overlap for name, c in contacts.items() if c.overlap is not None}
    lengths = {name: overlap * contacts[name].radius for name, overlap in overlaps.items()}
    frequencies = {name: c.frequency for name, c in contacts.items()}
    return [
        Quantity("contact_frequencies", frequencies, "frequencies of the contacts, by track", "rad/s"),
        Quantity("overlaps", overlaps, "largest overlaps of bodies in the run, as angles, by track", "rad"),
        Quantity("overlap_lengths", lengths, "largest overlaps of bodies in the run, by track", motion.case.machine.orbit_unit),
    ] if contacts else []  # fmt: skip


def _check_quantities(check: ContactCheck) -> list[Quantity]:
    """Return what contacts of another stiffness change."""
    stiffness = "four times as soft" if check.is_stiffer else "four times as stiff"
    outcome, condition = str(check.reference.verdict.outcome), f"with contacts {stiffness}"
    return [
        Quantity("contact_check", stiffness, "contacts of the run for comparison"),
        Quantity("contact_check_outcome", outcome, f"outcome {condition}"),
        Quantity("contact_check_amplitude", check.amplitude_change, f"change of the largest amplitude {condition}"),
        Quantity("contact_check_residual", check.residual_change, f"change of the residual unbalance {condition}"),
    ]


def _mismatch(result: xr.Dataset) -> float | None:
    return float(result[MISMATCH][-1]) if MISMATCH in result else None
