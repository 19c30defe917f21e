"""Findings -> the Dataset of a run-up: what was computed, with names and units, and the verdict."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.dimensionless import numbers
from wucht.machines.machine import MISMATCH, Machine
from wucht.machines.operation import natural_frequencies
from wucht.numerics.peaks import extremes
from wucht.results.conventions import answered
from wucht.results.outcomes import Outcome
from wucht.studies.run_up.both import joined
from wucht.studies.run_up.many import gathered
from wucht.studies.run_up.prepare import Plan
from wucht.studies.run_up.run import Findings, Motion
from wucht.studies.run_up.variables import variables
from wucht.studies.run_up.verdict import Verdict

if TYPE_CHECKING:
    import xarray as xr

_CLOSED = 1e-6  # an energy residual beyond it is reported as a warning


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of one run, of one run of both models, or of many.

    Its variables are those of ``run_up.variables``; with both models also those of ``run_up.both``; many runs are those of
    ``run_up.many``, with the dimension ``case``.
    """
    runs = [joined(motions, [of_motion(m) for m in motions]) for motions in findings.motions]
    return gathered(plan, runs, findings.finished) if plan.several else runs[0]


def of_motion(motion: Motion) -> xr.Dataset:
    """The motion of one model: the variables of ``run_up.variables``, and the summary of the contract."""
    import xarray as xr_

    machine, trajectory, verdict = motion.case.machine, motion.trajectory, motion.verdict
    coordinates, data = variables(machine, motion.rows, motion.seen)
    found = xr_.Dataset(dict(data.items()), coords=coordinates)
    summary = _summary(machine, found, verdict)
    return answered(
        found,
        summary,
        verdict.sentence,
        _warnings(motion) + _balance(summary["energy_residual"]),
        trajectory.failure,
        outcome=str(verdict.outcome),
        engine=motion.compiled.engine.name,
        tolerance=motion.compiled.tolerance,
        model=motion.model.name,
        end_time=trajectory.end_time,
        end_state=trajectory.end_state,
    )


def _warnings(motion: Motion) -> list[str]:
    verdict, failure = motion.verdict, motion.trajectory.failure
    # Of both models the horizon is that of the full one.
    own = motion.case.horizon.warnings if motion.model is motion.case.models[0] else ()
    said = [*own, *motion.model.warnings, *((*motion.model.remedies, failure) if failure else ())]
    if verdict.outcome is Outcome.PASSED and verdict.faster_branch:
        said.append(
            f"the rotor settled at {verdict.evidence.mean_speed:.4g}, just beyond the maximum of the vibration torque at "
            f"{verdict.evidence.resonance:.4g}, although the drive could hold a higher speed too: this is the branch of the "
            "captured states, close to its end"
        )
    return [*said, verdict.advice] if verdict.advice else said


def _balance(residual: float | None) -> list[str]:
    """A warning where the energy balance does not close."""
    if residual is None or residual <= _CLOSED:
        return []
    return [
        f"the energy balance closes only to {residual:.1e}: the run is not accurate; look for a parameter or a start that is "
        "off by a factor of thousands, or give a smaller study.tolerance"
    ]


def _summary(machine: Machine, found: xr.Dataset, verdict: Verdict) -> dict[str, Any]:
    time = found.time.values
    inside = (time >= verdict.window[0]) & (time <= verdict.window[1])
    if not inside.any():
        inside = np.zeros(len(time), bool)
        inside[-1:] = True
    rotor = found.speed.sel(body=machine.rotor.name).values
    machine = machine.at(float(time[-1]) if len(time) else 0.0)
    amplitude, modulation = found.amplitude.values[inside], verdict.modulation
    sense = float(np.sign(rotor[inside].mean())) or 1.0
    mean = sense * verdict.evidence.mean_speed if verdict.evidence.turning else _time_mean(time[inside], rotor[inside])
    low, high = extremes(rotor[inside])
    return {
        "outcome": str(verdict.outcome),
        "sentence": verdict.sentence,
        "final_speed": mean,
        "min_speed": low,
        "max_speed": high,
        "free_speed": float(found.free_speed),
        "final_amplitude": float(amplitude.mean()),
        "min_amplitude": float(amplitude.min()),
        "max_amplitude": float(amplitude.max()),
        "peak_amplitude": float(found.peak_amplitude),
        "amplitude_unit": machine.orbit_unit,
        "final_phases": verdict.phases,
        "final_residual_unbalance": verdict.evidence.residual,
        "settling_time": verdict.settling_time,
        "modulation_period": modulation.period if modulation else None,
        "modulation_period_phi": modulation.period_angle if modulation else None,
        "modulation_depth": (high - low) / (2 * abs(mean)) if modulation and mean else None,
        "energy_residual": float(found.energy_residual.max()) if len(time) else None,
        "damper_mismatch": float(found[MISMATCH][-1]) if MISMATCH in found and len(time) else None,
        "resonance_speed": verdict.evidence.resonance,
        "natural_frequencies": natural_frequencies(machine),
        "dimensionless": numbers(machine),
        "advice": verdict.advice,
        **_locking(verdict),
    }


def _locking(verdict: Verdict) -> dict[str, Any]:
    """Mean speeds over whole periods, and phases of rotors to each other or to the vibration; nothing for other machines."""
    if verdict.locked is None:
        return {}
    return {"mean_speeds": verdict.locked.speeds, "rotor_phases": verdict.locked.phases}


def _time_mean(time: np.ndarray, values: np.ndarray) -> float:
    if len(time) < 2:
        return float(values[-1]) if len(values) else math.nan
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))
