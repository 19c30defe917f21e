"""Findings -> the Dataset of a run-up: what was computed, with names and units, and the verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wucht.analysis.dimensionless import numbers
from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.observation import motion_of
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.machines.machine import MISMATCH, Machine
from wucht.machines.operation import natural_frequencies
from wucht.numerics.observers.turn_record import smooth_weights
from wucht.numerics.peaks import extremes
from wucht.results.quantities import Answer, Quantity, variables_of
from wucht.studies.motion_variables import envelopes, variables
from wucht.studies.run_up.both_models import joined
from wucht.studies.run_up.many_runs import gathered
from wucht.studies.run_up.prepare import Plan
from wucht.studies.run_up.run import Findings
from wucht.studies.run_up.vibration_at_the_end import vibration_at_the_end

if TYPE_CHECKING:
    import xarray as xr

_KEYS = ("free_speed", "peak_amplitude")  # variables that are keys of the summary
_FEWEST_A_TURN = 8
_CLOSED = 1e-6  # an energy residual beyond it is reported as a warning


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of one run, of one run of both models, or of many, with the dimension ``case``."""
    runs = [joined(motions, [_of_motion(m, plan.spec.deck) for m in motions]) for motions in findings.motions]
    return gathered(plan, runs, findings.finished) if plan.several else runs[0].dataset()


def _of_motion(motion: Motion, deck: float | None) -> Answer:
    """The motion of one model."""
    machine, trajectory, verdict = motion.case.machine, motion.trajectory, motion.verdict
    quantities = variables(machine, motion.rows, motion.seen, motion.observation.largest)
    observed = _observed(motion) if _coarse(motion) else None
    quantities += [] if observed is None else envelopes(machine, motion.observation.main.last(1.0))
    result = variables_of(quantities)
    residual = float(result.energy_residual.max())
    summary = _summary(machine, result, verdict, observed)
    summary += vibration_at_the_end(machine, result, _window(result, verdict), deck) if motion.model.name == "full" else []
    quantities = [replace(q, in_summary=q.name in _KEYS, headline=q.name == "peak_amplitude") for q in quantities]
    flow = {"engine": motion.compiled.engine.name, "tolerance": motion.compiled.tolerance, "model": motion.model.name}
    end = {"outcome": str(verdict.outcome), "end_time": trajectory.end_time, "end_state": trajectory.end_state}
    warnings = _warnings(motion, residual)
    return Answer([*summary, *quantities], verdict.sentence, warnings, (), trajectory.failure, flow | end)


def _warnings(motion: Motion, residual: float) -> list[str]:
    verdict, evidence, failure = motion.verdict, motion.verdict.evidence, motion.trajectory.failure
    # Of both models the horizon is that of the full one.
    own = (*motion.case.horizon.warnings, *_coarse(motion)) if motion.model is motion.case.models[0] else ()
    warnings = [*own, *motion.model.warnings, *((*motion.model.remedies, failure) if failure else ())]
    if verdict.outcome is Outcome.PASSED and verdict.faster_branch:
        warnings.append(
            f"the rotor settled at {verdict.speed:.4g}, just beyond the maximum of the vibration torque at "
            f"{evidence.resonance:.4g}, although the drive could hold a higher speed too: this is the branch of the "
            "captured states, close to its end"
        )
    warnings += [verdict.advice] if verdict.advice else []
    if not residual <= _CLOSED:  # one that is not a number does not close either
        warnings.append(
            f"the energy balance closes only to {residual:.1e}: the run is not accurate; look for a parameter or a start that "
            "is off by a factor of thousands, or give a smaller study.tolerance"
        )
    return warnings


def _coarse(motion: Motion) -> tuple[str, ...]:
    """A warning where the motion is stored with few samples a turn."""
    time, seen, machine = motion.seen.time, motion.seen, motion.case.machine
    speeds = np.abs([motion_of(machine, seen, b)[1] for b in machine.bodies]).max(axis=0)
    turned = float((np.diff(time) * np.maximum(speeds[1:], speeds[:-1])).max(initial=0.0))
    samples = 2 * math.pi / turned if turned else math.inf
    if samples >= _FEWEST_A_TURN:
        return ()
    return (
        f"only {samples:.1f} samples a turn are stored, to keep the result below {motion.case.horizon.most} samples: "
        "its variables do not show the whole motion, but least_speed, greatest_speed, least_radius and greatest_radius show "
        "its limits; verdict, speeds and amplitudes of the summary do not depend on them. study.stored_samples asks for more",
    )


@dataclass(frozen=True)
class _Observed:
    """Of the motion as it is integrated, in the window of the verdict: the least and the greatest speed of the main rotor, and
    of the amplitude the mean, the least and the greatest."""

    speeds: tuple[float, float]
    amplitudes: tuple[float, float, float]


def _observed(motion: Motion) -> _Observed:
    machine, verdict, spans = motion.case.machine, motion.verdict, motion.observation.main.last(1.0)
    turns = motion.observation.rotors[machine.rotor.name].whole
    begin, end = verdict.window
    inside, turned = spans.time >= begin, (turns.time >= begin) & (turns.time <= end)
    inside[-1:] = True
    speeds = float(spans.least_speed[inside].min()), float(spans.greatest_speed[inside].max())
    if turned.any():
        which = slice(int(np.argmax(turned)), None)
        return _Observed(speeds, turns.part(which).amplitudes)
    distance = spans.greatest_distance[inside]
    return _Observed(speeds, (float(distance.mean()), float(distance.min()), float(distance.max())))


def _window(result: xr.Dataset, verdict: Verdict) -> np.ndarray:
    """Which samples are those of the verdict (N,)."""
    time = result.time.values
    inside: np.ndarray = (time >= verdict.window[0]) & (time <= verdict.window[1])
    inside[-1] |= not inside.any()
    return inside


def _summary(machine: Machine, result: xr.Dataset, verdict: Verdict, observed: _Observed | None) -> list[Quantity]:
    """The summary of the contract. observed: where the variables of the result are too few samples of the motion."""
    evidence, modulation, inside = verdict.evidence, verdict.modulation, _window(result, verdict)
    machine, rotor = machine.at(float(result.time.values[-1])), result.speed.sel(body=machine.rotor.name).values[inside]
    envelope, (low, high) = result.amplitude.values[inside], observed.speeds if observed else extremes(rotor)
    amplitudes = verdict.amplitudes or (observed.amplitudes if observed else None)
    amplitude, least, greatest = amplitudes or (float(f(envelope)) for f in (np.mean, np.min, np.max))
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
        Quantity("final_phases", verdict.phases, "mean phases of the bodies to their rotor at the end", "rad"),
        Quantity("final_residual_unbalance", verdict.residual, "share of the rotor's unbalance that is left", headline=True),
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
        Quantity("dimensionless", numbers(machine), "dimensionless numbers of the machine"),
        Quantity("advice", verdict.advice, "advice"),
        Quantity("advised_time", verdict.needed, "time that would be long enough", time),
    ]
    if verdict.locked is not None:
        quantities += [
            Quantity("mean_speeds", verdict.locked.speeds, "mean speeds of the rotors", speed),
            Quantity("rotor_phases", verdict.locked.phases, "mean phases of the rotors", "rad"),
        ]
    if verdict.rotors:
        outcomes = {name: str(o) for name, o in verdict.rotors.items()}
        quantities.append(Quantity("rotor_outcomes", outcomes, "outcome of each rotor"))
    return quantities


def _mismatch(result: xr.Dataset) -> float | None:
    return float(result[MISMATCH][-1]) if MISMATCH in result else None
