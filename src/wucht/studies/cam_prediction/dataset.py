"""Findings -> the Dataset of a prediction."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.numerics.harmonics import even_angles
from wucht.results.quantities import Quantity, answer
from wucht.studies.cam_prediction.prepare import Plan
from wucht.studies.cam_prediction.run import Findings, Turning
from wucht.studies.cam_prediction.summary_of_prediction import stated, summary, verdict, warnings

if TYPE_CHECKING:
    import xarray as xr

CAMS = ["original", "corrected"]
NAMES = ("position", "velocity", "acceleration", "jerk")
_FEWEST, _MOST = 15, 100  # orders that are given
_SIMULATED = 36  # times of a turn at which the simulated speed is given


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a prediction; of elastic outputs and shafts with what their springs leave."""
    f, both, unit = findings, (findings.original, findings.corrected), plan.motion.unit
    count = min(max(3 * plan.count, _FEWEST), _MOST)
    called = ["law of the corrected cam", *(f"{name} by the cam angle" for name in NAMES[1:])]
    law = zip(NAMES, f.cam, called, (unit, f"{unit}/rad", f"{unit}/rad^2", f"{unit}/rad^3"), strict=True)
    speed = np.array([one.shaft.speed(f.tau) for one in both])
    torque = np.array([one.drive for one in both])
    amplitudes = [_amplitudes(one, count) for one in both]
    numbers = summary(plan, f)
    label, sentence = verdict(plan, numbers)
    quantities = [
        Quantity("tau", f.tau, "time of a turn as an angle", "rad", "tau"),
        Quantity("cam_angle", f.tau, "cam angle", "rad", "cam_angle"),
        Quantity("cam", CAMS, "cam", "", "cam"),
        Quantity("order", np.arange(1, count + 1), "order", "", "order"),
        Quantity("speed", speed, "speed of the shaft", "rad/s", "cam tau"),
        Quantity("drive_torque", torque, "torque of the drive", "N m", "cam tau"),
        Quantity("drive_power", torque * speed, "power of the drive", "W", "cam tau"),
        Quantity("power_at_constant_speed", f.constant, "power at constant speed", "W", "tau"),
        Quantity("output_acceleration", amplitudes, "acceleration of the output, amplitude", f"{unit}/s^2", "cam order"),
        *(Quantity(name, values, what, per, "cam_angle") for name, values, what, per in law),
        Quantity("cut", np.arange(1, len(f.cuts) + 1), "number of the cam", "", "cut"),
        Quantity("cut_residual", f.cuts, "largest order above N over order 1", "", "cut"),
        *_simulated(plan, f, count),
        *_elastic(plan, f),
        Quantity("verdict", label, "verdict"),
        *stated(numbers),
    ]
    parts = "rigid parts" if plan.output is None and plan.twisting is None else "elastic parts where stiffnesses are given"
    turned = "the camshaft held at its drive's speed" if plan.enforced else "the camshaft as inertia and drive move it"
    return answer(quantities, sentence, warnings(plan, f, numbers), [parts, turned])


def _amplitudes(one: Turning, count: int) -> np.ndarray:
    return one.acceleration.amplitudes[:count]


def _simulated(plan: Plan, f: Findings, count: int) -> list[Quantity]:
    if not f.confirmed:
        return []
    amplitudes = np.full((2, count), np.nan)
    for row, one, turning in zip(amplitudes, f.confirmed, (f.original, f.corrected), strict=True):
        found = turning.shaft.mean**2 * one.acceleration.amplitudes[:count]
        row[: len(found)] = found
    residual = [a[plan.count :].max(initial=0.0) / a[0] for a in amplitudes]
    what = "acceleration of the output in the last turn simulated, amplitude"
    tau = even_angles(_SIMULATED)
    speeds = [one.speed(tau) if not one.failure else np.full(_SIMULATED, np.nan) for one in f.confirmed]
    return [
        Quantity("simulated_tau", tau, "time of the last turn simulated as an angle", "rad", "simulated_tau"),
        Quantity("simulated_speed", speeds, "speed of the shaft in the last turn simulated", "rad/s", "cam simulated_tau"),
        Quantity(
            "simulated_deviation", [c.deviation for c in f.confirmed], "difference of speed over the mean speed", "", "cam"
        ),
        Quantity("simulated_residual", residual, "largest order above N over order 1, simulated", "", "cam"),
        Quantity("simulated_acceleration", amplitudes, what, f"{plan.motion.unit}/s^2", "cam order"),
    ]


def _elastic(plan: Plan, f: Findings) -> list[Quantity]:
    quantities = list[Quantity]()
    unit = plan.motion.unit
    if (v := f.vibrations) is not None:
        swept = v.over_speed
        table: dict[str, list[Any]] = {
            key: [asdict(e)[key] for e in v.excited] for key in ("deviation", "acceleration", "peak")
        }
        at = swept[1]  # of the corrected cam
        quantities += [
            Quantity("lever", list(v.names), "cam", "", "lever"),
            Quantity("swept_speed", swept[0].speeds, "mean speed", "rad/s", "swept_speed"),
            Quantity("residual_deviation", [s.deviation for s in swept], "deviation in the dwell", unit, "lever swept_speed"),
            Quantity(
                "residual_acceleration",
                [s.acceleration for s in swept],
                "acceleration in the dwell",
                f"{unit}/s^2",
                "lever swept_speed",
            ),
            Quantity("resonance_order", at.orders, "order that meets the natural frequency", "", "resonance"),
            Quantity("resonance_speed", at.resonances, "mean speed at which it does", "rad/s", "resonance"),
            Quantity("excited", [e.name for e in v.excited], "motion of the lever", "", "excited"),
            Quantity("excited_deviation", table["deviation"], "deviation in the dwell", unit, "excited"),
            Quantity("excited_acceleration", table["acceleration"], "acceleration in the dwell", f"{unit}/s^2", "excited"),
            Quantity("excited_peak", table["peak"], "largest acceleration of the output", f"{unit}/s^2", "excited"),
        ]
    if (t := f.twists) is not None:
        quantities += [
            Quantity(
                "twisted", np.array([c.name for c in t.cams], dtype=np.str_), "cam on the shaft that twists", "", "twisted"
            ),
            Quantity("twist_residual", [c.above for c in t.cams], "largest order above N over order 1", "", "twisted"),
            Quantity("twist_torque", [c.torque for c in t.cams], "largest torque in the shaft", "N m", "twisted"),
            Quantity("twist_angle", [c.twist for c in t.cams], "largest twist", "rad", "twisted"),
        ]
    return quantities
