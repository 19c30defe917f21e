"""The Dataset of a run-up: what was computed, with names, units, the whole input and the verdict."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies, numbers
from wucht.machines.machine import MISMATCH, Machine
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.peaks import extremes
from wucht.results.conventions import variable
from wucht.results.outcomes import Outcome
from wucht.results.store import to_json
from wucht.studies.attributes import attributes, structure
from wucht.studies.run_up.model import Model
from wucht.studies.run_up.variables import variables
from wucht.studies.run_up.verdict import Verdict

_CLOSED = 1e-6  # an energy residual beyond it is told as a warning

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.run_up.study import RunUp


def result(
    machine: Machine,
    question: RunUp,
    flow: CompiledSystem,
    model: Model,
    trajectory: Trajectory,
    verdict: Verdict,
    warnings: Sequence[str],
    begun: float,
) -> xr.Dataset:
    """Put a run into a Dataset: the variables of ``run_up.variables``, what is needed to continue the run, and attributes.

    The attributes hold the summary, outcome, warnings and provenance. begun: ``perf_counter()`` at the beginning of the run.
    """
    import xarray as xr_

    seen = model.seen(trajectory)
    coordinates, data = variables(machine, model.outputs(trajectory, seen), seen)
    coordinates["parameter"] = variable("parameter", list(machine.values), "parameter")
    data["parameters"] = variable("parameter", list(machine.values.values()), "parameter values")
    data["parameters_at_end"] = variable("own", trajectory.parameters, "run-time parameters at the end")
    data["end_state"] = variable("state", trajectory.end_state, "state and accumulated works at the end")
    found = xr_.Dataset(dict(data.items()), coords=coordinates)
    summary = _summary(machine, found, verdict)
    said = _warnings(trajectory, verdict, warnings, question.model) + _balance(summary["energy_residual"])
    found.attrs |= attributes(
        machine, question, summary, verdict.sentence, said, begun, trajectory.failure, trajectory.interrupted
    )
    found.attrs |= {
        "outcome": str(verdict.outcome),
        "engine": flow.engine.name,
        "tolerance": flow.tolerance,
        "model": question.model,
        "end_time": trajectory.end_time,
    }
    return found


def _warnings(trajectory: Trajectory, verdict: Verdict, warnings: Sequence[str], model: str) -> list[str]:
    said = list(warnings)
    if trajectory.failure:
        said.append(trajectory.failure)
    if trajectory.interrupted:
        goes_on = "--resume begins again" if model == "slow" else "--resume continues from there"
        said.append(f"interrupted at t = {trajectory.end_time:.6g}; {goes_on}")
    if verdict.outcome is Outcome.PASSED and verdict.faster_branch:
        said.append(
            f"the rotor settled at {verdict.evidence.mean_speed:.4g}, just beyond the maximum of the vibration torque at "
            f"{verdict.evidence.resonance:.4g}, although the drive could hold a higher speed too: this is the branch of the "
            "captured states, close to its end"
        )
    if verdict.advice:
        said.append(verdict.advice)
    return said


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
    amplitude, beating = found.amplitude.values[inside], verdict.beat
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
        "modulation_period": beating.period if beating else None,
        "modulation_period_phi": beating.period_angle if beating else None,
        "modulation_depth": (high - low) / (2 * abs(mean)) if beating and mean else None,
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


def restore(machine: Machine, question: RunUp, earlier: xr.Dataset) -> Trajectory:
    """The trajectory in an unfinished result, to be continued. Raises ``InputError`` if it answers another question."""
    given = json.loads(earlier.attrs["input"])
    mine = json.loads(to_json({"kind": question.kind, "start": question.start, "tolerance": question.tolerance}))
    same = given["machine"]["structure"] == structure(machine) and given["machine"]["parameters"] == machine.values
    if not same or {key: given["study"].get(key) for key in mine} != mine:
        raise InputError("--resume", None, "the result in the output folder is of another machine, start or tolerance")
    rows: dict[str, np.ndarray] = {}
    for b in machine.bodies:
        rows[b.coordinate.position.name] = earlier.angle.sel(body=b.name).values
        rows[b.coordinate.velocity.name] = earlier.speed.sel(body=b.name).values
    for direction, c in zip(machine.labels, machine.carrier, strict=True):
        rows[c.position.name] = earlier.displacement.sel(direction=direction).values
        rows[c.velocity.name] = earlier.velocity.sel(direction=direction).values
    for x in machine.sliders:
        rows[x.coordinate.position.name] = earlier.slider_displacement.sel(slider=x.name).values
        rows[x.coordinate.velocity.name] = earlier.slider_velocity.sel(slider=x.name).values
    return Trajectory(
        earlier.time.values,
        np.array([rows[name] for name in machine.system.state_names]),
        {q.name: earlier[q.name].values for q in machine.system.quadratures},
        earlier.parameters_at_end.values,
        float(earlier.attrs["end_time"]),
        earlier.end_state.values,
    )
