"""Findings -> the Dataset of a response: variables over the speed, the maxima, and the summary."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.operation import natural_frequencies
from wucht.results.conventions import answered, variable
from wucht.studies.response.prepare import Plan
from wucht.studies.response.run import Findings

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

    f, machine = findings, plan.steady.machine
    units, length, natural = machine.units, machine.orbit_unit, natural_frequencies(machine)
    free, eccentricity = (math.nan if x is None else x for x in (f.free_speed, f.eccentricity))
    z, vibration, losses = f.displacement, f.vibration_torque, f.loss_torque
    coordinates = {
        "speed": variable("speed", f.speeds, "speed", units.speed),
        "direction": variable("direction", list(machine.free_labels), "direction"),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "mode": variable("mode", list(natural), "mode of vibration"),
    }
    along = "direction speed"
    data = {
        "displacement_real": variable(along, z.real, "displacement at the start of a turn (r: rad)", units.length),
        "displacement_imag": variable(along, z.imag, "displacement a quarter turn before (r: rad)", units.length),
        "displacement_amplitude": variable(along, np.abs(z), "amplitude of the carrier (r: rad)", units.length),
        "lag": variable(along, f.lag, "phase lag behind the unbalance", "rad"),
        "amplitude": variable("speed", f.amplitude, "amplitude of the axis", length),
        "minor_axis": variable("speed", f.minor_axis, "semi-minor axis of the orbit", length),
        "centre_distance": variable("speed", f.centre_distance, "distance of the centre of mass", units.length),
        "vibration_torque": variable("speed", vibration, "torque of the vibration", units.torque),
        "loss_torque": variable("speed", losses, "torque of loads and bearings", units.torque),
        "required_torque": variable("speed", vibration + losses, "torque required", units.torque),
        "torque_on_body": variable("body speed", f.torque_on_body, "torque of the vibration on a body", units.torque),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
        "free_speed": variable("", free, "speed reached without vibration", units.speed),
        "eccentricity": variable("", eccentricity, "eccentricity of the rotor", units.length),
        "peak_speed": variable("peak", f.peak_speeds, "speed of a largest amplitude", units.speed),
        "peak_amplitude": variable("peak", f.peak_amplitudes, "largest amplitude", length),
    }
    summary = _summary(plan.range, natural, findings)
    sentence = _sentence(findings, summary["critical_speeds"])
    return answered(
        xr_.Dataset(dict(data.items()), coords=coordinates),
        {"sentence": sentence} | summary,
        sentence,
        _warnings(findings, units.speed) + plan.steady.warnings,
    )


def _summary(speeds: tuple[float, float], natural: dict[str, float], f: Findings) -> dict[str, Any]:
    critical: list[float] = []
    for frequency in sorted(natural.values()):
        twice = bool(critical) and math.isclose(critical[-1], frequency, rel_tol=1e-9)
        if speeds[0] <= frequency <= speeds[1] and frequency > 0 and not twice:
            critical.append(frequency)
    largest, hardest = int(f.amplitude.argmax()), int(f.vibration_torque.argmax())
    peak, at, torque = (float(x) for x in (f.amplitude[largest], f.speeds[largest], f.vibration_torque[hardest]))
    if np.isinf(f.peak_amplitudes).any():
        peak, at = math.inf, float(f.peak_speeds[np.isinf(f.peak_amplitudes)][-1])
    return {
        "range": list(speeds),
        "critical_speeds": critical,
        "natural_frequencies": natural,
        "peak_amplitude": peak,
        "peak_speed": at if peak else None,
        "peaks": _pairs("amplitude", f.peak_speeds, f.peak_amplitudes),
        "peak_torque": torque,
        "peak_torque_speed": float(f.speeds[hardest]) if torque > 0 else None,
        "torque_peaks": _pairs("torque", f.torque_peak_speeds, f.torque_peaks),
        "free_speed": f.free_speed,
        "amplitude_at_free_speed": f.amplitude_at_free_speed,
        "eccentricity": f.eccentricity,
        "self_centring_speed": f.self_centring_speed,
    }


def _pairs(name: str, speeds: np.ndarray, values: np.ndarray) -> list[dict[str, float]]:
    return [{"speed": w, name: value} for w, value in zip(speeds.tolist(), values.tolist(), strict=True)]


def _sentence(f: Findings, critical: list[float]) -> str:
    if not f.excited:
        return "nothing excites the carrier: the unbalances are zero or cancel"
    count = len(critical)
    sentence = f"{count or 'no'} critical speed{'' if count == 1 else 's'} in the range"
    if f.free_speed and critical:
        below = sum(c < abs(f.free_speed) for c in critical)
        where = "above" if below == count else "below" if not below else "between"
        sentence += f"; the drive runs {where} {'it' if count == 1 else 'them'}"
    return sentence


def _warnings(f: Findings, unit: str) -> list[str]:
    after = f" {unit}" if unit else ""
    return [f"nothing damps the resonance at {w:.6g}{after}: there the amplitude is infinite" for w in f.undamped]
