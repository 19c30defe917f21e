"""The answer of one run-up: its motion, its end and its verdict."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.analysis.synchronising_torque import SynchronisationMargin
from wucht.dynamics.run_ups.bearing_loads import BearingLife, bearing_warnings
from wucht.dynamics.run_ups.contacts import ContactCheck, track_contacts
from wucht.dynamics.run_ups.hanging_start import hanging_words
from wucht.dynamics.run_ups.motion_limits import amplitude_limits, speed_limits, stored_samples_per_turn
from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.machines.machine import MISMATCH, Machine
from wucht.machines.operation import natural_frequencies
from wucht.numerics.observers.records import smooth_weights
from wucht.numerics.zeros_and_peaks import extremes
from wucht.results.formatting import number_text
from wucht.studies.answer import Answer
from wucht.studies.motion_variables import envelopes, motion_quantities
from wucht.studies.run_up.vibration_answer import Mark, state_loads_of_run, state_vibration, verdict_window
from wucht.studies.starting_variables import start_warnings, state_starting_torques
from wucht.studies.synchronisation_variables import COLUMN, margin_in_words, synchronisation_columns

_KEYS = ("free_speed", "peak_amplitude")  # variables that are keys of the summary
_FEWEST_A_TURN = 8
_NEARLY = 0.1  # of their mean: difference of speeds of rotors that nearly turn synchronously
_BALANCE_LIMIT = 1e-6  # an energy residual beyond it is reported as a warning


def fill_motion(
    motion: Motion, deck: float | None, hangs: bool, a: Answer, check: ContactCheck | None = None, chance: Collection[str] = ()
) -> None:
    """State the motion of one model of a run.

    deck: as the key of the study. hangs: it starts at rest, hanging. check: of its contacts. chance: numbers that a neighbour
    does not confirm.
    """
    machine, trajectory, verdict = motion.case.machine, motion.trajectory, motion.verdict

    def mark(*keys: str) -> str:
        return " (one of many)" if any(key in chance for key in keys) else ""

    variables = motion_quantities(machine, motion.rows, motion.machine_motion, motion.observation.largest)
    samples = stored_samples_per_turn(motion)
    is_sparse = samples < _FEWEST_A_TURN  # then the variables are too few samples of the motion
    variables += envelopes(machine, motion.observation.main.last(1.0)) if is_sparse else []
    row, noise = {q.name: q.value for q in variables}, Noise.of(motion.compiled_system.tolerance)
    residual, at_end = float(np.fmax.reduce(row["energy_residual"])), machine.at(float(row["time"][-1]))
    a.sentence, a.failure = verdict.sentence, trajectory.failure
    a.verdict = f"{str(verdict.outcome).upper()}: {verdict.sentence}"
    a.attribute(
        engine=motion.compiled_system.engine_name,
        tolerance=motion.compiled_system.tolerance,
        model=motion.model.name,
        outcome=str(verdict.outcome),
        end_time=trajectory.end_time,
        end_state=trajectory.end_state,
    )
    _warn(a, motion, samples, residual)
    depth = _state_end(a, motion, row, is_sparse, noise, residual, mark)
    if motion.model.name == "full":
        _state_margin(a, at_end, verdict)
    if hangs:
        a.number("start_state", hanging_words(machine), "start of the machine")
    state_starting_torques(a, machine.at(trajectory.end_time))
    vibration = state_vibration(a, motion, row, noise, deck, mark) if motion.model.name == "full" else None
    peak = f", {{peak_amplitude}} at most{mark('peak_amplitude')}"
    a.line("amplitude", f"{{final_amplitude}} at the end{mark('final_amplitude')}{peak}")
    _tell_end(a, verdict, depth, mark)
    lives, is_alone = dict[str, BearingLife](), len(machine.rotors) == 1
    if is_alone:  # of exciters that run far above it, loads and lives are asked first
        _tell_resonance(a, at_end)
    if motion.model.name == "full":
        lives = state_loads_of_run(a, motion, vibration, deck, noise, mark)
    if verdict.outcome is Outcome.SYNCHRONISED:
        _tell_mean_speeds(a, verdict, mark)
    if not is_alone:
        _tell_resonance(a, at_end)
    numbers = dimensionless_numbers(at_end)
    if numbers and not machine.dimensionless:
        a.line("in numbers", ", ".join(f"{name} {value:.4g}" for name, value in numbers.items()))
    if motion.model.name == "full":
        _state_contacts(a, motion, mark)
        if check is not None:
            _state_check(a, check, verdict)
    a.line("energy", "balance closed to {energy_residual:.1e}")
    a.add(replace(q, in_summary=q.name in _KEYS, headline=q.name == "peak_amplitude") for q in variables)
    a.warn(*bearing_warnings(lives), *([check.warning()] if check is not None and check.is_stiffer else []))


def _tell_resonance(a: Answer, machine: Machine) -> None:
    """Add a line on the natural frequencies."""
    if natural_frequencies(machine):
        a.line("resonance", "{natural_frequencies}")


def _tell_mean_speeds(a: Answer, verdict: Verdict, mark: Mark) -> None:
    """Add a line on the speeds of several rotors."""
    if verdict.locking is not None and len(speeds := verdict.locking.final_speeds) > 1:
        listing = ", ".join(f"{name} {a.number_in_words(speed, 'speed')}" for name, speed in speeds.items())
        a.line("mean speeds", "{speeds}" + mark("mean_speeds"), speeds=listing)


def _warn(a: Answer, motion: Motion, samples: float, residual: float) -> None:
    """Warn of the run, of its verdict and of its accuracy. samples: stored in a turn."""
    verdict, evidence, failure = motion.verdict, motion.verdict.evidence, motion.trajectory.failure
    horizon, unit = motion.case.horizon, motion.case.machine.units.time
    if motion.model is motion.case.models[0]:  # of both models the horizon is that of the full one
        a.warn(*horizon.warnings)
        if samples < _FEWEST_A_TURN:
            a.warn(
                f"only {samples:.1f} samples a turn are stored, to keep the result below {horizon.most} samples: its variables "
                "do not show the whole motion, but least_speed, greatest_speed, least_radius and greatest_radius show its "
                "limits; verdict, speeds and amplitudes of the summary do not depend on them. study.stored_samples sets the "
                "limit"
            )
        a.warn(*horizon.limit_warnings(motion.trajectory.end_time, verdict, unit))
    a.warn(*motion.model.warnings, *((*motion.model.remedies, failure) if failure else ()))
    if verdict.outcome is Outcome.PASSED and verdict.faster_branch:
        a.warn(
            f"the rotor settled at {verdict.speed:.4g}, just beyond the maximum of the vibration torque at "
            f"{evidence.resonance:.4g}, although the drive could hold a higher speed too: this is the branch of the "
            "captured states, close to its end"
        )
    if motion.model.name == "full":  # averaged equations have no weight
        turning = {r.name for r in motion.case.machine.rotors} - set(verdict.not_started)
        a.warn(*start_warnings(motion.case.machine, motion.machine_motion.states[:, 0], turning))
    a.warn(*([verdict.advice] if verdict.advice else []))
    a.warn(*(warning for contacts in track_contacts(motion).values() if (warning := contacts.warning())))
    if not residual <= _BALANCE_LIMIT:  # NaN does not close either
        a.warn(
            f"the energy balance closes only to {residual:.1e}: the run is not accurate; look for a parameter or a start that "
            "is off by a factor of thousands, or give a smaller study.tolerance"
        )


def _state_end(
    a: Answer, motion: Motion, row: Mapping[str, Any], is_sparse: bool, noise: Noise, balance: float, mark: Mark
) -> float | None:
    """State the summary of the contract, and return the depth of the modulation.

    row: the variables of the result. is_sparse: they are too few samples. balance: error of the energy's.
    """
    verdict, machine = motion.verdict, motion.case.machine.at(float(row["time"][-1]))
    evidence, modulation, inside = verdict.evidence, verdict.modulation, verdict_window(row["time"], verdict)
    rotor = row["speed"][machine.bodies.index(machine.rotor)][inside]
    envelope, (low, high) = row["amplitude"][inside], speed_limits(motion) if is_sparse else extremes(rotor)
    amplitudes = verdict.amplitudes or (amplitude_limits(motion) if is_sparse else None)
    values = amplitudes or [float(f(envelope)) for f in (np.mean, np.min, np.max)]
    amplitude, least, greatest = (noise.without(a, motion.observation.largest) for a in values)
    residual = None if verdict.residual is None else noise.without(verdict.residual, 1.0)
    if evidence.turning:
        mean = (float(np.sign(rotor.mean())) or 1.0) * verdict.speed
    else:
        weights = smooth_weights(len(rotor))
        mean = float(np.average(rotor, weights=weights if weights.any() else None))
    depth = (modulation.high - modulation.low) / (2 * abs(mean)) if modulation and mean else None
    mismatch = float(row[MISMATCH][-1]) if MISMATCH in row else None
    length = machine.orbit_unit
    a.number("outcome", str(verdict.outcome), "outcome")
    a.number("final_speed", mean, "mean speed of the main rotor at the end", "speed", headline=True)
    a.number("min_speed", low, "least speed of the main rotor at the end", "speed")
    a.number("max_speed", high, "greatest speed of the main rotor at the end", "speed")
    a.number("final_amplitude", amplitude, "mean amplitude of the axis at the end", length, headline=True)
    a.number("min_amplitude", least, "least amplitude of the axis at the end", length)
    a.number("max_amplitude", greatest, "greatest amplitude of the axis at the end", length)
    a.number("amplitude_unit", length, "unit of amplitudes")
    a.number("final_phases", verdict.phases, "mean phases of the bodies relative to their rotor at the end", "rad")
    of_balancers = bool(verdict.phases)
    a.number("final_residual_unbalance", residual, "residual share of the rotor's unbalance", headline=of_balancers)
    a.number("settling_time", verdict.settling_time, "time until the speed has settled", "time", headline=True)
    of_amplitude = "time after which the amplitude has settled"
    a.number("amplitude_settling_time", verdict.amplitude_settling_time, of_amplitude, "time")
    a.number("modulation_period", modulation and modulation.period, "period of the modulation", "time")
    a.number("modulation_period_phi", modulation and modulation.period_angle, "angle of the rotor in that period", "rad")
    a.number("modulation_depth", depth, "share of the mean speed by which it is modulated to either side")
    a.number("energy_residual", balance, "largest relative error of the energy balance")
    a.number("damper_mismatch", mismatch, "relative mismatch of damper torques that are not reciprocal")
    a.number("resonance_speed", evidence.resonance, "speed of the largest vibration torque", "speed")
    a.number("natural_frequencies", natural_frequencies(machine), "natural frequencies by mode", "speed")
    a.number("dimensionless", dimensionless_numbers(machine), "dimensionless numbers of the machine")
    a.number("advice", verdict.advice, "advice")
    a.number("advised_time", verdict.needed_time, "sufficient time", "time")
    free, text = row["free_speed"], "{final_speed}"
    if free and math.isfinite(free):  # nothing drives a rotor that vibration sustains
        text += " of {free_speed} without vibration"
    if modulation is not None:
        text += ", modulated, between {min_speed} and {max_speed}"
    a.line("speed", text + mark("final_speed", *(("min_speed", "max_speed") if modulation is not None else ())))
    _state_rotors(a, verdict, noise, mark)
    return depth


def _state_rotors(a: Answer, verdict: Verdict, noise: Noise, mark: Mark) -> None:
    """State what the bodies do to the unbalance, and the speeds and phases of several rotors."""
    if verdict.unbalance_factor is not None:
        factor = noise.without(verdict.unbalance_factor, 1.0)
        a.number("unbalance_factor", factor, "factor by which the bodies increase the rotor's unbalance")
    if verdict.locking is not None:
        a.number("mean_speeds", verdict.locking.final_speeds, "mean speeds of the rotors", "speed")
        if verdict.outcome is not Outcome.SYNCHRONISED:
            _tell_mean_speeds(a, verdict, mark)
        phases = a.number("rotor_phases", verdict.locking.phases, "mean phases of the rotors", "rad")
        a.line("phase", "{phases}" + mark("rotor_phases"), phases=_angles(phases))
    if verdict.rotors:
        outcomes = {name: str(o) for name, o in verdict.rotors.items()}
        a.number("rotor_outcomes", outcomes, "outcome of each rotor")


def _state_margin(a: Answer, machine: Machine, verdict: Verdict) -> None:
    """State the margin of synchronism of exciters that turn synchronously, or of two that nearly do."""
    if verdict.outcome not in (Outcome.SYNCHRONISED, Outcome.NOT_SYNCHRONISED) or verdict.locking is None:
        return
    speeds = np.abs(list(verdict.locking.final_speeds.values()))
    # The torque that passes between two rotors varies with their phases as a sine: it is as large from any of them.
    if verdict.outcome is not Outcome.SYNCHRONISED and (len(speeds) > 2 or np.ptp(speeds) > _NEARLY * speeds.mean()):
        return
    margin = SynchronisationMargin.of(machine, float(speeds.mean()), verdict.locking.phases)
    if margin is not None:
        with a.group("synchronisation", "synchronism of the exciters"):
            for name, ((value,), words, *unit) in synchronisation_columns([margin]).items():
                a.number(name.removeprefix(COLUMN), value, words, *unit)
            a.line("synchronism", margin_in_words(margin, before=""))


def _tell_end(a: Answer, verdict: Verdict, depth: float | None, mark: Mark) -> None:
    """Add lines on the phases, the settling and the modulation at the end."""
    if verdict.phases:
        a.line("phases", "{phases}" + mark("final_phases"), phases=_angles(verdict.phases))
        remains = " remains" if verdict.unbalance_factor is None else ": more than without bodies"
        a.line("unbalance", f"{{final_residual_unbalance:%}} of the rotor's{remains}{mark('final_residual_unbalance')}")
    speed, amplitude = verdict.settling_time, verdict.amplitude_settling_time
    chance = mark("settling_time", "amplitude_settling_time")
    later = ", the speed" if amplitude is None else ""  # with lagging bodies the amplitude beats permanently
    if amplitude is not None and speed is not None and amplitude > speed:
        later = "; the amplitude at {amplitude_settling_time:.4g}"
    a.line("settled at", "{settling_time:.4g}" + later + chance)
    if (modulation := verdict.modulation) is not None:
        turns = modulation.period_angle / (2 * math.pi)
        period = f"period {{modulation_period:.5g}}, {turns:.4g} turns"
        period += "" if depth is None else ", +-{modulation_depth:.2g%} of the speed averaged over turns"
        a.line("modulation", period + mark("modulation_period", "modulation_depth"))


def _state_contacts(a: Answer, motion: Motion, mark: Mark) -> None:
    """State how stiff the contacts of balls are, and how far balls overlap in the run; nothing without tracks."""
    contacts = track_contacts(motion)
    if not contacts:
        return
    overlaps = {name: c.overlap for name, c in contacts.items() if c.overlap is not None}
    lengths = {name: overlap * contacts[name].radius for name, overlap in overlaps.items()}
    frequencies, unit = {name: c.frequency for name, c in contacts.items()}, motion.case.machine.orbit_unit
    a.number("contact_frequencies", frequencies, "frequencies of the contacts, by track", "rad/s")
    a.number("overlaps", overlaps, "largest overlaps of bodies in the run, as angles, by track", "rad")
    a.number("overlap_lengths", lengths, "largest overlaps of bodies in the run, by track", unit)
    for track, frequency in frequencies.items():
        overlap, angle = "", overlaps.get(track)
        if angle is not None:
            length = number_text(lengths[track], "m", "", motion.case.machine.dimensionless)
            overlap = f"; bodies overlap by {length} at most, {math.degrees(angle):.2g}°" if angle else "; none has closed"
        a.line("contacts", f"of {frequency:.4g} rad/s{overlap}{mark('overlaps', 'overlap_lengths')}")


def _state_check(a: Answer, check: ContactCheck, verdict: Verdict) -> None:
    """State what contacts of another stiffness change."""
    stiffness = "four times as soft" if check.is_stiffer else "four times as stiff"
    outcome, condition = str(check.reference.verdict.outcome), f"with contacts {stiffness}"
    amplitude, residual = check.amplitude_change, check.residual_change
    a.number("contact_check", stiffness, "contacts of the run for comparison")
    a.number("contact_check_outcome", outcome, f"outcome {condition}")
    a.number("contact_check_amplitude", amplitude, f"change of the largest amplitude {condition}")
    a.number("contact_check_residual", residual, f"change of the residual unbalance {condition}")
    changes = [] if amplitude is None else [f"the largest amplitude changes by {100 * amplitude:.2g} %"]
    changes += [] if residual is None else [f"the remaining unbalance by {100 * residual:.2g} % of the rotor's"]
    changes += [] if outcome == str(verdict.outcome) else [f"the outcome is {outcome}"]
    a.line("", f"{stiffness}, {', '.join(changes) or 'nothing is known of changes'}")


def _angles(phases: dict[str, float]) -> str:
    return ", ".join(f"{name} {math.degrees(phase):.1f}°" for name, phase in phases.items())
