"""Findings -> the Dataset of a prediction."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.numerics.harmonics import even_angles
from wucht.results.conventions import Variable, answered, assuming, variable
from wucht.studies.cam_prediction.prepare import Plan
from wucht.studies.cam_prediction.run import Findings, Turning
from wucht.studies.cam_prediction.summary_of_prediction import summary, verdict, warnings

if TYPE_CHECKING:
    import xarray as xr

CAMS = ["original", "corrected"]
NAMES = ("position", "velocity", "acceleration", "jerk")
_FEWEST, _MOST = 15, 100  # orders that are given
_SIMULATED = 36  # times of a turn at which the simulated speed is given


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a prediction.

    Coordinates: tau, cam_angle (N), cam (original, corrected), order (K, from 1), cut. Variables: speed, drive_torque,
    drive_power (cam, tau); power_at_constant_speed (tau); output_acceleration (cam, order): amplitudes; position, velocity,
    acceleration, jerk (cam_angle): the corrected cam's law; cut_residual (cut); simulated_deviation, simulated_residual (cam),
    simulated_acceleration (cam, order), simulated_speed (cam, simulated_tau) of the last turn, where it is simulated.

    With an elastic output: lever, swept_speed (M), excited, resonance; residual_deviation, residual_acceleration (lever,
    swept_speed); excited_deviation, excited_acceleration, excited_peak (excited); resonance_order, resonance_speed. With an
    elastic shaft: twisted; twist_residual, twist_torque, twist_angle.
    """
    import xarray as xr_

    f, both, unit = findings, (findings.original, findings.corrected), plan.motion.unit
    count = min(max(3 * plan.count, _FEWEST), _MOST)
    by_angle = [unit, f"{unit}/rad", f"{unit}/rad^2", f"{unit}/rad^3"]
    called = ["law of the corrected cam", *(f"{name} by the cam angle" for name in NAMES[1:])]
    speed = np.array([one.shaft.speed(f.tau) for one in both])
    torque = np.array([one.drive for one in both])
    data: dict[str, Variable] = {
        "speed": variable("cam tau", speed, "speed of the shaft", "rad/s"),
        "drive_torque": variable("cam tau", torque, "torque of the drive", "N m"),
        "drive_power": variable("cam tau", torque * speed, "power of the drive", "W"),
        "power_at_constant_speed": variable("tau", f.constant, "power at constant speed", "W"),
        "output_acceleration": variable(
            "cam order", [_amplitudes(one, count) for one in both], "acceleration of the output, amplitude", f"{unit}/s^2"
        ),
        **{n: variable("cam_angle", d, c, u) for n, d, c, u in zip(NAMES, f.cam, called, by_angle, strict=True)},
        "cut_residual": variable("cut", f.cuts, "largest order above N over order 1"),
        **_simulated(plan, f, count),
        **_elastic(plan, f),
    }
    coordinates = {
        "tau": variable("tau", f.tau, "time of a turn as an angle", "rad"),
        "cam_angle": variable("cam_angle", f.tau, "cam angle", "rad"),
        "cam": variable("cam", CAMS, "cam"),
        "order": variable("order", np.arange(1, count + 1), "order"),
        "cut": variable("cut", np.arange(1, len(f.cuts) + 1), "number of the cam"),
    }
    answer = {"sentence": "", "verdict": "", **summary(plan, f)}
    answer["verdict"], answer["sentence"] = verdict(plan, answer)
    made = answered(xr_.Dataset(dict(data), coords=coordinates), answer, answer["sentence"], warnings(plan, f, answer))
    parts = "rigid parts" if plan.output is None and plan.twisting is None else "elastic parts where stiffnesses are given"
    turned = "the camshaft held at its drive's speed" if plan.enforced else "the camshaft as inertia and drive move it"
    return assuming(made, [parts, turned])


def _amplitudes(one: Turning, count: int) -> np.ndarray:
    return one.acceleration.amplitudes[:count]


def _simulated(plan: Plan, f: Findings, count: int) -> dict[str, Variable]:
    if not f.confirmed:
        return {}
    amplitudes = np.full((2, count), np.nan)
    for row, one, turning in zip(amplitudes, f.confirmed, (f.original, f.corrected), strict=True):
        found = turning.shaft.mean**2 * one.acceleration.amplitudes[:count]
        row[: len(found)] = found
    residual = [a[plan.count :].max(initial=0.0) / a[0] for a in amplitudes]
    what = "acceleration of the output in the last turn simulated, amplitude"
    tau = even_angles(_SIMULATED)
    speeds = [one.speed(tau) if not one.failure else np.full(_SIMULATED, np.nan) for one in f.confirmed]
    return {
        "simulated_tau": variable("simulated_tau", tau, "time of the last turn simulated as an angle", "rad"),
        "simulated_speed": variable("cam simulated_tau", speeds, "speed of the shaft in the last turn simulated", "rad/s"),
        "simulated_deviation": variable("cam", [c.deviation for c in f.confirmed], "difference of speed over the mean speed"),
        "simulated_residual": variable("cam", residual, "largest order above N over order 1, simulated"),
        "simulated_acceleration": variable("cam order", amplitudes, what, f"{plan.motion.unit}/s^2"),
    }


def _elastic(plan: Plan, f: Findings) -> dict[str, Variable]:
    data: dict[str, Variable] = {}
    unit = plan.motion.unit
    if (v := f.vibrations) is not None:
        swept = v.over_speed
        table: dict[str, list[Any]] = {
            key: [asdict(e)[key] for e in v.excited] for key in ("deviation", "acceleration", "peak")
        }
        at = swept[1]  # of the corrected cam
        data |= {
            "lever": variable("lever", list(v.names), "cam"),
            "swept_speed": variable("swept_speed", swept[0].speeds, "mean speed", "rad/s"),
            "residual_deviation": variable("lever swept_speed", [s.deviation for s in swept], "deviation in the dwell", unit),
            "residual_acceleration": variable(
                "lever swept_speed", [s.acceleration for s in swept], "acceleration in the dwell", f"{unit}/s^2"
            ),
            "resonance_order": variable("resonance", at.orders, "order that meets the natural frequency"),
            "resonance_speed": variable("resonance", at.resonances, "mean speed at which it does", "rad/s"),
            "excited": variable("excited", [e.name for e in v.excited], "motion of the lever"),
            "excited_deviation": variable("excited", table["deviation"], "deviation in the dwell", unit),
            "excited_acceleration": variable("excited", table["acceleration"], "acceleration in the dwell", f"{unit}/s^2"),
            "excited_peak": variable("excited", table["peak"], "largest acceleration of the output", f"{unit}/s^2"),
        }
    if (t := f.twists) is not None:
        data |= {
            "twisted": variable("twisted", np.array([c.name for c in t.cams], dtype=np.str_), "cam on the shaft that twists"),
            "twist_residual": variable("twisted", [c.above for c in t.cams], "largest order above N over order 1"),
            "twist_torque": variable("twisted", [c.torque for c in t.cams], "largest torque in the shaft", "N m"),
            "twist_angle": variable("twisted", [c.twist for c in t.cams], "largest twist", "rad"),
        }
    return data
