"""The Dataset of a run-up: what was computed, with names, units, the whole input and the verdict."""

from __future__ import annotations

import hashlib
import json
import math
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies, numbers
from wucht.machines.machine import LOST, MISMATCH, SUPPLIED, Machine
from wucht.machines.vibration import Vibration, free_speed, group
from wucht.numerics.compile import Flow
from wucht.numerics.integrate import Trajectory
from wucht.numerics.peaks import envelope, extremes, interval_peaks
from wucht.results.conventions import Variable, variable
from wucht.results.outcomes import Outcome
from wucht.results.provenance import provenance
from wucht.results.store import to_json
from wucht.studies.start import static_position
from wucht.studies.verdict import Verdict

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.run_up import RunUp


def result(
    machine: Machine,
    question: RunUp,
    flow: Flow,
    trajectory: Trajectory,
    verdict: Verdict,
    warnings: Sequence[str],
    begun: float,
) -> xr.Dataset:
    """Put a run into a Dataset.

    Coordinates: time (N), body, balancer (bodies that turn about another), direction. Variables: angle, speed (body, time);
    phase (balancer, time); displacement, velocity, bearing_force (direction, time); radius, amplitude, motor_torque,
    motor_power, stored_energy, supplied_work, dissipated_work, energy_residual, residual_unbalance (time); natural_frequency
    (direction); free_speed. Attributes: summary, outcome, warnings, and the provenance.
    """
    import xarray as xr_

    names, units, states = machine.system.state_names, machine.units, trajectory.states
    outputs = flow.outputs(trajectory.time, states, trajectory.parameters)
    row = {name: states[i] for i, name in enumerate(names)} | outputs
    balancers = [b for b in machine.bodies if b.about is not None]
    directions = [c.position.name[-1] for c in machine.carrier]
    displacement = np.array([row[c.position.name] for c in machine.carrier])
    offset = displacement - static_position(machine)[:, None]
    velocity = np.array([row[c.velocity.name] for c in machine.carrier])
    angle = {b.name: row[b.coordinate.position.name] for b in machine.bodies}
    speed = {b.name: row[b.coordinate.velocity.name] for b in machine.bodies}
    natural = natural_frequencies(machine)
    amplitude, peak = _amplitude(trajectory.time, offset, velocity, speed[machine.rotor.name], natural)
    data: dict[str, Variable] = {
        "angle": variable("body time", list(angle.values()), "angle", "rad"),
        "speed": variable("body time", list(speed.values()), "speed", units.speed),
        "displacement": variable("direction time", displacement, "displacement of the axis", units.length),
        "velocity": variable("direction time", velocity, "velocity of the axis", _per(units)),
        "radius": variable(
            "time", np.hypot.reduce(offset, axis=0), "distance of the axis from its static position", units.length
        ),
        "amplitude": variable("time", amplitude, "amplitude of the axis", units.length),
        "peak_amplitude": variable("", peak, "largest amplitude of the axis", units.length),
        "bearing_force": variable(
            "direction time", [outputs[f"bearing_force_{d}"] for d in directions], "bearing force", units.force
        ),
        "motor_torque": variable("time", outputs["motor_torque"], "motor torque", units.torque),
        "motor_power": variable("time", outputs["motor_power"], "motor power", units.power),
        "residual_unbalance": variable("time", _residual(machine, angle), "share of the unbalance that is left"),
        "natural_frequency": variable("direction", [natural[d] for d in directions], "natural frequency", units.speed),
        "free_speed": variable("", _or_nan(free_speed(machine, machine.rotor)), "speed reached without vibration", units.speed),
    }
    if balancers:
        relative = [np.mod(angle[b.name] - angle[b.about or ""], 2 * math.pi) for b in balancers]
        data["phase"] = variable("balancer time", relative, "phase to the body turned about", "rad")
    balance = _energy(outputs, trajectory)
    for name, long_name in (
        ("stored_energy", "stored energy"), (SUPPLIED, "work of the drives"), (LOST, "energy dissipated"),
        (MISMATCH, "work created by dampers that are not reciprocal"),
    ):  # fmt: skip
        if name in balance:
            data[name] = variable("time", balance[name], long_name, units.energy)
    data["energy_residual"] = variable("time", balance["residual"], "energy residual, relative")
    coordinates = {
        "time": variable("time", trajectory.time, "time", units.time),
        "body": variable("body", list(angle), "body"),
        "direction": variable("direction", directions, "direction"),
        "balancer": variable("balancer", [b.name for b in balancers] or np.empty(0, "U1"), "balancing body"),
        "parameter": variable("parameter", list(machine.values), "parameter"),
        "end_state": variable("state", trajectory.end_state, "state and accumulated works at the end"),
    }
    data["parameters"] = variable("parameter", list(machine.values.values()), "parameter values")
    data["end_state"] = coordinates.pop("end_state")
    found = xr_.Dataset(dict(data.items()), coords=coordinates)
    said = _warnings(machine, trajectory, verdict, warnings)
    short = _summary(machine, found, verdict)
    found.attrs |= {
        "study": "run-up",
        "title": machine.title,
        "outcome": str(verdict.outcome),
        "sentence": verdict.sentence,
        "summary": to_json(short, indent=None),
        "warnings": to_json(said, indent=None),
        "dimensionless": int(not units.time),
        "engine": flow.engine.name,
        "tolerance": flow.tolerance,
        "end_time": trajectory.end_time,
        "finished": int(not (trajectory.interrupted or trajectory.failure)),
        "failure": trajectory.failure or "",
        **provenance(
            {k: v for k, v in asdict(question).items() if v is not None} | {"kind": "run-up"},
            {
                "title": machine.title,
                "structure": _structure(machine),
                "parameters": machine.values,
                "bodies": [[b.name, b.kind, b.about] for b in machine.bodies],
            },
            clock.perf_counter() - begun,
        ),
    }
    return found


def _per(units: Any) -> str:
    return f"{units.length}/{units.time}" if units.time else ""


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def _amplitude(
    time: np.ndarray, offset: np.ndarray, velocity: np.ndarray, speed: np.ndarray, natural: Mapping[str, float]
) -> tuple[np.ndarray, float]:
    """The envelope of the axis' distance from its static position, and its peak.

    offset, velocity: (m, N). A valley counts as part of the orbit if it is shorter than half a turn, or half a free vibration
    while the rotor is slower than that.
    """
    peaks = np.sqrt(np.maximum(interval_peaks(time, (offset**2).sum(axis=0), 2 * (offset * velocity).sum(axis=0)), 0.0))
    slowest = min((f for f in natural.values() if f > 0), default=0.0)
    rate = np.maximum(np.abs(speed), slowest)
    return envelope(time, peaks, np.divide(math.pi, rate, out=np.zeros_like(rate), where=rate > 0)), float(peaks.max())


def _residual(machine: Machine, angle: Mapping[str, np.ndarray]) -> np.ndarray:
    bodies = group(machine, machine.rotor)
    unbalances = Vibration.of(machine).unbalances
    vector = sum(unbalances[machine.bodies.index(b)] * np.exp(1j * angle[b.name]) for b in bodies)
    scale = unbalances[machine.bodies.index(machine.rotor)] or unbalances.max() or 1.0
    found: np.ndarray = np.abs(vector) / scale
    return found


def _energy(outputs: Mapping[str, np.ndarray], trajectory: Trajectory) -> dict[str, np.ndarray]:
    """The energy balance over time. residual: |supplied - dissipated - change of stored| over the larger of work and energy."""
    stored = outputs["stored_energy"]
    balance = {"stored_energy": stored, **trajectory.quadratures}
    gap = balance[SUPPLIED] - balance[LOST] - (stored - stored[:1])
    scale = max(float(np.abs(balance[SUPPLIED]).max(initial=0.0)), float(np.abs(stored).max(initial=0.0)))
    return balance | {"residual": np.abs(gap) / (scale or 1.0)}


def _warnings(machine: Machine, trajectory: Trajectory, verdict: Verdict, warnings: Sequence[str]) -> list[str]:
    said = [*machine.warnings, *warnings]
    if trajectory.failure:
        said.append(trajectory.failure)
    if trajectory.interrupted:
        said.append(f"interrupted at t = {trajectory.end_time:.6g}; --resume continues from there")
    if verdict.outcome is Outcome.PASSED and verdict.faster_branch:
        said.append(
            f"the rotor settled at {verdict.evidence.mean_speed:.4g}, just beyond the maximum of the vibration torque at "
            f"{verdict.evidence.resonance:.4g}, although the drive could hold a higher speed too: this is the branch of the "
            "captured states, close to its end"
        )
    if verdict.advice:
        said.append(verdict.advice)
    return said


def _summary(machine: Machine, found: xr.Dataset, verdict: Verdict) -> dict[str, Any]:
    time = found.time.values
    inside = (time >= verdict.window[0]) & (time <= verdict.window[1])
    if not inside.any():
        inside = np.zeros(len(time), bool)
        inside[-1:] = True
    rotor = found.speed.sel(body=machine.rotor.name).values
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
    }


def _time_mean(time: np.ndarray, values: np.ndarray) -> float:
    if len(time) < 2:
        return float(values[-1]) if len(values) else math.nan
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


def _structure(machine: Machine) -> str:
    """A fingerprint of the machine's equations."""
    s = machine.system
    return hashlib.sha256(repr((s.states, s.definitions, s.derivatives)).encode()).hexdigest()[:16]


def restore(machine: Machine, question: RunUp, earlier: xr.Dataset) -> Trajectory:
    """The trajectory in an unfinished result, to be continued. Raises ``InputError`` if it answers another question."""
    given = json.loads(earlier.attrs["input"])
    mine = json.loads(to_json({"kind": question.kind, "start": question.start, "tolerance": question.tolerance}))
    same = given["machine"]["structure"] == _structure(machine) and given["machine"]["parameters"] == machine.values
    if not same or {key: given["study"].get(key) for key in mine} != mine:
        raise InputError("--resume", None, "the result in the output folder is of another machine, start or tolerance")
    rows: dict[str, np.ndarray] = {}
    for b in machine.bodies:
        rows[b.coordinate.position.name] = earlier.angle.sel(body=b.name).values
        rows[b.coordinate.velocity.name] = earlier.speed.sel(body=b.name).values
    for c in machine.carrier:
        direction = c.position.name[-1]
        rows[c.position.name] = earlier.displacement.sel(direction=direction).values
        rows[c.velocity.name] = earlier.velocity.sel(direction=direction).values
    return Trajectory(
        earlier.time.values,
        np.array([rows[name] for name in machine.system.state_names]),
        {q.name: earlier[q.name].values for q in machine.system.quadratures},
        np.array(list(machine.values.values())),
        float(earlier.attrs["end_time"]),
        earlier.end_state.values,
    )
