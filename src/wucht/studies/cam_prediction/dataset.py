"""Findings -> the quantities of a prediction, and its lines in a report."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.numerics.fourier_series import even_angles
from wucht.results.formatting import formats, report_lines
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.cam_prediction.computation import Findings, Plan, ShaftPrediction
from wucht.studies.cam_prediction.summary_of_prediction import (
    order_deviation_text,
    prediction_quantities,
    verdict,
    warnings,
)

if TYPE_CHECKING:
    import xarray as xr


CAMS = ["original", "corrected"]
NAMES = ("position", "velocity", "acceleration", "jerk")
_SIMULATED_TIMES = 36  # times of a turn at which the simulated speed is stored


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a prediction; with the residuals of elastic outputs and shafts where there are any."""
    f, predictions, unit = findings, (findings.original_cam, findings.corrected_cam), plan.motion_law.unit
    count = plan.shown_orders
    descriptions = ["law of the corrected cam", *(f"{name} with respect to the cam angle" for name in NAMES[1:])]
    law = zip(NAMES, f.cam, descriptions, (unit, f"{unit}/rad", f"{unit}/rad^2", f"{unit}/rad^3"), strict=True)
    speed = np.array([one.shaft.speed(f.tau) for one in predictions])
    torque = np.array([one.drive for one in predictions])
    amplitudes = [_amplitudes(one, count) for one in predictions]
    summary = prediction_quantities(plan, f)
    s = {quantity.name: quantity.value for quantity in summary}
    label, sentence = verdict(plan, s)
    quantities = [
        Quantity("tau", f.tau, "time of a turn as an angle", "rad", "tau"),
        Quantity("cam_angle", f.tau, "cam angle", "rad", "cam_angle"),
        Quantity("cam", CAMS, "cam", "", "cam"),
        Quantity("order", np.arange(1, count + 1), "order", "", "order"),
        Quantity("speed", speed, "speed of the shaft", "rad/s", "cam tau"),
        Quantity("drive_torque", torque, "torque of the drive", "N m", "cam tau"),
        Quantity("drive_power", torque * speed, "power of the drive", "W", "cam tau"),
        Quantity("power_at_constant_speed", f.constant_speed_power, "power at constant speed", "W", "tau"),
        Quantity("output_acceleration", amplitudes, "acceleration of the output, amplitude", f"{unit}/s^2", "cam order"),
        *(Quantity(name, values, description, per, "cam_angle") for name, values, description, per in law),
        Quantity("cut", np.arange(1, len(f.cuts) + 1), "number of the cam", "", "cut"),
        Quantity("cut_residual", f.cuts, plan.purity.name, "", "cut"),
        *_record_quantities(plan, f),
        *_simulation_quantities(plan, f, count),
        *_output_quantities(plan, f),
        *_shaft_quantities(plan, f),
        Quantity("verdict", label, "verdict"),
        *summary,
    ]
    parts_assumption = (
        "rigid parts" if plan.output is None and plan.twisting is None else "elastic parts where stiffnesses are given"
    )
    shaft_assumption = (
        "the camshaft held at its drive's speed" if plan.is_enforced else "the camshaft as inertia and drive move it"
    )
    return result_dataset(quantities, sentence, warnings(plan, f, s), [parts_assumption, shaft_assumption])


def _amplitudes(one: ShaftPrediction, count: int) -> np.ndarray:
    return one.acceleration.amplitudes[:count]


def _record_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    if plan.record is None:
        return []
    return [Quantity("measured_speed", plan.record.speed(f.tau), "measured speed of the shaft, orders fitted", "rad/s", "tau")]


def _simulation_quantities(plan: Plan, f: Findings, count: int) -> list[Quantity]:
    if not f.confirmations:
        return []
    amplitudes = np.full((2, count), np.nan)
    for row, one, turning in zip(amplitudes, f.confirmations, (f.original_cam, f.corrected_cam), strict=True):
        spectrum = turning.shaft.mean**2 * one.acceleration.amplitudes[:count]
        row[: len(spectrum)] = spectrum
    residual = [math.nan if c.failure else plan.purity.share(c.acceleration) for c in f.confirmations]
    description = "acceleration of the output in the last turn simulated, amplitude"
    tau, deviation = even_angles(_SIMULATED_TIMES), [c.deviation for c in f.confirmations]
    speeds = [one.speed(tau) if not one.failure else np.full(_SIMULATED_TIMES, np.nan) for one in f.confirmations]
    return [
        Quantity("simulated_tau", tau, "time of the last turn simulated as an angle", "rad", "simulated_tau"),
        Quantity("simulated_speed", speeds, "speed of the shaft in the last turn simulated", "rad/s", "cam simulated_tau"),
        Quantity("simulated_deviation", deviation, "difference of speed over the mean speed", "", "cam"),
        Quantity("simulated_residual", residual, f"{plan.purity.name}, simulated", "", "cam"),
        Quantity("simulated_acceleration", amplitudes, description, f"{plan.motion_law.unit}/s^2", "cam order"),
    ]


def _output_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    if (v := f.vibrations) is None:
        return []
    sweeps, excitations, unit, dimensions = v.sweeps, v.excitations, plan.motion_law.unit, "lever swept_speed"
    deviation, acceleration, per = "deviation in the dwell", "acceleration in the dwell", f"{unit}/s^2"
    corrected_sweep = sweeps[1]  # of the corrected cam
    return [
        Quantity("lever", list(v.names), "cam", "", "lever"),
        Quantity("swept_speed", sweeps[0].speeds, "mean speed", "rad/s", "swept_speed"),
        Quantity("residual_deviation", [s.deviation for s in sweeps], deviation, unit, dimensions),
        Quantity("residual_acceleration", [s.acceleration for s in sweeps], acceleration, per, dimensions),
        Quantity("resonance_order", corrected_sweep.orders, "order at resonance with the natural frequency", "", "resonance"),
        Quantity("resonance_speed", corrected_sweep.resonances, "mean speed at that resonance", "rad/s", "resonance"),
        Quantity("excited", [e.name for e in excitations], "motion of the lever", "", "excited"),
        Quantity("excited_deviation", [e.deviation for e in excitations], deviation, unit, "excited"),
        Quantity("excited_acceleration", [e.acceleration for e in excitations], acceleration, per, "excited"),
        Quantity("excited_peak", [e.peak for e in excitations], "largest acceleration of the output", per, "excited"),
    ]


def _shaft_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    if f.twists is None:
        return []
    cams, along = f.twists.cams, "twisted"
    return [
        Quantity("twisted", np.array([c.name for c in cams], dtype=np.str_), "cam on the elastic shaft", "", along),
        Quantity("twist_residual", [c.above for c in cams], plan.purity.name, "", along),
        Quantity("twist_torque", [c.torque for c in cams], "largest torque in the shaft", "N m", along),
        Quantity("twist_angle", [c.twist for c in cams], "largest twist", "rad", along),
    ]


_BEST = 3  # motions of the elastic output that are listed


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a prediction."""
    s, (speed, _) = result.wucht.summary, formats(result)
    above, power, deviation = s["above"], s["power"], order_deviation_text(s)
    most = f"; without a drive there is a corrected cam up to {s['inertia_ratio_limit']:.3g}"
    ratio = f"of the output at most {s['inertia_ratio']:.3g} of the shaft's"
    lines = [("inertia", ratio + ("" if s["driven"] == "enforced" else most))]
    for name, one in (("original", s), ("corrected", s["corrected"])):
        residual = f"{deviation} {_share_text(above[name])} of order {above['reference_order']}"
        lines.append((name, f"{speed(one['mean_speed'])}, fluctuating by {_share_text(one['fluctuation'])}; {residual}"))
    errors = {name: _deviation_text(error, s["unit"]) for name, error in s["position_error"].items()}
    lines.append(("position", f"off the law by at most {errors['corrected']}; with the original cam by {errors['original']}"))
    lines += _record_lines(result)
    constant, drive = power["constant_speed"], power["corrected"]
    demand = (
        f"{_power_text(constant['peak'])} at most, {_power_text(constant['mean_positive'])} on average without "
        "power flowing back"
    )
    lines.append(("even speed", f"would need {demand}"))
    if s["driven"] == "eigenmotion":
        lines.append(("drive", "none: the eigenmotion saves all of this power"))
    elif s["driven"] == "drive":
        saving = s["power_saved"]
        less = f"saved {_power_text(saving['peak'])} and {_power_text(saving['mean_positive'])}"
        lines.append(
            ("drive", f"{_power_text(drive['peak'])} at most, {_power_text(drive['mean_positive'])} on average; {less}")
        )
    if s["cut_residuals"]:
        residuals = ", ".join(_share_text(residual) for residual in s["cut_residuals"])
        lines.append(("instead", f"cutting, measuring and cutting again leaves {residuals}"))
    if (simulation := s["simulation"]) is not None:
        one = simulation["corrected"]
        speed_clause = "it fails" if one["failure"] else f"the speed deviates by {one['deviation']:.1e}"
        residual = "" if one["above"] is None else f"; {deviation} {one['above']:.1e} of order {above['reference_order']}"
        lines.append(("simulated", f"{simulation['turns']} turns with the corrected cam: {speed_clause}{residual}"))
    return report_lines(result, s["sentence"], [*lines, *_spring_lines(s)])


def _record_lines(result: xr.Dataset) -> list[tuple[str, str]]:
    """Return a line on the record of the speed beside the prediction."""
    s, (speed, _) = result.wucht.summary, formats(result)
    if (record := s["record"]) is None:
        return []
    shares = ", ".join(f"the {name} cam {_share_text(max(share, 0.0))}" for name, share in record["explained"].items())
    motion = f"{speed(record['mean_speed'])}, fluctuating by {_share_text(record['fluctuation'])}"
    return [("record", f"{motion}; of this fluctuation the prediction explains with {shares}")]


def _spring_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    lines = []
    if (output := s["output"]) is not None:
        turns = output["natural_frequency"] / (2 * math.pi)
        lines.append(
            ("elastic", f"output at {turns:.4g} Hz, damping ratio {output['damping_ratio']:.3g}; in the dwell at most")
        )
        lines += [
            ("", f"{_deviation_text(e['deviation'], s['unit'])}: {e['name']}") for e in _named_excitations(output["excited"])
        ]
    for one in s["shaft"] or ():
        twist = f"twists by {math.degrees(one['twist']):.3g}°, {one['torque']:.4g} N m"
        share = f"{order_deviation_text(s)} {_share_text(one['above'])} of order {s['above']['reference_order']}"
        lines.append(("shaft", f"{twist}, {share}: {one['name']}"))
    if output is not None and s["shaft"]:
        lines.append(("springs", "of output and shaft: each is computed with the other rigid"))
    return lines


def _named_excitations(excitations: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the motions with the least vibration, and each cam."""
    return [e for i, e in enumerate(excitations) if i < _BEST or e["name"].endswith("cam")]


def _share_text(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-6 or not share else f"{share:.0e}"


def _power_text(power: float) -> str:
    return f"{power / 1e3:.4g} kW" if abs(power) >= 1e3 else f"{power:.4g} W"


def _deviation_text(value: float, unit: str) -> str:
    return f"{math.degrees(value):.3g}°" if unit == "rad" else f"{1e3 * value:.3g} mm"
