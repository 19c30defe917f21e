"""Findings -> the Dataset of a response: variables over the speed, the maxima, and the summary."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.forced import Forced
from wucht.dynamics.run_ups.steady_phases import Piece
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.results.conventions import Variable, answered, assuming, variable
from wucht.studies.response.maxima import Curve, Maximum, found_maxima
from wucht.studies.response.prepare import Plan
from wucht.studies.response.run import Findings, centre_distance, eccentricity_of, lag_of, losses_of, self_centring_speed

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a response.

    Coordinates: speed (N), direction (free coordinates of the carrier), body, mode, peak; of bodies in steady phases
    configuration, with its configuration_name. Variables over the speed, with steady phases over configuration and speed:
    displacement_real, displacement_imag (q = Re[z exp(i w t)], w t being the angle a body has turned from its start),
    displacement_amplitude, lag (direction, speed); amplitude, minor_axis, centre_distance, vibration_torque, required_torque
    (speed); torque_on_body (body, speed); then loss_torque (speed); stable (configuration, speed), overlapping
    (configuration); eccentricity, free_speed, natural_frequency (mode), peak_speed, peak_amplitude, with steady phases
    peak_configuration (peak).
    """
    import xarray as xr_

    machine, w, steady = plan.steady.machine, findings.speeds, plan.steady
    units, natural, free = machine.units, natural_frequencies(machine), free_speed(machine, machine.rotor)
    eccentricity, losses, pieces = eccentricity_of(machine), losses_of(machine, w), steady.pieces(w)
    each = [_over_speed(plan, forced, eccentricity, w, losses) for forced in steady.curves]
    maxima = found_maxima(plan, findings, [_curve(one, k, pieces) for k, one in enumerate(each)])
    coordinates = {
        "speed": variable("speed", w, "speed", units.speed),
        "direction": variable("direction", list(machine.free_labels), "direction"),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "mode": variable("mode", list(natural), "mode of vibration"),
    }
    data = {
        **(_of_pieces(each, pieces) if steady.branches else each[0]),
        "loss_torque": variable("speed", losses, "torque of loads and bearings", units.torque),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "eccentricity": variable("", eccentricity, "eccentricity of the rotor", units.length),
        "peak_speed": variable("peak", [m.speed for m in maxima.amplitudes], "speed of a largest amplitude", units.speed),
        "peak_amplitude": variable("peak", [m.value for m in maxima.amplitudes], "largest amplitude", machine.orbit_unit),
    }
    if steady.branches:
        names = np.array([p.label for p in pieces], str)
        coordinates["configuration_name"] = variable("configuration", names, "steady phase configuration")
        data["peak_configuration"] = variable(
            "peak", np.array([m.label for m in maxima.amplitudes], str), "configuration there"
        )
    inside = sorted(x for x in natural.values() if x > 0 and plan.range[0] <= x <= plan.range[1])
    critical = [x for x, below in zip(inside, [0.0, *inside], strict=False) if not math.isclose(x, below, rel_tol=1e-9)]
    excited = any(bool(forced.force(w).any()) for forced in steady.curves)
    sentence = _sentence(excited, critical, free, maxima.at_free)
    largest, hardest = maxima.largest, maxima.hardest
    summary = {
        "sentence": sentence,
        "range": list(plan.range),
        "bodies": "steady" if steady.branches else "held",
        "critical_speeds": critical,
        "natural_frequencies": natural,
        "peak_amplitude": None if largest is None else largest.value,
        "peak_speed": None if largest is None or largest.value == 0 else largest.speed,
        "peaks": [_entry("amplitude", m) for m in maxima.amplitudes],
        "peak_torque": None if hardest is None else hardest.value,
        "peak_torque_speed": None if hardest is None or not hardest.value > 0 else hardest.speed,
        "torque_peaks": [_entry("torque", m) for m in maxima.torques],
        "free_speed": free,
        "amplitude_at_free_speed": max((m.value for m in maxima.at_free), default=None),
        "configurations_at_free_speed": [m.label for m in maxima.at_free if m.label],
        "throw_at_free_speed": None if maxima.throw is None else maxima.throw.numbers,
        "eccentricity": eccentricity,
        "self_centring_speed": self_centring_speed(steady, eccentricity, w) if excited else None,
    }
    undamped = sorted({x for c in findings.curves for x in c.undamped})
    resonances = [f"{x:.6g} {units.speed}".rstrip() for x in undamped]
    warnings = [f"nothing damps the resonance at {at}: there the amplitude is infinite" for at in resonances]
    result = answered(xr_.Dataset(data, coords=coordinates), summary, sentence, warnings + steady.warnings)
    return assuming(result, steady.assumed)


def _over_speed(plan: Plan, forced: Forced, eccentricity: float, w: np.ndarray, losses: np.ndarray) -> dict[str, Variable]:
    """What one curve of the vibration says, over the speed."""
    known = forced.phases(w)
    forced = replace(forced, placed=known[0] if known[1] is None else lambda _: known)  # computed once
    machine, units, z = plan.steady.machine, plan.steady.machine.units, forced.displacement(w)[0].T
    along, vibration = "direction speed", forced.torque(w)[0]
    on_bodies = np.array([forced.torque_on(w, [i])[0] for i in range(len(machine.bodies))])
    centre = centre_distance(plan.steady, forced, eccentricity, w)
    return {
        "displacement_real": variable(along, z.real, "displacement at the start of a turn (r: rad)", units.length),
        "displacement_imag": variable(along, z.imag, "displacement a quarter turn before (r: rad)", units.length),
        "displacement_amplitude": variable(along, np.abs(z), "amplitude of the carrier (r: rad)", units.length),
        "lag": variable(along, lag_of(machine, forced, w, z), "phase lag behind the unbalance", "rad"),
        "amplitude": variable("speed", forced.amplitude(w)[0], "amplitude of the axis", machine.orbit_unit),
        "minor_axis": variable("speed", forced.minor(w), "semi-minor axis of the orbit", machine.orbit_unit),
        "centre_distance": variable("speed", centre, "distance of the centre of mass", units.length),
        "vibration_torque": variable("speed", vibration, "torque of the vibration", units.torque),
        "required_torque": variable("speed", vibration + losses, "torque required", units.torque),
        "torque_on_body": variable("body speed", on_bodies, "torque of the vibration on a body", units.torque),
    }


def _curve(values: dict[str, Variable], k: int, pieces: list[Piece]) -> Curve:
    """Of the k-th curve what its maxima are found from."""
    stable = [p.stable for p in pieces if p.branch == k and not p.overlapping]
    always = not pieces
    amplitude, torque = values["amplitude"][1], values["vibration_torque"][1]
    return Curve(amplitude, torque, np.any(stable, axis=0) if stable else np.full(len(amplitude), always))


def _of_pieces(each: list[dict[str, Variable]], pieces: list[Piece]) -> dict[str, Variable]:
    """The same over configurations, each where it has its name."""
    variables: dict[str, Variable] = {}
    for name, (dimensions, _, words) in each[0].items():
        values = [np.where(p.inside, each[p.branch][name][1], np.nan) for p in pieces]
        variables[name] = (("configuration", *dimensions), np.array(values), words)
    stable, over = (np.array([getattr(p, name) for p in pieces], np.int8) for name in ("stable", "overlapping"))
    variables["stable"] = variable("configuration speed", stable, "stable with the rotor held at the speed")
    variables["overlapping"] = variable("configuration", over, "bodies of a track are in each other's place")
    return variables


def _entry(name: str, m: Maximum) -> dict[str, Any]:
    more = {"configuration": m.label, "stable": m.stable} if m.label else {}
    return {"speed": m.speed, name: m.value, **more}


def _sentence(excited: bool, critical: list[float], free: float | None, at_free: list[Maximum]) -> str:
    if not excited:
        return "nothing excites the carrier: the unbalances are zero or cancel"
    count = len(critical)
    sentence = f"{count or 'no'} critical speed{'' if count == 1 else 's'} in the range"
    if free and critical:
        below = sum(c < abs(free) for c in critical)
        where = "above" if below == count else "below" if not below else "between"
        sentence += f"; the drive runs {where} {'it' if count == 1 else 'them'}"
    labels = dict.fromkeys(m.label for m in at_free if m.label)
    return f"{sentence}; bodies stable there: {', '.join(labels)}" if labels and free else sentence
