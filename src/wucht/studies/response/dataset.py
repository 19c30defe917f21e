"""Findings -> the quantities of a response over the speed and its maxima, and its lines in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.throw import NUMBERS
from wucht.analysis.vibration import ForcedVibration
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.run_ups.steady_phases import Piece
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.results.formatting import ReportLines, formats
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.from_rest_variables import FROM_REST_WORDS, from_rest_quantities
from wucht.studies.motion_variables import natural_vibrations
from wucht.studies.response.computation import (
    Findings,
    Maxima,
    Maximum,
    Plan,
    ResponseCurve,
    centre_distance,
    collect_maxima,
    eccentricity_of,
    losses_of,
    phase_lags,
    self_centring_speed,
)

if TYPE_CHECKING:
    import xarray as xr


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a response: q = Re[z exp(i w t)], w t being the angle that a body has turned from its start."""
    w, steady = findings.speeds, plan.steady
    machine, pieces = steady.machine, steady.pieces(w)
    eccentricity, losses, free = eccentricity_of(machine), losses_of(machine, w), free_speed(machine, machine.rotor)
    quantities_by_curve = [_curve_quantities(plan, vibration, eccentricity, w, losses) for vibration in steady.curves]
    maxima = collect_maxima(plan, findings, [_curve(one, k, pieces) for k, one in enumerate(quantities_by_curve)])
    inside = sorted(x for x in natural_frequencies(machine).values() if x > 0 and plan.range[0] <= x <= plan.range[1])
    critical = [x for x, below in zip(inside, [0.0, *inside], strict=False) if not math.isclose(x, below, rel_tol=1e-9)]
    is_excited = any(bool(vibration.force(w).any()) for vibration in steady.curves)
    speed, centring_speed = machine.units.speed, self_centring_speed(steady, eccentricity, w) if is_excited else None
    quantities = [
        Quantity("speed", w, "speed", speed, "speed"),
        Quantity("direction", list(machine.free_labels), "direction", "", "direction"),
        Quantity("body", [b.name for b in machine.bodies], "body", "", "body"),
        Quantity("range", list(plan.range), "lowest and highest speed", speed),
        Quantity("bodies", "steady" if steady.branches else "held", "phases of balancing bodies: held, or steady"),
        Quantity("critical_speeds", critical, "critical speeds in the range", speed),
        *natural_vibrations(machine),
        *(_configuration_quantities(quantities_by_curve, pieces) if steady.branches else quantities_by_curve[0]),
        *_maximum_quantities(plan, maxima),
        *_operation_quantities(plan, findings),
        Quantity("loss_torque", losses, "torque of loads and bearings", machine.units.torque, "speed"),
        Quantity("free_speed", free, "speed reached without vibration", speed, "", in_summary=True),
        Quantity("eccentricity", eccentricity, "eccentricity of the rotor", machine.units.length, "", in_summary=True),
        Quantity(
            "self_centring_speed", centring_speed, "speed from which the centre of mass is within the orbit of the axis", speed
        ),
    ]
    undamped_resonances = sorted({x for c in findings.curves for x in c.undamped_resonances})
    resonances = [f"{x:.6g} {speed}".rstrip() for x in undamped_resonances]
    warnings = [f"the resonance at {at} is undamped: there the amplitude is infinite" for at in resonances]
    sentence = _sentence(is_excited, critical, free, steady.list_labels([m.label for m in maxima.at_free]))
    if findings.from_rest is not None and is_excited:
        sentence += f"; in operation: {_from_rest(plan, findings, findings.from_rest)}"
    return result_dataset(quantities, sentence, warnings + steady.warnings, steady.assumptions)


def _curve_quantities(
    plan: Plan, vibration: ForcedVibration, eccentricity: float, w: np.ndarray, losses: np.ndarray
) -> list[Quantity]:
    """Return the quantities of one curve of the vibration over the speed."""
    phases = vibration.phases(w)
    vibration = replace(vibration, phase_law=phases[0] if phases[1] is None else lambda _: phases)  # computed once
    machine, units, z = plan.steady.machine, plan.steady.machine.units, vibration.displacement(w)[0].T
    along, vibration_torque, orbit = "direction speed", vibration.torque(w)[0], machine.orbit_unit
    on_bodies = np.array([vibration.torque_on(w, [i])[0] for i in range(len(machine.bodies))])
    centre = centre_distance(plan.steady, vibration, eccentricity, w)
    return [
        Quantity("displacement_real", z.real, "displacement at the start of a turn (r: rad)", units.length, along),
        Quantity("displacement_imag", z.imag, "displacement a quarter turn before (r: rad)", units.length, along),
        Quantity("displacement_amplitude", np.abs(z), "amplitude of the carrier (r: rad)", units.length, along),
        Quantity("lag", phase_lags(machine, vibration, w, z), "phase lag behind the unbalance", "rad", along),
        Quantity("amplitude", vibration.amplitude(w)[0], "amplitude of the axis", orbit, "speed"),
        Quantity("minor_axis", vibration.minor_amplitude(w), "semi-minor axis of the orbit", orbit, "speed"),
        Quantity("centre_distance", centre, "distance of the centre of mass", units.length, "speed"),
        Quantity("vibration_torque", vibration_torque, "torque of the vibration", units.torque, "speed"),
        Quantity("required_torque", vibration_torque + losses, "torque required", units.torque, "speed"),
        Quantity("torque_on_body", on_bodies, "torque of the vibration on a body", units.torque, "body speed"),
    ]


def _curve(values: Sequence[Quantity], k: int, pieces: list[Piece]) -> ResponseCurve:
    """Return the values of the k-th curve in which its maxima are searched."""
    stable = [p.stable for p in pieces if p.branch == k and not p.overlapping]
    amplitude, torque = (next(q.value for q in values if q.name == name) for name in ("amplitude", "vibration_torque"))
    return ResponseCurve(amplitude, torque, np.any(stable, axis=0) if stable else np.full(len(amplitude), not pieces))


def _configuration_quantities(quantities_by_curve: list[list[Quantity]], pieces: list[Piece]) -> list[Quantity]:
    """Return the quantities over configurations, each in its range of speeds."""
    stable, overlapping = (np.array([getattr(p, name) for p in pieces], np.int8) for name in ("stable", "overlapping"))
    names, along = np.array([p.label for p in pieces], str), "configuration"
    quantities = [
        Quantity("configuration_name", names, "steady phase configuration", "", along, coordinate=True),
        Quantity("stable", stable, "stable with the rotor held at the speed", "", f"{along} speed"),
        Quantity("overlapping", overlapping, "bodies of a track overlap", "", along),
    ]
    for k, q in enumerate(quantities_by_curve[0]):
        values = np.array([np.where(p.inside, quantities_by_curve[p.branch][k].value, np.nan) for p in pieces])
        quantities.append(replace(q, value=values, dimensions=f"{along} {q.dimensions}"))
    return quantities


def _maximum_quantities(plan: Plan, maxima: Maxima) -> list[Quantity]:
    """Return the largest amplitudes and torques, and the vibration in operation."""
    units, orbit, at_free = plan.steady.machine.units, plan.steady.machine.orbit_unit, maxima.at_free
    largest, hardest, peaks = maxima.largest, maxima.hardest, maxima.amplitudes
    there = {"configuration": ("configuration there", ""), "stable": ("whether it is stable there", "")}
    amplitude = {"speed": ("speed of a largest amplitude", units.speed), "amplitude": ("largest amplitude", orbit)} | there
    torque = {"speed": ("speed of a largest torque", units.speed), "torque": ("largest torque", units.torque)} | there
    columns: dict[str, Any] = {"speed": [m.speed for m in peaks], "amplitude": [m.value for m in peaks]}
    columns |= {"configuration": np.array([m.label for m in peaks], str)} if plan.steady.branches else {}
    peak_speed = largest.speed if largest is not None and largest.value != 0 else None
    hardest_speed = hardest.speed if hardest is not None and hardest.value > 0 else None
    operation, throw = max((m.value for m in at_free), default=None), None if maxima.throw is None else maxima.throw.numbers
    labels = [m.label for m in at_free if m.label]
    return [
        Quantity("peak_amplitude", largest and largest.value, "largest amplitude of the axis", orbit, headline=True),
        Quantity("peak_speed", peak_speed, "speed of the largest amplitude", units.speed),
        *table("peaks", [_entry("amplitude", m) for m in peaks], "largest amplitudes", amplitude),
        *(Quantity(f"peak_{part}", values, *amplitude[part], "peak") for part, values in columns.items()),
        Quantity("peak_torque", hardest and hardest.value, "largest torque of the vibration", units.torque, headline=True),
        Quantity("peak_torque_speed", hardest_speed, "speed of the largest torque", units.speed),
        *table("torque_peaks", [_entry("torque", m) for m in maxima.torques], "largest torques of the vibration", torque),
        Quantity("amplitude_at_free_speed", operation, "amplitude at the speed reached without vibration", orbit),
        Quantity("configurations_at_free_speed", labels, "stable configurations at that speed"),
        Quantity("throw_at_free_speed", throw, "throw of the carrier at that speed", parts=NUMBERS),
    ]


def _operation_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the vibration at the stable operating points."""
    units, orbit = plan.steady.machine.units, plan.steady.machine.orbit_unit
    parts = {
        "speed": ("speed in operation", units.speed),
        "configuration": ("configuration there", ""),
        "amplitude": ("amplitude of the axis there", orbit),
        "reached_from_rest": FROM_REST_WORDS,
    } | NUMBERS
    rows = [
        {"speed": o.speed, "configuration": o.label, "amplitude": o.amplitude, "reached_from_rest": answer}
        | ({} if o.throw is None else o.throw.numbers)
        for o, answer in zip(findings.operation, findings.answers(plan.machine.rotor.name), strict=True)
    ]
    fastest = max(findings.operation, key=lambda o: abs(o.speed), default=None)
    throw = None if fastest is None else fastest.throw
    throw_numbers = ("stroke", "machine_number")
    return [
        *from_rest_quantities(findings.from_rest, units),
        *table("operation", rows, "stable steady speeds at which the torques balance, with the vibration there", parts),
        Quantity("operating_speed", fastest and fastest.speed, "fastest of these speeds", units.speed, headline=True),
        Quantity("operating_amplitude", fastest and fastest.amplitude, "amplitude of the axis there", orbit, headline=True),
        *(
            Quantity(n, throw.numbers[n], f"{NUMBERS[n][0]}, there", NUMBERS[n][1], headline=True)
            for n in throw_numbers
            if throw
        ),
    ]


def _from_rest(plan: Plan, findings: Findings, end: FromRest) -> str:
    """Return which of the stable operating points is reached from rest."""
    unit = f" {plan.machine.units.speed}".rstrip()
    labels = [f"{o.speed:.5g}{unit}" + (f", {o.label}" if o.label else "") for o in findings.operation]
    return end.sentence(findings.answers(plan.machine.rotor.name), labels)


def _entry(name: str, m: Maximum) -> dict[str, Any]:
    more = {"configuration": m.label, "stable": m.stable} if m.label else {}
    return {"speed": m.speed, name: m.value, **more}


def _sentence(is_excited: bool, critical: list[float], free: float | None, labels: str) -> str:
    if not is_excited:
        return "nothing excites the carrier: the unbalances are zero or cancel"
    count = len(critical)
    sentence = f"{count or 'no'} critical speed{'' if count == 1 else 's'} in the range"
    if free and critical:
        below = sum(c < abs(free) for c in critical)
        relation = "above" if below == count else "below" if not below else "between"
        sentence += f"; the drive runs {relation} {'it' if count == 1 else 'them'}"
    return f"{sentence}; bodies stable there: {labels}" if labels and free else sentence


_MOST = 6  # maxima named one by one


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a response."""
    s, lines = result.wucht.summary, ReportLines(result)
    speed, length = formats(result, result.amplitude.attrs["units"])
    steady = " in stable steady phases" if s["bodies"] == "steady" else ""
    lines.add("range", " to ".join(map(speed, s["range"])))
    lines.add("critical", ", ".join(map(speed, s["critical_speeds"])) or "none")
    if s["peak_speed"] is not None:
        most = "infinite" if s["peak_amplitude"] is None else "{peak_amplitude}"
        lines.add("amplitude", f"{most} at most, at {{peak_speed}}{steady}")
    elif not steady:
        return lines.report(s["sentence"])
    else:
        never = "there are no stable steady phases"
        lines.add("amplitude", never if s["peak_amplitude"] is None else f"none{steady}")
    further_peaks = [m for m in _stable(s["peaks"]) if m["speed"] != s["peak_speed"]]
    if further_peaks:
        amplitudes = ["infinite" if m["amplitude"] is None else length(m["amplitude"]) for m in further_peaks[:_MOST]]
        listing = ", ".join(f"{size} at {speed(m['speed'])}" for size, m in zip(amplitudes, further_peaks, strict=False))
        lines.add("also", f"{listing} and {len(further_peaks) - _MOST} more" if len(further_peaks) > _MOST else listing)
    _add_operation(lines, s)
    if s["peak_torque_speed"] is not None:
        at = [m for m in _stable(s["torque_peaks"])[:_MOST] if m["speed"] != s["peak_torque_speed"]]
        unit = "" if result.wucht.dimensionless else " N m"
        also = "".join(f", also {m['torque']:.4g}{unit} at {speed(m['speed'])}" for m in at)
        lines.add("torque", f"of the vibration: at most {s['peak_torque']:.4g}{unit} at {{peak_torque_speed}}{also}")
    lines.add("self-centred", "from {self_centring_speed} on: the centre of mass moves inside the orbit of the axis")
    return lines.report(s["sentence"])


def _add_operation(lines: ReportLines, s: dict[str, Any]) -> None:
    """Add the vibration at each operating point; at the speed without vibration where no torque drives the machine."""
    for point in s["operation"][:_MOST]:
        label = f", {point['configuration']}" if point["configuration"] else ""
        label += "; reached from rest" if point["reached_from_rest"] else ""
        lines.add("in operation", "{amplitude} at {speed}{label}", point, "operation", label=label)
        if point.get("stroke") is not None:
            _add_throw(lines, point, "operation")
    if not s["operation"]:
        lines.add("in operation", "{amplitude_at_free_speed} at {free_speed}")
        if (throw := s["throw_at_free_speed"]) is not None:
            _add_throw(lines, throw, "throw_at_free_speed")


def _add_throw(lines: ReportLines, throw: dict[str, Any], name: str) -> None:
    weight = f"{throw['acceleration']:.4g} m/s\u00b2, machine number {throw['machine_number']:.3g}"
    lines.add("", f"stroke {{stroke}} peak to peak, {weight}", throw, name)


def _stable(maxima: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the maxima at which steady phases of balancing bodies, if any, are stable."""
    return [m for m in maxima if m.get("stable", True)]
