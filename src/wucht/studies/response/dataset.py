"""Findings -> the Dataset of a response: variables over the speed, the maxima, and the summary."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from wucht.analysis.throw import steady_throw
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.results.conventions import answered, variable
from wucht.studies.response.prepare import Plan
from wucht.studies.response.run import (
    Findings,
    amplitude_at,
    centre_distance,
    eccentricity_of,
    lag_of,
    losses_of,
    self_centring_speed,
)

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a response.

    Coordinates: speed (N), direction (free coordinates of the carrier), body, mode, peak. Variables over the speed:
    displacement_real, displacement_imag (q = Re[z exp(i w t)], w t being the angle a body has turned from its start),
    displacement_amplitude, lag (direction, speed); amplitude, minor_axis, centre_distance, vibration_torque, loss_torque,
    required_torque (speed); torque_on_body (body, speed). Then eccentricity, free_speed, natural_frequency (mode),
    peak_speed, peak_amplitude (peak).
    """
    import xarray as xr_

    f, machine, forced, w = findings, plan.steady.machine, plan.steady.forced, findings.speeds
    units, length, natural = machine.units, machine.orbit_unit, natural_frequencies(machine)
    free, eccentricity, excited = free_speed(machine, machine.rotor), eccentricity_of(machine), bool(forced.force.any())
    z, amplitude = forced.displacement(w)[0].T, forced.amplitude(w)[0]
    vibration, losses, centre = forced.torque(w)[0], losses_of(machine, w), centre_distance(plan.steady, eccentricity, w)
    on_bodies = np.array([forced.torque_on(w, [i])[0] for i in range(len(machine.bodies))])
    peaks = np.array([amplitude_at(forced, f.undamped, at) for at in f.peaks.tolist()])
    coordinates = {
        "speed": variable("speed", w, "speed", units.speed),
        "direction": variable("direction", list(machine.free_labels), "direction"),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "mode": variable("mode", list(natural), "mode of vibration"),
    }
    along = "direction speed"
    data = {
        "displacement_real": variable(along, z.real, "displacement at the start of a turn (r: rad)", units.length),
        "displacement_imag": variable(along, z.imag, "displacement a quarter turn before (r: rad)", units.length),
        "displacement_amplitude": variable(along, np.abs(z), "amplitude of the carrier (r: rad)", units.length),
        "lag": variable(along, lag_of(machine, forced, z), "phase lag behind the unbalance", "rad"),
        "amplitude": variable("speed", amplitude, "amplitude of the axis", length),
        "minor_axis": variable("speed", forced.minor(w), "semi-minor axis of the orbit", length),
        "centre_distance": variable("speed", centre, "distance of the centre of mass", units.length),
        "vibration_torque": variable("speed", vibration, "torque of the vibration", units.torque),
        "loss_torque": variable("speed", losses, "torque of loads and bearings", units.torque),
        "required_torque": variable("speed", vibration + losses, "torque required", units.torque),
        "torque_on_body": variable("body speed", on_bodies, "torque of the vibration on a body", units.torque),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "eccentricity": variable("", eccentricity, "eccentricity of the rotor", units.length),
        "peak_speed": variable("peak", f.peaks, "speed of a largest amplitude", units.speed),
        "peak_amplitude": variable("peak", peaks, "largest amplitude", length),
    }
    in_operation = None if free is None else amplitude_at(forced, f.undamped, abs(free))
    throw = steady_throw(machine, forced, free) if free is not None and math.isfinite(in_operation or 0.0) else None
    inside = sorted(x for x in natural.values() if x > 0 and plan.range[0] <= x <= plan.range[1])
    critical = [x for x, below in zip(inside, [0.0, *inside], strict=False) if not math.isclose(x, below, rel_tol=1e-9)]
    sentence, hardest, infinite = _sentence(excited, critical, free), vibration.argmax(), f.peaks[np.isinf(peaks)]
    summary = {
        "sentence": sentence,
        "range": list(plan.range),
        "critical_speeds": critical,
        "natural_frequencies": natural,
        "peak_amplitude": math.inf if len(infinite) else float(amplitude.max()),
        "peak_speed": float(infinite[-1]) if len(infinite) else float(w[amplitude.argmax()]) if amplitude.any() else None,
        "peaks": _pairs("amplitude", f.peaks, peaks),
        "peak_torque": float(vibration[hardest]),
        "peak_torque_speed": float(w[hardest]) if vibration[hardest] > 0 else None,
        "torque_peaks": _pairs("torque", f.torque_peaks, forced.torque(f.torque_peaks)[0]),
        "free_speed": free,
        "amplitude_at_free_speed": in_operation,
        "throw_at_free_speed": None if throw is None else throw.numbers,
        "eccentricity": eccentricity,
        "self_centring_speed": self_centring_speed(plan.steady, eccentricity, w) if excited else None,
    }
    resonances = [f"{x:.6g} {units.speed}".rstrip() for x in f.undamped]
    warnings = [f"nothing damps the resonance at {at}: there the amplitude is infinite" for at in resonances]
    return answered(xr_.Dataset(dict(data), coords=coordinates), summary, sentence, warnings + plan.steady.warnings)


def _pairs(name: str, speeds: np.ndarray, values: np.ndarray) -> list[dict[str, float]]:
    return [{"speed": w, name: value} for w, value in zip(speeds.tolist(), values.tolist(), strict=True)]


def _sentence(excited: bool, critical: list[float], free: float | None) -> str:
    if not excited:
        return "nothing excites the carrier: the unbalances are zero or cancel"
    count = len(critical)
    sentence = f"{count or 'no'} critical speed{'' if count == 1 else 's'} in the range"
    if free and critical:
        below = sum(c < abs(free) for c in critical)
        where = "above" if below == count else "below" if not below else "between"
        sentence += f"; the drive runs {where} {'it' if count == 1 else 'them'}"
    return sentence
